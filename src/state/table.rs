//! Numbers of the particles, column by column.

use crate::lines::{Lines, NUMBERS_PER_LINE};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

/// A table of numbers with one row a particle, stored column by column (structure of arrays): a kernel loads the same component of
/// neighbouring particles from neighbouring memory.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Table {
    width: usize,
    rows: usize,
    data: Lines,
}

/// From one column to the next. A kernel walks down all columns at once; were they a multiple of the page size apart, all would compete
/// for the same few lines of the cache (measured: 1.6 times slower with a million particles).
fn stride(rows: usize) -> usize {
    const LINES_PER_PAGE: usize = 64;
    let lines = rows.div_ceil(NUMBERS_PER_LINE);
    let shift = if lines < LINES_PER_PAGE { 0 } else { (5 + LINES_PER_PAGE - lines % LINES_PER_PAGE) % LINES_PER_PAGE };
    (lines + shift) * NUMBERS_PER_LINE
}

impl Table {
    pub(crate) fn new(width: usize, rows: usize) -> Self {
        Self { width, rows, data: Lines::zeros(width * stride(rows)) }
    }
    pub(crate) fn width(&self) -> usize {
        self.width
    }
    pub(crate) fn column(&self, c: usize) -> &[f64] {
        let start = c * stride(self.rows);
        &self.data.numbers()[start..start + self.rows]
    }
    pub(crate) fn column_mut(&mut self, c: usize) -> &mut [f64] {
        let start = c * stride(self.rows);
        &mut self.data.numbers_mut()[start..start + self.rows]
    }
    pub(crate) fn columns_mut(&mut self) -> impl Iterator<Item = &mut [f64]> {
        let rows = self.rows;
        self.data.numbers_mut().chunks_mut(stride(rows).max(1)).map(move |column| &mut column[..rows])
    }
    /// The first `N` numbers of a row; those beyond the width are 0.
    pub(crate) fn row<const N: usize>(&self, p: usize) -> [f64; N] {
        let mut row = [0.0; N];
        for (c, value) in row.iter_mut().enumerate().take(self.width) {
            *value = self.column(c)[p];
        }
        row
    }
    pub(crate) fn set_row(&mut self, p: usize, row: &[f64]) {
        for (column, value) in self.columns_mut().zip(row) {
            column[p] = *value;
        }
    }
    /// Puts row `order[p]` at place p, and leaves memory in `spare` that may be used again.
    pub(crate) fn permute(&mut self, order: &[u32], shared: bool, spare: &mut Lines) {
        let stride = stride(self.rows).max(1);
        spare.resize(self.data.numbers().len());
        let sort = |(to, from): (&mut [f64], &[f64])| {
            for (to, &p) in to.iter_mut().zip(order) {
                *to = from[p as usize];
            }
        };
        let (to, from) = (spare.numbers_mut(), self.data.numbers());
        if shared {
            to.par_chunks_mut(stride).zip(from.par_chunks(stride)).for_each(sort);
        } else {
            to.chunks_mut(stride).zip(from.chunks(stride)).for_each(sort);
        }
        std::mem::swap(&mut self.data, spare);
    }
    /// Copies a table into this one, whose memory is used again.
    pub(super) fn copy_from(&mut self, other: &Self) {
        (self.width, self.rows) = (other.width, other.rows);
        self.data.clone_from(&other.data);
    }
    pub(super) fn is(&self, width: usize, rows: usize) -> bool {
        self.width == width
            && (width == 0 && self.data.numbers().is_empty() || self.rows == rows && self.data.numbers().len() == width * stride(rows))
    }
}
