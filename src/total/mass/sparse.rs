//! The mass matrix of particles that do not fill a box: summed over them, factorised by sparse Cholesky.

use crate::implicit::{Factor, Matrix};
use crate::total::reference::Reference;

/// A mass matrix of one component of the nodes near particles.
pub(in crate::total) struct SparseMass {
    whole: Matrix,
    /// Of each component: the free nodes.
    free: [(Matrix, Option<Factor>); 3],
}

impl SparseMass {
    /// `masses` are those of the particles \[kg\]; `held` tells for each component and node whether it is held.
    pub(super) fn new(reference: &Reference, masses: &[f64], held: &[Vec<bool>; 3], dimension: usize) -> Self {
        let cells: Vec<Vec<u32>> =
            reference.cells().into_iter().map(|cell| cell.into_iter().map(|n| n - reference.start as u32).collect()).collect();
        let sum = |held: Option<&Vec<bool>>| {
            let mut matrix =
                Matrix::new(reference.len(), 1, cells.iter().map(Vec::as_slice), |node, _| held.is_some_and(|held| held[node]));
            let (mut nodes, mut weights, mut block) = (Vec::new(), Vec::new(), Vec::new());
            for (p, mass) in masses.iter().enumerate() {
                nodes.clear();
                weights.clear();
                reference.each_slowly(&reference.particle(p), |node, weight, _| {
                    nodes.push((node - reference.start) as u32);
                    weights.push(weight);
                });
                block.clear();
                block.extend(weights.iter().flat_map(|a| weights.iter().map(move |b| mass * a * b)));
                match reference.ties() {
                    Some(ties) => ties.add(&mut matrix, &nodes, 0, 1, &block),
                    None => matrix.add(&nodes, &block),
                }
            }
            matrix
        };
        let free = std::array::from_fn(|a| {
            let mut matrix = sum(Some(&held[a]));
            let factor = if a < dimension { matrix.factor(true) } else { None };
            (matrix, factor)
        });
        Self { whole: sum(None), free }
    }

    /// Multiplies one component of a nodal field by the matrix, in place.
    pub(super) fn times(&self, field: &mut [f64]) {
        let image = self.whole.times(field);
        field.copy_from_slice(&image);
    }

    /// Solves for the free nodes of a component, in place; what stands at others becomes 0.
    pub(super) fn solve(&self, component: usize, right: &mut [f64]) {
        let (matrix, factor) = &self.free[component];
        let mut x: Vec<f64> = matrix.components().map(|(node, _)| right[node]).collect();
        if let Some(factor) = factor {
            factor.solve(&mut x);
        }
        right.fill(0.0);
        for ((node, _), value) in matrix.components().zip(x) {
            right[node] = value;
        }
    }

    /// The entry of two nodes \[kg\].
    pub(super) fn entry(&self, i: usize, j: usize) -> f64 {
        self.whole.entry(i, j)
    }
}
