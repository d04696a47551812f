//! 2 COMPILE: Scene -> Model: immutable tables, and [`Needs`]: what this scene needs, and so what it does not.

mod lattice;
mod load;
mod sample;

pub(crate) use load::{Load, SPACE_TIME, Signal, SurfacePoint, Target};

use crate::basis::{Axis, Family};
use crate::material::{Embedding, Material};
use crate::scene::{self, Basis, Fault, Formula, Mass, MassSolver, Quadrature, SceneError, Shape, Transfer};
use crate::state::{Particles, State, Table};
pub(crate) use lattice::Lattice;
use lattice::lattice;
use sample::sample;

/// A scene made ready to run.
#[derive(Debug, Clone)]
pub(crate) struct Model {
    pub(crate) dimension: usize,
    pub(crate) embedding: Embedding,
    /// One an axis.
    pub(crate) axes: Vec<Axis>,
    pub(crate) bodies: Vec<Body>,
    pub(crate) boundaries: Vec<Boundary>,
    pub(crate) loads: Vec<Load>,
    pub(crate) probes: Vec<Probe>,
    /// Position at time 0 by particle id \[m\].
    pub(crate) reference: Table,
    pub(crate) integrator: scene::Integrator,
    pub(crate) transfer: Transfer,
    /// Share of FLIP; 0 for PIC and APIC.
    pub(crate) flip_share: f64,
    /// The velocity of nodes lighter than this takes no part of their force \[kg\].
    pub(crate) light: f64,
    /// Rows of a consistent mass matrix are lumped at nodes lighter than this \[kg\].
    pub(crate) lump_below: f64,
    pub(crate) masses: Masses,
    /// Mass matrix of the velocity projection.
    pub(crate) projection: MassRule,
    /// Mass matrix of the balance of momentum.
    pub(crate) balance: MassRule,
    /// Whether velocities are projected with the quadrature of the forces.
    pub(crate) quadrature_of_velocity: bool,
    /// Whether the domains of particles follow the deformation; `None` where the family has none.
    pub(crate) domains: Option<bool>,
    /// Coefficient of friction between bodies; `None` where they share one velocity field.
    pub(crate) friction: Option<f64>,
    pub(crate) pace: Pace,
    pub(crate) needs: Needs,
}

/// A body: its material and its particles by id.
#[derive(Debug, Clone)]
pub(crate) struct Body {
    pub(crate) name: String,
    pub(crate) material: Material,
    /// Density at time 0 \[kg/m3\].
    pub(crate) density: f64,
    pub(crate) particles: std::ops::Range<usize>,
    /// Half the length of the domain of a particle at time 0 \[m\].
    pub(crate) half: [f64; 3],
    /// The particles line by line; only where quadrature asks for it.
    pub(crate) lattice: Option<Lattice>,
}

/// What nodal masses may be.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Masses {
    /// Shape functions are nowhere negative.
    Positive,
    /// A negative one ends the run: the method breaks down there (Andersen 2007).
    MustBePositive,
    /// They may have any sign.
    Signed,
}

/// How a mass matrix is inverted.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum MassRule {
    /// Lumped.
    Lumped,
    /// This many terms of the series of the inverse.
    Series(usize),
    /// Solved down to a relative residual.
    Solved { solver: MassSolver, residual: f64 },
}

impl MassRule {
    fn new(mass: Mass, method: &scene::Method) -> Self {
        match mass {
            Mass::Lumped => Self::Lumped,
            Mass::Fmpm => Self::Series(method.fmpm_order.unwrap_or(2)),
            Mass::Consistent => {
                Self::Solved { solver: method.mass_solver.unwrap_or(MassSolver::Pcg), residual: method.mass_residual.unwrap_or(1e-9) }
            }
        }
    }
    pub(crate) fn is_lumped(self) -> bool {
        self == Self::Lumped
    }
}

/// Where and how the velocity of the grid is held.
#[derive(Debug, Clone)]
pub(crate) struct Boundary {
    pub(crate) name: String,
    region: Region,
    /// Velocity as a formula of t by axis; `None` where it is free.
    velocity: [Option<Formula>; 3],
}

#[derive(Debug, Clone)]
enum Region {
    /// The first or last function of an axis.
    Face {
        axis: usize,
        upper: bool,
    },
    Shape(Shape),
}

