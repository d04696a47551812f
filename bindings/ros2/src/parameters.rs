//! The parameters of the node: one table with defaults, meanings and ranges, read by `ros2 param` and by the loop.

use crate::interfaces::parameters::{FloatingPointRange, IntegerRange, Parameter, ParameterDescriptor, ParameterValue};
use matpoint::record::Options;
use std::collections::BTreeMap;

/// A value.
#[derive(Debug, Clone, PartialEq)]
#[expect(missing_docs, reason = "the names say it")]
pub enum Value {
    Bool(bool),
    Integer(i64),
    Double(f64),
    Text(String),
    Texts(Vec<String>),
}

/// What values a parameter may have.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Allowed {
    Any,
    Doubles(f64, f64),
    Integers(i64, i64),
    /// One of these words, or a list of them.
    Words(&'static [&'static str]),
}

struct Declared {
    name: &'static str,
    default: Value,
    allowed: Allowed,
    read_only: bool,
    doc: &'static str,
}

/// Columns that `particles.fields` may name.
pub const FIELDS: [&str; 6] = ["velocity", "von_mises", "pressure", "displacement", "body", "id"];

/// Every parameter, by name.
fn declared() -> Vec<Declared> {
    use Allowed::{Any, Doubles, Integers, Words};
    const RELIABILITY: Allowed = Words(&["reliable", "best_effort"]);
    let text = |t: &str| Value::Text(t.into());
    let rows = [
        (
            "command.after",
            text("decay"),
            Words(&["decay", "hold"]),
            false,
            "what a load does when its command has timed out: decay to zero, or hold its value",
        ),
        (
            "command.decay",
            Value::Double(0.0),
            Doubles(0.0, 1e6),
            false,
            "simulated time in which a load whose command has timed out goes to zero [s]; 0: at once",
        ),
        (
            "command.timeout",
            Value::Double(0.5),
            Doubles(0.0, 1e9),
            false,
            "simulated time for which a command holds, unless it says so itself [s]; 0: for ever",
        ),
        ("frame_id", text("map"), Any, true, "frame of all positions and vectors"),
        (
            "lock_step",
            Value::Bool(false),
            Any,
            false,
            "one communication step for each load command, none without; real_time_factor is not used",
        ),
        (
            "particles.fields",
            Value::Texts(vec!["von_mises".into()]),
            Words(&FIELDS),
            false,
            "columns of ~/particles beside x, y, z: any of velocity, von_mises, pressure, displacement, body, id",
        ),
        (
            "particles.max_bytes",
            Value::Integer(80_000),
            Integers(64, 1_000_000_000),
            true,
            "most bytes of points in a message: of a strided cloud, or of a tile; receivers with default buffers lose larger ones",
        ),
        (
            "particles.mode",
            text("strided"),
            Words(&["strided", "whole", "tiles"]),
            true,
            "~/particles: every n-th particle, all in one message, or all in messages of max_bytes that share a stamp",
        ),
        ("particles.rate", Value::Double(30.0), Doubles(0.0, 1e4), false, "clouds a second [Hz]; 0: one each communication step"),
        ("particles.reliability", text("reliable"), RELIABILITY, true, "quality of service of ~/particles; tiles are always best effort"),
        (
            "particles.stride",
            Value::Integer(0),
            Integers(0, 10_000_000),
            false,
            "in mode strided, every n-th particle; 0: the smallest that keeps to max_bytes",
        ),
        ("paused", Value::Bool(false), Any, true, "wait for simulation_interfaces before the first step"),
        ("real_time_factor", Value::Double(1.0), Doubles(0.0, 1e6), false, "simulated over wall time [-]; 0: as fast as it can"),
        (
            "record",
            text(""),
            Any,
            false,
            "recording under way: FILE.mcap, FILE.rrd (if built with rerun), FILE.pvd, or a folder for CSV; empty: none",
        ),
        ("record.cells", Value::Bool(false), Any, false, "a .rrd recording that begins shows the cells that hold particles"),
        (
            "record.every",
            Value::Double(0.0),
            Doubles(0.0, 1e9),
            false,
            "simulated time between two frames of a recording that begins [s]; 0: what the scene says",
        ),
        ("record.force", Value::Bool(false), Any, false, "a recording that begins writes over what is there"),
        ("record.precision", text("f32"), Words(&["f32", "f64"]), false, "numbers of particles in a recording that begins"),
        (
            "record.snapshots",
            Value::Double(0.0),
            Doubles(0.0, 1e9),
            false,
            "simulated time between snapshots, from which a run can go on, in a recording that begins [s]; 0: none",
        ),
        (
            "record.variables",
            Value::Texts(Vec::new()),
            Any,
            false,
            "what a recording that begins holds of each particle beside its position; empty: the usual",
        ),
        (
            "record.when_full",
            text("wait"),
            Words(&["wait", "drop"]),
            false,
            "what happens while a recording that begins cannot keep up: the simulation waits, or frames are dropped and counted",
        ),
        ("state.rate", Value::Double(0.0), Doubles(0.0, 1e4), false, "messages a second on ~/state [Hz]; 0: one each communication step"),
        ("state.reliability", text("reliable"), RELIABILITY, true, "quality of service of ~/state"),
        (
            "step",
            Value::Double(0.01),
            Doubles(1e-9, 1e3),
            false,
            "communication step: simulated time between two states, with as many substeps as it takes [s]",
        ),
        ("use_sim_time", Value::Bool(false), Any, false, "without effect: this node is the source of /clock"),
    ];
    rows.map(|(name, default, allowed, read_only, doc)| Declared { name, default, allowed, read_only, doc }).into()
}

