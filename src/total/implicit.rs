//! ONE IMPLICIT STEP of the total-Lagrangian method: the displacement at its end, by Newton's method.

use super::reference::Vectors;
use super::{Total, pace};
use crate::component::StepError;
use crate::implicit::{Balance, Failure, Matrix, Residual, Scheme, Trial, newton};
use crate::model::Model;
use crate::state::{Nodes, State};

/// Share of a prescribed displacement by which forces are differenced for the first guess.
const SMALL: f64 = 1e-6;

/// A step under way.
pub(super) struct Step<'a> {
    pub(super) total: &'a mut Total,
    pub(super) model: &'a Model,
    pub(super) state: &'a State,
    pub(super) scheme: Scheme,
    pub(super) trial: Trial,
    /// Time at the start \[s\].
    pub(super) time: f64,
    /// Its length \[s\].
    length: f64,
    /// Of the stiffness.
    matrix: &'a mut Matrix,
}

impl Total {
    /// Moves the state on by `h` \[s\], or by less where steps go by their error.
    pub(super) fn advance_implicitly(&mut self, model: &Model, state: &mut State, scheme: Scheme, h: f64) -> Result<(), StepError> {
        pace::advance(model, state, h, &mut |state: &mut State, h| self.solve_step(model, state, scheme, h))?;
        state.steps += 1;
        Ok(())
    }

    /// One step; a failed one leaves the state as it was.
    pub(super) fn solve_step(&mut self, model: &Model, state: &mut State, scheme: Scheme, h: f64) -> Result<(), Failure<StepError>> {
        if model.remembers_acceleration && state.nodes.acceleration.is_empty() {
            self.initial_acceleration(model, state).map_err(Failure::Trouble)?;
        }
        let mut matrix = match self.matrix.take() {
            Some(matrix) => matrix,
            None => self.pattern(model),
        };
        let solved = self.solve_balance(model, state, scheme, h, &mut matrix);
        self.matrix = Some(matrix);
        solved
    }

    fn solve_balance(
        &mut self,
        model: &Model,
        state: &mut State,
        scheme: Scheme,
        h: f64,
        matrix: &mut Matrix,
    ) -> Result<(), Failure<StepError>> {
        let (time, d) = (state.time, model.dimension);
        let start = state.nodes.displacement.clone();
        // where the held nodes go, and how fast they are on the mean
        let mut prescribed = vec![[0.0; 3]; start.len()];
        for held in &self.held {
            let velocity = |t: f64| model.boundaries[held.boundary].velocity(held.axis, t).unwrap_or(0.0);
            let ends = velocity(time) + velocity(time + h);
            prescribed[held.node][held.axis] =
                if scheme.is_conserving() { 0.5 * h * ends } else { h / 6.0 * (ends + 4.0 * velocity(time + 0.5 * h)) };
        }
        self.spread(&mut prescribed);
        let moves = prescribed.iter().flatten().any(|v| *v != 0.0);
        // the unknown is what the step adds: round-off of the displacement of a body that has travelled far would drown its inertia
        let mut guess = vec![[0.0; 3]; start.len()];
        if scheme.has_inertia() {
            for (u, v) in guess.iter_mut().zip(&state.nodes.velocity) {
                *u = v.map(|v| h * v);
            }
            for held in &self.held {
                guess[held.node][held.axis] = 0.0;
            }
            self.spread(&mut guess);
        }
        let before = if scheme.has_inertia() || !model.needs.work { Vec::new() } else { self.supports(model, state, time)? };
        let pulled = self.pulls.clone();
        let rules = model.newton;
        let mut step = Step::new(self, model, state, scheme, h, matrix);
        // a guess too far may invert particles: then from the start
        if step.residual(&guess).is_err() {
            guess.fill([0.0; 3]);
        }
        if moves {
            step.follow(&prescribed, &mut guess)?;
        }
        let (residual, history) = newton(&mut step, rules, &mut guess)?;
        self.iterations += history.len() as u64 - 1;
        self.residuals = history;
        let (velocity, acceleration) = self.ends(model, state, scheme, h, &guess);
        self.judge(model, state, scheme, h, &acceleration).map_err(Failure::Trouble)?;

        if !scheme.has_inertia() {
            // there is no mean over a time that does not count: the last balance is it
            self.impulse.fill([0.0; 3]);
            self.kicked = 0.0;
        }
        for held in &self.held {
            self.impulse[held.boundary][held.axis] += h * residual.supports[held.node][held.axis];
        }
        if !self.surfaces.is_empty() {
            let now = std::mem::take(&mut self.pulls);
            // where there is no inertia, work is done by the mean of both ends, as with loads
            let mean =
                |(b, now): (usize, &[f64; 3])| pulled.get(b).map_or(*now, |start| std::array::from_fn(|a| 0.5 * (start[a] + now[a])));
            let working = if scheme.has_inertia() { now.clone() } else { now.iter().enumerate().map(mean).collect() };
            self.reap(model, state, [&now, &working], [time, time + h]);
        }
        self.kicked += h;
        if model.needs.work {
            // what acts on the nodes, as in `supports`: at the time of the balance, or the mean of both ends where there is no inertia
            for (node, (load, support)) in residual.loads.iter().zip(&residual.supports).enumerate() {
                for a in 0..d {
                    let force = load[a] + support[a];
                    let mean = before.get(node).map_or(force, |before: &[f64; 3]| 0.5 * (force + before[a]));
                    state.external_work += mean * guess[node][a];
                }
            }
        }
        let acceleration = if model.remembers_acceleration { acceleration } else { Vec::new() };
        let displacement = start.iter().zip(&guess).map(|(start, moved)| std::array::from_fn(|a| start[a] + moved[a])).collect();
        state.nodes = Nodes { displacement, velocity, acceleration };
        state.time = time + h;
        self.internal.clear();
        self.update(model, state, state.time).map_err(Failure::Trouble)
    }

