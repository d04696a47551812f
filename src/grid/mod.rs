//! The background grid: only the blocks that hold part of a body exist, so cost and memory follow the bodies, never the domain.
//!
//! Cells are grouped into blocks. The particles of a block are neighbours in memory (a [`Bin`]); a kernel works on one bin at a time in a
//! [`Tile`], a small dense copy of the nodes that the bin touches. Bins of one colour touch no common node, so they are added to the
//! grid side by side, and colour after colour: the sums are the same, bit for bit, for any number of threads.

//!
//! With contact each body has blocks, and so nodes, of its own: a field. Where two fields have the same block, bodies may touch.

mod order;
mod tied;

pub(crate) use order::sort;
pub(crate) use tied::Tied;

use crate::basis::{Axis, Family};
use crate::model::Model;
use crate::state::{Bin, Particles};
use std::collections::HashMap;

/// Numbers of a node, in lanes: mass (or nothing), then one an axis.
pub(crate) type Lanes = [f64; 4];

/// How far, in cells, the particles of a bin may stray outside their block before all are sorted again.
const MARGIN: i32 = 1;
/// No such block.
const NONE: u32 = u32::MAX;

/// A block: the field it belongs to, and its place in slots.
pub(crate) type Block = (u16, [i32; 3]);

/// The active part of the grid.
#[derive(Debug, Clone, Default)]
pub(crate) struct Grid {
    shape: BlockShape,
    table: HashMap<Block, u32>,
    blocks: Vec<Block>,
    /// Mass and momentum of each node, after the balance mass and velocity.
    pub(crate) momentum: Vec<Lanes>,
    /// Force on each node, after the balance its acceleration.
    pub(crate) force: Vec<Lanes>,
    /// Held degrees of freedom.
    pub(crate) constraints: Vec<Constraint>,
    /// Pairs of blocks at the same place, of two fields: storage indices of their first nodes.
    pub(crate) encounters: Vec<[u32; 2]>,
    /// Nodes that follow others (serendipity elements, extended B-splines).
    pub(crate) tied: Tied,
    /// What each bin touches, in the order of the bins.
    pub(crate) homes: Vec<Home>,
    /// Bins by colour.
    pub(crate) colours: Vec<Vec<u32>>,
}

/// A node whose velocity along an axis is held.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Constraint {
    pub(crate) node: u32,
    pub(crate) axis: u8,
    pub(crate) boundary: u16,
}

/// Size of a block, by slot: 1 in slots that are not used.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(crate) struct BlockShape {
    /// Logarithm to base 2 of the cells along a slot.
    pub(crate) shift: [u32; 3],
    nodes: usize,
}

impl BlockShape {
    /// Two bins of one colour are a block apart, so a block must be wider than a stencil and both margins.
    pub(crate) fn new(dimension: usize, axis: &Axis) -> Self {
        let (first, last) = axis.reach(0);
        // the stencils of elements begin up to a cell before the cell of the particle
        let lead = i32::from(axis.family() == Family::Elements);
        let log = match dimension {
            1 => 4,
            2 => 3,
            _ if last - first + 2 * MARGIN + lead <= 4 => 2,
            _ => 3,
        };
        let shift: [u32; 3] = std::array::from_fn(|slot| if slot >= 3 - dimension { log } else { 0 });
        Self { shift, nodes: 1 << shift.iter().sum::<u32>() }
    }
    fn of(&self, node: [i32; 3]) -> [i32; 3] {
        std::array::from_fn(|s| node[s] >> self.shift[s])
    }
    fn size(&self, slot: usize) -> i32 {
        1 << self.shift[slot]
    }
    /// Index within its block, the last slot contiguous.
    fn index(&self, node: [i32; 3]) -> usize {
        let local = |s: usize| (node[s] & (self.size(s) - 1)) as usize;
        (((local(0) << self.shift[1]) + local(1)) << self.shift[2]) + local(2)
    }
}

/// The nodes that the particles of a bin touch, and where the blocks around it are stored.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Home {
    low: [i32; 3],
    high: [i32; 3],
    neighbours: [u32; 27],
}

/// What the particles of a bin did since they were sorted.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Stray {
    /// All still in or next to their block.
    No,
    /// One strayed further than the margin: sort again.
    Far,
    /// One left the grid; its place in the arrays.
    Left(usize),
}

impl Grid {
    pub(crate) fn new(model: &Model) -> Self {
        Self { shape: BlockShape::new(model.dimension, &model.axes[0]), ..Self::default() }
    }

