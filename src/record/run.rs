//! The driver: from record time to record time until the end.

use super::{RecordError, Sink};
use crate::Simulation;
use crate::component::StepError;

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
    /// Particle frames offered to the sinks, the first one included.
    pub frames: u64,
    /// Rows of energies and probes offered to the sinks, the first one included.
    pub rows: u64,
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
/// of `record.every` and `record.history` of its scene, at the start and at the end. `progress` is called after every stop.
pub fn run(sim: &mut Simulation, until: f64, sinks: &mut [&mut dyn Sink], progress: &mut dyn FnMut(Progress)) -> Result<Summary, RunError> {
    for sink in sinks.iter_mut() {
        sink.begin(sim).map_err(RunError::Begin)?;
    }
    let mut summary =
        Summary { start: sim.time(), end: sim.time(), substeps: 0, iterations: 0, smallest_step: f64::INFINITY, frames: 0, rows: 0 };
    let outcome = step_and_record(sim, until, sinks, progress, &mut summary);
    // After a failure too: what was recorded so far stays valid. The first error is the one worth telling.
    let mut finished = Ok(());
    for sink in sinks.iter_mut() {
        finished = finished.and(sink.finish(sim));
    }
    outcome?;
    finished.map_err(RunError::Record)?;
    Ok(summary)
}

fn step_and_record(
    sim: &mut Simulation,
    until: f64,
    sinks: &mut [&mut dyn Sink],
    progress: &mut dyn FnMut(Progress),
    summary: &mut Summary,
) -> Result<(), RunError> {
    let record = &sim.scene().record;
    let every = record.every.unwrap_or(sim.scene().time.end / 100.0);
    let mut stops = Stops::new(sim.time(), until, every, record.history.unwrap_or(every));
    let mut stop = Stop { time: sim.time(), frame: true, row: true };
    loop {
        for sink in sinks.iter_mut() {
            if stop.row {
                sink.history(sim, summary.substeps).map_err(RunError::Record)?;
            }
            if stop.frame {
                sink.frame(sim, summary.substeps).map_err(RunError::Record)?;
            }
        }
        summary.rows += u64::from(stop.row);
        summary.frames += u64::from(stop.frame);
        progress(Progress { time: sim.time(), until, substeps: summary.substeps });
        let Some(next) = stops.next() else { return Ok(()) };
        // From where the simulation is, not from the last stop: round-off does not add up.
        let report = sim.step(next.time - sim.time())?;
        summary.end = report.time;
        summary.substeps += report.substeps;
        summary.iterations += report.iterations;
        summary.smallest_step = summary.smallest_step.min(report.smallest_step);
        stop = next;
    }
}

/// A time at which something is recorded.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Stop {
    time: f64,
    frame: bool,
    row: bool,
}

/// The record times after the start, in order: whole multiples of two periods, then the end.
struct Stops {
    frames: Ticks,
    rows: Ticks,
    until: f64,
    done: bool,
}

impl Stops {
    fn new(start: f64, until: f64, every: f64, history: f64) -> Self {
        Self { frames: Ticks::after(start, every), rows: Ticks::after(start, history), until, done: until <= start }
    }
}

impl Iterator for Stops {
    type Item = Stop;

    fn next(&mut self) -> Option<Stop> {
        if self.done {
            return None;
        }
        // Times nearer than this are the same time, written with different round-off: 3 * 0.1 and 0.3.
        let same = 1e-9 * self.frames.period.min(self.rows.period);
        let time = self.frames.time().min(self.rows.time());
        if time >= self.until - same {
            self.done = true;
            return Some(Stop { time: self.until, frame: true, row: true });
        }
        let stop = Stop { time, frame: self.frames.time() <= time + same, row: self.rows.time() <= time + same };
        self.frames.index += u64::from(stop.frame);
        self.rows.index += u64::from(stop.row);
        Some(stop)
    }
}

/// Whole multiples of a period.
struct Ticks {
    period: f64,
    index: u64,
}

impl Ticks {
    /// The first multiple after `start` is next.
    fn after(start: f64, period: f64) -> Self {
        Self { period, index: (start / period + 1e-9).floor() as u64 + 1 }
    }
    fn time(&self) -> f64 {
        self.index as f64 * self.period
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn stops(start: f64, until: f64, every: f64, history: f64) -> Vec<(f64, bool, bool)> {
        Stops::new(start, until, every, history).map(|s| (s.time, s.frame, s.row)).collect()
    }

    #[test]
    fn multiples_of_both_periods_and_the_end() {
        let expected = [(0.25, false, true), (0.5, true, true), (0.75, false, true), (1.0, true, true), (1.1, true, true)];
        assert_eq!(stops(0.0, 1.1, 0.5, 0.25), expected);
    }

    #[test]
    fn round_off_makes_no_stop_of_its_own() {
        // 3 * 0.1 is not 0.3 in binary, and 30 * 0.1 is not 3.
        let all = stops(0.0, 3.0, 0.1, 0.3);
        assert_eq!(all.len(), 30);
        assert_eq!(all.iter().filter(|s| s.2).count(), 10);
        assert_eq!(all.last(), Some(&(3.0, true, true)));
    }

    #[test]
    fn goes_on_from_any_time_and_stops_at_once_when_there() {
        assert_eq!(stops(0.3, 0.45, 0.1, 0.1), [(0.4, true, true), (0.45, true, true)]);
        assert_eq!(stops(1.0, 1.0, 0.1, 0.1), []);
    }
}
