//! ONE EXPLICIT STEP where all bodies have the fast sums of [`rows`](super::rows): only nodes move. Particles follow when somebody looks.

use super::force::Trouble;
use super::mass::Mass;
use super::reference::Reference;
use super::rows::{Forces, Seen, kick};
use super::wide::Instructions;
use super::{Body, Held, Total};
use crate::component::StepError;
use crate::material::point::Trouble as Why;
use crate::model::{Boundary, Model};
use crate::state::{Shown, State};
use nalgebra::Matrix3;

/// The fast sums of all bodies, and what a kick needs beside them.
pub(crate) struct Fast {
    bodies: Vec<Box<dyn Forces>>,
    instructions: Instructions,
    /// One over the lumped mass by node and component \[1/kg\], 0 where a boundary holds; empty where mass is not lumped.
    inverse: Vec<f64>,
    /// What the last sums have come across.
    seen: Seen,
    /// What the external forces at hand were computed from.
    known: Vec<f64>,
    /// Velocities of the boundaries before and after a kick, by axis \[m/s\].
    ends: Vec<[[f64; 2]; 3]>,
    /// Velocities of the held nodes before a kick \[m/s\].
    before: Vec<f64>,
}

impl Fast {
    pub(super) fn new(bodies: Vec<Box<dyn Forces>>, grids: &[Body], held: &[Held], dimension: usize, instructions: Instructions) -> Self {
        let mut inverse = Vec::new();
        for grid in grids {
            if let Mass::Lumped(masses) = &grid.mass {
                for mass in masses {
                    inverse.extend((0..3).map(|a| if a < dimension && *mass > 0.0 { 1.0 / mass } else { 0.0 }));
                }
            }
        }
        if !inverse.is_empty() {
            held.iter().for_each(|held| inverse[3 * held.node + held.axis] = 0.0);
        }
        Self { bodies, instructions, inverse, seen: Seen::nothing(false), known: Vec::new(), ends: Vec::new(), before: Vec::new() }
    }

    /// Sets the internal forces of all bodies \[N\].
    fn set(&mut self, displacement: &[[f64; 3]], force: &mut [[f64; 3]], looks: bool) -> Seen {
        self.seen = Seen::nothing(looks);
        for body in &mut self.bodies {
            let seen = body.set(displacement, force, looks);
            self.seen.merge(&seen);
        }
        self.seen
    }

    /// Whether the external forces at hand are those of these values; if not, they soon will be.
    pub(super) fn knows(&mut self, values: Vec<f64>) -> bool {
        let knows = self.known == values && !values.is_empty();
        self.known = values;
        knows
    }

    /// Ratio of the stable step to that at time 0.
    pub(super) fn pace(&self) -> f64 {
        self.seen.pace()
    }

    /// Whether masses are lumped.
    pub(super) fn is_lumped(&self) -> bool {
        !self.inverse.is_empty()
    }

    pub(super) fn forget(&mut self) {
        self.known.clear();
    }

    pub(super) fn drift(&self, h: f64, velocity: &[[f64; 3]], displacement: &mut [[f64; 3]]) {
        kick::drift(self.instructions, h, velocity.as_flattened(), displacement.as_flattened_mut());
    }
}

impl Total {
    /// Whether particles are shown only when somebody looks.
    pub(crate) fn shows_late(&self) -> bool {
        self.fast.is_some()
    }

    /// Sums the internal forces of all nodes; the particles stay where they are.
    pub(super) fn update_nodes(&mut self, model: &Model, state: &State, time: f64) -> Result<(), StepError> {
        let Some(fast) = &mut self.fast else { return Ok(()) };
        self.internal.resize(self.acceleration.len(), [0.0; 3]);
        let seen = fast.set(&state.nodes.displacement, &mut self.internal, matches!(model.pace, crate::model::Pace::Cfl(_)));
        if seen.good {
            return Ok(());
        }
        self.internal.clear();
        let trouble = self.worst(model, state);
        Err(self.explain(model, state, time, &trouble))
    }

