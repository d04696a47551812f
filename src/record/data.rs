//! What a recording holds, as plain data: the same whether it comes from a simulation or from a file.

use super::columns::{self, Series};
use super::particles::{pressure, spacing, von_mises};
use super::{Options, Precision, RecordError, RosNames};
use crate::Simulation;
use crate::component::{ComponentError, Description, Variable};
use crate::scene::{Scene, nearest};
use std::sync::Arc;

/// What a recording is of: all that does not change while it is made.
#[derive(Debug, Clone, PartialEq)]
pub struct About {
    /// The scene.
    pub scene: Scene,
    /// The simulation.
    pub description: Description,
    /// Version of matpoint that made it.
    pub version: String,
    /// Commit of matpoint that made it; empty where it was built without git.
    pub commit: String,
    /// What is recorded of each particle, the position first.
    pub columns: Vec<Column>,
    /// How floating-point numbers of particles are stored.
    pub precision: Precision,
    /// Whether the cells of the grid that hold particles are shown.
    pub cells: bool,
    /// How an `.mcap` recording calls its topics.
    pub ros: RosNames,
    /// Energies, momenta, probes, reactions, errors and the pace, in the order of the values of a row.
    pub(crate) series: Vec<Series>,
    /// Inputs, in the order in which they follow the series in a row.
    pub(crate) inputs: Vec<Variable>,
    /// Position of each particle at time 0 \[m\], `dimension` numbers a particle.
    pub(crate) initial: Vec<f64>,
    /// Body of each particle.
    pub(crate) body: Vec<u32>,
    /// Distance of neighbours at time 0 \[m\]: body, axis.
    pub(crate) spacing: Vec<Vec<f64>>,
}

impl About {
    /// Of a simulation, with the particle variables that `options` choose.
    ///
    /// # Errors
    /// A variable that there is not.
    pub fn new(sim: &mut Simulation, options: &Options) -> Result<Self, RecordError> {
        let description = sim.describe();
        let columns = columns(&description, options.variables.as_deref())?;
        let (position, displacement) = (sim.share("particle/position")?, sim.get("particle/displacement")?);
        Ok(Self {
            initial: position.iter().zip(displacement).map(|(x, u)| x - u).collect(),
            body: sim.get("particle/body")?.iter().map(|&b| b as u32).collect(),
            spacing: spacing(sim.scene()),
            scene: sim.scene().clone(),
            version: env!("CARGO_PKG_VERSION").into(),
            commit: option_env!("MATPOINT_COMMIT").unwrap_or_default().into(),
            precision: options.precision,
            cells: options.cells,
            ros: options.ros.clone(),
            series: columns::series(&description).into_iter().chain(pace()).collect(),
            inputs: description.variables.iter().filter(|v| v.name.starts_with("load/")).cloned().collect(),
            columns,
            description,
        })
    }

    /// Number of space dimensions.
    pub fn dimension(&self) -> usize {
        self.description.dimension
    }

    /// Place of a column, by its name without `particle/`.
    pub(crate) fn column(&self, name: &str) -> Option<usize> {
        self.columns.iter().position(|c| c.name == name)
    }
}

/// How fast the simulation moves: recorded like a variable, but not one of the simulation.
fn pace() -> [Series; 3] {
    [("pace/step", "s"), ("pace/iterations", ""), ("pace/real_time_factor", "")].map(|(name, unit)| Series::scalar(name, unit))
}

/// What is recorded of each particle.
#[derive(Debug, Clone, PartialEq)]
pub struct Column {
    /// Name without `particle/`: a variable, `von_mises` or `pressure`.
    pub name: String,
    /// SI unit, empty for pure numbers.
    pub unit: &'static str,
    /// Numbers a particle in [`Frame::values`].
    pub width: usize,
    /// Label (empty for a scalar) and index of each number that is stored; symmetric tensors are stored once.
    pub components: Vec<(&'static str, usize)>,
}

impl Column {
    /// The variable it is made of.
    pub(crate) fn source(&self) -> String {
        match self.name.as_str() {
            "von_mises" | "pressure" => "particle/stress".into(),
            name => format!("particle/{name}"),
        }
    }

