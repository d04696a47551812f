//! The background grid: only the blocks that hold part of a body exist, so cost and memory follow the bodies, never the domain.
//!
//! Cells are grouped into blocks. The particles of a block of cells are neighbours in memory (a [`Bin`]). Nodes are stored block by block too,
//! so shifted that the particles of a bin touch two blocks of nodes an axis until they are sorted again: a kernel works on one bin at a time
//! in a [`Tile`], a dense copy of the nodes that it touches. Bins of one colour touch no common node, so they are added to the grid side by
//! side; a bin waits only for its neighbours of earlier colours (see [`Turns`]): the sums are the same, bit for bit, for any number of threads.
//!
//! With contact each body has blocks, and so nodes, of its own: a field. Where two fields have the same block, bodies may touch.

mod nodes;
mod order;
mod tied;
mod tile;
mod turns;

pub(crate) use nodes::Nodes;
pub(crate) use order::{colour, sort};
pub(crate) use tied::Tied;
pub(crate) use tile::{Frame, Site, Sums, Tile};
pub(crate) use turns::Turns;

use crate::basis::{Axis, Family};
use crate::model::Model;
use crate::state::Bin;
use std::collections::HashMap;

/// Numbers of a node, in lanes: mass (or nothing), then one an axis.
pub(crate) type Lanes = crate::lanes::Quad;

/// How far, in cells, the particles of a bin may stray from where they were sorted before all are sorted again.
const MARGIN: i32 = 1;
/// The same, as a distance that round-off does not reach.
pub(crate) const LARGEST_DRIFT: f64 = MARGIN as f64 - 1e-6;
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
    pub(crate) momentum: Nodes,
    /// Force on each node, after the balance its acceleration.
    pub(crate) force: Nodes,
    /// The same for the coming step, where particles give to it as they take from this one.
    pub(crate) next: [Nodes; 2],
    /// Held degrees of freedom.
    pub(crate) constraints: Vec<Constraint>,
    /// Pairs of blocks at the same place, of two fields: storage indices of their first nodes.
    pub(crate) encounters: Vec<[u32; 2]>,
    /// Nodes that follow others (serendipity elements, extended B-splines).
    pub(crate) tied: Tied,
    /// What each bin touches, in the order of the bins.
    pub(crate) homes: Vec<Home>,
    /// In which order bins are added.
    pub(crate) turns: Turns,
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
    /// Nodes from the first that particles of a block may touch to that with the number of their first cell.
    lead: i32,
    nodes: usize,
}

/// Particles from which blocks are long along a slot: there are enough of them for many threads then, and tiles of large blocks have fewer nodes
/// in common (measured: 1e5 particles take a twentieth less time, a million a seventh).
const MANY: [usize; 3] = [500_000, 64_000, 64_000];

impl BlockShape {
    /// Two blocks hold a block of cells, a stencil and both margins, so bins that are a block apart touch no common node.
    pub(crate) fn new(dimension: usize, axis: &Axis, particles: usize) -> Self {
        let (first, last) = axis.reach(0);
        // the stencils of elements begin up to a cell before the cell of the particle
        let elements = i32::from(axis.family() == Family::Elements);
        let narrow = last - first + 2 * MARGIN + elements <= 4;
        let shift: [u32; 3] = std::array::from_fn(|slot| match dimension {
            _ if slot < 3 - dimension => 0,
            1 => 4,
            3 if narrow && particles < MANY[slot] => 2,
            _ => 3,
        });
        Self { shift, lead: MARGIN + elements, nodes: 1 << shift.iter().sum::<u32>() }
    }
    /// Block of a cell.
    fn of_cell(&self, cell: [i32; 3]) -> [i32; 3] {
        std::array::from_fn(|s| cell[s] >> self.shift[s])
    }
    /// Number of a cell within its block, the last slot contiguous.
    fn cell_in_block(&self, cell: [i32; 3]) -> usize {
        let local = |s: usize| (cell[s] & (self.size(s) - 1)) as usize;
        (((local(0) << self.shift[1]) + local(1)) << self.shift[2]) + local(2)
    }
    /// The node as counted from the first of a block.
    fn shifted(&self, node: [i32; 3]) -> [i32; 3] {
        std::array::from_fn(|s| if self.shift[s] == 0 { node[s] } else { node[s] + self.lead })
    }
    /// First node of a block.
    fn first(&self, block: [i32; 3]) -> [i32; 3] {
        std::array::from_fn(|s| if self.shift[s] == 0 { block[s] } else { (block[s] << self.shift[s]) - self.lead })
    }
    /// Block of a node.
    fn of(&self, node: [i32; 3]) -> [i32; 3] {
        self.of_cell(self.shifted(node))
    }
    /// Index within its block, the last slot contiguous.
    fn index(&self, node: [i32; 3]) -> usize {
        self.cell_in_block(self.shifted(node))
    }
    fn size(&self, slot: usize) -> i32 {
        1 << self.shift[slot]
    }
}

