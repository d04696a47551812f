//! Publishing on a thread of its own: the newest of each kind wins, so that no subscriber can hold up a step. A replay is patient instead:
//! it waits until each message is out.

use crate::args::Level;
use crate::cloud;
use crate::interfaces::matpoint::{ComponentState, SceneDescription};
use crate::interfaces::parameters::ParameterEvent;
use crate::interfaces::standard::{Clock, DiagnosticArray, PointCloud2};
use ros2_client::builtin_interfaces::Time;
use ros2_client::{NodeLoggingHandle, Publisher, RosoutRaw, WriteError, ros2::LogLevel};
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
    /// Whoever brings a message waits for the one before it, and that for a subscriber who has no room.
    patient: bool,
    /// The thread has something in hand.
    busy: bool,
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
    /// The thread has taken what was pending, or nobody is patient any more.
    taken: Condvar,
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
        Self::with(publishers, level, name, false)
    }

    /// The same, but every message is published, in order: whoever brings one waits for room, until told not to by [`Hurry`].
    ///
    /// # Errors
    /// No thread can be had.
    pub fn patient(publishers: Publishers, level: Level, name: String) -> std::io::Result<Self> {
        Self::with(publishers, level, name, true)
    }

    fn with(publishers: Publishers, level: Level, name: String, patient: bool) -> std::io::Result<Self> {
        let shared = Arc::new(Shared { pending: Mutex::new(Pending { patient, ..Default::default() }), ..Default::default() });
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

    /// Whether the message before was replaced.
    fn newest<T>(&self, slot: impl Fn(&mut Pending) -> &mut Option<T>, message: T) -> bool {
        let full = |pending: &mut Pending| pending.patient && slot(pending).is_some();
        let mut pending = self.shared.taken.wait_while(self.shared.lock(), full).unwrap_or_else(PoisonError::into_inner);
        let replaced = slot(&mut pending).replace(message).is_some();
        drop(pending);
        self.shared.wake.notify_one();
        replaced
    }

    fn count_replaced(&self, replaced: bool) {
        self.shared.counts.replaced.fetch_add(u64::from(replaced), Relaxed);
    }

    /// Waits until all is published, or until told to hurry.
    pub fn drain(&self) {
        let working = |pending: &mut Pending| pending.patient && (pending.busy || pending.has_small() || pending.cloud.is_some());
        drop(self.shared.taken.wait_while(self.shared.lock(), working));
    }

    /// The way to end patience from another thread.
    pub fn hurry(&self) -> Hurry {
        Hurry(self.shared.clone())
    }

    /// Publishes the time.
    pub fn clock(&self, clock: Clock) {
        self.newest(|pending| &mut pending.clock, clock);
    }
    /// Publishes a state.
    pub fn state(&self, state: ComponentState) {
        self.count_replaced(self.newest(|pending| &mut pending.state, state));
    }
    /// Publishes a cloud.
    pub fn cloud(&self, cloud: Cloud) {
        self.count_replaced(self.newest(|pending| &mut pending.cloud, cloud));
    }
    /// Publishes diagnostics.
    pub fn diagnostics(&self, diagnostics: DiagnosticArray) {
        self.newest(|pending| &mut pending.diagnostics, diagnostics);
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
        self.put(|pending| (pending.closed, pending.patient) = (true, false));
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

/// Ends the patience of [`Outlets`]: who waits for room goes on at once, and what has no room is not published.
pub struct Hurry(Arc<Shared>);

impl Hurry {
    /// Now.
    pub fn now(&self) {
        self.0.lock().patient = false;
        self.0.taken.notify_all();
    }
}

fn run(shared: &Shared, to: &Publishers) {
    let mut tiles: VecDeque<PointCloud2> = VecDeque::new();
    let (mut due, mut apart) = (Instant::now(), Duration::ZERO);
    loop {
        let mut pending = shared.lock();
        pending.busy = !tiles.is_empty();
        shared.taken.notify_all();
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
        pending.busy = true;
        drop(pending);
        shared.taken.notify_all();

        // The time first: whoever gets a state at some time has the clock at that time.
        work.clock.into_iter().for_each(|m| send(&to.clock, m, shared));
        work.state.into_iter().for_each(|m| send(&to.state, m, shared));
        work.diagnostics.into_iter().for_each(|m| send(&to.diagnostics, m, shared));
        work.events.into_iter().for_each(|m| send(&to.parameter_events, m, shared));
        for (level, text) in work.logs {
            to.log.rosout_raw(Time::now(), log_level(level), to.log.base_name(), &text, "", "", 0);
        }
        match cloud {
            Some(Cloud { message, tiles: Some((points, period)) }) => {
                let cut = cloud::tiles(&message, points);
                (due, apart) = (Instant::now(), period / cut.len().max(1) as u32);
                tiles.extend(cut);
            }
            Some(Cloud { message, .. }) => send(&to.particles, message, shared),
            None => {}
        }
        if due <= Instant::now()
            && let Some(tile) = tiles.pop_front()
        {
            send(&to.particles, tile, shared);
            // A thread that was late catches up at twice the rate: a burst is what receivers lose.
            due = (due + apart).max(Instant::now() + apart / 2);
        }
        if closed {
            return;
        }
    }
}

fn send<M: serde::Serialize>(publisher: &Publisher<M>, mut message: M, shared: &Shared) {
    let outcome = loop {
        match publisher.publish(message) {
            Err(WriteError::WouldBlock { data }) if shared.lock().patient => message = data,
            outcome => break outcome,
        }
    };
    let count = if outcome.is_ok() { &shared.counts.published } else { &shared.counts.no_room };
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
