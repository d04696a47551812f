//! How fast particles are stepped, and how far that is from what the machine can do.
//!
//! Every timing is of a fresh process (`stopwatch`), and those that are compared are taken in turns: a machine that changes its speed changes it
//! for all of them. Figures are medians, ratios are medians of the ratios of each round. One part a file; `count` says how many operations and
//! bytes a particle takes, `roofline` draws it.

mod bases;
mod common;
mod cores;
mod count;
mod domain;
mod machine;
mod peers;
mod precision;
mod roofline;
mod scenes;
mod skip;
mod small;
mod stopwatch;
mod threads;
mod total;

pub use roofline::Roofline;
pub use stopwatch::serve;

use super::problem::Effort;
use super::report::{Finding, Report, Section};
use super::runner::Progress;
use count::Count;
use machine::{Limit, Machine};
use std::fmt::Write;
use std::path::{Path, PathBuf};
use stopwatch::{Stopwatch, Task};

/// A part of the study.
struct Part {
    id: &'static str,
    section: fn(&mut Bench) -> Result<Section, String>,
}

/// The parts, in the order in which they are measured and written.
const PARTS: [Part; 13] = [
    Part { id: "machine", section: machine::section },
    Part { id: "common", section: common::small },
    Part { id: "million", section: common::million },
    Part { id: "bases", section: bases::section },
    Part { id: "total", section: total::section },
    Part { id: "small", section: small::section },
    Part { id: "domain", section: domain::section },
    Part { id: "skip", section: skip::section },
    Part { id: "threads", section: threads::section },
    Part { id: "precision", section: precision::section },
    Part { id: "roofline", section: roofline::section },
    Part { id: "cores", section: cores::section },
    Part { id: "peers", section: peers::section },
];

/// Short names of the parts.
pub fn parts() -> impl Iterator<Item = &'static str> {
    PARTS.iter().map(|part| part.id)
}

/// Measures the parts whose short names are in `only` (all where it is empty) and writes of them. `program` is the command `matpoint`, which is
/// started for each timing; `peers` is what `benches/peers/run` wrote, if it is there.
pub fn report(effort: Effort, only: &[String], program: &Path, peers: &Path, progress: &dyn Fn(Progress)) -> Report {
    let wanted: Vec<&Part> = PARTS.iter().filter(|part| only.is_empty() || only.iter().any(|id| id == part.id)).collect();
    let mut bench = Bench::new(effort, program, peers);
    let mut sections = Vec::new();
    for (done, part) in wanted.iter().enumerate() {
        progress(Progress { done, total: wanted.len(), name: part.id.to_owned() });
        let section = (part.section)(&mut bench);
        sections.push(section.unwrap_or_else(|fault| Section {
            title: part.id.to_owned(),
            failures: vec![(part.id.to_owned(), fault)],
            ..Section::default()
        }));
    }
    let (option, extent) = effort.pick((" --quick", "small scenes, few repetitions: too short to judge by"), ("", "everything"));
    Report {
        name: "performance",
        title: "Performance".into(),
        text: format!(
            "Written by `matpoint study throughput{option}` ({extent}). Each timing is of a process of its own; those that are compared were taken \
             in turns. A figure is the median of {} rounds or more, a ratio the median of the ratios of each round. M/s is a million \
             particle-steps a second for whole steps: particles to grid, grid, grid to particles, stress, and what keeps the particles in order. \
             All figures of all rounds are in `performance/measurements.csv`.",
            effort.pick(3, ROUNDS)
        ),
        heads: ["what", "required", "measured"],
        sections,
        data: vec![("measurements.csv", bench.log)],
    }
}

/// Rounds of a race, if nothing else is said.
const ROUNDS: usize = 9;

/// What all parts share.
struct Bench<'a> {
    effort: Effort,
    program: &'a Path,
    peers: &'a Path,
    machine: Option<Machine>,
    /// Points of the roofline: name, what a particle takes, particle-steps a second with one thread at the peak of `machine`.
    points: Vec<(String, Count, f64)>,
    /// Every figure of every round, as CSV.
    log: String,
}

