//! What is measured at the time of the state, only when somebody asks: energies, momenta, and velocities brought from the half step to
//! the time of the state by the acceleration there.

use super::balance::is_empty;
use super::load::{deformation, place_of};
use super::pass::pass;
use super::{Stepper, worth_sharing};
use crate::component::StepError;
use crate::model::Model;
use crate::state::{State, Table};
use crate::transfer::{GatherTask, Rows, Sweep, What};
use nalgebra::Vector3;

/// Measures of a state.
#[derive(Debug, Clone, Default)]
pub(crate) struct Measures {
    /// Velocity at the time of the state by place in memory \[m/s\].
    pub(crate) velocity: Table,
    /// Kinetic energy of the particles \[J\] (Andersen 2007, eq. 26).
    pub(crate) kinetic: f64,
    /// Stored energy of the particles \[J\].
    pub(crate) strain: f64,
    /// Kinetic energy of the nodes \[J\] (Andersen 2007, eq. 28).
    pub(crate) nodal_kinetic: f64,
    /// Momentum \[kg m/s\].
    pub(crate) linear: [f64; 3],
    /// Moment of momentum about the origin \[kg m2/s\], with the affine part of APIC.
    pub(crate) angular: [f64; 3],
    /// Velocity of each probe \[m/s\].
    pub(crate) probes: Vec<[f64; 3]>,
    /// Position of each probe \[m\]; empty where it hangs on its particle.
    pub(crate) places: Vec<[f64; 3]>,
}

impl Stepper {
    /// Measures the state, which stays as it is but for the order of its particles (which the next step would have set).
    pub(crate) fn measure(&mut self, model: &Model, state: &mut State) -> Result<Measures, StepError> {
        let dimension = model.dimension;
        let kick = 0.5 * state.last_step;
        self.locate(model, state)?;
        self.load(model, state)?;
        self.particles_to_grid(model, state, What::MassMomentumForce)?;
        let mut measures = Measures { velocity: state.particles.velocity.clone(), ..Measures::default() };
        measures.angular = self.angular_momentum(model, kick);
        let (impulse, work) = (self.impulse.clone(), self.boundary_work);
        self.impulse.resize(model.boundaries.len(), [0.0; 3]);
        let iterations = self.iterations;
        self.balance(model, state, What::MassMomentumForce, 0.0, true)?;
        self.contact(model, Some(kick));
        (self.impulse, self.boundary_work, self.iterations) = (impulse, work, iterations);
        measures.nodal_kinetic = self.nodal_kinetic_energy(model);
        self.grid.spread_tied(true);
        self.kick_velocity(model, state, kick, &mut measures.velocity);
        let particles = &state.particles;
        for p in 0..particles.len() {
            let v: [f64; 3] = measures.velocity.row(p);
            let mass = particles.mass[p];
            measures.kinetic += 0.5 * mass * v.iter().map(|v| v * v).sum::<f64>();
            for a in 0..dimension {
                measures.linear[a] += mass * v[a];
            }
            let f = deformation(dimension, state, p);
            measures.strain += particles.volume[p] * model.material(particles.body[p]).energy(&f, &particles.history.row(p));
        }
        self.probe_velocities(model, state, &mut measures);
        Ok(measures)
    }

    /// Force on a node along the first axis \[N\], from stresses, loads on particles and surfaces, but without what acts on all masses
    /// alike. The state stays as it is but for the order of its particles. `None` where nothing is near the node.
    pub(crate) fn nodal_force(&mut self, model: &Model, state: &mut State, node: [i32; 3]) -> Result<Option<f64>, StepError> {
        self.locate(model, state)?;
        self.load(model, state)?;
        self.particles_to_grid(model, state, What::MassMomentumForce)?;
        Ok(self.grid.node(0, node).map(|index| self.grid.force[index][1]))
    }

    /// Sum of x_i x p_i over the nodes: for linearly complete functions the moment of momentum of the particles.
    fn angular_momentum(&self, model: &Model, kick: f64) -> [f64; 3] {
        let dimension = model.dimension;
        let mut sum = Vector3::zeros();
        self.grid.for_nodes(|index, node| {
            let (momentum, force) = (&self.grid.momentum[index], &self.grid.force[index]);
            if is_empty(model, momentum[0]) {
                return;
            }
            let (mut x, mut p) = (Vector3::zeros(), Vector3::zeros());
            for a in 0..dimension {
                x[a] = model.axes[a].node_position(node[3 - dimension + a]);
                p[a] = momentum[1 + a] + kick * (force[1 + a] + momentum[0] * self.gravity[a]);
            }
            sum += x.cross(&p);
        });
        sum.into()
    }

    /// Adds the acceleration of the grid times `kick` to `velocity`.
    fn kick_velocity(&mut self, model: &Model, state: &mut State, kick: f64, velocity: &mut Table) {
        let shared = worth_sharing(state);
        let rows = Rows::new(&mut state.particles).with_velocity(velocity);
        let gather = GatherTask { kick: Some(kick), ..GatherTask::NOTHING };
        pass(&mut self.grid, &self.kernels, &state.bins, shared, &Sweep { model, rows, gather: Some(gather), scatter: None, tidy: false });
    }

    /// A probe moves like the Taylor expansion of the grid velocity around its particle.
    fn probe_velocities(&mut self, model: &Model, state: &State, measures: &mut Measures) {
        for probe in &model.probes {
            let host = self.lookup[probe.anchor.particle as usize] as usize;
            let x: [f64; 3] = state.particles.position.row(host);
            let (position, _) = place_of(model, state, &self.lookup, &probe.anchor);
            let (half, bin) = (model.half_lengths(&state.particles, host), state.bin_of(host));
            let mut velocity: [f64; 3] = measures.velocity.row(host);
            for (arm, sign) in [(position - Vector3::from(x), 1.0), (Vector3::zeros(), -1.0)] {
                self.kernels.point_weights(&model.axes, [x, half, arm.into()], &mut self.rows);
                for (node, weight) in self.rows.nodes.iter().zip(&self.rows.weights) {
                    let node = self.grid.node_of_bin(bin, &state.bins[bin], *node);
                    for a in 0..model.dimension {
                        velocity[a] += sign * weight * self.grid.momentum[node][1 + a];
                    }
                }
            }
            measures.probes.push(velocity);
        }
    }
}
