//! ONE EXPLICIT STEP where all bodies have the fast sums of [`rows`](super::rows): only nodes move. Particles follow when somebody looks.

use super::force::Trouble;
use super::mass::{self, Mass};
use super::reference::Reference;
use super::rows::kick::{self, Push};
use super::rows::{Forces, Seen, Spread};
use super::{Body, Held, Total};
use crate::component::StepError;
use crate::material::point::Trouble as Why;
use crate::model::{Boundary, Model};
use crate::state::{Shown, State};
use nalgebra::Matrix3;
use std::ops::Range;

/// The fast sums of all bodies, and what a kick needs beside them.
pub(crate) struct Fast {
    bodies: Vec<Box<dyn Forces>>,
    spreads: Vec<Spread>,
    /// One over the lumped mass by node and component \[1/kg\], 0 where a boundary holds; empty where mass is not lumped.
    inverse: Vec<f64>,
    /// What the last sums have come across.
    seen: Seen,
    /// What the external forces at hand were computed from.
    known: Vec<f64>,
    /// Held nodes, body by body and axis by axis.
    sets: Vec<HeldSet>,
    /// Accelerations of the held nodes that those of all others at hand belong to \[m/s2\]; nothing where none are at hand.
    solved: Option<Vec<f64>>,
    /// Forces of the boundaries on held nodes with them \[N\].
    reactions: Vec<f64>,
    /// Velocities of the boundaries before and after a kick, by axis \[m/s\].
    ends: Vec<[[f64; 2]; 3]>,
    /// Velocities of the held nodes before a kick \[m/s\].
    before: Vec<f64>,
}

/// Nodes of a body that are held along an axis.
struct HeldSet {
    body: usize,
    axis: usize,
    /// Number of each among all that are held, and its place in the box around them.
    members: Vec<(usize, usize)>,
    /// The box of nodes around them.
    around: [Range<usize>; 3],
}

impl HeldSet {
    fn new(body: usize, axis: usize, reference: &Reference, held: &[Held]) -> Option<Self> {
        let mut is_held = vec![false; reference.len()];
        let own = || held.iter().enumerate().filter(|(_, held)| held.body == body && held.axis == axis);
        own().for_each(|(_, held)| is_held[held.node - reference.start] = true);
        let around = mass::bounds(&is_held, reference.counts);
        let [_, y, z] = [0, 1, 2].map(|a| around[a].len());
        let place = |held: &Held| {
            let [i, j, k] = reference.index(held.node - reference.start).map(|i| i as usize);
            ((i - around[0].start) * y + j - around[1].start) * z + k - around[2].start
        };
        let members: Vec<(usize, usize)> = own().map(|(number, held)| (number, place(held))).collect();
        (!members.is_empty()).then_some(Self { body, axis, members, around })
    }
}

impl Fast {
    pub(super) fn new(sums: Vec<(Box<dyn Forces>, Spread)>, grids: &[Body], held: &[Held], dimension: usize) -> Self {
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
        let set = |(body, axis): (usize, usize)| HeldSet::new(body, axis, &grids[body].reference, held);
        let sets = (0..grids.len()).flat_map(|body| (0..dimension).map(move |axis| (body, axis))).filter_map(set).collect();
        let (bodies, spreads) = sums.into_iter().unzip();
        Self {
            bodies,
            spreads,
            inverse,
            sets,
            solved: None,
            reactions: vec![0.0; held.len()],
            seen: Seen::nothing(false),
            known: Vec::new(),
            ends: Vec::new(),
            before: Vec::new(),
        }
    }

    /// Sets the internal forces of all bodies \[N\].
    fn set(&mut self, displacement: &[[f64; 3]], force: &mut [[f64; 3]], looks: bool) -> Seen {
        (self.seen, self.solved) = (Seen::nothing(looks), None);
        for body in &mut self.bodies {
            let seen = body.set(displacement, force, looks);
            self.seen.merge(&seen);
        }
        self.seen
    }

    /// Whether the external forces at hand are those of these values; if not, they soon will be.
    pub(super) fn knows(&mut self, values: Vec<f64>) -> bool {
        let knows = self.known == values;
        if !knows {
            (self.known, self.solved) = (values, None);
        }
        knows
    }

    /// Adds the forces of an acceleration of the particles of a body \[m/s2\], by number on its grid.
    pub(super) fn spread(&self, body: usize, accelerations: &[[f64; 3]], force: &mut [[f64; 3]]) {
        self.spreads[body].add(accelerations, force);
    }

    /// Ratio of the stable step to that at time 0.
    pub(super) fn pace(&self) -> f64 {
        self.seen.pace()
    }

    pub(super) fn forget(&mut self) {
        self.known.clear();
        self.solved = None;
    }

