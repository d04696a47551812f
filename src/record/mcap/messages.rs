//! The messages, in the order of the fields of their definitions, and the definitions: those of the node.

use serde::{Deserialize, Serialize};

/// Seconds and nanoseconds.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct Time {
    pub(super) sec: i32,
    pub(super) nanosec: u32,
}

impl Time {
    /// From nanoseconds.
    pub(super) fn new(nanos: u64) -> Self {
        Self { sec: i32::try_from(nanos / 1_000_000_000).unwrap_or(i32::MAX), nanosec: (nanos % 1_000_000_000) as u32 }
    }
}

/// When and in which frame.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct Header {
    pub(super) stamp: Time,
    pub(super) frame_id: String,
}

#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct Clock {
    pub(super) clock: Time,
}

#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct PointField {
    pub(super) name: String,
    pub(super) offset: u32,
    pub(super) datatype: u8,
    pub(super) count: u32,
}

#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct PointCloud2 {
    pub(super) header: Header,
    pub(super) height: u32,
    pub(super) width: u32,
    pub(super) fields: Vec<PointField>,
    pub(super) is_bigendian: bool,
    pub(super) point_step: u32,
    pub(super) row_step: u32,
    /// In one piece: byte by byte it takes ten times as long.
    #[serde(with = "serde_bytes")]
    pub(super) data: Vec<u8>,
    pub(super) is_dense: bool,
}

/// `geometry_msgs/Vector3`, and `Point`, which has the same fields.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct Vector3 {
    pub(super) x: f64,
    pub(super) y: f64,
    pub(super) z: f64,
}

impl Vector3 {
    /// The components given; missing ones are zero.
    pub(super) fn new(v: &[f64]) -> Self {
        let at = |i: usize| v.get(i).copied().unwrap_or(0.0);
        Self { x: at(0), y: at(1), z: at(2) }
    }
    /// The first `dimension` components.
    pub(super) fn list(self, dimension: usize) -> Vec<f64> {
        [self.x, self.y, self.z][..dimension].to_vec()
    }
}

#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct Probe {
    pub(super) name: String,
    pub(super) position: Vector3,
    pub(super) displacement: Vector3,
    pub(super) velocity: Vector3,
    pub(super) stress: [f64; 9],
}

#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct Reaction {
    pub(super) name: String,
    pub(super) force: Vector3,
}

#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct LoadState {
    pub(super) name: String,
    pub(super) kind: String,
    pub(super) value: Vec<f64>,
    pub(super) timed_out: bool,
}

#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct ComponentState {
    pub(super) header: Header,
    pub(super) steps: u64,
    pub(super) substeps: u64,
    pub(super) real_time_factor: f64,
    pub(super) kinetic_energy: f64,
    pub(super) strain_energy: f64,
    pub(super) external_work: f64,
    pub(super) total_energy: f64,
    pub(super) momentum: Vector3,
    pub(super) probes: Vec<Probe>,
    pub(super) reactions: Vec<Reaction>,
    pub(super) loads: Vec<LoadState>,
}

#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct VariableDescription {
    pub(super) name: String,
    pub(super) causality: u8,
    pub(super) unit: String,
    pub(super) shape: Vec<u32>,
    pub(super) doc: String,
}

#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct SceneDescription {
    pub(super) header: Header,
    pub(super) title: String,
    pub(super) version: String,
    pub(super) dimension: u8,
    pub(super) particles: u64,
    pub(super) bodies: Vec<String>,
    pub(super) body_particles: Vec<u64>,
    pub(super) method: Vec<String>,
    pub(super) stable_step: f64,
    pub(super) variables: Vec<VariableDescription>,
}

#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct KeyValue {
    pub(super) key: String,
    pub(super) value: String,
}

#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct DiagnosticStatus {
    pub(super) level: u8,
    pub(super) name: String,
    pub(super) message: String,
    pub(super) hardware_id: String,
    pub(super) values: Vec<KeyValue>,
}

#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct DiagnosticArray {
    pub(super) header: Header,
    pub(super) status: Vec<DiagnosticStatus>,
}

/// `rcl_interfaces/Log`: what appears on `/rosout`.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct Log {
    pub(super) stamp: Time,
    pub(super) level: u8,
    pub(super) name: String,
    pub(super) msg: String,
    pub(super) file: String,
    pub(super) function: String,
    pub(super) line: u32,
}

