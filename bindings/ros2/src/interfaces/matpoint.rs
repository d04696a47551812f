//! Messages and services of `matpoint_msgs`: `msgs/` says what the fields mean.

use super::standard::{Header, Point, Vector3};
use super::{Bytes, interfaces};

interfaces! {
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
    /// A value for a load.
    "matpoint_msgs/LoadCommand" LoadCommand { header: Header, name: String, kind: String, value: Vec<f64>, hold: f64 }
    /// A variable.
    "matpoint_msgs/VariableDescription" VariableDescription {
        name: String, causality: u8, unit: String, shape: Vec<u32>, doc: String,
    }
    /// What is simulated.
    "matpoint_msgs/SceneDescription" SceneDescription {
        header: Header, title: String, version: String, dimension: u8, particles: u64, bodies: Vec<String>, body_particles: Vec<u64>,
        method: Vec<String>, stable_step: f64, variables: Vec<VariableDescription>,
    }
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