/// A value that a parameter cannot have, or a parameter that there is not.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ParameterError {
    /// No such parameter.
    #[error("no parameter `{name}`{}", nearest.map(|n| format!("; did you mean `{n}`?")).unwrap_or_default())]
    Unknown {
        /// Asked for.
        name: String,
        /// Nearest right name.
        nearest: Option<&'static str>,
    },
    /// Another type.
    #[error("parameter `{name}` is a {expected}, not a {found}")]
    Type {
        /// Parameter.
        name: &'static str,
        /// Its type.
        expected: &'static str,
        /// Type given.
        found: &'static str,
    },
    /// A value that is not allowed.
    #[error("parameter `{name}` is {value}; allowed is {allowed}")]
    Range {
        /// Parameter.
        name: &'static str,
        /// Value given.
        value: String,
        /// Allowed values.
        allowed: String,
    },
    /// Set at the start only.
    #[error("parameter `{name}` can only be set when the node starts")]
    ReadOnly {
        /// Parameter.
        name: &'static str,
    },
}

impl Value {
    fn kind(&self) -> (&'static str, u8) {
        match self {
            Self::Bool(_) => ("bool", 1),
            Self::Integer(_) => ("integer", 2),
            Self::Double(_) => ("double", 3),
            Self::Text(_) => ("string", 4),
            Self::Texts(_) => ("string array", 9),
        }
    }

    /// As sent.
    pub fn to_wire(&self) -> ParameterValue {
        let mut wire = ParameterValue { r#type: self.kind().1, ..Default::default() };
        match self.clone() {
            Self::Bool(v) => wire.bool_value = v,
            Self::Integer(v) => wire.integer_value = v,
            Self::Double(v) => wire.double_value = v,
            Self::Text(v) => wire.string_value = v,
            Self::Texts(v) => wire.string_array_value = v,
        }
        wire
    }

    /// As received; `None` for a type that no parameter of this node has.
    pub fn from_wire(wire: ParameterValue) -> Option<Self> {
        Some(match wire.r#type {
            1 => Self::Bool(wire.bool_value),
            2 => Self::Integer(wire.integer_value),
            3 => Self::Double(wire.double_value),
            4 => Self::Text(wire.string_value),
            9 => Self::Texts(wire.string_array_value),
            _ => return None,
        })
    }
}

/// The values of all parameters.
pub struct Parameters {
    declared: Vec<Declared>,
    values: BTreeMap<&'static str, Value>,
    /// The same, ready for use.
    pub settings: Settings,
}

impl Default for Parameters {
    fn default() -> Self {
        let declared = declared();
        let values = declared.iter().map(|d| (d.name, d.default.clone())).collect();
        let settings = Settings::new(&values);
        Self { declared, values, settings }
    }
}

impl Parameters {
    /// Sets several parameters, all or none; `starting` allows those that are fixed later.
    ///
    /// # Errors
    /// The first that cannot be set.
    pub fn set(&mut self, changes: Vec<(String, Value)>, starting: bool) -> Result<(), ParameterError> {
        let mut good = Vec::new();
        for (name, value) in changes {
            let declared = self.find(&name)?;
            let value = check(declared, value)?;
            if declared.read_only && !starting && self.values.get(declared.name) != Some(&value) {
                return Err(ParameterError::ReadOnly { name: declared.name });
            }
            good.push((declared.name, value));
        }
        self.values.extend(good);
        self.settings = Settings::new(&self.values);
        Ok(())
    }

