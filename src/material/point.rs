//! What a material point answers to its deformation: the first Piola-Kirchhoff stress, and for implicit steps its derivative.

use super::{Embedding, History, Increment, Material, embed, hencky, neo_hookean, store_stress, stress_of, symmetric};
use nalgebra::Matrix3;

/// A tensor of the plane or axis of the problem.
pub(crate) type Plane<const D: usize> = [[f64; D]; D];

/// Derivative of the stress: `[i][J][k][L]` is dP_iJ / dF_kL \[Pa\].
pub(crate) type Tangent<const D: usize> = [[Plane<D>; D]; D];

/// Why a point has no answer.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Trouble {
    /// The determinant of the deformation gradient is not above 0.
    Inverted(f64),
    /// No stress-free thickness was found.
    NoThickness,
}

/// A deformation from one state to another: what a point must know of the first.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Start<const D: usize> {
    /// Deformation gradient at the start of the step, where the history belongs to.
    pub(crate) deformation: Plane<D>,
    pub(crate) history: History,
    /// Stretch across the plane or axis; 1 unless it is stress-free.
    pub(crate) lateral: f64,
}

/// A point at the end of a step.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Answer<const D: usize> {
    /// First Piola-Kirchhoff stress \[Pa\].
    pub(crate) stress: Plane<D>,
    pub(crate) history: History,
    pub(crate) lateral: f64,
}

impl Material {
    /// The stress at deformation gradient `new`.
    #[inline]
    pub(crate) fn answer<const D: usize>(&self, across: Embedding, start: &Start<D>, new: &Plane<D>) -> Result<Answer<D>, Trouble> {
        let mut answer = Answer { stress: [[0.0; D]; D], history: start.history, lateral: start.lateral };
        let stress = match self {
            Self::Linear(lame) => {
                // small strain: what F - I is, not what its logarithm would be
                let strain = across.gradient(lame, &difference(new, &identity()));
                let stress = lame.stress(&symmetric(&strain));
                store_stress(&mut answer.history, &stress);
                stress
            }
            Self::Hypo(lame) => {
                let step = RateStep::new(across, lame, start, new)?;
                self.update(&mut answer.history, &Increment { gradient: step.gradient, jacobian: step.jacobian });
                answer.lateral = step.lateral;
                stress_of(&answer.history) * inverse_transpose(&embed(new, answer.lateral))?
            }
            Self::NeoHookean(_) | Self::Hencky(_) => {
                if across.stress_free {
                    answer.lateral = across.stress_free_stretch(self, new, start.lateral).ok_or(Trouble::NoThickness)?;
                }
                let f = embed(new, answer.lateral);
                let back = inverse_transpose(&f)?;
                self.kirchhoff(&f, &answer.history) * back
            }
        };
        answer.stress = cut(&stress);
        Ok(answer)
    }

    /// The derivative of the stress by the deformation gradient at its end.
    pub(crate) fn tangent<const D: usize>(
        &self,
        across: Embedding,
        start: &Start<D>,
        new: &Plane<D>,
        answer: &Answer<D>,
    ) -> Result<Tangent<D>, Trouble> {
        match self {
            Self::Linear(lame) => Ok(each(|df| lame.stress(&symmetric(&across.gradient(lame, df))))),
            Self::Hypo(lame) => {
                let step = RateStep::new(across, lame, start, new)?;
                let stress = stress_of(&answer.history);
                let back = inverse_transpose(&embed(new, answer.lateral))?;
                Ok(each(|df| {
                    let (change, lateral) = step.change(across, lame, start, df);
                    let mut df = embed(df, 0.0);
                    (D..3).for_each(|a| df[(a, a)] = lateral);
                    (change - stress * back * df.transpose()) * back
                }))
            }
            Self::NeoHookean(_) | Self::Hencky(_) => {
                let f = embed(new, answer.lateral);
                let back = inverse_transpose(&f)?;
                let moduli = Moduli::new(self, &f);
                let stress = self.kirchhoff(&f, &answer.history);
                Ok(each(|df| {
                    let l = moduli.condense::<D>(across, embed(df, 0.0) * back.transpose());
                    (moduli.change(&l) - stress * l.transpose()) * back
                }))
            }
        }
    }
}

