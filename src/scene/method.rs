//! How a scene is solved.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// How the scene is solved: a point in the table basis x quadrature x mass x transfer x integrator.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Method {
    /// Whether the method is chosen by what the scene holds, which `method = "auto"` in a scene asks for; all else is as it is by default
    /// then.
    #[serde(skip)]
    pub auto: bool,
    /// In which configuration the balance of momentum is written.
    pub formulation: Formulation,
    /// Family of shape functions.
    pub basis: Basis,
    /// Degree of the B-splines, 1 to 5; 1 is the same as the linear basis.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub degree: Option<usize>,
    /// Whether the particle domains of GIMP follow the deformation.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub domain: Option<Domain>,
    /// Where the internal forces are integrated.
    pub quadrature: Quadrature,
    /// What else is integrated there.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub quadrature_of: Option<QuadratureOf>,
    /// Mass matrix of the projection of velocities and of the balance of momentum.
    /// Lumped for the updated formulation, consistent for the total one, if left out.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mass: Option<Mass>,
    /// Mass matrix of the balance of momentum alone; as `mass` if left out.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub balance_mass: Option<Mass>,
    /// Order k of FMPM(k), 2 or more: terms of the series.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub fmpm_order: Option<usize>,
    /// Solver of a consistent mass matrix.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mass_solver: Option<MassSolver>,
    /// Residual, over the right-hand side, at which the solver of a consistent mass matrix stops; 1e-9 if left out.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mass_residual: Option<f64>,
    /// How time goes on: `musl` for the updated formulation, `verlet` for the total one, if left out.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub integrator: Option<Integrator>,
    /// Beta of Newmark's scheme, 0.25 if left out.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub newmark_beta: Option<f64>,
    /// Gamma of Newmark's scheme, 0.5 if left out; more damps.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub newmark_gamma: Option<f64>,
    /// Share of its amplitude that an oscillation far faster than the step keeps in a step of the generalised-alpha scheme, 0 to 1; 0.8 if
    /// left out.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub spectral_radius: Option<f64>,
    /// Forces out of balance, over those in balance, at which Newton's method stops; 1e-10 if left out.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub newton_residual: Option<f64>,
    /// Most iterations of Newton's method before a step is halved; 20 if left out.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub newton_iterations: Option<usize>,
    /// How the linear systems of Newton's method are solved; by their size if left out, and always by a factor where a body cuts cells.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub linear_solver: Option<LinearSolver>,
    /// Numbers in which transfers between particles and grid are worked out; particles and nodes keep 64 bits either way.
    #[serde(skip_serializing_if = "is_double")]
    pub precision: Precision,
    /// Whether the particles of a cell share its mean change of volume: keeps nearly incompressible bodies from locking. For the total
    /// formulation.
    #[serde(skip_serializing_if = "is_false")]
    pub mean_dilatation: bool,
    /// How velocity travels between particles and grid.
    pub transfer: Transfer,
    /// Share of FLIP, 0 to 1; the rest is PIC in a FLIP transfer (1 if left out), APIC in an ASFLIP transfer (0.99 if left out).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub flip_share: Option<f64>,
    /// Share of its own velocity with which a particle moves in an ASFLIP transfer where it is neither compressed nor next to a boundary, 0
    /// to 1; the rest, and all of it elsewhere, is the velocity of the grid. 1 if left out.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub separation: Option<f64>,
    /// A node lighter than this share of the lightest particle, 0 to 1, is nearly empty. A consistent mass matrix is lumped there (1 if left
    /// out: less makes the stable step shrink as bodies move through the grid). With linear functions or Lagrange elements, lumped mass,
    /// and USL or APIC, the velocity of such a node, and so the velocity gradient, takes no part of its force; the particles do, so that
    /// momentum is conserved (0.1 if left out).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mass_tolerance: Option<f64>,
}

fn is_false(value: &bool) -> bool {
    !value
}

fn is_double(value: &Precision) -> bool {
    *value == Precision::Double
}

impl Default for Method {
    fn default() -> Self {
        Self {
            auto: false,
            formulation: Formulation::Updated,
            basis: Basis::Bspline,
            degree: None,
            domain: None,
            quadrature: Quadrature::Particles,
            quadrature_of: None,
            mass: None,
            balance_mass: None,
            fmpm_order: None,
            mass_solver: None,
            mass_residual: None,
            integrator: None,
            newmark_beta: None,
            newmark_gamma: None,
            spectral_radius: None,
            newton_residual: None,
            newton_iterations: None,
            linear_solver: None,
            precision: Precision::Double,
            mean_dilatation: false,
            transfer: Transfer::Flip,
            flip_share: None,
            separation: None,
            mass_tolerance: None,
        }
    }
}