    /// The value of a parameter.
    pub fn get(&self, name: &str) -> Option<&Value> {
        self.values.get(name)
    }

    /// The names of all, sorted.
    pub fn names(&self) -> impl Iterator<Item = &'static str> {
        self.declared.iter().map(|d| d.name)
    }

    /// What a parameter is; a descriptor without type for one that there is not.
    pub fn describe(&self, name: &str) -> ParameterDescriptor {
        let Ok(declared) = self.find(name) else { return ParameterDescriptor { name: name.into(), ..Default::default() } };
        let mut descriptor = ParameterDescriptor {
            name: name.into(),
            r#type: declared.default.kind().1,
            description: declared.doc.into(),
            read_only: declared.read_only,
            ..Default::default()
        };
        match declared.allowed {
            Allowed::Any => {}
            Allowed::Doubles(from_value, to_value) => {
                descriptor.floating_point_range.push(FloatingPointRange { from_value, to_value, step: 0.0 });
            }
            Allowed::Integers(from_value, to_value) => {
                descriptor.integer_range.push(IntegerRange { from_value, to_value, step: 1 });
            }
            Allowed::Words(_) => descriptor.additional_constraints = allowed(declared),
        }
        descriptor
    }

    /// As sent, for events.
    pub fn message(&self, name: &str) -> Parameter {
        Parameter { name: name.into(), value: self.get(name).map(Value::to_wire).unwrap_or_default() }
    }

    fn find(&self, name: &str) -> Result<&Declared, ParameterError> {
        self.declared.iter().find(|d| d.name == name).ok_or_else(|| {
            let near = self.names().map(|n| (strsim::damerau_levenshtein(n, name), n)).min().filter(|(far, n)| *far <= n.len() / 2);
            ParameterError::Unknown { name: name.into(), nearest: near.map(|(_, n)| n) }
        })
    }
}

fn allowed(declared: &Declared) -> String {
    match declared.allowed {
        Allowed::Any => "any value".into(),
        Allowed::Doubles(low, high) => format!("a number from {low} to {high}"),
        Allowed::Integers(low, high) => format!("a whole number from {low} to {high}"),
        Allowed::Words(words) => format!("any of {}", words.join(", ")),
    }
}

/// The value as the parameter has it; whole numbers are numbers too.
fn check(declared: &Declared, value: Value) -> Result<Value, ParameterError> {
    let value = match (&declared.default, value) {
        (Value::Double(_), Value::Integer(v)) => Value::Double(v as f64),
        (Value::Texts(_), Value::Text(v)) => Value::Texts(v.split(',').map(|w| w.trim().to_owned()).filter(|w| !w.is_empty()).collect()),
        (_, other) => other,
    };
    let ((expected, _), (found, _)) = (declared.default.kind(), value.kind());
    if expected != found {
        return Err(ParameterError::Type { name: declared.name, expected, found });
    }
    let fits = match (&value, declared.allowed) {
        (Value::Double(v), Allowed::Doubles(low, high)) => (low..=high).contains(v),
        (Value::Integer(v), Allowed::Integers(low, high)) => (low..=high).contains(v),
        (Value::Text(v), Allowed::Words(words)) => words.contains(&v.as_str()),
        (Value::Texts(list), Allowed::Words(words)) => list.iter().all(|v| words.contains(&v.as_str())),
        _ => true,
    };
    if fits {
        return Ok(value);
    }
    let shown = match value {
        Value::Bool(v) => v.to_string(),
        Value::Integer(v) => v.to_string(),
        Value::Double(v) => v.to_string(),
        Value::Text(v) => format!("`{v}`"),
        Value::Texts(v) => format!("`{}`", v.join(", ")),
    };
    Err(ParameterError::Range { name: declared.name, value: shown, allowed: allowed(declared) })
}

/// How `~/particles` is cut.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Mode {
    /// Every n-th particle.
    Strided,
    /// All in one message.
    Whole,
    /// All, in several messages.
    Tiles,
}

/// The parameters as the loop reads them; names and units as in the table.
#[derive(Debug, Clone, PartialEq)]
#[expect(missing_docs, reason = "the table documents them")]
pub struct Settings {
    pub hold_after: bool,
    pub decay: f64,
    pub timeout: f64,
    pub frame_id: String,
    pub lock_step: bool,
    pub fields: Vec<String>,
    pub max_bytes: usize,
    pub mode: Mode,
    pub particles_rate: f64,
    pub particles_reliable: bool,
    pub stride: usize,
    pub paused: bool,
    pub real_time_factor: f64,
    pub record: String,
    pub record_every: f64,
    pub record_options: Options,
    pub state_rate: f64,
    pub state_reliable: bool,
    pub step: f64,
}

