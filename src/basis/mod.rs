//! Shape functions: a family is just the function that fills the per-axis tables of [`Stencils`].
//!
//! All families are tensor products, the serendipity elements up to tied nodes. Along an axis a particle sees `W` nodes from `first` on,
//! with weights, derivatives and, for affine transfers, the affine weights of APIC. Linear is the B-spline of degree 1.

mod axis;
mod bspline;
mod extension;
mod gimp;
mod lagrange;

pub(crate) use axis::{Axis, Family, OFF_EDGE};
pub(crate) use extension::Extension;
pub(crate) use lagrange::{is_tied, serendipity_weight};

/// Second moment of the weights, in squares of cells, below which it is round-off.
pub(crate) const NO_MOMENT: f64 = 1e-9;

/// Particles whose stencils are computed side by side.
pub(crate) const BATCH: usize = 8;

/// One number a particle of a batch.
pub(crate) type Batch = [f64; BATCH];

/// Where the particles of a batch are, by axis.
#[derive(Clone, Copy)]
pub(crate) struct Places<const D: usize> {
    /// Position \[m\]; must lie in the grid.
    pub(crate) position: [Batch; D],
    /// Half the length of the particle domain \[m\]; of use only to families with domains.
    pub(crate) half: [Batch; D],
}

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
    /// The stencils of a batch.
    pub(crate) fn at<const D: usize>(axes: &[Axis], places: &Places<D>, third: Third) -> Self {
        let mut stencils = Self::default();
        stencils.set::<D>(axes, places, third);
        stencils
    }

    /// First node of a particle.
    #[inline(always)]
    pub(crate) fn first(&self, lane: usize) -> [i32; 3] {
        [self.first[0][lane], self.first[1][lane], self.first[2][lane]]
    }

    /// Sets the used slots for a batch.
    #[inline(always)]
    pub(crate) fn set<const D: usize>(&mut self, axes: &[Axis], places: &Places<D>, third: Third) {
        for (number, axis) in axes.iter().enumerate().take(D) {
            let slot = 3 - D + number;
            if matches!(axis.family(), Family::Domains { .. }) {
                self.set_domains(slot, axis, &places.position[number], &places.half[number], third);
                continue;
            }
            let (mut xi, mut cell) = (Batch::default(), [0; BATCH]);
            for l in 0..BATCH {
                (cell[l], xi[l]) = axis.cell(places.position[number][l]);
                self.first[slot][l] = axis.first(cell[l]);
            }
            let class = axis.class(cell[0]);
            // neighbours in memory are neighbours in space: most often all see the same polynomials
            if cell.iter().all(|c| *c == cell[0] || axis.class(*c) == class) {
                self.set_lanes::<BATCH>(slot, axis, class, 0, &xi, third);
            } else {
                for l in 0..BATCH {
                    self.set_lanes::<1>(slot, axis, axis.class(cell[l]), l, &xi, third);
                }
            }
        }
    }

    /// Sets `N` particles from `start` on, whose cells are of one class.
    #[inline(always)]
    fn set_lanes<const N: usize>(&mut self, slot: usize, axis: &Axis, class: usize, start: usize, xi: &Batch, third: Third) {
        let (coefficients, nodes) = axis.piece::<W>(class);
        let (h, inverse_h) = (axis.cell_size(), axis.inverse_cell());
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
        if third == Third::Affine {
            self.divide_by_moment(slot, start, &moment, h);
        }
    }

    /// Sets all particles of a batch from their domains.
    fn set_domains(&mut self, slot: usize, axis: &Axis, position: &Batch, half: &Batch, third: Third) {
        let (h, inverse_h) = (axis.cell_size(), axis.inverse_cell());
        let mut moment = Batch::default();
        for l in 0..BATCH {
            let (s, half) = ((position[l] - axis.origin()) * inverse_h, half[l] * inverse_h);
            let first = gimp::first(s, half);
            // nodes are counted from the one outside the grid
            self.first[slot][l] = first + 1;
            for a in 0..W {
                let r = s - (first + a as i32) as f64;
                let (n, slope) = gimp::weight(r, half);
                self.weight[slot][a][l] = n;
                self.slope[slot][a][l] = slope * inverse_h;
                if third != Third::Nothing {
                    self.third[slot][a][l] = -n * r * h;
                    moment[l] += n * (r * h) * (r * h);
                }
            }
        }
        if third == Third::Affine {
            self.divide_by_moment(slot, 0, &moment, h);
        }
    }

    /// Turns arms into the affine weights of APIC.
    #[inline(always)]
    fn divide_by_moment(&mut self, slot: usize, start: usize, moment: &[f64], h: f64) {
        // On a node the moment vanishes, and the weights tend to the derivatives; for linear functions they always are.
        let vanishes = |m: f64| W == 2 || m < NO_MOMENT * h * h;
        for a in 0..W {
            for (l, &m) in (start..).zip(moment) {
                let (slope, weight) = (self.slope[slot][a][l], self.third[slot][a][l]);
                self.third[slot][a][l] = if vanishes(m) { slope } else { weight / m };
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Partition of unity, its gradient, and the place of the particle from the places of the nodes: every family, everywhere in the grid.
    fn reproduces_linear_functions<const W: usize>(family: Family, half: f64) {
        let axis = Axis::new(-1.0, 0.5, 6, family);
        for step in 0..=997 {
            // domains may stick out of the grid by their half-length
            let x = -1.0 + 3.0 * step as f64 / 997.0;
            let places = Places { position: [[x; BATCH]], half: [[half; BATCH]] };
            let s = Stencils::<W>::at::<1>(std::slice::from_ref(&axis), &places, Third::Arm);
            let first = s.first(0)[2];
            let (low, high) = axis.reach(axis.cell(x).0);
            assert!(first >= low && first + W as i32 - 1 <= high && high < axis.functions(), "{family:?} at {x}");
            let sum = |f: &dyn Fn(usize) -> f64| (0..W).map(f).sum::<f64>();
            let node = |a: usize| axis.node_position(first + a as i32);
            // round-off of a few terms of order 1 over the half-length
            for (name, ours, exact) in [
                ("unity", sum(&|a| s.weight[2][a][0]), 1.0),
                ("gradient of unity", sum(&|a| s.slope[2][a][0]), 0.0),
                ("place", sum(&|a| s.weight[2][a][0] * node(a)), x),
                ("gradient of place", sum(&|a| s.slope[2][a][0] * node(a)), 1.0),
                ("arms", sum(&|a| s.third[2][a][0]), 0.0),
            ] {
                assert!((ours - exact).abs() < 1e-12, "{family:?} at {x}: {name} is {ours}");
            }
        }
    }

    #[test]
    fn every_family_reproduces_linear_functions() {
        reproduces_linear_functions::<2>(Family::OpenSpline(1), 0.0);
        reproduces_linear_functions::<3>(Family::OpenSpline(2), 0.0);
        reproduces_linear_functions::<3>(Family::Elements, 0.0);
        reproduces_linear_functions::<4>(Family::UniformCubic, 0.0);
        for half in [0.01, 0.0625, 0.125, 0.25] {
            reproduces_linear_functions::<3>(Family::Domains { follow: false }, half);
            reproduces_linear_functions::<4>(Family::Domains { follow: true }, half);
        }
        reproduces_linear_functions::<4>(Family::Domains { follow: true }, 0.5);
    }

    #[test]
    fn uniform_cubic_is_that_of_andersen() {
        let axis = Axis::new(0.0, 1.0, 4, Family::UniformCubic);
        let places = Places { position: [[2.25; BATCH]], half: [Batch::default()] };
        let s = Stencils::<4>::at::<1>(&[axis], &places, Third::Nothing);
        for a in 0..4 {
            // eq. 23, of the distance to the nodes 1, 2, 3, 4
            let r = (2.25f64 - (1 + a) as f64).abs();
            let exact = if r > 1.0 { (2.0 - r).powi(3) / 6.0 } else { 2.0 / 3.0 - r * r + 0.5 * r.powi(3) };
            assert!((s.weight[2][a][0] - exact).abs() < 1e-15, "{a}");
        }
    }
}
