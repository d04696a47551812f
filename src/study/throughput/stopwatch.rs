//! A process that holds one simulation and steps it when it is told to: what is timed has the number of threads and the instructions that its
//! environment says, and shares nothing with what is timed beside it. Orders go in and answers come out as lines of JSON.

use crate::Simulation;
use crate::record::{Options, Recorder, sink_for};
use crate::scene::{Scene, SceneError};
use serde::{Deserialize, Serialize};
use std::hint::black_box;
use std::io::{BufRead, BufReader, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};
use std::time::Instant;

/// A scene with a fixed step, and what is done in each call beside stepping it.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
pub(super) struct Task {
    /// The scene (TOML).
    pub(super) scene: String,
    /// Whether the particles lie in memory in no order at the start.
    pub(super) shuffled: bool,
    /// An input that is set before each call, and its values.
    pub(super) set: Option<(String, Vec<f64>)>,
    /// Variables that are read after each call.
    pub(super) get: Vec<String>,
    /// A recording that is offered each state, and the simulated time between its frames \[s\].
    pub(super) record: Option<(PathBuf, f64)>,
}

impl Task {
    pub(super) fn new(scene: String) -> Self {
        Self { scene, ..Self::default() }
    }
}

#[derive(Serialize, Deserialize)]
enum Order {
    /// Calls of `step` with so many substeps each.
    Step { calls: u64, substeps: u64 },
    /// Resident memory of the process.
    Memory,
    /// A hash of the snapshot of now.
    Hash,
    /// The kinetic energy, by which `benches/peers/race.py` sees that all codes have done the same.
    Energy,
}

#[derive(Serialize, Deserialize)]
enum Answer {
    /// Particles, and memory that the simulation takes \[bytes\].
    Ready {
        particles: usize,
        memory: usize,
    },
    /// Wall time of the calls \[s\].
    Took(f64),
    /// Resident memory \[bytes\].
    Resident(u64),
    Hash(u64),
    /// \[J\].
    Energy(f64),
    Fault(String),
}

/// Carries out the orders that come on standard input, until it ends. The first line is a task: what to time.
///
/// # Errors
/// Standard output that cannot be written.
pub fn serve() -> std::io::Result<()> {
    let mut lines = std::io::stdin().lock().lines();
    let mut out = std::io::stdout().lock();
    let mut answer = |answer: Result<Answer, String>| {
        let text = serde_json::to_string(&answer.unwrap_or_else(Answer::Fault)).unwrap_or_default();
        writeln!(out, "{text}")?;
        out.flush()
    };
    let Some(first) = lines.next().transpose()? else { return Ok(()) };
    let mut timed = match serde_json::from_str(&first).map_err(text).and_then(Timed::new) {
        Ok(timed) => timed,
        Err(fault) => return answer(Err(fault)),
    };
    let about = timed.sim.describe();
    answer(Ok(Answer::Ready { particles: about.particles, memory: about.memory }))?;
    for line in lines {
        answer(match serde_json::from_str(&line?) {
            Ok(Order::Step { calls, substeps }) => timed.step(calls, substeps).map(Answer::Took),
            Ok(Order::Memory) => resident().map(Answer::Resident).ok_or_else(|| "this system does not tell".to_owned()),
            Ok(Order::Hash) => Ok(Answer::Hash(hash(&timed.sim.save()))),
            Ok(Order::Energy) => timed.sim.get("energy/kinetic").map(|energy| Answer::Energy(energy[0])).map_err(text),
            Err(error) => Err(text(error)),
        })?;
    }
    Ok(())
}

fn text(error: impl std::fmt::Display) -> String {
    error.to_string()
}

struct Timed {
    sim: Simulation,
    task: Task,
    recorder: Option<Recorder<'static>>,
    /// The fixed step of the scene \[s\].
    substep: f64,
}

impl Timed {
    fn new(task: Task) -> Result<Self, String> {
        // a key that is not known is told without the list of those that are
        let fault = |error: SceneError| text(error).split("; allowed:").next().unwrap_or_default().to_owned();
        let mut sim = Scene::from_toml(&task.scene).and_then(Scene::build).map_err(fault)?;
        if task.shuffled {
            sim.shuffle();
        }
        let recorder = match &task.record {
            Some((path, every)) => {
                let sink = sink_for(path, &Options { force: true, ..Options::default() }).map_err(text)?;
                Some(Recorder::begin(&mut sim, vec![sink], Some(*every), Some(*every)).map_err(text)?)
            }
            None => None,
        };
        Ok(Self { substep: sim.usual_step(), sim, task, recorder })
    }

