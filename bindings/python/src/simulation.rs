//! Simulations.

use crate::array;
use crate::description::{Description, Variable};
use crate::error::{ToPython, unusable};
use crate::fork::with_threads;
use crate::recording::Recording;
use crate::report::{Report, Summary};
use crate::scene::Scene;
use matpoint::component::{ComponentError, StepError};
use matpoint::record::{self, Options, Precision, RecordError, Recorder, sink_for};
use numpy::PyArrayDyn;
use parking_lot::ReentrantMutex;
use pyo3::prelude::*;
use pyo3::pybacked::PyBackedBytes;
use pyo3::types::PyBytes;
use std::cell::RefCell;
use std::path::PathBuf;
use std::sync::Arc;
use std::time::{Duration, Instant};

/// How often a long step looks whether Ctrl-C was pressed.
const LOOK: Duration = Duration::from_millis(50);

/// A running scene.
///
/// Loads go in with `set`, `step` moves time, the state comes out with `get`. Only `step` and `run` move time. A failed call leaves the
/// simulation as it was. May be used from several threads: calls wait for each other, and `step` lets other threads of Python run.
#[pyclass(frozen, module = "matpoint")]
pub(crate) struct Simulation {
    /// A signal handler runs in the thread that steps, so that it must be able to find out that the simulation is in use.
    inner: ReentrantMutex<RefCell<Inner>>,
}

