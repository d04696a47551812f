//! Transfers between particles and grid, written once for all tensor-product bases and all dimensions.
//!
//! `scatter` is particles to grid (P2G), `gather` is grid to particles (G2P) with the update of the particles. Both work on the
//! particles of one bin in one dense [`Tile`]. Dimension and width of the stencil are constants of the compiled kernel; which kernel
//! runs is chosen once, in [`Kernels::new`], from the scene and from the CPU.
//!
//! Sums over the stencil are carried out axis by axis: what is common to a row of nodes is computed once a row.

mod gather;
mod lanes;
mod rows;
mod scatter;

pub(crate) use gather::{Fault, FaultKind, GatherReport, GatherTask};
pub(crate) use rows::Rows;
pub(crate) use scatter::ScatterTask;

use crate::basis::{BATCH, Spline, Stencils, Third};
use crate::grid::Tile;
use lanes::Portable;
use std::ops::Range;

/// Nodes, in slots, with their weights.
pub(crate) type NodeWeights = Vec<([i32; 3], f64)>;

/// The kernels of a scene.
#[derive(Clone, Copy)]
pub(crate) struct Kernels {
    scatter: unsafe fn(&ScatterTask, Range<usize>, &mut Tile),
    gather: unsafe fn(&GatherTask, Range<usize>, &Tile) -> GatherReport,
    point: fn(&[Spline], [f64; 3], [f64; 3], &mut NodeWeights),
}

impl Kernels {
    /// Kernels for a dimension and degree, with the widest instructions that this CPU has.
    pub(crate) fn new(dimension: usize, degree: usize) -> Self {
        Self::choose(dimension, degree, true)
    }

    /// Kernels that run on any CPU: the slow twin of the others.
    #[cfg(test)]
    pub(crate) fn portable(dimension: usize, degree: usize) -> Self {
        Self::choose(dimension, degree, false)
    }

    fn choose(dimension: usize, degree: usize, wide: bool) -> Self {
        match (dimension, degree) {
            (1, 1) => Self::of::<1, 2>(wide),
            (1, 2) => Self::of::<1, 3>(wide),
            (1, 3) => Self::of::<1, 4>(wide),
            (1, 4) => Self::of::<1, 5>(wide),
            (1, _) => Self::of::<1, 6>(wide),
            (2, 1) => Self::of::<2, 2>(wide),
            (2, 2) => Self::of::<2, 3>(wide),
            (2, 3) => Self::of::<2, 4>(wide),
            (2, 4) => Self::of::<2, 5>(wide),
            (2, _) => Self::of::<2, 6>(wide),
            (_, 1) => Self::of::<3, 2>(wide),
            (_, 2) => Self::of::<3, 3>(wide),
            (_, 3) => Self::of::<3, 4>(wide),
            (_, 4) => Self::of::<3, 5>(wide),
            (_, _) => Self::of::<3, 6>(wide),
        }
    }

    fn of<const D: usize, const W: usize>(wide: bool) -> Self {
        let point = point_weights::<D, W>;
        #[cfg(target_arch = "x86_64")]
        if wide && std::arch::is_x86_feature_detected!("avx2") && std::arch::is_x86_feature_detected!("fma") {
            return Self { scatter: x86::scatter::<D, W>, gather: x86::gather::<D, W>, point };
        }
        // elsewhere the portable kernels are already compiled for what every CPU of the kind has
        let _ = wide;
        Self { scatter: scatter::scatter::<D, W, Portable>, gather: gather::gather::<D, W, Portable>, point }
    }

    /// Adds mass, momentum and forces of the particles in `range` to the tile.
    ///
    /// # Safety
    /// The rows of `range` are this caller's alone, and the tile covers their stencils.
    pub(crate) unsafe fn scatter(&self, task: &ScatterTask, range: Range<usize>, tile: &mut Tile) {
        // SAFETY: the caller's promise; the kernel was chosen for this CPU.
        unsafe { (self.scatter)(task, range, tile) }
    }

    /// Updates the particles in `range` from the tile.
    ///
    /// # Safety
    /// As for `scatter`.
    pub(crate) unsafe fn gather(&self, task: &GatherTask, range: Range<usize>, tile: &Tile) -> GatherReport {
        // SAFETY: the caller's promise; the kernel was chosen for this CPU.
        unsafe { (self.gather)(task, range, tile) }
    }

