//! A sparse matrix over the free components of nodes whose pattern never changes, and how systems with it are solved.

use faer::linalg::solvers::Solve;
use faer::sparse::linalg::solvers::{Llt, Lu, SymbolicLlt, SymbolicLu};
use faer::sparse::{SparseColMat, SymbolicSparseColMat};
use faer::{MatMut, Side};

/// Number of a component that is held.
const HELD: u32 = u32::MAX;

/// A sparse matrix: one row and column for each free component of each node that takes part.
pub(crate) struct Matrix {
    dimension: usize,
    /// Row and column by node and component.
    number: Vec<u32>,
    /// Node and component by row.
    component: Vec<(u32, u8)>,
    values: SparseColMat<usize, f64>,
    cholesky: Option<SymbolicLlt<usize>>,
    elimination: Option<SymbolicLu<usize>>,
}

/// A factor of a matrix.
pub(crate) enum Factor {
    Cholesky(Llt<usize, f64>),
    Elimination(Box<Lu<usize, f64>>),
}

impl Factor {
    /// Solves in place.
    pub(crate) fn solve(&self, x: &mut [f64]) {
        let n = x.len();
        let x = MatMut::from_column_major_slice_mut(x, n, 1);
        match self {
            Self::Cholesky(factor) => factor.solve_in_place(x),
            Self::Elimination(factor) => factor.solve_in_place(x),
        }
    }
}

