//! The driver: from record time to record time until the end.

use super::{Level, RecordError, Recorder, Sink};
use crate::Simulation;
use crate::component::{Report, StepError};

/// What a run did.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Summary {
    /// Time at the start \[s\].
    pub start: f64,
    /// Time reached \[s\].
    pub end: f64,
    /// Substeps taken.
    pub substeps: u64,
    /// Iterations of the solver of the mass matrix; 0 with lumped mass.
    pub iterations: u64,
    /// Smallest substep \[s\]; infinite where none was taken.
    pub smallest_step: f64,
}

impl Summary {
    /// Of a run that starts at `start` \[s\].
    pub fn new(start: f64) -> Self {
        Self { start, end: start, substeps: 0, iterations: 0, smallest_step: f64::INFINITY }
    }

    /// Counts a step in.
    pub fn add(&mut self, report: &Report) {
        self.end = report.time;
        self.substeps += report.substeps;
        self.iterations += report.iterations;
        self.smallest_step = self.smallest_step.min(report.smallest_step);
    }
}

/// Where a run is, for a progress bar.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Progress {
    /// Time reached \[s\].
    pub time: f64,
    /// Time at the end of the run \[s\].
    pub until: f64,
    /// Substeps taken so far.
    pub substeps: u64,
}

/// A run that did not reach its end. Every sink was finished: what was recorded before is whole.
#[derive(Debug, thiserror::Error)]
pub enum RunError {
    /// A sink could not be opened; no step was taken.
    #[error(transparent)]
    Begin(RecordError),
    /// A step failed; the simulation is where it was before it.
    #[error(transparent)]
    Step(#[from] StepError),
    /// A sink failed during the run.
    #[error(transparent)]
    Record(RecordError),
}

/// Steps `sim` from where it is to the time `until` \[s\] and offers frames and rows to `sinks` on the way, at the whole multiples
/// of `record.every` (or `every_steps`) and `record.history` of its scene, at the start and at the end. `progress` is called at the start and after every
/// stop.
///
/// # Errors
/// A sink that cannot be opened or written, a step that cannot be done.
pub fn run(sim: &mut Simulation, until: f64, sinks: &mut [&mut dyn Sink], progress: &mut dyn FnMut(Progress)) -> Result<Summary, RunError> {
    let sinks: Vec<Box<dyn Sink + '_>> = sinks.iter_mut().map(|sink| Box::new(&mut **sink) as Box<dyn Sink + '_>).collect();
    let mut recorder = Recorder::begin(sim, sinks, None, None).map_err(RunError::Begin)?;
    let mut summary = Summary::new(sim.time());
    let outcome = step_and_record(sim, until, &mut recorder, progress, &mut summary);
    if let Err(RunError::Step(error)) = &outcome {
        // The step is what failed; a sink that fails as well says so below.
        let _ = recorder.event(sim, Level::Error, &error.to_string());
    }
    // After a failure too: what was recorded so far stays valid. The first error is the one worth telling.
    let finished = recorder.finish(sim);
    outcome?;
    finished.map_err(RunError::Record)?;
    Ok(summary)
}

fn step_and_record(
    sim: &mut Simulation,
    until: f64,
    recorder: &mut Recorder<'_>,
    progress: &mut dyn FnMut(Progress),
    summary: &mut Summary,
) -> Result<(), RunError> {
    let start = sim.steps();
    loop {
        progress(Progress { time: sim.time(), until, substeps: sim.steps() - start });
        if sim.time() >= until {
            return Ok(());
        }
        // From where the simulation is, not from the last stop: round-off does not add up.
        let report = sim.step(recorder.next(sim, until) - sim.time())?;
        summary.add(&report);
        recorder.offer(sim).map_err(RunError::Record)?;
    }
}
