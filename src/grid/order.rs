//! Keeps particles that are neighbours in space neighbours in memory.

use super::{Block, BlockShape};
use crate::lines::Lines;
use crate::model::Model;
use crate::state::{Bin, Particles};
use rayon::prelude::*;

/// Cells a particle up to which there is a counter for each cell of the box around all particles.
const CELLS_TO_COUNT: usize = 4;

/// Colours of blocks.
pub(crate) const COLOURS: usize = 8;

/// The colour of a block: blocks of one colour are at least two apart.
pub(crate) fn colour(block: [i32; 3]) -> usize {
    block.iter().fold(0, |colour, place| 2 * colour + (place & 1) as usize)
}

/// Sorts the particles by field (see [`super`]), colour and block and, within a block, by cell; particles of one cell keep their order.
/// Returns the bins. A pass takes them colour by colour, so it walks through memory from one end to the other.
pub(crate) fn sort(model: &Model, shape: BlockShape, particles: &mut Particles, shared: bool) -> Vec<Bin> {
    let cells = cells(model, particles, shared);
    let field = |p: usize| model.field(particles.body[p]);
    let order = order(shape, &cells, field);
    let mut bins: Vec<Bin> = Vec::new();
    for (place, &p) in order.iter().enumerate() {
        let (cell, place) = (cells[p as usize], place as u32);
        let (field, block): Block = (field(p as usize), shape.of_cell(cell));
        match bins.last_mut() {
            Some(bin) if (bin.field, bin.block) == (field, block) => {
                bin.end = place + 1;
                for s in 0..3 {
                    (bin.low[s], bin.high[s]) = (bin.low[s].min(cell[s]), bin.high[s].max(cell[s]));
                }
            }
            _ => bins.push(Bin { field, block, low: cell, high: cell, start: place, end: place + 1 }),
        }
    }
    if !order.is_sorted() {
        permute(particles, &order, shared);
    }
    bins
}

/// Cells of the particles, in slots.
fn cells(model: &Model, particles: &Particles, shared: bool) -> Vec<[i32; 3]> {
    let of = |p: usize| {
        let mut cell = [0; 3];
        for (number, axis) in model.axes.iter().enumerate() {
            cell[3 - model.dimension + number] = axis.cell(particles.position.column(number)[p]).0;
        }
        cell
    };
    let all = 0..particles.len();
    if shared { all.into_par_iter().map(of).collect() } else { all.map(of).collect() }
}

/// The particles by field, colour, block and cell: one after the other where the cells may be counted, else by comparison.
fn order(shape: BlockShape, cells: &[[i32; 3]], field: impl Fn(usize) -> u16) -> Vec<u32> {
    let n = cells.len();
    let (mut low, mut high, mut fields) = ([i32::MAX; 3], [i32::MIN; 3], 0);
    for (p, cell) in cells.iter().enumerate() {
        for s in 0..3 {
            (low[s], high[s]) = (low[s].min(cell[s]), high[s].max(cell[s]));
        }
        fields = fields.max(field(p) as usize + 1);
    }
    // pairs of blocks along a slot, one of each parity
    let (low, high) = (shape.of_cell(low).map(|block| block >> 1), shape.of_cell(high).map(|block| block >> 1));
    let extent: [usize; 3] = std::array::from_fn(|s| if n == 0 { 0 } else { (high[s] - low[s]) as usize + 1 });
    let counters = extent.iter().try_fold(shape.nodes * COLOURS * fields, |product, e| product.checked_mul(*e));
    let Some(counters) = counters.filter(|c| *c <= CELLS_TO_COUNT * n + 4096) else {
        let key = |p: u32| {
            let (cell, block) = (cells[p as usize], shape.of_cell(cells[p as usize]));
            (field(p as usize), colour(block), block, shape.cell_in_block(cell), p)
        };
        // the last key is the place in memory, so that equal cells keep their order and the result does not depend on the sort
        let mut order: Vec<u32> = (0..n as u32).collect();
        order.sort_unstable_by_key(|p| key(*p));
        return order;
    };
    let numbers: Vec<u32> = cells
        .iter()
        .enumerate()
        .map(|(p, &cell)| {
            let block = shape.of_cell(cell);
            let first = field(p) as usize * COLOURS + colour(block);
            let block = (0..3).fold(first, |number, s| number * extent[s] + ((block[s] >> 1) - low[s]) as usize);
            (block * shape.nodes + shape.cell_in_block(cell)) as u32
        })
        .collect();
    let mut next = vec![0u32; counters + 1];
    for &number in &numbers {
        next[number as usize + 1] += 1;
    }
    for c in 0..counters {
        next[c + 1] += next[c];
    }
    let mut order = vec![0; n];
    for (p, &number) in numbers.iter().enumerate() {
        order[next[number as usize] as usize] = p as u32;
        next[number as usize] += 1;
    }
    order
}

/// Puts particle `order[p]` at place p.
fn permute(particles: &mut Particles, order: &[u32], shared: bool) {
    fn gather<T: Copy + Send + Sync>(column: &mut Vec<T>, order: &[u32], shared: bool) {
        let at = |&p: &u32| column[p as usize];
        *column = if shared { order.par_iter().map(at).collect() } else { order.iter().map(at).collect() };
    }
    gather(&mut particles.id, order, shared);
    gather(&mut particles.body, order, shared);
    gather(&mut particles.mass, order, shared);
    gather(&mut particles.volume, order, shared);
    // one memory after the other takes the sorted columns: fresh memory would have to be cleared by the system first
    let mut spare = Lines::default();
    for table in particles.tables_mut() {
        table.permute(order, shared, &mut spare);
    }
}