impl Boundary {
    /// Whether the node (for B-splines: the Greville point) lies in the region.
    pub(crate) fn holds(&self, axes: &[Axis], node: &[i32]) -> bool {
        match &self.region {
            Region::Face { axis, upper } => axes[*axis].ends(node[*axis], *upper),
            Region::Shape(shape) => {
                // a node outside the grid is held with the nearest one on its edge
                let place: Vec<f64> = node.iter().zip(axes).map(|(&i, axis)| axis.clamped(axis.node_position(i))).collect();
                let slack = 1e-9 * Axis::smallest_cell(axes);
                shape.contains(&place, slack)
            }
        }
    }
    /// Velocity along `axis` at `time` \[m/s\]; `None` where it is free.
    pub(crate) fn velocity(&self, axis: usize, time: f64) -> Option<f64> {
        self.velocity[axis].as_ref().map(|f| f.eval(&[time]))
    }
    /// Holds the same nodes, but still.
    pub(crate) fn stop(&mut self) {
        for formula in self.velocity.iter_mut().flatten() {
            *formula = Formula::constant(0.0);
        }
    }
    pub(crate) fn holds_axis(&self, axis: usize) -> bool {
        self.velocity[axis].is_some()
    }
}

/// A material point that hangs on the nearest particle: x = x_p + F_p offset.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Anchor {
    /// Id of the particle.
    pub(crate) particle: u32,
    /// From the particle to the point at time 0 \[m\].
    pub(crate) offset: [f64; 3],
}

/// A material point that is watched.
#[derive(Debug, Clone)]
pub(crate) struct Probe {
    pub(crate) name: String,
    pub(crate) anchor: Anchor,
}

/// How long the substeps are.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Pace {
    /// Always the same \[s\].
    Fixed(f64),
    /// A share of the stable step.
    Cfl(f64),
}

/// What this scene needs; what is false here costs nothing.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Needs {
    /// An affine matrix a particle (APIC).
    pub(crate) affine: bool,
    /// Nodal accelerations at the particles (FLIP; nearly empty nodes).
    pub(crate) increment: bool,
    /// A body force that differs from particle to particle.
    pub(crate) body_force: bool,
    /// Numbers a particle that the material laws keep.
    pub(crate) history: usize,
    /// A stretch across the plane.
    pub(crate) lateral: bool,
    /// Finding particles by id: probes, and all loads but gravity.
    pub(crate) lookup: bool,
    /// The work of loads and moving boundaries.
    pub(crate) work: bool,
    /// Quadrature points beside the particles.
    pub(crate) quadrature: bool,
    /// A mass matrix that is not diagonal.
    pub(crate) mass_matrix: bool,
    /// Nodes that follow others (serendipity elements).
    pub(crate) tied: bool,
}

impl Model {
    /// Compiles a scene that has passed its check, with the state at time 0.
    pub(crate) fn new(scene: &scene::Scene) -> Result<(Self, State), SceneError> {
        compile(scene).map_err(|fault| SceneError::Faults { file: None, faults: vec![fault] })
    }

    pub(crate) fn material(&self, body: u16) -> &Material {
        &self.bodies[body as usize].material
    }

    /// Position at time 0 of the particle with this id \[m\].
    pub(crate) fn reference(&self, id: u32) -> [f64; 3] {
        self.reference.row(id as usize)
    }

    /// Whether a step uses the velocity that is projected first, before the kick: pure FLIP uses accelerations alone.
    pub(crate) fn needs_nodal_velocity(&self) -> bool {
        self.flip_share < 1.0 || self.friction.is_some() || self.integrator != scene::Integrator::Musl
    }

    /// Velocity field of a body.
    #[inline(always)]
    pub(crate) fn field(&self, body: u16) -> u16 {
        if self.friction.is_some() { body } else { 0 }
    }

    /// Half-lengths of the domain of the particle at a place in memory \[m\]; zero where the family has none.
    pub(crate) fn half_lengths(&self, particles: &Particles, row: usize) -> [f64; 3] {
        let Some(follow) = self.domains else { return [0.0; 3] };
        let half = self.bodies[particles.body[row] as usize].half;
        std::array::from_fn(|a| {
            let stretch = if follow && a < self.dimension { particles.deformation.column(a * (self.dimension + 1))[row] } else { 1.0 };
            half[a] * stretch
        })
    }

