//! Finds the particles that loads and probes hang on, and the points of loaded surfaces.

use super::{Anchor, Body, Load, Probe, Quadrilateral, Signal, SurfacePoint, Target, fault, side_of_box};
use crate::basis::Axis;
use crate::quadrature::gauss_legendre;
use crate::scene::{self, FacePoint, Fault, Shape};
use crate::state::Table;

/// Finds the particles that loads and probes hang on.
pub(super) struct Finder<'a> {
    pub(super) reference: &'a Table,
    pub(super) bodies: &'a [Body],
    pub(super) scene: &'a scene::Scene,
}

impl Finder<'_> {
    pub(super) fn load(&self, name: &str, load: &scene::Load) -> Result<Load, Fault> {
        let dimension = self.scene.dimension;
        let (target, signal, key) = match load {
            scene::Load::Gravity(value) => (Target::Gravity, value, "gravity"),
            scene::Load::BodyForce(b) => {
                let inside = |p: &usize| b.region.as_ref().is_none_or(|r| r.contains(&self.reference.row::<3>(*p)[..dimension], 0.0));
                let members: Vec<u32> = self.body(&b.body).particles.clone().filter(inside).map(|p| p as u32).collect();
                if members.is_empty() {
                    return Err(Fault::new(format!("load.{name}.body_force.region"), "holds no particle of the body"));
                }
                (Target::BodyForce(members), &b.value, "body_force.value")
            }
            scene::Load::Traction(t) => (Target::Traction(self.surface(name, "traction", &t.body, &t.face)?), &t.value, "traction.value"),
            scene::Load::Pressure(t) => (Target::Pressure(self.surface(name, "pressure", &t.body, &t.face)?), &t.value, "pressure.value"),
            scene::Load::PointForce(f) => {
                let mut anchor = self.anchor(self.body(&f.body), &f.at);
                if !self.scene.method.is_total() {
                    // the papers' way: the force acts at the particle itself
                    anchor.offset = [0.0; 3];
                }
                (Target::PointForce(anchor), &f.value, "point_force.value")
            }
        };
        let side = match load {
            scene::Load::Traction(scene::Traction { body, face, .. }) | scene::Load::Pressure(scene::Pressure { body, face, .. }) => {
                self.scene.body.get_index_of(body).and_then(|number| super::side(self.bodies, self.scene, number, face))
            }
            _ => None,
        };
        let target = match target {
            Target::Traction(_) if side.is_some() => Target::Traction(Vec::new()),
            Target::Pressure(_) if side.is_some() => Target::Pressure(Vec::new()),
            target => target,
        };
        let signal = Signal::new(signal).map_err(fault(format!("load.{name}.{key}")))?;
        let start = signal.value([0.0; 3], 0.0, &[]);
        if !signal.varies_in_space() && start.iter().any(|v| !v.is_finite()) {
            return Err(Fault::new(format!("load.{name}.{key}"), format!("is {:?} at t = 0; it must be finite", &start[..dimension])));
        }
        Ok(Load { name: name.into(), target, signal, side })
    }

    pub(super) fn probe(&self, name: &str, probe: &scene::Probe) -> Probe {
        let body = probe.body.as_ref().map_or(&self.bodies[0], |b| self.body(b));
        Probe { name: name.into(), anchor: self.anchor(body, &probe.at) }
    }

    fn body(&self, name: &str) -> &Body {
        let index = self.scene.body.get_index_of(name).unwrap_or(0);
        &self.bodies[index]
    }

    /// Points on a face, as far apart as the particles, each hung on its nearest particle.
    fn surface(&self, load: &str, kind: &str, body: &str, face: &str) -> Result<Vec<SurfacePoint>, Fault> {
        let described = &self.scene.body[body];
        let axes = &self.body(body).axes;
        let spacing: Vec<f64> = self.body(body).half[..axes.len()].iter().map(|half| 2.0 * half).collect();
        let points = match &described.shape {
            shape if self.body(body).map.is_some() => self.body(body).map.as_ref().map_or_else(Vec::new, |map| {
                let points = map.side(shape, face).map_or_else(Vec::new, |name| side(name, axes));
                points.iter().map(|point| bend(map, point)).collect()
            }),
            _ if let Some(cut) = self.body(body).fit.cut() => cut.face_points(face),
            Shape::Box { .. } if self.scene.method.is_total() => side(face, axes),
            shape => shape.faces().into_iter().find(|f| f.name == face).map(|f| f.points(&spacing)).unwrap_or_default(),
        };
        if points.is_empty() {
            return Err(Fault::new(format!("load.{load}.{kind}.face"), format!("`{face}` of body `{body}` has no area on its surface")));
        }
        let near = Neighbours::new(self.reference, self.body(body));
        // A point half-way between particles is shared by them, so that a symmetric body is loaded symmetrically.
        let mut shares = Vec::new();
        for point in &points {
            let hosts = near.hosts(&point.position);
            let mut area = [0.0; 3];
            for (to, from) in area.iter_mut().zip(&point.area) {
                *to = from / hosts.len() as f64;
            }
            shares.extend(hosts.into_iter().map(|anchor| SurfacePoint { anchor, area }));
        }
        Ok(shares)
    }

    fn anchor(&self, body: &Body, at: &[f64]) -> Anchor {
        Neighbours::new(self.reference, body).anchor(at)
    }
}

