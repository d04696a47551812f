//! The loop: owns the simulation, steps it at its pace, answers requests between steps, hands on what is to be published.

use crate::args::Level;
use crate::cloud::{self, Layout};
use crate::diagnostics::Tally;
use crate::graph::Watch;
use crate::inbox::Request;
use crate::interfaces::standard::{Clock, Header, Time};
use crate::loads::{Command, Load, Loads, Refusal};
use crate::pace::{Pace, Ticker};
use crate::parameters::{Parameters, Settings};
use crate::publish::{Cloud, Outlets};
use crate::state::Watched;
use matpoint::Simulation;
use matpoint::component::{ComponentError, Description};
use matpoint::record::{self, Recorder};
use std::sync::Arc;
use std::sync::atomic::Ordering::Relaxed;
use std::sync::mpsc::{Receiver, RecvTimeoutError};
use std::time::{Duration, Instant};

/// Requests that may come before a step that is due.
const REQUESTS_A_STEP: usize = 64;

/// Diagnostics each so often; where time stands still, topics too, so that who comes late sees something.
const HEARTBEAT: Duration = Duration::from_secs(1);

/// States of `simulation_interfaces`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[expect(missing_docs, reason = "the standard says it")]
pub enum Running {
    Stopped = 0,
    Playing = 1,
    Paused = 2,
    Quitting = 3,
}

/// Steps asked for while paused.
pub struct Stepping {
    /// Steps done.
    pub done: u64,
    /// Steps asked for.
    pub total: u64,
    /// Called after each step; tells whether to go on.
    pub progress: Box<dyn FnMut(u64, u64) -> bool + Send>,
    /// Called at the end, with what stopped it early.
    pub finish: Box<dyn FnOnce(Result<(), String>) + Send>,
}

/// Everything that the loop owns.
pub struct Session {
    /// The simulation.
    pub sim: Simulation,
    /// What it is.
    pub description: Description,
    /// The parameters.
    pub parameters: Parameters,
    /// The loads with their commands.
    pub loads: Loads,
    /// Whether time moves.
    pub running: Running,
    /// The way out.
    pub outlets: Outlets,
    /// What is counted and told in diagnostics.
    pub tally: Arc<Tally>,
    /// Full name of the node.
    pub name: String,
    /// Communication steps since start, reset or restore.
    pub steps: u64,
    /// Why the simulation cannot go on.
    pub fault: Option<String>,
    /// Recording under way and where it goes.
    pub recording: Option<(String, Recorder<'static>)>,
    stepping: Option<Stepping>,
    watch: Arc<Watch>,
    substeps: u64,
    heartbeat: Instant,
    /// No step since the last heartbeat.
    stood: bool,
    pace: Pace,
    tickers: [Ticker; 2],
    layout: Layout,
    watched: Watched,
    /// Load commands that wait for their step, in lock-step.
    triggered: u64,
    /// A larger cloud than allowed was thinned out, and that was said.
    thinned: bool,
}

impl Session {
    /// Ready to run.
    pub fn new(sim: Simulation, parameters: Parameters, outlets: Outlets, watch: Arc<Watch>, tally: Arc<Tally>, name: String) -> Self {
        let description = sim.describe();
        let settings = &parameters.settings;
        Self {
            running: if settings.paused { Running::Paused } else { Running::Playing },
            loads: Loads::new(Load::all(&description.variables)),
            watched: Watched::new(&description.variables),
            layout: Layout::new(&settings.fields),
            pace: Pace::new(settings.real_time_factor, Instant::now(), sim.time()),
            tickers: Default::default(),
            stepping: None,
            recording: None,
            fault: None,
            steps: 0,
            substeps: 0,
            heartbeat: Instant::now(),
            stood: true,
            triggered: 0,
            thinned: false,
            sim,
            description,
            parameters,
            outlets,
            watch,
            tally,
            name,
        }
    }

    fn settings(&self) -> &Settings {
        &self.parameters.settings
    }

    /// Runs until it is told to quit or nobody is left who could tell.
    pub fn run(&mut self, inbox: &Receiver<Request>) {
        if let Err(error) = self.follow_record_parameter() {
            self.outlets.log(Level::Error, error);
        }
        self.resume();
        while self.running != Running::Quitting {
            self.turn(inbox);
        }
        self.finish_stepping(Err("the simulator is quitting".into()));
        if let Err(error) = self.end_recording() {
            self.outlets.log(Level::Error, error);
        }
    }