    fn step(&mut self, calls: u64, substeps: u64) -> Result<f64, String> {
        let dt = substeps as f64 * self.substep;
        let start = Instant::now();
        for _ in 0..calls {
            if let Some((name, values)) = &self.task.set {
                self.sim.set(name, values).map_err(text)?;
            }
            self.sim.step(dt).map_err(text)?;
            if let Some(recorder) = &mut self.recorder {
                recorder.offer(&mut self.sim).map_err(text)?;
            }
            for name in &self.task.get {
                black_box(self.sim.get(name).map_err(text)?);
            }
        }
        Ok(start.elapsed().as_secs_f64())
    }
}

/// Resident memory of this process \[bytes\], where the system tells it as Linux does.
fn resident() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmRSS:"))?;
    Some(1024 * line.trim().strip_suffix("kB")?.trim().parse::<u64>().ok()?)
}

/// FNV-1a.
fn hash(bytes: &[u8]) -> u64 {
    bytes.iter().fold(0xcbf2_9ce4_8422_2325, |hash, byte| (hash ^ u64::from(*byte)).wrapping_mul(0x0100_0000_01b3))
}

/// Such a process, seen from outside.
pub(super) struct Stopwatch {
    child: Child,
    orders: ChildStdin,
    answers: BufReader<ChildStdout>,
    /// Number of particles.
    pub(super) particles: usize,
    /// Memory that the simulation takes \[bytes\].
    pub(super) memory: usize,
}

impl Stopwatch {
    /// Starts `program`, the command `matpoint`, with so many threads and with instructions as `MATPOINT_INSTRUCTIONS` names them: the best
    /// ones that the processor has where none are named.
    pub(super) fn start(program: &Path, task: &Task, threads: usize, instructions: Option<&str>) -> Result<Self, String> {
        let mut command = Command::new(program);
        command.args(["study", "stopwatch"]).env("RAYON_NUM_THREADS", threads.to_string());
        match instructions {
            Some(name) => command.env("MATPOINT_INSTRUCTIONS", name),
            None => command.env_remove("MATPOINT_INSTRUCTIONS"),
        };
        let mut child = command.stdin(Stdio::piped()).stdout(Stdio::piped()).spawn().map_err(|e| format!("{}: {e}", program.display()))?;
        let (Some(orders), Some(answers)) = (child.stdin.take(), child.stdout.take()) else { return Err("no pipes".into()) };
        let mut watch = Self { child, orders, answers: BufReader::new(answers), particles: 0, memory: 0 };
        match watch.ask(task)? {
            Answer::Ready { particles, memory } => (watch.particles, watch.memory) = (particles, memory),
            _ => return Err(MIXED.into()),
        }
        Ok(watch)
    }

    fn ask(&mut self, order: &impl Serialize) -> Result<Answer, String> {
        let order = serde_json::to_string(order).map_err(text)?;
        writeln!(self.orders, "{order}").map_err(text)?;
        let mut line = String::new();
        self.answers.read_line(&mut line).map_err(text)?;
        match serde_json::from_str(&line).map_err(|_| "the process that was timed has ended".to_owned())? {
            Answer::Fault(fault) => Err(fault),
            answer => Ok(answer),
        }
    }

    /// Wall time of so many calls of `step` with so many substeps each \[s\].
    pub(super) fn step(&mut self, calls: u64, substeps: u64) -> Result<f64, String> {
        match self.ask(&Order::Step { calls, substeps })? {
            Answer::Took(seconds) => Ok(seconds),
            _ => Err(MIXED.into()),
        }
    }

    /// Resident memory of the process \[bytes\].
    pub(super) fn resident(&mut self) -> Result<u64, String> {
        match self.ask(&Order::Memory)? {
            Answer::Resident(bytes) => Ok(bytes),
            _ => Err(MIXED.into()),
        }
    }

    /// A hash of the snapshot of now.
    pub(super) fn hash(&mut self) -> Result<u64, String> {
        match self.ask(&Order::Hash)? {
            Answer::Hash(hash) => Ok(hash),
            _ => Err(MIXED.into()),
        }
    }
}

const MIXED: &str = "an answer to another order";

impl Drop for Stopwatch {
    fn drop(&mut self) {
        // a process that has ended already cannot be stopped, which is no fault
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}
