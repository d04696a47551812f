//! A sweep over the particles of a bin, chunk by chunk: all take from the grid, all are updated, all give to it. Within a stage nobody waits
//! for the one before.

use super::chunk::{CHUNK, Chunk, ChunkMemory, store_eight};
use super::gather::{Group, gather, locate, positions, share};
use super::scatter::{Field, Source, add, pack, repack};
use super::task::{GatherTask, Plan, Sweep, SweepReport, What};
use super::tidy::{Sorting, tidy};
use super::update::{self, Eight};
use crate::grid::{Site, Tile};
use crate::lanes::{LANES, Real};

/// Tiles and chunks of one thread.
#[derive(Debug, Default)]
pub(crate) struct Scratch {
    /// Nodes that the particles take from.
    pub(crate) from: Tile,
    /// Nodes that they give to.
    pub(crate) to: Tile,
    memory: ChunkMemory,
    sorting: Sorting,
}

/// Carries out a sweep on the particles of a bin.
///
/// # Safety
/// As [`super::Kernels::sweep`].
#[inline(always)]
pub(super) unsafe fn sweep<const D: usize, const W: usize, V: Real>(sweep: &Sweep, site: &Site, scratch: &mut Scratch) -> SweepReport {
    let plan = Plan::<W>::new(sweep);
    let Scratch { from, to, memory, sorting } = scratch;
    let chunk = memory.chunk::<W, V>();
    if let Some(task) = &sweep.gather {
        site.load(task.needs_force(), from);
    }
    if sweep.scatter.is_some() {
        site.open(to);
    }
    if sweep.tidy {
        // SAFETY: the caller's promise.
        unsafe { tidy::<D, W, V::Wide, V::Number>(sweep, &plan, site, &from.frame, &mut chunk.fields, sorting) };
    }
    let (mut report, mut extremes) = (SweepReport::NOTHING, update::Extremes::<V::Wide>::none());
    let (mut first, end) = (site.bin.start as usize, site.bin.end as usize);
    while first < end {
        // the next chunk begins where a line of the cache does
        let count = (CHUNK - first % LANES).min(end - first);
        // SAFETY: the caller's promise.
        unsafe {
            report.runs += take::<D, W, V>(sweep, &plan, first, count, from, chunk);
            renew::<D, W, V>(sweep, &plan, first, count, chunk, &mut extremes, &mut report);
            give::<D, W, V>(sweep, &plan, first, count, to, chunk);
        }
        first += count;
    }
    // SAFETY: the caller's promise.
    unsafe { site.add::<V::Wide>(to) };
    extremes.report(&mut report);
    report
}

/// Takes the fields of the grid to the particles of a chunk. Returns how many runs of particles in one cell it found.
///
/// # Safety
/// As [`super::Kernels::sweep`].
#[inline(always)]
unsafe fn take<const D: usize, const W: usize, V: Real>(
    sweep: &Sweep,
    plan: &Plan<W>,
    first: usize,
    count: usize,
    from: &Tile,
    chunk: &mut Chunk<W, V>,
) -> u64 {
    let Some(task) = &sweep.gather else { return 0 };
    let mut at = 0;
    while at < count {
        // SAFETY: the caller's promise.
        unsafe {
            let eight = LANES.min(count - at);
            let x = positions::<D, V::Wide>(sweep, first + at, eight);
            let local = locate::<D, W, V::Wide, V::Number>(sweep, plan, &x, first + at, at, eight, &from.frame, &mut chunk.fields);
            for a in 0..D {
                store_eight::<V>(&mut chunk.fields.xi[a], at, local.xi[a]);
                if plan.domains {
                    store_eight::<V>(&mut chunk.fields.length[a], at, local.length[a]);
                }
            }
        }
        at += LANES;
    }
    chunk.fields.mark_runs();
    let (strain, affine) = (task.strain.is_some(), task.kick.is_some() && task.affine);
    // SAFETY: the caller's promise.
    unsafe {
        match (strain, affine) {
            (false, false) => take_fields::<D, W, V, false, false>(sweep, plan, task, first, count, from, chunk),
            (false, true) => take_fields::<D, W, V, false, true>(sweep, plan, task, first, count, from, chunk),
            (true, false) => take_fields::<D, W, V, true, false>(sweep, plan, task, first, count, from, chunk),
            (true, true) => take_fields::<D, W, V, true, true>(sweep, plan, task, first, count, from, chunk),
        }
    }
}

