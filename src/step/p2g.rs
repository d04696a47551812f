//! Stage 3: mass, momentum and forces from the particles to the grid, and the second projection of MUSL and USF.

use super::balance::{Field, is_empty};
use super::edge::Edges;
use super::{Stepper, Wrong, for_each, with_tile, worth_sharing};
use crate::basis::BATCH;
use crate::component::StepError;
use crate::grid::{Lanes, Tied};
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
    pub(super) fn particles_to_grid(&mut self, model: &Model, state: &mut State, what: What) -> Result<(), StepError> {
        let forces = what == What::MassMomentumForce;
        self.integrate(model, state)?;
        let shared = worth_sharing(state);
        self.grid.clear(forces);
        let momentum = Shared(self.grid.momentum.as_mut_ptr());
        let force = Shared(self.grid.force.as_mut_ptr());
        let (grid, kernels, bins) = (&self.grid, &self.kernels, &state.bins);
        let task = ScatterTask {
            model,
            rows: Rows::new(&mut state.particles),
            forces,
            // where mass is integrated, so is what acts on it
            body_force: if model.quadrature_of_velocity { &[] } else { &self.body_force },
            relieved: self.integration.relieved(),
        };
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
            if Edges::is_needed(model) {
                self.add_side_forces(model, state)?;
            }
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

    /// Projects the velocity of the particles anew, M v = sum m v N, with the boundaries at `time`.
    pub(super) fn project(&mut self, model: &Model, state: &mut State, time: f64) -> Result<(), StepError> {
        self.particles_to_grid(model, state, What::MassMomentum)?;
        self.check_masses(model, time)?;
        if model.projection.is_lumped() {
            for lanes in &mut self.grid.momentum {
                let mass = lanes[0];
                if !is_empty(model, mass) {
                    *lanes = [mass, lanes[1] / mass, lanes[2] / mass, lanes[3] / mass];
                }
            }
        } else {
            self.assemble(model, state)?;
            let held = self.held(model, |boundary, axis| boundary.velocity(axis, time));
            let mut right = std::mem::take(&mut self.right);
            right.clone_from(&self.grid.momentum);
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
