//! Stage 5: velocity, position, deformation and stress of the particles.

use super::{Stepper, with_tile, worth_sharing};
use crate::component::StepError;
use crate::grid::Grid;
use crate::model::{Model, Pace};
use crate::scene::Integrator;
use crate::state::{Bin, State};
use crate::transfer::{Fault, FaultKind, GatherReport, GatherTask, Kernels, Rows};
use rayon::prelude::*;

/// What is updated, and by how long a step \[s\].
#[derive(Debug, Clone, Copy)]
pub(super) struct Update {
    pub(super) kick: Option<f64>,
    pub(super) drift: Option<f64>,
    pub(super) strain: Option<f64>,
}

impl Stepper {
    pub(super) fn grid_to_particles(&mut self, model: &Model, state: &mut State, update: &Update) -> Result<(), StepError> {
        let shared = worth_sharing(state);
        let paces = matches!(model.pace, Pace::Cfl(_));
        let task = GatherTask {
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
            pace: paces,
            ..GatherTask::new(model, Rows::new(&mut state.particles))
        };
        sweep(&self.grid, &self.kernels, &state.bins, shared, &task, &mut self.reports);
        // in the order of the bins, so that sums do not depend on the threads
        if paces && update.strain.is_some() {
            state.pace = self.reports.iter().map(|r| r.pace).fold(1.0, f64::min);
        }
        state.external_work += self.reports.iter().map(|r| r.work).sum::<f64>();
        match self.reports.iter().find_map(|r| r.fault) {
            None => Ok(()),
            Some(fault) => Err(error(model, state, fault)),
        }
    }
}

/// Carries out a task on the particles of all bins. Reports come in the order of the bins.
pub(super) fn sweep(grid: &Grid, kernels: &Kernels, bins: &[Bin], shared: bool, task: &GatherTask, reports: &mut Vec<GatherReport>) {
    let of = |b: usize| {
        let bin = &bins[b];
        with_tile(|tile| {
            grid.load(b, bin, task.needs_force(), tile);
            // SAFETY: bins own their rows; the tile covers the cells of the bin.
            unsafe { kernels.gather(task, bin.start as usize..bin.end as usize, tile) }
        })
    };
    reports.clear();
    if shared {
        (0..bins.len()).into_par_iter().map(of).collect_into_vec(reports);
    } else {
        reports.extend((0..bins.len()).map(of));
    }
}

pub(super) fn error(model: &Model, state: &State, fault: Fault) -> StepError {
    let particle = state.particles.id[fault.row] as usize;
    let position = state.particles.position.row::<3>(fault.row)[..model.dimension].to_vec();
    let time = state.time;
    match fault.kind {
        FaultKind::Inverted(det) => StepError::Inverted { time, particle, position, det },
        FaultKind::NotFinite => StepError::NotFinite { time, particle, position },
        FaultKind::Left(place) => StepError::LeftGrid { time, particle, position: place[..model.dimension].to_vec() },
        FaultKind::WideDomain(length) => StepError::WideDomain { time, particle, position, length },
        FaultKind::NoThickness => StepError::NoThickness { time, particle, position },
    }
}