impl<'a> Bench<'a> {
    fn new(effort: Effort, program: &'a Path, peers: &'a Path) -> Self {
        Self { effort, program, peers, machine: None, points: Vec::new(), log: "part,name,round,value\n".to_owned() }
    }

    /// The limits, measured when they are first asked for.
    fn machine(&mut self) -> Result<&Machine, String> {
        let measured = match self.machine.take() {
            Some(measured) => measured,
            None => machine::measure(self)?,
        };
        Ok(self.machine.insert(measured))
    }

    fn rounds(&self) -> usize {
        self.effort.pick(3, ROUNDS)
    }

    /// Times all entries in turns. An entry that fails is left out, and told.
    fn race(&mut self, part: &str, entries: &[Entry], rounds: usize) -> Result<Race, String> {
        let mut race = Race::default();
        let mut running = Vec::new();
        for entry in entries {
            match entry.start(self.program) {
                Ok(gauge) => running.push((entry.name.clone(), gauge, Vec::new())),
                Err(fault) => race.faults.push((entry.name.clone(), fault)),
            }
        }
        // the first round warms caches and sorts particles that were shuffled: it does not count
        for round in 0..=rounds {
            for (name, gauge, figures) in &mut running {
                let figure = gauge().map_err(|fault| format!("{name}: {fault}"))?;
                if round > 0 {
                    figures.push(figure);
                    // writing to a String cannot fail
                    let _ = writeln!(self.log, "{part},\"{name}\",{round},{figure:e}");
                }
            }
        }
        race.figures = running.into_iter().map(|(name, _, figures)| (name, figures)).collect();
        Ok(race)
    }

    /// The same for what may differ by hundredths, which is also what the place of a process in memory does to its times: all processes are
    /// started anew so many times.
    fn race_anew(&mut self, part: &str, entries: &[Entry], starts: usize, rounds: usize) -> Result<Race, String> {
        let mut all = self.race(part, entries, rounds)?;
        for _ in 1..starts {
            let race = self.race(part, entries, rounds)?;
            if !race.faults.is_empty() {
                return Ok(race);
            }
            all.figures.iter_mut().zip(race.figures).for_each(|(all, race)| all.1.extend(race.1));
        }
        Ok(all)
    }

    /// A requirement, judged where enough was measured.
    fn judge(&self, what: &str, claim: &str, look: impl FnOnce() -> Option<(String, bool)>) -> Vec<Finding> {
        if self.effort == Effort::Quick { Vec::new() } else { vec![Finding::judge(what, claim, true, look)] }
    }
}

/// A figure a round, the more the better: of a process that steps, or of the machine.
type Gauge = Box<dyn FnMut() -> Result<f64, String>>;

/// What takes part in a race.
struct Entry {
    name: String,
    kind: Kind,
}

enum Kind {
    /// Particle-steps a second.
    Steps { task: Task, threads: usize, instructions: Option<&'static str>, calls: u64, substeps: u64 },
    /// Operations or bytes a second.
    Limit { limit: Limit, threads: usize },
}

impl Entry {
    /// A scene with one thread: in each round a call of `step` with so many substeps.
    fn scene(name: impl Into<String>, scene: String, substeps: u64) -> Self {
        let kind = Kind::Steps { task: Task::new(scene), threads: 1, instructions: None, calls: 1, substeps };
        Self { name: name.into(), kind }
    }

    fn limit(limit: Limit, threads: usize) -> Self {
        Self { name: limit.name(threads), kind: Kind::Limit { limit, threads } }
    }

    /// The fastest multiply-adds in double precision, with one thread.
    fn peak() -> Self {
        Self::limit(Limit::fastest(), 1)
    }

    fn threads(mut self, count: usize) -> Self {
        if let Kind::Steps { threads, .. } = &mut self.kind {
            *threads = count;
        }
        self
    }

