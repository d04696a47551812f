//! How something is recorded.

use super::RecordError;
#[cfg(any(feature = "mcap", feature = "rerun"))]
use std::fs::File;
use std::path::Path;
use std::str::FromStr;

/// How a sink records. The default suits most.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Options {
    /// Write over what is there; without it an existing recording is an error.
    pub force: bool,
    /// Variables of the particles beside the position, such as `velocity`, `von_mises`; the usual ones if left out.
    pub variables: Option<Vec<String>>,
    /// How floating-point numbers of particles are stored.
    pub precision: Precision,
    /// Simulated time between snapshots, from which a run can be started again \[s\]; none if left out.
    pub snapshots: Option<f64>,
    /// What happens while the recording cannot keep up; files wait and live views drop if left out.
    pub when_full: Option<WhenFull>,
    /// Whether the cells of the background grid that hold particles are recorded, for Rerun.
    pub cells: bool,
    /// Names that an `.mcap` recording uses.
    pub ros: RosNames,
    /// A recording that fails does not stop the simulation; the error is told at the end.
    pub keep_going: bool,
}

/// Names that an `.mcap` recording uses: those of the ROS 2 node that would publish the same.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RosNames {
    /// Full name of the node, before that of its topics.
    pub node: String,
    /// Frame of all positions and vectors.
    pub frame: String,
}

impl Default for RosNames {
    fn default() -> Self {
        Self { node: "/matpoint".into(), frame: "map".into() }
    }
}

/// How floating-point numbers of particles are stored.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Precision {
    /// 32 bits: what viewers show.
    #[default]
    Single,
    /// 64 bits: what was computed.
    Double,
}

/// What happens while frames come faster than they are written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum WhenFull {
    /// The simulation waits.
    Wait,
    /// Frames and rows are dropped and counted.
    Drop,
}

impl FromStr for Precision {
    type Err = String;
    fn from_str(text: &str) -> Result<Self, String> {
        match text {
            "f32" => Ok(Self::Single),
            "f64" => Ok(Self::Double),
            _ => Err("expected f32 or f64".into()),
        }
    }
}

impl FromStr for WhenFull {
    type Err = String;
    fn from_str(text: &str) -> Result<Self, String> {
        match text {
            "wait" => Ok(Self::Wait),
            "drop" => Ok(Self::Drop),
            _ => Err("expected wait or drop".into()),
        }
    }
}

/// Refuses a path where something is, unless `force`.
pub(super) fn free(path: &Path, force: bool) -> Result<(), RecordError> {
    if !force && path.exists() { Err(RecordError::Exists { path: path.to_path_buf() }) } else { Ok(()) }
}

/// Makes the file of a recording. It is locked while it is written, so that nobody repairs it under the hands of its writer.
#[cfg(any(feature = "mcap", feature = "rerun"))]
pub(super) fn create(path: &Path, force: bool) -> Result<File, RecordError> {
    free(path, force)?;
    let file = File::options().write(true).create(true).truncate(false).open(path).map_err(RecordError::write(path))?;
    if let Err(std::fs::TryLockError::WouldBlock) = file.try_lock() {
        return Err(RecordError::Busy { path: path.to_path_buf() });
    }
    // What was there is gone only now that nobody else writes it. Devices cannot be cut, and need not be.
    let _ = file.set_len(0);
    Ok(file)
}