    /// One turn of the loop: the requests that came in, and a step if one is due; waits until there is something to do.
    pub fn turn(&mut self, inbox: &Receiver<Request>) {
        if Instant::now() >= self.heartbeat {
            self.heartbeat = Instant::now() + HEARTBEAT;
            self.beat();
        }
        for _ in 0..REQUESTS_A_STEP {
            // In lock-step each command has a step of its own.
            if self.triggered > 0 || self.running == Running::Quitting {
                break;
            }
            let until = self.due().map_or(self.heartbeat, |due| due.min(self.heartbeat));
            match inbox.recv_timeout(until.saturating_duration_since(Instant::now())) {
                Ok(request) => request(self),
                Err(RecvTimeoutError::Timeout) => break,
                Err(RecvTimeoutError::Disconnected) => self.running = Running::Quitting,
            }
        }
        if self.due().is_some_and(|due| due <= Instant::now()) {
            self.advance();
        }
    }

    /// When the next step is due; `None` while time stands still.
    fn due(&self) -> Option<Instant> {
        let now = Instant::now;
        match self.running {
            _ if self.stepping.is_some() => Some(now()),
            Running::Playing if self.settings().lock_step => (self.triggered > 0).then(now),
            // A step is due when the time at which it starts has come: commands up to then take part in it.
            Running::Playing => Some(self.pace.due(self.sim.time()).unwrap_or_else(now)),
            _ => None,
        }
    }

    /// One communication step.
    pub fn advance(&mut self) {
        self.triggered = self.triggered.saturating_sub(1);
        self.stood = false;
        let result = self.loads.apply(&mut self.sim, &self.parameters.settings).map_err(|error| error.to_string());
        match result.and_then(|()| self.sim.step(self.parameters.settings.step).map_err(|error| error.to_string())) {
            Ok(report) => {
                self.steps += 1;
                self.substeps += report.substeps;
                if let Some(lost) = self.pace.reached(Instant::now(), report.time)
                    && self.running == Running::Playing
                    && !self.settings().lock_step
                {
                    self.behind(lost);
                }
                self.record();
                self.publish(false);
                self.progress();
            }
            Err(error) => {
                self.outlets.log(Level::Error, format!("{error}; paused"));
                self.running = Running::Paused;
                self.finish_stepping(Err(error.clone()));
                if let Some((_, recorder)) = &mut self.recording {
                    // A recording that cannot be written is told of when the next state is offered to it.
                    let _ = recorder.event(&self.sim, record::Level::Error, &error);
                }
                self.fault = Some(error);
            }
        }
    }

    fn behind(&self, lost: f64) {
        if self.tally.behind.now() {
            self.outlets.log(Level::Warn, self.pace.behind(lost));
        }
    }

    fn progress(&mut self) {
        let Some(stepping) = &mut self.stepping else { return };
        stepping.done += 1;
        let go_on = (stepping.progress)(stepping.done, stepping.total);
        if stepping.done >= stepping.total {
            self.finish_stepping(Ok(()));
        } else if !go_on {
            self.finish_stepping(Err("cancelled".into()));
        }
    }

    /// Starts a number of steps while paused.
    pub fn start_stepping(&mut self, stepping: Stepping) {
        let refusal = match (self.running, &self.stepping) {
            (Running::Paused, None) if stepping.total > 0 => None,
            (Running::Paused, None) => Some("no steps asked for"),
            (Running::Paused, Some(_)) => Some("steps of another call are under way"),
            _ => Some("the simulation is not paused"),
        };
        match refusal {
            None => self.stepping = Some(stepping),
            Some(why) => (stepping.finish)(Err(why.into())),
        }
    }

    /// Ends steps under way.
    pub fn finish_stepping(&mut self, how: Result<(), String>) {
        if let Some(stepping) = self.stepping.take() {
            (stepping.finish)(how);
        }
    }

    /// Goes on from here at the pace asked for: after a pause, a jump in time or a change of parameters.
    pub fn resume(&mut self) {
        self.pace.restart(self.settings().real_time_factor, Instant::now(), self.sim.time());
        self.triggered = 0;
        self.layout = Layout::new(&self.settings().fields);
    }

    /// Takes a load command that came on `topic`; in lock-step it brings a step with it.
    pub fn command(&mut self, topic: &str, command: Command) {
        let (time, steps) = (self.sim.time(), self.settings().lock_step && self.running == Running::Playing);
        // A state that was sent twice may get two answers: with a step for each, every later command would come a step late.
        if steps && command.late(time) {
            return self.tally.refuse(topic, &Refusal::Late(command.stamp.seconds()));
        }
        self.tally.taken.fetch_add(1, Relaxed);
        self.loads.command(command, time, &self.parameters.settings);
        self.triggered += u64::from(steps);
    }

