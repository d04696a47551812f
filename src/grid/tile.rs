//! The dense copy of the nodes that a bin touches, on which kernels work.

use super::{Grid, Lanes, NONE, Nodes};
use crate::lanes::{LANES, Wide};
use crate::state::Bin;

/// The box of nodes that a tile covers.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Frame {
    pub(crate) low: [i32; 3],
    /// Nodes along each slot.
    extent: [usize; 3],
    /// Tile nodes from one node to the next along slots 0 and 1; along slot 2 it is 1.
    pub(crate) stride: [usize; 2],
    pub(crate) nodes: usize,
}

impl Frame {
    /// The nodes from `low` to `high`, the first and last that the particles of a bin touch. Along slot 2 it begins and ends where a pair of
    /// nodes does, as they are counted from that number `start`.
    pub(super) fn new(start: i32, mut low: [i32; 3], mut high: [i32; 3]) -> Self {
        low[2] -= (low[2] - start) & 1;
        high[2] += (high[2] - start + 1) & 1;
        let extent: [usize; 3] = std::array::from_fn(|s| (high[s] + 1 - low[s]) as usize);
        Self { low, extent, stride: [extent[1] * extent[2], extent[2]], nodes: extent.iter().product() }
    }
    /// Tile nodes from one node to the next along a slot.
    #[inline(always)]
    pub(crate) fn step(&self, slot: usize) -> usize {
        if slot == 2 { 1 } else { self.stride[slot] }
    }
    /// Place of a node in the tile.
    #[inline(always)]
    pub(crate) fn index(&self, node: [i32; 3]) -> usize {
        let r = |s: usize| (node[s] - self.low[s]) as usize;
        r(0) * self.stride[0] + r(1) * self.stride[1] + r(2)
    }
}

/// A small dense copy of the nodes that a bin touches.
#[derive(Debug, Default)]
pub(crate) struct Tile {
    pub(crate) frame: Frame,
    pub(crate) momentum: Nodes,
    pub(crate) force: Nodes,
    /// Whether all of it is zero.
    is_zero: bool,
}

/// Makes room for the nodes of a frame; bins differ in theirs, so there may be room for more.
#[inline(always)]
fn cover(lanes: &mut Nodes, frame: &Frame) {
    if lanes.len() < frame.nodes {
        lanes.resize(frame.nodes);
    }
}

/// A bin and its place in the grid.
#[derive(Clone, Copy)]
pub(crate) struct Site<'a> {
    pub(crate) grid: &'a Grid,
    /// Number of the bin.
    pub(crate) index: usize,
    pub(crate) bin: &'a Bin,
    /// The fields that its particles give to.
    pub(crate) sums: Option<Sums>,
}

/// Fields that threads share; bins that are worked on at the same time write to different nodes.
#[derive(Clone, Copy)]
pub(crate) struct Sums {
    pub(crate) momentum: *mut Lanes,
    pub(crate) force: Option<*mut Lanes>,
}
// SAFETY: see `Site::add`.
unsafe impl Send for Sums {}
// SAFETY: see `Site::add`.
unsafe impl Sync for Sums {}

impl Site<'_> {
    /// Makes `tile` cover what the bin touches, filled with zeros: as [`Site::add`] left it, if it did.
    #[inline(always)]
    pub(crate) fn open(&self, tile: &mut Tile) {
        tile.frame = self.grid.homes[self.index].frame;
        for lanes in [&mut tile.momentum, &mut tile.force] {
            cover(lanes, &tile.frame);
            if !tile.is_zero {
                lanes.fill(Lanes::default());
            }
        }
        tile.is_zero = false;
    }

    /// Copies the nodes that the bin touches into `tile`.
    #[inline(always)]
    pub(crate) fn load(&self, with_force: bool, tile: &mut Tile) {
        let Tile { frame, momentum, force, is_zero } = tile;
        *frame = self.grid.homes[self.index].frame;
        // what particles do not touch may be anything
        *is_zero = false;
        let fields = [(momentum, &self.grid.momentum), (force, &self.grid.force)];
        for (to, from) in fields.into_iter().take(1 + usize::from(with_force)) {
            cover(to, frame);
            self.for_rows(frame, |row, node, length| {
                // two nodes at once, as everywhere an even number of them
                let (to, _) = to[row..row + length].as_chunks_mut::<2>();
                let (from, _) = from[node..node + length].as_chunks::<2>();
                for (to, from) in to.iter_mut().zip(from) {
                    *to = *from;
                }
            });
        }
    }

    /// Adds `tile` to the nodes that the bin touches, and makes it zero while it is at hand.
    ///
    /// # Safety
    /// The sums are arrays of as many nodes as the grid has, and no other bin that is added at the same time touches a common node
    /// (see [`super::Turns`]).
    #[inline(always)]
    pub(crate) unsafe fn add<V: Wide>(&self, tile: &mut Tile) {
        let Some(sums) = self.sums else { return };
        let Tile { frame, momentum, force, is_zero } = tile;
        for (to, from) in [(Some(sums.momentum), momentum), (sums.force, force)] {
            let Some(to) = to else { continue };
            self.for_rows(frame, |row, node, length| {
                // two nodes at once, as everywhere an even number of them
                let (from, _) = from[row..row + length].as_flattened_mut().as_chunks_mut::<LANES>();
                for (pair, from) in from.iter_mut().enumerate() {
                    // SAFETY: rows lie within active blocks, so within the arrays; the caller keeps others away from them.
                    unsafe { V::load_eight(from).add_to(to.add(node + 2 * pair).cast(), 2) };
                    V::splat(0.0).store_lanes(from);
                }
            });
        }
        *is_zero = true;
    }

    /// Calls `f(tile row, node row, length)` for each row of nodes of a block that the tile covers.
    #[inline(always)]
    fn for_rows(&self, frame: &Frame, mut f: impl FnMut(usize, usize, usize)) {
        let (home, shape) = (&self.grid.homes[self.index], &self.grid.shape);
        for (k, &block) in home.blocks.iter().enumerate() {
            if block == NONE {
                continue;
            }
            let half = [k >> 2, k >> 1 & 1, k & 1];
            // nodes of the tile that are in this block, from the first of the tile and from that of the block
            let (mut start, mut end, mut inside) = ([0; 3], [0; 3], [0; 3]);
            for s in 0..3 {
                let corner = home.origin[s] + ((half[s] as i32) << shape.shift[s]) - frame.low[s];
                start[s] = corner.max(0) as usize;
                end[s] = (corner + shape.size(s)).clamp(0, frame.extent[s] as i32) as usize;
                inside[s] = (-corner).max(0) as usize;
            }
            if start[2] >= end[2] {
                continue;
            }
            for (i, row) in (start[0]..end[0]).enumerate() {
                for (j, column) in (start[1]..end[1]).enumerate() {
                    let node = (((inside[0] + i) << shape.shift[1]) + inside[1] + j) << shape.shift[2];
                    let first = row * frame.stride[0] + column * frame.stride[1] + start[2];
                    f(first, block as usize * shape.nodes + node + inside[2], end[2] - start[2]);
                }
            }
        }
    }
}
