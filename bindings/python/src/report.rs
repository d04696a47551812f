//! What a step and a run did.

use matpoint::{component, record};
use pyo3::prelude::*;

/// What a call of `Simulation.step` did.
#[pyclass(frozen, get_all, eq, module = "matpoint")]
#[derive(PartialEq)]
pub(crate) struct Report {
    /// Time reached [s].
    time: f64,
    /// Substeps taken.
    substeps: u64,
    /// Smallest substep [s].
    smallest_step: f64,
    /// Iterations of the solver of the mass matrix; 0 with lumped mass.
    iterations: u64,
}

impl From<component::Report> for Report {
    fn from(report: component::Report) -> Self {
        let component::Report { time, substeps, smallest_step, iterations } = report;
        Self { time, substeps, smallest_step, iterations }
    }
}

#[pymethods]
impl Report {
    fn __repr__(&self) -> String {
        let Self { time, substeps, smallest_step, iterations } = self;
        format!("Report(time={time}, substeps={substeps}, smallest_step={smallest_step}, iterations={iterations})")
    }
}

/// What a call of `Simulation.run` did.
#[pyclass(frozen, get_all, eq, module = "matpoint")]
#[derive(PartialEq)]
pub(crate) struct Summary {
    /// Time at the start [s].
    start: f64,
    /// Time reached [s].
    end: f64,
    /// Substeps taken.
    substeps: u64,
    /// Smallest substep [s]; infinite where none was taken.
    smallest_step: f64,
    /// Iterations of the solver of the mass matrix; 0 with lumped mass.
    iterations: u64,
}

impl From<record::Summary> for Summary {
    fn from(summary: record::Summary) -> Self {
        let record::Summary { start, end, substeps, smallest_step, iterations } = summary;
        Self { start, end, substeps, smallest_step, iterations }
    }
}

#[pymethods]
impl Summary {
    fn __repr__(&self) -> String {
        let Self { start, end, substeps, smallest_step, iterations } = self;
        format!("Summary(start={start}, end={end}, substeps={substeps}, smallest_step={smallest_step}, iterations={iterations})")
    }
}
