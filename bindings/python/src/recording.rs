//! Recordings.

use crate::error::ToPython;
use crate::simulation::Simulation;
use pyo3::prelude::*;
use pyo3::types::PyTuple;
use std::path::PathBuf;
use std::sync::Mutex;

/// A recording under way, made by `Simulation.record`. Close it, or use it in a with statement; then its files are complete.
#[pyclass(frozen, module = "matpoint")]
pub(crate) struct Recording {
    simulation: Py<Simulation>,
    id: u64,
    files: Mutex<Vec<PathBuf>>,
}

impl Recording {
    pub(crate) fn new(simulation: Py<Simulation>, id: u64) -> Self {
        Self { simulation, id, files: Mutex::default() }
    }
}

#[pymethods]
impl Recording {
    /// Records the last state and completes the files. Does nothing where that has been done.
    fn close(&self, py: Python<'_>) -> PyResult<()> {
        let id = self.id;
        match self.simulation.get().with(py, |inner| inner.close(id))? {
            Some(Ok(written)) => {
                *self.files.lock().unwrap_or_else(|broken| broken.into_inner()) = written;
                Ok(())
            }
            Some(Err(error)) => Err(error.to_python(py)),
            None => Ok(()),
        }
    }

    /// The files that are complete; empty until the recording is closed.
    #[getter]
    fn files(&self) -> Vec<PathBuf> {
        self.files.lock().unwrap_or_else(|broken| broken.into_inner()).clone()
    }

    fn __enter__(slf: Py<Self>) -> Py<Self> {
        slf
    }

    #[pyo3(signature = (*_error))]
    fn __exit__(&self, py: Python<'_>, _error: &Bound<'_, PyTuple>) -> PyResult<()> {
        self.close(py)
    }
}
