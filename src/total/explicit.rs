//! ONE EXPLICIT STEP of the total-Lagrangian method.
//!
//! A step is a composition of kicks, v += b dt a(u), and drifts, u += c dt v: velocity Verlet, or a scheme of fourth order. Both are
//! symplectic, and nothing is projected, so that energy has no drift.

use super::Total;
use super::reference::Vectors;
use crate::component::StepError;
use crate::material::Material;
use crate::model::Model;
use crate::scene::Integrator;
use crate::state::{Shown, State};
use nalgebra::Matrix3;

/// Kicks and drifts of a step, as shares of it: kick, drift, kick, drift, ..., kick.
pub(super) struct Scheme {
    pub(super) kicks: &'static [f64],
    pub(super) drifts: &'static [f64],
}

pub(super) const VERLET: Scheme = Scheme { kicks: &[0.5, 0.5], drifts: &[1.0] };

/// Blanes and Moan 2002, Practical symplectic partitioned Runge-Kutta and Runge-Kutta-Nystroem methods, table 3, SRKN6b of order 4.
pub(super) const FOURTH_ORDER: Scheme = {
    const B: [f64; 3] = [0.082_984_406_417_405_2, 0.396_309_801_498_368, -0.039_056_304_922_348_6];
    const C: [f64; 2] = [0.245_298_957_184_271, 0.604_872_665_711_08];
    const MIDDLE_KICK: f64 = 1.0 - 2.0 * (B[0] + B[1] + B[2]);
    const MIDDLE_DRIFT: f64 = 0.5 - (C[0] + C[1]);
    Scheme { kicks: &[B[0], B[1], B[2], MIDDLE_KICK, B[2], B[1], B[0]], drifts: &[C[0], C[1], MIDDLE_DRIFT, MIDDLE_DRIFT, C[1], C[0]] }
};

impl Scheme {
    pub(super) fn of(integrator: Integrator) -> &'static Self {
        if integrator == Integrator::Symplectic4 { &FOURTH_ORDER } else { &VERLET }
    }
}

impl Total {
    /// One step of length `dt` \[s\]. On an error the state is spoilt; the caller holds a copy.
    pub(super) fn advance_explicitly(&mut self, model: &Model, state: &mut State, dt: f64) -> Result<(), StepError> {
        let Scheme { kicks, drifts } = self.scheme;
        // displacements and velocities are at different times between kicks and drifts
        let (start, mut at, mut velocity_at) = (state.time, 0.0, 0.0);
        for (k, share) in kicks.iter().enumerate() {
            let end = if k + 1 == kicks.len() { 1.0 } else { velocity_at + share };
            self.kick(model, state, start + at * dt, [start + velocity_at * dt, start + end * dt])?;
            velocity_at = end;
            if let Some(share) = drifts.get(k) {
                at += share;
                let nodes = &mut state.nodes;
                if let Some(fast) = &self.fast {
                    fast.drift(share * dt, &nodes.velocity, &mut nodes.displacement);
                    state.shown = Shown::Behind;
                } else {
                    for (u, v) in nodes.displacement.iter_mut().zip(&nodes.velocity) {
                        for a in 0..3 {
                            u[a] += share * dt * v[a];
                        }
                    }
                }
                self.internal.clear();
            }
        }
        self.check_velocities(model, state, start)?;
        state.last_step = dt;
        state.time = start + dt;
        state.steps += 1;
        self.keep_pace(model, state);
        Ok(())
    }

    /// Accelerates the nodes by the forces at `time`, from one time to another.
    fn kick(&mut self, model: &Model, state: &mut State, time: f64, [from, to]: [f64; 2]) -> Result<(), StepError> {
        let h = to - from;
        self.forces(model, state, time)?;
        if self.fast.is_some() {
            self.kick_nodes(model, state, [from, to]);
            return Ok(());
        }
        let total: Vectors = self.internal.iter().zip(&self.external).map(|(i, e)| std::array::from_fn(|a| i[a] + e[a])).collect();
        let mut acceleration = std::mem::take(&mut self.acceleration);
        acceleration.fill([0.0; 3]);
        for held in &self.held {
            let velocity = |t: f64| model.boundaries[held.boundary].velocity(held.axis, t).unwrap_or(0.0);
            acceleration[held.node][held.axis] = (velocity(to) - velocity(from)) / h;
        }
        self.solve(model, &total, &mut acceleration);
        if !self.surfaces.is_empty() {
            let pulls = self.pulls.clone();
            self.reap(model, state, [&pulls, &pulls], [from, to]);
        }
        let velocity = &mut state.nodes.velocity;
        // what a force does in a kick is the mean of the velocities before and after
        let path = |node: usize, a: usize, velocity: &Vectors| h * (velocity[node][a] + 0.5 * h * acceleration[node][a]);
        if model.needs.work {
            for (node, force) in self.external.iter().enumerate() {
                for a in 0..model.dimension {
                    state.external_work += force[a] * path(node, a, velocity);
                }
            }
        }
        if !self.held.is_empty() {
            let pulled = self.times(model, &acceleration);
            for held in &self.held {
                let reaction = pulled[held.node][held.axis] - total[held.node][held.axis];
                self.impulse[held.boundary][held.axis] += h * reaction;
                state.external_work += reaction * path(held.node, held.axis, velocity);
            }
        }
        for (v, a) in velocity.iter_mut().zip(&acceleration) {
            for k in 0..3 {
                v[k] += h * a[k];
            }
        }
        for held in &self.held {
            velocity[held.node][held.axis] = model.boundaries[held.boundary].velocity(held.axis, to).unwrap_or(0.0);
        }
        self.acceleration = acceleration;
        self.kicked += h;
        Ok(())
    }

    /// How much of the stable step is left: stiffness seen from time 0.
    pub(super) fn keep_pace(&mut self, model: &Model, state: &mut State) {
        if !matches!(model.pace, crate::model::Pace::Cfl(_)) {
            return;
        }
        if let Some(fast) = &self.fast {
            state.pace = fast.pace().clamp(f64::MIN_POSITIVE, 1.0);
            return;
        }
        let d = model.dimension;
        let mut pace = 1.0f64;
        for p in 0..state.particles.len() {
            let f = crate::step::load::deformation(d, state, p);
            let material = model.material(state.particles.body[p]);
            let ratio = steepness(material, &f);
            pace = pace.min(1.0 / ratio.sqrt());
        }
        state.pace = pace.clamp(f64::MIN_POSITIVE, 1.0);
    }
}

/// Square of the ratio of the wave speed at a point, seen from time 0, to that at time 0 \[-\].
pub(super) fn steepness(material: &Material, f: &Matrix3<f64>) -> f64 {
    if matches!(material, Material::Linear(_)) {
        return 1.0;
    }
    // a wave along N at time 0 sees the modulus times |F^-T N|^2
    let inverse = f.try_inverse().unwrap_or_else(Matrix3::identity);
    let steep = inverse.norm_squared().min(1e12);
    material.wave_modulus(f) * (steep / 3.0).max(largest(&inverse)) / material.lame().wave_modulus()
}

/// Largest diagonal entry of A A^T: the square of the longest row.
fn largest(a: &Matrix3<f64>) -> f64 {
    (0..3).map(|r| a.row(r).norm_squared()).fold(0.0, f64::max)
}
