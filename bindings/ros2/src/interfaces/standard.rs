//! Messages of the standard packages.

use super::{Bytes, interfaces};

interfaces! {
    /// Seconds and nanoseconds.
    "builtin_interfaces/Time" Time { sec: i32, nanosec: u32 }
    /// When and in which frame.
    "std_msgs/Header" Header { stamp: Time, frame_id: String }
    /// Three numbers.
    "geometry_msgs/Vector3" Vector3 { x: f64, y: f64, z: f64 }
    /// A place \[m\].
    "geometry_msgs/Point" Point { x: f64, y: f64, z: f64 }
    /// A rotation.
    "geometry_msgs/Quaternion" Quaternion { x: f64, y: f64, z: f64, w: f64 }
    /// A place and a rotation.
    "geometry_msgs/Pose" Pose { position: Point, orientation: Quaternion }
    /// Velocities \[m/s, rad/s\].
    "geometry_msgs/Twist" Twist { linear: Vector3, angular: Vector3 }
    /// Accelerations \[m/s2, rad/s2\].
    "geometry_msgs/Accel" Accel { linear: Vector3, angular: Vector3 }
    /// A vector with its frame.
    "geometry_msgs/Vector3Stamped" Vector3Stamped { header: Header, vector: Vector3 }
    /// Force \[N\] and torque \[N m\].
    "geometry_msgs/Wrench" Wrench { force: Vector3, torque: Vector3 }
    /// A wrench with its frame.
    "geometry_msgs/WrenchStamped" WrenchStamped { header: Header, wrench: Wrench }
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
}

impl Time {
    /// Seconds as a stamp; times before 0 are 0.
    pub fn from_seconds(seconds: f64) -> Self {
        // Rounded as a whole, so that 0.999 999 999 9 s becomes the next second and not 1e9 ns.
        let nanos = (seconds.max(0.0) * 1e9).round() as u64;
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

impl Point {
    /// The components given; missing ones are zero.
    pub fn from_slice(v: &[f64]) -> Self {
        let Vector3 { x, y, z } = Vector3::from_slice(v);
        Self { x, y, z }
    }
}
