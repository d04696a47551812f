//! What can go wrong while a simulation is stepped and talked to.

/// A step that could not be done. The state is as it was before the call.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum StepError {
    /// The asked step is not a positive, finite number.
    #[error("step of {step} s: a step is a positive, finite number of seconds")]
    BadStep {
        /// Asked step \[s\].
        step: f64,
    },
    /// The caller of `step_while` wanted no more substeps.
    #[error("interrupted at t = {time:.6} s; the state is as it was before the call")]
    Interrupted {
        /// Time that had been reached \[s\].
        time: f64,
    },
    /// The stable step has become too short to move time.
    #[error("at t = {time:.6} s the stable step has shrunk to {stable:.3e} s; something is much too fast or too stiff")]
    Unstable {
        /// Time \[s\].
        time: f64,
        /// Stable step \[s\].
        stable: f64,
    },
    /// A load is not a finite number.
    #[error("at t = {time:.6} s load `{load}` is not finite")]
    BadLoad {
        /// Time \[s\].
        time: f64,
        /// Name of the load.
        load: String,
    },
    /// A particle was turned inside out.
    #[error(
        "at t = {time:.6} s particle {particle} at {position:?} m was inverted (det F = {det:.3e}); take a smaller step or a finer grid"
    )]
    Inverted {
        /// Time at the start of the failed substep \[s\].
        time: f64,
        /// Particle, as in the order of `particle/position`.
        particle: usize,
        /// Its position \[m\].
        position: Vec<f64>,
        /// Determinant of its deformation gradient \[-\].
        det: f64,
    },
    /// A position, velocity or stress is no longer a finite number.
    #[error("at t = {time:.6} s particle {particle} at {position:?} m is no longer finite; take a smaller step")]
    NotFinite {
        /// Time at the start of the failed substep \[s\].
        time: f64,
        /// Particle, as in the order of `particle/position`.
        particle: usize,
        /// Its last position \[m\].
        position: Vec<f64>,
    },
    /// A particle left the grid.
    #[error("at t = {time:.6} s particle {particle} left the grid at {position:?} m; make the grid larger or hold the body")]
    LeftGrid {
        /// Time at the start of the failed substep \[s\].
        time: f64,
        /// Particle, as in the order of `particle/position`.
        particle: usize,
        /// Its position \[m\].
        position: Vec<f64>,
    },
    /// A nodal mass turned negative under Lagrange elements.
    #[error(
        "at t = {time:.6} s the mass of the node at {position:?} m is {mass:.3e} kg: with Lagrange elements and lumped mass the method breaks \
         down where a nodal mass turns negative; take another basis, or mass = \"consistent\""
    )]
    NegativeMass {
        /// Time at the start of the failed substep \[s\].
        time: f64,
        /// Position of the node \[m\].
        position: Vec<f64>,
        /// Its mass \[kg\].
        mass: f64,
    },
    /// The solver of the mass matrix did not reach its residual.
    #[error(
        "at t = {time:.6} s the mass matrix was not solved: relative residual {residual:.1e} after {iterations} iterations; take \
         mass_solver = \"pcg\", a larger mass_tolerance or a larger mass_residual"
    )]
    NoConvergence {
        /// Time at the start of the failed substep \[s\].
        time: f64,
        /// Iterations done.
        iterations: usize,
        /// Residual over right-hand side \[-\].
        residual: f64,
    },
    /// An implicit step found no balance of forces.
    #[error(
        "at t = {time:.6} s no balance of forces was found, down to steps of {step:.3e} s: relative residuals {}; take shorter steps, a larger \
         newton_residual, or a dynamic integrator where the body snaps through",
        .residuals.iter().map(|r| format!("{r:.1e}")).collect::<Vec<_>>().join(", ")
    )]
    NoEquilibrium {
        /// Time at the start of the failed step \[s\].
        time: f64,
        /// Its length after halving \[s\].
        step: f64,
        /// Forces out of balance over those in balance, by iteration \[-\].
        residuals: Vec<f64>,
    },
    /// However short an implicit step, the estimate of its error is above what is allowed.
    #[error(
        "at t = {time:.6} s a step of {step:.3e} s makes an error of {error:.3e} m, and shorter ones no less than the {allowed:.3e} m of \
         time.error; allow more, or look for a load or an initial velocity that jumps"
    )]
    Inaccurate {
        /// Time at the start of the failed step \[s\].
        time: f64,
        /// Its length \[s\].
        step: f64,
        /// Estimate of the error of the displacement \[m\].
        error: f64,
        /// Largest error allowed \[m\].
        allowed: f64,
    },
    /// The domain of a particle outgrew its stencil.
    #[error(
        "at t = {time:.6} s the domain of particle {particle} at {position:?} m is {length:.3e} m long along an axis, more than two cells; take \
         domain = \"uniform\", more particles, or another basis"
    )]
    WideDomain {
        /// Time at the start of the failed substep \[s\].
        time: f64,
        /// Particle, as in the order of `particle/position`.
        particle: usize,
        /// Its position \[m\].
        position: Vec<f64>,
        /// Length of the domain \[m\].
        length: f64,
    },
    /// The particles of a body no longer stand in rows, or left a gap of more than a cell between them.
    #[error(
        "at t = {time:.6} s stresses cannot be reconstructed at {position:?} m: {reason}; take quadrature = \"least_squares\" or \"particles\""
    )]
    NoReconstruction {
        /// Time at the start of the failed substep \[s\].
        time: f64,
        /// Where \[m\].
        position: Vec<f64>,
        /// Why.
        reason: String,
    },
    /// The stress-free thickness of plane stress was not found.
    #[error("at t = {time:.6} s no stress-free thickness was found for particle {particle} at {position:?} m; the material is crushed")]
    NoThickness {
        /// Time at the start of the failed substep \[s\].
        time: f64,
        /// Particle, as in the order of `particle/position`.
        particle: usize,
        /// Its position \[m\].
        position: Vec<f64>,
    },
}

