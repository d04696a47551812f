//! Hencky solid: the Kirchhoff stress is linear in the logarithmic strain ln V = (ln b) / 2 (Hencky 1928; Neff et al. 2016).

use super::{Lame, symmetric};
use nalgebra::Matrix3;

/// Logarithmic strain \[-\].
fn strain(f: &Matrix3<f64>) -> Matrix3<f64> {
    let eigen = symmetric(&(f * f.transpose())).symmetric_eigen();
    let logs = eigen.eigenvalues.map(|v| 0.5 * v.ln());
    eigen.eigenvectors * Matrix3::from_diagonal(&logs) * eigen.eigenvectors.transpose()
}

pub(super) fn kirchhoff(lame: &Lame, f: &Matrix3<f64>) -> Matrix3<f64> {
    lame.stress(&strain(f))
}

pub(super) fn energy(lame: &Lame, f: &Matrix3<f64>) -> f64 {
    let h = strain(f);
    lame.mu * h.norm_squared() + 0.5 * lame.lambda * h.trace().powi(2)
}
