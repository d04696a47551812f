//! A recording published as the node that made it did: the same topics, messages, names and stamps, in their own time. Nothing is
//! simulated: there are no loads, services or parameter services.

use crate::args::{ArgsError, Level, RosArgs};
use crate::cloud;
use crate::diagnostics::{Edge, Seldom};
use crate::graph::Watch;
use crate::inbox::inbox;
use crate::interfaces::standard::{Clock, Time};
use crate::names::Names;
use crate::network::{Network, NetworkError};
use crate::node::{NodeError, Receiving, Ros};
use crate::pace::Pace;
use crate::parameters::Settings;
use crate::publish::{Cloud, Hurry, Outlets};
use crate::start::{StartError, parameters, publishers};
use matpoint::record::{self, Item, Messages, RecordError, Recording};
use std::path::{Path, PathBuf};
use std::sync::atomic::Ordering::Relaxed;
use std::sync::mpsc::{Receiver, Sender, channel};
use std::time::{Duration, Instant};

/// Once one subscriber is there, those of the same program are known after so long.
const SETTLE: Duration = Duration::from_secs(1);

/// After the last message: what a reliable subscriber has lost is sent again within this. Subscribers say each 0.1 s what they lack;
/// ros2-client does not tell when they lack nothing.
const LINGER: Duration = Duration::from_secs(2);

/// Parameters that have an effect on a replay, or are given to every node.
const PARAMETERS: [&str; 7] = [
    "particles.max_bytes",
    "particles.mode",
    "particles.reliability",
    "particles.stride",
    "real_time_factor",
    "state.reliability",
    "use_sim_time",
];

/// A recording cannot be replayed.
#[derive(Debug, thiserror::Error)]
pub enum ReplayError {
    /// It cannot be read.
    #[error(transparent)]
    Record(#[from] RecordError),
    /// A format that this node was built without.
    #[error(
        "`{}`: this matpoint-node was built without .rrd: cargo build --release -p matpoint-ros2 --features rerun; or write it as .mcap \
         first: matpoint replay RUN.rrd --to mcap", .0.display()
    )]
    Format(PathBuf),
    /// A parameter of simulations.
    #[error("parameter `{0}` has no effect on a replay; those that have one: {known}", known = PARAMETERS.join(", "))]
    Parameter(String),
    /// The node cannot start.
    #[error(transparent)]
    Start(#[from] StartError),
}

macro_rules! start_errors {
    ($($error:ty),*) => { $(impl From<$error> for ReplayError { fn from(error: $error) -> Self { Self::Start(error.into()) } })* };
}
start_errors!(ArgsError, NetworkError, NodeError);

/// A node on the graph that has a recording to publish.
pub struct Replay {
    path: PathBuf,
    name: String,
    messages: Messages,
    settings: Settings,
    outlets: Outlets,
    ros: Ros,
    receiving: Receiving,
    stop: (Sender<()>, Receiver<()>),
    behind: Seldom,
    same_name: Edge,
    thinned: bool,
    /// Time of the last frame \[s\].
    frame: Option<f64>,
}

/// Ends a replay from another thread.
pub struct Stop(Hurry, Sender<()>);

impl Stop {
    /// Now.
    pub fn now(&self) {
        self.0.now();
        // Whoever is gone has stopped.
        let _ = self.1.send(());
    }
}

/// What is left of a replay that was told to stop.
struct Stopped;

