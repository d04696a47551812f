//! Recording beside the solver: a bounded queue, and a thread that computes what is recorded and drives a format.

use super::data::{About, Event, Item, Level, Row, Snapshot, read_frame};
use super::recorder::Ticks;
use super::{Options, RecordError, Sink, WhenFull};
use crate::Simulation;
use crate::state::State;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, SyncSender, TrySendError, channel, sync_channel};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// States that may wait. One is being written while another is made; a third takes up the jitter of a disk.
const STATES: usize = 3;
/// Orders that may wait.
const ORDERS: usize = 4096;
/// What was written longer ago has left this process: a kill costs no more than this.
const FLUSH: Duration = Duration::from_millis(500);

/// Something that recordings are written to. It lives on a thread of its own once it is open.
pub(crate) trait Writer: Send {
    /// Opens the files and writes what does not change.
    fn open(&mut self, about: Arc<About>) -> Result<(), RecordError>;
    /// Writes a thing.
    fn write(&mut self, item: &Item) -> Result<(), RecordError>;
    /// Hands everything written to the system.
    fn flush(&mut self) -> Result<(), RecordError>;
    /// Completes the files.
    fn close(&mut self) -> Result<Vec<PathBuf>, RecordError>;
    /// Whether somebody looks on, who is better served by the next frame than by all of them.
    fn is_live(&self) -> bool {
        false
    }
}

/// A sink that leaves the work to a [`Writer`] on another thread.
///
/// What the solver's thread does is to copy the state. The other thread has a twin of the simulation, and computes there what is recorded.
/// Its errors come back from the next call.
pub(crate) struct Background {
    writer: Option<Box<dyn Writer>>,
    options: Options,
    running: Option<Running>,
    files: Vec<PathBuf>,
    dropped: u64,
    /// Why the recording ended, where the simulation goes on without it.
    lost: Option<RecordError>,
}

/// What the other thread is to do, in this order.
enum Order {
    /// Record something of a state: of this one, or of the last one that came.
    Record { state: Option<Box<State>>, row: Option<RowHead>, frame: bool, snapshot: bool },
    /// Tell what happened.
    Event(Event),
}

/// What a row has that is not in a state.
struct RowHead {
    count: u64,
    /// Mean substep \[s\], iterations, real-time factor since the last row.
    pace: [f64; 3],
}

struct Running {
    queue: SyncSender<Order>,
    /// A place for each state under way.
    places: SyncSender<()>,
    /// States that were recorded, to be filled again.
    used: Receiver<Box<State>>,
    thread: JoinHandle<Result<Vec<PathBuf>, RecordError>>,
    when_full: WhenFull,
    snapshots: Option<Ticks>,
    snapshot: f64,
    rows: u64,
    /// Time and substeps of the state that a row was made of just now: a frame of the same time needs no other.
    last_state: Option<(f64, u64)>,
    /// Simulated time, substeps, iterations and wall time of the last row.
    last: (f64, u64, u64, Instant),
}

impl Background {
    pub(crate) fn new(writer: Box<dyn Writer>, options: &Options) -> Self {
        Self { writer: Some(writer), options: options.clone(), running: None, files: Vec::new(), dropped: 0, lost: None }
    }

    /// Hands an order over; `None` where the thread has ended, else whether it was taken.
    fn send(running: &Running, dropped: &mut u64, order: Order) -> Option<bool> {
        let has_state = matches!(order, Order::Record { state: Some(_), .. });
        if running.when_full == WhenFull::Wait {
            return ((!has_state || running.places.send(()).is_ok()) && running.queue.send(order).is_ok()).then_some(true);
        }
        let place = if has_state { running.places.try_send(()) } else { Ok(()) };
        let is_full = match place {
            Ok(()) => match running.queue.try_send(order) {
                Ok(()) => return Some(true),
                Err(error) => matches!(error, TrySendError::Full(_)),
            },
            Err(error) => matches!(error, TrySendError::Full(())),
        };
        *dropped += u64::from(is_full);
        is_full.then_some(false)
    }

