//! What can go wrong while something is recorded or read back.

use super::ENDINGS;
use crate::component::ComponentError;
use std::path::{Path, PathBuf};

/// A recording that could not be made or read.
#[derive(Debug, thiserror::Error)]
pub enum RecordError {
    /// Nothing is written for files with that ending.
    #[error("`{}`: recordings end in {}, or have no ending (a folder of CSV tables){}", path.display(), endings(), missing(path))]
    Ending {
        /// The file asked for.
        path: PathBuf,
    },
    /// Something is there already.
    #[error("`{}` exists; what writes over it is --force (in code `force`, of the ROS node `record.force`)", path.display())]
    Exists {
        /// What is there.
        path: PathBuf,
    },
    /// Another process writes the file.
    #[error("`{}` is being written by another process", path.display())]
    Busy {
        /// The file.
        path: PathBuf,
    },
    /// There is no such variable of particles.
    #[error("no variable `{name}`{}; there are {known}", nearest.as_ref().map(|n| format!(", did you mean `{n}`?")).unwrap_or_default())]
    Variable {
        /// The name asked for.
        name: String,
        /// The nearest right name.
        nearest: Option<String>,
        /// All of them.
        known: String,
    },
    /// A file cannot be created, written or renamed.
    #[error("cannot write `{}`: {source}", path.display())]
    Write {
        /// The file, or the folder that should hold it.
        path: PathBuf,
        /// What the system says.
        source: std::io::Error,
    },
    /// A file cannot be read.
    #[error("cannot read `{}`: {source}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// What the system says.
        source: std::io::Error,
    },
    /// A file is no recording, or not one of this program.
    #[error("`{}` {reason}", path.display())]
    Content {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        reason: String,
    },
    /// A variable cannot be read.
    #[error(transparent)]
    Component(#[from] ComponentError),
    /// A format cannot be written.
    #[error("cannot write `{}`: {source}", path.display())]
    Format {
        /// The recording.
        path: PathBuf,
        /// What its library says.
        source: Box<dyn std::error::Error + Send + Sync>,
    },
    /// No thread can be had.
    #[error("no thread to record on: {source}")]
    Spawn {
        /// What the system says.
        source: std::io::Error,
    },
    /// The thread that records has panicked.
    #[error("the recording ended with a fault of the program that writes it")]
    Thread,
}

impl RecordError {
    /// For `map_err` on file operations.
    pub(crate) fn write(path: &Path) -> impl FnOnce(std::io::Error) -> Self + '_ {
        move |source| Self::Write { path: path.to_path_buf(), source }
    }
    /// For `map_err` on file operations.
    pub(crate) fn read(path: &Path) -> impl FnOnce(std::io::Error) -> Self + '_ {
        move |source| Self::Read { path: path.to_path_buf(), source }
    }
    /// For `map_err` on what libraries say.
    #[cfg(any(feature = "mcap", feature = "rerun"))]
    pub(crate) fn format<E: Into<Box<dyn std::error::Error + Send + Sync>>>(path: &Path) -> impl FnOnce(E) -> Self + '_ {
        move |source| Self::Format { path: path.to_path_buf(), source: source.into() }
    }
    /// A file with something wrong about it: `reason` goes on after its name.
    pub(crate) fn content(path: &Path, reason: impl Into<String>) -> Self {
        Self::Content { path: path.to_path_buf(), reason: reason.into() }
    }
}

fn endings() -> String {
    ENDINGS.iter().map(|(ending, what)| format!(".{ending} ({what})")).collect::<Vec<_>>().join(", ")
}

/// How to get what this program was built without.
fn missing(path: &Path) -> String {
    let known = ["mcap", "rrd"].into_iter().zip(["mcap", "rerun"]);
    let asked = known.filter(|(ending, _)| path.extension().is_some_and(|e| e.eq_ignore_ascii_case(ending))).map(|(_, feature)| feature);
    asked.map(|feature| format!("; this matpoint was built without it: cargo build --release --features {feature}")).collect()
}
