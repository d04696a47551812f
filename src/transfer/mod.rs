//! Transfers between particles and grid, written once for all tensor-product bases and all dimensions.
//!
//! `scatter` is particles to grid (P2G), `gather` is grid to particles (G2P) with the update of the particles. Both work on the
//! particles of one bin in one dense [`Tile`]. Dimension and width of the stencil are constants of the compiled kernel; which kernel
//! runs is chosen once, in [`Kernels::new`], from the scene and from the CPU.
//!
//! A sweep may begin with `tidy`, which sorts the particles of the bin by cell.
//!
//! In single precision the nodes, the positions and what particles keep are in double precision all the same, as is their update; what is
//! taken from the grid and given to it is worked out with half the bits, from differences of nodes that are taken with all of them.
//!
//! Sums over the stencil are carried out axis by axis: what is common to a row of nodes is computed once a row.

mod chunk;
mod domains;
mod functions;
mod gather;
mod particle;
mod rate;
mod rows;
mod scatter;
mod stencil;
mod sweep;
mod task;
mod tidy;
mod update;

pub(crate) use rows::Rows;
pub(crate) use stencil::StencilRows;
pub(crate) use sweep::Scratch;
pub(crate) use task::{Fault, FaultKind, GatherTask, ScatterTask, Sweep, SweepReport, What};

use crate::basis::{Axis, BATCH, Places};
use crate::grid::Site;
#[cfg(target_arch = "x86_64")]
use crate::lanes::{Avx2, Avx2Single, Avx512, Avx512Single};
use crate::lanes::{Instructions, Plain, PlainSingle};
use crate::scene::Precision;

/// Functions along an axis, at most, for which there are kernels in single precision.
pub(crate) const WIDEST_SINGLE: usize = 4;

/// The kernels of a scene.
#[derive(Clone, Copy)]
pub(crate) struct Kernels {
    sweep: unsafe fn(&Sweep, &Site, &mut Scratch) -> SweepReport,
    stencils: fn(&[Axis], &Places<3>, usize, &mut StencilRows),
}

impl Kernels {
    /// Kernels for a dimension and a width of the stencil, with the widest instructions that this CPU has.
    pub(crate) fn new(dimension: usize, width: usize, precision: Precision) -> Self {
        Self::with(dimension, width, precision, Instructions::of_this_cpu())
    }

    /// Kernels with these instructions, which the CPU must have.
    pub(crate) fn with(dimension: usize, width: usize, precision: Precision, instructions: Instructions) -> Self {
        if precision == Precision::Single {
            assert!(width <= WIDEST_SINGLE, "the check of the scene refuses wider functions in single precision");
            return match (dimension, width) {
                (1, 2) => Self::single::<1, 2>(instructions),
                (1, 3) => Self::single::<1, 3>(instructions),
                (1, _) => Self::single::<1, 4>(instructions),
                (2, 2) => Self::single::<2, 2>(instructions),
                (2, 3) => Self::single::<2, 3>(instructions),
                (2, _) => Self::single::<2, 4>(instructions),
                (_, 2) => Self::single::<3, 2>(instructions),
                (_, 3) => Self::single::<3, 3>(instructions),
                (_, _) => Self::single::<3, 4>(instructions),
            };
        }
        match (dimension, width) {
            (1, 2) => Self::double::<1, 2>(instructions),
            (1, 3) => Self::double::<1, 3>(instructions),
            (1, 4) => Self::double::<1, 4>(instructions),
            (1, 5) => Self::double::<1, 5>(instructions),
            (1, _) => Self::double::<1, 6>(instructions),
            (2, 2) => Self::double::<2, 2>(instructions),
            (2, 3) => Self::double::<2, 3>(instructions),
            (2, 4) => Self::double::<2, 4>(instructions),
            (2, 5) => Self::double::<2, 5>(instructions),
            (2, _) => Self::double::<2, 6>(instructions),
            (_, 2) => Self::double::<3, 2>(instructions),
            (_, 3) => Self::double::<3, 3>(instructions),
            (_, 4) => Self::double::<3, 4>(instructions),
            (_, 5) => Self::double::<3, 5>(instructions),
            (_, _) => Self::double::<3, 6>(instructions),
        }
    }

