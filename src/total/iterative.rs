//! Corrections of Newton's method by conjugate gradients, without a matrix.

use super::Total;
use super::implicit::Step;
use super::load::Action;
use super::mass::bounds;
use super::precondition::{FastDiagonal, MOST_FUNCTIONS};
use super::reference::Vectors;
use crate::component::StepError;
use crate::implicit::{Scheme, conjugate_gradients};
use crate::model::Model;
use crate::scene::LinearSolver;

/// Unknowns from which on a factor takes longer and more memory, in dimension 3 and below.
const MANY: [usize; 2] = [30_000, 300_000];
/// Residual of a correction, relative: each takes the residual of Newton's method down by about as much.
const RESIDUAL: f64 = 1e-6;
const MOST_ITERATIONS: usize = 2000;

/// Inverses to start from, of each body and component, and the weights of stiffness and mass that they are for.
pub(super) struct Precondition {
    weights: [f64; 2],
    bodies: Vec<Vec<FastDiagonal>>,
}

impl Total {
    /// Whether corrections are found by iteration.
    pub(super) fn iterates(&self, model: &Model, scheme: Scheme) -> bool {
        let unknowns = self.acceleration.len() * model.dimension;
        let can = self.sweeps.linear.is_some()
            && !self.updated
            && self.bodies.iter().all(|body| body.reference.ties().is_none())
            && !scheme.is_conserving()
            && model.bodies.iter().all(|body| body.material.has_potential())
            && !self.actions.iter().any(|action| matches!(action, Action::Follower(_)));
        can && match model.linear_solver {
            Some(solver) => solver == LinearSolver::Iterative,
            None => unknowns > MANY[usize::from(model.dimension < 3)],
        }
    }

    /// Makes the inverses, unless they are there. `false` where that takes too much.
    fn precondition(&mut self, model: &Model, weights: [f64; 2]) -> bool {
        if self.precondition.as_ref().is_some_and(|known| known.weights == weights) {
            return true;
        }
        let mut bodies = Vec::new();
        for (body, described) in self.bodies.iter().zip(&model.bodies) {
            let reference = &body.reference;
            if reference.counts.iter().any(|&count| count > MOST_FUNCTIONS) {
                return false;
            }
            let lame = described.material.lame();
            // along its own axis a component sees the modulus of compression
            let along = if model.embedding.stress_free {
                4.0 * lame.mu * (lame.lambda + lame.mu) / lame.wave_modulus()
            } else {
                lame.wave_modulus()
            };
            let mut components = Vec::new();
            for component in 0..model.dimension {
                let moduli = std::array::from_fn(|a| weights[0] * if a == component { along } else { lame.mu });
                let ranges = self.free_ranges(body.reference.start, reference.counts, component);
                let Some(one) = FastDiagonal::new(&described.axes, reference.counts, ranges, weights[1] * described.density, moduli) else {
                    return false;
                };
                components.push(one);
            }
            bodies.push(components);
        }
        self.precondition = Some(Precondition { weights, bodies });
        true
    }

    /// The smallest box of nodes that holds all that are free.
    fn free_ranges(&self, start: usize, counts: [usize; 3], component: usize) -> [std::ops::Range<usize>; 3] {
        let mut free = vec![true; counts.iter().product()];
        let nodes = start..start + free.len();
        for held in self.held.iter().filter(|h| h.axis == component && nodes.contains(&h.node)) {
            free[held.node - start] = false;
        }
        bounds(&free, counts)
    }
}

impl Step<'_> {
    /// The correction after a displacement; `None` where it is not found so.
    pub(super) fn iterate(&mut self, moved: &[[f64; 3]], forces: &[[f64; 3]]) -> Result<Option<Vectors>, StepError> {
        let Some(linear) = self.total.sweeps.linear else { return Ok(None) };
        let (inner, by_moved) = (self.trial.inner, self.trial.acceleration[0]);
        if !self.total.precondition(self.model, [inner, by_moved]) {
            return Ok(None);
        }
        let at = self.at(moved, inner);
        let mut moduli = Vec::new();
        for part in &self.total.parts {
            let task = self.total.task(self.model, part, &at, false);
            let mut own = Vec::new();
            let found = (linear.moduli)(&task, &self.state.particles, &mut own);
            found.map_err(|trouble| self.total.explain(self.model, self.state, self.time, &trouble))?;
            moduli.push(own);
        }
        let model = self.model;
        let has_inertia = self.scheme.has_inertia();
        let Some(precondition) = self.total.precondition.take() else { return Ok(None) };
        let total = &mut *self.total;
        let release = |total: &Total, field: &mut Vectors| {
            for held in &total.held {
                field[held.node][held.axis] = 0.0;
            }
        };
        let starts: Vec<usize> = total.bodies.iter().map(|body| body.reference.start).collect();
        let held: Vec<(usize, usize)> = total.held.iter().map(|h| (h.node, h.axis)).collect();
        let correction = conjugate_gradients(
            |x| {
                let mut y = vec![[0.0; 3]; x.len()];
                for (part, moduli) in total.parts.iter().zip(&moduli) {
                    (linear.times)(&total.task(model, part, &at, false), moduli, x, &mut y);
                }
                y.iter_mut().flatten().for_each(|v| *v *= inner);
                if has_inertia {
                    let inertia = total.times(model, &x.to_vec());
                    y.iter_mut().zip(&inertia).for_each(|(y, m)| (0..3).for_each(|a| y[a] += by_moved * m[a]));
                }
                release(total, &mut y);
                y
            },
            |r| {
                let mut z = vec![[0.0; 3]; r.len()];
                for (start, components) in starts.iter().zip(&precondition.bodies) {
                    for (a, inverse) in components.iter().enumerate() {
                        let nodes = *start..*start + inverse.len();
                        let mut field: Vec<f64> = r[nodes.clone()].iter().map(|r| r[a]).collect();
                        inverse.solve(&mut field);
                        nodes.zip(field).for_each(|(node, v)| z[node][a] = v);
                    }
                }
                held.iter().for_each(|&(node, a)| z[node][a] = 0.0);
                z
            },
            forces,
            RESIDUAL,
            MOST_ITERATIONS,
        );
        self.total.precondition = Some(precondition);
        Ok(correction)
    }
}