    /// Velocities and accelerations of the nodes at the end of a step, by its displacement.
    fn ends(&self, model: &Model, state: &State, scheme: Scheme, h: f64, moved: &Vectors) -> (Vectors, Vectors) {
        let nodes = &state.nodes;
        let (mut velocity, mut acceleration) = (vec![[0.0; 3]; moved.len()], vec![[0.0; 3]; moved.len()]);
        for (node, moved) in moved.iter().enumerate() {
            for a in 0..model.dimension {
                let before = nodes.acceleration.get(node).map_or(0.0, |all| all[a]);
                [velocity[node][a], acceleration[node][a]] = scheme.end(h, moved[a], nodes.velocity[node][a], before);
            }
        }
        for held in &self.held {
            let given = model.boundaries[held.boundary].velocity(held.axis, state.time + h).unwrap_or(0.0);
            velocity[held.node][held.axis] = if scheme.has_inertia() { given } else { 0.0 };
        }
        self.spread(&mut velocity);
        (velocity, acceleration)
    }

    /// Forces that act on the nodes at the start of a quasi-static step \[N\]: loads, and supports that meet them.
    fn supports(&mut self, model: &Model, state: &mut State, time: f64) -> Result<Vectors, Failure<StepError>> {
        self.forces(model, state, time).map_err(Failure::Trouble)?;
        let mut acting = self.external.clone();
        for held in &self.held {
            acting[held.node][held.axis] = -self.internal[held.node][held.axis];
        }
        Ok(acting)
    }

    /// Acceleration of the nodes at time 0, from the forces there.
    pub(super) fn initial_acceleration(&mut self, model: &Model, state: &mut State) -> Result<(), StepError> {
        self.forces(model, state, state.time)?;
        let total: Vectors = self.internal.iter().zip(&self.external).map(|(i, e)| std::array::from_fn(|a| i[a] + e[a])).collect();
        let mut acceleration = vec![[0.0; 3]; total.len()];
        self.solve(model, &total, &mut acceleration);
        state.nodes.acceleration = acceleration;
        Ok(())
    }

    /// The pattern of the stiffness: nodes of the same cell are coupled.
    pub(super) fn pattern(&self, model: &Model) -> Matrix {
        let held: std::collections::HashSet<(usize, usize)> = self.held.iter().map(|h| (h.node, h.axis)).collect();
        let cells: Vec<Vec<u32>> = self.bodies.iter().flat_map(|body| body.reference.cells()).collect();
        Matrix::new(self.acceleration.len(), model.dimension, cells.iter().map(Vec::as_slice), |node, axis| held.contains(&(node, axis)))
    }
}

impl<'a> Step<'a> {
    pub(super) fn new(
        total: &'a mut Total,
        model: &'a Model,
        state: &'a State,
        scheme: Scheme,
        length: f64,
        matrix: &'a mut Matrix,
    ) -> Self {
        Self { total, model, state, scheme, trial: scheme.trial(length), time: state.time, length, matrix }
    }

    /// Displacement of the nodes after this share of the step.
    pub(super) fn at(&self, moved: &[[f64; 3]], share: f64) -> Vectors {
        let start = &self.state.nodes.displacement;
        moved.iter().zip(start).map(|(moved, start)| std::array::from_fn(|a| start[a] + share * moved[a])).collect()
    }

    /// Carries a guess along with nodes whose displacement is prescribed, by one linear solve.
    fn follow(&mut self, prescribed: &[[f64; 3]], guess: &mut Vectors) -> Result<(), Failure<StepError>> {
        let add = |u: &[[f64; 3]], share: f64, v: &[[f64; 3]]| -> Vectors {
            u.iter().zip(v).map(|(u, v)| std::array::from_fn(|a| u[a] + share * v[a])).collect()
        };
        let here = self.residual(guess).map_err(Failure::Trouble)?;
        let there = self.residual(&add(guess, SMALL, prescribed)).map_err(Failure::Trouble)?;
        let change = add(&there.forces, -1.0, &here.forces);
        let forces = add(&here.forces, 1.0 / SMALL, &change);
        let Some(correction) = self.correction(guess, &forces).map_err(Failure::Trouble)? else {
            return Err(Failure::NoConvergence(Vec::new()));
        };
        *guess = add(&add(guess, 1.0, prescribed), 1.0, &correction);
        Ok(())
    }

