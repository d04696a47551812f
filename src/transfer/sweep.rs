//! A sweep over the particles of a bin, chunk by chunk: all of a stage, then all of the next, so that none waits for the one before it.

use super::chunk::{CHUNK, Chunk, ChunkMemory, store};
use super::functions::cell_of;
use super::gather::{gather, places};
use super::scatter::{Field, Source, add, pack};
use super::task::{Plan, Sweep, SweepReport, What};
use super::{stencil, update};
use crate::basis::{Family, Inner};
use crate::grid::{Frame, Tile};
use crate::lanes::{LANES, Mask, Real};
use std::ops::Range;

/// Tiles and chunks of one thread.
#[derive(Debug, Default)]
pub(crate) struct Scratch {
    /// Nodes that the particles take from.
    pub(crate) from: Tile,
    /// Nodes that they give to.
    pub(crate) to: Tile,
    memory: ChunkMemory,
}

/// Carries out a sweep on the particles in `range`.
///
/// # Safety
/// As [`super::Kernels::sweep`].
#[inline(always)]
pub(super) unsafe fn sweep<const D: usize, const W: usize, V: Real>(
    sweep: &Sweep,
    range: Range<usize>,
    scratch: &mut Scratch,
) -> SweepReport {
    let plan = Plan::new(sweep);
    let Scratch { from, to, memory } = scratch;
    let chunk = memory.chunk::<W>();
    let (mut report, mut extremes) = (SweepReport::NOTHING, update::Extremes::<V>::none());
    let mut first = range.start;
    while first < range.end {
        let count = CHUNK.min(range.end - first);
        // SAFETY: the caller's promise.
        unsafe {
            if let Some(task) = &sweep.gather {
                locate::<D, W, V>(sweep, &plan, first, count, &from.frame, chunk);
                report.runs += take::<D, W, V>(sweep, &plan, first, count, from, chunk);
                let mut at = 0;
                while at < count {
                    update::update::<D, W, V>(sweep, task, &plan, first + at, at, LANES.min(count - at), chunk, &mut extremes, &mut report);
                    at += LANES;
                }
            }
            if sweep.scatter.is_some() {
                locate::<D, W, V>(sweep, &plan, first, count, &to.frame, chunk);
                give::<D, W, V>(sweep, &plan, first, count, to, chunk);
            }
        }
        first += count;
    }
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
    plan: &Plan,
    first: usize,
    count: usize,
    from: &Tile,
    chunk: &mut Chunk<W>,
) -> u64 {
    let Some(task) = &sweep.gather else { return 0 };
    let mut runs = 0;
    let (strain, affine, increment) = (task.strain.is_some(), task.kick.is_some() && task.affine, task.needs_force());
    let mut at = 0;
    while at < count {
        let mut of_cell = 1;
        while of_cell < LANES.min(count - at) && chunk.node[at + of_cell] == chunk.node[at] {
            of_cell += 1;
        }
        // SAFETY: the caller's promise.
        unsafe {
            match (strain, affine, increment) {
                (false, false, false) => gather::<D, W, V, false, false, false>(sweep, plan, first + at, at, of_cell, from, chunk),
                (false, false, true) => gather::<D, W, V, false, false, true>(sweep, plan, first + at, at, of_cell, from, chunk),
                (false, true, false) => gather::<D, W, V, false, true, false>(sweep, plan, first + at, at, of_cell, from, chunk),
                (false, true, true) => gather::<D, W, V, false, true, true>(sweep, plan, first + at, at, of_cell, from, chunk),
                (true, false, false) => gather::<D, W, V, true, false, false>(sweep, plan, first + at, at, of_cell, from, chunk),
                (true, false, true) => gather::<D, W, V, true, false, true>(sweep, plan, first + at, at, of_cell, from, chunk),
                (true, true, false) => gather::<D, W, V, true, true, false>(sweep, plan, first + at, at, of_cell, from, chunk),
                (true, true, true) => gather::<D, W, V, true, true, true>(sweep, plan, first + at, at, of_cell, from, chunk),
            }
        }
        at += of_cell;
        runs += 1;
    }
    runs
}

/// Adds what the particles of a chunk give to the tile.
///
/// # Safety
/// As [`super::Kernels::sweep`].
#[inline(always)]
unsafe fn give<const D: usize, const W: usize, V: Real>(
    sweep: &Sweep,
    plan: &Plan,
    first: usize,
    count: usize,
    to: &mut Tile,
    chunk: &mut Chunk<W>,
) {
    let Some(task) = &sweep.scatter else { return };
    let source = if sweep.gather.is_some_and(|gather| !gather.keep) { Source::Chunk } else { Source::Rows };
    let (fields, scale): (&[Field], f64) = match task.what {
        What::MassMomentum => (&[Field::Momentum], 0.0),
        What::MassMomentumForce => (&[Field::Momentum, Field::Force], 1.0),
        What::Kicked(kick) => (&[Field::Momentum], kick),
    };
    for &field in fields {
        let stressed = field == Field::Force || matches!(task.what, What::Kicked(_));
        let mut at = 0;
        while at < count {
            let (row, lanes) = (first + at, LANES.min(count - at));
            // SAFETY: the caller's promise.
            unsafe {
                if stressed {
                    update::stress::<D, W, V>(sweep, plan, scale, task.relieved, row, at, lanes, chunk);
                }
                pack::<D, W, V>(sweep, task, plan, field, source, row, at, lanes, chunk);
            }
            at += LANES;
        }
        if stressed || sweep.model.needs.affine {
            add::<D, W, V, true>(chunk, count, to, field);
        } else {
            add::<D, W, V, false>(chunk, count, to, field);
        }
    }
}

/// Finds the first node of each particle of a chunk in a tile, and where in its cell it is.
///
/// # Safety
/// As [`super::Kernels::sweep`].
#[inline(always)]
unsafe fn locate<const D: usize, const W: usize, V: Real>(
    sweep: &Sweep,
    plan: &Plan,
    first: usize,
    count: usize,
    frame: &Frame,
    chunk: &mut Chunk<W>,
) {
    let axes = &sweep.model.axes;
    let mut at = 0;
    while at < count {
        // SAFETY: the caller's promise.
        let (x, half) = unsafe { places::<D, V>(sweep, first + at, LANES.min(count - at)) };
        let mut outside = 0;
        let to = &mut chunk.node[at % CHUNK..][..LANES];
        if matches!(axes[0].family(), Family::OpenSpline(_) | Family::UniformCubic) {
            let mut index = V::splat(0.0);
            for a in 0..D {
                let (cell, xi) = cell_of(&axes[a], x[a]);
                store(&mut chunk.xi[a], at, xi);
                // whole numbers far below 2^53
                index = (cell - V::splat(f64::from(frame.low[3 - D + a]))).fma(V::splat(frame.step(3 - D + a) as f64), index);
                match plan.inner[a] {
                    Some(Inner { cells: (first, last), .. }) => outside |= cell.below(V::splat(first)) | V::splat(last).below(cell),
                    None => outside = Mask::MAX,
                }
            }
            // negative where a particle is not in the tile, which never is: then far beyond it
            index.store_indices(to.first_chunk_mut().expect("there is room for eight from any particle on"));
        } else {
            outside = Mask::MAX;
            stencil::first_nodes::<D, W, V>(axes, &x, &half, frame, to);
        }
        chunk.outside[at % CHUNK / LANES] = outside;
        at += LANES;
    }
}
