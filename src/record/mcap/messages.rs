//! What is recorded as the messages that the ROS 2 node publishes: `.mcap` recordings hold them, and the node sends them when it replays one.

use super::super::data::{About, Event, Frame, Level, Row};
use super::layout::Layout;
use crate::messages::*;
use std::sync::Arc;

/// Makes the messages of a recording. Stamps are simulated time, the frame is that of the recording.
pub struct Messages {
    about: Arc<About>,
    layout: Layout,
}

impl Messages {
    /// Those of a recording of `about`.
    pub fn new(about: Arc<About>) -> Self {
        let layout = Layout::new(&about);
        Self { about, layout }
    }

    /// What the recording is of.
    pub fn about(&self) -> &About {
        &self.about
    }

    /// Bytes of a point in [`cloud`](Self::cloud).
    pub fn point_step(&self) -> usize {
        self.layout.point_step()
    }

    /// What was simulated: `~/scene`.
    pub fn scene(&self) -> SceneDescription {
        SceneDescription::new(&self.about.description, &self.about.version, &self.about.ros.frame)
    }

    /// All particles with all columns that were recorded: `~/particles`.
    pub fn cloud(&self, frame: &Frame) -> PointCloud2 {
        self.layout.cloud(self.header(frame.time), frame)
    }

    /// Energies, probes, reactions, loads: `~/state`.
    pub fn state(&self, row: &Row) -> ComponentState {
        let about = &self.about;
        let mut state = ComponentState { header: self.header(row.time), steps: row.count, substeps: row.step, ..Default::default() };
        for (series, values) in about.series.iter().zip(&row.values) {
            match said(&series.variable) {
                Some(Said::Energy(0)) => state.kinetic_energy = values[0],
                Some(Said::Energy(1)) => state.strain_energy = values[0],
                Some(Said::Energy(2)) => state.external_work = values[0],
                Some(Said::Energy(_)) => state.total_energy = values[0],
                Some(Said::Momentum) => state.momentum = Vector3::from_slice(values),
                Some(Said::RealTimeFactor) => state.real_time_factor = values[0],
                Some(Said::Probe(name, quantity)) => {
                    if state.probes.last().is_none_or(|p| p.name != name) {
                        state.probes.push(Probe { name: name.into(), ..Default::default() });
                    }
                    if let Some(probe) = state.probes.last_mut() {
                        match quantity {
                            0 => probe.position = Point::from_slice(values),
                            1 => probe.displacement = Vector3::from_slice(values),
                            2 => probe.velocity = Vector3::from_slice(values),
                            // A row of a file that was cut off may lack some.
                            _ => probe.stress.iter_mut().zip(values).for_each(|(to, &value)| *to = value),
                        }
                    }
                }
                Some(Said::Reaction(name)) => state.reactions.push(Reaction { name: name.into(), force: Vector3::from_slice(values) }),
                None => {}
            }
        }
        for (input, values) in about.inputs.iter().zip(&row.values[about.series.len()..]) {
            let name = input.name.trim_start_matches("load/");
            let (name, kind) = name.rsplit_once('/').unwrap_or((name, ""));
            state.loads.push(LoadState { name: name.into(), kind: kind.into(), value: values.clone(), timed_out: false });
        }
        state
    }

    /// What a state message has no field for: errors, angular momentum, step size and so on. As text, which reads back as the same number:
    /// `/diagnostics`.
    pub fn diagnostics(&self, row: &Row) -> DiagnosticArray {
        let rest = self.about.series.iter().zip(&row.values).filter(|(series, _)| said(&series.variable).is_none());
        let values = rest.map(|(series, values)| KeyValue {
            key: if series.unit.is_empty() { series.variable.clone() } else { format!("{} [{}]", series.variable, series.unit) },
            value: values.iter().map(|v| format!("{v:?}")).collect::<Vec<_>>().join(" "),
        });
        let status = DiagnosticStatus {
            name: "matpoint: history".into(),
            message: "recording".into(),
            values: values.collect(),
            ..Default::default()
        };
        DiagnosticArray { header: self.header(row.time), status: vec![status] }
    }

    /// What happened: `/rosout`.
    pub(super) fn log(&self, event: &Event) -> Log {
        let level = match event.level {
            Level::Info => 20,
            Level::Warning => 30,
            Level::Error => 40,
        };
        Log {
            stamp: Time::from_seconds(event.time),
            level,
            name: self.about.ros.node.trim_start_matches('/').replace('/', "."),
            msg: event.text.clone(),
            ..Default::default()
        }
    }

    fn header(&self, time: f64) -> Header {
        Header { stamp: Time::from_seconds(time), frame_id: self.about.ros.frame.clone() }
    }
}

/// What a state message says of a series; the other series go to the diagnostics.
pub(super) enum Said<'a> {
    Energy(usize),
    Momentum,
    RealTimeFactor,
    /// Name of the probe, number of the quantity.
    Probe(&'a str, usize),
    Reaction(&'a str),
}

const ENERGIES: [&str; 4] = ["kinetic", "strain", "external", "total"];
const PROBED: [&str; 4] = ["position", "displacement", "velocity", "stress"];

pub(super) fn said(variable: &str) -> Option<Said<'_>> {
    let (kind, rest) = variable.split_once('/')?;
    match kind {
        "energy" => ENERGIES.iter().position(|&e| e == rest).map(Said::Energy),
        "momentum" if rest == "linear" => Some(Said::Momentum),
        "pace" if rest == "real_time_factor" => Some(Said::RealTimeFactor),
        "probe" => {
            let (name, quantity) = rest.rsplit_once('/')?;
            PROBED.iter().position(|&q| q == quantity).map(|q| Said::Probe(name, q))
        }
        "boundary" => rest.strip_suffix("/reaction").map(Said::Reaction),
        _ => None,
    }
}
