//! Hypo-elasticity with the Jaumann rate of the Kirchhoff stress: tau' = w tau - tau w + J D : d.
//!
//! In terms of the Cauchy stress this adds -sigma tr(d), so that in one dimension sigma' = (E - sigma) eps' (Tielen 2016, section 3.2),
//! which integrates to tau = E (J - 1). The rotation is the one of Hughes and Winget (1980), so a rotating body keeps its stress.
//! A rate law has no potential; its energy is the work of the stress, kept as the seventh number of the history.

use super::{History, Increment, Lame, store_stress, stress_of, symmetric};
use nalgebra::Matrix3;

pub(super) const HISTORY: usize = 7;

pub(super) fn update(lame: &Lame, history: &mut History, increment: &Increment) {
    let strain = symmetric(&increment.gradient);
    let half_spin = (increment.gradient - increment.gradient.transpose()) * 0.25;
    let identity = Matrix3::identity();
    // I - w/2 with a skew w is never singular
    let rotation = (identity - half_spin).try_inverse().unwrap_or(identity) * (identity + half_spin);
    let old = rotation * stress_of(history) * rotation.transpose();
    let new = old + lame.stress(&strain) * increment.jacobian;
    history[6] += 0.5 * (old + new).dot(&strain);
    store_stress(history, &new);
}

pub(super) fn energy(history: &History) -> f64 {
    history[6]
}

/// Change of the stress after a step with small changes of the gradient and the volume ratio of the step.
pub(super) fn change(
    lame: &Lame,
    history: &History,
    gradient: &Matrix3<f64>,
    jacobian: f64,
    gradient_change: &Matrix3<f64>,
    jacobian_change: f64,
) -> Matrix3<f64> {
    let half_spin = (gradient - gradient.transpose()) * 0.25;
    let half_spin_change = (gradient_change - gradient_change.transpose()) * 0.25;
    let identity = Matrix3::identity();
    let inverse = (identity - half_spin).try_inverse().unwrap_or(identity);
    let rotation = inverse * (identity + half_spin);
    let turn = inverse * half_spin_change * (identity + rotation);
    let stress = stress_of(history);
    let turned = turn * stress * rotation.transpose();
    turned + turned.transpose() + lame.stress(&symmetric(gradient)) * jacobian_change + lame.stress(&symmetric(gradient_change)) * jacobian
}
