//! Publishing on a thread of its own: the newest of each kind wins, so that no subscriber can hold up a step.

use crate::args::Level;
use crate::cloud::Layout;
use crate::interfaces::matpoint::{ComponentState, SceneDescription};
use crate::interfaces::parameters::ParameterEvent;
use crate::interfaces::standard::{Clock, DiagnosticArray, PointCloud2};
use ros2_client::builtin_interfaces::Time;
use ros2_client::{NodeLoggingHandle, Publisher, RosoutRaw, ros2::LogLevel};
use std::collections::VecDeque;
use std::sync::atomic::{AtomicU64, Ordering::Relaxed};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant, SystemTime};

/// Messages of the log that may wait.
const LOGS: usize = 100;

/// The publishers of the node.
pub struct Publishers {
    /// `/clock`.
    pub clock: Publisher<Clock>,
    /// `~/state`.
    pub state: Publisher<ComponentState>,
    /// `~/particles`.
    pub particles: Publisher<PointCloud2>,
    /// `/diagnostics`.
    pub diagnostics: Publisher<DiagnosticArray>,
    /// `/parameter_events`.
    pub parameter_events: Publisher<ParameterEvent>,
    /// `~/scene`, transient local: it lives as long as the others.
    pub scene: Publisher<SceneDescription>,
    /// `/rosout`.
    pub log: NodeLoggingHandle,
}

/// A cloud to publish.
pub struct Cloud {
    /// All of it.
    pub message: PointCloud2,
    /// Its columns.
    pub layout: Arc<Layout>,
    /// Points in a tile and the time over which the tiles are spread; one message if not given.
    pub tiles: Option<(usize, Duration)>,
}

#[derive(Default)]
struct Pending {
    clock: Option<Clock>,
    state: Option<ComponentState>,
    cloud: Option<Cloud>,
    diagnostics: Option<DiagnosticArray>,
    events: VecDeque<ParameterEvent>,
    logs: VecDeque<(Level, String)>,
    closed: bool,
}

impl Pending {
    fn has_small(&self) -> bool {
        self.clock.is_some() || self.state.is_some() || self.diagnostics.is_some() || !self.events.is_empty() || !self.logs.is_empty()
    }
}

/// What the thread did and left undone.
#[derive(Debug, Default)]
pub struct Counts {
    /// Messages published, tiles counted one by one.
    pub published: AtomicU64,
    /// States and clouds that a newer one replaced before they were published.
    pub replaced: AtomicU64,
    /// Messages that a reliable subscriber who does not answer left no room for.
    pub no_room: AtomicU64,
}

#[derive(Default)]
struct Shared {
    pending: Mutex<Pending>,
    wake: Condvar,
    counts: Counts,
}

impl Shared {
    fn lock(&self) -> MutexGuard<'_, Pending> {
        self.pending.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// The way out of the loop.
pub struct Outlets {
    shared: Arc<Shared>,
    thread: Option<JoinHandle<()>>,
    level: Level,
    name: String,
}

impl Outlets {
    /// Starts the thread. Messages of the log below `level` go nowhere; `name` stands before them on stderr.
    ///
    /// # Errors
    /// No thread can be had.
    pub fn new(publishers: Publishers, level: Level, name: String) -> std::io::Result<Self> {
        let shared = Arc::new(Shared::default());
        let theirs = shared.clone();
        let thread = std::thread::Builder::new().name("publish".into()).spawn(move || run(&theirs, &publishers))?;
        Ok(Self { shared, thread: Some(thread), level, name })
    }

    /// What the thread did.
    pub fn counts(&self) -> &Counts {
        &self.shared.counts
    }

    fn put(&self, f: impl FnOnce(&mut Pending)) {
        f(&mut self.shared.lock());
        self.shared.wake.notify_one();
    }

    fn newest<T>(&self, slot: impl FnOnce(&mut Pending) -> &mut Option<T>, message: T) {
        self.put(|pending| {
            if slot(pending).replace(message).is_some() {
                self.shared.counts.replaced.fetch_add(1, Relaxed);
            }
        });
    }

