//! `/diagnostics`, and what is said now and then on `/rosout`.

use crate::args::Level;
use crate::interfaces::standard::{DiagnosticArray, DiagnosticStatus, Header, KeyValue, Time};
use crate::loads::Refusal;
use crate::publish::Outlets;
use crate::session::Session;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering::Relaxed};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant, SystemTime};

/// Warnings of one kind come at most this often.
const SELDOM: Duration = Duration::from_secs(5);

/// Says something not too often.
#[derive(Debug, Default)]
pub struct Seldom(Mutex<Option<Instant>>);

impl Seldom {
    /// Whether to say it now.
    pub fn now(&self) -> bool {
        let mut last = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let now = last.is_none_or(|last| last.elapsed() >= SELDOM);
        if now {
            *last = Some(Instant::now());
        }
        now
    }
}

/// Says something when it begins.
#[derive(Debug, Default)]
pub struct Edge(AtomicBool);

impl Edge {
    /// Whether `is` has become true since the last call.
    pub fn once(&self, is: bool) -> bool {
        !self.0.swap(is, Relaxed) && is
    }
}

/// What is counted.
#[derive(Debug, Default)]
pub struct Tally {
    /// Load commands taken.
    pub taken: AtomicU64,
    /// Load commands refused.
    pub refused: AtomicU64,
    said: AtomicU64,
    told: AtomicU64,
    last: Mutex<Option<String>>,
    /// The pace cannot be kept.
    pub behind: Seldom,
    /// The name is taken.
    pub same_name: Edge,
}

impl Tally {
    /// Counts a refused command.
    pub fn refuse(&self, topic: &str, refusal: &Refusal) {
        self.refused.fetch_add(1, Relaxed);
        *self.last.lock().unwrap_or_else(PoisonError::into_inner) = Some(format!("{topic}: {refusal}"));
    }

    /// Tells of commands refused since the last call.
    pub fn say(&self, outlets: &Outlets) {
        let refused = self.refused.load(Relaxed);
        let new = refused - self.said.swap(refused, Relaxed);
        let last = self.last.lock().unwrap_or_else(PoisonError::into_inner).take();
        if let (1.., Some(last)) = (new, last) {
            outlets.log(Level::Warn, format!("refused {new} load commands; the last: {last}"));
        }
    }

    /// Commands refused since the last message.
    fn news(&self) -> u64 {
        let refused = self.refused.load(Relaxed);
        refused - self.told.swap(refused, Relaxed)
    }
}

/// How the simulation fares.
pub fn message(session: &Session) -> DiagnosticArray {
    let (tally, counts) = (&session.tally, session.outlets.counts());
    let refused = tally.news();
    let asked = session.parameters.settings.real_time_factor;
    let (reached, lock_step) = (session.real_time_factor(), session.parameters.settings.lock_step);
    let (level, text) = match &session.fault {
        Some(fault) => (2, fault.clone()),
        None if session.same_name() => (1, format!("another node is named {}", session.name)),
        None if refused > 0 => (1, format!("refused {refused} load commands")),
        None if !lock_step && asked > 0.0 && reached > 0.0 && reached < 0.95 * asked => {
            (1, format!("real-time factor {reached:.3}, not {asked}"))
        }
        None => (0, format!("{:?}", session.running).to_lowercase()),
    };
    let values = [
        ("state", format!("{:?}", session.running).to_lowercase()),
        ("time [s]", session.sim.time().to_string()),
        ("communication steps", session.steps.to_string()),
        ("particles", session.description.particles.to_string()),
        ("real-time factor", format!("{reached:.4}")),
        ("real-time factor asked for", asked.to_string()),
        ("wall time given up [s]", format!("{:.3}", session.lost())),
        ("load commands taken", tally.taken.load(Relaxed).to_string()),
        ("load commands refused", tally.refused.load(Relaxed).to_string()),
        ("load commands timed out", session.loads.timeouts.to_string()),
        ("messages published", counts.published.load(Relaxed).to_string()),
        ("messages replaced by newer ones", counts.replaced.load(Relaxed).to_string()),
        ("messages without room", counts.no_room.load(Relaxed).to_string()),
    ];
    let status = DiagnosticStatus {
        level,
        name: format!("{}: simulation", session.name.trim_start_matches('/')),
        message: text,
        hardware_id: session.description.title.clone(),
        values: values.map(|(key, value)| KeyValue { key: key.into(), value }).into(),
    };
    let now = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH).unwrap_or_default().as_secs_f64();
    // Wall time: diagnostics are about the machine, and must be fresh while the simulation is paused.
    DiagnosticArray { header: Header { stamp: Time::from_seconds(now), frame_id: String::new() }, status: vec![status] }
}