impl Method {
    /// Degree of the B-splines (2 unless given).
    pub fn spline_degree(&self) -> usize {
        self.degree.unwrap_or(2)
    }
    /// Whether the formulation is the total-Lagrangian one.
    pub fn is_total(&self) -> bool {
        self.formulation == Formulation::Total
    }
    /// Mass matrix of the projection of velocities, and of the total formulation.
    pub fn mass(&self) -> Mass {
        self.mass.unwrap_or(if self.is_total() { Mass::Consistent } else { Mass::Lumped })
    }
    /// Mass matrix of the balance of momentum.
    pub fn mass_of_balance(&self) -> Mass {
        self.balance_mass.unwrap_or(self.mass())
    }
    /// How time goes on.
    pub fn integrator(&self) -> Integrator {
        self.integrator.unwrap_or(if self.is_total() { Integrator::Verlet } else { Integrator::Musl })
    }
    /// Whether velocities are projected with the quadrature of the forces.
    pub fn quadrature_of_velocity(&self) -> bool {
        self.quadrature != Quadrature::Particles && self.quadrature_of == Some(QuadratureOf::ForceAndVelocity)
    }
    /// Whether shape functions have kinks at nodes: their slopes do not vanish where they do.
    pub fn has_kinks(&self) -> bool {
        match self.basis {
            Basis::Linear | Basis::Lagrange | Basis::Serendipity => true,
            Basis::Bspline => self.spline_degree() == 1,
            Basis::Cubic | Basis::Gimp => false,
        }
    }
}

/// A method as a scene file has it.
#[derive(Serialize, Deserialize, JsonSchema)]
#[serde(untagged)]
pub(super) enum Written {
    /// The point in the table.
    Method(Box<Method>),
    /// The word `"auto"`: formulation, degree and integrator are chosen by what the scene holds; `matpoint describe` says which and why.
    Auto(Auto),
}

/// The word `auto`.
#[derive(Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub(super) enum Auto {
    /// Chosen by what the scene holds.
    Auto,
}

impl Written {
    pub(super) fn serialize<S: serde::Serializer>(method: &Method, to: S) -> Result<S::Ok, S::Error> {
        if method.auto { Auto::Auto.serialize(to) } else { method.serialize(to) }
    }

    pub(super) fn deserialize<'de, D: serde::Deserializer<'de>>(from: D) -> Result<Method, D::Error> {
        Ok(match <Self as Deserialize>::deserialize(from)? {
            Self::Method(method) => *method,
            Self::Auto(_) => Method { auto: true, ..Method::default() },
        })
    }
}

/// Configurations in which the balance of momentum is written.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Formulation {
    /// That of now: particles move through a grid, which forgets after each step. Bodies may touch, and deform without bounds.
    Updated,
    /// That of time 0: each body has a grid of its own that deforms with it, so that shape functions are computed once. For bodies that do not
    /// touch: far more accurate, and cheaper. The grid is fitted to boxes and convex polygons of four corners. The edge of disks, rings, other
    /// polygons, in dimension 3 the surface of spheres and of intersections of boxes and half-spaces, and those of differences of them whose holes
    /// are wholly inside and apart, cut cells of the grid of the scene: particles are the points of a quadrature of what is inside, functions
    /// with little of the body follow others (extended B-splines), and the order is that of a fitted grid, wherever the body lies. Such bodies
    /// are held by `boundary.NAME.surface`: regions hold functions, of which none is alone at an edge. With lumped mass no function follows another: from degree 2 on the stable step does not suffer, but order is lost. Any other
    /// shape has the grid of the box around it, and its edge is known to a particle only.
    Total,
}

/// Families of shape functions.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Basis {
    /// Piecewise linear (bilinear, trilinear).
    Linear,
    /// B-splines with open knots at the ends of the grid.
    Bspline,
    /// Quadratic Lagrange elements over two cells along each axis: 3, 9 or 27 nodes. Their functions are negative in part of the element;
    /// with lumped mass a step stops where a nodal mass turns negative.
    Lagrange,
    /// Serendipity elements over two cells along each axis: 8 nodes in dimension 2, 20 in dimension 3. With lumped mass their corners have
    /// negative mass (Andersen 2007).
    Serendipity,
    /// Uniform cubic splines with a row of nodes outside the grid (Andersen 2007). A held face holds the nodes on it and outside.
    Cubic,
    /// Linear functions averaged over particle domains (Bardenhagen and Kober 2004).
    Gimp,
}

/// Particle domains of GIMP.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Domain {
    /// Domains keep their size.
    Uniform,
    /// Domains stretch with the deformation gradient along each axis, so that they stay next to each other.
    Contiguous,
}

/// Where the internal forces are integrated.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Quadrature {
    /// At the particles, with their volumes as weights.
    Particles,
    /// At Gauss points in cells, from cubic splines through the particles (Tielen 2016, chapter 7). Particles stand in rows that stay rows. In
    /// dimension 2 each body is a box, a ring or a convex polygon with four corners, anywhere in the grid, with particles on its edges too;
    /// cells that its edge cuts are integrated exactly, and with quadrature_of = "force_and_velocity" the functions at the edge are extended
    /// from inside (Hollig 2001). In dimensions 1 and 3 it is a box, in
    /// dimension 3 with particles on its faces too, and its ends must stay upright: where they lean, integrals are off (0.8 % at 0.1 rad).
    Splines,
    /// At Gauss points of full cells, from a least-squares fit in each (Wobbes et al. 2019); at the particles of other cells.
    LeastSquares,
}

