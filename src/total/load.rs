//! Loads as forces on the nodes of a body.

use super::fast::Fast;
use super::reference::{Point, Reference, Vectors};
use crate::component::StepError;
use crate::implicit::Matrix;
use crate::model::{Anchor, Load, Model, SurfacePoint, Target};
use crate::state::State;
use nalgebra::{Matrix3, Vector3};

/// Where loads find their particles.
pub(super) struct Host<'a> {
    pub(super) model: &'a Model,
    pub(super) state: &'a State,
    pub(super) bodies: &'a [&'a Reference],
    /// Place in memory by particle id.
    pub(super) lookup: &'a [u32],
    /// Whether the reference is the configuration at the start of a step.
    pub(super) updated: bool,
}

impl Host<'_> {
    /// Grid of a particle, by id.
    fn grid(&self, id: u32) -> usize {
        if self.updated { 0 } else { usize::from(self.state.particles.body[id as usize]) }
    }

    /// Number of a particle on its grid, by id.
    fn number(&self, id: u32) -> usize {
        let row = self.lookup[id as usize] as usize;
        if self.updated { row } else { row - self.model.bodies[self.grid(id)].particles.start }
    }

    /// A point that hangs on a particle: where its functions are taken, how far it is from there \[m\], and the deformation gradient there.
    /// On the grid of the scene they are taken at the particle: nodes further out may have no mass.
    fn hang(&self, anchor: &Anchor) -> (Point, Vector3<f64>, Matrix3<f64>) {
        let reference = self.bodies[self.grid(anchor.particle)];
        if self.updated {
            let (place, f) = crate::step::load::place_of(self.model, self.state, self.lookup, anchor);
            let row = self.lookup[anchor.particle as usize] as usize;
            return (reference.particle(row), place - Vector3::from(self.state.particles.position.row::<3>(row)), f);
        }
        let host = self.model.reference(anchor.particle);
        (reference.point(std::array::from_fn(|a| host[a] + anchor.offset[a])), Vector3::zeros(), Matrix3::identity())
    }
}

/// How a load acts on nodes.
#[derive(Debug)]
pub(super) enum Action {
    /// As much of each component of its value on each node: mass, area or 1.
    Fixed(Vec<(u32, f64)>),
    /// A value for each particle: its id, its grid, its number there, its mass.
    Varying(Vec<(u32, usize, usize, f64)>),
    /// A traction that varies along a surface.
    Dead(Vec<Piece>),
    /// Pressure on pieces of area that follow the body.
    Follower(Vec<Piece>),
}

/// A piece of a surface.
#[derive(Debug)]
pub(super) struct Piece {
    /// Its grid.
    body: usize,
    /// Where it is at time 0 \[m\].
    place: [f64; 3],
    at: Point,
    /// From there to the piece \[m\].
    arm: Vector3<f64>,
    /// Outward normal times area at time 0 \[m2\].
    area: Vector3<f64>,
    /// Deformation gradient of the reference.
    base: Matrix3<f64>,
}

impl Action {
    pub(super) fn new(load: &Load, host: &Host<'_>) -> Self {
        let mut fixed = std::collections::BTreeMap::<u32, f64>::new();
        let mut add = |reference: &Reference, point: &Point, arm: Vector3<f64>, share: f64| {
            reference.each_slowly(point, |node, weight, slope| {
                *fixed.entry(node as u32).or_default() += share * (weight + arm.dot(&Vector3::from(slope)));
            });
        };
        let mass = |id: u32| host.state.particles.mass[host.lookup[id as usize] as usize];
        let all: Vec<u32>;
        match &load.target {
            Target::Gravity | Target::BodyForce(_) => {
                let members = if let Target::BodyForce(members) = &load.target {
                    members
                } else {
                    all = (0..host.lookup.len() as u32).collect();
                    &all
                };
                if load.signal.varies_in_space() {
                    return Self::Varying(members.iter().map(|&id| (id, host.grid(id), host.number(id), mass(id))).collect());
                }
                for &id in members {
                    let reference = host.bodies[host.grid(id)];
                    add(reference, &reference.particle(host.number(id)), Vector3::zeros(), mass(id));
                }
            }
            Target::Traction(points) if load.signal.varies_in_space() => {
                return Self::Dead(points.iter().map(|point| Piece::new(point, host)).collect());
            }
            Target::Traction(points) => {
                for point in points {
                    let reference = host.bodies[host.grid(point.anchor.particle)];
                    let (at, arm, _) = host.hang(&point.anchor);
                    add(reference, &at, arm, Vector3::from(point.area).norm());
                }
            }
            Target::Pressure(points) => {
                return Self::Follower(points.iter().map(|point| Piece::new(point, host)).collect());
            }
            Target::PointForce(anchor) => {
                let (at, arm, _) = host.hang(anchor);
                add(host.bodies[host.grid(anchor.particle)], &at, arm, 1.0);
            }
        }
        Self::Fixed(fixed.into_iter().collect())
    }

