//! A sparse factor of a mass matrix, from which conjugate gradients start: exact but for held nodes.

use super::mass::{NOTHING, Reduced};
use crate::grid::Lanes;
use crate::implicit::{Factor, Matrix};

/// The factor, and the pattern that it was analysed for.
#[derive(Default)]
pub(super) struct Direct {
    matrix: Option<Matrix>,
    /// Nodes of the groups of points that share them, one group after the other, with its length before it.
    pattern: Vec<u32>,
    factor: Option<Factor>,
    column: Vec<f64>,
}

impl std::fmt::Debug for Direct {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        f.debug_struct("Direct").field("unknowns", &self.column.len()).finish()
    }
}

/// Points that see the same nodes: those, ascending, and their matrix row by row.
pub(super) struct Group {
    pub(super) nodes: Vec<u32>,
    pub(super) block: Vec<f64>,
}

impl Group {
    /// For points with these nodes.
    pub(super) fn new(row: &Reduced) -> Self {
        let mut nodes: Vec<u32> = row.iter().map(|(node, _)| *node as u32).collect();
        nodes.sort_unstable();
        let block = vec![0.0; nodes.len() * nodes.len()];
        Self { nodes, block }
    }

    /// A node that is lumped.
    pub(super) fn of(node: usize, mass: f64) -> Self {
        Self { nodes: vec![node as u32], block: vec![mass] }
    }

    /// Adds `mass N N^T`.
    pub(super) fn add(&mut self, row: &Reduced, mass: f64, place: &mut Vec<usize>) {
        place.clear();
        place.extend(row.iter().map(|(node, _)| self.nodes.partition_point(|n| (*n as usize) < *node)));
        let n = self.nodes.len();
        for ((_, a), &i) in row.iter().zip(place.iter()) {
            for ((_, b), &j) in row.iter().zip(place.iter()) {
                self.block[i * n + j] += mass * a * b;
            }
        }
    }
}

impl Direct {
    /// Factors the sum of groups over this many stored nodes. Where it cannot be, there is none.
    pub(super) fn factor(&mut self, nodes: usize, groups: &[Group]) {
        let mut diagonal = vec![0.0; nodes];
        for group in groups {
            let n = group.nodes.len();
            group.nodes.iter().enumerate().for_each(|(i, node)| diagonal[*node as usize] += group.block[i * n + i]);
        }
        let least = NOTHING * diagonal.iter().copied().fold(0.0, f64::max);
        let mut pattern: Vec<u32> =
            groups.iter().flat_map(|g| std::iter::once(g.nodes.len() as u32).chain(g.nodes.iter().copied())).collect();
        pattern.extend((0..nodes).filter(|node| diagonal[*node] > 0.0 && diagonal[*node] <= least).map(|node| node as u32));
        if self.matrix.is_none() || pattern != self.pattern {
            let groups = groups.iter().map(|g| g.nodes.as_slice());
            self.matrix = Some(Matrix::new(nodes, 1, groups, |node, _| diagonal[node] <= least));
            self.pattern = pattern;
        }
        self.factor = None;
        if let Some(matrix) = &mut self.matrix {
            matrix.clear();
            groups.iter().for_each(|g| matrix.add(&g.nodes, &g.block));
            self.factor = matrix.cholesky();
            self.column.resize(matrix.components().count(), 0.0);
        }
    }

    pub(super) fn is_ready(&self) -> bool {
        self.factor.is_some()
    }

    /// Forgets the factor.
    pub(super) fn clear(&mut self) {
        self.factor = None;
    }

    /// `solution` = matrix^-1 `right`, in all lanes but the first; zero at nodes that take no part.
    pub(super) fn solve(&mut self, right: &[Lanes], solution: &mut Vec<Lanes>) {
        solution.clear();
        solution.resize(right.len(), Lanes::default());
        let (Some(matrix), Some(factor)) = (&self.matrix, &self.factor) else { return };
        for lane in 1..4 {
            if right.iter().all(|lanes| lanes[lane] == 0.0) {
                continue;
            }
            for ((node, _), value) in matrix.components().zip(&mut self.column) {
                *value = right[node][lane];
            }
            factor.solve(&mut self.column);
            for ((node, _), value) in matrix.components().zip(&self.column) {
                solution[node][lane] = *value;
            }
        }
    }
}
