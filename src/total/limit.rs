//! The largest stable step: from the highest frequency of the bodies at time 0, by Lanczos.

use super::Total;
use super::explicit::Scheme;
use super::reference::Vectors;
use crate::component::StepError;
use crate::model::Model;
use crate::state::State;

/// Lanczos vectors: the highest frequency comes out to a per mille or better.
const VECTORS: usize = 40;
/// Displacement of a probe, over the cell: differences of forces of this size are linear to as many digits as they have.
const SMALL: f64 = 1e-7;

impl Total {
    /// Largest stable step at time 0 \[s\].
    pub(crate) fn stable_step(&mut self, model: &Model, state: &State) -> Result<f64, StepError> {
        let highest = self.highest_frequency_squared(model, state)?;
        // round-off of the differences and what the iteration has not found yet
        Ok(self.scheme.reach() / (1.001 * highest).sqrt())
    }

    /// Largest eigenvalue of M^-1 K \[1/s2\].
    fn highest_frequency_squared(&mut self, model: &Model, state: &State) -> Result<f64, StepError> {
        let n = self.acceleration.len();
        let dot = |a: &[[f64; 3]], b: &[[f64; 3]]| a.iter().zip(b).flat_map(|(a, b)| (0..3).map(move |k| a[k] * b[k])).sum::<f64>();
        // a start with a part of every mode, the same on every machine
        let mut vector: Vec<[f64; 3]> = (0..n)
            .map(|i| {
                std::array::from_fn(|a| {
                    if a < model.dimension {
                        ((1.7 + a as f64) * (i as f64 + 1.0)).sin() + if i % 2 == 0 { 1.0 } else { -1.0 }
                    } else {
                        0.0
                    }
                })
            })
            .collect();
        self.held.iter().for_each(|h| vector[h.node][h.axis] = 0.0);
        for body in &self.bodies {
            let start = body.reference.start;
            (0..body.reference.len()).filter(|i| !body.reference.is_own(*i)).for_each(|i| vector[start + i] = [0.0; 3]);
        }
        self.spread(&mut vector);
        let (mut known, mut images): (Vec<Vectors>, Vec<Vectors>) = (Vec::new(), Vec::new());
        let (mut diagonal, mut beside) = (Vec::new(), Vec::new());
        for _ in 0..VECTORS.min(n * model.dimension) {
            // orthogonal in the product of the mass matrix, twice for the sake of round-off
            for _ in 0..2 {
                for (v, image) in known.iter().zip(&images) {
                    let share = dot(&vector, image);
                    vector.iter_mut().zip(v).for_each(|(x, v)| (0..3).for_each(|k| x[k] -= share * v[k]));
                }
            }
            let image = self.times(model, &vector);
            let length = dot(&vector, &image).sqrt();
            if length.is_nan() || length <= 1e-12 * diagonal.first().copied().unwrap_or(0.0) || length == 0.0 {
                break;
            }
            if !known.is_empty() {
                beside.push(length);
            }
            let scale = |x: &[[f64; 3]]| x.iter().map(|x| x.map(|v| v / length)).collect::<Vec<_>>();
            let (unit, unit_image) = (scale(&vector), scale(&image));
            let force = self.stiffness_times(model, state, &unit)?;
            diagonal.push(dot(&unit, &force));
            let mut next = vec![[0.0; 3]; n];
            self.solve(model, &force, &mut next);
            vector = next;
            known.push(unit);
            images.push(unit_image);
        }
        beside.truncate(diagonal.len().saturating_sub(1));
        let matrix = nalgebra::DMatrix::from_fn(diagonal.len(), diagonal.len(), |r, c| match r.abs_diff(c) {
            0 => diagonal[r],
            1 => beside[r.min(c)],
            _ => 0.0,
        });
        Ok(matrix.symmetric_eigenvalues().iter().copied().fold(0.0, f64::max))
    }

    /// K x at time 0, by a central difference of the internal forces.
    fn stiffness_times(&mut self, model: &Model, state: &State, x: &[[f64; 3]]) -> Result<Vec<[f64; 3]>, StepError> {
        let largest = x.iter().flatten().fold(0.0f64, |m, v| m.max(v.abs()));
        let size = SMALL * model.cell() / largest;
        let mut force = |sign: f64| -> Result<Vec<[f64; 3]>, StepError> {
            let mut moved = state.clone();
            for (u, x) in moved.nodes.displacement.iter_mut().zip(x) {
                for k in 0..3 {
                    u[k] += sign * size * x[k];
                }
            }
            self.internal.clear();
            let result = self.forces(model, &mut moved, state.time);
            let internal = std::mem::take(&mut self.internal);
            result.map(|()| internal)
        };
        let (plus, minus) = (force(1.0)?, force(-1.0)?);
        Ok(plus.iter().zip(&minus).map(|(p, m)| std::array::from_fn(|k| (m[k] - p[k]) / (2.0 * size))).collect())
    }
}

impl Scheme {
    /// Largest frequency times step at which an oscillation stays bounded.
    fn reach(&self) -> f64 {
        // trace of the map of a step for u'' = -w^2 u with a step of 1: bounded while it is between -2 and 2
        let trace = |w: f64| {
            let step = |mut u: f64, mut v: f64| {
                for (k, kick) in self.kicks.iter().enumerate() {
                    v -= kick * w * w * u;
                    u += self.drifts.get(k).copied().unwrap_or(0.0) * v;
                }
                [u, v]
            };
            step(1.0, 0.0)[0] + step(0.0, 1.0)[1]
        };
        let mut w = 0.0;
        let fine = 1e-4;
        while trace(w + fine).abs() <= 2.0 + 1e-12 {
            w += fine;
        }
        w
    }
}

#[cfg(test)]
mod tests {
    use super::super::explicit::{FOURTH_ORDER, VERLET};

    #[test]
    fn verlet_is_bounded_up_to_two() {
        assert!((VERLET.reach() - 2.0).abs() < 1e-3);
        assert!(FOURTH_ORDER.reach() > 2.0);
    }

    /// The error of an oscillator falls with the fourth power of the step.
    #[test]
    fn the_scheme_of_fourth_order_is_one() {
        let error = |steps: usize| {
            let h = 1.0 / steps as f64;
            let (mut u, mut v) = (1.0f64, 0.0f64);
            for _ in 0..steps {
                for (k, kick) in FOURTH_ORDER.kicks.iter().enumerate() {
                    // sin: a force that is not linear
                    v -= kick * h * u.sin();
                    u += FOURTH_ORDER.drifts.get(k).copied().unwrap_or(0.0) * h * v;
                }
            }
            [u, v]
        };
        let exact = error(4000);
        let distance = |n: usize| (error(n)[0] - exact[0]).hypot(error(n)[1] - exact[1]);
        let order = (distance(16) / distance(32)).log2();
        assert!((order - 4.0).abs() < 0.3, "{order}");
    }
}
