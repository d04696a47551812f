//! Shape functions at a list of points, as rows of a sparse matrix over the stored nodes.

use crate::basis::{is_tied, serendipity_weight};
use crate::grid::Lanes;
use crate::model::Model;
use crate::transfer::StencilRows;

/// A row a point: the shape functions there. All rows have as many entries.
#[derive(Debug, Clone, Default)]
pub(super) struct SparseRows {
    entries: usize,
    nodes: Vec<u32>,
    weights: Vec<f64>,
    /// Derivatives \[1/m\] by axis; empty unless asked for.
    slopes: Vec<[f64; 3]>,
    /// Entries of tied nodes, those of their masters, and the weights: the same for every element.
    ties: Vec<(usize, usize, f64)>,
}

impl SparseRows {
    /// Starts anew.
    pub(super) fn clear(&mut self, model: &Model) {
        let width = model.axes[0].width();
        if self.entries == 0 {
            self.entries = width.pow(model.dimension as u32);
            if model.needs.tied {
                self.ties = ties(model.dimension, self.entries);
            }
        }
        self.nodes.clear();
        self.weights.clear();
        self.slopes.clear();
    }

    /// Appends the points of `rows`; `index` finds where a node is stored. The number of the first point for which it does not.
    pub(super) fn push(&mut self, rows: &StencilRows, with_slopes: bool, index: impl Fn([i32; 3]) -> Option<usize>) -> Result<(), usize> {
        let start = self.weights.len();
        let mut before = None;
        for (p, nodes) in rows.nodes.chunks(self.entries).enumerate() {
            if before == Some(nodes[0]) {
                // neighbours see the same nodes
                let last = self.nodes.len() - self.entries;
                self.nodes.extend_from_within(last..);
                continue;
            }
            for node in nodes {
                self.nodes.push(index(*node).ok_or(p)? as u32);
            }
            before = Some(nodes[0]);
        }
        self.weights.extend(&rows.weights);
        if with_slopes {
            self.slopes.extend(&rows.slopes);
        }
        for point in (start..self.weights.len()).step_by(self.entries) {
            for &(tied, master, weight) in &self.ties {
                self.weights[point + master] += weight * self.weights[point + tied];
                if with_slopes {
                    for a in 0..3 {
                        self.slopes[point + master][a] += weight * self.slopes[point + tied][a];
                    }
                }
            }
            for &(tied, ..) in &self.ties {
                self.weights[point + tied] = 0.0;
                if with_slopes {
                    self.slopes[point + tied] = [0.0; 3];
                }
            }
        }
        Ok(())
    }

    pub(super) fn len(&self) -> usize {
        self.weights.len().checked_div(self.entries).unwrap_or(0)
    }

    /// Nodes and weights of a point.
    #[inline(always)]
    pub(super) fn row(&self, point: usize) -> impl Iterator<Item = (usize, f64)> {
        let range = point * self.entries..(point + 1) * self.entries;
        self.nodes[range.clone()].iter().map(|n| *n as usize).zip(self.weights[range].iter().copied())
    }

    /// Nodes and derivatives of a point.
    pub(super) fn slopes(&self, point: usize) -> impl Iterator<Item = (usize, [f64; 3])> {
        let range = point * self.entries..(point + 1) * self.entries;
        self.nodes[range.clone()].iter().map(|n| *n as usize).zip(self.slopes[range].iter().copied())
    }

    /// The field at a point.
    #[inline(always)]
    pub(super) fn value(&self, point: usize, field: &[Lanes]) -> Lanes {
        let mut sum = Lanes::default();
        for (node, weight) in self.row(point) {
            for lane in 0..4 {
                sum[lane] += weight * field[node][lane];
            }
        }
        sum
    }

    /// Adds an amount at a point to the nodes.
    #[inline(always)]
    pub(super) fn add(&self, point: usize, amount: Lanes, to: &mut [Lanes]) {
        for (node, weight) in self.row(point) {
            for lane in 0..4 {
                to[node][lane] += weight * amount[lane];
            }
        }
    }
}

/// Ties within an element of three nodes an axis.
fn ties(dimension: usize, entries: usize) -> Vec<(usize, usize, f64)> {
    let node = |entry: usize| -> [i32; 3] {
        std::array::from_fn(|s| if s < 3 - dimension { 0 } else { (entry / 3usize.pow(2 - s as u32) % 3) as i32 })
    };
    let mut list = Vec::new();
    for tied in (0..entries).filter(|e| is_tied(dimension, node(*e))) {
        for master in 0..entries {
            let weight = serendipity_weight(dimension, node(tied), node(master));
            if weight != 0.0 {
                list.push((tied, master, weight));
            }
        }
    }
    list
}
