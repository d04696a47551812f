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

/// How the logarithmic strain changes with a small motion on top of a deformation.
pub(crate) struct StrainChange {
    b: Matrix3<f64>,
    vectors: Matrix3<f64>,
    /// Half the divided differences of the logarithm of the eigenvalues of b.
    slopes: Matrix3<f64>,
}

impl StrainChange {
    pub(super) fn new(f: &Matrix3<f64>) -> Self {
        let b = symmetric(&(f * f.transpose()));
        let eigen = b.symmetric_eigen();
        let slopes = Matrix3::from_fn(|i, j| {
            let (x, y) = (eigen.eigenvalues[i], eigen.eigenvalues[j]);
            let r = (x - y) / y;
            0.5 * if r == 0.0 { 1.0 } else { r.ln_1p() / r } / y
        });
        Self { b, vectors: eigen.eigenvectors, slopes }
    }

    /// Change of the strain with the spatial gradient `l` of the motion.
    pub(super) fn of(&self, l: &Matrix3<f64>) -> Matrix3<f64> {
        let change = l * self.b + self.b * l.transpose();
        let turned = self.vectors.transpose() * change * self.vectors;
        self.vectors * turned.component_mul(&self.slopes) * self.vectors.transpose()
    }
}