    /// Nodes and weights through which a force at `position + arm` acts that hangs on a particle at `position`.
    pub(crate) fn point_weights(&self, axes: &[Spline], position: [f64; 3], arm: [f64; 3], weights: &mut NodeWeights) {
        (self.point)(axes, position, arm, weights);
    }
}

#[cfg(target_arch = "x86_64")]
mod x86 {
    //! The same kernels, compiled for CPUs with AVX2 and FMA (all x86-64 since 2013-2015).
    use super::lanes::Avx2;
    use super::*;

    /// # Safety
    /// As [`Kernels::scatter`]; the CPU has AVX2 and FMA.
    #[target_feature(enable = "avx2,fma")]
    pub(super) unsafe fn scatter<const D: usize, const W: usize>(task: &ScatterTask, range: Range<usize>, tile: &mut Tile) {
        // SAFETY: the caller's promise.
        unsafe { scatter::scatter::<D, W, Avx2>(task, range, tile) }
    }

    /// # Safety
    /// As [`Kernels::gather`]; the CPU has AVX2 and FMA.
    #[target_feature(enable = "avx2,fma")]
    pub(super) unsafe fn gather<const D: usize, const W: usize>(task: &GatherTask, range: Range<usize>, tile: &Tile) -> GatherReport {
        // SAFETY: the caller's promise.
        unsafe { gather::gather::<D, W, Avx2>(task, range, tile) }
    }
}

/// Nodes along a slot: `W`, or one in a slot that is not used.
#[inline(always)]
const fn nodes<const D: usize, const W: usize>(slot: usize) -> usize {
    if slot >= 3 - D { W } else { 1 }
}

/// First-order Taylor expansion of the shape functions around the particle: N_i(x_p) + grad N_i(x_p) . arm. The weights sum to 1 and
/// their first moment is that of the point, so force and moment of a surface load are exact, and only nodes with mass are loaded.
fn point_weights<const D: usize, const W: usize>(axes: &[Spline], position: [f64; 3], arm: [f64; 3], weights: &mut NodeWeights) {
    let place: [_; D] = std::array::from_fn(|a| [position[a]; BATCH]);
    let s = Stencils::<W>::at::<D>(axes, &place, Third::Nothing);
    let first = s.first(0);
    weights.clear();
    for i in 0..nodes::<D, W>(0) {
        for j in 0..nodes::<D, W>(1) {
            for k in 0..nodes::<D, W>(2) {
                let at = [i, j, k];
                let n: [f64; 3] = std::array::from_fn(|slot| s.weight[slot][at[slot]][0]);
                let mut weight = n[0] * n[1] * n[2];
                for axis in 0..D {
                    let slot = 3 - D + axis;
                    let others: f64 = (0..3).filter(|&o| o != slot).map(|o| n[o]).product();
                    weight += s.slope[slot][at[slot]][0] * others * arm[axis];
                }
                weights.push((std::array::from_fn(|slot| first[slot] + at[slot] as i32), weight));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_hung_force_has_its_exact_sum_and_moment_anywhere() {
        // sum of weights 1 and first moment the point itself: then force and moment of any load are exact
        let axes: Vec<Spline> = (0..3).map(|a| Spline::new(-1.0, 0.25 + 0.05 * a as f64, 9, 3)).collect();
        let mut weights = Vec::new();
        for (x, arm) in [([0.1, 0.4, -0.3], [0.05, -0.1, 0.08]), ([-0.99, 1.6, -1.0], [-0.02, 0.3, 0.0])] {
            point_weights::<3, 4>(&axes, x, arm, &mut weights);
            let sum: f64 = weights.iter().map(|(_, w)| w).sum();
            assert!((sum - 1.0).abs() < 1e-12);
            for a in 0..3 {
                let moment: f64 = weights.iter().map(|(node, w)| w * axes[a].node_position(node[a])).sum();
                assert!((moment - (x[a] + arm[a])).abs() < 1e-12, "axis {a}");
            }
        }
    }
}
