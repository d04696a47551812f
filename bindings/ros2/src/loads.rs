//! External loads: which there are, what a command must look like, how long it holds.

use crate::interfaces::matpoint::{LoadCommand, LoadState};
use crate::interfaces::standard::{Header, Time, Vector3Stamped, WrenchStamped};
use crate::names::token;
use crate::parameters::Settings;
use matpoint::Simulation;
use matpoint::component::{Causality, ComponentError, Variable};

/// An external load of the scene.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Load {
    /// Name, as in the scene.
    pub name: String,
    /// `traction`, `pressure`, `body_force` or `force`.
    pub kind: String,
    /// Name of the variable.
    pub variable: String,
    /// Number of values.
    pub components: usize,
}

impl Load {
    /// The external loads among the variables of a simulation.
    pub fn all(variables: &[Variable]) -> Vec<Self> {
        let inputs = variables.iter().filter(|v| v.causality == Causality::Input);
        inputs
            .filter_map(|v| {
                let (name, kind) = v.name.strip_prefix("load/")?.rsplit_once('/')?;
                Some(Self { name: name.into(), kind: kind.into(), variable: v.name.clone(), components: v.len() })
            })
            .collect()
    }

    /// Its topic.
    pub fn topic(&self) -> String {
        format!("~/load/{}", token(&self.name))
    }
}

/// A command that was found good.
#[derive(Debug, Clone, PartialEq)]
pub struct Command {
    /// The load, by its place in the list.
    pub load: usize,
    /// Value, in the unit of the load.
    pub value: Vec<f64>,
    /// Simulated time for which it holds \[s\], if it says so itself.
    pub hold: Option<f64>,
    /// Its stamp.
    pub stamp: Time,
}

impl Command {
    /// Whether it answers a state from before `time` \[s\]. One without a stamp answers none, and neither does one with the time of the wall.
    pub fn late(&self, time: f64) -> bool {
        let now = Time::from_seconds(time);
        self.stamp != Time::default() && (self.stamp.sec, self.stamp.nanosec) < (now.sec, now.nanosec)
    }
}

/// Why a command is not applied.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Refusal {
    /// NaN or infinity.
    #[error("a value is not finite")]
    NotFinite,
    /// Another frame.
    #[error("frame `{found}`, not `{expected}`")]
    Frame {
        /// As received.
        found: String,
        /// The one of this node.
        expected: String,
    },
    /// Too many or too few values.
    #[error("load `{load}` takes {expected} values, not {found}")]
    Size {
        /// Load.
        load: String,
        /// Values it takes.
        expected: usize,
        /// Values given, up to the last that is not zero where the message has three.
        found: usize,
    },
    /// No such load.
    #[error("no external load `{name}`; there are: {known}")]
    Unknown {
        /// As received.
        name: String,
        /// Names of all.
        known: String,
    },
    /// Another kind.
    #[error("load `{load}` is a {expected}, not a {found}")]
    Kind {
        /// Load.
        load: String,
        /// Its kind.
        expected: String,
        /// Kind given.
        found: String,
    },
    /// A torque on a particle.
    #[error("a load acts on a point: it takes no torque")]
    Torque,
    /// A negative hold time.
    #[error("the hold time is {0} s; it must be 0 or more")]
    Hold(f64),
    /// In lock-step: the state that it answers had its command.
    #[error("it answers the state of {0} s, which has had its command")]
    Late(f64),
    /// Bytes that are no message.
    #[error("bytes that are no message of this type")]
    Malformed,
}

/// What a message must agree with.
#[derive(Debug, Clone)]
pub struct Rules {
    /// The external loads.
    pub loads: Vec<Load>,
    /// Frame of the node.
    pub frame: String,
}

impl Rules {
    /// Checks a vector for load number `load`.
    ///
    /// # Errors
    /// What is wrong with it.
    pub fn vector(&self, load: usize, message: &Vector3Stamped) -> Result<Command, Refusal> {
        self.three(load, &message.header, message.vector.array())
    }

    /// Checks a wrench for load number `load`.
    ///
    /// # Errors
    /// What is wrong with it.
    pub fn wrench(&self, load: usize, message: &WrenchStamped) -> Result<Command, Refusal> {
        if message.wrench.torque.array() != [0.0; 3] {
            return Err(Refusal::Torque);
        }
        self.three(load, &message.header, message.wrench.force.array())
    }

    /// Checks a command that names its load.
    ///
    /// # Errors
    /// What is wrong with it.
    pub fn named(&self, message: &LoadCommand) -> Result<Command, Refusal> {
        let load = self.loads.iter().position(|l| l.name == message.name).ok_or_else(|| Refusal::Unknown {
            name: message.name.clone(),
            known: self.loads.iter().map(|l| l.name.as_str()).collect::<Vec<_>>().join(", "),
        })?;
        let known = &self.loads[load];
        if !message.kind.is_empty() && message.kind != known.kind {
            return Err(Refusal::Kind { load: known.name.clone(), expected: known.kind.clone(), found: message.kind.clone() });
        }
        if !(message.hold >= 0.0 && message.hold.is_finite()) {
            return Err(Refusal::Hold(message.hold));
        }
        let hold = (message.hold > 0.0).then_some(message.hold);
        self.command(load, &message.header, message.value.clone(), hold)
    }