    /// Smallest cell size \[m\].
    pub(crate) fn cell(&self) -> f64 {
        Axis::smallest_cell(&self.axes)
    }
}

fn fault(path: impl Into<String>) -> impl FnOnce(String) -> Fault {
    let path = path.into();
    |message| Fault::new(path, message)
}

fn compile(scene: &scene::Scene) -> Result<(Model, State), Fault> {
    let (dimension, method) = (scene.dimension, &scene.method);
    let family = match method.basis {
        Basis::Linear => Family::OpenSpline(1),
        Basis::Bspline => Family::OpenSpline(method.spline_degree()),
        Basis::Lagrange | Basis::Serendipity => Family::Elements,
        Basis::Cubic => Family::UniformCubic,
        Basis::Gimp => Family::Domains { follow: method.domain != Some(scene::Domain::Uniform) },
    };
    let axes: Vec<Axis> = (0..dimension)
        .map(|a| {
            let cell = scene.grid.cell.axis(a).unwrap_or(f64::NAN);
            Axis::new(scene.grid.origin[a], cell, (scene.grid.size[a] / cell).round() as usize, family)
        })
        .collect();
    let affine = method.transfer == Transfer::Apic;

    let mut bodies: Vec<Body> = Vec::new();
    let (mut samples, mut body_of) = (Vec::new(), Vec::new());
    for (index, (name, body)) in scene.body.iter().enumerate() {
        let material = &scene.material[&body.material];
        let start = samples.len();
        samples.extend(sample(body, &axes));
        if samples.len() == start {
            return Err(Fault::new(
                format!("body.{name}.shape"),
                "holds no particle; make it larger than a particle spacing, or the cells smaller",
            ));
        }
        body_of.resize(samples.len(), index as u16);
        let ordered = if method.quadrature == Quadrature::Splines {
            let found = lattice(&samples[start..], start, dimension, Axis::smallest_cell(&axes));
            Some(found.ok_or_else(|| {
                let message = "does not hold its particles in full rows and columns, which `method.quadrature = \"splines\"` needs; \
                               take a box of whole cells, or \"least_squares\"";
                Fault::new(format!("body.{name}.shape"), message)
            })?)
        } else {
            None
        };
        let half = |a: usize| axes.get(a).map_or(0.0, |axis| 0.5 * axis.cell_size() / body.particles_per_cell.axis(a).unwrap_or(1) as f64);
        bodies.push(Body {
            name: name.clone(),
            material: Material::new(material),
            density: material.density,
            particles: start..samples.len(),
            half: std::array::from_fn(half),
            lattice: ordered,
        });
    }
    let n = samples.len();
    let embedding = Embedding::new(dimension, scene.plane);
    let history = bodies.iter().map(|b| b.material.history()).max().unwrap_or(0);
    let lateral = embedding.stress_free;

    let mut reference = Table::new(dimension, n);
    for (p, sample) in samples.iter().enumerate() {
        reference.set_row(p, &sample.position);
    }
    let particles = Particles {
        id: (0..n as u32).collect(),
        mass: samples.iter().zip(&body_of).map(|(s, &b)| s.volume * bodies[b as usize].density).collect(),
        volume: samples.iter().map(|s| s.volume).collect(),
        body: body_of,
        position: reference.clone(),
        velocity: Table::new(dimension, n),
        deformation: identity_rows(dimension, n),
        affine: Table::new(if affine { dimension * dimension } else { 0 }, n),
        history: Table::new(history, n),
        lateral: if lateral { ones(n) } else { Table::default() },
    };
    let mut state = State { particles, ..State::default() };
    for (body, described) in bodies.iter().zip(scene.body.values()) {
        set_initial_velocity(&mut state.particles, body, described, dimension).map_err(fault(format!("body.{}.velocity", body.name)))?;
    }

    let boundaries = scene.boundary.iter().map(|(name, b)| boundary(name, b)).collect::<Result<Vec<_>, _>>()?;
    let finder = Finder { reference: &reference, bodies: &bodies, scene, axes: &axes };
    let loads = scene.load.iter().map(|(name, l)| finder.load(name, l)).collect::<Result<Vec<_>, _>>()?;
    let probes: Vec<Probe> = scene.probe.iter().map(|(name, p)| finder.probe(name, p)).collect();
    state.reactions = vec![[0.0; 3]; boundaries.len()];
    state.inputs =
        loads.iter().map(|l| if matches!(l.signal, Signal::External) { vec![0.0; l.components(dimension)] } else { Vec::new() }).collect();

    let flip_share = match method.transfer {
        Transfer::Flip => method.flip_share.unwrap_or(1.0),
        Transfer::Pic | Transfer::Apic => 0.0,
    };
    let lightest = state.particles.mass.iter().copied().fold(f64::INFINITY, f64::min);
    let (projection, balance) = (MassRule::new(method.mass, method), MassRule::new(method.mass_of_balance(), method));
    let masses = match method.basis {
        Basis::Lagrange if projection.is_lumped() || balance.is_lumped() => Masses::MustBePositive,
        Basis::Lagrange | Basis::Serendipity => Masses::Signed,
        _ => Masses::Positive,
    };
    // Only where the gradient is taken of the kicked velocity, and slopes do not vanish with the functions.
    let affine_or_last = affine || method.integrator == scene::Integrator::Usl;
    let guarded = method.has_kinks() && affine_or_last && (flip_share == 0.0 || flip_share == 1.0) && balance.is_lumped();
    let light = if guarded { method.mass_tolerance.unwrap_or(0.1) * lightest } else { 0.0 };
    let needs = Needs {
        affine,
        increment: flip_share > 0.0 || light > 0.0,
        body_force: loads.iter().any(|l| matches!(l.target, Target::BodyForce(_))),
        history,
        lateral,
        lookup: !probes.is_empty()
            || method.quadrature != Quadrature::Particles
            || loads.iter().any(|l| !matches!(l.target, Target::Gravity)),
        work: !loads.is_empty()
            || boundaries.iter().any(|b: &Boundary| b.velocity.iter().flatten().any(|f| f.uses(0) || f.eval(&[0.0]) != 0.0)),
        quadrature: method.quadrature != Quadrature::Particles,
        mass_matrix: !projection.is_lumped() || !balance.is_lumped(),
        tied: method.basis == Basis::Serendipity,
    };
    let model = Model {
        dimension,
        embedding,
        axes,
        bodies,
        boundaries,
        loads,
        probes,
        reference,
        integrator: method.integrator,
        transfer: method.transfer,
        flip_share,
        light,
        lump_below: if masses == Masses::Positive { method.mass_tolerance.unwrap_or(1.0) * lightest } else { 0.0 },
        masses,
        projection,
        balance,
        quadrature_of_velocity: method.quadrature_of_velocity(),
        domains: match family {
            Family::Domains { follow } => Some(follow),
            _ => None,
        },
        friction: scene.contact.as_ref().map(|contact| contact.friction),
        pace: match scene.time.step {
            Some(step) => Pace::Fixed(step),
            None => Pace::Cfl(scene.time.cfl.unwrap_or(0.4)),
        },
        needs,
    };
    Ok((model, state))
}

