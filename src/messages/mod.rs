//! The ROS 2 messages of a simulation: what the node publishes and what `.mcap` recordings hold, defined here once.
//!
//! `msgs/` holds the definitions of the package `matpoint_msgs` and says what the fields mean.

mod schema;

pub(crate) use schema::schema;

use crate::component::{Causality, Description, Variable};
use std::sync::Arc;

/// A type that has a name in ROS interface files.
pub trait Interface {
    /// That name: `float64[]`, `std_msgs/Header`.
    fn ros() -> String;
}

/// Name and fields of a message or of one half of a service.
#[derive(Debug, Clone, PartialEq)]
pub struct Definition {
    /// `package/Name`, `package/Name.request` or `package/Name.response`.
    pub name: &'static str,
    /// Names and types, in order.
    pub fields: Vec<(&'static str, String)>,
}

macro_rules! primitives {
    ($($rust:ty = $ros:literal),*) => { $(impl Interface for $rust { fn ros() -> String { $ros.into() } })* };
}
primitives!(
    bool = "bool",
    u8 = "uint8",
    u16 = "uint16",
    i32 = "int32",
    u32 = "uint32",
    i64 = "int64",
    u64 = "uint64",
    f64 = "float64",
    String = "string",
    [f64; 9] = "float64[9]",
    Bytes = "uint8[]"
);

impl<T: Interface> Interface for Vec<T> {
    fn ros() -> String {
        format!("{}[]", T::ros())
    }
}

/// Messages as structs with public fields, and `definitions()`, the list of them. Whoever uses it needs `serde` with `derive`.
#[doc(hidden)]
#[macro_export]
macro_rules! interfaces {
    ($($(#[$doc:meta])* $ros:literal $name:ident { $($field:ident: $type:ty),* $(,)? })*) => {
        $(
            $(#[$doc])*
            #[derive(Debug, Clone, Default, PartialEq, serde::Serialize, serde::Deserialize)]
            #[allow(missing_docs, reason = "the interface files document the fields")]
            pub struct $name { $(pub $field: $type),* }
            impl $crate::messages::Interface for $name {
                fn ros() -> String { $ros.into() }
            }
        )*
        /// Every definition of this file.
        pub fn definitions() -> Vec<$crate::messages::Definition> {
            use $crate::messages::Interface;
            vec![$($crate::messages::Definition {
                name: $ros,
                fields: vec![$((stringify!($field).trim_start_matches("r#"), <$type>::ros())),*],
            }),*]
        }
    };
}

interfaces! {
    /// Seconds and nanoseconds.
    "builtin_interfaces/Time" Time { sec: i32, nanosec: u32 }
    /// When and in which frame.
    "std_msgs/Header" Header { stamp: Time, frame_id: String }
    /// Three numbers.
    "geometry_msgs/Vector3" Vector3 { x: f64, y: f64, z: f64 }
    /// A place \[m\].
    "geometry_msgs/Point" Point { x: f64, y: f64, z: f64 }
    /// The simulated time.
    "rosgraph_msgs/Clock" Clock { clock: Time }
    /// A column of a cloud.
    "sensor_msgs/PointField" PointField { name: String, offset: u32, datatype: u8, count: u32 }
    /// A cloud of points.
    "sensor_msgs/PointCloud2" PointCloud2 {
        header: Header, height: u32, width: u32, fields: Vec<PointField>, is_bigendian: bool, point_step: u32, row_step: u32, data: Bytes,
        is_dense: bool,
    }
    /// A name and its value.
    "diagnostic_msgs/KeyValue" KeyValue { key: String, value: String }
    /// How a part fares.
    "diagnostic_msgs/DiagnosticStatus" DiagnosticStatus {
        level: u8, name: String, message: String, hardware_id: String, values: Vec<KeyValue>,
    }
    /// How all parts fare.
    "diagnostic_msgs/DiagnosticArray" DiagnosticArray { header: Header, status: Vec<DiagnosticStatus> }
    /// What appears on `/rosout`.
    "rcl_interfaces/Log" Log {
        stamp: Time, level: u8, name: String, msg: String, file: String, function: String, line: u32,
    }
    /// The simulation at the end of a step.
    "matpoint_msgs/ComponentState" ComponentState {
        header: Header, steps: u64, substeps: u64, real_time_factor: f64, kinetic_energy: f64, strain_energy: f64, external_work: f64,
        total_energy: f64, momentum: Vector3, probes: Vec<Probe>, reactions: Vec<Reaction>, loads: Vec<LoadState>,
    }
    /// A watched material point.
    "matpoint_msgs/Probe" Probe { name: String, position: Point, displacement: Vector3, velocity: Vector3, stress: [f64; 9] }
    /// What a boundary does to the bodies.
    "matpoint_msgs/Reaction" Reaction { name: String, force: Vector3 }
    /// What an external load does.
    "matpoint_msgs/LoadState" LoadState { name: String, kind: String, value: Vec<f64>, timed_out: bool }
    /// A variable.
    "matpoint_msgs/VariableDescription" VariableDescription {
        name: String, causality: u8, unit: String, shape: Vec<u32>, doc: String,
    }
    /// What is simulated.
    "matpoint_msgs/SceneDescription" SceneDescription {
        header: Header, title: String, version: String, dimension: u8, particles: u64, bodies: Vec<String>, body_particles: Vec<u64>,
        method: Vec<String>, stable_step: f64, variables: Vec<VariableDescription>,
    }
}

impl Time {
    /// Seconds as a stamp; times before 0 are 0.
    pub fn from_seconds(seconds: f64) -> Self {
        // Rounded as a whole, so that 0.999 999 999 9 s becomes the next second and not 1e9 ns.
        Self::from_nanos((seconds.max(0.0) * 1e9).round() as u64)
    }
    /// Nanoseconds as a stamp.
    pub fn from_nanos(nanos: u64) -> Self {
        Self { sec: i32::try_from(nanos / 1_000_000_000).unwrap_or(i32::MAX), nanosec: (nanos % 1_000_000_000) as u32 }
    }
    /// Seconds.
    pub fn seconds(&self) -> f64 {
        f64::from(self.sec) + 1e-9 * f64::from(self.nanosec)
    }
}

impl Vector3 {
    /// The components given; missing ones are zero.
    pub fn from_slice(v: &[f64]) -> Self {
        let at = |i: usize| v.get(i).copied().unwrap_or(0.0);
        Self { x: at(0), y: at(1), z: at(2) }
    }
    /// As an array.
    pub fn array(&self) -> [f64; 3] {
        [self.x, self.y, self.z]
    }
}

impl PointCloud2 {
    /// A cloud in one row: as many points as `data` holds, of `point_step` bytes each.
    pub fn row(header: Header, fields: Vec<PointField>, point_step: usize, data: Bytes) -> Self {
        Self {
            header,
            height: 1,
            width: (data.0.len() / point_step) as u32,
            fields,
            is_bigendian: false,
            point_step: point_step as u32,
            row_step: data.0.len() as u32,
            data,
            is_dense: true,
        }
    }
}

impl Point {
    /// The components given; missing ones are zero.
    pub fn from_slice(v: &[f64]) -> Self {
        let Vector3 { x, y, z } = Vector3::from_slice(v);
        Self { x, y, z }
    }
    /// As an array.
    pub fn array(&self) -> [f64; 3] {
        [self.x, self.y, self.z]
    }
}

impl From<&Variable> for VariableDescription {
    fn from(variable: &Variable) -> Self {
        Self {
            name: variable.name.clone(),
            causality: u8::from(variable.causality == Causality::Output),
            unit: variable.unit.into(),
            shape: variable.shape.iter().map(|&n| n as u32).collect(),
            doc: variable.doc.into(),
        }
    }
}

impl SceneDescription {
    /// What is simulated, by which version; `frame` is that of all vectors.
    pub fn new(description: &Description, version: &str, frame: &str) -> Self {
        Self {
            header: Header { frame_id: frame.into(), ..Default::default() },
            title: description.title.clone(),
            version: version.into(),
            dimension: description.dimension as u8,
            particles: description.particles as u64,
            bodies: description.bodies.iter().map(|b| b.0.clone()).collect(),
            body_particles: description.bodies.iter().map(|b| b.1 as u64).collect(),
            method: description.method.iter().map(|(what, choice)| format!("{what}: {choice}")).collect(),
            stable_step: description.stable_step,
            variables: description.variables.iter().map(Into::into).collect(),
        }
    }
}

/// `uint8[]` that is written in one piece and cloned for free.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Bytes(pub Arc<Vec<u8>>);

impl serde::Serialize for Bytes {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_bytes(&self.0)
    }
}

impl<'de> serde::Deserialize<'de> for Bytes {
    fn deserialize<D: serde::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Visitor;
        impl serde::de::Visitor<'_> for Visitor {
            type Value = Vec<u8>;
            fn expecting(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                f.write_str("bytes")
            }
            fn visit_bytes<E>(self, bytes: &[u8]) -> Result<Vec<u8>, E> {
                Ok(bytes.to_vec())
            }
            fn visit_byte_buf<E>(self, bytes: Vec<u8>) -> Result<Vec<u8>, E> {
                Ok(bytes)
            }
        }
        deserializer.deserialize_byte_buf(Visitor).map(|bytes| Self(Arc::new(bytes)))
    }
}
