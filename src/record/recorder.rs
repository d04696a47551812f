//! Sinks together with the times at which they are due.

use super::{Level, RecordError, Sink};
use crate::Simulation;
use std::path::PathBuf;

/// Records a simulation that somebody steps: offer it after each step, and the sinks get what is due.
///
/// Frames and rows are due at the whole multiples of their periods (seconds, or substeps), at the start and at the end. A step that leaps over
/// several multiples is recorded once.
pub struct Recorder<'s> {
    sinks: Vec<Box<dyn Sink + 's>>,
    frames: Cadence,
    rows: Cadence,
    /// Time of the last frame and row \[s\].
    last: [f64; 2],
}

impl<'s> Recorder<'s> {
    /// Opens the sinks and records the state as it is. Periods in simulated seconds; those of the scene where none are given.
    ///
    /// # Errors
    /// A sink that cannot be opened or written; no sink is finished then.
    pub fn begin(
        sim: &mut Simulation,
        sinks: Vec<Box<dyn Sink + 's>>,
        every: Option<f64>,
        history: Option<f64>,
    ) -> Result<Self, RecordError> {
        let record = &sim.scene().record;
        let period = |every: f64| Cadence::Time(Ticks::after(sim.time(), every));
        let frames = match (every.or(record.every), record.every_steps) {
            (Some(every), _) => period(every),
            (None, Some(count)) => Cadence::Steps { count, index: sim.steps() / count + 1 },
            // what nobody asked for does not shorten steps
            (None, None) => period((0.01 * sim.scene().time.end).max(sim.scene().time.step.unwrap_or(0.0))),
        };
        let rows = history.or(every).or(record.history).map_or(frames, period);
        let mut recorder = Self { sinks, frames, rows, last: [f64::NAN; 2] };
        recorder.sinks.iter_mut().try_for_each(|sink| sink.begin(sim))?;
        recorder.record(sim, true, true)?;
        Ok(recorder)
    }

    /// Next time at which something is due, `until` at the latest \[s\]. What is due a billionth of a period before `until` waits for it. Where
    /// substeps are counted, it is the time at which so many will have been taken if none gets shorter.
    pub fn next(&self, sim: &Simulation, until: f64) -> f64 {
        sooner([self.frames, self.rows].map(|cadence| cadence.next(sim.time(), sim.steps(), sim.usual_step())), until)
    }

    /// Records what is due at the time of `sim`.
    ///
    /// # Errors
    /// A sink that cannot be written.
    pub fn offer(&mut self, sim: &mut Simulation) -> Result<(), RecordError> {
        let (frame, row) = (self.frames.passed(sim.time(), sim.steps()), self.rows.passed(sim.time(), sim.steps()));
        self.record(sim, frame, row)
    }

    /// Tells those who will look at the recordings what happened.
    ///
    /// # Errors
    /// A sink that cannot be written.
    pub fn event(&mut self, sim: &Simulation, level: Level, text: &str) -> Result<(), RecordError> {
        self.sinks.iter_mut().try_for_each(|sink| sink.event(sim, level, text))
    }

    /// Frames and rows that were not recorded because the recordings could not keep up.
    pub fn dropped(&self) -> u64 {
        self.sinks.iter().map(|sink| sink.dropped()).sum()
    }

    /// Records the last state, unless it is recorded, and closes the sinks. Gives the files that are complete.
    ///
    /// # Errors
    /// The first sink that cannot be written or closed; all are closed all the same.
    pub fn finish(mut self, sim: &mut Simulation) -> Result<Vec<PathBuf>, RecordError> {
        let [frame, row] = self.last.map(|last| last != sim.time());
        let recorded = self.record(sim, frame, row);
        let closed = self.close(sim);
        recorded.and(closed).map(|()| self.sinks.iter().flat_map(|sink| sink.files()).collect())
    }

    fn record(&mut self, sim: &mut Simulation, frame: bool, row: bool) -> Result<(), RecordError> {
        let step = sim.steps();
        if row {
            self.sinks.iter_mut().try_for_each(|sink| sink.history(sim, step))?;
            self.last[1] = sim.time();
        }
        if frame {
            self.sinks.iter_mut().try_for_each(|sink| sink.frame(sim, step))?;
            self.last[0] = sim.time();
        }
        Ok(())
    }

