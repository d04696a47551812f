//! ONE IMPLICIT STEP of the updated-Lagrangian method: a step of the total-Lagrangian one whose reference is the configuration at its
//! start, on the grid of the scene, which forgets afterwards.

use super::mass::Mass;
use super::reference::Reference;
use super::{Body, Held, Part, Total, pace};
use crate::component::StepError;
use crate::implicit::{Failure, Scheme};
use crate::model::Model;
use crate::state::{Nodes, State};
use crate::step::Stepper;

/// Implicit steps of particles that move through a grid. Nothing in it is needed for a restart.
pub(crate) struct Updated {
    /// Sorts particles and measures states.
    pub(crate) stepper: Stepper,
    /// Impulse of each boundary since the last call of `begin` \[N s\].
    impulse: Vec<[f64; 3]>,
    kicked: f64,
    iterations: u64,
    residuals: Vec<f64>,
}

impl Updated {
    pub(crate) fn new(model: &Model) -> Self {
        Self { stepper: Stepper::new(model), impulse: Vec::new(), kicked: 0.0, iterations: 0, residuals: Vec::new() }
    }

    /// Starts to add up boundary reactions.
    pub(crate) fn begin(&mut self, model: &Model) {
        self.impulse.clear();
        self.impulse.resize(model.boundaries.len(), [0.0; 3]);
        (self.kicked, self.iterations) = (0.0, 0);
    }

    /// Mean force of each boundary on the bodies since [`Self::begin`] \[N\]; the last one where there is no inertia.
    pub(crate) fn mean_reactions(&self) -> impl Iterator<Item = [f64; 3]> {
        self.impulse.iter().map(|impulse| impulse.map(|i| i / self.kicked))
    }

    /// Iterations of Newton's method since [`Self::begin`].
    pub(crate) fn iterations(&self) -> u64 {
        self.iterations
    }

    /// Forces out of balance over those in balance, by iteration of the last solve.
    pub(crate) fn residuals(&self) -> &[f64] {
        &self.residuals
    }

    /// Moves the state on by `h` \[s\], or by less where steps go by their error.
    pub(crate) fn advance(&mut self, model: &Model, state: &mut State, scheme: Scheme, h: f64) -> Result<(), StepError> {
        pace::advance(model, state, h, &mut |state: &mut State, h| self.advance_once(model, state, scheme, h))?;
        state.steps += 1;
        Ok(())
    }

    fn advance_once(&mut self, model: &Model, state: &mut State, scheme: Scheme, h: f64) -> Result<(), Failure<StepError>> {
        self.stepper.locate(model, state).map_err(Failure::Trouble)?;
        let mut grid = Total::of_now(model, state, self.stepper.lookup(state).to_vec());
        grid.begin(model);
        let velocity = grid.project(model, state, &state.particles.velocity);
        let displacement = vec![[0.0; 3]; velocity.len()];
        let remembers = state.particles.acceleration.width() > 0;
        // at time 0 it comes from the forces
        let acceleration =
            if remembers && state.time > 0.0 { grid.project(model, state, &state.particles.acceleration) } else { Vec::new() };
        state.nodes = Nodes { displacement, velocity: velocity.clone(), acceleration };
        let solved = grid.solve_step(model, state, scheme, h);
        let nodes = std::mem::take(&mut state.nodes);
        solved?;

        if !scheme.has_inertia() {
            // there is no mean over a time that does not count: the last balance is it
            self.impulse.fill([0.0; 3]);
            self.kicked = 0.0;
        }
        for (sum, impulse) in self.impulse.iter_mut().zip(&grid.impulse) {
            (0..3).for_each(|a| sum[a] += impulse[a]);
        }
        self.kicked += grid.kicked;
        self.iterations += grid.iterations;
        self.residuals = std::mem::take(&mut grid.residuals);
        let reference = &grid.bodies[0].reference;
        for p in 0..state.particles.len() {
            let particles = &mut state.particles;
            let (mut place, old): ([f64; 3], [f64; 3]) = (particles.position.row(p), particles.velocity.row(p));
            let (mut new, mut gained, mut pull) = ([0.0; 3], [0.0; 3], [0.0; 3]);
            reference.each_slowly(&reference.particle(p), |node, weight, _| {
                for a in 0..model.dimension {
                    place[a] += weight * nodes.displacement[node][a];
                    new[a] += weight * nodes.velocity[node][a];
                    gained[a] += weight * (nodes.velocity[node][a] - velocity[node][a]);
                    pull[a] += nodes.acceleration.get(node).map_or(0.0, |all| weight * all[a]);
                }
            });
            let flip = if scheme.has_inertia() { model.flip_share } else { 0.0 };
            let speed: [f64; 3] = std::array::from_fn(|a| flip * (old[a] + gained[a]) + (1.0 - flip) * new[a]);
            particles.position.set_row(p, &place);
            particles.velocity.set_row(p, &speed);
            particles.acceleration.set_row(p, &pull);
        }
        // how far they moved nobody has asked
        state.order.is_stale = true;
        Ok(())
    }
}

impl Total {
    /// The grid of the scene with all particles where they are.
    pub(super) fn of_now(model: &Model, state: &State, lookup: Vec<u32>) -> Self {
        let particles = &state.particles;
        let places = (0..particles.len()).map(|p| particles.position.row(p));
        let reference = Reference::new(&model.axes, None, 0, places);
        let mut held = Vec::new();
        for i in 0..reference.len() {
            let index = reference.index(i);
            for axis in 0..model.dimension {
                let holds = |b: &crate::model::Boundary| b.holds_axis(axis) && b.holds(&model.axes, &index[..model.dimension]);
                if let Some(boundary) = model.boundaries.iter().rposition(holds) {
                    held.push(Held { body: 0, node: i, axis, boundary });
                }
            }
        }
        let mut parts: Vec<Part> = Vec::new();
        for (p, &body) in particles.body.iter().enumerate() {
            match parts.last_mut() {
                Some(part) if part.material == usize::from(body) => part.last = p + 1,
                _ => parts.push(Part { body: 0, material: usize::from(body), first: p, last: p + 1, offset: 0 }),
            }
        }
        let mass = Mass::new(model, &reference, &particles.mass, &held, None);
        Self::assemble(model, state, vec![Body { reference, mass }], parts, held, lookup, true)
    }
}