/// The particles of a body by grid cell, to find the nearest one to a point.
struct Neighbours<'a> {
    reference: &'a Table,
    axes: &'a [Axis],
    map: Option<&'a Quadrilateral>,
    cells: std::collections::HashMap<[i32; 3], Vec<u32>>,
}

impl<'a> Neighbours<'a> {
    fn new(reference: &'a Table, body: &'a Body) -> Self {
        let mut near = Self { reference, axes: &body.axes, map: body.map.as_ref(), cells: std::collections::HashMap::new() };
        for p in body.particles.clone() {
            let cell = near.cell(&reference.row::<3>(p));
            near.cells.entry(cell).or_default().push(p as u32);
        }
        near
    }

    fn cell(&self, place: &[f64]) -> [i32; 3] {
        let mut cell = [0; 3];
        let bent = self.map.map(|map| map.inverse([place[0], place[1], 0.0]));
        let place = bent.as_ref().map_or(place, |at| at.as_slice());
        for (a, axis) in self.axes.iter().enumerate() {
            cell[a] = axis.cell(place[a]).0;
        }
        cell
    }

    /// Hangs a point on its nearest particle, the one with the smallest id among equals.
    fn anchor(&self, at: &[f64]) -> Anchor {
        self.hosts(at)[0]
    }

    /// Hangs a point on each of its nearest particles, by id; they are as near as each other up to round-off.
    fn hosts(&self, at: &[f64]) -> Vec<Anchor> {
        let mut place = [0.0; 3];
        place[..at.len()].copy_from_slice(at);
        let offset = |p: u32| -> [f64; 3] {
            let x = self.reference.row::<3>(p as usize);
            std::array::from_fn(|a| place[a] - x[a])
        };
        let distance = |p: u32| offset(p).iter().map(|d| d * d).sum::<f64>().sqrt();
        let home = self.cell(at);
        let around = (0..27).map(|k| [home[0] + k / 9 - 1, home[1] + k / 3 % 3 - 1, home[2] + k % 3 - 1]);
        let mut candidates: Vec<u32> = around.filter_map(|cell| self.cells.get(&cell)).flatten().copied().collect();
        if candidates.is_empty() {
            candidates = self.cells.values().flatten().copied().collect();
        }
        candidates.sort_unstable();
        let nearest = candidates.iter().map(|&p| distance(p)).fold(f64::INFINITY, f64::min);
        let tie = 1e-9 * Axis::smallest_cell(self.axes);
        let hosts = candidates.into_iter().filter(|&p| distance(p) <= nearest + tie);
        hosts.map(|particle| Anchor { particle, offset: offset(particle) }).collect()
    }
}

/// A point of the surface of a bent grid, in space.
fn bend(map: &Quadrilateral, point: &FacePoint) -> FacePoint {
    let at = [point.position[0], point.position[1], 0.0];
    // Nanson: n dA = J F^-T N dA0
    let area = crate::step::load::cofactor(&map.jacobian(at)) * nalgebra::Vector3::new(point.area[0], point.area[1], 0.0);
    FacePoint { position: map.place(at)[..2].to_vec(), area: vec![area[0], area[1]] }
}

/// Gauss points on a side of the box that a grid fills, as many in a cell as integrate the functions exactly.
fn side(name: &str, axes: &[Axis]) -> Vec<FacePoint> {
    let Some((axis, upper)) = side_of_box(name) else { return Vec::new() };
    let end = axes[axis].clamped(if upper { f64::INFINITY } else { f64::NEG_INFINITY });
    let mut area = vec![0.0; axes.len()];
    area[axis] = if upper { 1.0 } else { -1.0 };
    let mut points = vec![FacePoint { position: vec![end; axes.len()], area }];
    for (a, along) in axes.iter().enumerate().filter(|(a, _)| *a != axis) {
        let rule = gauss_legendre(along.width());
        let place = |cell: i32, xi: f64| along.origin() + along.cell_size() * (f64::from(cell) + xi);
        let line = (0..along.cells()).flat_map(|cell| rule.iter().map(move |(xi, weight)| (place(cell, *xi), weight * along.cell_size())));
        let line: Vec<(f64, f64)> = line.collect();
        let widen = |point: &FacePoint| -> Vec<FacePoint> {
            let at = |&(x, share): &(f64, f64)| {
                let mut point = point.clone();
                point.position[a] = x;
                point.area.iter_mut().for_each(|v| *v *= share);
                point
            };
            line.iter().map(at).collect()
        };
        points = points.iter().flat_map(widen).collect();
    }
    points
}
