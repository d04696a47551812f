//! Stage 6: velocity, position, deformation and stress of the particles, and in the same pass what they give to the grid next.

use super::Stepper;
use crate::component::StepError;
use crate::model::{Model, Pace};
use crate::scene::Integrator;
use crate::state::State;
use crate::transfer::{GatherTask, Rows, ScatterTask, Sweep, What};

/// What is updated, and by how long a step \[s\].
#[derive(Debug, Clone, Copy)]
pub(super) struct Update {
    pub(super) kick: Option<f64>,
    pub(super) drift: Option<f64>,
    pub(super) strain: Option<f64>,
    /// Whether somebody may look at the particles when the step is done.
    pub(super) seen: bool,
}

impl Stepper {
    /// Updates the particles. Where the scene allows, they give to the grid in the same pass what the coming projection or step sums, if
    /// there is one: a particle is then loaded once.
    pub(super) fn grid_to_particles(
        &mut self,
        model: &Model,
        state: &mut State,
        update: &Update,
        coming: Option<What>,
    ) -> Result<(), StepError> {
        let paces = matches!(model.pace, Pace::Cfl(_));
        if let Some(dt) = update.drift {
            self.look_ahead(model, state, dt);
        }
        let stays = update.drift.is_none() || !state.order.is_stale;
        let coming = coming.filter(|_| model.fuses() && stays);
        let gather = GatherTask {
            affine: model.needs.affine,
            increment: model.needs.increment,
            flip_share: model.flip_share,
            separation: model.separation,
            kick: update.kick,
            drift: update.drift,
            strain: update.strain,
            gradient_is_new: model.integrator == Integrator::Usf,
            gravity: self.gravity,
            body_force: &self.body_force,
            work: model.needs.work && (self.gravity != [0.0; 3] || model.needs.body_force),
            pace: paces,
            // a whole step leaves velocities that the next pass takes from the grid anew
            keep: model.needs.increment || update.strain.is_none() || update.kick.is_none() || update.seen || coming.is_none(),
        };
        // what is known of particles by their places in memory is known anew after the pass; body forces are not
        let tidy = model.fuses() && update.drift.is_some() && self.is_untidy(model, state);
        let scatter = coming.map(|what| ScatterTask { what, body_force: &[], relieved: &[] });
        let shared = super::worth_sharing(state);
        let sweep = Sweep { model, rows: Rows::new(&mut state.particles), gather: Some(gather), scatter, tidy };
        let report = super::pass::pass(&mut self.grid, &self.kernels, &state.bins, shared, &sweep);
        if let Some(fault) = report.fault {
            return Err(super::pass::error(model, state, fault));
        }
        self.sums = coming;
        if update.drift.is_some() {
            self.look_back(state, &report, tidy);
        }
        if tidy {
            self.lookup.clear();
            if model.needs.lookup {
                self.lookup(state);
            }
        }
        if paces && update.strain.is_some() {
            state.pace = report.pace();
        }
        state.external_work += report.work;
        Ok(())
    }
}
