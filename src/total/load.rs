//! Loads as forces on the nodes of a body.

use super::reference::{Point, Reference, Vectors};
use crate::component::StepError;
use crate::model::{Load, Model, Target};
use crate::state::State;
use crate::implicit::Matrix;
use nalgebra::{Matrix3, Vector3};

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

    /// Adds this share of minus the derivative of the load by the displacement \[N/m\]; tells whether it follows the body.
    pub(super) fn add_stiffness(
        &self,
        load: &Load,
        input: &[f64],
        model: &Model,
        bodies: &[&Reference],
        time: f64,
        displacement: &[[f64; 3]],
        share: f64,
        matrix: &mut Matrix,
    ) -> bool {
        let Self::Follower(points) = self else { return false };
        let d = model.dimension;
        let pressure = load.signal.value([0.0; 3], time, input)[0];
        let (mut nodes, mut functions, mut block) = (Vec::new(), Vec::new(), Vec::new());
        for (body, point, area) in points {
            nodes.clear();
            functions.clear();
            let mut f = Matrix3::identity();
            bodies[*body].each_slowly(point, |node, weight, slope| {
                for i in 0..d {
                    for k in 0..d {
                        f[(i, k)] += displacement[node][i] * slope[k];
                    }
                }
                nodes.push(node as u32);
                functions.push((weight, Vector3::from(slope)));
            });
            let Some(inverse) = f.try_inverse() else { continue };
            let back = inverse.transpose();
            // d cof F = J (F^-1 : dF) F^-T - J F^-T dF^T F^-T, with dF = e_k (x) slope
            let push = back * Vector3::from(*area) * (pressure * f.determinant());
            let rows = nodes.len() * d;
            block.clear();
            block.resize(rows * rows, 0.0);
            for (b, (_, slope)) in functions.iter().enumerate() {
                let along = back * slope;
                for k in 0..d {
                    let change = push * along[k] - along * push[k];
                    let column = &mut block[(b * d + k) * rows..][..rows];
                    for (a, (weight, _)) in functions.iter().enumerate() {
                        for i in 0..d {
                            column[a * d + i] += share * weight * change[i];
                        }
                    }
                }
            }
            matrix.add(&nodes, &block);
        }
        true
    }
}
