//! Shape functions: a family is just the function that fills the per-axis tables of a [`Stencil`].
//!
//! All families of today are tensor products. Along an axis a particle sees `W` nodes from `first` on, with weights, derivatives
//! and, for affine transfers, the affine weights of APIC. Linear is the B-spline of degree 1.

mod bspline;

pub(crate) use bspline::Spline;

/// Second moment of the weights, in squares of cells, below which it is round-off.
const NO_MOMENT: f64 = 1e-9;

/// What a particle sees of the grid, axis by axis, in slots: dimension `D` uses the last `D` of three slots, so that the axis that is
/// contiguous in memory is always slot 2. A slot that is not used has the one weight 1 and no derivative.
#[derive(Clone, Copy)]
pub(crate) struct Stencil<const W: usize> {
    /// First node of each slot.
    pub(crate) first: [i32; 3],
    /// Weights N.
    pub(crate) weight: [[f64; W]; 3],
    /// Derivatives dN/dx \[1/m\].
    pub(crate) slope: [[f64; W]; 3],
    /// Distances from the particle to the nodes (Greville points) \[m\].
    pub(crate) arm: [[f64; W]; 3],
    /// Weights of the affine matrix of APIC: N arm / sum(N arm^2) \[1/m\] (Jiang et al. 2017, section 5.3).
    pub(crate) affine: [[f64; W]; 3],
}

impl<const W: usize> Stencil<W> {
    /// The stencil of a particle at `position` (one number an axis). The position must lie in the grid.
    #[inline(always)]
    pub(crate) fn at<const D: usize, const AFFINE: bool>(axes: &[Spline], position: [f64; D]) -> Self {
        let mut stencil = Self { first: [0; 3], weight: [[0.0; W]; 3], slope: [[0.0; W]; 3], arm: [[0.0; W]; 3], affine: [[0.0; W]; 3] };
        for slot in 0..3 - D {
            stencil.weight[slot][0] = 1.0;
        }
        for axis in 0..D {
            let slot = 3 - D + axis;
            let spline = &axes[axis];
            let (cell, xi) = spline.cell(position[axis]);
            let coefficients = spline.piece::<W>(cell);
            let (mut n, mut dn) = (coefficients[W - 1], [0.0; W]);
            for power in (0..W - 1).rev() {
                for a in 0..W {
                    dn[a] = dn[a] * xi + n[a];
                    n[a] = n[a] * xi + coefficients[power][a];
                }
            }
            stencil.first[slot] = cell;
            stencil.weight[slot] = n;
            stencil.slope[slot] = dn.map(|v| v * spline.inverse_cell());
            if AFFINE {
                let node = spline.nodes::<W>(cell);
                let arm = node.map(|g| (g - (cell as f64 + xi)) * spline.cell_size());
                stencil.arm[slot] = arm;
                let mut moment = 0.0;
                for a in 0..W {
                    moment += n[a] * arm[a] * arm[a];
                }
                // On a node the moment vanishes, and the weights tend to the derivatives; for linear functions they always are.
                stencil.affine[slot] = if W == 2 || moment < NO_MOMENT * spline.cell_size() * spline.cell_size() {
                    stencil.slope[slot]
                } else {
                    std::array::from_fn(|a| n[a] * arm[a] / moment)
                };
            }
        }
        stencil
    }
}