    /// Hands an order over; tells whether it was taken.
    fn put(&mut self, order: Order) -> Result<bool, RecordError> {
        match self.running.as_ref().map(|running| Self::send(running, &mut self.dropped, order)) {
            Some(None) => self.end().map(|()| false),
            Some(Some(taken)) => Ok(taken),
            None => Ok(false),
        }
    }

    /// Has something of the state of `sim` recorded.
    fn record(&mut self, sim: &Simulation, row: Option<RowHead>, frame: bool, snapshot: bool) -> Result<(), RecordError> {
        let Some(running) = &mut self.running else { return Ok(()) };
        let now = (sim.time(), sim.steps());
        // a row comes just before the frame of the same time
        let known = running.last_state.take() == Some(now) && row.is_none();
        let state = (!known).then(|| {
            let mut state = running.used.try_recv().unwrap_or_default();
            sim.copy_state(&mut state);
            state
        });
        let is_row = row.is_some();
        if self.put(Order::Record { state, row, frame, snapshot })?
            && is_row
            && let Some(running) = &mut self.running
        {
            running.last_state = Some(now);
        }
        Ok(())
    }

    /// Waits for the thread, and takes what it leaves.
    fn end(&mut self) -> Result<(), RecordError> {
        let Some(Running { queue, places, thread, .. }) = self.running.take() else { return Ok(()) };
        drop((queue, places));
        let outcome = thread.join().unwrap_or(Err(RecordError::Thread));
        match outcome {
            Ok(files) => self.files = files,
            Err(error) if self.options.keep_going => self.lost = Some(error),
            Err(error) => return Err(error),
        }
        Ok(())
    }
}

impl Sink for Background {
    fn begin(&mut self, sim: &mut Simulation) -> Result<(), RecordError> {
        let Some(mut writer) = self.writer.take() else { return Ok(()) };
        let about = Arc::new(About::new(sim, &self.options)?);
        writer.open(about.clone())?;
        let usual = if writer.is_live() { WhenFull::Drop } else { WhenFull::Wait };
        let ((queue, orders), (places, freed), (back, used)) = (sync_channel(ORDERS), sync_channel(STATES), channel());
        let twin = sim.twin();
        let mut scribe = Scribe { twin, about, body: sim.share("particle/body")?, writer, freed, back };
        let thread = std::thread::Builder::new()
            .name("record".into())
            .spawn(move || scribe.work(&orders))
            .map_err(|source| RecordError::Spawn { source })?;
        self.running = Some(Running {
            queue,
            places,
            used,
            thread,
            when_full: self.options.when_full.unwrap_or(usual),
            snapshots: self.options.snapshots.map(|every| Ticks::after(sim.time(), every)),
            snapshot: sim.time(),
            rows: 0,
            last_state: None,
            last: (sim.time(), sim.steps(), sim.iterations(), Instant::now()),
        });
        for warning in crate::scene::check::warnings(sim.scene()) {
            self.event(sim, Level::Warning, &warning.to_string())?;
        }
        Ok(())
    }

    fn frame(&mut self, sim: &mut Simulation, _: u64) -> Result<(), RecordError> {
        let Some(running) = &mut self.running else { return Ok(()) };
        let snapshot = running.snapshots.as_mut().is_some_and(|ticks| ticks.passed(sim.time()));
        if snapshot {
            running.snapshot = sim.time();
        }
        self.record(sim, None, true, snapshot)
    }

    fn history(&mut self, sim: &mut Simulation, step: u64) -> Result<(), RecordError> {
        let Some(running) = &mut self.running else { return Ok(()) };
        let now = (sim.time(), step, sim.iterations(), Instant::now());
        let last = std::mem::replace(&mut running.last, now);
        let (moved, substeps) = (now.0 - last.0, now.1.saturating_sub(last.1));
        let wall = (now.3 - last.3).as_secs_f64();
        let ratio = |a: f64, b: f64| if b > 0.0 { a / b } else { 0.0 };
        let pace = [ratio(moved, substeps as f64), now.2.saturating_sub(last.2) as f64, ratio(moved, wall)];
        let head = RowHead { count: running.rows, pace };
        running.rows += 1;
        self.record(sim, Some(head), false, false)
    }

