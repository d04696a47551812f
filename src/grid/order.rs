//! Keeps particles that are neighbours in space neighbours in memory.

use super::{Block, BlockShape};
use crate::model::Model;
use crate::state::{Bin, Particles};

/// Sorts the particles by field (see [`super`]) and block and, within a block, by cell; particles of one cell keep their order. Returns the
/// bins.
pub(crate) fn sort(model: &Model, shape: BlockShape, particles: &mut Particles) -> Vec<Bin> {
    let (axes, dimension) = (&model.axes, model.dimension);
    let n = particles.len();
    let mut keyed: Vec<(Block, u32, u32)> = (0..n)
        .map(|p| {
            let mut cell = [0; 3];
            for (axis, spline) in axes.iter().enumerate() {
                cell[3 - dimension + axis] = spline.cell(particles.position.column(axis)[p]).0;
            }
            ((model.field(particles.body[p]), shape.of(cell)), shape.index(cell) as u32, p as u32)
        })
        .collect();
    // the last key is the place in memory, so that equal cells keep their order and the result does not depend on the sort
    keyed.sort_unstable();
    let order: Vec<usize> = keyed.iter().map(|k| k.2 as usize).collect();
    if !order.is_sorted() {
        permute(particles, &order);
    }
    let mut bins: Vec<Bin> = Vec::new();
    for (p, (block, _, _)) in keyed.iter().enumerate() {
        match bins.last_mut() {
            Some(bin) if (bin.field, bin.block) == *block => bin.end = p as u32 + 1,
            _ => bins.push(Bin { field: block.0, block: block.1, start: p as u32, end: p as u32 + 1 }),
        }
    }
    bins
}

/// Puts particle `order[p]` at place p.
fn permute(particles: &mut Particles, order: &[usize]) {
    fn gather<T: Copy>(column: &mut Vec<T>, order: &[usize]) {
        *column = order.iter().map(|&p| column[p]).collect();
    }
    gather(&mut particles.id, order);
    gather(&mut particles.body, order);
    gather(&mut particles.mass, order);
    gather(&mut particles.volume, order);
    for table in particles.tables_mut() {
        table.permute(order);
    }
}
