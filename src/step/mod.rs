//! 5 ONE STEP of the explicit updated-Lagrangian method, one file a stage, in running order:
//!
//! 1. [`locate`]: which cells are the particles in; sort them and activate blocks where that has changed much
//! 2. [`load`]: body forces, surface loads, in the configuration and at the time of the state
//! 3. [`p2g`]: mass, momentum and forces from the particles to the grid, and from quadrature points ([`integrate`])
//! 4. [`balance`]: velocity and acceleration of the nodes by the [`mass`] matrix, boundaries
//! 5. [`contact`]: bodies that meet
//! 6. [`g2p`]: velocity, position, deformation and stress of the particles; and, one step having followed another, their sums for it
//!
//! The step is a leapfrog: positions and stresses live at the time of the state, velocities half a step before it. The kick is half the
//! last step and half the coming one, so the first one is half a kick and free fall is exact.

mod balance;
mod contact;
mod direct;
mod edge;
mod extend;
mod g2p;
mod integrate;
pub(crate) mod limit;
pub(crate) mod load;
mod locate;
mod mass;
pub(crate) mod measure;
mod p2g;
mod pass;
mod side;
#[cfg(test)]
mod slivers;
mod sparse;
mod wrong;

pub(crate) use wrong::Wrong;

use crate::component::{Fallback, StepError};
use crate::grid::{Grid, Lanes};
use crate::model::Model;
use crate::scene::Integrator;
use crate::state::State;
use crate::transfer::{Kernels, StencilRows, What};
use integrate::{Integration, Rule};

/// Kernels and scratch memory of a running scene: nothing in it is needed for a restart.
pub(crate) struct Stepper {
    pub(super) kernels: Kernels,
    pub(crate) grid: Grid,
    /// Body force of each particle \[m/s2\] by axis; empty where all have the same.
    body_force: Vec<Vec<f64>>,
    /// Acceleration of everything \[m/s2\].
    gravity: [f64; 3],
    /// Surface and point loads of this step.
    surface: Vec<load::PointLoad>,
    /// Place in memory by particle id; empty until asked for, and once particles were sorted.
    lookup: Vec<u32>,
    /// Impulse of each boundary on the bodies since the last call of `begin` \[N s\].
    impulse: Vec<[f64; 3]>,
    /// Length of all kicks since the last call of `begin` \[s\].
    kicked: f64,
    /// Work of moving boundaries over this step \[J\].
    boundary_work: f64,
    /// What the particles already gave to the coming projection or step, if anything.
    sums: Option<What>,
    rows: StencilRows,
    integration: Integration,
    matrix: mass::MassMatrix,
    /// Whether the mass matrix is that of the particles where they are.
    matrix_is_current: bool,
    /// Integrals of the functions of the nodes, over that of one in the middle of the grid.
    shares: Vec<f64>,
    /// Right-hand side of a mass matrix.
    right: Vec<Lanes>,
    /// A mass matrix times a field.
    product: Vec<Lanes>,
    /// Nodes at which bodies pushed each other in the last step.
    contacts: usize,
    /// What is done wrong on purpose.
    pub(crate) wrong: Option<Wrong>,
    /// Iterations of the solver of the mass matrix since the last call of `begin`.
    pub(crate) iterations: u64,
}

impl Stepper {
    pub(crate) fn new(model: &Model) -> Self {
        Self {
            kernels: Kernels::new(model.dimension, model.axes[0].width(), model.precision),
            grid: Grid::new(model),
            body_force: Vec::new(),
            gravity: [0.0; 3],
            surface: Vec::new(),
            lookup: Vec::new(),
            impulse: Vec::new(),
            kicked: 0.0,
            boundary_work: 0.0,
            sums: None,
            rows: StencilRows::default(),
            integration: Integration::new(model),
            matrix: mass::MassMatrix::default(),
            matrix_is_current: false,
            shares: Vec::new(),
            right: Vec::new(),
            product: Vec::new(),
            contacts: 0,
            wrong: None,
            iterations: 0,
        }
    }

    /// Forgets what belongs to another state.
    pub(crate) fn forget(&mut self, model: &Model) {
        *self = Self { wrong: self.wrong, ..Self::new(model) };
    }

    /// Starts to add up boundary reactions.
    pub(crate) fn begin(&mut self, model: &Model) {
        self.impulse.clear();
        self.impulse.resize(model.boundaries.len(), [0.0; 3]);
        self.kicked = 0.0;
        self.iterations = 0;
    }

    /// Mean force of each boundary on the bodies since [`Stepper::begin`] \[N\]: impulse over the length of the kicks it acted in.
    pub(crate) fn mean_reactions(&self) -> impl Iterator<Item = [f64; 3]> {
        self.impulse.iter().map(|impulse| impulse.map(|i| i / self.kicked))
    }

    /// Where the last step fell back to a lower order.
    pub(crate) fn fallback(&self) -> Fallback {
        let Integration { bodies, extender, .. } = &self.integration;
        let cells = bodies.iter().map(|body| if let Rule::Cells(cells) = &body.rule { cells.left_cells() } else { 0 }).sum();
        Fallback { cells, nodes: extender.ragged.len(), contacts: self.contacts }
    }

