//! 1 DESCRIBE: the user's words. Plain serde data in SI units, without numerics and without generics.
//!
//! One [`Scene`] is one TOML (or JSON) file. [`parse`] turns text into a `Scene` and reports every structural fault with its
//! place; [`check`] reports what is well-formed but makes no sense. The doc comments of the fields below are also the
//! descriptions in the JSON schema that `matpoint schema` prints.

pub mod check;
mod fault;
mod formula;
mod method;
pub mod parse;
mod polyhedron;
mod shape;
mod structure;

pub use fault::{Fault, SceneError, nearest};
pub use formula::Formula;
pub(crate) use formula::{PLACES, Results, Tape};
pub use method::{
    Basis, Domain, Formulation, Integrator, LinearSolver, Mass, MassSolver, Method, Precision, Quadrature, QuadratureOf, Transfer,
};
pub(crate) use polyhedron::{Polyhedron, half_spaces};
pub use shape::{Face, FacePoint, Shape};

use indexmap::IndexMap;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A scene: what there is, what acts on it, how it is solved, what is recorded. SI units throughout.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Scene {
    /// What the scene shows, in one line.
    pub title: String,
    /// Number of space dimensions: 1, 2 or 3.
    pub dimension: usize,
    /// What happens across the plane (dimension 2) or the axis (dimension 1); no meaning in dimension 3.
    #[serde(default)]
    pub plane: Plane,
    /// The background grid.
    pub grid: Grid,
    /// Materials by name.
    pub material: IndexMap<String, Material>,
    /// Bodies by name.
    pub body: IndexMap<String, Body>,
    /// Where the velocity of the grid is fixed or prescribed, by name. A later boundary overrides an earlier one.
    #[serde(default)]
    pub boundary: IndexMap<String, Boundary>,
    /// Loads by name.
    #[serde(default)]
    pub load: IndexMap<String, Load>,
    /// Material points that are watched, by name.
    #[serde(default)]
    pub probe: IndexMap<String, Probe>,
    /// What happens where bodies meet; without it they share one velocity field, and stick.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub contact: Option<Contact>,
    /// How the scene is solved: a point in the table formulation x basis x quadrature x mass x transfer x integrator, or the word `"auto"`.
    #[serde(default, with = "method::Written")]
    #[schemars(with = "method::Written")]
    pub method: Method,
    /// How long, and in what steps.
    pub time: Time,
    /// How often `run` records.
    #[serde(default)]
    pub record: Record,
    /// The known solution, for scenes that have one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub exact: Option<Exact>,
}

/// What happens across the plane (dimension 2) or the axis (dimension 1).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Plane {
    /// No strain across.
    #[default]
    Strain,
    /// No stress across: the thickness changes freely.
    Stress,
}

/// The background grid: a box of equal cells. B-splines have open knots at its ends, so a wall is best put there.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Grid {
    /// Lower corner \[m\].
    pub origin: Vec<f64>,
    /// Extent along each axis \[m\]: a whole number of cells.
    pub size: Vec<f64>,
    /// Cell size \[m\]: one number, or one an axis.
    pub cell: OneOrEach<f64>,
}

/// One value for all axes, or one for each.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(untagged)]
pub enum OneOrEach<T> {
    /// The same along every axis.
    One(T),
    /// One an axis.
    Each(Vec<T>),
}

impl<T: Clone> OneOrEach<T> {
    /// The value along `axis`; `None` where too few are given.
    pub fn axis(&self, axis: usize) -> Option<T> {
        match self {
            Self::One(value) => Some(value.clone()),
            Self::Each(values) => values.get(axis).cloned(),
        }
    }
    /// Whether one is given for each of `dimension` axes.
    pub fn fits(&self, dimension: usize) -> bool {
        matches!(self, Self::One(_)) || matches!(self, Self::Each(values) if values.len() == dimension)
    }
}

/// An isotropic elastic material.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Material {
    /// The law.
    pub law: Law,
    /// Young's modulus \[Pa\].
    pub young: f64,
    /// Poisson's ratio \[-\], above -1 and below 0.5.
    #[serde(default)]
    pub poisson: f64,
    /// Density before deformation \[kg/m3\].
    pub density: f64,
}