impl Matrix {
    /// `cells` are sets of nodes, in ascending order, that are coupled with each other; `held` tells by node and component what is no
    /// unknown.
    pub(crate) fn new<'a>(
        nodes: usize,
        dimension: usize,
        cells: impl Iterator<Item = &'a [u32]> + Clone,
        held: impl Fn(usize, usize) -> bool,
    ) -> Self {
        let mut neighbours: Vec<Vec<u32>> = vec![Vec::new(); nodes];
        for cell in cells {
            for &node in cell {
                neighbours[node as usize].extend_from_slice(cell);
                // keeps the lists short while they are being made
                if neighbours[node as usize].len() > 1024 {
                    neighbours[node as usize].sort_unstable();
                    neighbours[node as usize].dedup();
                }
            }
        }
        let (mut number, mut component) = (vec![HELD; nodes * dimension], Vec::new());
        for (node, list) in neighbours.iter_mut().enumerate() {
            list.sort_unstable();
            list.dedup();
            for axis in (0..dimension).filter(|&axis| !list.is_empty() && !held(node, axis)) {
                number[node * dimension + axis] = component.len() as u32;
                component.push((node as u32, axis as u8));
            }
        }
        let (mut starts, mut rows) = (vec![0], Vec::new());
        for &(node, _) in &component {
            for &other in &neighbours[node as usize] {
                let own = &number[other as usize * dimension..][..dimension];
                rows.extend(own.iter().filter(|n| **n != HELD).map(|n| *n as usize));
            }
            starts.push(rows.len());
        }
        let n = component.len();
        let values = vec![0.0; rows.len()];
        let pattern = SymbolicSparseColMat::new_checked(n, n, starts, None, rows);
        let values = SparseColMat::new(pattern, values);
        Self { dimension, number, component, values, cholesky: None, elimination: None }
    }

    /// Node and component of each unknown.
    pub(crate) fn components(&self) -> impl Iterator<Item = (usize, usize)> {
        self.component.iter().map(|&(node, axis)| (node as usize, axis as usize))
    }

    /// Makes all entries zero.
    pub(crate) fn clear(&mut self) {
        self.values.val_mut().fill(0.0);
    }

    /// Adds a dense block over all components of `nodes`, which are ascending, column by column.
    pub(crate) fn add(&mut self, nodes: &[u32], block: &[f64]) {
        let d = self.dimension;
        let (pattern, values) = self.values.parts_mut();
        let rows = nodes.len() * d;
        for (b, &node) in nodes.iter().enumerate() {
            for k in 0..d {
                let column = self.number[node as usize * d + k];
                if column == HELD {
                    continue;
                }
                let range = pattern.col_range(column as usize);
                let places = &pattern.row_idx()[range.clone()];
                let values = &mut values[range];
                let from = &block[(b * d + k) * rows..][..rows];
                // both lists ascend: one walk finds all
                let mut at = 0;
                for (a, &other) in nodes.iter().enumerate() {
                    for i in 0..d {
                        let row = self.number[other as usize * d + i];
                        if row == HELD {
                            continue;
                        }
                        while places[at] != row as usize {
                            at += 1;
                        }
                        values[at] += from[a * d + i];
                    }
                }
            }
        }
    }

    /// Adds `entry(node, other)` to each pair of like components of nodes that are coupled.
    pub(crate) fn add_scalar(&mut self, entry: impl Fn(usize, usize) -> f64) {
        let (pattern, values) = self.values.parts_mut();
        for (column, &(node, axis)) in self.component.iter().enumerate() {
            let range = pattern.col_range(column);
            for (&row, value) in pattern.row_idx()[range.clone()].iter().zip(&mut values[range]) {
                let (other, along) = self.component[row];
                if along == axis {
                    *value += entry(other as usize, node as usize);
                }
            }
        }
    }

    /// The matrix times a field of the unknowns.
    #[cfg(test)]
    pub(crate) fn multiply(&self, x: &[f64]) -> Vec<f64> {
        let mut y = vec![0.0; x.len()];
        for (column, x) in x.iter().enumerate() {
            for (&row, value) in self.values.symbolic().row_idx_of_col_raw(column).iter().zip(self.values.val_of_col(column)) {
                y[row] += value * x;
            }
        }
        y
    }

    /// The matrix, of one component, times a nodal field.
    pub(crate) fn times(&self, field: &[f64]) -> Vec<f64> {
        let mut image = vec![0.0; field.len()];
        for (column, &(node, _)) in self.component.iter().enumerate() {
            for (&row, value) in self.values.symbolic().row_idx_of_col_raw(column).iter().zip(self.values.val_of_col(column)) {
                image[self.component[row].0 as usize] += value * field[node as usize];
            }
        }
        image
    }

    /// The entry of two nodes of a matrix of one component; 0 where they are not coupled.
    pub(crate) fn entry(&self, node: usize, other: usize) -> f64 {
        let (row, column) = (self.number[node], self.number[other]);
        if row == HELD || column == HELD {
            return 0.0;
        }
        let rows = self.values.symbolic().row_idx_of_col_raw(column as usize);
        rows.binary_search(&(row as usize)).map_or(0.0, |at| self.values.val_of_col(column as usize)[at])
    }

    /// A Cholesky factor; `None` where the matrix is not positive.
    pub(crate) fn cholesky(&mut self) -> Option<Factor> {
        if self.cholesky.is_none() {
            self.cholesky = Some(SymbolicLlt::try_new(self.values.symbolic(), Side::Lower).ok()?);
        }
        let symbolic = self.cholesky.clone()?;
        Llt::try_new_with_symbolic(symbolic, self.values.as_ref(), Side::Lower).ok().map(Factor::Cholesky)
    }

    /// A factor of the matrix: Cholesky where it is symmetric and positive, else by elimination. `None` where it is singular.
    pub(crate) fn factor(&mut self, symmetric: bool) -> Option<Factor> {
        if let Some(factor) = symmetric.then(|| self.cholesky()).flatten() {
            return Some(factor);
        }
        if self.elimination.is_none() {
            self.elimination = Some(SymbolicLu::try_new(self.values.symbolic()).ok()?);
        }
        let symbolic = self.elimination.as_ref()?;
        Lu::try_new_with_symbolic(symbolic.clone(), self.values.as_ref()).ok().map(|factor| Factor::Elimination(Box::new(factor)))
    }
}
