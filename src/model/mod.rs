//! 2 COMPILE: Scene -> Model: immutable tables, and [`Needs`]: what this scene needs, and so what it does not.

mod boundary;
mod chart;
mod cut;
mod finder;
mod lattice;
mod load;
mod map;
mod outline;
mod sample;
mod skin;

pub(crate) use boundary::Boundary;
pub(crate) use chart::Chart;
pub(crate) use cut::{Cut, CutPoint, Fit};
pub(crate) use load::{Load, SPACE_TIME, Side, Signal, SurfacePoint, Target};

use crate::basis::{Axis, Family};
use crate::implicit::{Rules, Scheme};
use crate::material::{Embedding, Material};
use crate::scene::{self, Basis, Fault, Formula, Mass, MassSolver, Quadrature, SceneError, Shape, Transfer};
use crate::state::{Particles, State, Table};
use finder::Finder;
pub(crate) use lattice::Lattice;
use lattice::lattice;
pub(crate) use map::Quadrilateral;
use outline::Outline;
use sample::{Sample, sample};
use skin::Skin;

/// A scene made ready to run.
#[derive(Debug, Clone)]
pub(crate) struct Model {
    pub(crate) dimension: usize,
    pub(crate) embedding: Embedding,
    /// One an axis.
    pub(crate) axes: Vec<Axis>,
    pub(crate) bodies: Vec<Body>,
    pub(crate) boundaries: Vec<Boundary>,
    /// Sides of bodies in rows that are held: the boundary, and the side.
    pub(crate) walls: Vec<(usize, Side)>,
    pub(crate) loads: Vec<Load>,
    pub(crate) probes: Vec<Probe>,
    /// Position at time 0 by particle id \[m\].
    pub(crate) reference: Table,
    /// End of a run, as the scene has it \[s\].
    pub(crate) end: f64,
    /// Whether bodies have grids of their own, at time 0.
    pub(crate) total: bool,
    /// Whether particles have the volume ratio of their cell.
    pub(crate) mean_dilatation: bool,
    /// Of the transfers between particles and grid.
    pub(crate) precision: scene::Precision,
    pub(crate) integrator: scene::Integrator,
    /// Scheme of implicit steps.
    pub(crate) implicit: Option<Scheme>,
    /// Whether accelerations are part of the state.
    pub(crate) remembers_acceleration: bool,
    /// How its linear systems are solved; by their size where none is asked for.
    pub(crate) linear_solver: Option<scene::LinearSolver>,
    /// When Newton's method stops.
    pub(crate) newton: Rules,
    pub(crate) transfer: Transfer,
    /// Share of FLIP, of ASFLIP beside APIC; 0 for PIC and APIC.
    pub(crate) flip_share: f64,
    /// Share of its own velocity with which a particle moves where it separates; 0 but for ASFLIP.
    pub(crate) separation: f64,
    /// Mass of the lightest particle \[kg\].
    pub(crate) lightest: f64,
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
    /// The grid that its particles were made in: that of the scene, or in the total formulation its own.
    pub(crate) axes: Vec<Axis>,
    /// Where its own grid is bent.
    pub(crate) map: Option<Quadrilateral>,
    /// How its own grid fits it.
    pub(crate) fit: Fit,
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
    fn new(mass: Mass, method: &scene::Method, cuts_cells: bool) -> Self {
        let usual = if cuts_cells { MassSolver::Direct } else { MassSolver::Pcg };
        match mass {
            Mass::Lumped => Self::Lumped,
            Mass::Fmpm => Self::Series(method.fmpm_order.unwrap_or(2)),
            Mass::Consistent => {
                Self::Solved { solver: method.mass_solver.unwrap_or(usual), residual: method.mass_residual.unwrap_or(1e-9) }
            }
        }
    }
    pub(crate) fn is_lumped(self) -> bool {
        self == Self::Lumped
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

impl Anchor {
    /// Where the point is at time 0 \[m\].
    pub(crate) fn place(&self, model: &Model) -> [f64; 3] {
        let host = model.reference(self.particle);
        std::array::from_fn(|a| host[a] + self.offset[a])
    }
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
    /// As long as the error of the displacement that a step makes is at most `allowed` \[m\], and at most `longest` \[s\].
    Error { allowed: f64, longest: f64 },
}

/// What this scene needs; what is false here costs nothing.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Needs {
    /// An affine matrix a particle (APIC, ASFLIP).
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
    /// Functions at the edge that follow those inside (see [`crate::basis::Extension`]).
    pub(crate) extension: bool,
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

    /// Whether particles may give to the grid in the pass in which they take from it: nothing but them is summed, weights are not negative,
    /// and they move as the grid does.
    pub(crate) fn fuses(&self) -> bool {
        let needs = &self.needs;
        let apart = needs.quadrature || needs.mass_matrix || needs.body_force || needs.tied || self.separation > 0.0;
        self.implicit.is_none() && self.masses == Masses::Positive && !apart
    }

    /// Whether forces are summed with the momenta they change: nobody asks for accelerations.
    pub(crate) fn merges(&self) -> bool {
        self.fuses() && !self.needs.increment && self.friction.is_none() && self.walls.is_empty()
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
    let affine = method.transfer.is_affine();

    let mut bodies: Vec<Body> = Vec::new();
    let (mut samples, mut body_of) = (Vec::new(), Vec::new());
    for (index, (name, body)) in scene.body.iter().enumerate() {
        let material = &scene.material[&body.material];
        let start = samples.len();
        let map = if method.is_total() { Quadrilateral::new(&body.shape) } else { None };
        let per_cell = scene.particles_per_cell(body);
        let chart = if dimension == 2 && method.quadrature == Quadrature::Splines { Chart::new(&body.shape) } else { None };
        let mut sheet = None;
        let (own, made, fit) = match (&map, &body.shape) {
            (Some(map), _) => {
                let own = fitted(&[0.0; 2], &map.lengths, &axes);
                let whole = scene::Body { shape: Shape::Box { min: vec![0.0; 2], max: map.lengths.to_vec() }, ..body.clone() };
                let in_grid = sample(&whole, &per_cell, scene.positions(body), &own);
                let bent =
                    |s: &Sample| Sample { position: map.place(s.position), volume: s.volume * map.jacobian(s.position).determinant() };
                (own, in_grid.iter().map(bent).collect(), Fit::Whole)
            }
            (None, shape) if method.is_total() => {
                let (lower, upper) = shape.bounds(dimension);
                let bounds = [&lower[..], &upper[..]];
                let cut = match (shape, dimension) {
                    (Shape::Box { .. }, _) => None,
                    (_, 3) => Some(Skin::new(shape).map(|skin| Ok(cut::cut_in_space(&skin, bounds, &axes, &per_cell)))),
                    (..) => Some(Outline::new(shape).map(|outline| cut::cut(&outline, bounds, &axes, &per_cell))),
                };
                match cut {
                    Some(Ok(made)) => {
                        let lost = |lost: cut::Lost| {
                            Fault::new(
                                format!("body.{name}.shape"),
                                format!("has an edge that cannot be followed near {:?} m", lost.position),
                            )
                        };
                        let (own, made, cut) = made.map_err(lost)?;
                        (own, made, Fit::Cut(cut))
                    }
                    around => {
                        let own = fitted(&lower, &upper, &axes);
                        let made = sample(body, &per_cell, scene.positions(body), &own);
                        (own, made, around.and_then(Result::err).map_or(Fit::Whole, Fit::Around))
                    }
                }
            }
            (None, _) => match chart {
                Some(chart) => {
                    let spacing = [0, 1].map(|a| axes[a].cell_size() / per_cell.axis(a).unwrap_or(1) as f64);
                    let (in_rows, sites) = chart.sample(spacing);
                    sheet = Some(Lattice::of_chart(chart, sites, start));
                    (axes.clone(), in_rows, Fit::Whole)
                }
                None => {
                    let made = match &body.shape {
                        Shape::Box { min, max } if in_rows(scene, body) => sample::with_faces([min, max], &per_cell, &axes),
                        _ => sample(body, &per_cell, scene.positions(body), &axes),
                    };
                    (axes.clone(), made, Fit::Whole)
                }
            },
        };
        samples.extend(made);
        if samples.len() == start {
            return Err(Fault::new(
                format!("body.{name}.shape"),
                "holds no particle; make it larger than a particle spacing, or the cells smaller",
            ));
        }
        body_of.resize(samples.len(), index as u16);
        let ordered = match sheet {
            None if method.quadrature == Quadrature::Splines => {
                let (low, high) = body.shape.bounds(dimension);
                let found =
                    if dimension == 2 { None } else { lattice(&samples[start..], start, [&low, &high], Axis::smallest_cell(&axes)) };
                Some(found.ok_or_else(|| {
                    let take = if dimension == 2 { "box, a ring or a convex polygon with four corners" } else { "box of whole cells" };
                    let message = format!(
                        "does not hold its particles in full rows and columns, which `method.quadrature = \"splines\"` needs; \
                         take a {take}, or \"least_squares\""
                    );
                    Fault::new(format!("body.{name}.shape"), message)
                })?)
            }
            sheet => sheet,
        };
        let half = |a: usize| own.get(a).map_or(0.0, |axis| 0.5 * axis.cell_size() / per_cell.axis(a).unwrap_or(1) as f64);
        bodies.push(Body {
            name: name.clone(),
            material: Material::new(material),
            density: material.density,
            particles: start..samples.len(),
            half: std::array::from_fn(half),
            axes: own,
            map,
            fit,
            lattice: ordered,
        });
    }
    let n = samples.len();
    let embedding = Embedding::new(dimension, scene.plane);
    let implicit = Scheme::new(method);
    let remembers_acceleration = implicit.is_some_and(|scheme| scheme.needs_acceleration() || scene.time.error.is_some());
    let history = bodies.iter().map(|b| b.material.history()).max().unwrap_or(0);
    // with the volume ratio of the cell a particle is stretched across the plane, too
    let lateral = embedding.stress_free || method.mean_dilatation && dimension < 3;

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
        acceleration: Table::new(if !method.is_total() && remembers_acceleration { dimension } else { 0 }, n),
    };
    let pace = match (scene.time.error, scene.time.step) {
        (Some(allowed), longest) => Pace::Error { allowed, longest: longest.unwrap_or(0.01 * scene.time.end) },
        (None, Some(step)) => Pace::Fixed(step),
        // bodies on grids of their own need no room for other places of particles in their cells
        (None, None) => Pace::Cfl(scene.time.cfl.unwrap_or(if method.is_total() { 0.8 } else { 0.4 })),
    };
    let next_step = if let Pace::Error { longest, .. } = pace { longest } else { 0.0 };
    let mut state = State { particles, next_step, ..State::default() };
    for (body, described) in bodies.iter().zip(scene.body.values()) {
        set_initial_velocity(&mut state.particles, body, described, dimension).map_err(fault(format!("body.{}.velocity", body.name)))?;
    }

    let boundaries = scene.boundary.iter().map(|(name, b)| Boundary::new(name, b, scene, &bodies)).collect::<Result<Vec<_>, _>>()?;
    let wall = |(number, boundary): (usize, &Boundary)| {
        let (body, face) = boundary.surface()?;
        Some((number, side(&bodies, scene, body, face)?))
    };
    let walls: Vec<(usize, Side)> = boundaries.iter().enumerate().filter_map(wall).collect();
    let finder = Finder { reference: &reference, bodies: &bodies, scene };
    let loads = scene.load.iter().map(|(name, l)| finder.load(name, l)).collect::<Result<Vec<_>, _>>()?;
    let probes: Vec<Probe> = scene.probe.iter().map(|(name, p)| finder.probe(name, p)).collect();
    state.reactions = vec![[0.0; 3]; boundaries.len()];
    state.inputs =
        loads.iter().map(|l| if matches!(l.signal, Signal::External) { vec![0.0; l.components(dimension)] } else { Vec::new() }).collect();

    let flip_share = match method.transfer {
        Transfer::Flip => method.flip_share.unwrap_or(1.0),
        Transfer::Asflip => method.flip_share.unwrap_or(0.99),
        Transfer::Pic | Transfer::Apic => 0.0,
    };
    let separation = if method.transfer == Transfer::Asflip { method.separation.unwrap_or(1.0) } else { 0.0 };
    // lines of lower degree are as in the papers; a node that bodies push must not be followed: those with little of a body are lumped instead
    let extension = goes_beyond_lines(scene) && method.quadrature_of_velocity() && scene.contact.is_none();
    let lightest = state.particles.mass.iter().copied().fold(f64::INFINITY, f64::min);
    let (projection, balance) =
        (MassRule::new(method.mass(), method, extension), MassRule::new(method.mass_of_balance(), method, extension));
    let masses = match method.basis {
        Basis::Lagrange if projection.is_lumped() || balance.is_lumped() => Masses::MustBePositive,
        Basis::Lagrange | Basis::Serendipity => Masses::Signed,
        _ => Masses::Positive,
    };
    // Only where the gradient is taken of the kicked velocity, and slopes do not vanish with the functions.
    let affine_or_last = affine || method.integrator() == scene::Integrator::Usl;
    let guarded = method.has_kinks() && affine_or_last && (flip_share == 0.0 || flip_share == 1.0) && balance.is_lumped();
    let light = if guarded { method.mass_tolerance.unwrap_or(0.1) * lightest } else { 0.0 };
    let needs = Needs {
        affine,
        increment: !method.is_total() && implicit.is_none() && (flip_share > 0.0 || light > 0.0),
        body_force: loads.iter().any(|l| matches!(l.target, Target::BodyForce(_))),
        history,
        lateral,
        lookup: !probes.is_empty()
            || method.quadrature != Quadrature::Particles
            || loads.iter().any(|l| !matches!(l.target, Target::Gravity)),
        work: !loads.is_empty()
            || boundaries.iter().any(|b: &Boundary| b.velocity.iter().flatten().any(|f| f.uses(0) || f.eval(&[0.0]) != 0.0)),
        quadrature: method.quadrature != Quadrature::Particles,
        extension,
        mass_matrix: !projection.is_lumped() || !balance.is_lumped(),
        tied: method.basis == Basis::Serendipity,
    };
    let model = Model {
        dimension,
        embedding,
        axes,
        bodies,
        boundaries,
        walls,
        loads,
        probes,
        reference,
        end: scene.time.end,
        integrator: method.integrator(),
        implicit,
        remembers_acceleration,
        linear_solver: method.linear_solver,
        newton: Rules { residual: method.newton_residual.unwrap_or(1e-10), iterations: method.newton_iterations.unwrap_or(20) },
        total: method.is_total(),
        mean_dilatation: method.mean_dilatation,
        precision: method.precision,
        transfer: method.transfer,
        flip_share,
        separation,
        light,
        lightest,
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
        pace,
        needs,
    };
    Ok((model, state))
}

/// Axis of the side of a box with this name, and whether it is the upper one.
fn side_of_box(name: &str) -> Option<(usize, bool)> {
    let axis = ["x", "y", "z"].iter().position(|axis| name.starts_with(axis))?;
    Some((axis, name.ends_with('+')))
}

/// The side of a body in rows that is a face of it.
fn side(bodies: &[Body], scene: &scene::Scene, body: usize, face: &str) -> Option<Side> {
    let (axis, upper) = match (&bodies[body].lattice.as_ref()?.sheet, &scene.body[body].shape) {
        (Some((chart, _)), shape) => chart.side(shape, face)?,
        (None, Shape::Box { .. }) if goes_beyond_lines(scene) => side_of_box(face)?,
        (None, _) => return None,
    };
    Some(Side { body, axis, upper })
}

/// Whether splines through the particles are more than those that the papers have along lines.
fn goes_beyond_lines(scene: &scene::Scene) -> bool {
    scene.method.quadrature == Quadrature::Splines && (scene.dimension > 1 || scene.method.spline_degree() > 2)
}

/// Whether particles of a box stand on its faces too: in space, where splines lead through them. (Lines keep those of the papers, and planes have
/// sheets.)
fn in_rows(scene: &scene::Scene, body: &scene::Body) -> bool {
    scene.dimension == 3 && scene.method.quadrature == Quadrature::Splines && scene.positions(body) == scene::Positions::Uniform
}

/// The grid of a body: cells about as large as those of the scene, as many as fit exactly.
fn fitted(lower: &[f64], upper: &[f64], axes: &[Axis]) -> Vec<Axis> {
    let fit = |(a, axis): (usize, &Axis)| {
        let length = upper[a] - lower[a];
        let cells = (length / axis.cell_size()).round().max(1.0);
        Axis::new(lower[a], length / cells, cells as usize, axis.family())
    };
    axes.iter().enumerate().map(fit).collect()
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