/// The laws of elasticity on offer.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Law {
    /// Small strain: the stress follows the sum of the strain increments, volume changes are ignored.
    LinearElastic,
    /// Jaumann rate of the Kirchhoff stress; in one dimension sigma' = (E - sigma) eps', the law of Tielen (2016).
    HypoElastic,
    /// Compressible neo-Hookean: tau = mu (b - I) + lambda ln J I.
    NeoHookean,
    /// Hencky: linear between the logarithmic strain and the Kirchhoff stress.
    Hencky,
}

/// A deformable body, filled with particles.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Body {
    /// Name of its material.
    pub material: String,
    /// The region it fills at time 0.
    pub shape: Shape,
    /// Particles along each axis of a cell: one number, or one an axis. If left out: two, and one more than the degree for the total
    /// formulation.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub particles_per_cell: Option<OneOrEach<usize>>,
    /// Where in a cell the particles sit: `uniform` if left out, `gauss` for the total formulation, and always where a body cuts cells in it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub positions: Option<Positions>,
    /// Seed of the jitter.
    #[serde(default)]
    pub seed: u64,
    /// Initial velocity \[m/s\], one number or formula of x, y, z (position at time 0) an axis. Zero if left out.
    #[serde(default)]
    pub velocity: Vec<Expr>,
}

impl Scene {
    /// Particles along each axis of a cell of a body: one number, or one an axis.
    pub fn particles_per_cell(&self, body: &Body) -> OneOrEach<usize> {
        let usual = if self.method.is_total() { self.method.spline_degree() + 1 } else { 2 };
        body.particles_per_cell.clone().unwrap_or(OneOrEach::One(usual))
    }
    /// Where in a cell the particles of a body sit.
    pub fn positions(&self, body: &Body) -> Positions {
        body.positions.unwrap_or(if self.method.is_total() { Positions::Gauss } else { Positions::Uniform })
    }
}

/// Where in a cell the particles of a body sit.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Positions {
    /// Centres of equal parts of the cell.
    Uniform,
    /// Gauss-Legendre points of the cell, each with its weight as volume.
    Gauss,
    /// Uniform, then moved at random by up to 40 % of the spacing; the same for the same seed.
    Jittered,
}

/// A number, or a formula such as `"0.1*sin(PI*x/25)"`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(untagged)]
pub enum Expr {
    /// A constant.
    Number(f64),
    /// A formula in the variables that the field names; knows +, -, *, /, ^, sin, cos, exp, ln, sqrt, abs, PI, E and more.
    Formula(String),
}

/// Where velocity is fixed or prescribed. Give one of `face`, `region` and `surface`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Boundary {
    /// A whole end of the grid: `"x-"`, `"x+"`, `"y-"`, `"y+"`, `"z-"` or `"z+"`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub face: Option<String>,
    /// A region: every node (for B-splines: every Greville point) in it is held.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub region: Option<Shape>,
    /// A face of a body, wherever it lies in the grid: what sticks to a wall. For formulation = "total" in dimension 2 and 3, and for
    /// quadrature = "splines". In "total", where the face cuts cells it is held by Nitsche's method: for laws with a stored energy, without
    /// `mean_dilatation`; the work of its forces is not counted as stored energy.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub surface: Option<Surface>,
    /// Axes along which the velocity is zero.
    #[serde(default)]
    pub fixed: Vec<Axis>,
    /// Prescribed velocity \[m/s\] along an axis: a number or a formula of t.
    #[serde(default)]
    pub velocity: IndexMap<Axis, Expr>,
}

/// A face of a body.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Surface {
    /// Name of the body.
    pub body: String,
    /// Name of the face, as for a traction.
    pub face: String,
}

/// A coordinate axis.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Axis {
    /// First axis.
    X,
    /// Second axis.
    Y,
    /// Third axis.
    Z,
}

/// A load. Exactly one kind a name.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Load {
    /// Acceleration of everything \[m/s2\].
    Gravity(Signal),
    /// Specific body force (an acceleration) on a body or a part of it.
    BodyForce(BodyForce),
    /// Dead traction on a face of a body: force an undeformed area, direction fixed in space.
    Traction(Traction),
    /// Follower pressure on a face of a body: force a deformed area, against the deformed normal.
    Pressure(Pressure),
    /// Force on the particle nearest to a point; in the total formulation at the point itself.
    PointForce(PointForce),
}

/// Specific body force (an acceleration) on a body or a part of it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BodyForce {
    /// Name of the body.
    pub body: String,
    /// Part of the body that is loaded, at time 0; all of it if left out.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub region: Option<Shape>,
    /// Acceleration \[m/s2\]; its formulas may use x, y, z (position at time 0) and t.
    pub value: Signal,
}

