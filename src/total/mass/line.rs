//! Solving many lines of nodes at once, each with the same band matrix: lines lie beside each other, so that each operation is one on rows of numbers.

use crate::total::reference::MOST;
use rayon::prelude::*;
use std::ops::Range;

/// Lines that are contiguous in memory are solved so many at a time, side by side: enough to hide how long an operation takes.
const SIDE_BY_SIDE: usize = 16;
/// Numbers below which threads cost more than they bring.
const FEW: usize = 50_000;

/// A Cholesky factor of a band matrix.
#[derive(Debug)]
pub(super) struct Factor {
    /// Entry `[i][k]` is that of row i and column i - k; on the diagonal its reciprocal.
    rows: Vec<[f64; MOST]>,
    /// Entries beside the diagonal.
    beside: usize,
}

impl Factor {
    /// `rows` are those of a lower triangle, as above but for the diagonal.
    pub(super) fn new(mut rows: Vec<[f64; MOST]>) -> Self {
        let beside = (0..MOST).rev().find(|k| rows.iter().any(|row| row[*k] != 0.0)).unwrap_or(0);
        rows.iter_mut().for_each(|row| row[0] = 1.0 / row[0]);
        Self { rows, beside }
    }

    /// Solves along an axis of a field with these counts, in place; only the nodes of `range` take part.
    pub(super) fn solve(&self, counts: [usize; 3], axis: usize, range: &Range<usize>, field: &mut [f64]) {
        let stride: usize = counts[axis + 1..].iter().product();
        let count = counts[axis];
        let threads = rayon::current_num_threads() > 1 && field.len() > FEW;
        let block = if stride == 1 { SIDE_BY_SIDE * count } else { stride * count };
        let work = |block: &mut [f64]| {
            if stride == 1 {
                self.lines(count, range, block);
            } else {
                substitute(self, stride, &mut block[range.start * stride..range.end * stride]);
            }
        };
        if threads {
            field.par_chunks_mut(block).for_each(work);
        } else {
            field.chunks_mut(block).for_each(work);
        }
    }

    /// Solves lines of `count` nodes that follow each other in memory.
    fn lines(&self, count: usize, range: &Range<usize>, lines: &mut [f64]) {
        let number = lines.len() / count;
        let mut rows = vec![[0.0; SIDE_BY_SIDE]; range.len()];
        for line in 0..number {
            for (row, value) in rows.iter_mut().zip(&lines[line * count + range.start..]) {
                row[line] = *value;
            }
        }
        substitute(self, SIDE_BY_SIDE, rows.as_flattened_mut());
        for line in 0..number {
            for (row, value) in rows.iter().zip(&mut lines[line * count + range.start..]) {
                *value = row[line];
            }
        }
    }
}

/// Solves in place; row i of the field is `stride` numbers, one of each line.
fn substitute(factor: &Factor, stride: usize, field: &mut [f64]) {
    #[cfg(target_arch = "x86_64")]
    if std::arch::is_x86_feature_detected!("avx2") {
        // SAFETY: the processor has these instructions
        return unsafe { substitute_avx2(factor, stride, field) };
    }
    substitute_rows(factor, stride, field);
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2")]
fn substitute_avx2(factor: &Factor, stride: usize, field: &mut [f64]) {
    substitute_rows(factor, stride, field);
}

/// Forward and backward substitution. No fused operations: the same bytes on all processors.
#[inline(always)]
fn substitute_rows(factor: &Factor, stride: usize, field: &mut [f64]) {
    let n = field.len() / stride;
    // rows beside the one at hand, the nearest first
    let mut entries = [0.0; MOST];
    for i in 0..n {
        let (before, rest) = field.split_at_mut(i * stride);
        let beside = factor.beside.min(i);
        entries[..beside].copy_from_slice(&factor.rows[i][1..=beside]);
        reduce(&mut rest[..stride], factor.rows[i][0], &entries[..beside], |k| &before[(i - 1 - k) * stride..][..stride]);
    }
    for i in (0..n).rev() {
        let (rest, after) = field.split_at_mut((i + 1) * stride);
        let beside = factor.beside.min(n - 1 - i);
        for k in 0..beside {
            entries[k] = factor.rows[i + 1 + k][k + 1];
        }
        reduce(&mut rest[i * stride..], factor.rows[i][0], &entries[..beside], |k| &after[k * stride..][..stride]);
    }
}

/// row = (row - sum of entry k times row k) * scale, two rows at a time.
#[inline(always)]
fn reduce<'a>(row: &mut [f64], scale: f64, entries: &[f64], other: impl Fn(usize) -> &'a [f64]) {
    let pairs = entries.len() / 2;
    for pair in 0..pairs {
        let ([c, d], last) = ([entries[2 * pair], entries[2 * pair + 1]], 2 * pair + 2 == entries.len());
        let scale = if last { scale } else { 1.0 };
        for ((x, y), z) in row.iter_mut().zip(other(2 * pair)).zip(other(2 * pair + 1)) {
            *x = (*x - c * y - d * z) * scale;
        }
    }
    if entries.len() % 2 == 1 {
        let last = entries.len() - 1;
        for (x, y) in row.iter_mut().zip(other(last)) {
            *x = (*x - entries[last] * y) * scale;
        }
    }
    if entries.is_empty() {
        row.iter_mut().for_each(|x| *x *= scale);
    }
}