    pub(crate) fn shape(&self) -> BlockShape {
        self.shape
    }

    /// Memory \[bytes\].
    pub(crate) fn bytes(&self) -> usize {
        self.momentum.len() * 2 * size_of::<Lanes>() + self.homes.len() * size_of::<Home>() + self.blocks.len() * 32
    }

    /// First and last node that the particles of one bin touch, and whether they are still near their block.
    pub(crate) fn survey(&self, axes: &[Axis], particles: &Particles, bin: &Bin) -> (Stray, [i32; 3], [i32; 3]) {
        let dimension = axes.len();
        let (mut low, mut high) = ([0; 3], [0; 3]);
        let range = bin.start as usize..bin.end as usize;
        for (axis, spline) in axes.iter().enumerate() {
            let slot = 3 - dimension + axis;
            let (mut l, mut h) = (i32::MAX, i32::MIN);
            for (p, &x) in range.clone().zip(&particles.position.column(axis)[range.clone()]) {
                if !spline.holds(x) {
                    return (Stray::Left(p), low, high);
                }
                let cell = spline.cell(x).0;
                l = l.min(cell);
                h = h.max(cell);
            }
            let start = bin.block[slot] << self.shape.shift[slot];
            if l < start - MARGIN || h >= start + self.shape.size(slot) + MARGIN {
                return (Stray::Far, low, high);
            }
            (low[slot], high[slot]) = (spline.reach(l).0, spline.reach(h).1);
        }
        (Stray::No, low, high)
    }

    /// Takes over what [`Grid::survey`] found; activates blocks where a bin touches one that does not exist.
    pub(crate) fn settle(&mut self, model: &Model, bins: &[Bin], extents: &[([i32; 3], [i32; 3])]) {
        let known = self.homes.len() == bins.len();
        for (home, (low, high)) in self.homes.iter_mut().zip(extents) {
            (home.low, home.high) = (*low, *high);
        }
        if !known || self.homes.iter().zip(bins).any(|(home, bin)| self.misses_block(model, home, bin)) {
            self.activate(model, bins, extents);
        }
    }

    fn misses_block(&self, model: &Model, home: &Home, bin: &Bin) -> bool {
        let mut missing = false;
        let (low, high) = wanted(model, home.low, home.high);
        self.for_blocks(low, high, |block| missing |= home.neighbours[relative(block, bin.block)] == NONE);
        missing
    }

    /// Calls `f` for each block with nodes between `low` and `high`.
    fn for_blocks(&self, low: [i32; 3], high: [i32; 3], mut f: impl FnMut([i32; 3])) {
        let (first, last) = (self.shape.of(low), self.shape.of(high));
        for a in first[0]..=last[0] {
            for b in first[1]..=last[1] {
                for c in first[2]..=last[2] {
                    f([a, b, c]);
                }
            }
        }
    }

    /// Builds the table of active blocks from the nodes that bins touch.
    fn activate(&mut self, model: &Model, bins: &[Bin], extents: &[([i32; 3], [i32; 3])]) {
        let mut touched: Vec<Block> = Vec::new();
        for (bin, (low, high)) in bins.iter().zip(extents) {
            let (low, high) = wanted(model, *low, *high);
            self.for_blocks(low, high, |block| touched.push((bin.field, block)));
        }
        touched.sort_unstable();
        touched.dedup();
        self.blocks = touched;
        self.table = self.blocks.iter().enumerate().map(|(i, b)| (*b, i as u32)).collect();
        let nodes = self.blocks.len() * self.shape.nodes;
        self.momentum.clear();
        self.momentum.resize(nodes, Lanes::default());
        self.force.clear();
        self.force.resize(nodes, Lanes::default());
        self.homes = bins
            .iter()
            .zip(extents)
            .map(|(bin, (low, high))| {
                let around = |k: usize| [0, 1, 2].map(|s| bin.block[s] + [k / 9, k / 3 % 3, k % 3][s] as i32 - 1);
                let neighbours = std::array::from_fn(|k| self.table.get(&(bin.field, around(k))).copied().unwrap_or(NONE));
                Home { low: *low, high: *high, neighbours }
            })
            .collect();
        self.colours = vec![Vec::new(); 8];
        for (i, bin) in bins.iter().enumerate() {
            let parity = |s: usize| (bin.block[s] & 1) as usize;
            self.colours[4 * parity(0) + 2 * parity(1) + parity(2)].push(i as u32);
        }
        self.colours.retain(|c| !c.is_empty());
        self.meet();
        self.tie(model);
        self.constrain(model);
    }