    fn three(&self, load: usize, header: &Header, value: [f64; 3]) -> Result<Command, Refusal> {
        // Components that the scene does not have must be zero.
        let used = value.iter().rposition(|v| *v != 0.0).map_or(0, |last| last + 1);
        self.command(load, header, value[..used.max(self.loads[load].components)].to_vec(), None)
    }

    fn command(&self, load: usize, header: &Header, value: Vec<f64>, hold: Option<f64>) -> Result<Command, Refusal> {
        let known = &self.loads[load];
        if !header.frame_id.is_empty() && header.frame_id != self.frame {
            return Err(Refusal::Frame { found: header.frame_id.clone(), expected: self.frame.clone() });
        }
        if value.iter().any(|v| !v.is_finite()) {
            return Err(Refusal::NotFinite);
        }
        if value.len() != known.components {
            return Err(Refusal::Size { load: known.name.clone(), expected: known.components, found: value.len() });
        }
        Ok(Command { load, value, hold, stamp: header.stamp.clone() })
    }
}

/// A command under way.
#[derive(Debug, Clone, PartialEq)]
struct Held {
    value: Vec<f64>,
    /// Simulated time after which it has timed out \[s\].
    until: f64,
}

/// The loads with the commands under way.
pub struct Loads {
    all: Vec<Load>,
    held: Vec<Option<Held>>,
    /// Times at which a command timed out since the start.
    pub timeouts: u64,
    timed_out: Vec<bool>,
}

impl Loads {
    /// Without commands.
    pub fn new(all: Vec<Load>) -> Self {
        let (held, timed_out) = (vec![None; all.len()], vec![true; all.len()]);
        Self { all, held, timeouts: 0, timed_out }
    }

    /// Takes a command at simulated time `time`.
    pub fn command(&mut self, command: Command, time: f64, settings: &Settings) {
        let hold = command.hold.or(Some(settings.timeout).filter(|t| *t > 0.0)).unwrap_or(f64::INFINITY);
        self.held[command.load] = Some(Held { value: command.value, until: time + hold });
        self.timed_out[command.load] = false;
    }

    /// Forgets the command for a variable, because it was set otherwise.
    pub fn forget(&mut self, variable: &str) {
        if let Some(load) = self.all.iter().position(|l| l.variable == variable) {
            (self.held[load], self.timed_out[load]) = (None, true);
        }
    }

    /// Forgets all commands: after a reset or a restored snapshot.
    pub fn forget_all(&mut self) {
        self.held.fill(None);
        self.timed_out.fill(true);
    }

    /// Sets the values for the step that starts now.
    ///
    /// # Errors
    /// Never, for commands that were found good.
    pub fn apply(&mut self, sim: &mut Simulation, settings: &Settings) -> Result<(), ComponentError> {
        let now = sim.time();
        for (i, load) in self.all.iter().enumerate() {
            let Some(held) = &self.held[i] else { continue };
            // Round-off of many steps must not end a command a step early or late.
            let over = now - held.until + 1e-6 * settings.step;
            let gone = over >= 0.0;
            self.timeouts += u64::from(gone && !self.timed_out[i]);
            self.timed_out[i] = gone;
            let share = match (gone, settings.hold_after) {
                (false, _) | (true, true) => 1.0,
                (true, false) if settings.decay > 0.0 => (1.0 - over / settings.decay).clamp(0.0, 1.0),
                (true, false) => 0.0,
            };
            let value: Vec<f64> = held.value.iter().map(|v| share * v).collect();
            if sim.get(&load.variable)? != value {
                sim.set(&load.variable, &value)?;
            }
            if share == 0.0 {
                self.held[i] = None;
            }
        }
        Ok(())
    }

    /// What they do, for messages.
    ///
    /// # Errors
    /// Never, for variables that there are.
    pub fn states(&self, sim: &mut Simulation) -> Result<Vec<LoadState>, ComponentError> {
        let state = |(i, load): (usize, &Load)| {
            let value = sim.get(&load.variable)?.to_vec();
            Ok(LoadState { name: load.name.clone(), kind: load.kind.clone(), value, timed_out: self.timed_out[i] })
        };
        self.all.iter().enumerate().map(state).collect()
    }

    /// The loads.
    pub fn all(&self) -> &[Load] {
        &self.all
    }
}

#[cfg(test)]
#[path = "loads_tests.rs"]
mod tests;
