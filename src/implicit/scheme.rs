//! Schemes in time: what an end displacement means for accelerations and forces, and the velocity that goes with it.

use crate::scene;

/// A scheme of one step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Scheme {
    /// No inertia: loads are at the end of the step.
    QuasiStatic,
    /// Newmark's relations with the balance between both ends (Chung and Hulbert 1993); Newmark's own where both alphas are 0.
    Newmark { beta: f64, gamma: f64, alpha_m: f64, alpha_f: f64 },
    /// Balance in the middle with a stress that conserves energy (Gonzalez 2000).
    EnergyMomentum,
}

/// How a step of a scheme weighs what goes into the balance: M a + f_int = f_ext.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Trial {
    /// Acceleration by displacement of the step \[1/s2\], by velocity at the start \[1/s\] and by acceleration at the start \[-\].
    pub(crate) acceleration: [f64; 3],
    /// Share of the end in the displacement at which the internal forces are; a conserving stress takes both ends anyway.
    pub(crate) inner: f64,
    /// Share of the end in the displacement at which the loads are.
    pub(crate) outer: f64,
    /// Time of the loads, as a share of the step.
    pub(crate) time: f64,
}

impl Scheme {
    /// The scheme of a scene; `None` where it is explicit.
    pub(crate) fn new(method: &scene::Method) -> Option<Self> {
        match method.integrator() {
            scene::Integrator::QuasiStatic => Some(Self::QuasiStatic),
            scene::Integrator::Newmark => {
                let (beta, gamma) = (method.newmark_beta.unwrap_or(0.25), method.newmark_gamma.unwrap_or(0.5));
                Some(Self::Newmark { beta, gamma, alpha_m: 0.0, alpha_f: 0.0 })
            }
            scene::Integrator::GeneralizedAlpha => {
                // Chung and Hulbert 1993, eqs. 17, 18, 25
                let rho = method.spectral_radius.unwrap_or(0.8);
                let (alpha_m, alpha_f) = ((2.0 * rho - 1.0) / (rho + 1.0), rho / (rho + 1.0));
                let (beta, gamma) = (0.25 * (1.0 - alpha_m + alpha_f).powi(2), 0.5 - alpha_m + alpha_f);
                Some(Self::Newmark { beta, gamma, alpha_m, alpha_f })
            }
            scene::Integrator::EnergyMomentum => Some(Self::EnergyMomentum),
            _ => None,
        }
    }

    pub(crate) fn has_inertia(self) -> bool {
        self != Self::QuasiStatic
    }

    /// Whether the acceleration at the start counts.
    pub(crate) fn needs_acceleration(self) -> bool {
        matches!(self, Self::Newmark { .. })
    }

    pub(crate) fn is_conserving(self) -> bool {
        self == Self::EnergyMomentum
    }

    /// Weights for a step of `h` \[s\].
    pub(crate) fn trial(self, h: f64) -> Trial {
        match self {
            Self::QuasiStatic => Trial { acceleration: [0.0; 3], inner: 1.0, outer: 1.0, time: 1.0 },
            Self::Newmark { beta, alpha_m, alpha_f, .. } => {
                let share = 1.0 - alpha_m;
                let acceleration = [share / (beta * h * h), -share / (beta * h), alpha_m - share * (0.5 - beta) / beta];
                Trial { acceleration, inner: 1.0 - alpha_f, outer: 1.0 - alpha_f, time: 1.0 - alpha_f }
            }
            Self::EnergyMomentum => Trial { acceleration: [2.0 / (h * h), -2.0 / h, 0.0], inner: 1.0, outer: 0.5, time: 0.5 },
        }
    }

    /// Velocity and acceleration at the end (energy-momentum: mean of the step), from displacement, velocity and acceleration at the start.
    pub(crate) fn end(self, h: f64, moved: f64, velocity: f64, acceleration: f64) -> [f64; 2] {
        match self {
            Self::QuasiStatic => [0.0; 2],
            Self::Newmark { beta, gamma, .. } => {
                let end = (moved - h * velocity) / (beta * h * h) - (0.5 - beta) / beta * acceleration;
                [velocity + h * ((1.0 - gamma) * acceleration + gamma * end), end]
            }
            Self::EnergyMomentum => [2.0 * moved / h - velocity, 2.0 / h * (moved / h - velocity)],
        }
    }

    /// By which share of h^3 times the third derivative of the displacement that displacement is off at the end of a step; and how long after
    /// the start the acceleration of [`Self::end`] is \[s\].
    pub(crate) fn third_derivative(self, h: f64) -> [f64; 2] {
        match self {
            Self::QuasiStatic => [0.0, h],
            // where a displacement of third order hides it (beta = 1 / 6), the velocity still has the error of the trapezoidal rule
            Self::Newmark { beta, .. } => [(beta - 1.0 / 6.0).abs().max(1.0 / 12.0), h],
            Self::EnergyMomentum => [1.0 / 12.0, 0.5 * h],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The end of an oscillator u'' = -u after time 3, by steps of 3 / n.
    fn oscillator(scheme: Scheme, n: usize) -> [f64; 2] {
        let h = 3.0 / n as f64;
        let (mut u, mut v, mut a) = (1.0, 0.0, -1.0);
        let trial = scheme.trial(h);
        // the conserving stress of a linear law is the mean of both ends
        let inner = if scheme.is_conserving() { 0.5 } else { trial.inner };
        for _ in 0..n {
            let [by_moved, by_velocity, by_acceleration] = trial.acceleration;
            let moved = -(u + by_velocity * v + by_acceleration * a) / (by_moved + inner);
            [v, a] = scheme.end(h, moved, v, a);
            u += moved;
        }
        [u, v]
    }

    #[test]
    fn all_are_of_second_order_and_two_conserve() {
        let trapezoid = Scheme::Newmark { beta: 0.25, gamma: 0.5, alpha_m: 0.0, alpha_f: 0.0 };
        let method =
            scene::Method { integrator: Some(scene::Integrator::GeneralizedAlpha), spectral_radius: Some(0.5), ..Default::default() };
        let damped = Scheme::new(&method).unwrap();
        for scheme in [trapezoid, damped, Scheme::EnergyMomentum] {
            let error = |n: usize| {
                let [u, v] = oscillator(scheme, n);
                (u - 3f64.cos()).hypot(v + 3f64.sin())
            };
            let order = (error(100) / error(200)).log2();
            assert!((order - 2.0).abs() < 0.05, "{scheme:?}: {order}");
            let [u, v] = oscillator(scheme, 40);
            let energy = u * u + v * v;
            assert_eq!((energy - 1.0).abs() < 1e-12, scheme != damped, "{scheme:?}: {energy}");
            assert!(energy < 1.0 + 1e-12);
        }
    }
}
