//! Scenes.

use crate::convert;
use crate::error::ToPython;
use crate::fork::with_threads;
use crate::simulation::Simulation;
use matpoint::scene::{self, Fault, SceneError, check};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyMapping};
use std::path::PathBuf;

/// A scene: what there is, what acts on it, how it is solved, what is recorded. SI units throughout.
///
/// Made from a file (`Scene.load`), from text (`Scene.from_toml`, `Scene.from_json`), from a dict (`Scene.from_dict`), or with keyword
/// arguments, which are the keys of a scene file; `matpoint.scene` has a typed dict for each of its parts::
///
///     from matpoint import Scene
///     from matpoint.scene import Body, Box, Grid, Material, Time
///
///     scene = Scene(
///         title="a falling block",
///         dimension=2,
///         grid=Grid(origin=[0, 0], size=[4, 4], cell=0.25),
///         material={"rubber": Material(law="neo_hookean", young=1e5, density=1e3)},
///         body={"block": Body(material="rubber", shape={"box": Box(min=[1, 2], max=[2, 3])})},
///         load={"weight": {"gravity": [0, -9.81]}},
///         time=Time(end=1),
///     )
///
/// Raises SceneError with every fault at once.
#[pyclass(frozen, eq, module = "matpoint")]
pub(crate) struct Scene {
    scene: scene::Scene,
    /// File and overrides, for the places of faults that show only when the scene is built.
    source: Option<(PathBuf, Vec<(String, String)>)>,
}

impl PartialEq for Scene {
    fn eq(&self, other: &Self) -> bool {
        self.scene == other.scene
    }
}

impl Scene {
    pub(crate) fn new(scene: scene::Scene) -> Self {
        Self { scene, source: None }
    }

    fn simulation(&self, py: Python<'_>) -> PyResult<matpoint::Simulation> {
        let built = py.detach(|| with_threads(|| matpoint::Simulation::new(self.scene.clone())));
        built.map_err(|error| match &self.source {
            Some((path, overrides)) => error.in_file(path, overrides).to_python(py),
            None => error.to_python(py),
        })
    }
}

#[pymethods]
impl Scene {
    #[new]
    #[pyo3(signature = (**keys))]
    fn from_keys(py: Python<'_>, keys: Option<&Bound<'_, PyDict>>) -> PyResult<Self> {
        match keys {
            Some(keys) => Self::from_dict(py, keys.as_mapping()),
            None => Self::from_dict(py, PyDict::new(py).as_mapping()),
        }
    }

    /// Reads a `.toml` or `.json` file, with some values set differently: `set={"grid.cell": 0.1, "method.transfer": "apic"}`.
    #[staticmethod]
    #[pyo3(signature = (path, set = None))]
    fn load(py: Python<'_>, path: PathBuf, set: Option<&Bound<'_, PyDict>>) -> PyResult<Self> {
        let overrides = convert::overrides(set)?;
        let scene = py.detach(|| scene::Scene::load_with(&path, &overrides)).map_err(|error| error.to_python(py))?;
        Ok(Self { scene, source: Some((path, overrides)) })
    }

    /// Reads TOML.
    #[staticmethod]
    fn from_toml(py: Python<'_>, text: &str) -> PyResult<Self> {
        scene::Scene::from_toml(text).map(Self::new).map_err(|error| error.to_python(py))
    }

    /// Reads JSON.
    #[staticmethod]
    fn from_json(py: Python<'_>, text: &str) -> PyResult<Self> {
        scene::Scene::from_json(text).map(Self::new).map_err(|error| error.to_python(py))
    }

    /// A scene from the keys that a scene file has. Keys that are None count as left out; numpy arrays are lists.
    #[staticmethod]
    fn from_dict(py: Python<'_>, keys: &Bound<'_, PyMapping>) -> PyResult<Self> {
        let text = convert::scene(keys)?;
        scene::Scene::from_toml(&text).map(Self::new).map_err(|error| without_lines(error).to_python(py))
    }

    /// Finds every fault, those that show only when the scene is built included, and raises SceneError with them. Returns warnings: what
    /// can be simulated but is seldom wise.
    fn check(&self, py: Python<'_>) -> PyResult<Vec<String>> {
        self.simulation(py)?;
        Ok(check::warnings(&self.scene).iter().map(ToString::to_string).collect())
    }

    /// Makes the scene ready to run: choices become types and tables here.
    pub(crate) fn build(&self, py: Python<'_>) -> PyResult<Simulation> {
        self.simulation(py).map(Simulation::new)
    }

    /// The scene as TOML, every key with its value.
    fn to_toml(&self) -> String {
        self.scene.to_toml()
    }

    /// The scene as JSON, every key with its value.
    fn to_json(&self) -> String {
        self.scene.to_json()
    }

    /// The scene as a dict, every key with its value.
    fn to_dict<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        py.import("json")?.call_method1("loads", (self.scene.to_json(),))
    }

    /// The JSON schema of a scene, with the meaning and unit of every key.
    #[staticmethod]
    fn schema(py: Python<'_>) -> PyResult<Bound<'_, PyAny>> {
        py.import("json")?.call_method1("loads", (scene::Scene::schema().to_string(),))
    }

    /// What the scene shows, in one line.
    #[getter]
    fn title(&self) -> &str {
        &self.scene.title
    }

    /// Number of space dimensions.
    #[getter]
    fn dimension(&self) -> usize {
        self.scene.dimension
    }

    /// End of a run [s].
    #[getter]
    fn end(&self) -> f64 {
        self.scene.time.end
    }

    fn __repr__(&self) -> String {
        format!("<matpoint.Scene {:?}, dimension {}>", self.scene.title, self.scene.dimension)
    }

    fn __str__(&self) -> String {
        self.scene.to_toml()
    }

    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<(Bound<'py, PyAny>, (String,))> {
        Ok((slf.get_type().getattr("from_json")?, (slf.get().scene.to_json(),)))
    }
}

/// Lines of text that the user never wrote would only confuse.
fn without_lines(error: SceneError) -> SceneError {
    match error {
        SceneError::Faults { faults, .. } => {
            let faults = faults.into_iter().map(|fault| Fault { line: None, column: None, ..fault }).collect();
            SceneError::Faults { file: None, faults }
        }
        error => error,
    }
}