impl Settings {
    fn new(values: &BTreeMap<&'static str, Value>) -> Self {
        let bool = |name: &str| matches!(values.get(name), Some(Value::Bool(true)));
        let double = |name: &str| if let Some(Value::Double(v)) = values.get(name) { *v } else { 0.0 };
        let integer = |name: &str| if let Some(Value::Integer(v)) = values.get(name) { usize::try_from(*v).unwrap_or(0) } else { 0 };
        let text = |name: &str| if let Some(Value::Text(v)) = values.get(name) { v.clone() } else { String::new() };
        let texts = |name: &str| if let Some(Value::Texts(v)) = values.get(name) { v.clone() } else { Vec::new() };
        let mode = match text("particles.mode").as_str() {
            "tiles" => Mode::Tiles,
            "whole" => Mode::Whole,
            _ => Mode::Strided,
        };
        Self {
            hold_after: text("command.after") == "hold",
            decay: double("command.decay"),
            timeout: double("command.timeout"),
            frame_id: text("frame_id"),
            lock_step: bool("lock_step"),
            fields: texts("particles.fields"),
            max_bytes: integer("particles.max_bytes"),
            mode,
            particles_rate: double("particles.rate"),
            particles_reliable: mode != Mode::Tiles && text("particles.reliability") == "reliable",
            stride: integer("particles.stride"),
            paused: bool("paused"),
            real_time_factor: double("real_time_factor"),
            record: text("record"),
            record_every: double("record.every"),
            record_options: Options {
                force: bool("record.force"),
                cells: bool("record.cells"),
                variables: Some(texts("record.variables")).filter(|names| !names.is_empty()),
                precision: text("record.precision").parse().unwrap_or_default(),
                snapshots: Some(double("record.snapshots")).filter(|&every| every > 0.0),
                when_full: text("record.when_full").parse().ok(),
                ..Options::default()
            },
            state_rate: double("state.rate"),
            state_reliable: text("state.reliability") == "reliable",
            step: double("step"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn set(name: &str, value: Value) -> Result<Settings, String> {
        let mut parameters = Parameters::default();
        parameters.set(vec![(name.into(), value)], false).map_err(|e| e.to_string())?;
        Ok(parameters.settings)
    }

    #[test]
    fn values_are_checked_and_errors_name_all_of_it() {
        assert_eq!(set("step", Value::Integer(2)).unwrap().step, 2.0);
        assert_eq!(set("step", Value::Double(0.0)).unwrap_err(), "parameter `step` is 0; allowed is a number from 0.000000001 to 1000");
        assert_eq!(
            set("step", Value::Double(f64::NAN)).unwrap_err(),
            "parameter `step` is NaN; allowed is a number from 0.000000001 to 1000"
        );
        assert_eq!(set("stepp", Value::Double(1.0)).unwrap_err(), "no parameter `stepp`; did you mean `step`?");
        assert_eq!(set("lock_step", Value::Double(1.0)).unwrap_err(), "parameter `lock_step` is a bool, not a double");
        assert_eq!(set("paused", Value::Bool(true)).unwrap_err(), "parameter `paused` can only be set when the node starts");
        assert_eq!(
            set("command.after", Value::Text("x".into())).unwrap_err(),
            "parameter `command.after` is `x`; allowed is any of decay, hold"
        );
        let fields = set("particles.fields", Value::Texts(vec!["id".into(), "mass".into()]));
        assert_eq!(
            fields.unwrap_err(),
            "parameter `particles.fields` is `id, mass`; allowed is any of velocity, von_mises, pressure, displacement, body, id"
        );
    }

    #[test]
    fn all_or_none_are_set() {
        let mut parameters = Parameters::default();
        let changes = vec![("step".into(), Value::Double(0.5)), ("wrong".into(), Value::Bool(true))];
        assert!(parameters.set(changes, false).is_err());
        assert_eq!(parameters.get("step"), Some(&Value::Double(0.01)));
    }

    #[test]
    fn every_parameter_is_sorted_described_and_within_its_own_range() {
        let parameters = Parameters::default();
        assert!(declared().is_sorted_by(|a, b| a.name < b.name));
        for d in &parameters.declared {
            assert!(check(d, d.default.clone()).is_ok(), "{}", d.name);
            assert!(!parameters.describe(d.name).description.is_empty());
            assert_eq!(Value::from_wire(d.default.to_wire()).as_ref(), Some(&d.default));
        }
    }
}
