//! Stage 3: mass, momentum and forces from the particles to the grid, and the second projection of MUSL and USF.

use super::{Stepper, for_each, with_tile, worth_sharing};
use crate::grid::Lanes;
use crate::model::Model;
use crate::state::State;
use crate::transfer::{Rows, ScatterTask};

/// What is summed on the grid.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum What {
    MassMomentumForce,
    MassMomentum,
}

/// A pointer that threads share; bins of one colour write to different nodes.
#[derive(Clone, Copy)]
struct Shared(*mut Lanes);
// SAFETY: see `Grid::add`.
unsafe impl Send for Shared {}
// SAFETY: see `Grid::add`.
unsafe impl Sync for Shared {}
impl Shared {
    fn get(self) -> *mut Lanes {
        self.0
    }
}

impl Stepper {
    pub(super) fn particles_to_grid(&mut self, model: &Model, state: &mut State, what: What) {
        let forces = what == What::MassMomentumForce;
        let shared = worth_sharing(state);
        self.grid.clear(forces);
        let momentum = Shared(self.grid.momentum.as_mut_ptr());
        let force = Shared(self.grid.force.as_mut_ptr());
        let (grid, kernels, bins) = (&self.grid, &self.kernels, &state.bins);
        let task = ScatterTask { model, rows: Rows::new(&mut state.particles), forces, body_force: &self.body_force };
        for colour in &grid.colours {
            for_each(shared, colour, |b| {
                let bin = &bins[b];
                with_tile(|tile| {
                    grid.open(b, tile);
                    // SAFETY: bins own their rows; the tile covers the cells of the bin; bins of one colour touch no common node.
                    unsafe {
                        kernels.scatter(&task, bin.start as usize..bin.end as usize, tile);
                        grid.add(b, bin, tile, momentum.get(), forces.then(|| force.get()));
                    }
                });
            });
        }
        if forces {
            self.add_surface_forces(model, state);
        }
    }

    /// Projects the velocity of the particles anew: v_i = sum m v N / m_i, with the boundaries at `time`.
    pub(super) fn project(&mut self, model: &Model, state: &mut State, time: f64) {
        self.particles_to_grid(model, state, What::MassMomentum);
        for lanes in &mut self.grid.momentum {
            let mass = lanes[0];
            if mass > 0.0 {
                *lanes = [mass, lanes[1] / mass, lanes[2] / mass, lanes[3] / mass];
            }
        }
        self.hold_velocity(model, time);
    }
}
