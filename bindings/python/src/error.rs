//! Errors as exceptions: the classes are in `matpoint/errors.py`.

use matpoint::component::{ComponentError, StepError};
use matpoint::record::RecordError;
use matpoint::scene::SceneError;
use pyo3::prelude::*;

/// An exception of the class `class` of `matpoint.errors`, with attributes that `fill` sets.
fn exception(py: Python<'_>, class: &str, message: String, fill: impl FnOnce(&Bound<'_, PyAny>) -> PyResult<()>) -> PyErr {
    let make = || {
        let error = py.import("matpoint.errors")?.getattr(class)?.call1((message,))?;
        fill(&error)?;
        Ok(PyErr::from_value(error))
    };
    make().unwrap_or_else(|error| error)
}

/// The exception for what the core found wrong.
pub(crate) trait ToPython {
    fn to_python(self, py: Python<'_>) -> PyErr;
}

impl ToPython for SceneError {
    fn to_python(self, py: Python<'_>) -> PyErr {
        exception(py, "SceneError", self.to_string(), |error| {
            let class = py.import("matpoint.errors")?.getattr("Fault")?;
            let faults: Vec<_> =
                self.faults().iter().map(|f| class.call1((&f.path, f.line, f.column, &f.message))).collect::<PyResult<_>>()?;
            error.setattr("faults", faults)
        })
    }
}

impl ToPython for StepError {
    fn to_python(self, py: Python<'_>) -> PyErr {
        exception(py, "StepError", self.to_string(), |error| {
            error.setattr("time", self.time())?;
            error.setattr("particle", self.particle())?;
            error.setattr("position", self.position().map(<[f64]>::to_vec))
        })
    }
}

impl ToPython for ComponentError {
    fn to_python(self, py: Python<'_>) -> PyErr {
        exception(py, "ComponentError", self.to_string(), |_| Ok(()))
    }
}

impl ToPython for RecordError {
    fn to_python(self, py: Python<'_>) -> PyErr {
        exception(py, "RecordError", self.to_string(), |_| Ok(()))
    }
}

/// A call that does not fit a variable, found here and not by the core.
pub(crate) fn misfit(py: Python<'_>, message: String) -> PyErr {
    exception(py, "ComponentError", message, |_| Ok(()))
}

/// A simulation that cannot be used now.
pub(crate) fn unusable(py: Python<'_>, message: &str) -> PyErr {
    exception(py, "MatpointError", message.to_owned(), |_| Ok(()))
}