/// Definitions by name: the package's own are the files that ROS builds it from.
const DEFINITIONS: [(&str, &str); 18] = [
    ("builtin_interfaces/Time", "int32 sec\nuint32 nanosec\n"),
    ("std_msgs/Header", "builtin_interfaces/Time stamp\nstring frame_id\n"),
    ("rosgraph_msgs/Clock", "builtin_interfaces/Time clock\n"),
    ("geometry_msgs/Vector3", "float64 x\nfloat64 y\nfloat64 z\n"),
    ("geometry_msgs/Point", "float64 x\nfloat64 y\nfloat64 z\n"),
    (
        "sensor_msgs/PointField",
        "uint8 INT8=1\nuint8 UINT8=2\nuint8 INT16=3\nuint8 UINT16=4\nuint8 INT32=5\nuint8 UINT32=6\nuint8 FLOAT32=7\nuint8 FLOAT64=8\n\
         string name\nuint32 offset\nuint8 datatype\nuint32 count\n",
    ),
    (
        "sensor_msgs/PointCloud2",
        "std_msgs/Header header\nuint32 height\nuint32 width\nsensor_msgs/PointField[] fields\nbool is_bigendian\nuint32 point_step\n\
         uint32 row_step\nuint8[] data\nbool is_dense\n",
    ),
    ("diagnostic_msgs/KeyValue", "string key\nstring value\n"),
    (
        "diagnostic_msgs/DiagnosticStatus",
        "byte OK=0\nbyte WARN=1\nbyte ERROR=2\nbyte STALE=3\nbyte level\nstring name\nstring message\nstring hardware_id\n\
         diagnostic_msgs/KeyValue[] values\n",
    ),
    ("diagnostic_msgs/DiagnosticArray", "std_msgs/Header header\ndiagnostic_msgs/DiagnosticStatus[] status\n"),
    (
        "rcl_interfaces/Log",
        "byte DEBUG=10\nbyte INFO=20\nbyte WARN=30\nbyte ERROR=40\nbyte FATAL=50\nbuiltin_interfaces/Time stamp\nuint8 level\nstring name\n\
         string msg\nstring file\nstring function\nuint32 line\n",
    ),
    ("matpoint_msgs/ComponentState", include_str!("../../../msgs/msg/ComponentState.msg")),
    ("matpoint_msgs/Probe", include_str!("../../../msgs/msg/Probe.msg")),
    ("matpoint_msgs/Reaction", include_str!("../../../msgs/msg/Reaction.msg")),
    ("matpoint_msgs/LoadState", include_str!("../../../msgs/msg/LoadState.msg")),
    ("matpoint_msgs/SceneDescription", include_str!("../../../msgs/msg/SceneDescription.msg")),
    ("matpoint_msgs/VariableDescription", include_str!("../../../msgs/msg/VariableDescription.msg")),
    ("matpoint_msgs/LoadCommand", include_str!("../../../msgs/msg/LoadCommand.msg")),
];

fn definition(name: &str) -> Option<(&'static str, &'static str)> {
    DEFINITIONS.into_iter().find(|(known, _)| *known == name)
}

/// The definition of a message followed by those of all that it is made of, as MCAP wants it; names are `package/Name`.
pub(super) fn schema(name: &str) -> String {
    let mut parts: Vec<(&str, &str)> = definition(name).into_iter().collect();
    let mut next = 0;
    while let Some(&(of, text)) = parts.get(next) {
        let package = of.split_once('/').map_or("", |(package, _)| package);
        for line in text.lines() {
            let line = line.split('#').next().unwrap_or_default();
            let Some(kind) = line.split_whitespace().next() else { continue };
            let kind = kind.split('[').next().unwrap_or_default();
            let full = if kind.contains('/') { kind.to_owned() } else { format!("{package}/{kind}") };
            if let Some(part) = definition(&full)
                && !parts.contains(&part)
            {
                parts.push(part);
            }
        }
        next += 1;
    }
    let separator = "=".repeat(80);
    let mut whole = String::new();
    for (i, (name, text)) in parts.iter().enumerate() {
        if i > 0 {
            whole += &format!("{separator}\nMSG: {name}\n");
        }
        whole += text;
    }
    whole
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Names of the fields of a definition, constants left out.
    fn fields(name: &str) -> Vec<String> {
        let text = definition(name).unwrap().1;
        let lines = text.lines().map(|l| l.split('#').next().unwrap()).filter(|l| !l.contains('='));
        lines.filter_map(|l| l.split_whitespace().nth(1).map(str::to_owned)).collect()
    }

    /// Names of the fields of a message, as it is written.
    fn written<T: Serialize + Default>() -> Vec<String> {
        serde_json::to_value(T::default()).unwrap().as_object().unwrap().keys().cloned().collect()
    }

    #[test]
    fn messages_have_the_fields_of_their_definitions_in_order() {
        assert_eq!(written::<ComponentState>(), fields("matpoint_msgs/ComponentState"));
        assert_eq!(written::<Probe>(), fields("matpoint_msgs/Probe"));
        assert_eq!(written::<Reaction>(), fields("matpoint_msgs/Reaction"));
        assert_eq!(written::<LoadState>(), fields("matpoint_msgs/LoadState"));
        assert_eq!(written::<SceneDescription>(), fields("matpoint_msgs/SceneDescription"));
        assert_eq!(written::<VariableDescription>(), fields("matpoint_msgs/VariableDescription"));
        assert_eq!(written::<PointCloud2>(), fields("sensor_msgs/PointCloud2"));
        assert_eq!(written::<PointField>(), fields("sensor_msgs/PointField"));
        assert_eq!(written::<DiagnosticStatus>(), fields("diagnostic_msgs/DiagnosticStatus"));
        assert_eq!(written::<Log>(), fields("rcl_interfaces/Log"));
    }

    #[test]
    fn a_schema_has_all_its_parts_once() {
        let text = schema("matpoint_msgs/ComponentState");
        for part in ["std_msgs/Header", "builtin_interfaces/Time", "geometry_msgs/Point", "matpoint_msgs/Probe", "matpoint_msgs/LoadState"]
        {
            assert_eq!(text.matches(&format!("MSG: {part}\n")).count(), 1, "{part}");
        }
    }
}
