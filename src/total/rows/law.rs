//! Material laws for eight points at once: displacement gradients become stresses, in place.

use super::Block;
use crate::material::point::{Plane, Start, identity};
use crate::material::{Embedding, Lame, Material, embed};
use crate::total::explicit::steepness;
use crate::total::wide::{LANES, Lane, Portable, Wide};

/// A material with what its kernel needs.
#[derive(Debug, Clone, Copy)]
pub(super) struct Law {
    material: Material,
    embedding: Embedding,
    lame: Lame,
    pub(super) kind: Kind,
}

/// How stresses are computed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    /// Eight points at once.
    NeoHookean,
    /// One by one.
    Other,
}

/// What a sweep has come across.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Seen {
    /// Whether every point had an answer.
    pub(crate) good: bool,
    /// Whether to look for the stiffest point.
    pub(crate) looks: bool,
    /// Square of the largest ratio of the wave speed, seen from time 0, to that at time 0 \[-\].
    pub(super) ratio: Lane,
}

impl Seen {
    pub(crate) fn nothing(looks: bool) -> Self {
        Self { good: true, looks, ratio: Lane([1.0; LANES]) }
    }

    pub(crate) fn merge(&mut self, other: &Self) {
        self.good &= other.good;
        for i in 0..LANES {
            self.ratio.0[i] = self.ratio.0[i].max(other.ratio.0[i]);
        }
    }

    /// Ratio of the stable step to that at time 0.
    pub(crate) fn pace(&self) -> f64 {
        1.0 / self.ratio.0.iter().fold(1.0, |most: f64, ratio| most.max(*ratio)).sqrt()
    }
}

impl Law {
    /// The law where its answer depends on the deformation alone, not on what was before; that of small strain is not worked out at points (see
    /// [`small_strain`]).
    pub(super) fn new(material: &Material, embedding: Embedding) -> Option<Self> {
        let kind = match material {
            Material::NeoHookean(_) if !embedding.stress_free => Kind::NeoHookean,
            Material::NeoHookean(_) | Material::Hencky(_) => Kind::Other,
            Material::Linear(_) | Material::Hypo(_) => return None,
        };
        Some(Self { material: *material, embedding, lame: *material.lame(), kind })
    }

    /// Stress and ratio of wave speeds at one point; `None` where there is none.
    fn answer<const D: usize>(&self, new: &Plane<D>, looks: bool) -> Option<(Plane<D>, f64)> {
        let start = Start { deformation: identity(), history: [0.0; 7], lateral: 1.0 };
        let answer = self.material.answer(self.embedding, &start, new).ok()?;
        let ratio = if looks { steepness(&self.material, &embed(new, answer.lateral)) } else { 1.0 };
        Some((answer.stress, ratio))
    }
}

/// The constants of the law of small strain, P = lambda tr(e) I + 2 mu e, in its plane or along its axis: where that is stress-free across, it is a
/// law with another first constant. `None` for other laws.
pub(super) fn small_strain(material: &Material, embedding: Embedding) -> Option<Lame> {
    let Material::Linear(Lame { lambda, mu }) = *material else { return None };
    let lambda = match embedding.dimension {
        _ if !embedding.stress_free => lambda,
        // Young's modulus along an axis
        1 => lambda * mu / (lambda + mu),
        // plane stress
        _ => 2.0 * lambda * mu / (lambda + 2.0 * mu),
    };
    Some(Lame { lambda, mu })
}

/// Compressible neo-Hookean solid: P = mu F + (lambda ln J - mu) F^-T (Bonet and Wood 2008, eq. 6.28, times F^-T).
#[inline(always)]
pub(super) fn neo_hookean<V: Wide, const D: usize>(law: &Law, points: &mut [Block<D>], seen: &mut Seen) {
    let Lame { lambda, mu } = law.lame;
    let (lambda, mu) = (V::splat(lambda), V::splat(mu));
    let one = V::splat(1.0);
    let (mut good, mut ratio) = (true, V::load(&seen.ratio));
    let share = V::splat(1.0 / law.lame.wave_modulus());
    for point in points {
        let mut f = [[V::zero(); D]; D];
        for k in 0..D {
            for i in 0..D {
                f[i][k] = V::load(&point[k][i]);
            }
            f[k][k] = f[k][k].add(one);
        }
        let mut cofactor = [[V::zero(); D]; D];
        let jacobian = if D > 2 {
            for i in 0..D {
                let (a, b) = ((i + 1) % 3, (i + 2) % 3);
                for k in 0..D {
                    let (c, d) = ((k + 1) % 3, (k + 2) % 3);
                    cofactor[i][k] = f[a][d].fnma(f[b][c], f[a][c].mul(f[b][d]));
                }
            }
            f[0][2].fma(cofactor[0][2], f[0][1].fma(cofactor[0][1], f[0][0].mul(cofactor[0][0])))
        } else {
            cofactor[0][0] = f[1][1];
            cofactor[1][1] = f[0][0];
            cofactor[0][1] = V::zero().sub(f[1][0]);
            cofactor[1][0] = V::zero().sub(f[0][1]);
            f[0][1].fnma(f[1][0], f[0][0].mul(f[1][1]))
        };
        good &= jacobian.above_zero();
        let (log, inverse) = jacobian.ln_and_inverse();
        let back = lambda.fma(log, V::zero().sub(mu)).mul(inverse);
        for i in 0..D {
            for k in 0..D {
                back.fma(cofactor[i][k], mu.mul(f[i][k])).store(&mut point[k][i]);
            }
        }
        if seen.looks {
            ratio = ratio.max(steep_modulus::<V, D>(&f, &cofactor, log, inverse, lambda, mu).mul(share));
        }
    }
    seen.good &= good;
    ratio.store(&mut seen.ratio);
}

