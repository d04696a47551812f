//! 6 FROM OUTSIDE: all that an adapter (Python, ROS 2, a recorder, the command line) may see.

mod auto;
mod description;
mod error;
mod exact;
mod output;
mod variable;
mod words;

pub use auto::Choice;
pub use description::Description;
pub use error::{ComponentError, StepError};
pub use variable::{Causality, Fallback, Report, Variable};

use crate::model::{Masses, Model, Pace, Signal};
use crate::scene::{Fault, Scene, SceneError};
use crate::solver::{Solver, awake};
use crate::state::State;
use crate::step::measure::Measures;
use crate::step::{Next, Wrong};
use exact::Exact;
use output::Outputs;
use std::path::Path;
use std::sync::Arc;

/// A running scene.
///
/// Loads go in with [`set`](Self::set), [`step`](Self::step) moves time, the state comes out with [`get`](Self::get). Only `step` moves
/// time. A failed call leaves the simulation as it was.
pub struct Simulation {
    scene: Scene,
    model: Model,
    state: State,
    solver: Solver,
    /// Stable step at time 0 \[s\].
    stable_step: f64,
    exact: Option<Exact>,
    /// Measures at time 0, from which errors of energy are counted.
    initial: Measures,
    outputs: Outputs,
    /// What `method = "auto"` has chosen.
    choices: Vec<Choice>,
    /// State before the step under way.
    backup: State,
    /// Length of the last call of `step` \[s\]: where the one before had the same, the next is taken to have it too.
    last_call: f64,
    /// Iterations of the solver of the mass matrix since the simulation was made.
    iterations: u64,
}

// adapters move a simulation between threads
const _: fn() = || {
    fn may_move<T: Send + Sync>() {}
    may_move::<Simulation>();
};

impl Scene {
    /// Makes the scene ready to run: choices become types and tables here.
    ///
    /// # Errors
    /// Every fault of the scene; a fixed step above the stable one.
    pub fn build(self) -> Result<Simulation, SceneError> {
        Simulation::new(self)
    }
}

impl Simulation {
    /// Reads a scene file, with some values set differently (see [`Scene::load_with`]), and makes it ready to run.
    ///
    /// # Errors
    /// Every fault with its line and column, those that show only when the scene is built included.
    pub fn load(path: impl AsRef<Path>, overrides: &[(String, String)]) -> Result<Self, SceneError> {
        let path = path.as_ref();
        Self::new(Scene::load_with(path, overrides)?).map_err(|error| error.in_file(path, overrides))
    }

    /// Makes a scene ready to run.
    ///
    /// # Errors
    /// Every fault of the scene; a fixed step above the stable one.
    pub fn new(scene: Scene) -> Result<Self, SceneError> {
        scene.check()?;
        let (scene, choices) = auto::choose(scene)?;
        let (model, mut state) = Model::new(&scene)?;
        let fault = |path: &str, message: String| SceneError::Faults { file: None, faults: vec![Fault::new(path, message)] };
        let mut solver = Solver::new(&model, &mut state);
        let stable_step = solver.stable_step(&model, &state).map_err(|e| fault("body", e.to_string()))?;
        state.pace = initial_pace(&model, &state);
        let largest = stable_step * state.pace;
        if !(largest > 0.0 && (largest.is_finite() || model.implicit.is_some())) {
            let message = format!("makes a stable step of {largest} s; velocities and stiffness must leave it a positive number");
            return Err(fault("body", message));
        }
        if let Pace::Fixed(step) = model.pace
            && step > largest
        {
            let message =
                format!("is {step} s, above the stable step of {largest:.4e} s; take at most {:.2e}, or `cfl` instead", 0.99 * largest);
            return Err(fault("time.step", message));
        }
        let exact = scene.exact.as_ref().map(|e| Exact::new(e, model.dimension)).transpose().map_err(|m| fault("exact", m))?;
        let initial = solver.measure(&model, &mut state).map_err(|e| fault("body", e.to_string()))?;
        let outputs = Outputs::new(&model, &state, exact.as_ref());
        Ok(Self {
            scene,
            model,
            state,
            solver,
            stable_step,
            exact,
            initial,
            outputs,
            choices,
            backup: State::default(),
            last_call: 0.0,
            iterations: 0,
        })
    }

