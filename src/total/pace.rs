//! The lengths of implicit steps: halved where no balance is found, or as long as an estimate of their error allows.

use super::Total;
use super::reference::Vectors;
use crate::component::StepError;
use crate::implicit::{Failure, Scheme};
use crate::model::{Model, Pace};
use crate::state::State;

/// How often a step is halved before it is given up.
const HALVINGS: u32 = 8;
/// Shortest step that is tried, over the one that was wanted.
const SHORTEST: f64 = 1e-6;
/// Room for an estimate that is too low.
const SAFETY: f64 = 0.9;
/// By how much a step may be shorter or longer than the one before.
const CHANGE: [f64; 2] = [0.2, 2.0];

/// One step; a failed one leaves the state as it was.
pub(super) trait Step: FnMut(&mut State, f64) -> Result<(), Failure<StepError>> {}
impl<F: FnMut(&mut State, f64) -> Result<(), Failure<StepError>>> Step for F {}

/// Moves the state on by `h` \[s\], in several steps where one finds no balance; where steps go by their error, by as much as that allows.
pub(super) fn advance(model: &Model, state: &mut State, h: f64, step: &mut impl Step) -> Result<(), StepError> {
    match model.pace {
        Pace::Error { .. } => accurately(state, h, step),
        _ => in_halves(state, h, HALVINGS, step),
    }
}

fn in_halves(state: &mut State, h: f64, left: u32, step: &mut impl Step) -> Result<(), StepError> {
    match step(state, h) {
        Ok(()) => Ok(()),
        Err(_) if left > 0 => {
            in_halves(state, 0.5 * h, left - 1, step)?;
            in_halves(state, 0.5 * h, left - 1, step)
        }
        Err(failure) => Err(explain(failure, state.time, h)),
    }
}

fn accurately(state: &mut State, wanted: f64, step: &mut impl Step) -> Result<(), StepError> {
    let mut h = wanted;
    loop {
        let Err(failure) = step(state, h) else { return Ok(()) };
        let shorter = match &failure {
            Failure::Trouble(StepError::Inaccurate { error, allowed, .. }) => h * share(*error, *allowed).clamp(CHANGE[0], SAFETY),
            _ => 0.5 * h,
        };
        // an estimate that is no number would be tried for ever
        if shorter.is_nan() || shorter < SHORTEST * wanted {
            return Err(explain(failure, state.time, h));
        }
        h = shorter;
    }
}

fn explain(failure: Failure<StepError>, time: f64, step: f64) -> StepError {
    match failure {
        Failure::NoConvergence(residuals) => StepError::NoEquilibrium { time, step, residuals },
        Failure::Trouble(error) => error,
    }
}

/// The step with this error is to be multiplied by this much: errors of schemes of second order go with the third power of a step.
fn share(error: f64, allowed: f64) -> f64 {
    SAFETY * (allowed / error).cbrt()
}

impl Total {
    /// Judges a step of `h` \[s\] from the state, that would end with these accelerations of the nodes: an error where it is off by more than is
    /// allowed; else the length that the next may have becomes part of the state.
    pub(super) fn judge(
        &mut self,
        model: &Model,
        state: &mut State,
        scheme: Scheme,
        h: f64,
        acceleration: &[[f64; 3]],
    ) -> Result<(), StepError> {
        let Pace::Error { allowed, longest } = model.pace else { return Ok(()) };
        // the displacement of the scheme has the third derivative wrong (Zienkiewicz and Xie 1991, equation 10)
        let [coefficient, since] = scheme.third_derivative(h);
        let factor = coefficient * h * h * (h / (since + state.acceleration_age));
        let mut error: Vectors = acceleration
            .iter()
            .zip(&state.nodes.acceleration)
            .map(|(end, start)| std::array::from_fn(|a| if a < model.dimension { factor * (end[a] - start[a]) } else { 0.0 }))
            .collect();
        for held in &self.held {
            error[held.node][held.axis] = 0.0;
        }
        // root of the mean square over the mass
        let weighted = self.times(model, &error);
        let sum: f64 = error.iter().flatten().zip(weighted.iter().flatten()).map(|(e, w)| e * w).sum();
        let error = (sum.max(0.0) / state.particles.mass.iter().sum::<f64>()).sqrt();
        if error.is_nan() || error > allowed {
            return Err(StepError::Inaccurate { time: state.time, step: h, error, allowed });
        }
        let most = CHANGE[1] * h.max(state.next_step);
        state.next_step = (h * share(error, allowed).max(CHANGE[0])).min(most).min(longest);
        state.acceleration_age = h - since;
        Ok(())
    }
}
