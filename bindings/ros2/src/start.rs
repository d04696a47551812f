//! From a scene and ROS arguments to a running loop.

use crate::args::{ArgsError, RosArgs};
use crate::diagnostics::Tally;
use crate::inbox::{Inbox, Request, inbox};
use crate::interfaces::matpoint::{LoadCommand, SceneDescription};
use crate::interfaces::standard::{Vector3Stamped, WrenchStamped};
use crate::loads::{Command, Load, Refusal, Rules};
use crate::names::Names;
use crate::network::{Network, NetworkError};
use crate::node::{NodeError, Quality, Receiving, Ros};
use crate::parameters::{Mode, ParameterError, Parameters, Settings};
use crate::publish::{Outlets, Publishers};
use crate::session::Session;
use crate::{action, cloud, control, parameter_services, recording, services};
use matpoint::Simulation;
use std::sync::Arc;
use std::sync::mpsc::Receiver;
use std::time::Duration;

/// How long a patient publisher waits for room before it asks whether it still should.
const TRY: Duration = Duration::from_millis(100);

/// The node cannot start.
#[derive(Debug, thiserror::Error)]
pub enum StartError {
    /// ROS arguments.
    #[error(transparent)]
    Args(#[from] ArgsError),
    /// A parameter.
    #[error(transparent)]
    Parameter(#[from] ParameterError),
    /// A variable of the environment.
    #[error(transparent)]
    Network(#[from] NetworkError),
    /// The graph.
    #[error(transparent)]
    Node(#[from] NodeError),
}

/// A node that has joined the graph.
pub struct Started {
    /// The loop.
    pub session: Session,
    /// Requests for it.
    pub requests: Receiver<Request>,
    /// The way to bring requests.
    pub inbox: Inbox,
    ros: Ros,
    receiving: Receiving,
}

/// Joins the graph with a simulation.
///
/// # Errors
/// Arguments, parameters or variables that make no sense; DDS refuses.
pub fn start(sim: Simulation, args: &RosArgs) -> Result<Started, StartError> {
    let names = Names::new("/", "matpoint", args.remaps.clone())?;
    let parameters = parameters(args, &names)?;
    let network = Network::read(|name| std::env::var(name).ok())?;
    let (inbox, requests) = inbox();
    let mut ros = Ros::open(names.clone(), &network, inbox.clone())?;
    let description = sim.describe();
    let (settings, tally) = (parameters.settings.clone(), Arc::<Tally>::default());
    let point_step = cloud::Layout::new(&crate::parameters::FIELDS.map(str::to_owned)).point_step();
    let publishers = publishers(&mut ros, &settings, description.particles, point_step, false)?;
    let scene = SceneDescription::new(&description, env!("CARGO_PKG_VERSION"), &settings.frame_id);
    publishers.scene.publish(scene).map_err(NodeError::dds("~/scene"))?;
    let outlets = Outlets::new(publishers, args.level, names.node().to_owned()).map_err(NodeError::Thread)?;
    let rules = Arc::new(Rules { loads: Load::all(&description.variables), frame: settings.frame_id });
    subscribe(&mut ros, &rules, &tally)?;
    parameter_services::serve(&mut ros)?;
    control::serve(&mut ros)?;
    services::serve(&mut ros)?;
    recording::serve(&mut ros)?;
    action::serve(&mut ros)?;
    ros.follow()?;
    let session = Session::new(sim, parameters, outlets, ros.watch.clone(), tally, names.full());
    network.warnings().for_each(|text| session.outlets.log(crate::args::Level::Warn, text));
    let receiving = ros.start()?;
    Ok(Started { session, requests, inbox, ros, receiving })
}

impl Started {
    /// Runs until told to quit, then leaves the graph.
    pub fn run(mut self) {
        self.session.run(&self.requests);
        self.close();
    }

    /// Leaves the graph: first the publishers, then services and subscriptions, then the node, at last the participant.
    pub fn close(self) {
        let Self { session, requests, inbox, ros, receiving } = self;
        drop((session, requests, inbox));
        ros.close(receiving);
    }
}

/// The parameters that a node of these names is given.
///
/// # Errors
/// A file that cannot be read; a parameter that there is not, or cannot have the value.
pub fn parameters(args: &RosArgs, names: &Names) -> Result<Parameters, StartError> {
    let mut parameters = Parameters::default();
    for change in args.overrides(names)? {
        match parameters.set(vec![(change.name, change.value)], true) {
            // A wildcard gives all nodes the parameters of any.
            Err(ParameterError::Unknown { .. }) if !change.exact => {}
            other => other?,
        }
    }
    Ok(parameters)
}

/// The publishers of a node, for clouds of at most `particles` points of `point_step` bytes. Those of a `patient` one wait for room.
///
/// # Errors
/// A remap to what is no name; DDS refuses.
pub fn publishers(ros: &mut Ros, settings: &Settings, particles: usize, point_step: usize, patient: bool) -> Result<Publishers, NodeError> {
    let most = match settings.mode {
        Mode::Whole => particles * point_step,
        Mode::Strided | Mode::Tiles => settings.max_bytes,
    };
    // Answers come each 0.1 s. Who goes as fast as he may sends so many at once, and a receiver with default buffers loses what is more.
    let at_once = if patient && settings.real_time_factor == 0.0 { 8 } else { 256 };
    // A reliable subscriber that does not answer costs at most this much memory.
    let unanswered = ((32 << 20) / most.max(1)).clamp(8, at_once);
    let tiles = if settings.mode == Mode::Tiles { (particles * point_step).div_ceil(settings.max_bytes) } else { 1 };
    let quality = Quality { patience: if patient { TRY } else { Duration::ZERO }, ..Quality::RELIABLE };
    let cloud = Quality { reliable: settings.particles_reliable, depth: 5 * tiles, unanswered: unanswered.max(5 * tiles), ..quality };
    let state = Quality { reliable: settings.state_reliable, ..quality };
    let latched = Quality { latched: true, depth: 1, ..quality };
    Ok(Publishers {
        clock: ros.publisher("/clock", "rosgraph_msgs", "Clock", quality)?,
        state: ros.publisher("~/state", "matpoint_msgs", "ComponentState", state)?,
        particles: ros.publisher("~/particles", "sensor_msgs", "PointCloud2", cloud)?,
        diagnostics: ros.publisher("/diagnostics", "diagnostic_msgs", "DiagnosticArray", quality)?,
        parameter_events: ros.publisher("/parameter_events", "rcl_interfaces", "ParameterEvent", quality)?,
        scene: ros.publisher("~/scene", "matpoint_msgs", "SceneDescription", latched)?,
        log: ros.logger(),
    })
}

/// Commands are checked where they come in; only good ones reach the loop.
fn subscribe(ros: &mut Ros, rules: &Arc<Rules>, tally: &Arc<Tally>) -> Result<(), NodeError> {
    let take = |topic: String| {
        let tally = tally.clone();
        move |checked: Result<Command, Refusal>| -> Option<Request> {
            match checked {
                Ok(command) => {
                    let topic = topic.clone();
                    Some(Box::new(move |session: &mut Session| session.command(&topic, command)))
                }
                Err(refusal) => {
                    tally.refuse(&topic, &refusal);
                    None
                }
            }
        }
    };
    for (i, load) in rules.loads.iter().enumerate() {
        let (topic, rules) = (load.topic(), rules.clone());
        let take = take(topic.clone());
        if load.kind == "force" {
            ros.subscribe(&topic, "geometry_msgs", "WrenchStamped", move |message: Option<WrenchStamped>| {
                take(message.ok_or(Refusal::Malformed).and_then(|message| rules.wrench(i, &message)))
            })?;
        } else {
            ros.subscribe(&topic, "geometry_msgs", "Vector3Stamped", move |message: Option<Vector3Stamped>| {
                take(message.ok_or(Refusal::Malformed).and_then(|message| rules.vector(i, &message)))
            })?;
        }
    }
    let (take, rules) = (take("~/command".into()), rules.clone());
    ros.subscribe("~/command", "matpoint_msgs", "LoadCommand", move |message: Option<LoadCommand>| {
        take(message.ok_or(Refusal::Malformed).and_then(|message| rules.named(&message)))
    })
}