    /// A simulation of the same scene that takes over states of this one; it is in none until then.
    pub(crate) fn twin(&self) -> Self {
        let mut state = self.state.clone();
        Self {
            scene: self.scene.clone(),
            model: self.model.clone(),
            solver: Solver::new(&self.model, &mut state),
            state: State::default(),
            stable_step: self.stable_step,
            outputs: Outputs::new(&self.model, &self.state, self.exact.as_ref()),
            exact: self.exact.clone(),
            initial: self.initial.clone(),
            choices: self.choices.clone(),
            backup: State::default(),
            last_call: 0.0,
            iterations: 0,
        }
    }

    /// Copies the state.
    pub(crate) fn copy_state(&self, to: &mut State) {
        self.state.copy_to(to);
    }

    /// Takes over a state of a simulation of the same scene, and gives its own.
    pub(crate) fn exchange_state(&mut self, state: &mut State) {
        std::mem::swap(&mut self.state, state);
        self.replaced();
    }

    /// Puts the particles in memory in no order, as if the scene had made them so.
    pub(crate) fn shuffle(&mut self) {
        self.state.shuffle();
        self.replaced();
    }

    /// Forgets what belongs to the state that was there before.
    fn replaced(&mut self) {
        self.solver.forget(&self.model);
        self.outputs.outdate();
        // its particles may have other masses
        self.backup.particles.id.clear();
    }

    /// Does it wrong on purpose, to show what comes of it.
    pub(crate) fn go_wrong(&mut self, wrong: Wrong) {
        self.solver.go_wrong(wrong);
        if wrong == Wrong::NegativeMass {
            self.model.masses = Masses::Signed;
        }
    }

    /// The scene that runs; with `method = "auto"`, the method that was chosen.
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// Time \[s\].
    pub fn time(&self) -> f64 {
        self.state.time
    }

    /// Substeps taken since time 0.
    pub fn steps(&self) -> u64 {
        self.state.steps
    }

    /// Iterations of Newton's method, or of the solver of the mass matrix, since the simulation was made; 0 where there is neither.
    pub fn iterations(&self) -> u64 {
        self.iterations
    }

    /// Forces out of balance over those in balance \[-\], before each iteration of Newton's method in the last substep and at its end; empty
    /// for explicit integrators, and before the first step.
    pub fn residuals(&self) -> &[f64] {
        self.solver.residuals()
    }

    /// Largest stable substep \[s\], infinite where steps are implicit: the stable step of the scene at time 0, less what waves and particles have gained in speed since
    /// (with a fixed step: what they had at time 0). Where particles have moved to other places in their cells it may be lower, down to
    /// half with one particle a cell; `cfl` is there to leave room for that.
    pub fn max_step(&self) -> f64 {
        self.stable_step * self.state.pace
    }

    /// The substep that a step of many would begin with \[s\].
    pub fn usual_step(&self) -> f64 {
        match self.model.pace {
            Pace::Fixed(step) => step,
            Pace::Cfl(share) => share * self.max_step(),
            Pace::Error { .. } => self.state.next_step,
        }
    }

    /// Moves time by `dt` \[s\], in as many substeps as are needed, and lands exactly on the new time.
    ///
    /// # Errors
    /// A step that cannot be done; the state is then as it was before the call.
    pub fn step(&mut self, dt: f64) -> Result<Report, StepError> {
        // the threads stay awake from the first substep to the last
        if self.solver.shares(&self.state) { awake(|| self.step_asking(dt, None)) } else { self.step_asking(dt, None) }
    }

    /// As [`step`](Self::step), as long as `proceed` says so: it is asked after each substep but the last.
    ///
    /// # Errors
    /// As [`step`](Self::step), and [`StepError::Interrupted`] where `proceed` said no; the state is then as it was before the call.
    pub fn step_while(&mut self, dt: f64, proceed: &mut dyn FnMut() -> bool) -> Result<Report, StepError> {
        self.step_asking(dt, Some(proceed))
    }

