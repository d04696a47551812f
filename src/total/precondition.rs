//! The inverse of the stiffness of a box at rest, without the coupling of components: by fast diagonalisation (Lynch, Rice and Thomas 1964;
//! for splines, Sangalli and Tani 2016). It is what iterations start from.

use super::mass::Band;
use crate::basis::Axis;
use nalgebra::{DMatrix, DVector};
use std::ops::Range;

/// Most functions along an axis: the matrices of the axes are full.
pub(super) const MOST_FUNCTIONS: usize = 600;

/// The inverse for one component.
pub(super) struct FastDiagonal {
    counts: [usize; 3],
    ranges: [Range<usize>; 3],
    /// Eigenvectors of each axis, by column, made unit in the mass of the axis.
    vectors: [Option<DMatrix<f64>>; 3],
    /// One over the eigenvalues.
    inverse: Vec<f64>,
}

impl FastDiagonal {
    /// Of `mass` times the density of the volume, plus `moduli` of each axis times second derivatives along it; for the nodes of ranges.
    pub(super) fn new(axes: &[Axis], counts: [usize; 3], ranges: [Range<usize>; 3], mass: f64, moduli: [f64; 3]) -> Option<Self> {
        let mut vectors = [const { None }; 3];
        let mut values: [Vec<f64>; 3] = std::array::from_fn(|_| vec![0.0]);
        for (a, axis) in axes.iter().enumerate() {
            let full = |band: &Band| {
                let range = ranges[a].clone();
                DMatrix::from_fn(range.len(), range.len(), |i, j| band.entry(range.start + i, range.start + j))
            };
            let cholesky = full(&Band::mass(axis)).cholesky()?;
            // L^-1 K L^-T is symmetric
            let half = cholesky.l().solve_lower_triangular(&full(&Band::stiffness(axis)))?;
            let whole = cholesky.l().solve_lower_triangular(&half.transpose())?;
            let eigen = ((&whole + whole.transpose()) * 0.5).symmetric_eigen();
            vectors[a] = Some(cholesky.l().transpose().solve_upper_triangular(&eigen.eigenvectors)?);
            values[a] = eigen.eigenvalues.iter().copied().collect();
        }
        // what nothing holds is held by a little
        let sum = |i: usize, j: usize, k: usize| mass + moduli[0] * values[0][i] + moduli[1] * values[1][j] + moduli[2] * values[2][k];
        let most = values.iter().zip(moduli).map(|(v, m)| m * v.iter().copied().fold(0.0, f64::max)).fold(mass, f64::max);
        let mut inverse = Vec::new();
        for i in 0..values[0].len() {
            for j in 0..values[1].len() {
                inverse.extend((0..values[2].len()).map(|k| 1.0 / sum(i, j, k).max(1e-10 * most)));
            }
        }
        Some(Self { counts, ranges, vectors, inverse })
    }

    /// Number of nodes.
    pub(super) fn len(&self) -> usize {
        self.counts.iter().product()
    }

    /// Applies the inverse to one component of a nodal field, in place; what stands at nodes outside of the ranges becomes 0.
    pub(super) fn solve(&self, field: &mut [f64]) {
        let sizes = [0, 1, 2].map(|a| if self.vectors[a].is_some() { self.ranges[a].len() } else { 1 });
        let [_, ny, nz] = self.counts;
        let start = |a: usize| if self.vectors[a].is_some() { self.ranges[a].start } else { 0 };
        let place = |i: usize, j: usize, k: usize| ((start(0) + i) * ny + start(1) + j) * nz + start(2) + k;
        let mut inner = Vec::with_capacity(self.inverse.len());
        for i in 0..sizes[0] {
            for j in 0..sizes[1] {
                inner.extend((0..sizes[2]).map(|k| field[place(i, j, k)]));
            }
        }
        self.turn(&mut inner, sizes, true);
        inner.iter_mut().zip(&self.inverse).for_each(|(v, inverse)| *v *= inverse);
        self.turn(&mut inner, sizes, false);
        field.fill(0.0);
        let mut values = inner.into_iter();
        for i in 0..sizes[0] {
            for j in 0..sizes[1] {
                for k in 0..sizes[2] {
                    field[place(i, j, k)] = values.next().unwrap_or(0.0);
                }
            }
        }
    }

    /// To the eigenvectors of all axes, or back.
    fn turn(&self, field: &mut [f64], sizes: [usize; 3], forth: bool) {
        for (a, vectors) in self.vectors.iter().enumerate() {
            let Some(vectors) = vectors else { continue };
            let (count, stride) = (sizes[a], sizes[a + 1..].iter().product::<usize>());
            let mut line = DVector::zeros(count);
            for block in 0..field.len() / (count * stride) {
                for offset in 0..stride {
                    let first = block * count * stride + offset;
                    (0..count).for_each(|k| line[k] = field[first + k * stride]);
                    let turned = if forth { vectors.tr_mul(&line) } else { vectors * &line };
                    (0..count).for_each(|k| field[first + k * stride] = turned[k]);
                }
            }
        }
    }
}
