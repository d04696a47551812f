//! Fields of the points of a lattice as forces on its nodes, axis by axis.

use super::{Grid, GridAxis};
use crate::total::reference::{Line, Reference};

/// The functions at the points of a body, and its masses.
pub(crate) struct Spread {
    density: f64,
    axes: Vec<GridAxis>,
    /// Nodes along each axis.
    nodes: [usize; 3],
    /// First node of the body.
    start: usize,
    /// Place of each particle among the points, row by row.
    order: Vec<u32>,
}

impl Spread {
    pub(super) fn new(grid: Grid, reference: &Reference, density: f64, particles: usize) -> Self {
        let [_, y, z] = [0, 1, 2].map(|a| grid.axes[a].as_ref().map_or(1, |axis| axis.lines.len()));
        let order = (0..particles).map(|p| grid.place(p)).map(|[i, j, k]| ((i * y + j) * z + k) as u32).collect();
        Self { density, axes: grid.axes.into_iter().flatten().collect(), nodes: reference.counts, start: reference.start, order }
    }

    /// Adds the forces of an acceleration of the particles \[m/s2\], by number on their grid.
    pub(in crate::total) fn add(&self, accelerations: &[[f64; 3]], force: &mut [[f64; 3]]) {
        let mut field = vec![[0.0; 3]; accelerations.len()];
        for (value, place) in accelerations.iter().zip(&self.order) {
            field[*place as usize] = value.map(|v| self.density * v);
        }
        let mut field = field.as_flattened().to_vec();
        for (a, axis) in self.axes.iter().enumerate() {
            let inner = 3 * self.axes[a + 1..].iter().map(|axis| axis.lines.len()).product::<usize>();
            field = self.contract(axis, self.nodes[a], inner, &field);
        }
        let nodes = force[self.start..].as_flattened_mut();
        nodes.iter_mut().zip(&field).for_each(|(f, push)| *f += push);
    }

    /// Sums over the points along one axis: rows of `inner` numbers.
    fn contract(&self, axis: &GridAxis, nodes: usize, inner: usize, field: &[f64]) -> Vec<f64> {
        let points = axis.lines.len();
        let mut sums = vec![0.0; field.len() / points * nodes];
        for (from, to) in field.chunks_exact(points * inner).zip(sums.chunks_exact_mut(nodes * inner)) {
            let rows = axis.lines.iter().zip(&axis.shares).zip(from.chunks_exact(inner));
            for ((Line { first, weight, .. }, share), row) in rows {
                for (k, to) in to[first * inner..].chunks_exact_mut(inner).take(weight.len()).enumerate() {
                    let weight = share * weight[k];
                    if weight != 0.0 {
                        to.iter_mut().zip(row).for_each(|(to, value)| *to += weight * value);
                    }
                }
            }
        }
        sums
    }
}