    fn step_asking(&mut self, dt: f64, proceed: Option<&mut dyn FnMut() -> bool>) -> Result<Report, StepError> {
        if !(dt > 0.0 && dt.is_finite()) {
            return Err(StepError::BadStep { step: dt });
        }
        self.state.copy_to(&mut self.backup);
        let result = self.substeps(dt, proceed);
        if result.is_err() {
            std::mem::swap(&mut self.state, &mut self.backup);
            self.solver.forget(&self.model);
        } else {
            self.outputs.outdate();
            self.last_call = dt;
        }
        result
    }

    fn substeps(&mut self, dt: f64, mut proceed: Option<&mut dyn FnMut() -> bool>) -> Result<Report, StepError> {
        let (start, first) = (self.state.time, self.state.steps);
        let end = start + dt;
        let mut smallest = f64::INFINITY;
        self.solver.begin(&self.model);
        let mut done = 0.0;
        let (mut left, mut h) = self.plan(dt, start, end, done);
        loop {
            let time = self.state.time;
            // one ahead: the pass that ends a step begins the next
            let knows = !matches!(self.model.pace, Pace::Error { .. });
            let next = (knows && left > 1.0).then(|| self.plan(dt, time + h, end, done + 1.0));
            let of_next_call = || (knows && dt == self.last_call).then(|| self.plan(dt, end, end + dt, 0.0));
            let coming = next.or_else(of_next_call).map(|(_, dt)| Next { dt, at_once: next.is_some() });
            if time + h <= time || h.is_nan() {
                return Err(StepError::Unstable { time, stable: self.max_step() });
            }
            self.advance(h, coming, proceed.is_some())?;
            done += 1.0;
            let taken = self.state.time - time;
            smallest = smallest.min(taken);
            if left <= 1.0 && taken >= (1.0 - 1e-9) * h {
                break;
            }
            if !proceed.as_mut().is_none_or(|proceed| proceed()) {
                return Err(StepError::Interrupted { time: self.state.time });
            }
            (left, h) = next.unwrap_or_else(|| self.plan(dt, self.state.time, end, done));
        }
        self.state.time = end;
        self.solver.end(&self.model, &mut self.state);
        let (substeps, iterations) = (self.state.steps - first, self.solver.iterations());
        self.iterations += iterations;
        Ok(Report { time: end, substeps, smallest_step: smallest, iterations })
    }

    /// One substep. Who is asked between two of them is asked on the thread of the caller: then each is handed to the others by itself.
    fn advance(&mut self, h: f64, next: Option<Next>, asking: bool) -> Result<(), StepError> {
        let Self { solver, model, state, .. } = self;
        let wakes = asking && solver.shares(state);
        if wakes { awake(|| solver.advance(model, state, h, next)) } else { solver.advance(model, state, h, next) }
    }

    /// How many substeps are left at `time` of a step of length `dt` that ends at `end`, of which some are `done`, and how long the next is.
    fn plan(&self, dt: f64, time: f64, end: f64, done: f64) -> (f64, f64) {
        match self.model.pace {
            Pace::Fixed(step) => (substeps_in(dt, step) - done, dt / substeps_in(dt, step)),
            // as many equal ones as the stable step of now asks for, thought over for each
            Pace::Cfl(share) => {
                let left = substeps_in(end - time, share * self.max_step());
                (left, (end - time) / left)
            }
            // the same, but each may turn out to be too long
            Pace::Error { .. } => {
                let left = substeps_in(end - time, self.state.next_step);
                (left, if left <= 2.0 { (end - time) / left } else { self.state.next_step })
            }
        }
    }

    /// Where the last step fell back to a lower order: none before the first step.
    pub fn fallback(&self) -> Fallback {
        self.solver.fallback()
    }

    /// What a variable is.
    ///
    /// # Errors
    /// Unknown name.
    pub fn variable(&self, name: &str) -> Result<&Variable, ComponentError> {
        self.outputs.find(name).map(|index| self.outputs.variable(index))
    }

