//! `matpoint-node SCENE`: the command.

use clap::Parser;
use matpoint::Simulation;
use matpoint_ros2::args;
use matpoint_ros2::args::Level;
use matpoint_ros2::session::Running;
use matpoint_ros2::start::start;
use signal_hook::consts::{SIGINT, SIGTERM};
use std::io::Write;
use std::num::NonZeroUsize;
use std::path::PathBuf;
use std::process::ExitCode;

/// Simulates a scene as a ROS 2 node.
///
/// After the scene come ROS arguments: --ros-args -r __ns:=/lab -p real_time_factor:=0.5 --params-file FILE. `ros2 param describe
/// /matpoint NAME` tells what a parameter is.
#[derive(Parser)]
#[command(name = "matpoint-node", version)]
struct Cli {
    /// Scene file, TOML or JSON.
    scene: PathBuf,
    /// Sets a value of the scene differently, such as grid.cell=0.1; may be given several times.
    #[arg(long = "set", value_name = "KEY=VALUE", value_parser = key_value)]
    set: Vec<(String, String)>,
    /// Threads of the solver; results do not depend on it.
    #[arg(long, value_name = "N")]
    threads: Option<NonZeroUsize>,
}

fn key_value(text: &str) -> Result<(String, String), String> {
    match text.split_once('=') {
        Some((key, value)) if !key.trim().is_empty() => Ok((key.trim().to_owned(), value.trim().to_owned())),
        _ => Err("expected KEY=VALUE, such as grid.cell=0.1".to_owned()),
    }
}

fn main() -> ExitCode {
    // DDS logs much that is normal, as errors too; it is silent unless asked for.
    if std::env::var_os("RUST_LOG").is_some() {
        env_logger::init();
    }
    match run() {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            // Not `eprintln!`: that panics where stderr is closed.
            let _ = writeln!(std::io::stderr(), "{error}");
            ExitCode::FAILURE
        }
    }
}

fn run() -> Result<(), Box<dyn std::error::Error>> {
    let (ours, ros) = args::split(std::env::args())?;
    let cli = Cli::parse_from(ours);
    if let Some(threads) = cli.threads {
        rayon::ThreadPoolBuilder::new().num_threads(threads.get()).build_global()?;
    }
    let sim = Simulation::load(&cli.scene, &cli.set)?;
    let started = start(sim, &ros)?;
    let inbox = started.inbox.clone();
    let mut signals = signal_hook::iterator::Signals::new([SIGINT, SIGTERM])?;
    std::thread::Builder::new().name("signals".into()).spawn(move || {
        let mut signals = signals.forever();
        if signals.next().is_some() {
            inbox.send_blocking(Box::new(|session| session.running = Running::Quitting));
        }
        // Whoever asks twice does not want to wait for the step under way.
        if signals.next().is_some() {
            std::process::exit(130);
        }
    })?;
    let session = &started.session;
    let (title, particles) = (&session.description.title, session.description.particles);
    session.outlets.log(Level::Info, format!("{title}: {particles} particles, {} as {}", cli.scene.display(), session.name));
    started.run();
    Ok(())
}