/// What is integrated at the quadrature points.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum QuadratureOf {
    /// Internal forces; mass and momentum come from the particles, which conserves momentum.
    Force,
    /// Internal forces, and mass and momentum in the projection of velocities.
    ForceAndVelocity,
}

/// Mass matrices.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Mass {
    /// Row sums on the diagonal.
    Lumped,
    /// The full matrix, solved in each step. The stable step is about a sixth of that with lumped mass.
    Consistent,
    /// The first `fmpm_order` terms of the series of its inverse (Nairn and Hammerquist 2021). With `balance_mass = "lumped"` and
    /// `transfer = "pic"` particles take the velocity of XPIC(m), m terms (Hammerquist and Nairn 2017), and move with it; the paper moves
    /// them with what a lumped mass makes of their velocity, and half its change.
    Fmpm,
}

/// Numbers of a transfer between particles and grid.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Precision {
    /// 64 bits.
    #[default]
    Double,
    /// 32 bits, sums of them on the nodes in 64: faster, with a round-off of 6e-8 of a step in what travels. For explicit steps of the updated
    /// formulation with a lumped mass, quadrature at the particles, and linear functions or B-splines of degree up to 3.
    Single,
}

/// Solvers of a consistent mass matrix.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum MassSolver {
    /// Conjugate gradients, preconditioned by the diagonal.
    Pcg,
    /// Conjugate gradients from a sparse factor of the matrix, which are at their end after an iteration or a few; for
    /// quadrature_of = "force_and_velocity". The choice for bodies that cut cells.
    Direct,
    /// Richardson iteration from the lumped solution (Tielen 2016, section 7.2).
    Richardson,
}

/// How time goes on. The first three are for the updated formulation and tell when the stress is updated within a step.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Integrator {
    /// Update stress first: from the velocity projected at the new positions. Keeps the energy.
    Usf,
    /// Update stress last: from the updated nodal velocity. Cheapest; dissipates.
    Usl,
    /// Modified update stress last: stress and positions from the velocity projected again (Sulsky 1994, Tielen 2016, section 3.2).
    /// Keeps the energy; quieter than USF, for particles and their deformation move with the same field.
    Musl,
    /// Velocity Verlet, of second order and symplectic; for the total formulation.
    Verlet,
    /// Symplectic Runge-Kutta-Nystroem scheme of fourth order with six forces a step (Blanes and Moan 2002); for the total formulation.
    Symplectic4,
    /// Loads applied without inertia, in steps: the balance of forces at the end of each. Nothing has a velocity.
    QuasiStatic,
    /// Newmark's implicit scheme, `newmark_beta` and `newmark_gamma`; by default the trapezoidal rule.
    Newmark,
    /// Implicit, of second order, damps what is faster than the step (Chung and Hulbert 1993); `spectral_radius` says how much.
    GeneralizedAlpha,
    /// Implicit, of second order: conserves energy and momenta (Gonzalez 2000).
    EnergyMomentum,
}

impl Integrator {
    /// Whether steps solve for a balance of forces.
    pub fn is_implicit(self) -> bool {
        matches!(self, Self::QuasiStatic | Self::Newmark | Self::GeneralizedAlpha | Self::EnergyMomentum)
    }
    /// Whether the updated formulation has it.
    pub fn is_updated(self) -> bool {
        matches!(self, Self::Usf | Self::Usl | Self::Musl)
    }
}

/// How the linear systems of implicit steps are solved.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum LinearSolver {
    /// A sparse factor: Cholesky, or elimination where that fails or the system is not symmetric.
    Direct,
    /// Conjugate gradients without a matrix, from the inverse of the stiffness of a box at rest; direct where the system is not symmetric and
    /// positive.
    Iterative,
}

/// How velocity travels between particles and grid.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Transfer {
    /// Particles take the interpolated velocity: very dissipative with lumped mass, where it is XPIC(1) too. XPIC(m) is PIC with
    /// `mass = "fmpm"`, `fmpm_order` = m, `balance_mass = "lumped"`.
    Pic,
    /// Particles take the interpolated increment; `flip_share` blends with PIC.
    Flip,
    /// Affine particle-in-cell: keeps linear and angular momentum, filters noise.
    Apic,
    /// Affine separable FLIP (Fei et al. 2021), for USF and USL: APIC, to which particles add the share `flip_share` of their own velocity
    /// that the grid has not got, and with which they move where they are neither compressed nor next to a boundary (`separation`). Bodies
    /// that share a velocity field part more easily; less of a vibration is lost. Angular momentum is kept less well than by APIC, and
    /// deformation is no longer exactly the gradient of the motion.
    Asflip,
}

impl Transfer {
    /// Whether particles carry an affine matrix.
    pub fn is_affine(self) -> bool {
        matches!(self, Self::Apic | Self::Asflip)
    }
}