    /// Sets an input; it is held until set again.
    ///
    /// # Errors
    /// Unknown name, output, wrong number of values, value that is not finite.
    pub fn set(&mut self, name: &str, values: &[f64]) -> Result<(), ComponentError> {
        let load = self.outputs.input(name, values)?;
        self.state.inputs[load].copy_from_slice(values);
        self.outputs.outdate();
        Ok(())
    }

    /// The values of a variable as a C-order array, computed where they are not yet.
    ///
    /// # Errors
    /// Unknown name.
    pub fn get(&mut self, name: &str) -> Result<&[f64], ComponentError> {
        self.values(name).map(|values| values.as_slice())
    }

    /// As [`get`](Self::get), to be kept: what a later step makes does not change what was shared.
    ///
    /// # Errors
    /// Unknown name.
    pub fn share(&mut self, name: &str) -> Result<Arc<Vec<f64>>, ComponentError> {
        self.values(name).cloned()
    }

    fn values(&mut self, name: &str) -> Result<&Arc<Vec<f64>>, ComponentError> {
        let index = self.outputs.find(name)?;
        if self.outputs.needs_particles(index) {
            self.solver.show(&self.model, &mut self.state)?;
        }
        if self.outputs.needs_probes(index) {
            self.outputs.probes = Some(self.solver.probe(&self.model, &self.state));
        }
        if self.outputs.needs_measures(index) {
            self.outputs.measures = Some(self.solver.measure(&self.model, &mut self.state)?);
        }
        let lookup = if self.model.needs.lookup { self.solver.lookup(&self.state) } else { &[] };
        Ok(self.outputs.value(index, &self.model, &self.state, lookup, &self.initial, self.exact.as_ref()))
    }

    /// Internal force at node `node` of a scene in dimension 1 \[N\]: the integral of stress times slope of its function, as the method of the
    /// scene sums it (Tielen 2016, equation 3.2). Means what it says where no load acts on particles or surfaces. Zero far from any body.
    ///
    /// # Errors
    /// A state that cannot be measured.
    pub(crate) fn internal_force(&mut self, node: usize) -> Result<f64, ComponentError> {
        let force = self.solver.nodal_force(&self.model, &mut self.state, [0, 0, node as i32])?;
        Ok(-force.unwrap_or(0.0))
    }

    /// All bytes that a restart needs.
    pub fn save(&self) -> Vec<u8> {
        // a state is plain numbers: there is nothing that could not be written to memory
        postcard::to_allocvec(&(SNAPSHOT, self.fingerprint(), self.state.bare().as_ref())).unwrap_or_default()
    }

    /// Goes back to a saved state of the same scene. Steps from here on give the same bytes as from there.
    ///
    /// # Errors
    /// Bytes that are no snapshot, or one of another scene or version; nothing is changed then.
    pub fn restore(&mut self, bytes: &[u8]) -> Result<(), ComponentError> {
        let bad = |reason| ComponentError::BadSnapshot { reason };
        let (header, rest) = postcard::take_from_bytes::<([u8; 8], u64)>(bytes).map_err(|_| bad("the bytes are no snapshot"))?;
        if header.0 != SNAPSHOT {
            return Err(bad("the bytes are no snapshot, or one of another version"));
        }
        if header.1 != self.fingerprint() {
            return Err(bad("the snapshot is of another scene"));
        }
        let (mut state, rest) = postcard::take_from_bytes::<State>(rest).map_err(|_| bad("the snapshot is cut short or damaged"))?;
        state.complete(&self.state);
        if !rest.is_empty() || !state.fits(&self.state) {
            return Err(bad("the snapshot is damaged"));
        }
        self.state = state;
        self.replaced();
        Ok(())
    }

    /// Goes back to time 0, inputs at zero.
    pub fn reset(&mut self) {
        if let Ok((_, state)) = Model::new(&self.scene) {
            self.state = state;
            self.state.pace = initial_pace(&self.model, &self.state);
            self.solver.restart(&self.model, &mut self.state);
        }
        self.replaced();
        // puts the particles in the order they had when the simulation was made; it could be measured then, so it can now
        self.outputs.measures = self.solver.measure(&self.model, &mut self.state).ok();
    }