    fn double<const D: usize, const W: usize>(instructions: Instructions) -> Self {
        let sweep = match instructions {
            // elsewhere AVX-512 gains too little for the time that it takes to compile
            #[cfg(target_arch = "x86_64")]
            Instructions::Avx512 if const { D > 1 && D * W <= 12 } => x86::avx512::<D, W, Avx512>,
            #[cfg(target_arch = "x86_64")]
            Instructions::Avx512 => x86::avx2::<D, W, Avx2>,
            #[cfg(target_arch = "x86_64")]
            Instructions::Avx2 => x86::avx2::<D, W, Avx2>,
            Instructions::Plain => sweep::sweep::<D, W, Plain>,
        };
        Self { sweep, stencils: stencil::tabulate::<D, W> }
    }

    fn single<const D: usize, const W: usize>(instructions: Instructions) -> Self {
        let sweep = match instructions {
            #[cfg(target_arch = "x86_64")]
            Instructions::Avx512 if const { D > 1 } => x86::avx512::<D, W, Avx512Single>,
            #[cfg(target_arch = "x86_64")]
            Instructions::Avx512 => x86::avx2::<D, W, Avx2Single>,
            #[cfg(target_arch = "x86_64")]
            Instructions::Avx2 => x86::avx2::<D, W, Avx2Single>,
            Instructions::Plain => sweep::sweep::<D, W, PlainSingle>,
        };
        Self { sweep, stencils: stencil::tabulate::<D, W> }
    }

    /// Carries out a sweep on the particles of a bin: they take from one tile of `scratch` and give to the other.
    ///
    /// # Safety
    /// The rows of the bin are this caller's alone, tiles cover their stencils, before and after they move, and the rest is as
    /// [`Site::add`] says.
    pub(crate) unsafe fn sweep(&self, task: &Sweep, site: &Site, scratch: &mut Scratch) -> SweepReport {
        // SAFETY: the caller's promise; the kernel was chosen for this CPU.
        unsafe { (self.sweep)(task, site, scratch) }
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
    //! The same kernels, compiled for CPUs with AVX2 and FMA (all x86-64 since 2013-2015) and for those with AVX-512.
    use super::*;
    use crate::lanes::Real;

    /// # Safety
    /// As [`Kernels::sweep`]; the CPU has AVX2 and FMA.
    #[target_feature(enable = "avx2,fma")]
    pub(super) unsafe fn avx2<const D: usize, const W: usize, V: Real>(task: &Sweep, site: &Site, scratch: &mut Scratch) -> SweepReport {
        // SAFETY: the caller's promise.
        unsafe { sweep::sweep::<D, W, V>(task, site, scratch) }
    }

    /// # Safety
    /// As [`Kernels::sweep`]; the CPU has AVX-512 F, DQ and VL.
    #[target_feature(enable = "avx512f,avx512dq,avx512vl,avx2,fma")]
    pub(super) unsafe fn avx512<const D: usize, const W: usize, V: Real>(task: &Sweep, site: &Site, scratch: &mut Scratch) -> SweepReport {
        // SAFETY: the caller's promise.
        unsafe { sweep::sweep::<D, W, V>(task, site, scratch) }
    }
}

/// Of the nodes of a slot the one from which the others are taken as differences, and which gets what they leave of a sum: nowhere in inner
/// cells is its function small.
const fn middle(width: usize) -> usize {
    (width - 1) / 2
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
                Kernels::new(3, 4, Precision::Double).point_weights(&axes, [x, [0.1; 3], arm], &mut rows);
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