    /// The first particle that has no answer; by the sums over particles.
    fn worst(&self, model: &Model, state: &State) -> Trouble {
        let mut unused = vec![[0.0; 3]; self.acceleration.len()];
        let (mut least, mut worst) = (f64::INFINITY, 0);
        for part in &self.parts {
            let task = self.task(model, part, &state.nodes.displacement, false);
            if let Err(trouble) = (self.sweeps.force)(&task, &state.particles, &mut unused) {
                return trouble;
            }
            for p in part.first..part.last {
                let det = self.deformation(state, part.body, p - part.offset).determinant();
                if det < least {
                    (least, worst) = (det, p);
                }
            }
        }
        // one that is on the edge: by the other sums it is just not inverted
        Trouble { particle: worst, why: Why::Inverted(least) }
    }

    /// Deformation gradient of a particle, by its number on its grid.
    fn deformation(&self, state: &State, body: usize, number: usize) -> Matrix3<f64> {
        let reference: &Reference = &self.bodies[body].reference;
        let mut f = Matrix3::identity();
        reference.each_slowly(&reference.particle(number), |node, _, slope| {
            for i in 0..3 {
                for k in 0..3 {
                    f[(i, k)] += state.nodes.displacement[node][i] * slope[k];
                }
            }
        });
        f
    }

    /// As [`kick`](Self::kick), where masses are lumped.
    pub(super) fn kick_lumped(&mut self, model: &Model, state: &mut State, [from, to]: [f64; 2]) {
        let Some(fast) = &mut self.fast else { return };
        let h = to - from;
        fast.ends.clear();
        let velocity = |boundary: &Boundary, axis: usize| [from, to].map(|t| boundary.velocity(axis, t).unwrap_or(0.0));
        fast.ends.extend(model.boundaries.iter().map(|boundary| [0, 1, 2].map(|axis| velocity(boundary, axis))));
        let velocity = state.nodes.velocity.as_flattened_mut();
        fast.before.clear();
        fast.before.extend(self.held.iter().map(|held| velocity[3 * held.node + held.axis]));
        let external = if model.loads.is_empty() { &[] } else { self.external.as_flattened() };
        let internal = self.internal.as_flattened();
        state.external_work += kick::kick(fast.instructions, h, &fast.inverse, internal, external, velocity);
        for (held, before) in self.held.iter().zip(&fast.before) {
            let [start, end] = fast.ends[held.boundary][held.axis];
            let acceleration = (end - start) / h;
            let at = 3 * held.node + held.axis;
            let push = external.get(at).copied().unwrap_or(0.0);
            let pull = self.bodies[held.body].mass.lumped(held.node - self.bodies[held.body].reference.start) * acceleration;
            let reaction = pull - (internal[at] + push);
            self.impulse[held.boundary][held.axis] += h * reaction;
            // so far the node was taken to keep its velocity
            state.external_work += h * (reaction * (before + 0.5 * h * acceleration) + push * 0.5 * h * acceleration);
            velocity[at] = end;
        }
        self.kicked += h;
    }

    /// Carries the particles to where the nodes have gone, if they are not there.
    pub(crate) fn catch_up(&mut self, model: &Model, state: &mut State) -> Result<(), StepError> {
        if state.shown != Shown::Behind {
            return Ok(());
        }
        let mut unused = vec![[0.0; 3]; self.acceleration.len()];
        // nothing of what was shown before has a say
        state.particles.lateral.columns_mut().for_each(|column| column.fill(1.0));
        for part in &self.parts {
            let task = self.task(model, part, &state.nodes.displacement, false);
            if let Err(trouble) = (self.sweeps.advance)(&task, &mut state.particles, &mut unused) {
                return Err(self.explain(model, state, state.time, &trouble));
            }
        }
        self.show(model, state);
        state.shown = Shown::Now;
        Ok(())
    }

    /// An error where a velocity is no number.
    pub(super) fn check_velocities(&self, model: &Model, state: &State, time: f64) -> Result<(), StepError> {
        let mut bad = false;
        for v in state.nodes.velocity.as_flattened() {
            bad |= !v.is_finite();
        }
        if !bad {
            return Ok(());
        }
        let stands_still = |p: &usize| self.at(*p, &state.nodes.velocity).iter().all(|v| v.is_finite());
        let particle = (0..state.particles.len()).find(|p| !stands_still(p)).unwrap_or_default();
        Err(StepError::NotFinite { time, particle, position: model.reference(particle as u32)[..model.dimension].to_vec() })
    }
}
