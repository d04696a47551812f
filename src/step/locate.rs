//! Stage 1: which cells are the particles in.

use super::g2p::error;
use super::{Stepper, worth_sharing};
use crate::component::StepError;
use crate::grid::{Stray, sort};
use crate::model::Model;
use crate::state::State;
use crate::transfer::{Fault, FaultKind};
use rayon::prelude::*;

/// Cells of the particles of a bin: lowest and highest.
pub(super) type Extent = ([i32; 3], [i32; 3]);

impl Stepper {
    pub(crate) fn locate(&mut self, model: &Model, state: &mut State) -> Result<(), StepError> {
        if state.bins.is_empty() || !self.survey(model, state)? {
            state.bins = sort(model, self.grid.shape(), &mut state.particles);
            self.lookup.clear();
            self.grid.homes.clear();
            self.survey(model, state)?;
        }
        self.grid.settle(model, &state.bins, &self.extents);
        self.matrix_is_current = false;
        self.integration.outdate();
        if model.needs.lookup {
            self.lookup(state);
        }
        Ok(())
    }

    /// Place in memory by particle id, found anew where particles were sorted since.
    pub(crate) fn lookup(&mut self, state: &State) -> &[u32] {
        if self.lookup.is_empty() {
            self.lookup.resize(state.particles.len(), 0);
            for (place, &id) in state.particles.id.iter().enumerate() {
                self.lookup[id as usize] = place as u32;
            }
        }
        &self.lookup
    }

    /// Finds the extents of the bins; false where a particle strayed too far from its bin.
    fn survey(&mut self, model: &Model, state: &State) -> Result<bool, StepError> {
        let of = |bin| self.grid.survey(&model.axes, &state.particles, bin);
        let mut found = std::mem::take(&mut self.extents);
        found.clear();
        let mut stray = Stray::No;
        if worth_sharing(state) {
            let all: Vec<_> = state.bins.par_iter().map(of).collect();
            for (s, low, high) in all {
                note(&mut stray, s);
                found.push((low, high));
            }
        } else {
            for bin in &state.bins {
                let (s, low, high) = of(bin);
                note(&mut stray, s);
                found.push((low, high));
            }
        }
        self.extents = found;
        match stray {
            Stray::No => Ok(true),
            Stray::Far => Ok(false),
            Stray::Left(row) => {
                let kind = FaultKind::of_position(state.particles.position.row(row));
                Err(error(model, state, Fault { row, kind }))
            }
        }
    }
}

/// Keeps the worst: the first particle that left, else that one strayed.
fn note(worst: &mut Stray, next: Stray) {
    if !matches!(worst, Stray::Left(_)) && next != Stray::No {
        *worst = next;
    }
}