pub(crate) struct Inner {
    sim: matpoint::Simulation,
    recorders: Vec<(u64, Recorder<'static>)>,
    /// Recorders opened so far.
    opened: u64,
    /// Whether a call is under way; true at the start of a call where the last one panicked.
    busy: bool,
}

/// A function and what to call it with: how a pickle makes a simulation again.
type Recipe<'py> = (Bound<'py, PyAny>, (Scene, Bound<'py, PyBytes>));

/// Why a call failed, while Python is let go.
pub(crate) enum Failure {
    Step(StepError),
    Component(ComponentError),
    Record(RecordError),
    Python(PyErr),
}

impl From<StepError> for Failure {
    fn from(error: StepError) -> Self {
        Self::Step(error)
    }
}
impl From<ComponentError> for Failure {
    fn from(error: ComponentError) -> Self {
        Self::Component(error)
    }
}
impl From<RecordError> for Failure {
    fn from(error: RecordError) -> Self {
        Self::Record(error)
    }
}

impl ToPython for Failure {
    fn to_python(self, py: Python<'_>) -> PyErr {
        match self {
            Self::Step(error) => error.to_python(py),
            Self::Component(error) => error.to_python(py),
            Self::Record(error) => error.to_python(py),
            Self::Python(error) => error,
        }
    }
}

impl Inner {
    fn new(sim: matpoint::Simulation) -> Self {
        Self { sim, recorders: Vec::new(), opened: 0, busy: false }
    }

    /// Steps and records. Ctrl-C, or what else a signal handler raises, stops it and leaves the state as it was.
    fn step(&mut self, dt: f64) -> Result<matpoint::component::Report, Failure> {
        let mut raised = None;
        let mut looked = Instant::now();
        let mut proceed = || {
            if looked.elapsed() > LOOK {
                raised = Python::attach(|py| py.check_signals()).err();
                looked = Instant::now();
            }
            raised.is_none()
        };
        let report = self.sim.step_while(dt, &mut proceed);
        if let Some(error) = raised {
            return Err(Failure::Python(error));
        }
        let report = report?;
        let mut index = 0;
        while index < self.recorders.len() {
            if let Err(error) = self.recorders[index].1.offer(&mut self.sim) {
                // one that cannot be written is of no more use
                self.recorders.remove(index);
                return Err(error.into());
            }
            index += 1;
        }
        Ok(report)
    }

    /// Closes a recorder; `None` where that has been done.
    pub(crate) fn close(&mut self, id: u64) -> Option<Result<Vec<PathBuf>, RecordError>> {
        let index = self.recorders.iter().position(|(other, _)| *other == id)?;
        let (_, recorder) = self.recorders.remove(index);
        Some(recorder.finish(&mut self.sim))
    }
}

impl Drop for Inner {
    fn drop(&mut self) {
        // nobody is left to be told what goes wrong
        for (_, recorder) in std::mem::take(&mut self.recorders) {
            let _ = recorder.finish(&mut self.sim);
        }
    }
}

impl Simulation {
    pub(crate) fn new(sim: matpoint::Simulation) -> Self {
        Self { inner: ReentrantMutex::new(RefCell::new(Inner::new(sim))) }
    }

    /// Calls `work` with the simulation, once other threads are done with it. Other threads of Python run meanwhile.
    pub(crate) fn with<R: Send>(&self, py: Python<'_>, work: impl FnOnce(&mut Inner) -> R + Send) -> PyResult<R> {
        let done = py.detach(|| {
            let lock = self.inner.lock();
            let Ok(mut borrowed) = lock.try_borrow_mut() else {
                return Err("the simulation is stepping in this very thread: a signal handler cannot use it");
            };
            let inner: &mut Inner = &mut borrowed;
            if std::mem::replace(&mut inner.busy, true) {
                return Err("an earlier call broke this simulation; build it anew");
            }
            let result = with_threads(|| work(inner));
            inner.busy = false;
            Ok(result)
        });
        done.map_err(|message| unusable(py, message))
    }

    /// As [`with`](Self::with), for work that can fail.
    fn attempt<R: Send>(&self, py: Python<'_>, work: impl FnOnce(&mut Inner) -> Result<R, Failure> + Send) -> PyResult<R> {
        self.with(py, work)?.map_err(|failure| failure.to_python(py))
    }

    /// Values and shape of a variable.
    fn values(&self, py: Python<'_>, name: &str) -> PyResult<(Arc<Vec<f64>>, Vec<usize>)> {
        self.attempt(py, |inner| Ok((inner.sim.share(name)?, inner.sim.variable(name)?.shape.clone())))
    }
}

#[pymethods]
impl Simulation {
    /// The scene that runs.
    #[getter]
    fn scene(&self, py: Python<'_>) -> PyResult<Scene> {
        self.with(py, |inner| inner.sim.scene().clone()).map(Scene::new)
    }

    /// Time [s].
    #[getter]
    fn time(&self, py: Python<'_>) -> PyResult<f64> {
        self.with(py, |inner| inner.sim.time())
    }

    /// Substeps taken since time 0.
    #[getter]
    fn steps(&self, py: Python<'_>) -> PyResult<u64> {
        self.with(py, |inner| inner.sim.steps())
    }

    /// Largest stable substep [s], inf where steps are implicit. `step` takes as many substeps as it needs; this is for those who want to know.
    #[getter]
    fn max_step(&self, py: Python<'_>) -> PyResult<f64> {
        self.with(py, |inner| inner.sim.max_step())
    }

    /// Forces out of balance over those in balance [-], before each iteration of Newton's method in the last substep and at its end; empty for
    /// explicit integrators, and before the first step.
    #[getter]
    fn residuals(&self, py: Python<'_>) -> PyResult<Vec<f64>> {
        self.with(py, |inner| inner.sim.residuals().to_vec())
    }

    /// Moves time by dt [s], in as many substeps as are needed, and lands exactly on the new time.
    ///
    /// Raises StepError where that cannot be done, and KeyboardInterrupt on Ctrl-C; the state is then as it was before the call.
    fn step(&self, py: Python<'_>, dt: f64) -> PyResult<Report> {
        self.attempt(py, |inner| inner.step(dt)).map(Into::into)
    }

    /// Steps until a time [s], the end of the scene if None, and stops on the way at the times at which the scene records.
    ///
    /// `callback(simulation)` is called after each stop; where it returns False the run ends there. A progress bar is drawn where stderr is
    /// a terminal or a notebook. Ctrl-C ends the run: the state is then that of the last stop, and a recording is good up to there.
    #[pyo3(signature = (until = None, callback = None, progress = true))]
    fn run(slf: &Bound<'_, Self>, until: Option<f64>, callback: Option<Bound<'_, PyAny>>, progress: bool) -> PyResult<Summary> {
        let (py, this) = (slf.py(), slf.get());
        // without a sink: it only knows when the scene records
        let begin = |inner: &mut Inner| Recorder::begin(&mut inner.sim, Vec::new(), None, None).map_err(Failure::Record);
        let mut stops = this.attempt(py, begin)?;
        let (mut time, end, particles) =
            this.with(py, |inner| (inner.sim.time(), inner.sim.scene().time.end, inner.sim.describe().particles))?;
        let until = until.unwrap_or(end);
        let bar = progress.then(|| py.import("matpoint.progress")?.call_method1("bar", (time, until, particles))).transpose()?;
        let mut summary = record::Summary::new(time);
        let mut outcome = Ok(());
        loop {
            if time >= until {
                break;
            }
            let stop = this.attempt(py, |inner| {
                let sim = &inner.sim;
                let next = inner.recorders.iter().fold(stops.next(sim, until), |next, (_, recorder)| next.min(recorder.next(sim, until)));
                let report = inner.step(next - inner.sim.time())?;
                stops.offer(&mut inner.sim)?;
                Ok(report)
            });
            outcome = stop.and_then(|report| {
                summary.add(&report);
                time = report.time;
                if let Some(bar) = &bar {
                    bar.call_method1("show", (time, summary.substeps))?;
                }
                let go_on = callback.as_ref().map(|callback| callback.call1((slf,))).transpose()?;
                if go_on.is_some_and(|answer| answer.extract::<bool>().is_ok_and(|go_on| !go_on)) {
                    time = f64::INFINITY;
                }
                py.check_signals()
            });
            if outcome.is_err() {
                break;
            }
        }
        if let Some(bar) = &bar {
            bar.call_method0("close")?;
        }
        outcome.map(|()| summary.into())
    }

    /// Sets an input; it is held until set again. Takes a number, or what numpy reads as an array of the variable's shape.
    fn set(&self, py: Python<'_>, name: &str, value: &Bound<'_, PyAny>) -> PyResult<()> {
        let shape = self.attempt(py, |inner| Ok(inner.sim.variable(name)?.shape.clone()))?;
        array::read(value, &shape, name, |values| {
            let values = values.to_vec();
            self.attempt(py, |inner| Ok(inner.sim.set(name, &values)?))
        })?
    }

    /// The values of a variable: a copy as a C-order float64 array, of shape (n, dimension) or (n, 3, 3) for particles, () for one number.
    ///
    /// `out` is an array to write to instead. `view=True` gives a read-only array without a copy; it keeps showing these values when the
    /// simulation goes on. Values are computed when first asked for after a step, and kept until the next.
    #[pyo3(signature = (name, out = None, *, view = false))]
    fn get<'py>(&self, py: Python<'py>, name: &str, out: Option<Bound<'py, PyAny>>, view: bool) -> PyResult<Bound<'py, PyAny>> {
        let (values, shape) = self.values(py, name)?;
        match out {
            Some(_) if view => Err(crate::error::misfit(py, format!("`{name}`: give out or view=True, not both"))),
            Some(out) => array::copy_to(py, &values, &shape, &out, name).map(|()| out),
            None if view => array::view(py, values, &shape).map(Bound::into_any),
            None => Ok(array::copy(py, &values, &shape).into_any()),
        }
    }

    fn __getitem__<'py>(&self, py: Python<'py>, name: &str) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        let (values, shape) = self.values(py, name)?;
        Ok(array::copy(py, &values, &shape))
    }

