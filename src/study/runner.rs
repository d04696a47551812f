//! Runs many scenes and keeps what was asked for.

use crate::Simulation;
use crate::component::ComponentError;
use crate::scene::Scene;
use crate::step::Wrong;
use indexmap::IndexMap;
use rayon::prelude::*;
use std::sync::Mutex;
use std::time::Instant;

/// Reads a simulation.
type Read<T> = Box<dyn Fn(&mut Simulation) -> Result<T, ComponentError> + Send + Sync>;

/// A scene to be run from time 0 to its end, and what is kept of it.
pub struct Job {
    name: String,
    scene: String,
    every: Option<f64>,
    watches: Vec<(String, Read<f64>)>,
    snapshots: Vec<(f64, String, Read<Vec<f64>>)>,
    alone: bool,
    wrong: Option<Wrong>,
}

impl Job {
    /// The scene is TOML; the name must differ from those of all other jobs.
    pub fn new(name: impl Into<String>, scene: impl Into<String>) -> Self {
        Self { name: name.into(), scene: scene.into(), every: None, watches: Vec::new(), snapshots: Vec::new(), alone: false, wrong: None }
    }

    /// Time between samples \[s\]; the first is taken at time 0. A whole number of steps, where the step is fixed: a step is shortened
    /// to land on a sample. Without it nothing is sampled.
    pub fn every(mut self, interval: f64) -> Self {
        self.every = Some(interval);
        self
    }

    /// Samples a number over time; see [`value`] for one that is a variable.
    pub fn watch(
        mut self,
        name: impl Into<String>,
        watch: impl Fn(&mut Simulation) -> Result<f64, ComponentError> + Send + Sync + 'static,
    ) -> Self {
        self.watches.push((name.into(), Box::new(watch)));
        self
    }

    /// Keeps whole variables at a time \[s\].
    pub fn snapshot<'a>(self, time: f64, variables: impl IntoIterator<Item = &'a str>) -> Self {
        variables.into_iter().fold(self, |job, name| {
            let variable = name.to_owned();
            job.keep(time, name, move |sim| Ok(sim.get(&variable)?.to_vec()))
        })
    }

    /// Keeps numbers at a time \[s\] that are no variable, under a name.
    pub fn keep(
        mut self,
        time: f64,
        name: impl Into<String>,
        read: impl Fn(&mut Simulation) -> Result<Vec<f64>, ComponentError> + Send + Sync + 'static,
    ) -> Self {
        self.snapshots.push((time, name.into(), Box::new(read)));
        self
    }

    /// Its wall time is a result: it runs at the end, with nothing beside it.
    pub fn alone(mut self) -> Self {
        self.alone = true;
        self
    }

    /// Is run in a way that a paper warns of.
    pub(crate) fn wrong(mut self, wrong: Wrong) -> Self {
        self.wrong = Some(wrong);
        self
    }

    /// The name.
    pub fn name(&self) -> &str {
        &self.name
    }
}

/// Component `index` of a variable, for [`Job::watch`].
pub fn value(variable: impl Into<String>, index: usize) -> impl Fn(&mut Simulation) -> Result<f64, ComponentError> + Send + Sync + 'static {
    let variable = variable.into();
    move |sim| Ok(sim.get(&variable)?.get(index).copied().unwrap_or(f64::NAN))
}

/// How a run ended.
#[derive(Debug, Clone, PartialEq)]
pub enum End {
    /// At the end of its scene.
    Done,
    /// A step failed; what was sampled until then is kept.
    Failed(String),
    /// The scene has a fault: nothing was run.
    Refused(String),
}

/// What is left of a job.
#[derive(Debug, Clone)]
pub struct Run {
    /// Name of the job.
    pub name: String,
    /// How it ended.
    pub end: End,
    /// Times of the samples \[s\].
    pub times: Vec<f64>,
    samples: IndexMap<String, Vec<f64>>,
    snapshots: Vec<Snapshot>,
    /// Wall time of all steps \[s\], without sampling.
    pub wall: f64,
    /// Substeps taken.
    pub substeps: u64,
    /// Iterations of Newton's method, or of the solver of the mass matrix.
    pub iterations: u64,
}

