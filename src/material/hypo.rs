//! Hypo-elasticity with the Jaumann rate of the Kirchhoff stress: tau' = w tau - tau w + J D : d.
//!
//! In terms of the Cauchy stress this adds -sigma tr(d), so that in one dimension sigma' = (E - sigma) eps' (Tielen 2016, section 3.2),
//! which integrates to tau = E (J - 1). The rotation is the one of Hughes and Winget (1980), so a rotating body keeps its stress.
//! A rate law has no potential; its energy is the work of the stress, kept as the seventh number of the history.

use super::{History, Increment, Lame, store_stress, stress_of, symmetric};
use nalgebra::{Matrix3, Vector3};

pub(super) const HISTORY: usize = 7;

#[inline(always)]
pub(super) fn update(lame: &Lame, history: &mut History, increment: &Increment) {
    let strain = symmetric(&increment.gradient);
    let old = turned(&stress_of(history), &rotation(&increment.gradient));
    let new = old + lame.stress(&strain) * increment.jacobian;
    history[6] += 0.5 * (old + new).dot(&strain);
    store_stress(history, &new);
}

/// Rotation of a step, (I - h)^-1 (I + h) with half its spin h. With the axial vector a of h that is I + 2 / (1 + a.a) (h + h h).
#[inline(always)]
fn rotation(gradient: &Matrix3<f64>) -> Matrix3<f64> {
    let twice = |r: usize, c: usize| gradient[(r, c)] - gradient[(c, r)];
    let a = Vector3::new(twice(2, 1), twice(0, 2), twice(1, 0)) * 0.25;
    let square = a.norm_squared();
    let half_spin = a.cross_matrix();
    Matrix3::identity() + (half_spin + a * a.transpose() - Matrix3::from_diagonal_element(square)) * (2.0 / (1.0 + square))
}

/// R S R^T of a symmetric S: six sums, not nine.
#[inline(always)]
fn turned(s: &Matrix3<f64>, r: &Matrix3<f64>) -> Matrix3<f64> {
    let half = |i: usize, k: usize| r[(i, 0)] * s[(0, k)] + r[(i, 1)] * s[(1, k)] + r[(i, 2)] * s[(2, k)];
    let row = |i: usize| [half(i, 0), half(i, 1), half(i, 2)];
    let rows = [row(0), row(1), row(2)];
    let of = |i: usize, j: usize| rows[i][0] * r[(j, 0)] + rows[i][1] * r[(j, 1)] + rows[i][2] * r[(j, 2)];
    let (xy, xz, yz) = (of(0, 1), of(0, 2), of(1, 2));
    Matrix3::new(of(0, 0), xy, xz, xy, of(1, 1), yz, xz, yz, of(2, 2))
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
    let half_spin_change = (gradient_change - gradient_change.transpose()) * 0.25;
    let rotation = rotation(gradient);
    // (I - h)^-1 is the mean of I and the rotation
    let mean = (Matrix3::identity() + rotation) * 0.5;
    let turn = mean * half_spin_change * mean * 2.0;
    let stress = stress_of(history);
    let turned = turn * stress * rotation.transpose();
    turned + turned.transpose() + lame.stress(&symmetric(gradient)) * jacobian_change + lame.stress(&symmetric(gradient_change)) * jacobian
}