    fn close(&mut self, sim: &mut Simulation) -> Result<(), RecordError> {
        // all of them, whatever becomes of the others
        self.sinks.iter_mut().map(|sink| sink.finish(sim)).fold(Ok(()), Result::and)
    }
}

/// The first of two times, given with their periods, unless `until` comes first.
fn sooner([(first, period), (second, other)]: [(f64, f64); 2], until: f64) -> f64 {
    let next = first.min(second);
    if next < until - 1e-9 * period.min(other) { next } else { until }
}

/// When something is due.
#[derive(Debug, Clone, Copy)]
enum Cadence {
    Time(Ticks),
    /// Each `count` substeps; `index` multiples of it will have been taken at the next.
    Steps {
        count: u64,
        index: u64,
    },
}

impl Cadence {
    /// The next time and the time between two, seen from time and substeps of now with substeps of `step` to come.
    fn next(self, time: f64, steps: u64, step: f64) -> (f64, f64) {
        match self {
            Self::Time(ticks) => (ticks.time(), ticks.period),
            Self::Steps { count, index } => (time + (index * count).saturating_sub(steps).max(1) as f64 * step, count as f64 * step),
        }
    }

    /// Whether one is due, now that it is `time` and `steps` substeps were taken; counts on, also where a restored simulation goes back.
    fn passed(&mut self, time: f64, steps: u64) -> bool {
        match self {
            Self::Time(ticks) => ticks.passed(time),
            Self::Steps { count, index } => {
                let next = steps / *count + 1;
                std::mem::replace(index, next) != next
            }
        }
    }
}

/// Whole multiples of a period.
#[derive(Debug, Clone, Copy)]
pub(super) struct Ticks {
    period: f64,
    /// The next one.
    index: u64,
}

impl Ticks {
    /// The first multiple after `start` is next.
    pub(super) fn after(start: f64, period: f64) -> Self {
        Self { period, index: Self::first_after(start, period) }
    }

    /// Times nearer than a billionth of a period are the same time, written with different round-off: 3 * 0.1 and 0.3.
    fn first_after(time: f64, period: f64) -> u64 {
        (time / period + 1e-9).floor() as u64 + 1
    }

    fn time(&self) -> f64 {
        self.index as f64 * self.period
    }

    /// Whether `time` has passed a multiple since the last call, in either direction: a restored simulation goes back.
    pub(super) fn passed(&mut self, time: f64) -> bool {
        let next = Self::first_after(time, self.period);
        std::mem::replace(&mut self.index, next) != next
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Stops of a run: time, frame, row.
    fn stops(start: f64, until: f64, every: f64, history: f64) -> Vec<(f64, bool, bool)> {
        let [mut frames, mut rows] = [every, history].map(|period| Cadence::Time(Ticks::after(start, period)));
        let mut stops = Vec::new();
        let mut time = start;
        while time < until {
            time = sooner([frames, rows].map(|cadence| cadence.next(time, 0, 1.0)), until);
            stops.push((time, frames.passed(time, 0), rows.passed(time, 0)));
        }
        stops
    }

    #[test]
    fn multiples_of_both_periods_and_the_end() {
        let expected = [(0.25, false, true), (0.5, true, true), (0.75, false, true), (1.0, true, true), (1.1, false, false)];
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
        assert_eq!(stops(0.3, 0.45, 0.1, 0.1), [(0.4, true, true), (0.45, false, false)]);
        assert_eq!(stops(1.0, 1.0, 0.1, 0.1), []);
    }

    #[test]
    fn substeps_are_counted_too() {
        let mut every_ten = Cadence::Steps { count: 10, index: 1 };
        // 7 were taken, 3 are left.
        assert_eq!(every_ten.next(0.7, 7, 0.1).0, 0.7 + 3.0 * 0.1);
        assert!(!every_ten.passed(0.9, 9) && every_ten.passed(1.1, 11) && !every_ten.passed(1.9, 19) && every_ten.passed(4.0, 40));
        assert_eq!(every_ten.next(4.0, 40, 0.1).0, 4.0 + 10.0 * 0.1);
    }

    #[test]
    fn leaps_count_once_and_so_does_going_back() {
        let mut ticks = Ticks::after(0.0, 0.1);
        assert!(ticks.passed(0.55) && !ticks.passed(0.59) && ticks.passed(0.6));
        assert!(ticks.passed(0.2) && !ticks.passed(0.25) && ticks.passed(0.3));
    }
}
