//! Messages and services of `matpoint_msgs`: `msgs/` says what the fields mean.

use super::standard::Header;
use super::{Bytes, interfaces};
pub use ::matpoint::messages::{ComponentState, LoadState, Probe, Reaction, SceneDescription, VariableDescription};

interfaces! {
    /// A value for a load.
    "matpoint_msgs/LoadCommand" LoadCommand { header: Header, name: String, kind: String, value: Vec<f64>, hold: f64 }
    /// What is simulated.
    "matpoint_msgs/Describe.response" DescribeResponse { scene: SceneDescription }
    /// A variable to read.
    "matpoint_msgs/GetVariable.request" GetVariableRequest { name: String }
    /// Its values.
    "matpoint_msgs/GetVariable.response" GetVariableResponse {
        success: bool, message: String, time: f64, variable: VariableDescription, values: Vec<f64>,
    }
    /// An input to set.
    "matpoint_msgs/SetVariable.request" SetVariableRequest { name: String, values: Vec<f64> }
    /// Whether it was.
    "matpoint_msgs/SetVariable.response" SetVariableResponse { success: bool, message: String }
    /// Where to save.
    "matpoint_msgs/SaveState.request" SaveStateRequest { path: String }
    /// What was saved.
    "matpoint_msgs/SaveState.response" SaveStateResponse { success: bool, message: String, time: f64, snapshot: Bytes }
    /// What to restore.
    "matpoint_msgs/RestoreState.request" RestoreStateRequest { path: String, snapshot: Bytes }
    /// Whether it was.
    "matpoint_msgs/RestoreState.response" RestoreStateResponse { success: bool, message: String, time: f64 }
    /// Where to record.
    "matpoint_msgs/Record.request" RecordRequest { path: String }
    /// What was recorded.
    "matpoint_msgs/Record.response" RecordResponse { success: bool, message: String, files: Vec<String> }
}
