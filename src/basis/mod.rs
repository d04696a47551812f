//! Shape functions: a family is just the function that fills the per-axis tables of [`Stencils`].
//!
//! All families of today are tensor products. Along an axis a particle sees `W` nodes from `first` on, with weights, derivatives
//! and, for affine transfers, the affine weights of APIC. Linear is the B-spline of degree 1.

mod bspline;

pub(crate) use bspline::Spline;

/// Second moment of the weights, in squares of cells, below which it is round-off.
const NO_MOMENT: f64 = 1e-9;

/// Particles whose stencils are computed side by side.
pub(crate) const BATCH: usize = 8;

/// One number a particle of a batch.
pub(crate) type Batch = [f64; BATCH];

/// The third weight of a node, beside value and slope.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Third {
    /// None.
    Nothing,
    /// N times the distance from the particle to the node \[m\]: what the affine matrix is multiplied with.
    Arm,
    /// The same over its second moment \[1/m\]: what the affine matrix of APIC is summed with (Jiang et al. 2017, section 5.3).
    Affine,
}

/// What up to eight particles see of the grid, axis by axis, in slots: dimension `D` uses the last `D` of three slots, so that the axis
/// that is contiguous in memory is always slot 2. A slot that is not used has the one weight 1 and no derivative.
#[derive(Clone, Copy)]
pub(crate) struct Stencils<const W: usize> {
    first: [[i32; BATCH]; 3],
    /// Weights N by slot and node.
    pub(crate) weight: [[Batch; W]; 3],
    /// Derivatives dN/dx \[1/m\].
    pub(crate) slope: [[Batch; W]; 3],
    /// See [`Third`].
    pub(crate) third: [[Batch; W]; 3],
}

impl<const W: usize> Default for Stencils<W> {
    /// Stencils whose slots are all unused.
    fn default() -> Self {
        let mut one = [Batch::default(); W];
        one[0] = [1.0; BATCH];
        Self { first: [[0; BATCH]; 3], weight: [one; 3], slope: [[Batch::default(); W]; 3], third: [[Batch::default(); W]; 3] }
    }
}

impl<const W: usize> Stencils<W> {
    /// The stencils of particles at `positions` (by axis, one number a particle). The positions must lie in the grid.
    pub(crate) fn at<const D: usize>(axes: &[Spline], positions: &[Batch; D], third: Third) -> Self {
        let mut stencils = Self::default();
        stencils.set::<D>(axes, positions, third);
        stencils
    }

    /// First node of a particle.
    #[inline(always)]
    pub(crate) fn first(&self, lane: usize) -> [i32; 3] {
        [self.first[0][lane], self.first[1][lane], self.first[2][lane]]
    }

    /// Sets the used slots for particles at `positions`. The positions must lie in the grid.
    #[inline(always)]
    pub(crate) fn set<const D: usize>(&mut self, axes: &[Spline], positions: &[Batch; D], third: Third) {
        for axis in 0..D {
            let slot = 3 - D + axis;
            let spline = &axes[axis];
            let (mut xi, mut class) = (Batch::default(), [0; BATCH]);
            for l in 0..BATCH {
                (self.first[slot][l], xi[l]) = spline.cell(positions[axis][l]);
                class[l] = spline.class(self.first[slot][l]);
            }
            // neighbours in memory are neighbours in space: most often all see the same polynomials
            if class.iter().all(|c| *c == class[0]) {
                self.set_lanes::<BATCH>(slot, spline, class[0], 0, &xi, third);
            } else {
                for l in 0..BATCH {
                    self.set_lanes::<1>(slot, spline, class[l], l, &xi, third);
                }
            }
        }
    }

    /// Sets `N` particles from `start` on, whose cells are of one class.
    #[inline(always)]
    fn set_lanes<const N: usize>(&mut self, slot: usize, spline: &Spline, class: usize, start: usize, xi: &Batch, third: Third) {
        let (coefficients, nodes) = spline.piece::<W>(class);
        let (h, inverse_h) = (spline.cell_size(), spline.inverse_cell());
        let mut moment = [0.0; N];
        for a in 0..W {
            for l in 0..N {
                let x = xi[start + l];
                let (mut n, mut dn) = (coefficients[W - 1][a], 0.0);
                for power in (0..W - 1).rev() {
                    dn = dn * x + n;
                    n = n * x + coefficients[power][a];
                }
                self.weight[slot][a][start + l] = n;
                self.slope[slot][a][start + l] = dn * inverse_h;
                if third != Third::Nothing {
                    let arm = (nodes[a] - x) * h;
                    self.third[slot][a][start + l] = n * arm;
                    moment[l] += n * arm * arm;
                }
            }
        }
        if third != Third::Affine {
            return;
        }
        // On a node the moment vanishes, and the weights tend to the derivatives; for linear functions they always are.
        let vanishes = |m: f64| W == 2 || m < NO_MOMENT * h * h;
        for a in 0..W {
            for l in 0..N {
                let (slope, weight) = (self.slope[slot][a][start + l], self.third[slot][a][start + l]);
                self.third[slot][a][start + l] = if vanishes(moment[l]) { slope } else { weight / moment[l] };
            }
        }
    }
}
