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
mod stencil;

pub(crate) use gather::{Fault, FaultKind, GatherReport, GatherTask};
pub(crate) use rows::Rows;
pub(crate) use scatter::ScatterTask;
pub(crate) use stencil::StencilRows;

use crate::basis::{Axis, BATCH, Places};
use crate::grid::Tile;
use lanes::Portable;
use std::ops::Range;

/// The kernels of a scene.
#[derive(Clone, Copy)]
pub(crate) struct Kernels {
    scatter: unsafe fn(&ScatterTask, Range<usize>, &mut Tile),
    gather: unsafe fn(&GatherTask, Range<usize>, &Tile) -> GatherReport,
    stencils: fn(&[Axis], &Places<3>, usize, &mut StencilRows),
}

impl Kernels {
    /// Kernels for a dimension and a width of the stencil, with the widest instructions that this CPU has.
    pub(crate) fn new(dimension: usize, width: usize) -> Self {
        Self::choose(dimension, width, true)
    }

    /// Kernels that run on any CPU: the slow twin of the others.
    #[cfg(test)]
    pub(crate) fn portable(dimension: usize, width: usize) -> Self {
        Self::choose(dimension, width, false)
    }

    fn choose(dimension: usize, width: usize, wide: bool) -> Self {
        match (dimension, width) {
            (1, 2) => Self::of::<1, 2>(wide),
            (1, 3) => Self::of::<1, 3>(wide),
            (1, 4) => Self::of::<1, 4>(wide),
            (1, 5) => Self::of::<1, 5>(wide),
            (1, _) => Self::of::<1, 6>(wide),
            (2, 2) => Self::of::<2, 2>(wide),
            (2, 3) => Self::of::<2, 3>(wide),
            (2, 4) => Self::of::<2, 4>(wide),
            (2, 5) => Self::of::<2, 5>(wide),
            (2, _) => Self::of::<2, 6>(wide),
            (_, 2) => Self::of::<3, 2>(wide),
            (_, 3) => Self::of::<3, 3>(wide),
            (_, 4) => Self::of::<3, 4>(wide),
            (_, 5) => Self::of::<3, 5>(wide),
            (_, _) => Self::of::<3, 6>(wide),
        }
    }

    fn of<const D: usize, const W: usize>(wide: bool) -> Self {
        let stencils = stencil::tabulate::<D, W>;
        #[cfg(target_arch = "x86_64")]
        if wide && std::arch::is_x86_feature_detected!("avx2") && std::arch::is_x86_feature_detected!("fma") {
            return Self { scatter: x86::scatter::<D, W>, gather: x86::gather::<D, W>, stencils };
        }
        // elsewhere the portable kernels are already compiled for what every CPU of the kind has
        let _ = wide;
        Self { scatter: scatter::scatter::<D, W, Portable>, gather: gather::gather::<D, W, Portable>, stencils }
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

    /// Shape functions at the first `count` of some places.
    pub(crate) fn stencils(&self, axes: &[Axis], places: &Places<3>, count: usize, rows: &mut StencilRows) {
        (self.stencils)(axes, places, count, rows);
    }

    /// Nodes and weights through which a force at `position + arm` acts that hangs on a particle at `position` with a domain of
    /// half-lengths `half`: the first-order Taylor expansion of the shape functions around the particle, N_i + grad N_i . arm. The weights
    /// sum to 1 and their first moment is that of the point, so force and moment of a surface load are exact, and only nodes with mass are
    /// loaded.
    pub(crate) fn point_weights(&self, axes: &[Axis], [position, half, arm]: [[f64; 3]; 3], rows: &mut StencilRows) {
        let places = Places { position: position.map(|x| [x; BATCH]), half: half.map(|x| [x; BATCH]) };
        self.stencils(axes, &places, 1, rows);
        for (weight, slope) in rows.weights.iter_mut().zip(&rows.slopes) {
            *weight += (0..3).map(|a| slope[a] * arm[a]).sum::<f64>();
        }
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::basis::Family;

    #[test]
    fn a_hung_force_has_its_exact_sum_and_moment_anywhere() {
        // sum of weights 1 and first moment the point itself: then force and moment of any load are exact
        for family in [Family::OpenSpline(3), Family::UniformCubic, Family::Domains { follow: true }] {
            let axes: Vec<Axis> = (0..3).map(|a| Axis::new(-1.0, 0.25 + 0.05 * a as f64, 9, family)).collect();
            let mut rows = StencilRows::default();
            for (x, arm) in [([0.1, 0.4, -0.3], [0.05, -0.1, 0.08]), ([-0.99, 1.6, -1.0], [-0.02, 0.3, 0.0])] {
                Kernels::new(3, 4).point_weights(&axes, [x, [0.1; 3], arm], &mut rows);
                let sum: f64 = rows.weights.iter().sum();
                assert!((sum - 1.0).abs() < 1e-12);
                for a in 0..3 {
                    let moment: f64 = rows.weights.iter().zip(&rows.nodes).map(|(w, node)| w * axes[a].node_position(node[a])).sum();
                    assert!((moment - (x[a] + arm[a])).abs() < 1e-12, "axis {a}");
                }
            }
        }
    }
}