    fn instructions(mut self, set: &'static str) -> Self {
        if let Kind::Steps { instructions, .. } = &mut self.kind {
            *instructions = Some(set);
        }
        self
    }

    /// So many calls in a round.
    fn calls(mut self, count: u64) -> Self {
        if let Kind::Steps { calls, .. } = &mut self.kind {
            *calls = count;
        }
        self
    }

    /// Does something else beside.
    fn with(mut self, change: impl FnOnce(&mut Task)) -> Self {
        if let Kind::Steps { task, .. } = &mut self.kind {
            change(task);
        }
        self
    }

    fn start(&self, program: &Path) -> Result<Gauge, String> {
        match &self.kind {
            Kind::Steps { task, threads, instructions, calls, substeps } => {
                let mut watch = Stopwatch::start(program, task, *threads, *instructions)?;
                let (calls, substeps) = (*calls, *substeps);
                let steps = (watch.particles as u64 * calls * substeps) as f64;
                Ok(Box::new(move || Ok(steps / watch.step(calls, substeps)?)))
            }
            Kind::Limit { limit, threads } => {
                let mut gauge = limit.gauge(*threads);
                Ok(Box::new(move || Ok(gauge())))
            }
        }
    }
}

/// Figures of a race, a number a round.
#[derive(Default)]
struct Race {
    figures: Vec<(String, Vec<f64>)>,
    /// Who could not start, and why.
    faults: Vec<(String, String)>,
}

impl Race {
    fn of(&self, name: &str) -> Option<&[f64]> {
        self.figures.iter().find(|f| f.0 == name).map(|f| f.1.as_slice())
    }

    fn median(&self, name: &str) -> Option<f64> {
        self.of(name).map(|figures| median(figures.to_vec()))
    }

    /// The rate that the share of the multiply-adds of its rounds would have been at another `peak` \[flop/s\].
    fn at_peak(&self, name: &str, peak: f64) -> Option<f64> {
        Some(peak * self.ratio(name, &Limit::fastest().name(1))?)
    }

    /// How many times faster the first is than the second.
    fn ratio(&self, first: &str, second: &str) -> Option<f64> {
        Some(median(self.of(first)?.iter().zip(self.of(second)?).map(|(a, b)| a / b).collect()))
    }
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    let n = values.len();
    if n == 0 { f64::NAN } else { 0.5 * (values[(n - 1) / 2] + values[n / 2]) }
}

/// Three digits: more than a timing has.
fn three(value: f64) -> f64 {
    format!("{value:.2e}").parse().unwrap_or(value)
}

/// Three decimals, for ratios near 1.
fn thousandths(ratio: f64) -> f64 {
    (1e3 * ratio).round() / 1e3
}

/// A rate in M/s, three digits.
fn million(rate: f64) -> f64 {
    three(1e-6 * rate)
}

/// A folder for what is written while it is timed; it is removed with all in it.
struct Scratch(PathBuf);

impl Scratch {
    fn new() -> Result<Self, String> {
        let path = std::env::temp_dir().join(format!("matpoint-throughput-{}", std::process::id()));
        std::fs::create_dir_all(&path).map_err(|e| format!("{}: {e}", path.display()))?;
        Ok(Self(path))
    }
}

impl Drop for Scratch {
    fn drop(&mut self) {
        // nothing to be done about a folder that cannot be removed
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ratios_are_those_of_rounds() {
        let figures = vec![("a".to_owned(), vec![2.0, 20.0, 6.0]), ("b".to_owned(), vec![1.0, 10.0, 2.0])];
        let race = Race { figures, faults: Vec::new() };
        assert_eq!((race.ratio("a", "b"), race.median("a"), race.median("c")), (Some(2.0), Some(6.0), None));
        assert_eq!([three(1234.5), million(20.456e6), median(vec![1.0, 4.0])], [1230.0, 20.5, 2.5]);
    }
}