    /// Its values, from those of its source.
    fn derive(&self, source: Arc<Vec<f64>>) -> Arc<Vec<f64>> {
        match self.name.as_str() {
            "von_mises" => Arc::new(source.chunks_exact(9).map(von_mises).collect()),
            "pressure" => Arc::new(source.chunks_exact(9).map(pressure).collect()),
            _ => source,
        }
    }
}

/// The columns asked for, the position first; those that most want to see where nothing is asked for.
fn columns(description: &Description, names: Option<&[String]>) -> Result<Vec<Column>, RecordError> {
    // In dimension 1 the stress has a sign worth seeing.
    let usual: &[&str] =
        if description.dimension == 1 { &["velocity", "stress", "body"] } else { &["velocity", "von_mises", "pressure", "body"] };
    let names: Vec<&str> = names.map_or(usual.to_vec(), |names| names.iter().map(String::as_str).collect());
    let mut columns: Vec<Column> = Vec::new();
    for name in std::iter::once("position").chain(names) {
        let name = name.trim_start_matches("particle/");
        if columns.iter().any(|c| c.name == name) {
            continue;
        }
        let made = match name {
            "von_mises" | "pressure" => Some(Column { name: name.into(), unit: "Pa", width: 1, components: vec![("", 0)] }),
            _ => description.variables.iter().find(|v| v.name.strip_prefix("particle/") == Some(name)).map(|v| Column {
                name: name.into(),
                unit: v.unit,
                width: v.shape[1..].iter().product(),
                components: columns::components(&v.name, &v.shape[1..]),
            }),
        };
        columns.push(made.ok_or_else(|| {
            let known = description.variables.iter().filter_map(|v| v.name.strip_prefix("particle/")).chain(["von_mises", "pressure"]);
            let known: Vec<&str> = known.collect();
            RecordError::Variable {
                name: name.into(),
                nearest: nearest(name, known.iter().copied()).map(Into::into),
                known: known.join(", "),
            }
        })?);
    }
    Ok(columns)
}

/// The particles at a time.
#[derive(Debug, Clone, PartialEq)]
pub struct Frame {
    /// Time \[s\].
    pub time: f64,
    /// Substeps since time 0.
    pub step: u64,
    /// A C-order array for each column, in the order of the particles' numbers.
    pub values: Vec<Arc<Vec<f64>>>,
}

/// A frame of the state of a simulation. The `body` of each particle does not change.
pub(super) fn read_frame(sim: &mut Simulation, columns: &[Column], body: &Arc<Vec<f64>>) -> Result<Frame, ComponentError> {
    let read = |column: &Column| {
        if column.name == "body" { Ok(body.clone()) } else { sim.share(&column.source()).map(|source| column.derive(source)) }
    };
    let values = columns.iter().map(read).collect::<Result<_, _>>()?;
    Ok(Frame { time: sim.time(), step: sim.steps(), values })
}

/// Energies, probes and the rest of the history at a time.
#[derive(Debug, Clone, PartialEq)]
pub struct Row {
    /// Time \[s\].
    pub time: f64,
    /// Substeps since time 0.
    pub step: u64,
    /// Communication steps recorded so far.
    pub count: u64,
    /// All numbers of each series, then those of each input.
    pub values: Vec<Vec<f64>>,
}

/// How much an event matters.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Level {
    /// Good to know.
    Info,
    /// Seldom wise.
    Warning,
    /// The run ends here.
    Error,
}

/// Something that happened.
#[derive(Debug, Clone, PartialEq)]
pub struct Event {
    /// Time \[s\].
    pub time: f64,
    /// Substeps since time 0.
    pub step: u64,
    /// How much it matters.
    pub level: Level,
    /// What happened.
    pub text: String,
}

/// All that a restart needs.
#[derive(Debug, Clone, PartialEq)]
pub struct Snapshot {
    /// Time \[s\].
    pub time: f64,
    /// Substeps since time 0.
    pub step: u64,
    /// As [`Simulation::save`] gives them.
    pub bytes: Vec<u8>,
}

/// One thing that is recorded.
#[derive(Debug, Clone, PartialEq)]
pub enum Item {
    /// Particles.
    Frame(Frame),
    /// History.
    Row(Row),
    /// Text.
    Event(Event),
    /// For a restart.
    Snapshot(Snapshot),
}

impl Item {
    /// Time \[s\].
    pub fn time(&self) -> f64 {
        match self {
            Self::Frame(frame) => frame.time,
            Self::Row(row) => row.time,
            Self::Event(event) => event.time,
            Self::Snapshot(snapshot) => snapshot.time,
        }
    }
}
