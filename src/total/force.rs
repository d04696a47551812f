//! Forces of a body on its nodes: from the stresses, and from loads.

use super::reference::{Point, Reference, Vectors};
use crate::component::StepError;
use crate::material::{Embedding, History, Increment, Material, embed};
use crate::model::{Load, Model, Target};
use crate::state::{Particles, State};
use nalgebra::{Matrix3, Vector3};

/// What the sum over the particles of a body needs.
pub(super) struct Task<'a> {
    pub(super) reference: &'a Reference,
    pub(super) material: &'a Material,
    pub(super) embedding: Embedding,
    pub(super) particles: &'a mut Particles,
    /// First particle of the body.
    pub(super) first: usize,
    pub(super) last: usize,
    pub(super) displacement: &'a [[f64; 3]],
    /// \[N\], added to.
    pub(super) force: &'a mut [[f64; 3]],
}

/// Why a particle cannot be gone on with.
pub(super) struct Trouble {
    pub(super) particle: usize,
    /// Determinant of its deformation gradient; `None` where no stress-free thickness was found.
    pub(super) det: Option<f64>,
}

/// Adds the internal forces, f_i = -sum_p V_p P_p grad N_i, with P = tau F^-T, and carries deformation and history of the particles along.
pub(super) type Sweep = fn(Task<'_>) -> Result<(), Trouble>;

/// The sum for a dimension and a width.
pub(super) fn sweep(dimension: usize, width: usize) -> Sweep {
    match (dimension, width) {
        (1, 2) => add::<1, 2>,
        (1, 3) => add::<1, 3>,
        (1, 4) => add::<1, 4>,
        (1, 5) => add::<1, 5>,
        (1, _) => add::<1, 6>,
        (2, 2) => add::<2, 2>,
        (2, 3) => add::<2, 3>,
        (2, 4) => add::<2, 4>,
        (2, 5) => add::<2, 5>,
        (2, _) => add::<2, 6>,
        (_, 2) => add::<3, 2>,
        (_, 3) => add::<3, 3>,
        (_, 4) => add::<3, 4>,
        (_, 5) => add::<3, 5>,
        (_, _) => add::<3, 6>,
    }
}

fn add<const D: usize, const W: usize>(task: Task<'_>) -> Result<(), Trouble> {
    let Task { reference, material, embedding, particles, first, last, displacement, force } = task;
    for p in first..last {
        let point = reference.particle(p - first);
        let mut gradient = [[0.0; D]; D];
        reference.each::<D, W>(&point, |node, _, slope| {
            for i in 0..D {
                for k in 0..D {
                    gradient[i][k] += displacement[node][i] * slope[k];
                }
            }
        });
        let old: [f64; 9] = particles.deformation.row(p);
        let mut new = [[0.0; D]; D];
        for i in 0..D {
            for k in 0..D {
                new[i][k] = gradient[i][k] + if i == k { 1.0 } else { 0.0 };
                particles.deformation.column_mut(i * D + k)[p] = new[i][k];
            }
        }
        let mut history: History = particles.history.row(p);
        let mut lateral = if embedding.stress_free { particles.lateral.column(0)[p] } else { 1.0 };
        let stress = match material {
            // small strain: what F - I is, not what its logarithm would be
            Material::Linear(lame) => {
                let strain = embedding.gradient(lame, &gradient);
                material.small_strain(&mut history, &strain);
                particles.history.set_row(p, &history);
                material.kirchhoff(&Matrix3::identity(), &history)
            }
            Material::Hypo(lame) => {
                let old: [[f64; D]; D] = std::array::from_fn(|i| std::array::from_fn(|k| old[i * D + k]));
                let step: [[f64; D]; D] = std::array::from_fn(|i| std::array::from_fn(|k| new[i][k] - old[i][k]));
                let middle: [[f64; D]; D] = std::array::from_fn(|i| std::array::from_fn(|k| 0.5 * (new[i][k] + old[i][k])));
                let (middle, step) = (embed(&middle, 1.0), embed(&step, 0.0));
                let Some(inverse) = middle.try_inverse() else { return Err(Trouble { particle: p, det: Some(0.0) }) };
                let along = step * inverse;
                let in_plane: [[f64; D]; D] = std::array::from_fn(|i| std::array::from_fn(|k| along[(i, k)]));
                let gradient = embedding.gradient(lame, &in_plane);
                let before = lateral;
                if embedding.stress_free {
                    lateral *= gradient[(2, 2)].exp();
                    particles.lateral.column_mut(0)[p] = lateral;
                }
                let across = (0.5 * (before + lateral)).powi(3 - D as i32);
                material.update(&mut history, &Increment { gradient, jacobian: middle.determinant() * across });
                particles.history.set_row(p, &history);
                let f = embed(&new, lateral);
                material.kirchhoff(&f, &history) * inverse_transpose(&f, p)?
            }
            Material::NeoHookean(_) | Material::Hencky(_) => {
                if embedding.stress_free {
                    lateral = embedding.stress_free_stretch(material, &new, lateral).ok_or(Trouble { particle: p, det: None })?;
                    particles.lateral.column_mut(0)[p] = lateral;
                }
                let f = embed(&new, lateral);
                let back = inverse_transpose(&f, p)?;
                material.kirchhoff(&f, &history) * back
            }
        };
        let volume = particles.volume[p];
        let first_piola: [[f64; D]; D] = std::array::from_fn(|i| std::array::from_fn(|k| volume * stress[(i, k)]));
        reference.each::<D, W>(&point, |node, _, slope| {
            for i in 0..D {
                for k in 0..D {
                    force[node][i] -= first_piola[i][k] * slope[k];
                }
            }
        });
    }
    Ok(())
}

/// F^-T of a deformation that is not inverted.
fn inverse_transpose(f: &Matrix3<f64>, particle: usize) -> Result<Matrix3<f64>, Trouble> {
    let det = f.determinant();
    // not `det <= 0`: NaN is trouble too
    let inverse = if det > 0.0 { f.try_inverse() } else { None };
    inverse.map(|inverse| inverse.transpose()).ok_or(Trouble { particle, det: Some(det) })
}

/// How a load acts on nodes.
#[derive(Debug)]
pub(super) enum Action {
    /// As much of each component of its value on each node: mass, area or 1.
    Fixed(Vec<(u32, f64)>),
    /// A value for each particle: its body, its number in the body, its mass.
    Varying(Vec<(usize, usize, f64)>),
    /// Pressure on pieces of area \[m2\] that follow the body: its body and its place.
    Follower(Vec<(usize, Point, [f64; 3])>),
}

impl Action {
    pub(super) fn new(load: &Load, model: &Model, bodies: &[&Reference], state: &State) -> Self {
        let body_of = |id: usize| usize::from(state.particles.body[id]);
        let number = |id: usize| id - model.bodies[body_of(id)].particles.start;
        let mut fixed = std::collections::BTreeMap::<u32, f64>::new();
        let mut add = |reference: &Reference, point: &Point, share: f64| {
            reference.each_slowly(point, |node, weight, _| *fixed.entry(node as u32).or_default() += share * weight);
        };
        let surface_place = |point: &crate::model::SurfacePoint| -> [f64; 3] {
            let host: [f64; 3] = model.reference(point.anchor.particle);
            std::array::from_fn(|a| host[a] + point.anchor.offset[a])
        };
        let all: Vec<u32>;
        match &load.target {
            Target::Gravity | Target::BodyForce(_) => {
                let members = if let Target::BodyForce(members) = &load.target {
                    members
                } else {
                    all = (0..state.particles.len() as u32).collect();
                    &all
                };
                if load.signal.varies_in_space() {
                    let of = |&id: &u32| (body_of(id as usize), number(id as usize), state.particles.mass[id as usize]);
                    return Self::Varying(members.iter().map(of).collect());
                }
                for &id in members {
                    let id = id as usize;
                    let reference = bodies[body_of(id)];
                    add(reference, &reference.particle(number(id)), state.particles.mass[id]);
                }
            }
            Target::Traction(points) => {
                for point in points {
                    let reference = bodies[body_of(point.anchor.particle as usize)];
                    add(reference, &reference.point(surface_place(point)), Vector3::from(point.area).norm());
                }
            }
            Target::Pressure(points) => {
                let of = |point: &crate::model::SurfacePoint| {
                    let body = body_of(point.anchor.particle as usize);
                    (body, bodies[body].point(surface_place(point)), point.area)
                };
                return Self::Follower(points.iter().map(of).collect());
            }
            Target::PointForce(anchor) => {
                let id = anchor.particle as usize;
                let reference = bodies[body_of(id)];
                add(reference, &reference.particle(number(id)), 1.0);
            }
        }
        Self::Fixed(fixed.into_iter().collect())
    }

    /// Adds the forces of a load at the time of the state.
    pub(super) fn add(
        &self,
        load: &Load,
        input: &[f64],
        model: &Model,
        bodies: &[&Reference],
        time: f64,
        displacement: &[[f64; 3]],
        force: &mut Vectors,
    ) -> Result<(), StepError> {
        let d = model.dimension;
        let finite = |value: [f64; 3]| {
            let good = value.iter().all(|v| v.is_finite());
            good.then_some(value).ok_or_else(|| StepError::BadLoad { time, load: load.name.clone() })
        };
        match self {
            Self::Fixed(shares) => {
                let value = finite(load.signal.value([0.0; 3], time, input))?;
                for &(node, share) in shares {
                    for a in 0..d {
                        force[node as usize][a] += share * value[a];
                    }
                }
            }
            Self::Varying(members) => {
                for &(body, number, mass) in members {
                    let id = (model.bodies[body].particles.start + number) as u32;
                    let value = finite(load.signal.value(model.reference(id), time, input))?;
                    bodies[body].each_slowly(&bodies[body].particle(number), |node, weight, _| {
                        for a in 0..d {
                            force[node][a] += mass * weight * value[a];
                        }
                    });
                }
            }
            Self::Follower(points) => {
                let [pressure, ..] = finite(load.signal.value([0.0; 3], time, input))?;
                for (body, point, area) in points {
                    let mut f = Matrix3::identity();
                    bodies[*body].each_slowly(point, |node, _, slope| {
                        for i in 0..d {
                            for k in 0..d {
                                f[(i, k)] += displacement[node][i] * slope[k];
                            }
                        }
                    });
                    // Nanson: n da = J F^-T N dA
                    let push = crate::step::load::cofactor(&f) * Vector3::from(*area) * -pressure;
                    bodies[*body].each_slowly(point, |node, weight, _| {
                        for a in 0..d {
                            force[node][a] += weight * push[a];
                        }
                    });
                }
            }
        }
        Ok(())
    }
}