/// The same for the fields that are asked for.
///
/// # Safety
/// As [`super::Kernels::sweep`].
#[inline(always)]
unsafe fn take_fields<const D: usize, const W: usize, V: Real, const GRADIENT: bool, const AFFINE: bool>(
    sweep: &Sweep,
    plan: &Plan<W>,
    task: &GatherTask,
    first: usize,
    count: usize,
    from: &Tile,
    chunk: &mut Chunk<W, V>,
) -> u64 {
    // two cells at once gain nothing where the nodes of each are read one by one
    let may_mix = V::MIXES && W > 2 && !task.needs_force();
    // where the cell of particle `at` ends, number `cell` of the chunk, and where the two after it do
    let (mut at, mut ends, mut cell, mut runs) = (0, [0; 3], 0, 0);
    while at < count {
        while at >= ends[0] {
            let start = ends[2];
            ends = [ends[1], start, count];
            if start < count {
                // ahead of time, so that nobody waits for it
                share::<D, W, V>(chunk, start, from, runs);
                ends[2] = chunk.fields.end_of_run(start, count);
                runs += 1;
            }
            cell += 1;
        }
        let end = ends[0];
        let of_first = V::LANES.min(end - at);
        let mut group = Group { at, count: of_first, of_first, cell: cell - 3 };
        // SAFETY: the caller's promise.
        unsafe {
            if may_mix && of_first < V::LANES && end < count && chunk.fields.is_inner(at) && chunk.fields.is_inner(end) {
                group.count = V::LANES.min(ends[1] - at);
                gather::<D, W, V, GRADIENT, AFFINE, true>(sweep, plan, task, first + at, group, from, chunk);
            } else {
                gather::<D, W, V, GRADIENT, AFFINE, false>(sweep, plan, task, first + at, group, from, chunk);
            }
        }
        at += group.count;
    }
    runs as u64
}

/// Updates the particles of a chunk, with the stresses that go with their momenta.
///
/// # Safety
/// As [`super::Kernels::sweep`].
#[inline(always)]
unsafe fn renew<const D: usize, const W: usize, V: Real>(
    sweep: &Sweep,
    plan: &Plan<W>,
    first: usize,
    count: usize,
    chunk: &mut Chunk<W, V>,
    extremes: &mut update::Extremes<V::Wide>,
    report: &mut SweepReport,
) {
    let stressed = sweep.scatter.is_some_and(|task| task.what != What::MassMomentum);
    let mut at = 0;
    while at < count {
        let (row, lanes) = (first + at, LANES.min(count - at));
        // SAFETY: the caller's promise.
        unsafe {
            let eight = match &sweep.gather {
                Some(task) => update::update::<D, W, V, V::Wide>(sweep, task, plan, row, at, lanes, &mut chunk.fields, extremes, report),
                None => Eight::load(sweep, row, lanes),
            };
            if stressed {
                update::stress::<D, W, V, V::Wide>(sweep, plan, &eight, row, at, lanes, &mut chunk.fields);
            }
        }
        at += LANES;
    }
}

/// The particles of a chunk give to the tile; forces apart, where they have a field of their own.
///
/// # Safety
/// As [`super::Kernels::sweep`].
#[inline(always)]
unsafe fn give<const D: usize, const W: usize, V: Real>(
    sweep: &Sweep,
    plan: &Plan<W>,
    first: usize,
    count: usize,
    to: &mut Tile,
    chunk: &mut Chunk<W, V>,
) {
    let Some(task) = &sweep.scatter else { return };
    let (affine, frame) = (sweep.model.needs.affine, to.frame);
    let source = if sweep.gather.is_some_and(|gather| !gather.keep) { Source::Chunk } else { Source::Rows };
    for field in [Field::Momentum, Field::Force] {
        let momentum = field == Field::Momentum;
        if !(momentum || task.what == What::MassMomentumForce) {
            return;
        }
        let parts = if momentum { [true, affine, task.packs_stress(affine)] } else { [false, false, true] };
        let mut at = 0;
        while at < count {
            let (row, lanes) = (first + at, V::LANES.min(count - at));
            // SAFETY: the caller's promise.
            unsafe {
                if momentum || affine {
                    pack::<D, W, V>(sweep, task, plan, parts, source, row, at, lanes, &frame, chunk);
                } else {
                    repack::<W, V>(sweep, task, row, at, lanes, chunk);
                }
            }
            at += V::LANES;
        }
        if momentum {
            chunk.fields.mark_runs();
        }
        if !momentum || affine || matches!(task.what, What::Kicked(_)) {
            add::<D, W, V, true>(chunk, count, to, field);
        } else {
            add::<D, W, V, false>(chunk, count, to, field);
        }
    }
}
