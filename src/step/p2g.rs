//! Stage 3: mass, momentum and forces from the particles to the grid, and the second projection of MUSL and USF.

use super::balance::{Field, is_empty};
use super::edge::Edges;
use super::pass::pass;
use super::{Stepper, Wrong, worth_sharing};
use crate::basis::BATCH;
use crate::component::StepError;
use crate::grid::{Grid, Tied};
use crate::model::Model;
use crate::state::State;
use crate::transfer::{Rows, ScatterTask, Sweep, What};

impl Stepper {
    pub(super) fn particles_to_grid(&mut self, model: &Model, state: &mut State, what: What) -> Result<(), StepError> {
        self.integrate(model, state)?;
        let scatter = ScatterTask {
            what,
            // where mass is integrated, so is what acts on it
            body_force: if model.quadrature_of_velocity { &[] } else { &self.body_force },
            relieved: self.integration.relieved(),
        };
        let shared = worth_sharing(state);
        let sweep = Sweep { model, rows: Rows::new(&mut state.particles), gather: None, scatter: Some(scatter), tidy: false };
        pass(&mut self.grid, &self.kernels, &state.bins, shared, &sweep);
        self.complete_sums(model, state, what)
    }

    /// Takes over the sums that the particles gave in the pass before.
    pub(super) fn take_over_sums(&mut self, model: &Model, state: &mut State, what: What) -> Result<(), StepError> {
        let Grid { momentum, force, next: [next_momentum, next_force], .. } = &mut self.grid;
        std::mem::swap(momentum, next_momentum);
        if what == What::MassMomentumForce {
            std::mem::swap(force, next_force);
        }
        self.complete_sums(model, state, what)
    }

    /// Adds what does not come from particles.
    fn complete_sums(&mut self, model: &Model, state: &mut State, what: What) -> Result<(), StepError> {
        let forces = what == What::MassMomentumForce;
        if what != What::MassMomentum {
            self.add_surface_forces(model, state, what);
        }
        if forces && Edges::is_needed(model) {
            self.add_side_forces(model, state)?;
        }
        self.grid.fold_tied(forces);
        if self.wrong == Some(Wrong::ProductMomentum) {
            let each = state.particles.mass[0];
            for lanes in &mut self.grid.momentum {
                let share = lanes[0] / each;
                lanes[1..].iter_mut().for_each(|p| *p *= share);
            }
        }
        if forces && model.needs.quadrature {
            self.add_point_forces(model, state);
        }
        if model.quadrature_of_velocity {
            self.assemble(model, state)?;
            self.sum_at_points(model, state, forces);
            if model.needs.extension {
                self.grid.fold_tied(forces);
            }
        }
        Ok(())
    }

    /// What a step sums whose kick has this length \[s\].
    pub(super) fn sums_of(&self, model: &Model, kick: f64) -> What {
        if model.merges() && self.wrong.is_none() { What::Kicked(kick) } else { What::MassMomentumForce }
    }

    /// Projects the velocity of the particles anew, M v = sum m v N, with the boundaries at `time`.
    pub(super) fn project(&mut self, model: &Model, state: &mut State, time: f64) -> Result<(), StepError> {
        if self.sums.take() == Some(What::MassMomentum) {
            self.take_over_sums(model, state, What::MassMomentum)?;
        } else {
            self.particles_to_grid(model, state, What::MassMomentum)?;
        }
        self.check_masses(model, time)?;
        if model.projection.is_lumped() {
            for lanes in &mut self.grid.momentum {
                let mass = lanes[0];
                if !is_empty(model, mass) {
                    let inverse = 1.0 / mass;
                    *lanes = [mass, lanes[1] * inverse, lanes[2] * inverse, lanes[3] * inverse];
                }
            }
        } else {
            self.assemble(model, state)?;
            let held = self.held(model, |boundary, axis| boundary.velocity(axis, time));
            let mut right = std::mem::take(&mut self.right);
            (*self.grid.momentum).clone_into(&mut right);
            if !model.walls.is_empty() {
                let wanted = self.wall_values(model, |boundary, axis, _| model.boundaries[boundary].velocity(axis, time).unwrap_or(0.0));
                self.matrix.add_walls(&wanted, &mut right);
            }
            self.solve(model.projection, time, &held, &right, Field::Momentum, model)?;
            self.right = right;
        }
        self.hold_velocity(model, time);
        self.contact(model, None);
        self.grid.spread_tied(false);
        Ok(())
    }

    /// Gathers the points of the mass matrix where they have moved.
    pub(super) fn assemble(&mut self, model: &Model, state: &mut State) -> Result<(), StepError> {
        if self.matrix_is_current {
            return Ok(());
        }
        if model.quadrature_of_velocity {
            self.assemble_points(model, state)?;
        } else {
            let Self { matrix, grid, kernels, rows, shares, .. } = self;
            grid.shares(&model.axes, shares);
            matrix.set(model, shares, &Tied::default(), |points, mass| {
                mass.extend_from_slice(&state.particles.mass);
                let particles = Rows::new(&mut state.particles);
                for (b, bin) in state.bins.iter().enumerate() {
                    for start in (bin.start as usize..bin.end as usize).step_by(BATCH) {
                        let end = (start + BATCH).min(bin.end as usize);
                        // SAFETY: nobody else uses the rows now, and they are below the number of particles.
                        let places = unsafe { particles.places_3(model, start, end) };
                        kernels.stencils(&model.axes, &places, end - start, rows);
                        points.push(rows, false, |node| Some(grid.node_of_bin(b, bin, node))).expect("every node of a bin is stored");
                    }
                }
                Ok(())
            })?;
        }
        self.matrix_is_current = true;
        Ok(())
    }
}
