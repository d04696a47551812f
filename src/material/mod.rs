//! Material laws, one file a law. Always 3x3 in, 3x3 out: a law knows no dimension, no grid and no particle.
//!
//! Every law yields the Kirchhoff stress tau = J sigma \[Pa\], so that the internal force is the sum of -V0 tau grad N, and its stored
//! energy for a unit of undeformed volume \[J/m3\]. Laws of rate type keep their stress in a history: `xx yy zz yz xz xy`, then the
//! work of the stress.

mod embed;
mod hencky;
mod hypo;
mod linear;
mod neo_hookean;
pub(crate) mod point;

pub(crate) use embed::{Embedding, embed};

use crate::scene;
use nalgebra::Matrix3;

/// Most numbers a law keeps from step to step.
pub(crate) const MAX_HISTORY: usize = 7;
pub(crate) type History = [f64; MAX_HISTORY];

/// Lamé constants and density of an isotropic elastic material.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Lame {
    /// First constant \[Pa\].
    pub(crate) lambda: f64,
    /// Shear modulus \[Pa\].
    pub(crate) mu: f64,
}

impl Lame {
    fn new(young: f64, poisson: f64) -> Self {
        Self { lambda: young * poisson / ((1.0 + poisson) * (1.0 - 2.0 * poisson)), mu: 0.5 * young / (1.0 + poisson) }
    }
    /// Isotropic linear map: lambda tr(e) I + 2 mu e.
    #[inline(always)]
    fn stress(&self, e: &Matrix3<f64>) -> Matrix3<f64> {
        Matrix3::from_diagonal_element(self.lambda * e.trace()) + e * (2.0 * self.mu)
    }
    /// Energy of the linear map from the stress: half stress times compliance times stress.
    fn energy_of_stress(&self, s: &Matrix3<f64>) -> f64 {
        let bulk = 3.0 * self.lambda + 2.0 * self.mu;
        (s.norm_squared() - self.lambda / bulk * s.trace().powi(2)) / (4.0 * self.mu)
    }
    /// Modulus of a plane compression wave \[Pa\].
    pub(crate) fn wave_modulus(&self) -> f64 {
        self.lambda + 2.0 * self.mu
    }
}

/// A material: its law with its constants.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Material {
    Linear(Lame),
    Hypo(Lame),
    NeoHookean(Lame),
    Hencky(Lame),
}

/// What happened to a particle in a step, for laws of rate type.
pub(crate) struct Increment {
    /// Velocity gradient times step \[-\].
    pub(crate) gradient: Matrix3<f64>,
    /// Volume ratio where the gradient was taken: before the step, or after it where the gradient refers to the new positions.
    pub(crate) jacobian: f64,
}

impl Material {
    pub(crate) fn new(material: &scene::Material) -> Self {
        let lame = Lame::new(material.young, material.poisson);
        match material.law {
            scene::Law::LinearElastic => Self::Linear(lame),
            scene::Law::HypoElastic => Self::Hypo(lame),
            scene::Law::NeoHookean => Self::NeoHookean(lame),
            scene::Law::Hencky => Self::Hencky(lame),
        }
    }

    pub(crate) fn lame(&self) -> &Lame {
        match self {
            Self::Linear(lame) | Self::Hypo(lame) | Self::NeoHookean(lame) | Self::Hencky(lame) => lame,
        }
    }

    /// Whether the stress is the derivative of a stored energy, so that tangents are symmetric.
    pub(crate) fn has_potential(&self) -> bool {
        !matches!(self, Self::Hypo(_))
    }

    /// Numbers that the law keeps from step to step.
    pub(crate) fn history(&self) -> usize {
        match self {
            Self::Linear(_) => linear::HISTORY,
            Self::Hypo(_) => hypo::HISTORY,
            Self::NeoHookean(_) | Self::Hencky(_) => 0,
        }
    }

    /// Kirchhoff stress \[Pa\].
    #[inline(always)]
    pub(crate) fn kirchhoff(&self, f: &Matrix3<f64>, history: &History) -> Matrix3<f64> {
        match self {
            Self::Linear(_) | Self::Hypo(_) => stress_of(history),
            Self::NeoHookean(lame) => neo_hookean::kirchhoff(lame, f),
            Self::Hencky(lame) => hencky::kirchhoff(lame, f),
        }
    }

    /// Cauchy stress \[Pa\]: the Kirchhoff stress over the volume ratio, which the small-strain law does not know.
    pub(crate) fn cauchy(&self, f: &Matrix3<f64>, history: &History) -> Matrix3<f64> {
        let kirchhoff = self.kirchhoff(f, history);
        if matches!(self, Self::Linear(_)) { kirchhoff } else { kirchhoff / f.determinant() }
    }

    /// Carries the history over a step.
    #[inline(always)]
    pub(crate) fn update(&self, history: &mut History, increment: &Increment) {
        match self {
            Self::Linear(lame) => linear::update(lame, history, increment),
            Self::Hypo(lame) => hypo::update(lame, history, increment),
            Self::NeoHookean(_) | Self::Hencky(_) => {}
        }
    }

    /// Stored energy for a unit of undeformed volume \[J/m3\].
    pub(crate) fn energy(&self, f: &Matrix3<f64>, history: &History) -> f64 {
        match self {
            Self::Linear(lame) => linear::energy(lame, history),
            Self::Hypo(_) => hypo::energy(history),
            Self::NeoHookean(lame) => neo_hookean::energy(lame, f),
            Self::Hencky(lame) => hencky::energy(lame, f),
        }
    }

    /// Modulus of the fastest wave, for a unit of undeformed volume \[Pa\]: what limits the step.
    #[inline(always)]
    pub(crate) fn wave_modulus(&self, f: &Matrix3<f64>) -> f64 {
        match self {
            Self::Linear(lame) | Self::Hencky(lame) => lame.wave_modulus(),
            Self::Hypo(lame) => lame.wave_modulus() * f.determinant().max(1.0),
            Self::NeoHookean(lame) => neo_hookean::wave_modulus(lame, f),
        }
    }
}

/// The stress at the head of a history.
#[inline(always)]
fn stress_of(h: &History) -> Matrix3<f64> {
    Matrix3::new(h[0], h[5], h[4], h[5], h[1], h[3], h[4], h[3], h[2])
}

#[inline(always)]
fn store_stress(h: &mut History, s: &Matrix3<f64>) {
    h[..6].copy_from_slice(&[s[(0, 0)], s[(1, 1)], s[(2, 2)], s[(1, 2)], s[(0, 2)], s[(0, 1)]]);
}

#[inline(always)]
fn symmetric(a: &Matrix3<f64>) -> Matrix3<f64> {
    (a + a.transpose()) * 0.5
}

#[cfg(test)]
mod tests;
