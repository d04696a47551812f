//! Mass matrices, and how they are inverted.

mod filled;
mod line;
mod sparse;

use super::Held;
use super::reference::Reference;
use crate::model::Model;
pub(super) use filled::Band;
use filled::FilledMass;
use sparse::SparseMass;
use std::ops::Range;

/// The smallest box of nodes that holds all that are free; empty where none is.
pub(super) fn bounds(free: &[bool], counts: [usize; 3]) -> [Range<usize>; 3] {
    let (mut low, mut high) = ([usize::MAX; 3], [0; 3]);
    for (i, _) in free.iter().enumerate().filter(|(_, free)| **free) {
        let index = [i / (counts[1] * counts[2]), i / counts[2] % counts[1], i % counts[2]];
        for a in 0..3 {
            (low[a], high[a]) = (low[a].min(index[a]), high[a].max(index[a] + 1));
        }
    }
    std::array::from_fn(|a| low[a].min(high[a])..high[a])
}

/// How the masses of a body are inverted.
pub(super) enum Mass {
    /// Of each node \[kg\].
    Lumped(Vec<f64>),
    /// Of a box.
    Filled(Box<FilledMass>),
    /// Of a body that is no box.
    Sparse(Box<SparseMass>),
}

impl Mass {
    /// `masses` are those of the particles of a grid \[kg\]; `filled` is the body that fills it, if one does.
    pub(super) fn new(model: &Model, reference: &Reference, masses: &[f64], held: &[Held], filled: Option<&crate::model::Body>) -> Self {
        if model.balance.is_lumped() {
            let mut sums = vec![0.0; reference.len()];
            for (p, mass) in masses.iter().enumerate() {
                reference.each_slowly(&reference.particle(p), |node, weight, _| sums[node - reference.start] += mass * weight);
            }
            if let Some(ties) = reference.ties() {
                let mut rows: Vec<[f64; 1]> = sums.iter().map(|sum| [*sum]).collect();
                ties.fold(&mut rows);
                sums = rows.into_iter().map(|[sum]| sum).collect();
            }
            return Self::Lumped(sums);
        }
        let mut fixed: [Vec<bool>; 3] = std::array::from_fn(|_| vec![false; reference.len()]);
        held.iter().for_each(|h| fixed[h.axis][h.node - reference.start] = true);
        match filled {
            Some(body) => Self::Filled(Box::new(FilledMass::new(body.density, &body.axes, reference.counts, fixed))),
            None => Self::Sparse(Box::new(SparseMass::new(reference, masses, &fixed, model.dimension))),
        }
    }

    /// Multiplies one component of a nodal field by the matrix, in place.
    pub(super) fn times(&mut self, field: &mut [f64]) {
        match self {
            Self::Lumped(masses) => field.iter_mut().zip(masses.iter()).for_each(|(v, mass)| *v *= mass),
            Self::Filled(mass) => mass.times(field),
            Self::Sparse(mass) => mass.times(field),
        }
    }

    /// The entry of two nodes \[kg\].
    pub(super) fn entry(&self, i: usize, j: usize) -> f64 {
        match self {
            Self::Lumped(masses) => {
                if i == j {
                    masses[i]
                } else {
                    0.0
                }
            }
            Self::Filled(mass) => mass.entry(i, j),
            Self::Sparse(mass) => mass.entry(i, j),
        }
    }

    /// The lumped mass of a node; 0 where there is none \[kg\].
    pub(super) fn lumped(&self, i: usize) -> f64 {
        if let Self::Lumped(masses) = self { masses[i] } else { 0.0 }
    }

    /// Rows of the matrix, those of a box of nodes, times one component of a field.
    pub(super) fn rows_times(&mut self, rows: &[Range<usize>; 3], counts: [usize; 3], field: &[f64]) -> Vec<f64> {
        if let Self::Filled(mass) = self {
            return mass.rows_times(rows, field);
        }
        let mut all = field.to_vec();
        self.times(&mut all);
        let [_, y, z] = counts;
        let line = |i: usize, j: usize| rows[2].clone().map(move |k| (i * y + j) * z + k);
        let nodes = rows[0].clone().flat_map(|i| rows[1].clone().flat_map(move |j| line(i, j)));
        nodes.map(|node| all[node]).collect()
    }

    /// Solves for the free nodes of a component, in place; what stands at held nodes is lost.
    pub(super) fn solve(&mut self, component: usize, right: &mut [f64]) {
        match self {
            Self::Lumped(masses) => {
                right.iter_mut().zip(masses.iter()).for_each(|(v, mass)| *v = if *mass > 0.0 { *v / mass } else { 0.0 });
            }
            Self::Filled(mass) => mass.solve(component, right),
            Self::Sparse(mass) => mass.solve(component, right),
        }
    }
}
