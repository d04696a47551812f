//! The one place where dimensions 1 and 2 are embedded in the 3x3 world of the material laws.

use super::{History, Lame, Material};
use crate::scene::Plane;
use nalgebra::Matrix3;

/// Where a problem of `dimension` axes lies in space, and what happens across it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Embedding {
    /// Number of space dimensions.
    pub(crate) dimension: usize,
    /// Whether the stress across is zero.
    pub(crate) stress_free: bool,
}

/// Newton steps before giving up on a stress-free thickness; quadratic convergence needs five or six.
const MAX_NEWTON: usize = 50;

impl Embedding {
    pub(crate) fn new(dimension: usize, plane: Plane) -> Self {
        Self { dimension, stress_free: plane == Plane::Stress && dimension < 3 }
    }

    /// Gradient of velocity times step in 3x3 from its in-plane part. Across, laws of rate type stay stress-free by
    /// d33 = -lambda / (lambda + 2 mu) (d11 + d22), in one dimension d22 = d33 = -nu d11.
    pub(crate) fn gradient<const D: usize>(&self, lame: &Lame, in_plane: &[[f64; D]; D]) -> Matrix3<f64> {
        let mut gradient = embed(in_plane, 0.0);
        if self.stress_free {
            let (sum, Lame { lambda, mu }) = (gradient.trace(), *lame);
            let across = if D == 1 { -0.5 * lambda / (lambda + mu) * sum } else { -lambda / (lambda + 2.0 * mu) * sum };
            for a in D..3 {
                gradient[(a, a)] = across;
            }
        }
        gradient
    }

    /// Stretch across that makes the stress across vanish for laws with a potential, from a guess; `None` where none is found.
    pub(crate) fn stress_free_stretch<const D: usize>(&self, material: &Material, in_plane: &[[f64; D]; D], guess: f64) -> Option<f64> {
        let none = History::default();
        let across = |stretch: f64| material.kirchhoff(&embed(in_plane, stretch), &none)[(2, 2)];
        let modulus = material.lame().wave_modulus();
        // The stress across grows with the logarithm of the stretch, so Newton in the logarithm, with a difference for the slope.
        let mut log = guess.ln();
        for _ in 0..MAX_NEWTON {
            let stress = across(log.exp());
            if !stress.is_finite() {
                return None;
            }
            // 1e-14: what 3x3 products leave of a stress of the size of the modulus
            if stress.abs() <= 1e-14 * modulus {
                return Some(log.exp());
            }
            let h = 1e-6;
            let slope = (across((log + h).exp()) - across((log - h).exp())) / (2.0 * h);
            log -= (stress / slope).clamp(-0.5, 0.5);
        }
        // round-off of a stiff state may stop a little above: accept what is as good as the difference slope allows
        (across(log.exp()).abs() <= 1e-10 * modulus).then(|| log.exp())
    }
}

/// A D x D tensor with `across` on the rest of the diagonal.
#[inline(always)]
pub(crate) fn embed<const D: usize>(in_plane: &[[f64; D]; D], across: f64) -> Matrix3<f64> {
    let mut full = Matrix3::from_diagonal_element(across);
    for r in 0..D {
        for c in 0..D {
            full[(r, c)] = in_plane[r][c];
        }
    }
    full
}