fn identity_rows(dimension: usize, n: usize) -> Table {
    let mut table = Table::new(dimension * dimension, n);
    for a in 0..dimension {
        table.column_mut(a * dimension + a).fill(1.0);
    }
    table
}

fn ones(n: usize) -> Table {
    let mut table = Table::new(1, n);
    table.column_mut(0).fill(1.0);
    table
}

/// Velocity of the particles of a body at time 0, and for APIC its gradient.
fn set_initial_velocity(particles: &mut Particles, body: &Body, described: &scene::Body, dimension: usize) -> Result<(), String> {
    let affine = particles.affine.width() > 0;
    for (a, expr) in described.velocity.iter().enumerate() {
        let formula = expr.compile(&["x", "y", "z"])?;
        let mut evaluate = |formula: &Formula, affine_column: Option<usize>| {
            for p in body.particles.clone() {
                let place: [f64; 3] = particles.position.row(p);
                let value = formula.eval(&place);
                if !value.is_finite() {
                    let what = if affine_column.is_some() { "has a slope of" } else { "is" };
                    return Err(format!(
                        "component {} {what} {value} at {:?} m; it must be finite all over the body",
                        a + 1,
                        &place[..dimension]
                    ));
                }
                let table = if affine_column.is_some() { &mut particles.affine } else { &mut particles.velocity };
                table.column_mut(affine_column.unwrap_or(a))[p] = value;
            }
            Ok(())
        };
        evaluate(&formula, None)?;
        for k in 0..dimension {
            if affine && formula.uses(k) {
                let slope = formula.derivative(k)?;
                evaluate(&slope, Some(a * dimension + k))?;
            }
        }
    }
    Ok(())
}