    /// Makes the stiffness after a displacement; tells whether it is symmetric.
    pub(super) fn stiffen(&mut self, moved: &[[f64; 3]]) -> Result<bool, StepError> {
        self.matrix.clear();
        let inner = self.at(moved, self.trial.inner);
        let (stiffness, share) = (self.total.sweeps.stiffness, self.trial.inner);
        for part in &self.total.parts {
            let task = self.total.task(self.model, part, &inner, self.scheme.is_conserving());
            let summed = stiffness(&task, &self.state.particles, share, self.matrix);
            summed.map_err(|trouble| self.total.explain(self.model, self.state, self.time, &trouble))?;
        }
        let outer = self.at(moved, self.trial.outer);
        let time = self.time + self.trial.time * self.length;
        let follows = self.total.load_stiffness(self.model, self.state, time, &outer, self.trial.outer, self.matrix)?;
        self.total.pull_stiffness(self.model, self.state, time, &outer, self.trial.outer, self.matrix)?;
        let by_moved = self.trial.acceleration[0];
        if self.scheme.has_inertia() {
            for body in &self.total.bodies {
                let nodes = body.reference.start..body.reference.start + body.reference.len();
                self.matrix.add_scalar(|i, j| {
                    let both = nodes.contains(&i) && nodes.contains(&j);
                    if both { by_moved * body.mass.entry(i - nodes.start, j - nodes.start) } else { 0.0 }
                });
            }
        }
        // a law without a stored energy has no symmetric tangent
        let stores = self.model.bodies.iter().all(|body| body.material.has_potential());
        Ok(stores && !follows && !self.scheme.is_conserving())
    }
}

impl Balance for Step<'_> {
    type Trouble = StepError;

    fn residual(&mut self, moved: &[[f64; 3]]) -> Result<Residual, StepError> {
        let n = moved.len();
        let d = self.model.dimension;
        let mut internal = vec![[0.0; 3]; n];
        let inner = self.at(moved, self.trial.inner);
        for part in &self.total.parts {
            let task = self.total.task(self.model, part, &inner, self.scheme.is_conserving());
            let summed = (self.total.sweeps.force)(&task, &self.state.particles, &mut internal);
            summed.map_err(|trouble| self.total.explain(self.model, self.state, self.time, &trouble))?;
        }
        let outer = self.at(moved, self.trial.outer);
        let time = self.time + self.trial.time * self.length;
        self.total.pulls = self.total.pull(self.model, self.state, time, &outer, &mut internal)?;
        self.total.fold(&mut internal);
        let mut loads = vec![[0.0; 3]; n];
        self.total.load(self.model, self.state, time, &outer, &mut loads)?;
        let mut forces: Vectors = internal.iter().zip(&loads).map(|(i, e)| std::array::from_fn(|a| i[a] + e[a])).collect();
        let norm = |v: &[[f64; 3]]| v.iter().flatten().map(|v| v * v).sum::<f64>().sqrt();
        let mut size = norm(&internal).max(norm(&loads));
        if self.scheme.has_inertia() {
            let [by_moved, by_velocity, by_acceleration] = self.trial.acceleration;
            let nodes = &self.state.nodes;
            let mut acceleration = vec![[0.0; 3]; n];
            for node in 0..n {
                for a in 0..d {
                    acceleration[node][a] = by_moved * moved[node][a]
                        + by_velocity * nodes.velocity[node][a]
                        + by_acceleration * nodes.acceleration.get(node).map_or(0.0, |all| all[a]);
                }
            }
            for held in &self.total.held {
                let velocity = |t: f64| self.model.boundaries[held.boundary].velocity(held.axis, t).unwrap_or(0.0);
                acceleration[held.node][held.axis] = (velocity(self.time + self.length) - velocity(self.time)) / self.length;
            }
            let inertia = self.total.times(self.model, &acceleration);
            size = size.max(norm(&inertia));
            for (force, inertia) in forces.iter_mut().zip(&inertia) {
                (0..d).for_each(|a| force[a] -= inertia[a]);
            }
        }
        let mut supports = vec![[0.0; 3]; n];
        for held in &self.total.held {
            let force = &mut forces[held.node][held.axis];
            supports[held.node][held.axis] = -std::mem::take(force);
        }
        Ok(Residual { forces, supports, loads, size })
    }

    fn correction(&mut self, moved: &[[f64; 3]], forces: &[[f64; 3]]) -> Result<Option<Vectors>, StepError> {
        if self.total.iterates(self.model, self.scheme)
            && let Some(correction) = self.iterate(moved, forces)?
        {
            return Ok(Some(correction));
        }
        let symmetric = self.stiffen(moved)?;
        let Some(factor) = self.matrix.factor(symmetric) else { return Ok(None) };
        let mut x: Vec<f64> = self.matrix.components().map(|(node, a)| forces[node][a]).collect();
        factor.solve(&mut x);
        let mut correction = vec![[0.0; 3]; moved.len()];
        for ((node, a), x) in self.matrix.components().zip(x) {
            correction[node][a] = x;
        }
        self.total.spread(&mut correction);
        Ok(Some(correction))
    }
}