    pub(super) fn drift(&self, h: f64, velocity: &[[f64; 3]], displacement: &mut [[f64; 3]]) {
        kick::drift(h, velocity.as_flattened(), displacement.as_flattened_mut());
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

    /// Accelerates the nodes by the forces at hand, from one time to another: as [`kick`](Self::kick), in few passes over memory.
    pub(super) fn kick_nodes(&mut self, model: &Model, state: &mut State, [from, to]: [f64; 2]) {
        let Some(mut fast) = self.fast.take() else { return };
        let h = to - from;
        fast.ends.clear();
        let velocity = |boundary: &Boundary, axis: usize| [from, to].map(|t| boundary.velocity(axis, t).unwrap_or(0.0));
        fast.ends.extend(model.boundaries.iter().map(|boundary| [0, 1, 2].map(|axis| velocity(boundary, axis))));
        let ends = std::mem::take(&mut fast.ends);
        let gained = |held: &Held| {
            let [start, end] = ends[held.boundary][held.axis];
            (end - start) / h
        };
        if fast.inverse.is_empty() {
            let held: Vec<f64> = self.held.iter().map(gained).collect();
            if fast.solved.as_ref() != Some(&held) {
                self.accelerate(&mut fast, &held);
                fast.solved = Some(held);
            }
        } else {
            for (held, reaction) in self.held.iter().zip(&mut fast.reactions) {
                let mass = self.bodies[held.body].mass.lumped(held.node - self.bodies[held.body].reference.start);
                let force = self.internal[held.node][held.axis] + self.external[held.node][held.axis];
                *reaction = mass * gained(held) - force;
            }
        }
        let velocity = state.nodes.velocity.as_flattened_mut();
        fast.before.clear();
        fast.before.extend(self.held.iter().map(|held| velocity[3 * held.node + held.axis]));
        let external = if model.loads.is_empty() { &[] } else { self.external.as_flattened() };
        let push = if fast.inverse.is_empty() {
            Push::Accelerations(self.acceleration.as_flattened())
        } else {
            Push::Forces(self.internal.as_flattened(), &fast.inverse)
        };
        state.external_work += kick::kick(h, push, external, velocity);
        for ((held, before), reaction) in self.held.iter().zip(&fast.before).zip(&fast.reactions) {
            let at = 3 * held.node + held.axis;
            // in the pass above, held nodes kept their velocity
            let more = 0.5 * h * gained(held);
            let push = external.get(at).copied().unwrap_or(0.0);
            self.impulse[held.boundary][held.axis] += h * reaction;
            state.external_work += h * (reaction * (before + more) + push * more);
            velocity[at] = ends[held.boundary][held.axis][1];
        }
        self.kicked += h;
        fast.ends = ends;
        self.fast = Some(fast);
    }

    /// Solves the balance of momentum for the accelerations of free nodes; those of held ones stay 0.
    fn accelerate(&mut self, fast: &mut Fast, held: &[f64]) {
        let moves = held.iter().any(|a| *a != 0.0);
        for (number, body) in self.bodies.iter_mut().enumerate() {
            let nodes = body.reference.start..body.reference.start + body.reference.len();
            for a in 0..body.reference.axes.len() {
                let set = fast.sets.iter().find(|set| set.body == number && set.axis == a);
                let forces = self.internal[nodes.clone()].iter().zip(&self.external[nodes.clone()]);
                self.column.clear();
                self.column.extend(forces.map(|(internal, external)| internal[a] + external[a]));
                let known = |values: &mut [f64]| {
                    for (member, _) in set.iter().flat_map(|set| &set.members) {
                        values[self.held[*member].node - nodes.start] = held[*member];
                    }
                };
                let force: Vec<f64> = match set {
                    Some(set) => set.members.iter().map(|(member, _)| self.column[self.held[*member].node - nodes.start]).collect(),
                    None => Vec::new(),
                };
                if moves {
                    self.product.clear();
                    self.product.resize(nodes.len(), 0.0);
                    known(&mut self.product);
                    body.mass.times(&mut self.product);
                    self.column.iter_mut().zip(&self.product).for_each(|(f, held)| *f -= held);
                }
                body.mass.solve(a, &mut self.column);
                for (all, value) in self.acceleration[nodes.clone()].iter_mut().zip(&self.column) {
                    all[a] = *value;
                }
                if let Some(set) = set {
                    known(&mut self.column);
                    let pulled = body.mass.rows_times(&set.around, body.reference.counts, &self.column);
                    for ((member, place), force) in set.members.iter().zip(force) {
                        fast.reactions[*member] = pulled[*place] - force;
                        self.acceleration[self.held[*member].node][a] = 0.0;
                    }
                }
            }
        }
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