/// Dead traction on a face of a body.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Traction {
    /// Name of the body.
    pub body: String,
    /// Name of the face: `x-` ... `z+` of a box, `outer` of a disk or sphere, `inner` or `outer` of a ring, `edge1` ... of a polygon, `plane` of
    /// a half-space; in a union, difference or intersection with the number of the part before it, as in `2/x+`.
    pub face: String,
    /// Force an undeformed area \[Pa\]; its formulas may use x, y, z (position at time 0) and t.
    pub value: Signal,
}

/// Follower pressure on a face of a body.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Pressure {
    /// Name of the body.
    pub body: String,
    /// Name of the face, as for a traction.
    pub face: String,
    /// Pressure \[Pa\], one component, positive when it pushes on the body; its formulas as for a traction.
    pub value: Signal,
}

/// Force on the particle nearest to a point; in the total formulation at the point itself.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PointForce {
    /// Name of the body.
    pub body: String,
    /// The point at time 0 \[m\].
    pub at: Vec<f64>,
    /// Force \[N\] (per metre of thickness in dimension 2, per square metre of section in dimension 1).
    pub value: Signal,
}

/// A value in time: constants and formulas of t, a table, or set from outside.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(untagged)]
pub enum Signal {
    /// One number or formula of t a component.
    Components(Vec<Expr>),
    /// Linear between the rows of a table, constant before and after it.
    Table(Table),
    /// The word `"external"`: set from outside while running, zero until set.
    External(External),
}

/// The word `external`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum External {
    /// Set from outside while running; zero until set.
    External,
}

/// A table of values in time.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Table {
    /// Times \[s\], increasing.
    pub time: Vec<f64>,
    /// One row of components a time.
    pub value: Vec<Vec<f64>>,
}

/// A material point that is watched.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Probe {
    /// Name of the body; needed only where there are several.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub body: Option<String>,
    /// The point at time 0 \[m\], in the body or at most one cell outside it. It moves with the nearest particle and its deformation.
    pub at: Vec<f64>,
}

/// What happens where bodies meet: each has its own velocity field, corrected at the nodes that two bodies reach so that they do not come
/// closer there, with Coulomb friction (Bardenhagen et al. 2001).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Contact {
    /// Coefficient of friction \[-\], 0 or more.
    #[serde(default)]
    pub friction: f64,
}

/// How long, and in what steps. For explicit integrators give either `step` or `cfl`; with neither, `cfl` is 0.4, or 0.8 in the total
/// formulation. For implicit ones give
/// `step`, or `error`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Time {
    /// End of a run \[s\].
    pub end: f64,
    /// Fixed step \[s\]; refused where it is above the stable one. Beside `error`: the longest.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub step: Option<f64>,
    /// Share of the stable step, above 0 and up to 1. The stable step is that of the particles where they are at time 0: leave room for
    /// other places in their cells.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub cfl: Option<f64>,
    /// Largest error of the displacement that an implicit step may make \[m\], root of the mean square over the mass: steps are as long as an
    /// estimate of it allows, up to `step`, or a hundredth of the run if that is left out.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub error: Option<f64>,
}

/// How often `run` records, in simulated seconds.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Record {
    /// Time between particle frames \[s\]; a hundredth of the run if left out, or `time.step` where that is longer.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub every: Option<f64>,
    /// Substeps between particle frames, instead of `every`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub every_steps: Option<u64>,
    /// Time between rows of energies and probes \[s\]; with the frames if left out.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub history: Option<f64>,
}

/// The known solution of a scene. Its formulas may use x, y, z (position at time 0) and t.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Exact {
    /// Displacement \[m\], one an axis.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub displacement: Vec<Expr>,
    /// Velocity \[m/s\], one an axis.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub velocity: Vec<Expr>,
    /// Cauchy stress \[Pa\] by component: `xx`, `yy`, `zz`, `yz`, `xz`, `xy`.
    #[serde(default, skip_serializing_if = "IndexMap::is_empty")]
    pub stress: IndexMap<StressComponent, Expr>,
    /// CSV file with the columns `time_s, X_m, displacement_m, velocity_m_s, stress_Pa` (dimension 1), beside the scene file.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reference: Option<String>,
}

/// A component of the stress tensor.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
#[expect(missing_docs, reason = "the names say it")]
pub enum StressComponent {
    Xx,
    Yy,
    Zz,
    Yz,
    Xz,
    Xy,
}