    /// Appends what the forces of a load at a time are computed from: if that is the same, so are they. NaN where they follow the body.
    pub(super) fn source(&self, load: &Load, input: &[f64], time: f64, to: &mut Vec<f64>) {
        match self {
            Self::Fixed(_) => to.extend(load.signal.value([0.0; 3], time, input)),
            Self::Varying(_) | Self::Dead(_) => to.push(time),
            Self::Follower(_) => to.push(f64::NAN),
        }
    }

    /// Adds the forces of a load at the time of the state; `fast`, where bodies have fast sums.
    pub(super) fn add(
        &self,
        load: &Load,
        input: &[f64],
        model: &Model,
        bodies: &[&Reference],
        time: f64,
        displacement: &[[f64; 3]],
        fast: Option<&Fast>,
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
                let places: Vec<[f64; 3]> = members.iter().map(|member| model.reference(member.0)).collect();
                let mut values = load.signal.values(&places, time, input);
                for value in &mut values {
                    *value = finite(*value)?;
                }
                let Some(fast) = fast else {
                    for (&(_, body, number, mass), value) in members.iter().zip(&values) {
                        bodies[body].each_slowly(&bodies[body].particle(number), |node, weight, _| {
                            for a in 0..d {
                                force[node][a] += mass * weight * value[a];
                            }
                        });
                    }
                    return Ok(());
                };
                for (number, body) in model.bodies.iter().enumerate() {
                    let mut field = vec![[0.0; 3]; body.particles.len()];
                    let own = members.iter().zip(&values).filter(|(member, _)| member.1 == number);
                    own.for_each(|(member, value)| field[member.2] = *value);
                    fast.spread(number, &field, force);
                }
            }
            Self::Dead(points) => {
                let places: Vec<[f64; 3]> = points.iter().map(|piece| piece.place).collect();
                for (piece, value) in points.iter().zip(load.signal.values(&places, time, input)) {
                    let value = finite(value)?;
                    let area = piece.area.norm();
                    bodies[piece.body].each_slowly(&piece.at, |node, weight, slope| {
                        let weight = weight + piece.arm.dot(&Vector3::from(slope));
                        for a in 0..d {
                            force[node][a] += weight * area * value[a];
                        }
                    });
                }
            }
            Self::Follower(points) => {
                for piece in points {
                    let [pressure, ..] = finite(load.signal.value(piece.place, time, input))?;
                    let f = piece.deform(bodies, d, displacement) * piece.base;
                    // Nanson: n da = J F^-T N dA
                    let push = crate::step::load::cofactor(&f) * piece.area * -pressure;
                    bodies[piece.body].each_slowly(&piece.at, |node, weight, slope| {
                        let weight = weight + piece.arm.dot(&Vector3::from(slope));
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
        let (mut nodes, mut functions, mut block) = (Vec::new(), Vec::new(), Vec::new());
        for piece in points {
            let pressure = load.signal.value(piece.place, time, input)[0];
            nodes.clear();
            functions.clear();
            bodies[piece.body].each_slowly(&piece.at, |node, weight, slope| {
                nodes.push(node as u32);
                let slope = Vector3::from(slope);
                functions.push((weight + piece.arm.dot(&slope), slope));
            });
            let since = piece.deform(bodies, d, displacement);
            let f = since * piece.base;
            let (Some(inverse), Some(inverse_since)) = (f.try_inverse(), since.try_inverse()) else { continue };
            let back = inverse_since.transpose();
            // d cof F = J (F^-1 : dF) F^-T - J F^-T dF^T F^-T, with dF = e_k (x) slope on top of the reference
            let push = inverse.transpose() * piece.area * (pressure * f.determinant());
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
            bodies[piece.body].add(matrix, &nodes, d, &block);
        }
        true
    }
}

impl Piece {
    fn new(point: &SurfacePoint, host: &Host<'_>) -> Self {
        let (at, arm, base) = host.hang(&point.anchor);
        let (body, place) = (host.grid(point.anchor.particle), point.anchor.place(host.model));
        Self { body, place, at, arm, area: Vector3::from(point.area), base }
    }

    /// Deformation gradient since the reference.
    fn deform(&self, bodies: &[&Reference], dimension: usize, displacement: &[[f64; 3]]) -> Matrix3<f64> {
        let mut f = Matrix3::identity();
        bodies[self.body].each_slowly(&self.at, |node, _, slope| {
            for i in 0..dimension {
                for k in 0..dimension {
                    f[(i, k)] += displacement[node][i] * slope[k];
                }
            }
        });
        f
    }
}