    /// Publishes the time.
    pub fn clock(&self, clock: Clock) {
        self.put(|pending| pending.clock = Some(clock));
    }
    /// Publishes a state.
    pub fn state(&self, state: ComponentState) {
        self.newest(|pending| &mut pending.state, state);
    }
    /// Publishes a cloud.
    pub fn cloud(&self, cloud: Cloud) {
        self.newest(|pending| &mut pending.cloud, cloud);
    }
    /// Publishes diagnostics.
    pub fn diagnostics(&self, diagnostics: DiagnosticArray) {
        self.put(|pending| pending.diagnostics = Some(diagnostics));
    }
    /// Publishes a change of parameters.
    pub fn event(&self, event: ParameterEvent) {
        self.put(|pending| pending.events.push_back(event));
    }

    /// Says something on stderr and `/rosout`.
    pub fn log(&self, level: Level, text: impl Into<String>) {
        if level < self.level {
            return;
        }
        let text = text.into();
        let now = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH).unwrap_or_default().as_secs_f64();
        let word = format!("{level:?}").to_uppercase();
        // Not `eprintln!`: that panics where stderr is closed.
        let line = format!("[{word}] [{now:.6}] [{}]: {text}\n", self.name);
        let _ = std::io::Write::write_all(&mut std::io::stderr(), line.as_bytes());
        self.put(|pending| {
            if pending.logs.len() < LOGS {
                pending.logs.push_back((level, text));
            }
        });
    }

    /// Publishes what is left and takes the publishers off the graph.
    pub fn close(&mut self) {
        self.put(|pending| pending.closed = true);
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

impl Drop for Outlets {
    fn drop(&mut self) {
        self.close();
    }
}

fn run(shared: &Shared, to: &Publishers) {
    let counts = &shared.counts;
    let mut tiles: VecDeque<PointCloud2> = VecDeque::new();
    let (mut due, mut apart) = (Instant::now(), Duration::ZERO);
    loop {
        let mut pending = shared.lock();
        // A cloud waits until the tiles of the one before it are out: every cloud that is begun is whole.
        while !(pending.has_small() || pending.closed || tiles.is_empty() && pending.cloud.is_some()) {
            if tiles.is_empty() {
                pending = shared.wake.wait(pending).unwrap_or_else(PoisonError::into_inner);
                continue;
            }
            let left = due.saturating_duration_since(Instant::now());
            if left.is_zero() {
                break;
            }
            pending = shared.wake.wait_timeout(pending, left).unwrap_or_else(PoisonError::into_inner).0;
        }
        let closed = pending.closed;
        let cloud = if tiles.is_empty() { pending.cloud.take() } else { None };
        let work = Pending {
            clock: pending.clock.take(),
            state: pending.state.take(),
            diagnostics: pending.diagnostics.take(),
            events: std::mem::take(&mut pending.events),
            logs: std::mem::take(&mut pending.logs),
            ..Default::default()
        };
        drop(pending);

        // The time first: whoever gets a state at some time has the clock at that time.
        work.clock.into_iter().for_each(|m| send(&to.clock, m, counts));
        work.state.into_iter().for_each(|m| send(&to.state, m, counts));
        work.diagnostics.into_iter().for_each(|m| send(&to.diagnostics, m, counts));
        work.events.into_iter().for_each(|m| send(&to.parameter_events, m, counts));
        for (level, text) in work.logs {
            to.log.rosout_raw(Time::now(), log_level(level), to.log.base_name(), &text, "", "", 0);
        }
        match cloud {
            Some(Cloud { message, layout, tiles: Some((points, period)) }) => {
                let cut = layout.tiles(&message, points);
                (due, apart) = (Instant::now(), period / cut.len().max(1) as u32);
                tiles.extend(cut);
            }
            Some(Cloud { message, .. }) => send(&to.particles, message, counts),
            None => {}
        }
        if due <= Instant::now()
            && let Some(tile) = tiles.pop_front()
        {
            send(&to.particles, tile, counts);
            // A thread that was late catches up at twice the rate: a burst is what receivers lose.
            due = (due + apart).max(Instant::now() + apart / 2);
        }
        if closed {
            return;
        }
    }
}

fn send<M: serde::Serialize>(publisher: &Publisher<M>, message: M, counts: &Counts) {
    let count = if publisher.publish(message).is_ok() { &counts.published } else { &counts.no_room };
    count.fetch_add(1, Relaxed);
}

fn log_level(level: Level) -> LogLevel {
    match level {
        Level::Debug => LogLevel::Debug,
        Level::Info => LogLevel::Info,
        Level::Warn => LogLevel::Warn,
        Level::Error => LogLevel::Error,
    }
}
