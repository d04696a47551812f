//! What a simulation is.

use matpoint::component::{self, Causality};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple};

/// One variable of a simulation.
#[pyclass(frozen, eq, hash, module = "matpoint")]
#[derive(Clone, PartialEq, Hash)]
pub(crate) struct Variable {
    /// Name, as `get` and `set` take it: `"particle/position"`, `"load/tip/traction"`.
    #[pyo3(get)]
    name: String,
    /// `"input"` or `"output"`.
    #[pyo3(get)]
    causality: &'static str,
    /// SI unit, empty for pure numbers.
    #[pyo3(get)]
    unit: &'static str,
    /// Meaning.
    #[pyo3(get)]
    doc: &'static str,
    sizes: Vec<usize>,
}

impl From<&component::Variable> for Variable {
    fn from(variable: &component::Variable) -> Self {
        let causality = match variable.causality {
            Causality::Input => "input",
            Causality::Output => "output",
        };
        Self { name: variable.name.clone(), causality, unit: variable.unit, doc: variable.doc, sizes: variable.shape.clone() }
    }
}

#[pymethods]
impl Variable {
    /// Shape of the array; empty for one number.
    #[getter]
    fn shape<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyTuple>> {
        PyTuple::new(py, &self.sizes)
    }

    fn __repr__(&self) -> String {
        format!("Variable({:?}, {}, unit={:?}, shape={:?})", self.name, self.causality, self.unit, self.sizes)
    }
}

/// What a simulation is: its method, what it needs and skips, its variables. Prints as text, and as a table in notebooks.
#[pyclass(frozen, module = "matpoint")]
pub(crate) struct Description(pub(crate) component::Description);

#[pymethods]
impl Description {
    /// Title of the scene.
    #[getter]
    fn title(&self) -> &str {
        &self.0.title
    }
    /// Number of space dimensions.
    #[getter]
    fn dimension(&self) -> usize {
        self.0.dimension
    }
    /// Number of particles.
    #[getter]
    fn particles(&self) -> usize {
        self.0.particles
    }
    /// Number of particles by body, in the order of `particle/body`.
    #[getter]
    fn bodies<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let bodies = PyDict::new(py);
        self.0.bodies.iter().try_for_each(|(name, count)| bodies.set_item(name, count))?;
        Ok(bodies)
    }
    /// The method, part by part, in words.
    #[getter]
    fn method<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let method = PyDict::new(py);
        self.0.method.iter().try_for_each(|(part, choice)| method.set_item(part, choice))?;
        Ok(method)
    }
    /// What `method = "auto"` has chosen: part of the method, what, and why; empty where the scene names its method.
    #[getter]
    fn choices(&self) -> Vec<(&'static str, String, String)> {
        self.0.choices.iter().map(|choice| (choice.part, choice.chosen.clone(), choice.why.clone())).collect()
    }

    /// What this scene needs, and so costs.
    #[getter]
    fn needs(&self) -> Vec<String> {
        self.0.needs.clone()
    }
    /// What this scene does not need, and so does not cost.
    #[getter]
    fn skips(&self) -> Vec<String> {
        self.0.skips.clone()
    }
    /// Memory of particles, grid and tables [bytes].
    #[getter]
    fn memory(&self) -> usize {
        self.0.memory
    }
    /// Largest stable step at time 0 [s].
    #[getter]
    fn stable_step(&self) -> f64 {
        self.0.stable_step
    }
    /// End of a run, as the scene has it [s].
    #[getter]
    fn end(&self) -> f64 {
        self.0.end
    }
    /// Variables by name.
    #[getter]
    fn variables<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let variables = PyDict::new(py);
        self.0.variables.iter().try_for_each(|v| variables.set_item(&v.name, Variable::from(v)))?;
        Ok(variables)
    }
    fn __str__(&self) -> String {
        self.0.to_string()
    }
    fn __repr__(&self) -> String {
        self.0.to_string()
    }
    fn _repr_html_(&self) -> String {
        self.0.html()
    }
}