/// Calls `f` for each unit change of the deformation gradient.
fn each<const D: usize>(mut f: impl FnMut(&Plane<D>) -> Matrix3<f64>) -> Tangent<D> {
    let mut tangent = [[[[0.0; D]; D]; D]; D];
    for k in 0..D {
        for l in 0..D {
            let mut unit = [[0.0; D]; D];
            unit[k][l] = 1.0;
            let change = f(&unit);
            for i in 0..D {
                for j in 0..D {
                    tangent[i][j][k][l] = change[(i, j)];
                }
            }
        }
    }
    tangent
}

/// How the Kirchhoff stress of a law with a potential changes with a small motion on top of a deformation.
pub(crate) enum Moduli {
    NeoHookean { lambda: f64, mu: f64, b: Matrix3<f64> },
    Hencky { lambda: f64, mu: f64, strain: hencky::StrainChange },
}

impl Moduli {
    /// Of a law with a potential at deformation gradient `f`.
    pub(crate) fn new(material: &Material, f: &Matrix3<f64>) -> Self {
        let lame = material.lame();
        let (lambda, mu) = (lame.lambda, lame.mu);
        match material {
            Material::Hencky(_) => Self::Hencky { lambda, mu, strain: hencky::StrainChange::new(f) },
            _ => Self::NeoHookean { lambda, mu, b: f * f.transpose() },
        }
    }

    /// Change of the Kirchhoff stress with the spatial gradient `l` of the motion.
    pub(crate) fn change(&self, l: &Matrix3<f64>) -> Matrix3<f64> {
        match self {
            Self::NeoHookean { lambda, mu, b } => neo_hookean::change(*lambda, *mu, b, l),
            Self::Hencky { lambda, mu, strain } => {
                let strain = strain.of(l);
                Matrix3::from_diagonal_element(lambda * strain.trace()) + strain * (2.0 * mu)
            }
        }
    }

    /// The motion with what happens across added, where that is stress-free.
    pub(crate) fn condense<const D: usize>(&self, across: Embedding, mut l: Matrix3<f64>) -> Matrix3<f64> {
        if across.stress_free {
            let mut unit = Matrix3::zeros();
            (D..3).for_each(|a| unit[(a, a)] = 1.0);
            let share = -self.change(&l)[(2, 2)] / self.change(&unit)[(2, 2)];
            l += unit * share;
        }
        l
    }
}

/// What a law with a potential answers to C = F^T F.
struct Potential {
    /// A deformation gradient with that C.
    f: Matrix3<f64>,
    /// Second Piola-Kirchhoff stress \[Pa\].
    stress: Matrix3<f64>,
}

/// Stress of Gonzalez (2000, Exact energy and momentum conserving algorithms for general models in nonlinear elasticity, eq. 4.5): at the
/// mean of C at both ends, with what is missing to the change of the stored energy added along the change of C. The law of small strain
/// is quadratic: for it the mean of both ends is enough.
struct Conserving {
    /// Deformation gradient in the middle.
    middle: Matrix3<f64>,
    end: Matrix3<f64>,
    at_middle: Potential,
    /// Change of C.
    change: Matrix3<f64>,
    /// Of the change; 0 where it is too small to divide by.
    squared: f64,
    /// What is missing to the change of the stored energy \[Pa\].
    missing: f64,
    stress: Matrix3<f64>,
}

/// Change of C, squared, below which there is nothing to divide by.
const SMALL_CHANGE: f64 = 1e-30;
/// Change of C, squared, from which on the difference of energies is exact enough: below, the rule of three points has errors of the
/// seventh power of the change.
const LARGE_CHANGE: f64 = 1e-4;

impl Material {
    fn potential<const D: usize>(&self, across: Embedding, c: &Matrix3<f64>, guess: f64) -> Result<Potential, Trouble> {
        let cholesky = (cut_and_fill::<D>(c)).cholesky().ok_or(Trouble::Inverted(c.determinant()))?;
        let plane: Plane<D> = cut(&cholesky.l().transpose());
        let lateral = if across.stress_free { across.stress_free_stretch(self, &plane, guess).ok_or(Trouble::NoThickness)? } else { 1.0 };
        let f = embed(&plane, lateral);
        let inverse = f.try_inverse().ok_or(Trouble::Inverted(f.determinant()))?;
        let stress = inverse * self.kirchhoff(&f, &[0.0; 7]) * inverse.transpose();
        Ok(Potential { f, stress: embed::<D>(&cut(&stress), 0.0) })
    }

