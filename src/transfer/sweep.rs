//! A sweep over the particles of a bin, chunk by chunk: all take from the grid, all are updated, all give to it. Within a stage nobody waits
//! for the one before.

use super::chunk::{CHUNK, Chunk, ChunkMemory, store};
use super::gather::{gather, locate, places, share};
use super::scatter::{Field, Source, add, pack, repack};
use super::task::{Plan, Sweep, SweepReport, What};
use super::tidy::{Sorting, tidy};
use super::update::{self, Eight};
use crate::grid::{Frame, Site, Tile};
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
    let chunk = memory.chunk::<W>();
    if let Some(task) = &sweep.gather {
        site.load(task.needs_force(), from);
    }
    if let Some(task) = &sweep.scatter {
        site.open(task.what == What::MassMomentumForce, to);
    }
    if sweep.tidy {
        // SAFETY: the caller's promise.
        unsafe { tidy::<D, W, V>(sweep, &plan, site, &from.frame, chunk, sorting) };
    }
    let (mut report, mut extremes) = (SweepReport::NOTHING, update::Extremes::<V>::none());
    let (mut first, end) = (site.bin.start as usize, site.bin.end as usize);
    while first < end {
        // the next chunk begins where a line of the cache does
        let count = (CHUNK - first % LANES).min(end - first);
        // SAFETY: the caller's promise.
        unsafe {
            report.runs += take::<D, W, V>(sweep, &plan, first, count, from, chunk);
            renew::<D, W, V>(sweep, &plan, first, count, &to.frame, chunk, &mut extremes, &mut report);
            give::<D, W, V>(sweep, &plan, first, count, to, chunk);
        }
        first += count;
    }
    // SAFETY: the caller's promise.
    unsafe { site.add::<V>(to) };
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
    chunk: &mut Chunk<W>,
) -> u64 {
    let Some(task) = &sweep.gather else { return 0 };
    let mut at = 0;
    while at < count {
        // SAFETY: the caller's promise.
        unsafe {
            let (x, _) = places::<D, V>(sweep, first + at, LANES.min(count - at));
            let xi = locate::<D, W, V>(sweep, plan, &x, first + at, at, LANES.min(count - at), &from.frame, chunk);
            for a in 0..D {
                store(&mut chunk.xi[a], at, xi[a]);
            }
        }
        at += LANES;
    }
    let (strain, affine, increment) = (task.strain.is_some(), task.kick.is_some() && task.affine, task.needs_force());
    // SAFETY: the caller's promise.
    unsafe {
        match (strain, affine, increment) {
            (false, false, false) => take_fields::<D, W, V, false, false, false>(sweep, plan, first, count, from, chunk),
            (false, false, true) => take_fields::<D, W, V, false, false, true>(sweep, plan, first, count, from, chunk),
            (false, true, false) => take_fields::<D, W, V, false, true, false>(sweep, plan, first, count, from, chunk),
            (false, true, true) => take_fields::<D, W, V, false, true, true>(sweep, plan, first, count, from, chunk),
            (true, false, false) => take_fields::<D, W, V, true, false, false>(sweep, plan, first, count, from, chunk),
            (true, false, true) => take_fields::<D, W, V, true, false, true>(sweep, plan, first, count, from, chunk),
            (true, true, false) => take_fields::<D, W, V, true, true, false>(sweep, plan, first, count, from, chunk),
            (true, true, true) => take_fields::<D, W, V, true, true, true>(sweep, plan, first, count, from, chunk),
        }
    }
}

/// The same for the fields that are asked for.
///
/// # Safety
/// As [`super::Kernels::sweep`].
#[inline(always)]
unsafe fn take_fields<const D: usize, const W: usize, V: Real, const GRADIENT: bool, const AFFINE: bool, const INCREMENT: bool>(
    sweep: &Sweep,
    plan: &Plan<W>,
    first: usize,
    count: usize,
    from: &Tile,
    chunk: &mut Chunk<W>,
) -> u64 {
    let (mut start, mut cell, mut runs) = (0, 0, 0);
    share::<D, W, V>(chunk, start, from, cell);
    while start < count {
        let end = chunk.end_of_run(start, count);
        if end < count {
            // ahead of time, so that nobody waits for it
            share::<D, W, V>(chunk, end, from, cell + 1);
        }
        while start < end {
            let of_cell = LANES.min(end - start);
            // SAFETY: the caller's promise.
            unsafe { gather::<D, W, V, GRADIENT, AFFINE, INCREMENT>(sweep, plan, first + start, start, of_cell, from, cell, chunk) };
            start += of_cell;
            runs += 1;
        }
        cell += 1;
    }
    runs
}

/// Updates the particles of a chunk, and makes packets of what they give to the grid first.
///
/// # Safety
/// As [`super::Kernels::sweep`].
#[inline(always)]
unsafe fn renew<const D: usize, const W: usize, V: Real>(
    sweep: &Sweep,
    plan: &Plan<W>,
    first: usize,
    count: usize,
    frame: &Frame,
    chunk: &mut Chunk<W>,
    extremes: &mut update::Extremes<V>,
    report: &mut SweepReport,
) {
    let source = if sweep.gather.is_some_and(|gather| !gather.keep) { Source::Chunk } else { Source::Rows };
    let mut at = 0;
    while at < count {
        let (row, lanes) = (first + at, LANES.min(count - at));
        // SAFETY: the caller's promise.
        unsafe {
            let eight = match &sweep.gather {
                Some(task) => update::update::<D, W, V>(sweep, task, plan, row, at, lanes, chunk, extremes, report),
                None => Eight::load(sweep, row, lanes),
            };
            if let Some(task) = &sweep.scatter {
                pack::<D, W, V>(sweep, task, plan, Field::Momentum, source, &eight, row, at, lanes, frame, chunk);
            }
        }
        at += LANES;
    }
}

/// Adds the packets of the particles of a chunk to the tile, and then those of forces, where they have a field of their own.
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
    chunk: &mut Chunk<W>,
) {
    let Some(task) = &sweep.scatter else { return };
    if sweep.model.needs.affine || matches!(task.what, What::Kicked(_)) {
        add::<D, W, V, true>(chunk, count, to, Field::Momentum);
    } else {
        add::<D, W, V, false>(chunk, count, to, Field::Momentum);
    }
    if task.what != What::MassMomentumForce {
        return;
    }
    let mut at = 0;
    while at < count {
        let (row, lanes) = (first + at, LANES.min(count - at));
        // SAFETY: the caller's promise.
        unsafe {
            if sweep.model.needs.affine {
                let eight = Eight::load(sweep, row, lanes);
                pack::<D, W, V>(sweep, task, plan, Field::Force, Source::Rows, &eight, row, at, lanes, &to.frame, chunk);
            } else {
                repack::<W, V>(sweep, task, row, at, lanes, chunk);
            }
        }
        at += LANES;
    }
    add::<D, W, V, true>(chunk, count, to, Field::Force);
}