/// The nodes that the particles of a bin touch, and where the blocks around it are stored.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Home {
    frame: Frame,
    /// First node of the block of the bin.
    origin: [i32; 3],
    /// Where the two blocks an axis are stored: that of the bin, and the next.
    blocks: [u32; 8],
}

impl Grid {
    pub(crate) fn new(model: &Model) -> Self {
        let particles = model.bodies.last().map_or(0, |body| body.particles.end);
        Self { shape: BlockShape::new(model.dimension, &model.axes[0], particles), ..Self::default() }
    }

    pub(crate) fn shape(&self) -> BlockShape {
        self.shape
    }

    /// Memory \[bytes\].
    pub(crate) fn bytes(&self) -> usize {
        self.momentum.len() * 2 * size_of::<Lanes>() + self.homes.len() * size_of::<Home>() + self.blocks.len() * 32
    }

    /// Takes over where the bins are: activates the blocks that their particles may touch until they are sorted again. Nodes stay what they
    /// are where these blocks are active already.
    pub(crate) fn arrange(&mut self, model: &Model, bins: &[Bin]) {
        let mut touched: Vec<Block> = Vec::new();
        for bin in bins {
            let (low, high) = reach(model, bin);
            let (low, high) = wanted(model, low, high);
            self.for_blocks(low, high, |block| touched.push((bin.field, block)));
        }
        touched.sort_unstable();
        touched.dedup();
        let known = touched == self.blocks;
        if !known {
            self.blocks = touched;
            self.table = self.blocks.iter().enumerate().map(|(i, b)| (*b, i as u32)).collect();
            let nodes = self.blocks.len() * self.shape.nodes;
            for lanes in [&mut self.momentum, &mut self.force] {
                lanes.resize(nodes);
                lanes.fill(Lanes::default());
            }
            self.next = Default::default();
        }
        self.homes.clear();
        self.homes.extend(bins.iter().map(|bin| {
            let next = |k: usize| [0, 1, 2].map(|s| bin.block[s] + [k >> 2, k >> 1 & 1, k & 1][s] as i32);
            let blocks = std::array::from_fn(|k| self.table.get(&(bin.field, next(k))).copied().unwrap_or(NONE));
            let (origin, (low, high)) = (self.shape.first(bin.block), reach(model, bin));
            Home { frame: Frame::new(origin[2], low, high), origin, blocks }
        }));
        let blocks: Vec<Block> = bins.iter().map(|bin| (bin.field, bin.block)).collect();
        self.turns = Turns::new(&blocks, |bin| bins[bin].end - bins[bin].start);
        if !known {
            self.meet();
            self.tie(model);
            self.constrain(model);
        }
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
        let first = self.shape.first(block);
        (field, std::array::from_fn(|s| first[s] + local[s] as i32))
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
        let place = self.shape.of(node);
        let next = |s: usize| (place[s] - bin.block[s]) as usize;
        let block = self.homes[bin_index].blocks[4 * next(0) + 2 * next(1) + next(2)];
        block as usize * self.shape.nodes + self.shape.index(node)
    }
}

/// First and last node that the particles of a bin touch until they are sorted again.
fn reach(model: &Model, bin: &Bin) -> ([i32; 3], [i32; 3]) {
    let (mut low, mut high) = ([0; 3], [0; 3]);
    for (number, axis) in model.axes.iter().enumerate() {
        let slot = 3 - model.dimension + number;
        low[slot] = axis.reach((bin.low[slot] - MARGIN).max(0)).0;
        high[slot] = axis.reach((bin.high[slot] + MARGIN).min(axis.cells() - 1)).1;
    }
    (low, high)
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