#[derive(Debug, Clone)]
struct Snapshot {
    time: f64,
    name: String,
    values: Vec<f64>,
}

impl Run {
    /// What was watched under `name`, a number for each of [`Run::times`]; empty where nothing was.
    pub fn samples(&self, name: &str) -> &[f64] {
        self.samples.get(name).map_or(&[], Vec::as_slice)
    }

    /// Points (time, sample) of a curve.
    pub fn curve(&self, name: &str) -> Vec<[f64; 2]> {
        self.times.iter().zip(self.samples(name)).map(|(&t, &v)| [t, v]).collect()
    }

    /// What was kept under a name at a time \[s\]; `None` where the run was not asked for it or did not get there.
    pub fn at(&self, time: f64, name: &str) -> Option<&[f64]> {
        let now = |s: &&Snapshot| (s.time - time).abs() <= 1e-9 * time.abs().max(1e-9) && s.name == name;
        self.snapshots.iter().find(now).map(|s| s.values.as_slice())
    }

    /// A run that nobody made, for tests of what is written of runs.
    #[cfg(test)]
    pub(crate) fn of_numbers(name: String, wall: f64, time: f64, kept: &str, values: Vec<f64>) -> Self {
        let snapshots = vec![Snapshot { time, name: kept.to_owned(), values }];
        Self { name, end: End::Done, times: Vec::new(), samples: IndexMap::new(), snapshots, wall, substeps: 1, iterations: 0 }
    }

    /// Whether it reached the end of its scene.
    pub fn is_done(&self) -> bool {
        self.end == End::Done
    }
}

/// All runs, by the names of their jobs.
#[derive(Debug, Clone, Default)]
pub struct Runs {
    runs: IndexMap<String, Run>,
}

impl Runs {
    /// A run that took at least one step or was ready to; `None` for a name without a job and for a scene that was refused.
    pub fn get(&self, name: &str) -> Option<&Run> {
        self.runs.get(name).filter(|run| !matches!(run.end, End::Refused(_)))
    }

    /// A run that reached its end.
    pub fn done(&self, name: &str) -> Option<&Run> {
        self.get(name).filter(|run| run.is_done())
    }

    /// All of them, in the order of the jobs.
    pub fn iter(&self) -> impl Iterator<Item = &Run> {
        self.runs.values()
    }
}

impl FromIterator<Run> for Runs {
    fn from_iter<T: IntoIterator<Item = Run>>(runs: T) -> Self {
        Self { runs: runs.into_iter().map(|run| (run.name.clone(), run)).collect() }
    }
}

/// Where a study is, for a progress bar.
#[derive(Debug, Clone, PartialEq)]
pub struct Progress {
    /// Jobs that have ended.
    pub done: usize,
    /// All jobs.
    pub total: usize,
    /// The job that has just ended or begun.
    pub name: String,
}

/// Runs all jobs: side by side, then one by one those whose wall time counts. A job that fails is a result like any other.
pub fn run(jobs: Vec<Job>, progress: impl Fn(Progress) + Sync) -> Runs {
    let total = jobs.len();
    let done = Mutex::new(0);
    let tell = |name: &str, ended: usize| {
        if let Ok(mut done) = done.lock() {
            *done += ended;
            progress(Progress { done: *done, total, name: name.to_owned() });
        }
    };
    let work = |job: &Job| {
        tell(&job.name, 0);
        let run = run_one(job);
        tell(&job.name, 1);
        run
    };
    let mut runs: Vec<Option<Run>> = jobs.par_iter().with_max_len(1).map(|job| (!job.alone).then(|| work(job))).collect();
    for (run, job) in runs.iter_mut().zip(&jobs).filter(|(_, job)| job.alone) {
        *run = Some(work(job));
    }
    runs.into_iter().flatten().collect()
}