/// Modulus of the fastest wave, seen from time 0 \[Pa\]: as [`steepness`].
#[inline(always)]
fn steep_modulus<V: Wide, const D: usize>(f: &[[V; D]; D], cofactor: &[[V; D]; D], log: V, inverse: V, lambda: V, mu: V) -> V {
    let one = V::splat(1.0);
    let missing = V::splat((3 - D) as f64);
    let (mut all, mut largest) = (missing, missing);
    let mut stretch = one;
    for k in 0..D {
        let (mut squares, mut row) = (V::zero(), V::zero());
        for i in 0..D {
            // row k of F^-1 is column k of F^-T
            let entry = cofactor[i][k].mul(inverse);
            squares = entry.fma(entry, squares);
            let mut product = V::zero();
            for j in 0..D {
                product = f[k][j].fma(f[i][j], product);
            }
            row = row.add(product.abs());
        }
        all = all.add(squares);
        largest = largest.max(squares);
        stretch = stretch.max(row);
    }
    let steep = all.min(V::splat(1e12)).mul(V::splat(1.0 / 3.0)).max(largest);
    let pressed = V::zero().sub(log).max(V::zero());
    let modulus = mu.add(mu).fma(stretch, lambda.fma(pressed, lambda));
    modulus.mul(steep)
}

/// Any law, point by point.
pub(super) fn one_by_one<const D: usize>(law: &Law, points: &mut [Block<D>], seen: &mut Seen) {
    for point in points {
        for lane in 0..LANES {
            let new: Plane<D> = std::array::from_fn(|i| std::array::from_fn(|k| point[k][i].0[lane] + if i == k { 1.0 } else { 0.0 }));
            let answer = if law.embedding.dimension == 1 {
                // the second axis is the one that the scene has (see `Rows`)
                law.answer::<1>(&[[new[1][1]]], seen.looks).map(|([[stress]], ratio)| {
                    let mut all = [[0.0; D]; D];
                    all[1][1] = stress;
                    (all, ratio)
                })
            } else {
                law.answer(&new, seen.looks)
            };
            let Some((stress, ratio)) = answer else {
                seen.good = false;
                continue;
            };
            for i in 0..D {
                for k in 0..D {
                    point[k][i].0[lane] = stress[i][k];
                }
            }
            seen.ratio.0[lane] = seen.ratio.0[lane].max(ratio);
        }
    }
}

/// The kernel of a law. Unsafe to call where the processor lacks the instructions that it was chosen for.
pub(super) type Kernel<const D: usize> = unsafe fn(&Law, &mut [Block<D>], &mut Seen);

macro_rules! kernels {
    ($module:ident, $vector:ty $(, $features:literal)?) => {
        mod $module {
            use super::*;
            $(#[target_feature(enable = $features)])?
            pub(super) fn neo_hookean<const D: usize>(law: &Law, points: &mut [Block<D>], seen: &mut Seen) {
                super::neo_hookean::<$vector, D>(law, points, seen);
            }
        }
    };
}
#[cfg(target_arch = "x86_64")]
kernels!(avx512, crate::total::wide::Avx512, "avx512f");
#[cfg(target_arch = "x86_64")]
kernels!(avx2, crate::total::wide::Avx2, "avx2,fma");
kernels!(portable, Portable);

impl Kind {
    /// Its kernel for these instructions.
    pub(super) fn kernel<const D: usize>(self, instructions: crate::total::wide::Instructions) -> Kernel<D> {
        use crate::total::wide::Instructions;
        match (self, instructions) {
            (Self::Other, _) => one_by_one::<D>,
            #[cfg(target_arch = "x86_64")]
            (Self::NeoHookean, Instructions::Avx512) => avx512::neo_hookean::<D>,
            #[cfg(target_arch = "x86_64")]
            (Self::NeoHookean, Instructions::Avx2) => avx2::neo_hookean::<D>,
            (Self::NeoHookean, Instructions::Portable) => portable::neo_hookean::<D>,
        }
    }
}
