//! The mass matrix of particles that do not fill a box: summed over them, factorised by sparse Cholesky.

use crate::implicit::{Factor, Matrix};
use crate::total::reference::Reference;

/// A mass matrix of one component of the nodes near particles.
pub(in crate::total) struct SparseMass {
    whole: Matrix,
    /// Of the free nodes: once for components that have the same.
    free: Vec<(Matrix, Option<Factor>)>,
    /// Place among `free` by component.
    of: [usize; 3],
}

impl SparseMass {
    /// `masses` are those of the particles \[kg\]; `held` tells for each component and node whether it is held.
    pub(super) fn new(reference: &Reference, masses: &[f64], held: &[Vec<bool>; 3], dimension: usize) -> Self {
        let cells: Vec<Vec<u32>> =
            reference.cells().into_iter().map(|cell| cell.into_iter().map(|n| n - reference.start as u32).collect()).collect();
        let sum = |held: Option<&Vec<bool>>| {
            let mut matrix =
                Matrix::new(reference.len(), 1, cells.iter().map(Vec::as_slice), |node, _| held.is_some_and(|held| held[node]));
            let mut add = |nodes: &[u32], block: &[f64]| match reference.ties() {
                Some(ties) => ties.add(&mut matrix, nodes, 0, 1, block),
                None => matrix.add(nodes, block),
            };
            // particles of the same cell share their nodes: their shares are summed in a dense block first
            let (mut nodes, mut weights, mut block) = (Vec::new(), Vec::new(), Vec::new());
            let mut cell = None;
            for (p, mass) in masses.iter().enumerate() {
                let at = reference.particle(p);
                if cell != Some(at.cell()) {
                    if cell.is_some() {
                        add(&nodes, &block);
                    }
                    cell = Some(at.cell());
                    nodes.clear();
                    reference.each_slowly(&at, |node, _, _| nodes.push((node - reference.start) as u32));
                    block.clear();
                    block.resize(nodes.len() * nodes.len(), 0.0);
                }
                weights.clear();
                reference.each_slowly(&at, |_, weight, _| weights.push(weight));
                for (row, a) in block.chunks_exact_mut(nodes.len()).zip(&weights) {
                    row.iter_mut().zip(&weights).for_each(|(entry, b)| *entry += mass * a * b);
                }
            }
            if cell.is_some() {
                add(&nodes, &block);
            }
            matrix
        };
        let (mut free, mut of) = (Vec::new(), [0; 3]);
        for a in 0..dimension {
            of[a] = (0..a).find(|&other| held[other] == held[a]).map_or(free.len(), |other| of[other]);
            if of[a] == free.len() {
                let mut matrix = sum(Some(&held[a]));
                let factor = matrix.factor(true);
                free.push((matrix, factor));
            }
        }
        Self { whole: sum(None), free, of }
    }

    /// Multiplies one component of a nodal field by the matrix, in place.
    pub(super) fn times(&self, field: &mut [f64]) {
        let image = self.whole.times(field);
        field.copy_from_slice(&image);
    }

    /// Solves for the free nodes of a component, in place; what stands at others becomes 0.
    pub(super) fn solve(&self, component: usize, right: &mut [f64]) {
        let (matrix, factor) = &self.free[self.of[component]];
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
