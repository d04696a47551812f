//! `import matpoint._matpoint`: the parts of the Python package `matpoint` that are written in Rust.
//!
//! A thin adapter: it converts values, errors and arrays, releases the GIL, and holds no physics and no defaults. Everything else of the
//! package is Python, in `bindings/python/python/matpoint`.

mod array;
mod convert;
mod description;
mod error;
mod fork;
mod recording;
mod report;
mod scene;
mod simulation;

use pyo3::prelude::*;

#[pymodule]
mod _matpoint {
    #[pymodule_export]
    use super::description::{Description, Variable};
    #[pymodule_export]
    use super::fork::forked;
    #[pymodule_export]
    use super::recording::Recording;
    #[pymodule_export]
    use super::report::{Report, Summary};
    #[pymodule_export]
    use super::scene::Scene;
    #[pymodule_export]
    use super::simulation::{Simulation, restored};

    #[pymodule_export]
    #[allow(non_upper_case_globals, reason = "the name that Python has for it")]
    const __version__: &str = env!("CARGO_PKG_VERSION");
}
