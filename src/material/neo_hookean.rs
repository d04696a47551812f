//! Compressible neo-Hookean solid: tau = mu (b - I) + lambda ln J I (for example Bonet and Wood 2008, eq. 6.28).

use super::Lame;
use nalgebra::Matrix3;

#[inline(always)]
pub(super) fn kirchhoff(lame: &Lame, f: &Matrix3<f64>) -> Matrix3<f64> {
    f * f.transpose() * lame.mu + Matrix3::from_diagonal_element(lame.lambda * f.determinant().ln() - lame.mu)
}

pub(super) fn energy(lame: &Lame, f: &Matrix3<f64>) -> f64 {
    let log_j = f.determinant().ln();
    0.5 * lame.mu * (f.norm_squared() - 3.0) - lame.mu * log_j + 0.5 * lame.lambda * log_j * log_j
}

/// A wave along a stretch L sees d tau / d ln L = lambda + 2 mu L^2; the largest L^2 is at most the largest row sum of |b|. Below a
/// stretch of 1 the stress -tau adds to it.
#[inline(always)]
pub(super) fn wave_modulus(lame: &Lame, f: &Matrix3<f64>) -> f64 {
    let b = f * f.transpose();
    let row = |i: usize| b[(i, 0)].abs() + b[(i, 1)].abs() + b[(i, 2)].abs();
    let stretch = row(0).max(row(1)).max(row(2)).max(1.0);
    lame.lambda * (1.0 + (-f.determinant().ln()).max(0.0)) + 2.0 * lame.mu * stretch
}

/// Change of the Kirchhoff stress with the spatial gradient `l` of a small motion on top of a deformation with b = F F^T.
pub(super) fn change(lambda: f64, mu: f64, b: &Matrix3<f64>, l: &Matrix3<f64>) -> Matrix3<f64> {
    (l * b + b * l.transpose()) * mu + Matrix3::from_diagonal_element(lambda * l.trace())
}
