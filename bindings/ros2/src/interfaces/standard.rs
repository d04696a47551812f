//! Messages of the standard packages.

use super::interfaces;
pub use ::matpoint::messages::{Clock, DiagnosticArray, DiagnosticStatus, Header, KeyValue, Point, PointCloud2, PointField, Time, Vector3};

interfaces! {
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
}