    /// One step of length `dt` \[s\], and what can be done for the `next` in passing. On an error the state is spoilt; the caller holds a copy.
    pub(crate) fn advance(&mut self, model: &Model, state: &mut State, dt: f64, next: Option<Next>) -> Result<(), StepError> {
        use g2p::Update;
        let kick = 0.5 * (state.last_step + dt);
        let sums = self.sums_of(model, kick);
        let coming = next.map(|next| self.sums_of(model, 0.5 * (dt + next.dt)));
        let seen = !next.is_some_and(|next| next.at_once);
        if self.sums.take() == Some(sums) {
            self.load(model, state)?;
            self.take_over_sums(model, state, sums)?;
        } else {
            self.locate(model, state)?;
            self.load(model, state)?;
            self.particles_to_grid(model, state, sums)?;
        }
        self.balance(model, state, sums, dt, model.needs_nodal_velocity())?;
        self.contact(model, Some(kick));
        self.leave_to_light_nodes(model);
        self.mark_held_nodes(model);
        self.grid.spread_tied(true);
        if model.needs.work {
            state.external_work += self.side_work(kick, dt);
        }
        match model.integrator {
            Integrator::Usl => {
                self.grid_to_particles(model, state, &Update { kick: Some(kick), drift: Some(dt), strain: Some(dt), seen }, coming)?;
            }
            Integrator::Usf => {
                let all = Some(What::MassMomentum);
                self.grid_to_particles(model, state, &Update { kick: Some(kick), drift: Some(dt), strain: None, seen }, all)?;
                if self.sums.is_none() {
                    self.locate(model, state)?;
                }
                self.project(model, state, state.time + 0.5 * dt)?;
                self.grid_to_particles(model, state, &Update { kick: None, drift: None, strain: Some(dt), seen }, coming)?;
            }
            // MUSL: the check leaves only these three to explicit steps of the updated formulation
            _ => {
                let all = Some(What::MassMomentum);
                self.grid_to_particles(model, state, &Update { kick: Some(kick), drift: None, strain: None, seen }, all)?;
                self.project(model, state, state.time + 0.5 * dt)?;
                self.grid_to_particles(model, state, &Update { kick: None, drift: Some(dt), strain: Some(dt), seen }, coming)?;
            }
        }
        self.close_work(model, state);
        self.kicked += kick;
        state.last_step = dt;
        state.time += dt;
        state.steps += 1;
        Ok(())
    }
}

/// The step that follows one, for all that is known.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Next {
    /// Its length \[s\].
    pub(crate) dt: f64,
    /// Whether nobody looks at the state before it.
    pub(crate) at_once: bool,
}

/// Particles below which a loop is not worth sharing between threads.
const WORTH_SHARING: usize = 4096;

pub(crate) fn worth_sharing(state: &State) -> bool {
    state.particles.len() >= WORTH_SHARING && rayon::current_num_threads() > 1
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lanes::Instructions;
    use crate::scene::{Precision, Scene};
    use crate::state::Particles;
    use crate::transfer::WIDEST_SINGLE;

    /// The kernels for this CPU and those for any CPU do the same but for round-off.
    #[test]
    fn wide_and_portable_kernels_agree() {
        for (dimension, degree, transfer) in [
            (1, 1, "flip"),
            (1, 4, "apic"),
            (2, 2, "apic"),
            (2, 3, "flip"),
            (3, 1, "pic"),
            (3, 2, "apic"),
            (3, 5, "flip"),
            (2, 3, "asflip"),
            (3, 2, "asflip"),
        ] {
            let list = |v: f64| format!("{:?}", vec![v; dimension]);
            let velocity = ["\"0.3*sin(3*x)\"", "\"0.2*cos(2*x)\"", "0.1"][..dimension].join(", ");
            let integrator = if transfer == "asflip" { "usl" } else { "musl" };
            let text = format!(
                r#"
                title = "twins"
                dimension = {dimension}
                grid = {{ origin = {}, size = {}, cell = 0.25 }}
                material.m = {{ law = "neo_hookean", young = 1e3, poisson = 0.3, density = 10 }}
                method = {{ basis = "bspline", degree = {degree}, transfer = "{transfer}", integrator = "{integrator}" }}
                boundary.wall = {{ face = "x-", fixed = ["x"] }}
                body.b = {{ material = "m", shape = {{ box = {{ min = {}, max = {} }} }}, positions = "jittered", velocity = [{velocity}] }}
                time = {{ end = 1 }}
                "#,
                list(0.0),
                list(3.0),
                list(0.0),
                list(1.0),
            );
            let run = |kernels: Kernels| {
                let (model, mut state) = Model::new(&Scene::from_toml(&text).unwrap()).unwrap();
                let mut stepper = Stepper { kernels, ..Stepper::new(&model) };
                stepper.begin(&model);
                for _ in 0..50 {
                    stepper.advance(&model, &mut state, 2e-3, None).unwrap();
                }
                state.particles
            };
            let with = |precision, instructions| run(Kernels::with(dimension, degree + 1, precision, instructions));
            let apart = |a: &Particles, b: &Particles| {
                let of = |axis: usize| a.position.column(axis).iter().zip(b.position.column(axis)).map(|(a, b)| (a - b).abs());
                (0..dimension).flat_map(of).fold(0.0, f64::max)
            };
            let (wide, portable) =
                (run(Kernels::new(dimension, degree + 1, Precision::Double)), with(Precision::Double, Instructions::Plain));
            // round-off of 50 steps
            let error = apart(&wide, &portable);
            assert!(error < 1e-12, "{dimension}D degree {degree} {transfer}: {error}");
            if degree < WIDEST_SINGLE {
                // particles move by 0.03; 50 steps with a round-off of 6e-8 each, as slopes and stresses pass it on
                for instructions in [Instructions::of_this_cpu(), Instructions::Plain] {
                    let error = apart(&wide, &with(Precision::Single, instructions));
                    assert!(error > 1e-12 && error < 1e-7, "{dimension}D degree {degree} {transfer}, single, {instructions:?}: {error}");
                }
            }
        }
    }
}