fn run_one(job: &Job) -> Run {
    let mut run = Run {
        name: job.name.clone(),
        end: End::Done,
        times: Vec::new(),
        samples: job.watches.iter().map(|(name, _)| (name.clone(), Vec::new())).collect(),
        snapshots: Vec::new(),
        wall: 0.0,
        substeps: 0,
        iterations: 0,
    };
    let mut sim = match Scene::from_toml(&job.scene).and_then(Scene::build) {
        Ok(sim) => sim,
        Err(error) => {
            run.end = End::Refused(error.to_string());
            return run;
        }
    };
    if let Some(wrong) = job.wrong {
        sim.go_wrong(wrong);
    }
    if let Err(message) = follow(job, &mut sim, &mut run) {
        run.end = End::Failed(message);
    }
    run
}

/// Steps from stop to stop, in the order of time.
fn follow(job: &Job, sim: &mut Simulation, run: &mut Run) -> Result<(), String> {
    let end = sim.scene().time.end;
    let samples: Vec<f64> = job.every.map_or(Vec::new(), |every| {
        let last = (end / every * (1.0 + 1e-9)).floor() as usize;
        (0..=last).map(|k| (k as f64 * every).min(end)).collect()
    });
    let mut stops: Vec<f64> = samples.iter().copied().chain(job.snapshots.iter().map(|s| s.0)).chain([end]).collect();
    stops.sort_by(f64::total_cmp);
    let slack = 1e-9 * end;
    stops.dedup_by(|a, b| (*a - *b).abs() <= slack);
    let mut samples = samples.into_iter().peekable();
    for stop in stops {
        if stop > sim.time() + slack {
            let start = Instant::now();
            let report = sim.step(stop - sim.time()).map_err(|e| e.to_string())?;
            run.wall += start.elapsed().as_secs_f64();
            run.substeps += report.substeps;
            run.iterations += report.iterations;
        }
        if samples.next_if(|time| (time - stop).abs() <= slack).is_some() {
            run.times.push(sim.time());
            for (name, watch) in &job.watches {
                let sample = watch(sim).map_err(|e| e.to_string())?;
                run.samples.entry(name.clone()).or_default().push(sample);
            }
        }
        for (time, name, read) in job.snapshots.iter().filter(|s| (s.0 - stop).abs() <= slack) {
            let values = read(sim).map_err(|e| e.to_string())?;
            run.snapshots.push(Snapshot { time: *time, name: name.clone(), values });
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn scene(speed: f64, extra: &str) -> String {
        format!(
            r#"
            title = "a block that drifts"
            dimension = 1
            grid = {{ origin = [0], size = [4], cell = 0.5 }}
            material.soft = {{ law = "neo_hookean", young = 1e3, density = 1e3 }}
            body.block = {{ material = "soft", shape = {{ box = {{ min = [1], max = [2] }} }}, velocity = [{speed}] }}
            probe.first = {{ at = [1.125] }}
            time = {{ end = 1 }}
            {extra}
            "#
        )
    }

    #[test]
    fn keeps_samples_and_snapshots_of_good_runs_and_messages_of_bad_ones() {
        let job = |name: &str, text: String| Job::new(name, text).every(0.25).watch("x", value("probe/first/position", 0));
        let jobs = vec![
            job("drifts", scene(1.0, "")).snapshot(0.6, ["particle/velocity"]),
            job("leaves", scene(4.0, "")).alone(),
            job("makes no sense", scene(1.0, "wrong = 1")),
        ];
        let runs = run(jobs, |_| {});
        let drifts = runs.done("drifts").unwrap();
        assert_eq!(drifts.times.len(), 5);
        assert!((drifts.samples("x")[4] - 2.125).abs() < 1e-9);
        assert!(drifts.at(0.6, "particle/velocity").unwrap().iter().all(|v| (v - 1.0).abs() < 1e-9));
        assert!(drifts.at(0.5, "particle/velocity").is_none() && drifts.substeps > 0);
        let leaves = runs.get("leaves").unwrap();
        assert!(matches!(&leaves.end, End::Failed(message) if message.contains("left the grid")) && leaves.times.len() < 5);
        assert!(runs.get("makes no sense").is_none() && runs.iter().count() == 3);
    }
}