    fn event(&mut self, sim: &Simulation, level: Level, text: &str) -> Result<(), RecordError> {
        self.put(Order::Event(Event { time: sim.time(), step: sim.steps(), level, text: text.to_owned() })).map(drop)
    }

    fn finish(&mut self, sim: &mut Simulation) -> Result<(), RecordError> {
        if self.running.as_ref().is_some_and(|r| r.snapshots.is_some() && r.snapshot != sim.time()) {
            self.record(sim, None, false, true)?;
        }
        if self.dropped > 0 {
            self.event(sim, Level::Warning, &format!("{} frames and rows dropped: the recording could not keep up", self.dropped))?;
        }
        self.end()?;
        self.lost.take().map_or(Ok(()), Err)
    }

    fn files(&self) -> Vec<PathBuf> {
        self.files.clone()
    }

    fn dropped(&self) -> u64 {
        self.dropped
    }
}

impl Drop for Background {
    fn drop(&mut self) {
        // Whoever did not finish still gets whole files; nobody is left to hear of an error.
        let _ = self.end();
    }
}

/// What the other thread has.
struct Scribe {
    /// Has the state that is recorded.
    twin: Simulation,
    about: Arc<About>,
    /// Body of each particle, which does not change.
    body: Arc<Vec<f64>>,
    writer: Box<dyn Writer>,
    freed: Receiver<()>,
    back: Sender<Box<State>>,
}

impl Scribe {
    /// Writes until nobody is left to send anything.
    fn work(&mut self, orders: &Receiver<Order>) -> Result<Vec<PathBuf>, RecordError> {
        let (mut flushed, mut dirty) = (Instant::now(), true);
        loop {
            match orders.recv_timeout(FLUSH) {
                Ok(order) => {
                    self.obey(order)?;
                    dirty = true;
                }
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => return self.writer.close(),
            }
            if dirty && flushed.elapsed() >= FLUSH {
                self.writer.flush()?;
                (flushed, dirty) = (Instant::now(), false);
            }
        }
    }

    fn obey(&mut self, order: Order) -> Result<(), RecordError> {
        let (state, row, frame, snapshot) = match order {
            Order::Event(event) => return self.writer.write(&Item::Event(event)),
            Order::Record { state, row, frame, snapshot } => (state, row, frame, snapshot),
        };
        if let Some(mut state) = state {
            self.twin.exchange_state(&mut state);
            // whoever records no longer needs none back
            let _ = self.back.send(state);
            let _ = self.freed.try_recv();
        }
        if let Some(head) = row {
            let row = self.row(&head)?;
            self.writer.write(&Item::Row(row))?;
        }
        if frame {
            let frame = read_frame(&mut self.twin, &self.about.columns, &self.body)?;
            self.writer.write(&Item::Frame(frame))?;
        }
        if snapshot {
            let twin = &self.twin;
            self.writer.write(&Item::Snapshot(Snapshot { time: twin.time(), step: twin.steps(), bytes: twin.save() }))?;
        }
        Ok(())
    }

    fn row(&mut self, head: &RowHead) -> Result<Row, RecordError> {
        let mut pace = head.pace.into_iter();
        let mut values = Vec::with_capacity(self.about.series.len() + self.about.inputs.len());
        for series in &self.about.series {
            values.push(if series.variable.starts_with("pace/") {
                pace.next().into_iter().collect()
            } else {
                self.twin.get(&series.variable)?.to_vec()
            });
        }
        for input in &self.about.inputs {
            values.push(self.twin.get(&input.name)?.to_vec());
        }
        Ok(Row { time: self.twin.time(), step: self.twin.steps(), count: head.count, values })
    }
}