fn boundary(name: &str, described: &scene::Boundary) -> Result<Boundary, Fault> {
    let region = match (&described.face, &described.region) {
        (Some(face), _) => {
            let axis = ["x", "y", "z"].iter().position(|a| face.starts_with(a)).unwrap_or(0);
            Region::Face { axis, upper: face.ends_with('+') }
        }
        (None, Some(shape)) => Region::Shape(shape.clone()),
        (None, None) => return Err(Fault::new(format!("boundary.{name}"), "needs a `face` or a `region`")),
    };
    let mut velocity = [None, None, None];
    for axis in &described.fixed {
        velocity[*axis as usize] = Some(scene::Expr::Number(0.0).compile(&["t"]).map_err(fault(format!("boundary.{name}.fixed")))?);
    }
    for (axis, expr) in &described.velocity {
        velocity[*axis as usize] = Some(expr.compile(&["t"]).map_err(fault(format!("boundary.{name}.velocity")))?);
    }
    Ok(Boundary { name: name.into(), region, velocity })
}

/// Finds the particles that loads and probes hang on.
struct Finder<'a> {
    reference: &'a Table,
    bodies: &'a [Body],
    scene: &'a scene::Scene,
    axes: &'a [Axis],
}

impl Finder<'_> {
    fn load(&self, name: &str, load: &scene::Load) -> Result<Load, Fault> {
        let dimension = self.axes.len();
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
                // the papers' way: the force acts at the particle itself
                let anchor = Anchor { offset: [0.0; 3], ..self.anchor(self.body(&f.body), &f.at) };
                (Target::PointForce(anchor), &f.value, "point_force.value")
            }
        };
        let signal = Signal::new(signal).map_err(fault(format!("load.{name}.{key}")))?;
        let start = signal.value([0.0; 3], 0.0, &[]);
        if !signal.varies_in_space() && start.iter().any(|v| !v.is_finite()) {
            return Err(Fault::new(format!("load.{name}.{key}"), format!("is {:?} at t = 0; it must be finite", &start[..dimension])));
        }
        Ok(Load { name: name.into(), target, signal })
    }

    fn probe(&self, name: &str, probe: &scene::Probe) -> Probe {
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
        let spacing: Vec<f64> =
            (0..self.axes.len()).map(|a| self.axes[a].cell_size() / described.particles_per_cell.axis(a).unwrap_or(1) as f64).collect();
        let found = described.shape.faces().into_iter().find(|f| f.name == face);
        let points = found.map(|f| f.points(&spacing)).unwrap_or_default();
        if points.is_empty() {
            return Err(Fault::new(format!("load.{load}.{kind}.face"), format!("`{face}` of body `{body}` has no area on its surface")));
        }
        let near = Neighbours::new(self.reference, self.body(body).particles.clone(), self.axes);
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
        Neighbours::new(self.reference, body.particles.clone(), self.axes).anchor(at)
    }
}

/// The particles of a body by grid cell, to find the nearest one to a point.
struct Neighbours<'a> {
    reference: &'a Table,
    axes: &'a [Axis],
    cells: std::collections::HashMap<[i32; 3], Vec<u32>>,
}

impl<'a> Neighbours<'a> {
    fn new(reference: &'a Table, particles: std::ops::Range<usize>, axes: &'a [Axis]) -> Self {
        let mut near = Self { reference, axes, cells: std::collections::HashMap::new() };
        for p in particles {
            let cell = near.cell(&reference.row::<3>(p));
            near.cells.entry(cell).or_default().push(p as u32);
        }
        near
    }

    fn cell(&self, place: &[f64]) -> [i32; 3] {
        let mut cell = [0; 3];
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