    /// Back to time 0.
    pub fn reset(&mut self) {
        self.finish_stepping(Err("the simulation was reset".into()));
        self.sim.reset();
        self.jumped();
    }

    /// Time has jumped.
    pub fn jumped(&mut self) {
        self.loads.forget_all();
        (self.steps, self.substeps, self.fault) = (0, 0, None);
        self.tickers = Default::default();
        self.resume();
        self.record();
        self.publish(true);
    }

    /// Stamp and frame of all that is published now.
    pub fn header(&self) -> Header {
        Header { stamp: Time::from_seconds(self.sim.time()), frame_id: self.settings().frame_id.clone() }
    }

    /// Real-time factor of late \[-\].
    pub fn real_time_factor(&self) -> f64 {
        let moves = self.running == Running::Playing || self.stepping.is_some();
        if moves { self.pace.measured() } else { 0.0 }
    }

    /// Wall time given up because the pace could not be kept \[s\].
    pub fn lost(&self) -> f64 {
        self.pace.lost
    }

    /// Publishes what is due, to those who listen; `all` whether due or not.
    fn publish(&mut self, all: bool) {
        let (now, time) = (Instant::now(), self.sim.time());
        if Watch::listened(&self.watch.clock) {
            self.outlets.clock(Clock { clock: Time::from_seconds(time) });
        }
        let settings = &self.parameters.settings;
        // What is not tied to the wall is published by the wall, but in lock-step whoever waits for a state must get it.
        let factor = if settings.lock_step || self.stepping.is_some() { 0.0 } else { settings.real_time_factor };
        let state_rate = if settings.lock_step { 0.0 } else { settings.state_rate };
        let mut outcome = Ok(());
        if Watch::listened(&self.watch.state) && (self.tickers[0].due(state_rate, factor, now, time) || all) {
            outcome = outcome.and(self.publish_state());
        }
        if Watch::listened(&self.watch.particles) && (self.tickers[1].due(self.settings().particles_rate, factor, now, time) || all) {
            outcome = outcome.and(self.publish_cloud());
        }
        if let Err(error) = outcome {
            self.outlets.log(Level::Warn, error.to_string());
        }
    }

    fn publish_state(&mut self) -> Result<(), ComponentError> {
        let header = self.header();
        let mut state = self.watched.state(&mut self.sim, &self.loads, header)?;
        (state.steps, state.substeps, state.real_time_factor) = (self.steps, self.substeps, self.real_time_factor());
        self.outlets.state(state);
        Ok(())
    }

    fn publish_cloud(&mut self) -> Result<(), ComponentError> {
        let (particles, dimension) = (self.description.particles, self.description.dimension);
        let settings = &self.parameters.settings;
        let stride = cloud::stride(settings, particles, self.layout.point_step());
        if !self.thinned
            && let Some(text) = cloud::thinned(settings, particles, stride)
        {
            self.thinned = true;
            self.outlets.log(Level::Warn, text);
        }
        let period = match (settings.particles_rate, settings.real_time_factor) {
            (rate, _) if rate > 0.0 => 1.0 / rate,
            (_, factor) if factor > 0.0 => settings.step / factor,
            _ => 1.0 / 60.0,
        };
        let tiles = cloud::tiling(settings, self.layout.point_step(), period);
        let header = self.header();
        let message = self.layout.build(&mut self.sim, dimension, stride, header)?;
        self.outlets.cloud(Cloud { message, tiles });
        Ok(())
    }

    fn beat(&mut self) {
        if self.tally.same_name.once(self.watch.same_name.load(Relaxed)) {
            self.outlets.log(Level::Warn, Watch::taken(&self.name));
        }
        self.tally.say(&self.outlets);
        // In lock-step time does not stand still because a step waits for its command just now.
        if self.due().is_none() && std::mem::replace(&mut self.stood, true) {
            self.publish(true);
        }
        if Watch::listened(&self.watch.diagnostics) {
            let message = crate::diagnostics::message(self);
            self.outlets.diagnostics(message);
        }
    }

    /// Whether another node has the same name.
    pub fn same_name(&self) -> bool {
        self.watch.same_name.load(Relaxed)
    }
}