    fn conserve<const D: usize>(&self, across: Embedding, start: &Start<D>, new: &Plane<D>) -> Result<Conserving, Trouble> {
        let (old, end) = (embed(&start.deformation, 0.0), embed(new, 0.0));
        let (before, after) = (old.transpose() * old, end.transpose() * end);
        let change = after - before;
        let squared = change.norm_squared();
        let at_middle = self.potential::<D>(across, &((before + after) * 0.5), start.lateral)?;
        let mut stress = at_middle.stress;
        let mut missing = 0.0;
        if squared > SMALL_CHANGE {
            let at = |share: f64| self.potential::<D>(across, &(before + change * share), start.lateral);
            missing = if squared > LARGE_CHANGE {
                let none = History::default();
                self.energy(&at(1.0)?.f, &none) - self.energy(&at(0.0)?.f, &none) - 0.5 * stress.dot(&change)
            } else {
                // a small difference of energies drowns in round-off; its integral, by three Gauss points, does not
                let side = 0.5 * 0.6f64.sqrt();
                let beside = at(0.5 - side)?.stress + at(0.5 + side)?.stress - stress * 2.0;
                0.5 * 5.0 / 18.0 * beside.dot(&change)
            };
            stress += change * (2.0 * missing / squared);
        }
        Ok(Conserving { middle: (old + end) * 0.5, end, at_middle, change, squared, missing, stress })
    }

    /// The stress that makes the work of a step the change of the stored energy, and turns with the body.
    pub(crate) fn conserving_stress<const D: usize>(
        &self,
        across: Embedding,
        start: &Start<D>,
        new: &Plane<D>,
    ) -> Result<Plane<D>, Trouble> {
        if self.history() > 0 {
            return Ok(self.answer(across, start, &combine(0.5, &start.deformation, 0.5, new))?.stress);
        }
        let conserving = self.conserve(across, start, new)?;
        Ok(cut(&(conserving.middle * conserving.stress)))
    }

    /// Its derivative by the deformation gradient at the end.
    pub(crate) fn conserving_tangent<const D: usize>(
        &self,
        across: Embedding,
        start: &Start<D>,
        new: &Plane<D>,
    ) -> Result<Tangent<D>, Trouble> {
        if self.history() > 0 {
            let middle = combine(0.5, &start.deformation, 0.5, new);
            let answer = self.answer(across, start, &middle)?;
            let tangent = self.tangent(across, start, &middle, &answer)?;
            return Ok(tangent.map(|a| a.map(|b| b.map(|c| c.map(|d| 0.5 * d)))));
        }
        let Conserving { middle, end, at_middle, change, squared, missing, stress } = self.conserve(across, start, new)?;
        let moduli = Moduli::new(self, &at_middle.f);
        let inverse = at_middle.f.try_inverse().ok_or(Trouble::Inverted(0.0))?;
        let kirchhoff = self.kirchhoff(&at_middle.f, &[0.0; 7]);
        let after = if squared > SMALL_CHANGE {
            self.potential::<D>(across, &(end.transpose() * end), start.lateral)?.stress
        } else {
            Matrix3::zeros()
        };
        Ok(each(|df| {
            let df = embed(df, 0.0);
            let dc = df.transpose() * end + end.transpose() * df;
            // of the stress in the middle, where C changes half as much
            let l = moduli.condense::<D>(across, inverse.transpose() * dc * inverse * 0.25);
            let full = inverse * (moduli.change(&l) - l * kirchhoff - kirchhoff * l.transpose()) * inverse.transpose();
            let mut ds = embed::<D>(&cut(&full), 0.0);
            if squared > SMALL_CHANGE {
                let more = 0.5 * (after.dot(&dc) - ds.dot(&change) - at_middle.stress.dot(&dc));
                ds += change * (2.0 * more / squared - 4.0 * missing * change.dot(&dc) / (squared * squared))
                    + dc * (2.0 * missing / squared);
            }
            df * stress * 0.5 + middle * ds
        }))
    }
}