impl StepError {
    /// Time at which it went wrong \[s\].
    pub fn time(&self) -> Option<f64> {
        use StepError::*;
        match self {
            BadStep { .. } => None,
            Interrupted { time }
            | Unstable { time, .. }
            | BadLoad { time, .. }
            | Inverted { time, .. }
            | NotFinite { time, .. }
            | LeftGrid { time, .. }
            | NegativeMass { time, .. }
            | NoConvergence { time, .. }
            | NoEquilibrium { time, .. }
            | Inaccurate { time, .. }
            | WideDomain { time, .. }
            | NoReconstruction { time, .. }
            | NoThickness { time, .. } => Some(*time),
        }
    }

    /// The particle with which it went wrong, as in the order of `particle/position`.
    pub fn particle(&self) -> Option<usize> {
        use StepError::*;
        match self {
            Inverted { particle, .. }
            | NotFinite { particle, .. }
            | LeftGrid { particle, .. }
            | WideDomain { particle, .. }
            | NoThickness { particle, .. } => Some(*particle),
            _ => None,
        }
    }

    /// Where it went wrong \[m\]: position of the particle or node.
    pub fn position(&self) -> Option<&[f64]> {
        use StepError::*;
        match self {
            Inverted { position, .. }
            | NotFinite { position, .. }
            | LeftGrid { position, .. }
            | NegativeMass { position, .. }
            | WideDomain { position, .. }
            | NoReconstruction { position, .. }
            | NoThickness { position, .. } => Some(position),
            _ => None,
        }
    }
}

/// A call with wrong words or numbers. Nothing was changed.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ComponentError {
    /// No variable of that name.
    #[error("no variable `{name}`{}", nearest.as_ref().map(|n| format!("; did you mean `{n}`?")).unwrap_or_default())]
    UnknownVariable {
        /// Name asked for.
        name: String,
        /// Nearest right name.
        nearest: Option<String>,
    },
    /// Wrong number of values.
    #[error("`{name}` takes {expected} values, not {found}")]
    WrongShape {
        /// Variable.
        name: String,
        /// Values it takes.
        expected: usize,
        /// Values given.
        found: usize,
    },
    /// An output cannot be set.
    #[error("`{name}` is an output and cannot be set")]
    ReadOnly {
        /// Variable.
        name: String,
    },
    /// A value is NaN or infinite.
    #[error("`{name}`[{index}] is {value}; values are finite numbers")]
    NotFinite {
        /// Variable.
        name: String,
        /// Index of the first such value.
        index: usize,
        /// The value.
        value: f64,
    },
    /// The state cannot be measured.
    #[error("cannot be measured: {0}")]
    Unmeasurable(#[from] StepError),
    /// The bytes are no snapshot of this scene.
    #[error("cannot restore: {reason}")]
    BadSnapshot {
        /// What is wrong with the bytes.
        reason: &'static str,
    },
}