    /// What this simulation is: its method, what it needs and skips, its variables.
    pub fn describe(&self) -> Description {
        let model = &self.model;
        let step = match model.pace {
            Pace::Fixed(step) => format!("{step} s, fixed"),
            Pace::Cfl(share) => format!("{share} of the stable step"),
            Pace::Error { allowed, longest } => format!("up to {longest} s, by an error of {allowed} m a step"),
        };
        let mut method = vec![
            ("formulation", if model.total { "total Lagrangian" } else { "updated Lagrangian" }.into()),
            ("basis", words::basis(&self.scene)),
            ("quadrature", words::quadrature(&self.scene.method)),
            ("mass", words::mass(model)),
            ("transfer", words::transfer(model)),
            ("integrator", words::integrator(model.integrator).into()),
            ("step", step),
        ];
        if let Some(grids) = self.solver.grids(model) {
            method.insert(1, ("grid", grids));
        }
        let needs = &model.needs;
        let parts = [
            (needs.affine, "affine matrix of each particle (APIC, ASFLIP)"),
            (needs.increment, "nodal acceleration at each particle (FLIP, ASFLIP)"),
            (needs.history > 0, "stress history of each particle"),
            (needs.lateral, "stretch across the plane of each particle"),
            (needs.body_force, "body force that differs from particle to particle"),
            (needs.lookup, "finding particles by id (probes, loads)"),
            (!model.boundaries.is_empty(), "boundaries with reactions"),
            (needs.work, "work of loads and moving boundaries"),
            (matches!(model.pace, Pace::Cfl(_)), "step control by wave and particle speed"),
            (needs.mass_matrix, "mass matrix that is not diagonal"),
            (needs.quadrature, "quadrature points beside the particles"),
            (model.friction.is_some(), "a velocity field for each body, contact"),
        ];
        let list = |wanted: bool| parts.iter().filter(|(n, _)| *n == wanted).map(|(_, text)| (*text).to_owned()).collect();
        let n = self.state.particles.len();
        Description {
            title: self.scene.title.clone(),
            dimension: model.dimension,
            particles: n,
            bodies: model.bodies.iter().map(|b| (b.name.clone(), b.particles.len())).collect(),
            method,
            choices: self.choices.clone(),
            needs: list(true),
            skips: list(false),
            // the state, its copy while a step is under way, and the positions at time 0
            memory: n * (2 * self.state.particles.bytes_each() + 8 * model.dimension) + self.solver.bytes(),
            stable_step: self.stable_step,
            end: self.scene.time.end,
            variables: self.outputs.variables(),
        }
    }

    /// FNV-1a hash of the scene: enough to tell scenes apart, the same on every machine.
    fn fingerprint(&self) -> u64 {
        let text = self.scene.to_json();
        text.bytes().fold(0xcbf2_9ce4_8422_2325, |hash, byte| (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3))
    }
}

/// First bytes of a snapshot; the last is the version of its format.
const SNAPSHOT: [u8; 8] = *b"matpnt\x00\x06";

/// Substeps of at most `step` in `dt`; a step that fits up to round-off fits.
fn substeps_in(dt: f64, step: f64) -> f64 {
    (dt / step * (1.0 - 1e-9)).ceil().max(1.0)
}

/// Ratio of the wave speed to wave plus particle speed at time 0.
fn initial_pace(model: &Model, state: &State) -> f64 {
    let particles = &state.particles;
    if model.total {
        // no particle moves through the grid
        return 1.0;
    }
    (0..particles.len())
        .map(|p| {
            let body = &model.bodies[particles.body[p] as usize];
            let wave = (body.material.lame().wave_modulus() / body.density).sqrt();
            let speed = particles.velocity.row::<3>(p).iter().map(|v| v * v).sum::<f64>().sqrt();
            wave / (wave + speed)
        })
        .fold(1.0, f64::min)
}

/// Loads that are set from outside, by their place among the loads.
fn external_loads(model: &Model) -> impl Iterator<Item = usize> {
    (0..model.loads.len()).filter(|&i| matches!(model.loads[i].signal, Signal::External))
}