    fn __setitem__(&self, py: Python<'_>, name: &str, value: &Bound<'_, PyAny>) -> PyResult<()> {
        self.set(py, name, value)
    }

    fn __contains__(&self, py: Python<'_>, name: &str) -> PyResult<bool> {
        self.with(py, |inner| inner.sim.variable(name).is_ok())
    }

    /// The names of all variables.
    fn names(&self, py: Python<'_>) -> PyResult<Vec<String>> {
        self.with(py, |inner| inner.sim.describe().variables.into_iter().map(|variable| variable.name).collect())
    }

    /// What a variable is: unit, shape, meaning.
    fn variable(&self, py: Python<'_>, name: &str) -> PyResult<Variable> {
        self.attempt(py, |inner| Ok(Variable::from(inner.sim.variable(name)?)))
    }

    /// The state now, by attributes: `state.time`, `state.particle.position`, `state.energy.total`, `state.probe.tip.displacement`.
    fn state<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        slf.py().import("matpoint.state")?.getattr("State")?.call1((slf,))
    }

    /// What this simulation is: its method, what it needs and skips, its variables.
    fn describe(&self, py: Python<'_>) -> PyResult<Description> {
        self.with(py, |inner| inner.sim.describe()).map(Description)
    }

    /// All that a restart needs, as bytes.
    fn save<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        self.with(py, |inner| inner.sim.save()).map(|bytes| PyBytes::new(py, &bytes))
    }

    /// Goes back to a saved state of the same scene. Steps from here on give the same bytes as from there.
    fn restore(&self, py: Python<'_>, bytes: PyBackedBytes) -> PyResult<()> {
        self.attempt(py, |inner| Ok(inner.sim.restore(&bytes)?))
    }

    /// Goes back to time 0, inputs at zero.
    fn reset(&self, py: Python<'_>) -> PyResult<()> {
        self.with(py, |inner| inner.sim.reset())
    }

    /// Records what the simulation does from now on, until the recording is closed; to be used in a with statement.
    ///
    /// The ending of the path says how: `.mcap` for ROS 2 and Foxglove, `.rrd` for Rerun, `.pvd` for ParaView, `.svg` for a picture of the last
    /// state, none for a folder of CSV tables. What is there already is not written over unless `force`. Particles are recorded every `every`
    /// seconds of simulated time, energies and probes every `history` seconds; as the scene says if None. A step that leaps over several
    /// such times is recorded once; `run` stops at each. `variables` names what is recorded of particles beside the position, such as
    /// `["velocity", "stress"]`, in 64 bits if `double`; `snapshots` is the simulated time between states from which a run can go on;
    /// `cells` shows the cells of the background grid that hold particles, in Rerun.
    #[pyo3(signature = (path, every = None, history = None, *, force = false, variables = None, double = false, snapshots = None, cells = false))]
    #[expect(clippy::too_many_arguments, reason = "keywords")]
    fn record(
        slf: &Bound<'_, Self>,
        path: PathBuf,
        every: Option<f64>,
        history: Option<f64>,
        force: bool,
        variables: Option<Vec<String>>,
        double: bool,
        snapshots: Option<f64>,
        cells: bool,
    ) -> PyResult<Recording> {
        let precision = if double { Precision::Double } else { Precision::Single };
        let options = Options { force, variables, precision, snapshots, cells, ..Options::default() };
        let id = slf.get().attempt(slf.py(), |inner| {
            let recorder = Recorder::begin(&mut inner.sim, vec![sink_for(&path, &options)?], every, history)?;
            inner.opened += 1;
            inner.recorders.push((inner.opened, recorder));
            Ok(inner.opened)
        })?;
        Ok(Recording::new(slf.clone().unbind(), id))
    }

    fn _ipython_key_completions_(&self, py: Python<'_>) -> PyResult<Vec<String>> {
        self.names(py)
    }

    fn _repr_html_(&self, py: Python<'_>) -> PyResult<String> {
        self.with(py, |inner| inner.sim.describe().html())
    }

    fn __repr__(&self, py: Python<'_>) -> PyResult<String> {
        self.with(py, |inner| {
            let description = inner.sim.describe();
            format!("<matpoint.Simulation {:?}, {} particles, t = {} s>", description.title, description.particles, inner.sim.time())
        })
    }

    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<Recipe<'py>> {
        let (py, this) = (slf.py(), slf.get());
        let make = py.import("matpoint._matpoint")?.getattr("_restored")?;
        Ok((make, (this.scene(py)?, this.save(py)?)))
    }
}

/// A simulation of a scene in a saved state.
#[pyfunction]
#[pyo3(name = "_restored")]
pub(crate) fn restored(py: Python<'_>, scene: &Scene, bytes: PyBackedBytes) -> PyResult<Simulation> {
    let simulation = scene.build(py)?;
    simulation.restore(py, bytes)?;
    Ok(simulation)
}