    /// Finds the blocks that two fields have.
    fn meet(&mut self) {
        self.encounters.clear();
        let last = self.blocks.last().map_or(0, |block| block.0);
        for (a, (field, place)) in self.blocks.iter().enumerate() {
            for other in field + 1..=last {
                if let Some(b) = self.table.get(&(other, *place)) {
                    self.encounters.push([a as u32, *b].map(|block| block * self.shape.nodes as u32));
                }
            }
        }
    }

    /// The boundary that holds a node along an axis.
    pub(crate) fn holder(&self, node: usize, axis: usize) -> Option<u16> {
        // they are listed in the order of the nodes
        let start = self.constraints.partition_point(|c| (c.node as usize) < node);
        let of_node = self.constraints[start..].iter().take_while(|c| c.node as usize == node);
        of_node.into_iter().find(|c| c.axis as usize == axis).map(|c| c.boundary)
    }

    /// Nodes of a block.
    pub(crate) fn nodes_a_block(&self) -> usize {
        self.shape.nodes
    }

    /// The field and, in slots, the place of a node that is stored at `index`.
    pub(crate) fn place(&self, index: usize) -> (u16, [i32; 3]) {
        let shift = self.shape.shift;
        let (field, block) = self.blocks[index / self.shape.nodes];
        let index = index % self.shape.nodes;
        let local = [index >> (shift[1] + shift[2]), (index >> shift[2]) & ((1 << shift[1]) - 1), index & ((1 << shift[2]) - 1)];
        (field, std::array::from_fn(|s| (block[s] << shift[s]) + local[s] as i32))
    }

    /// Integral of the function of each stored node over that of one in the middle of the grid.
    pub(crate) fn shares(&self, axes: &[Axis], shares: &mut Vec<f64>) {
        shares.clear();
        self.for_nodes(|_, node| {
            // a block may reach beyond the grid
            let of = |(axis, &i): (&Axis, &i32)| if (0..axis.functions()).contains(&i) { axis.share(i) } else { 1.0 };
            shares.push(axes.iter().zip(&node[3 - axes.len()..]).map(of).product());
        });
    }

    /// Lists the held degrees of freedom of the active blocks. A later boundary overrides an earlier one.
    fn constrain(&mut self, model: &Model) {
        self.constraints.clear();
        if model.boundaries.is_empty() {
            return;
        }
        let dimension = model.dimension;
        let mut constraints = std::mem::take(&mut self.constraints);
        self.for_nodes(|index, node| {
            let place = &node[3 - dimension..];
            if place.iter().zip(&model.axes).any(|(&i, axis)| i < 0 || i >= axis.functions()) {
                return;
            }
            for axis in 0..dimension {
                let holder = model.boundaries.iter().rposition(|w| w.holds_axis(axis) && w.holds(&model.axes, place));
                if let Some(boundary) = holder {
                    constraints.push(Constraint { node: index as u32, axis: axis as u8, boundary: boundary as u16 });
                }
            }
        });
        self.constraints = constraints;
    }

    /// Calls `f(storage index, node)` for each node of the active blocks, in slots.
    pub(crate) fn for_nodes(&self, mut f: impl FnMut(usize, [i32; 3])) {
        for index in 0..self.momentum.len() {
            f(index, self.place(index).1);
        }
    }

    /// Storage index of a node of an active block.
    pub(crate) fn node(&self, field: u16, node: [i32; 3]) -> Option<usize> {
        let block = self.table.get(&(field, self.shape.of(node)))?;
        Some(*block as usize * self.shape.nodes + self.shape.index(node))
    }

    /// Storage index of a node that the particles of a bin touch.
    pub(crate) fn node_of_bin(&self, bin_index: usize, bin: &Bin, node: [i32; 3]) -> usize {
        let block = self.homes[bin_index].neighbours[relative(self.shape.of(node), bin.block)];
        block as usize * self.shape.nodes + self.shape.index(node)
    }

    /// Sets the sums to zero.
    pub(crate) fn clear(&mut self, forces_too: bool) {
        self.momentum.fill(Lanes::default());
        if forces_too {
            self.force.fill(Lanes::default());
        }
    }