impl Replay {
    /// Joins the graph with the recording at `path`, by the name that it has in it unless `args` say otherwise.
    ///
    /// # Errors
    /// A file that cannot be read or is no recording; arguments, parameters or variables that make no sense; DDS refuses.
    pub fn start(path: &Path, args: &RosArgs) -> Result<Self, ReplayError> {
        if cfg!(not(feature = "rerun")) && path.extension().is_some_and(|ending| ending == "rrd") {
            return Err(ReplayError::Format(path.to_path_buf()));
        }
        let recording = Recording::open(path)?;
        let messages = Messages::new(recording.about().clone());
        let about = messages.about();
        let (namespace, node) = about.ros.node.rsplit_once('/').unwrap_or(("", &about.ros.node));
        let names = Names::new(namespace, node, args.remaps.clone())?;
        let exact = args.overrides(&names)?.into_iter().filter(|given| given.exact);
        let settings = parameters(args, &names)?.settings;
        if let Some(other) = exact.map(|given| given.name).find(|name| !PARAMETERS.contains(&name.as_str())) {
            return Err(ReplayError::Parameter(other));
        }
        let network = Network::read(|name| std::env::var(name).ok())?;
        // Nothing is subscribed to or served: no request comes.
        let mut ros = Ros::open(names.clone(), &network, inbox().0)?;
        let publishers = publishers(&mut ros, &settings, about.description.particles, messages.point_step(), true)?;
        publishers.scene.publish(messages.scene()).map_err(NodeError::dds("~/scene"))?;
        let outlets = Outlets::patient(publishers, args.level, names.node().to_owned()).map_err(NodeError::Thread)?;
        network.warnings().for_each(|text| outlets.log(Level::Warn, text));
        if !recording.is_whole() {
            outlets.log(Level::Warn, format!("{} was cut off or is being written: what is in it now is replayed", path.display()));
        }
        ros.follow()?;
        let receiving = ros.start()?;
        let (path, name, stop) = (path.to_path_buf(), names.full(), channel());
        let (behind, same_name, thinned, frame) = (Seldom::default(), Edge::default(), false, None);
        Ok(Self { path, name, messages, settings, outlets, ros, receiving, stop, behind, same_name, thinned, frame })
    }

    /// The way to end it from another thread.
    pub fn stop(&self) -> Stop {
        Stop(self.outlets.hurry(), self.stop.0.clone())
    }

    /// Publishes the recording once somebody subscribes, at the latest after `wait`; over and over if `repeat`. Then leaves the graph, when
    /// reliable subscribers had the time to get all of it.
    ///
    /// # Errors
    /// A file that cannot be read any more.
    pub fn run(mut self, wait: Duration, repeat: bool) -> Result<(), ReplayError> {
        let outcome = self.publish(wait, repeat);
        let Self { outlets, ros, receiving, .. } = self;
        drop(outlets);
        ros.close(receiving);
        outcome
    }

    fn publish(&mut self, wait: Duration, repeat: bool) -> Result<(), ReplayError> {
        let (title, path) = (&self.messages.about().scene.title, self.path.display());
        self.outlets.log(Level::Info, format!("{title}: {path} replayed as {}", self.name));
        let mut going = self.wait(wait);
        while going.is_ok() {
            going = self.once()?;
            if !repeat {
                break;
            }
        }
        if going.is_ok() {
            self.outlets.drain();
            if self.listened() {
                let _ = self.sleep(LINGER);
            }
        }
        Ok(())
    }

    /// Waits for a subscriber.
    fn wait(&self, at_most: Duration) -> Result<(), Stopped> {
        let end = Instant::now() + at_most;
        while !self.listened() {
            if Instant::now() >= end {
                self.outlets.log(Level::Info, "nobody subscribes: published all the same");
                return Ok(());
            }
            self.sleep(Duration::from_millis(20))?;
        }
        self.sleep(SETTLE)
    }

    fn listened(&self) -> bool {
        let watch = &self.ros.watch;
        [&watch.clock, &watch.state, &watch.particles, &watch.diagnostics].into_iter().any(Watch::listened)
    }

    fn sleep(&self, span: Duration) -> Result<(), Stopped> {
        if self.stop.1.recv_timeout(span).is_ok() { Err(Stopped) } else { Ok(()) }
    }

