//! One pass over the particles: they take from the grid, give to it, or first the one and then the other, bin by bin.

use crate::component::StepError;
use crate::grid::{Grid, Lanes, Site, Sums};
use crate::model::Model;
use crate::state::{Bin, State};
use crate::transfer::{Fault, FaultKind, Kernels, Scratch, Sweep, SweepReport, What};
use rayon::prelude::*;
use std::cell::{Cell, RefCell};

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
            momentum.resize(nodes);
            clear(shared, momentum);
            if with_force {
                force.resize(nodes);
                clear(shared, force);
            }
            Some(Sums { momentum: momentum.as_mut_ptr(), force: with_force.then_some(force.as_mut_ptr()) })
        }
    };
    let of = |grid: &Grid, b: usize| {
        let site = Site { grid, index: b, bin: &bins[b], sums };
        // SAFETY: bins own their rows; tiles cover the cells that the particles of the bin are in until they are sorted again; the sums are
        // fields of this grid, and bins that touch common nodes are not worked on at the same time.
        with_scratch(|scratch| unsafe { kernels.sweep(sweep, &site, scratch) })
    };
    // taken, not lent: while this thread waits for others it may begin another pass
    let mut reports = REPORTS.take();
    reports.clear();
    reports.resize(bins.len(), SweepReport::NOTHING);
    if shared {
        let turns = grid.turns.share();
        let work = |_| {
            let mut found = Vec::new();
            turns.work(|b| found.push((b, of(grid, b as usize))));
            found
        };
        let threads = rayon::current_num_threads().min(bins.len());
        let found: Vec<_> = (0..threads).into_par_iter().with_max_len(1).map(work).collect();
        found.iter().flatten().for_each(|(b, report)| reports[*b as usize] = *report);
    } else {
        grid.turns.order().iter().for_each(|&b| reports[b as usize] = of(grid, b as usize));
    }
    let mut all = SweepReport::NOTHING;
    reports.iter().for_each(|report| all.join(report));
    REPORTS.set(reports);
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

thread_local! {
    /// Memory for a report a bin.
    static REPORTS: Cell<Vec<SweepReport>> = const { Cell::new(Vec::new()) };
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