    /// Calls `f(tile row, node row, length)` for each row of nodes that a bin touches.
    fn for_rows(&self, home: &Home, bin: &Bin, tile: &Frame, mut f: impl FnMut(usize, usize, usize)) {
        let shape = &self.shape;
        self.for_blocks(home.low, home.high, |block| {
            let base = home.neighbours[relative(block, bin.block)] as usize * shape.nodes;
            let start: [i32; 3] = std::array::from_fn(|s| (block[s] << shape.shift[s]).max(home.low[s]));
            let end: [i32; 3] = std::array::from_fn(|s| ((block[s] << shape.shift[s]) + shape.size(s) - 1).min(home.high[s]));
            for i in start[0]..=end[0] {
                for j in start[1]..=end[1] {
                    let first = [i, j, start[2]];
                    f(tile.index(first), base + shape.index(first), (end[2] - start[2] + 1) as usize);
                }
            }
        });
    }

    /// Makes `tile` cover what a bin touches, filled with zeros.
    pub(crate) fn open(&self, bin_index: usize, tile: &mut Tile) {
        let home = &self.homes[bin_index];
        tile.frame = Frame::new(home.low, home.high);
        let nodes = tile.frame.nodes;
        for lanes in [&mut tile.momentum, &mut tile.force] {
            lanes.clear();
            lanes.resize(nodes, Lanes::default());
        }
    }

    /// Copies the nodes that a bin touches into `tile`.
    pub(crate) fn load(&self, bin_index: usize, bin: &Bin, with_force: bool, tile: &mut Tile) {
        self.open(bin_index, tile);
        let home = &self.homes[bin_index];
        let Tile { frame, momentum, force } = tile;
        self.for_rows(home, bin, frame, |row, node, len| {
            momentum[row..row + len].copy_from_slice(&self.momentum[node..node + len]);
            if with_force {
                force[row..row + len].copy_from_slice(&self.force[node..node + len]);
            }
        });
    }

    /// Adds `tile` to the nodes that a bin touches.
    ///
    /// # Safety
    /// `momentum` and `force` are the arrays of this grid, and no other bin that is added at the same time touches a common node: true
    /// for bins of one colour.
    pub(crate) unsafe fn add(&self, bin_index: usize, bin: &Bin, tile: &Tile, momentum: *mut Lanes, force: Option<*mut Lanes>) {
        let home = &self.homes[bin_index];
        // SAFETY: rows lie within active blocks, so within the arrays; the caller keeps others away from them.
        let row_of = |base: *mut Lanes, node: usize, len: usize| unsafe { std::slice::from_raw_parts_mut(base.add(node), len) };
        self.for_rows(home, bin, &tile.frame, |row, node, len| {
            add_rows(row_of(momentum, node, len), &tile.momentum[row..row + len]);
            if let Some(force) = force {
                add_rows(row_of(force, node, len), &tile.force[row..row + len]);
            }
        });
    }
}

/// The nodes whose blocks a bin wants: those its particles touch; quadrature points lie up to a cell beside the particles.
fn wanted(model: &Model, low: [i32; 3], high: [i32; 3]) -> ([i32; 3], [i32; 3]) {
    if !model.needs.quadrature {
        return (low, high);
    }
    let axis = |s: usize| (s + model.dimension).checked_sub(3).map(|a| &model.axes[a]);
    let down = std::array::from_fn(|s| axis(s).map_or(0, |_| (low[s] - 1).max(0)));
    let up = std::array::from_fn(|s| axis(s).map_or(0, |axis| (high[s] + 1).min(axis.functions() - 1)));
    (down, up)
}

fn add_rows(to: &mut [Lanes], from: &[Lanes]) {
    for (a, b) in to.iter_mut().zip(from) {
        for lane in 0..4 {
            a[lane] += b[lane];
        }
    }
}

/// Place of a block among the 27 around a bin's own.
fn relative(block: [i32; 3], own: [i32; 3]) -> usize {
    let r = |s: usize| (block[s] - own[s] + 1) as usize;
    9 * r(0) + 3 * r(1) + r(2)
}

/// The box of nodes that a tile covers.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Frame {
    low: [i32; 3],
    /// Tile nodes from one node to the next along slots 0 and 1; along slot 2 it is 1.
    pub(crate) stride: [usize; 2],
    nodes: usize,
}

impl Frame {
    fn new(low: [i32; 3], top: [i32; 3]) -> Self {
        let extent: [usize; 3] = std::array::from_fn(|s| (top[s] - low[s] + 1) as usize);
        Self { low, stride: [extent[1] * extent[2], extent[2]], nodes: extent.iter().product() }
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
    pub(crate) momentum: Vec<Lanes>,
    pub(crate) force: Vec<Lanes>,
}
