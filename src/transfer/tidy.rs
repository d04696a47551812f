//! Sorts the particles of a bin by cell, while they are at hand: most of those that change their cell stay in their bin.

use super::chunk::Fields;
use super::gather::{locate, positions};
use super::rows::Spare;
use super::task::{Plan, Sweep};
use crate::grid::{Frame, Site};
use crate::lanes::{LANES, Number, Wide};

/// Memory of a sort.
#[derive(Debug, Default)]
pub(super) struct Sorting {
    /// First node of each particle in the tile of the bin.
    nodes: Vec<u32>,
    /// Where the next particle of a node goes.
    next: Vec<u32>,
    order: Vec<u32>,
    spare: Spare,
}

/// Sorts the particles of a bin by the first node of their stencils; particles of one cell keep their order.
///
/// # Safety
/// As [`super::Kernels::sweep`].
#[inline(always)]
pub(super) unsafe fn tidy<const D: usize, const W: usize, V: Wide, N: Number>(
    sweep: &Sweep,
    plan: &Plan<W>,
    site: &Site,
    frame: &Frame,
    fields: &mut Fields<N>,
    memory: &mut Sorting,
) {
    let Sorting { nodes, next, order, spare } = memory;
    let (start, end) = (site.bin.start as usize, site.bin.end as usize);
    nodes.clear();
    let mut row = start;
    while row < end {
        let count = LANES.min(end - row);
        // SAFETY: the caller's promise.
        unsafe {
            let x = positions::<D, V>(sweep, row, count);
            locate::<D, W, V, N>(sweep, plan, &x, row, 0, count, frame, fields);
        }
        nodes.extend_from_slice(&fields.node[..count]);
        row += count;
    }
    if nodes.is_sorted() {
        return;
    }
    next.clear();
    next.resize(frame.nodes + 1, 0);
    nodes.iter().for_each(|&node| next[node as usize + 1] += 1);
    for node in 0..frame.nodes {
        next[node + 1] += next[node];
    }
    order.clear();
    order.resize(nodes.len(), 0);
    for (p, &node) in nodes.iter().enumerate() {
        order[next[node as usize] as usize] = p as u32;
        next[node as usize] += 1;
    }
    let kept = sweep.gather.is_none_or(|task| task.keep);
    // SAFETY: the caller's promise.
    unsafe { sweep.rows.permute(sweep.model, start, order, kept, spare) };
}
