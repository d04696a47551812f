//! The one list of variables: names, units, shapes and meaning. Every adapter reads its variables from here.

/// Whether a variable is set from outside or read.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Causality {
    /// Set from outside, held over the following steps.
    Input,
    /// Computed by the simulation.
    Output,
}

/// One variable of a [`crate::Simulation`].
#[derive(Debug, Clone, PartialEq)]
pub struct Variable {
    /// Name, as `get` and `set` take it: `particle/position`, `load/tip/traction`.
    pub name: String,
    /// Input or output.
    pub causality: Causality,
    /// SI unit, empty for pure numbers.
    pub unit: &'static str,
    /// Shape of the C-order array; empty for one number.
    pub shape: Vec<usize>,
    /// Meaning.
    pub doc: &'static str,
}

impl Variable {
    /// Number of values.
    pub fn len(&self) -> usize {
        self.shape.iter().product()
    }
    /// Whether it holds no value.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

/// What a call of [`crate::Simulation::step`] did.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Report {
    /// Time reached \[s\].
    pub time: f64,
    /// Substeps taken.
    pub substeps: u64,
    /// Smallest substep \[s\].
    pub smallest_step: f64,
    /// Iterations of Newton's method, or of the solver of the mass matrix, all substeps together; 0 where there is neither.
    pub iterations: u64,
}

/// Where the last step was not of the order of the method, cell by cell.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Fallback {
    /// Cells that were integrated at their particles, as those are too few or too uneven for a fit.
    pub cells: usize,
    /// Nodes with little of a body that found none to follow: lumped where their mass is next to nothing.
    pub nodes: usize,
    /// Nodes at which bodies pushed each other.
    pub contacts: usize,
}
