//! Recording beside the solver: a bounded queue, and a thread that drives a format.

use super::data::{About, Event, Frame, Item, Level, Row, Snapshot, read_frame};
use super::recorder::Ticks;
use super::{Options, RecordError, Sink, WhenFull};
use crate::Simulation;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender, TrySendError, sync_channel};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// Frames that may wait. One is being written while another is made; a third takes up the jitter of a disk.
const FRAMES: usize = 3;
/// Rows, events and frames that may wait.
const ITEMS: usize = 4096;
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
/// What the solver's thread does for a frame is to have the variables computed; they are shared, not copied. Errors of the other thread
/// come back from the next call.
pub(crate) struct Background {
    writer: Option<Box<dyn Writer>>,
    options: Options,
    running: Option<Running>,
    files: Vec<PathBuf>,
    dropped: u64,
    /// Why the recording ended, where the simulation goes on without it.
    lost: Option<RecordError>,
}

struct Running {
    about: Arc<About>,
    body: Arc<Vec<f64>>,
    queue: SyncSender<Item>,
    /// A place for each frame under way.
    places: SyncSender<()>,
    thread: JoinHandle<Result<Vec<PathBuf>, RecordError>>,
    when_full: WhenFull,
    snapshots: Option<Ticks>,
    snapshot: f64,
    rows: u64,
    /// Simulated time, substeps, iterations and wall time of the last row.
    last: (f64, u64, u64, Instant),
}

impl Background {
    pub(crate) fn new(writer: Box<dyn Writer>, options: &Options) -> Self {
        Self { writer: Some(writer), options: options.clone(), running: None, files: Vec::new(), dropped: 0, lost: None }
    }

    /// Hands an item over; `false` where the thread has ended.
    fn send(running: &Running, dropped: &mut u64, item: Item) -> bool {
        let is_frame = matches!(item, Item::Frame(_));
        match running.when_full {
            WhenFull::Wait => (!is_frame || running.places.send(()).is_ok()) && running.queue.send(item).is_ok(),
            WhenFull::Drop => {
                let outcome = if is_frame { running.places.try_send(()) } else { Ok(()) };
                match outcome
                    .map_err(|e| matches!(e, TrySendError::Full(())))
                    .and_then(|()| running.queue.try_send(item).map_err(|e| matches!(e, TrySendError::Full(_))))
                {
                    Ok(()) => true,
                    Err(full) => {
                        *dropped += u64::from(full);
                        full
                    }
                }
            }
        }
    }

    fn put(&mut self, item: Item) -> Result<(), RecordError> {
        match &self.running {
            Some(running) if !Self::send(running, &mut self.dropped, item) => self.end(),
            _ => Ok(()),
        }
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

    fn save(&mut self, sim: &Simulation) -> Result<(), RecordError> {
        let snapshot = Snapshot { time: sim.time(), step: sim.steps(), bytes: sim.save() };
        if let Some(running) = &mut self.running {
            running.snapshot = snapshot.time;
        }
        self.put(Item::Snapshot(snapshot))
    }
}

impl Sink for Background {
    fn begin(&mut self, sim: &mut Simulation) -> Result<(), RecordError> {
        let Some(mut writer) = self.writer.take() else { return Ok(()) };
        let about = Arc::new(About::new(sim, &self.options)?);
        writer.open(about.clone())?;
        let usual = if writer.is_live() { WhenFull::Drop } else { WhenFull::Wait };
        let ((queue, items), (places, freed)) = (sync_channel(ITEMS), sync_channel(FRAMES));
        let theirs = about.clone();
        let thread = std::thread::Builder::new()
            .name("record".into())
            .spawn(move || work(&mut *writer, &theirs, &items, &freed))
            .map_err(|source| RecordError::Spawn { source })?;
        self.running = Some(Running {
            body: sim.share("particle/body")?,
            about,
            queue,
            places,
            thread,
            when_full: self.options.when_full.unwrap_or(usual),
            snapshots: self.options.snapshots.map(|every| Ticks::after(sim.time(), every)),
            snapshot: sim.time(),
            rows: 0,
            last: (sim.time(), sim.steps(), sim.iterations(), Instant::now()),
        });
        for warning in crate::scene::check::warnings(sim.scene()) {
            self.event(sim, Level::Warning, &warning.to_string())?;
        }
        Ok(())
    }

    fn frame(&mut self, sim: &mut Simulation, _: u64) -> Result<(), RecordError> {
        let Some(running) = &mut self.running else { return Ok(()) };
        let due = running.snapshots.as_mut().is_some_and(|ticks| ticks.passed(sim.time()));
        let frame = read_frame(sim, &running.about.columns, &running.body)?;
        self.put(Item::Frame(frame))?;
        if due { self.save(sim) } else { Ok(()) }
    }

    fn history(&mut self, sim: &mut Simulation, step: u64) -> Result<(), RecordError> {
        let Some(running) = &mut self.running else { return Ok(()) };
        let now = (sim.time(), step, sim.iterations(), Instant::now());
        let last = std::mem::replace(&mut running.last, now);
        let (moved, substeps) = (now.0 - last.0, now.1.saturating_sub(last.1));
        let wall = (now.3 - last.3).as_secs_f64();
        let ratio = |a: f64, b: f64| if b > 0.0 { a / b } else { 0.0 };
        let pace = [ratio(moved, substeps as f64), now.2.saturating_sub(last.2) as f64, ratio(moved, wall)];
        let mut pace = pace.into_iter();
        let mut values = Vec::with_capacity(running.about.series.len() + running.about.inputs.len());
        for series in &running.about.series {
            values.push(if series.variable.starts_with("pace/") {
                pace.next().into_iter().collect()
            } else {
                sim.get(&series.variable)?.to_vec()
            });
        }
        for input in &running.about.inputs {
            values.push(sim.get(&input.name)?.to_vec());
        }
        let row = Row { time: now.0, step, count: running.rows, values };
        running.rows += 1;
        self.put(Item::Row(row))
    }

    fn event(&mut self, sim: &Simulation, level: Level, text: &str) -> Result<(), RecordError> {
        self.put(Item::Event(Event { time: sim.time(), step: sim.steps(), level, text: text.to_owned() }))
    }

    fn finish(&mut self, sim: &mut Simulation) -> Result<(), RecordError> {
        if self.running.as_ref().is_some_and(|r| r.snapshots.is_some() && r.snapshot != sim.time()) {
            self.save(sim)?;
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

/// The other thread: writes until nobody is left to send anything.
fn work(writer: &mut dyn Writer, about: &About, items: &Receiver<Item>, freed: &Receiver<()>) -> Result<Vec<PathBuf>, RecordError> {
    let (mut flushed, mut dirty) = (Instant::now(), true);
    loop {
        match items.recv_timeout(FLUSH) {
            Ok(Item::Frame(frame)) => {
                let frame: Frame = frame.derive(&about.columns);
                writer.write(&Item::Frame(frame))?;
                let _ = freed.try_recv();
                dirty = true;
            }
            Ok(item) => {
                writer.write(&item)?;
                dirty = true;
            }
            Err(RecvTimeoutError::Timeout) => {}
            Err(RecvTimeoutError::Disconnected) => return writer.close(),
        }
        if dirty && flushed.elapsed() >= FLUSH {
            writer.flush()?;
            (flushed, dirty) = (Instant::now(), false);
        }
    }
}
