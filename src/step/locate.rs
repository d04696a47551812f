//! Stage 1: which cells are the particles in.

use super::pass::error;
use super::{Stepper, worth_sharing};
use crate::component::StepError;
use crate::grid::{LARGEST_DRIFT, Lanes, sort};
use crate::model::Model;
use crate::state::{Order, State};
use crate::transfer::{Fault, FaultKind, SweepReport};
use rayon::prelude::*;

/// Runs of particles in one cell that take as much time as sorting a particle among all. Sorting is worth its time once it would have saved
/// as much.
const RUNS_A_SORT: f64 = 4.0;
/// The same for sorting it within its bin.
const RUNS_A_TIDY: f64 = 0.2;
/// Nodes that a thread looks through at a time.
const SOME: usize = 4096;

impl Stepper {
    /// Sorts the particles where their order does not fit the grid any more.
    pub(crate) fn locate(&mut self, model: &Model, state: &mut State) -> Result<(), StepError> {
        let is_new = self.grid.homes.is_empty();
        // also where the drift is no number
        let fits = !state.bins.is_empty() && !state.order.is_stale && state.order.drift <= LARGEST_DRIFT;
        if !fits || is_new && !is_near(model, state) {
            self.check_places(model, state)?;
            self.sort(model, state);
        } else if is_new {
            self.grid.arrange(model, &state.bins);
        }
        self.matrix_is_current = false;
        self.integration.outdate();
        if model.needs.lookup {
            self.lookup(state);
        }
        Ok(())
    }

    /// Sorts the particles and finds the nodes they may touch.
    fn sort(&mut self, model: &Model, state: &mut State) {
        let shared = worth_sharing(state);
        state.bins = sort(model, self.grid.shape(), &mut state.particles, shared);
        state.order = Order::default();
        self.lookup.clear();
        self.sums = None;
        self.grid.arrange(model, &state.bins);
    }

    /// Sorts the particles at the end of a call of `step` where the next would have to: then looking at a state changes nothing of it.
    pub(crate) fn tidy(&mut self, model: &Model, state: &mut State) {
        if state.order.is_stale {
            self.sort(model, state);
        }
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

    /// Decides whether the particles are to be sorted before the next step, before a pass in which they move for `dt` \[s\].
    ///
    /// Where particles give in such a pass, weights are not negative and sum to 1: nobody moves faster than the fastest node. But of a node
    /// with less mass than a particle, which may be thrown far, nobody sees more than the ratio of the masses.
    pub(super) fn look_ahead(&self, model: &Model, state: &mut State, dt: f64) {
        let of = |nodes: &[Lanes]| {
            let (mut fastest, mut light) = ([0.0; 3], [0.0; 3]);
            for &[mass, x, y, z] in nodes {
                // most nodes of the active blocks are empty
                if mass == 0.0 {
                    continue;
                }
                let speed = [x, y, z].map(f64::abs);
                if mass < model.lightest {
                    let share = (mass / model.lightest).max(0.0);
                    light = larger(light, speed.map(|speed| share * speed));
                } else {
                    fastest = larger(fastest, speed);
                }
            }
            (fastest, light)
        };
        let nodes: &[Lanes] = &self.grid.momentum;
        let (fastest, light) = if !model.fuses() {
            Default::default()
        } else if worth_sharing(state) {
            let parts = nodes.par_chunks(SOME).map(of);
            parts.reduce(Default::default, |a, b| (larger(a.0, b.0), larger(a.1, b.1)))
        } else {
            of(nodes)
        };
        let nodes = (model.axes[0].width() as f64).powi(model.dimension as i32);
        let mut reach = (0..model.dimension).map(|a| (fastest[a] + nodes * light[a]) * dt * model.axes[a].inverse_cell());
        let order = &mut state.order;
        let is_ragged = (order.lag + order.excess) as f64 > RUNS_A_SORT * state.particles.len() as f64;
        order.is_stale = is_ragged || !reach.all(|reach| order.drift + reach <= LARGEST_DRIFT);
    }

    /// Whether sorting each bin for itself is worth its time. Particles with domains, sorted by cell, are in no order yet: those of one cell
    /// begin at either of two nodes along an axis.
    pub(super) fn is_untidy(&self, model: &Model, state: &State) -> bool {
        let order = &state.order;
        model.domains.is_some() && order.sorted_runs == 0 || order.excess as f64 > RUNS_A_TIDY * state.particles.len() as f64
    }

    /// Notes how well the particles are in order after a pass in which they moved, before which each bin was sorted where it is `tidied`.
    pub(super) fn look_back(&self, state: &mut State, report: &SweepReport, tidied: bool) {
        let order = &mut state.order;
        order.drift += report.way;
        if order.sorted_runs == 0 {
            (order.sorted_runs, order.tidy_runs) = (report.runs, report.runs);
        } else if tidied {
            (order.tidy_runs, order.excess) = (report.runs, 0);
        }
        order.lag += order.tidy_runs.saturating_sub(order.sorted_runs);
        order.excess += report.runs.saturating_sub(order.tidy_runs);
    }

    fn check_places(&self, model: &Model, state: &State) -> Result<(), StepError> {
        let positions = &state.particles.position;
        let is_inside = |row: usize| model.axes.iter().enumerate().all(|(a, axis)| axis.holds(positions.column(a)[row]));
        match (0..state.particles.len()).find(|row| !is_inside(*row)) {
            None => Ok(()),
            Some(row) => Err(error(model, state, Fault { row, kind: FaultKind::of_position(positions.row(row)) })),
        }
    }
}

/// The larger of two speeds, axis by axis; one that is no number is kept.
fn larger(old: [f64; 3], new: [f64; 3]) -> [f64; 3] {
    std::array::from_fn(|a| if new[a] > old[a] || new[a].is_nan() { new[a] } else { old[a] })
}

/// Whether the particles of a state that came from elsewhere are where its bins say.
fn is_near(model: &Model, state: &State) -> bool {
    state.bins.iter().all(|bin| {
        model.axes.iter().enumerate().all(|(a, axis)| {
            let slot = 3 - model.dimension + a;
            let cells = bin.low[slot].saturating_sub(1)..=bin.high[slot].saturating_add(1);
            state.particles.position.column(a)[bin.start as usize..bin.end as usize].iter().all(|x| cells.contains(&axis.cell(*x).0))
        })
    })
}
