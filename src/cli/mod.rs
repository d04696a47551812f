//! What the commands do. They see a scene and a simulation from outside, as any adapter does.

mod describe;
mod inspect;
mod ros2;
mod run;
mod study;

pub(crate) use describe::{check, describe, schema};
pub(crate) use inspect::{inspect, replay};
pub(crate) use run::run;
pub(crate) use study::{gallery, study, throughput};

use crate::SceneArgs;
use matpoint::Simulation;
use matpoint::record::{RecordError, RunError};
use matpoint::scene::{Scene, SceneError};
use std::path::PathBuf;
use std::process::ExitCode;

/// Why a command did not do what it was asked for.
#[derive(Debug, thiserror::Error)]
pub(crate) enum Failure {
    /// Every fault of the scene, a line each.
    #[error("{0}")]
    Scene(#[from] SceneError),
    /// A file name with an ending that nothing is written for.
    #[error("`{}` does not end in `.{ending}`: --{option} writes .{ending} files", path.display())]
    Ending { option: &'static str, path: PathBuf, ending: &'static str },
    /// A file cannot be opened; nothing was computed.
    #[error("{0}")]
    Open(RecordError),
    /// A recording would be written over itself.
    #[error("`{}` is the recording itself; --to takes another file", .0.display())]
    Itself(PathBuf),
    /// The node publishes, and there is none.
    #[error(
        "--to ros2 needs matpoint-node, which is neither beside this program nor on PATH, and MATPOINT_NODE does not say where it is.\n\
         Build it: cargo build --release -p matpoint-ros2\n\
         Or publish with ROS 2 itself: matpoint replay RUN --to mcap, then ros2 bag play RUN.mcap"
    )]
    NoNode,
    /// The node is there and does not start.
    #[error("cannot start `{}`: {error}; build it: cargo build --release -p matpoint-ros2", node.display())]
    Start { node: PathBuf, error: std::io::Error },
    /// Arguments for the node where it has no part.
    #[error("what stands behind `--` is for the ROS 2 node: it goes with --to ros2 only")]
    NodeArguments,
    /// The gallery cannot be made.
    #[error("{0}")]
    Gallery(#[from] matpoint::study::GalleryError),
    /// The thread pool cannot be made.
    #[error("--threads: {0}")]
    Threads(#[from] rayon::ThreadPoolBuildError),
    /// A step or a recording failed on the way.
    #[error("the run failed: {error}{}", kept(files))]
    Run { error: RunError, files: Vec<PathBuf> },
    /// The report cannot be written.
    #[error("{0}")]
    Report(RecordError),
    /// Findings or tables of a study came out differently from what is known.
    #[error("{count} of the results are unexpected")]
    Unexpected { count: usize },
    /// The summary cannot be read from the simulation.
    #[error(transparent)]
    Component(#[from] matpoint::component::ComponentError),
    /// Standard output is closed or full.
    #[error("cannot write to standard output: {0}")]
    Output(#[from] std::io::Error),
}

impl Failure {
    pub(crate) fn exit_code(&self) -> ExitCode {
        match self {
            Self::Run { .. } | Self::Gallery(_) | Self::Report(_) | Self::Unexpected { .. } | Self::Component(_) | Self::Output(_) => {
                ExitCode::from(1)
            }
            _ => ExitCode::from(2),
        }
    }
}

/// What a failed run leaves.
fn kept(files: &[PathBuf]) -> String {
    if files.is_empty() {
        return String::new();
    }
    let names: Vec<String> = files.iter().map(|file| file.display().to_string()).collect();
    format!("\nrecorded until then: {}", names.join(", "))
}

/// Says on standard error what can be simulated but is seldom wise.
fn warn(scene: &Scene) {
    for warning in matpoint::scene::check::warnings(scene) {
        // Not `eprintln!`: that panics where stderr is closed.
        let _ = std::io::Write::write_all(&mut std::io::stderr(), format!("warning: {warning}\n").as_bytes());
    }
}

fn load(args: &SceneArgs) -> Result<Simulation, Failure> {
    Ok(Simulation::load(&args.scene, &args.overrides)?)
}