/// The part of a tensor in the plane, and 1 on the rest of the diagonal.
fn cut_and_fill<const D: usize>(c: &Matrix3<f64>) -> Matrix3<f64> {
    embed::<D>(&cut(c), 1.0)
}

/// A step of the law of rate type, from the deformation gradient at its start to that at its end.
struct RateStep {
    increment: Matrix3<f64>,
    /// Inverse of the deformation gradient in the middle.
    inverse: Matrix3<f64>,
    /// Displacement of the step, derived by the place in its middle \[-\].
    gradient: Matrix3<f64>,
    jacobian: f64,
    lateral: f64,
}

impl RateStep {
    fn new<const D: usize>(across: Embedding, lame: &super::Lame, start: &Start<D>, new: &Plane<D>) -> Result<Self, Trouble> {
        let old = &start.deformation;
        let middle = embed(&combine(0.5, old, 0.5, new), 1.0);
        let increment = embed(&difference(new, old), 0.0);
        let inverse = middle.try_inverse().ok_or(Trouble::Inverted(0.0))?;
        let gradient = across.gradient(lame, &cut::<D>(&(increment * inverse)));
        let lateral = if across.stress_free { start.lateral * gradient[(2, 2)].exp() } else { start.lateral };
        let jacobian = middle.determinant() * (0.5 * (start.lateral + lateral)).powi(3 - D as i32);
        Ok(Self { inverse, gradient, jacobian, lateral, increment })
    }

    /// Changes of the Kirchhoff stress and of the stretch across with the deformation gradient at the end.
    fn change<const D: usize>(&self, across: Embedding, lame: &super::Lame, start: &Start<D>, df: &Plane<D>) -> (Matrix3<f64>, f64) {
        let df = embed(df, 0.0);
        let half = df * self.inverse * 0.5;
        let gradient = across.gradient(lame, &cut::<D>(&((df - self.increment * self.inverse * df * 0.5) * self.inverse)));
        let lateral = if across.stress_free { self.lateral * gradient[(2, 2)] } else { 0.0 };
        let mean = 0.5 * (start.lateral + self.lateral);
        let jacobian = self.jacobian * (half.trace() + (3 - D) as f64 * 0.5 * lateral / mean);
        (super::hypo::change(lame, &start.history, &self.gradient, self.jacobian, &gradient, jacobian), lateral)
    }
}

/// The part of a tensor that lies in the plane or axis.
pub(crate) fn cut<const D: usize>(full: &Matrix3<f64>) -> Plane<D> {
    std::array::from_fn(|i| std::array::from_fn(|j| full[(i, j)]))
}

pub(crate) fn identity<const D: usize>() -> Plane<D> {
    std::array::from_fn(|i| std::array::from_fn(|j| if i == j { 1.0 } else { 0.0 }))
}

pub(crate) fn combine<const D: usize>(s: f64, a: &Plane<D>, t: f64, b: &Plane<D>) -> Plane<D> {
    std::array::from_fn(|i| std::array::from_fn(|j| s * a[i][j] + t * b[i][j]))
}

fn difference<const D: usize>(a: &Plane<D>, b: &Plane<D>) -> Plane<D> {
    combine(1.0, a, -1.0, b)
}