    /// Publishes all that is recorded, each thing at its time.
    fn once(&mut self) -> Result<Result<(), Stopped>, ReplayError> {
        let (mut pace, mut clock) = (None, None);
        let (mut frames, mut rows) = (0u64, 0u64);
        for item in Recording::open(&self.path)? {
            let item = item?;
            let time = item.time();
            let pace = pace.get_or_insert_with(|| Pace::new(self.settings.real_time_factor, Instant::now(), time));
            let left = pace.due(time).map_or(Duration::ZERO, |due| due.saturating_duration_since(Instant::now()));
            if self.sleep(left).is_err() {
                return Ok(Err(Stopped));
            }
            if let Some(lost) = pace.reached(Instant::now(), time)
                && self.behind.now()
            {
                self.outlets.log(Level::Warn, pace.behind(lost));
            }
            if self.same_name.once(self.ros.watch.same_name.load(Relaxed)) {
                self.outlets.log(Level::Warn, Watch::taken(&self.name));
            }
            // The time first: whoever gets a state at some time has the clock at that time.
            if clock.replace(time) != Some(time) && Watch::listened(&self.ros.watch.clock) {
                self.outlets.clock(Clock { clock: Time::from_seconds(time) });
            }
            match item {
                Item::Frame(frame) => {
                    frames += 1;
                    self.cloud(&frame);
                }
                Item::Row(row) => {
                    rows += 1;
                    if Watch::listened(&self.ros.watch.state) {
                        self.outlets.state(self.messages.state(&row));
                    }
                    if Watch::listened(&self.ros.watch.diagnostics) {
                        self.outlets.diagnostics(self.messages.diagnostics(&row));
                    }
                }
                Item::Event(event) => {
                    let level = match event.level {
                        record::Level::Info => Level::Info,
                        record::Level::Warning => Level::Warn,
                        record::Level::Error => Level::Error,
                    };
                    self.outlets.log(level, format!("t = {time} s: {}", event.text));
                }
                Item::Snapshot(_) => {}
            }
        }
        self.outlets.log(Level::Info, format!("replayed {frames} frames and {rows} states"));
        Ok(Ok(()))
    }

    fn cloud(&mut self, frame: &record::Frame) {
        // Tiles are spread over the time between this cloud and the one before.
        let between = self.frame.replace(frame.time).map(|before| frame.time - before).filter(|time| *time > 0.0);
        if !Watch::listened(&self.ros.watch.particles) {
            return;
        }
        let factor = self.settings.real_time_factor;
        let period = between.filter(|_| factor > 0.0).map_or(1.0 / 60.0, |time| time / factor);
        let (particles, point_step) = (self.messages.about().description.particles, self.messages.point_step());
        let stride = cloud::stride(&self.settings, particles, point_step);
        if !self.thinned
            && let Some(text) = cloud::thinned(&self.settings, particles, stride)
        {
            self.thinned = true;
            self.outlets.log(Level::Warn, text);
        }
        let message = cloud::thin(self.messages.cloud(frame), stride);
        self.outlets.cloud(Cloud { message, tiles: cloud::tiling(&self.settings, point_step, period) });
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::args::split;
    use matpoint::record::{Options, Recorder, sink_for};
    use matpoint::scene::Scene;

    #[test]
    fn what_has_no_effect_is_refused() {
        let scene = concat!(env!("CARGO_MANIFEST_DIR"), "/../../launch_scripts/scenes/cantilever.toml");
        let mut sim = Scene::load(scene).unwrap().build().unwrap();
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("run.mcap");
        let sink = sink_for(&path, &Options::default()).unwrap();
        Recorder::begin(&mut sim, vec![sink], None, None).unwrap().finish(&mut sim).unwrap();
        let fault = |path: &Path, args: &str| {
            let (_, ros) = split(args.split_whitespace().map(str::to_owned)).unwrap();
            Replay::start(path, &ros).err().unwrap().to_string()
        };
        let said = fault(&path, "--ros-args -p real_time_factor:=2.0 -p step:=0.1");
        assert!(said.starts_with("parameter `step` has no effect on a replay") && said.contains("real_time_factor"), "{said}");
        assert!(fault(&path, "--ros-args -p real_time_factor:=-1.0").contains("allowed is a number from 0"));
        assert!(fault(&path, "--ros-args -p rael_time_factor:=1.0").contains("did you mean `real_time_factor`?"));
        assert!(fault(&folder.path().join("none.mcap"), "").contains("cannot read"));
        std::fs::write(&path, "nothing").unwrap();
        assert!(fault(&path, "").contains("is no MCAP file"));
        if cfg!(not(feature = "rerun")) {
            assert!(fault(&folder.path().join("run.rrd"), "").contains("--features rerun"));
        }
    }
}
