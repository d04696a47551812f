//! Replays through ROS 2: done by `matpoint-node`, as this program has no DDS in it.

use super::Failure;
use std::env;
use std::ffi::OsString;
use std::io::Error;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Becomes `matpoint-node --replay RUN ARGS`. Returns only if that fails.
pub(super) fn replay(run: &Path, args: &[OsString]) -> Failure {
    let Some(node) = find() else { return Failure::NoNode };
    let error = become_process(Command::new(&node).arg("--replay").arg(run).args(args));
    Failure::Start { node, error }
}

/// The node that MATPOINT_NODE says, else the one beside this program, else the first on PATH.
fn find() -> Option<PathBuf> {
    if let Some(node) = env::var_os("MATPOINT_NODE").filter(|node| !node.is_empty()) {
        return Some(node.into());
    }
    let beside = env::current_exe().ok().and_then(|own| Some(own.parent()?.to_path_buf()));
    let path = env::var_os("PATH").unwrap_or_default();
    let name = format!("matpoint-node{}", env::consts::EXE_SUFFIX);
    beside.into_iter().chain(env::split_paths(&path)).map(|folder| folder.join(&name)).find(|node| node.is_file())
}

/// Signals and the exit code are those of the node: it has the place of this process.
#[cfg(unix)]
fn become_process(command: &mut Command) -> Error {
    std::os::unix::process::CommandExt::exec(command)
}

#[cfg(not(unix))]
fn become_process(command: &mut Command) -> Error {
    match command.status() {
        Ok(status) => std::process::exit(status.code().unwrap_or(1)),
        Err(error) => error,
    }
}
