//! `matpoint-node SCENE` and `matpoint-node --replay RUN`: the command.

use clap::Parser;
use matpoint::Simulation;
use matpoint_ros2::args;
use matpoint_ros2::args::{Level, RosArgs};
use matpoint_ros2::replay::Replay;
use matpoint_ros2::session::Running;
use matpoint_ros2::start::start;
use signal_hook::consts::{SIGINT, SIGTERM};
use std::io::Write;
use std::num::NonZeroUsize;
use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Duration;

/// Simulates a scene as a ROS 2 node, or publishes a recording.
///
/// After the scene or the recording come ROS arguments: --ros-args -r __ns:=/lab -p real_time_factor:=0.5 --params-file FILE. `ros2 param describe
/// /matpoint NAME` tells what a parameter is.
#[derive(Parser)]
#[command(name = "matpoint-node", version, arg_required_else_help = true)]
#[command(after_help = "Examples:
  matpoint-node beam.toml                                  simulates it
  matpoint-node beam.toml --ros-args -p record:=beam.mcap  and records it
  matpoint-node --replay beam.mcap                         publishes what was recorded
  matpoint-node --replay beam.mcap --loop --ros-args -p real_time_factor:=0.5")]
struct Cli {
    /// Scene file, TOML or JSON.
    #[arg(required_unless_present = "replay")]
    scene: Option<PathBuf>,
    /// Sets a value of the scene differently, such as grid.cell=0.1; may be given several times.
    #[arg(long = "set", value_name = "KEY=VALUE", value_parser = key_value)]
    set: Vec<(String, String)>,
    /// Threads of the solver; results do not depend on it.
    #[arg(long, value_name = "N")]
    threads: Option<NonZeroUsize>,
    /// Publishes a recording (.mcap, or .rrd if built with rerun) instead: particles, state, clock, diagnostics and scene, by the name of the
    /// node that made it; ends after that.
    #[arg(long, value_name = "RUN", conflicts_with_all = ["scene", "set", "threads"])]
    replay: Option<PathBuf>,
    /// How long the replay waits for the first subscriber [s].
    #[arg(long, value_name = "T", default_value = "5", value_parser = seconds, requires = "replay")]
    wait: Duration,
    /// Begins the replay again when it is through.
    #[arg(long = "loop", requires = "replay")]
    repeat: bool,
}

fn seconds(text: &str) -> Result<Duration, String> {
    let time = text.parse().ok().and_then(|time| Duration::try_from_secs_f64(time).ok());
    // One that would never end is a slip of the hand.
    time.filter(|time| *time < Duration::from_secs(1 << 32)).ok_or_else(|| "expected a number of seconds, 0 or more".to_owned())
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
    if let Some(recording) = &cli.replay {
        let replay = Replay::start(recording, &ros)?;
        let stop = replay.stop();
        on_signal(move || stop.now())?;
        return Ok(replay.run(cli.wait, cli.repeat)?);
    }
    simulate(&cli, &ros)
}

fn simulate(cli: &Cli, ros: &RosArgs) -> Result<(), Box<dyn std::error::Error>> {
    let scene = cli.scene.as_deref().ok_or("a scene is missing, or --replay RUN")?;
    if let Some(threads) = cli.threads {
        rayon::ThreadPoolBuilder::new().num_threads(threads.get()).build_global()?;
    }
    let sim = Simulation::load(scene, &cli.set)?;
    let started = start(sim, ros)?;
    let inbox = started.inbox.clone();
    on_signal(move || inbox.send_blocking(Box::new(|session| session.running = Running::Quitting)))?;
    let session = &started.session;
    let (title, particles) = (&session.description.title, session.description.particles);
    session.outlets.log(Level::Info, format!("{title}: {particles} particles, {} as {}", scene.display(), session.name));
    started.run();
    Ok(())
}

/// Ends at SIGINT and SIGTERM.
fn on_signal(end: impl FnOnce() + Send + 'static) -> std::io::Result<()> {
    let mut signals = signal_hook::iterator::Signals::new([SIGINT, SIGTERM])?;
    std::thread::Builder::new().name("signals".into()).spawn(move || {
        let mut signals = signals.forever();
        if signals.next().is_some() {
            end();
        }
        // Whoever asks twice does not want to wait for the step under way.
        if signals.next().is_some() {
            std::process::exit(130);
        }
    })?;
    Ok(())
}