/// F^-T of a deformation that is not inverted.
fn inverse_transpose(f: &Matrix3<f64>) -> Result<Matrix3<f64>, Trouble> {
    let det = f.determinant();
    // not `det <= 0`: NaN is trouble too
    let inverse = if det > 0.0 { f.try_inverse() } else { None };
    inverse.map(|inverse| inverse.transpose()).ok_or(Trouble::Inverted(det))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::material::Lame;
    use crate::scene::Plane as Across;

    fn answers<const D: usize>(plane: Across) {
        let across = Embedding::new(D, plane);
        let full = [[1.15, 0.2, -0.1], [0.05, 0.9, 0.15], [0.1, -0.12, 1.08]];
        let before = [[1.05, 0.1, -0.02], [-0.03, 0.97, 0.05], [0.04, -0.06, 1.02]];
        let lame = Lame { lambda: 3.0, mu: 2.0 };
        for material in [Material::Linear(lame), Material::Hypo(lame), Material::NeoHookean(lame), Material::Hencky(lame)] {
            let history = if material.history() > 0 { [0.3, -0.2, 0.1, 0.05, -0.07, 0.15, 0.0] } else { [0.0; 7] };
            let lateral = if across.stress_free { 0.97 } else { 1.0 };
            let start = Start::<D> { deformation: std::array::from_fn(|i| std::array::from_fn(|j| before[i][j])), history, lateral };
            let new: Plane<D> = std::array::from_fn(|i| std::array::from_fn(|j| full[i][j]));
            let at = |f: &Plane<D>| material.answer(across, &start, f).unwrap();
            let tangent = material.tangent(across, &start, &new, &at(&new)).unwrap();
            for k in 0..D {
                for l in 0..D {
                    let h = 1e-5;
                    let moved = |by: f64| {
                        let mut f = new;
                        f[k][l] += by;
                        at(&f).stress
                    };
                    let (up, down) = (moved(h), moved(-h));
                    for i in 0..D {
                        for j in 0..D {
                            let difference = (up[i][j] - down[i][j]) / (2.0 * h);
                            let error = (tangent[i][j][k][l] - difference).abs();
                            // central differences: h^2 times a third derivative of the size of the moduli
                            assert!(error < 1e-8, "{material:?} {D}D {plane:?} {i}{j}{k}{l}: {error:e} of {difference}");
                        }
                    }
                }
            }
        }
    }

    /// The work of the conserving stress over a step is the change of the stored energy; its tangent is its derivative.
    fn conserves<const D: usize>(plane: Across) {
        let across = Embedding::new(D, plane);
        let lame = Lame { lambda: 3.0, mu: 2.0 };
        let full = [[1.15, 0.2, -0.1], [0.05, 0.9, 0.15], [0.1, -0.12, 1.08]];
        let before = [[1.05, 0.1, -0.02], [-0.03, 0.97, 0.05], [0.04, -0.06, 1.02]];
        for material in [Material::Linear(lame), Material::NeoHookean(lame), Material::Hencky(lame)] {
            let at = |f: &Plane<D>| {
                let mut start = Start { deformation: identity(), history: [0.0; 7], lateral: 1.0 };
                let answer = material.answer(across, &start, f).unwrap();
                start = Start { deformation: *f, history: answer.history, lateral: answer.lateral };
                let energy = material.energy(&embed(f, answer.lateral), &answer.history);
                (start, energy)
            };
            let old: Plane<D> = std::array::from_fn(|i| std::array::from_fn(|j| before[i][j]));
            let new: Plane<D> = std::array::from_fn(|i| std::array::from_fn(|j| full[i][j]));
            let ((start, first), (_, last)) = (at(&old), at(&new));
            let stress = |f: &Plane<D>| material.conserving_stress(across, &start, f).unwrap();
            let p = stress(&new);
            let work: f64 = (0..D).flat_map(|i| (0..D).map(move |j| (i, j))).map(|(i, j)| p[i][j] * (new[i][j] - old[i][j])).sum();
            assert!((work - (last - first)).abs() < 1e-13, "{material:?} {D}D {plane:?}: {work} {}", last - first);
            let tangent = material.conserving_tangent(across, &start, &new).unwrap();
            for k in 0..D {
                for l in 0..D {
                    let h = 1e-5;
                    let moved = |by: f64| {
                        let mut f = new;
                        f[k][l] += by;
                        stress(&f)
                    };
                    let (up, down) = (moved(h), moved(-h));
                    for i in 0..D {
                        for j in 0..D {
                            let difference = (up[i][j] - down[i][j]) / (2.0 * h);
                            let error = (tangent[i][j][k][l] - difference).abs();
                            assert!(error < 1e-7, "{material:?} {D}D {plane:?} {i}{j}{k}{l}: {error:e} of {difference}");
                        }
                    }
                }
            }
        }
    }

    #[test]
    fn the_conserving_stress_conserves() {
        for plane in [Across::Strain, Across::Stress] {
            conserves::<1>(plane);
            conserves::<2>(plane);
        }
        conserves::<3>(Across::Strain);
    }

    #[test]
    fn tangents_are_derivatives_of_stresses() {
        for plane in [Across::Strain, Across::Stress] {
            answers::<1>(plane);
            answers::<2>(plane);
        }
        answers::<3>(Across::Strain);
    }
}
