//! One pass over the particles: they take from the grid, give to it, or first the one and then the other, bin by bin.

use crate::component::StepError;
use crate::grid::{Grid, Lanes};
use crate::model::Model;
use crate::state::{Bin, State};
use crate::transfer::{Fault, FaultKind, Kernels, Scratch, Sweep, SweepReport, What};
use rayon::prelude::*;
use std::cell::RefCell;

/// Fields that threads share; bins of one colour write to different nodes.
#[derive(Clone, Copy)]
struct Sums {
    momentum: *mut Lanes,
    force: Option<*mut Lanes>,
}
// SAFETY: see `Grid::add`.
unsafe impl Send for Sums {}
// SAFETY: see `Grid::add`.
unsafe impl Sync for Sums {}

/// Carries out a sweep on the particles of all bins. What they give is summed in the fields of the grid, or, where they take in the same
/// sweep, in those of the coming step. The report is that of all bins, in their order, so that it does not depend on the threads.
pub(super) fn pass(grid: &mut Grid, kernels: &Kernels, bins: &[Bin], shared: bool, sweep: &Sweep) -> SweepReport {
    let mut next = std::mem::take(&mut grid.next);
    let with_force = sweep.scatter.is_some_and(|task| task.what == What::MassMomentumForce);
    let sums = match (&sweep.scatter, &sweep.gather) {
        (None, _) => None,
        (Some(_), None) => {
            let [momentum, force] = [&mut grid.momentum, &mut grid.force];
            clear(shared, momentum);
            if with_force {
                clear(shared, force);
            }
            Some(Sums { momentum: momentum.as_mut_ptr(), force: with_force.then_some(force.as_mut_ptr()) })
        }
        (Some(_), Some(_)) => {
            let nodes = grid.momentum.len();
            let [momentum, force] = &mut next;
            momentum.resize(nodes, Lanes::default());
            clear(shared, momentum);
            if with_force {
                force.resize(nodes, Lanes::default());
                clear(shared, force);
            }
            Some(Sums { momentum: momentum.as_mut_ptr(), force: with_force.then_some(force.as_mut_ptr()) })
        }
    };
    let of = |grid: &Grid, b: usize| {
        with_scratch(|scratch| {
            let bin = &bins[b];
            if let Some(task) = &sweep.gather {
                grid.load(b, bin, task.needs_force(), &mut scratch.from);
            }
            if sums.is_some() {
                grid.open(bin, with_force, &mut scratch.to);
            }
            // SAFETY: bins own their rows; tiles cover the cells that the particles of the bin are in until they are sorted again.
            let report = unsafe { kernels.sweep(sweep, bin.start as usize..bin.end as usize, scratch) };
            if let Some(Sums { momentum, force }) = sums {
                // SAFETY: the fields are those of this grid; bins of one colour touch no common node.
                unsafe { grid.add(b, &scratch.to, momentum, force) };
            }
            report
        })
    };
    let mut reports = vec![SweepReport::NOTHING; bins.len()];
    let mut carry_out = |grid: &Grid, some: &[u32]| {
        if shared {
            let found: Vec<(u32, SweepReport)> = some.par_iter().map(|&b| (b, of(grid, b as usize))).collect();
            found.iter().for_each(|(b, report)| reports[*b as usize] = *report);
        } else {
            some.iter().for_each(|&b| reports[b as usize] = of(grid, b as usize));
        }
    };
    for colour in &grid.colours {
        carry_out(grid, colour);
    }
    let mut all = SweepReport::NOTHING;
    reports.iter().for_each(|report| all.join(report));
    grid.next = next;
    all
}

/// Sets all nodes to zero.
fn clear(shared: bool, nodes: &mut [Lanes]) {
    const SOME: usize = 4096;
    if shared {
        nodes.par_chunks_mut(SOME).for_each(|some| some.fill(Lanes::default()));
    } else {
        nodes.fill(Lanes::default());
    }
}

/// Calls `f` with the scratch memory of this thread.
fn with_scratch<R>(f: impl FnOnce(&mut Scratch) -> R) -> R {
    thread_local!(static SCRATCH: RefCell<Scratch> = RefCell::default());
    SCRATCH.with_borrow_mut(f)
}

pub(super) fn error(model: &Model, state: &State, fault: Fault) -> StepError {
    let particle = state.particles.id[fault.row] as usize;
    let position = state.particles.position.row::<3>(fault.row)[..model.dimension].to_vec();
    let time = state.time;
    match fault.kind {
        FaultKind::Inverted(det) => StepError::Inverted { time, particle, position, det },
        FaultKind::NotFinite => StepError::NotFinite { time, particle, position },
        FaultKind::Left(place) => StepError::LeftGrid { time, particle, position: place[..model.dimension].to_vec() },
        FaultKind::WideDomain(length) => StepError::WideDomain { time, particle, position, length },
        FaultKind::NoThickness => StepError::NoThickness { time, particle, position },
    }
}
