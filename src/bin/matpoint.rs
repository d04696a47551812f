//! The command `matpoint`: run, check and describe scenes, compare them with papers, print the
//! schema of scene files.
//!
//! Exit codes: 0 done; 1 a run failed; 2 a fault in the scene or the arguments, and then nothing was written.

#[path = "../cli/mod.rs"]
mod cli;

use clap::{Args, Parser, Subcommand};
use cli::Failure;
use matpoint::record::{Precision, WhenFull};
use matpoint::study::{Study, accuracy, papers, throughput};
use std::path::PathBuf;
use std::process::ExitCode;

/// Simulate elastic solids with the material point method.
///
/// A scene is a TOML or JSON file in SI units. `matpoint schema` prints what may stand in it.
#[derive(Parser)]
#[command(name = "matpoint", version, arg_required_else_help = true)]
#[command(after_help = "Examples:
  matpoint check beam.toml                       find every fault of a scene
  matpoint run beam.toml --picture beam.svg      run it, draw the last frame
  matpoint run beam.toml --record beam.rrd       run it, then watch with: rerun beam.rrd

`matpoint help run` has more. Exit codes: 0 done, 1 the run failed, 2 a fault in the scene or the arguments.")]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Run a scene and record it.
    #[command(after_help = RUN_EXAMPLES)]
    Run(RunArgs),
    /// Tell what is in a recording, draw it, compare it; repair one that was cut off.
    #[command(after_help = "Examples:
  matpoint inspect beam.mcap                     scene, method, frames, time, energy drift, events, variables
  matpoint inspect beam.rrd --csv probe/tip/displacement > tip.csv
  matpoint inspect beam.mcap --png beam.png --frames 6
  matpoint inspect fine.mcap --compare coarse.mcap

A recording that was cut off, because its process was killed or the disk was full, gets its index again; all that reached the disk is kept.")]
    Inspect(InspectArgs),
    /// Write a recording in another format, or publish it in ROS 2.
    #[command(after_help = "Examples:
  matpoint replay beam.mcap --to rrd             writes beam.rrd
  matpoint replay beam.rrd --to look/beam.pvd    for ParaView
  matpoint replay beam.mcap --to ros2            publishes it in its own time, by matpoint-node
  matpoint replay beam.mcap --to ros2 -- --loop --ros-args -p real_time_factor:=0.5
  ros2 bag play beam.mcap                        publishes it too: .mcap recordings are bags

matpoint-node (cargo build --release -p matpoint-ros2) is looked for beside this program, then on PATH; MATPOINT_NODE says it is elsewhere.")]
    Replay(ReplayArgs),
    /// Find every fault of a scene without running it.
    #[command(after_help = "Examples:
  matpoint check beam.toml
  matpoint check beam.toml --set grid.cell=0.1   would it be sound on a finer grid?")]
    Check(SceneArgs),
    /// Tell what a scene becomes: method, memory, stable step, variables.
    #[command(after_help = "Examples:
  matpoint describe beam.toml
  matpoint describe beam.toml --set method.transfer=apic")]
    Describe(SceneArgs),
    /// Run many scenes and compare them with what others published.
    #[command(subcommand)]
    Study(StudyCommand),
    /// Print the JSON schema of scene files.
    #[command(after_help = "Examples:
  matpoint schema > scene.schema.json            editors complete and check scene files with it")]
    Schema,
}

#[derive(Subcommand)]
enum StudyCommand {
    /// Run the problems of three papers; write tables, figures and findings beside theirs.
    #[command(after_help = "Examples:
  matpoint study papers                          everything; writes docs/papers.md and docs/papers/
  matpoint study papers --quick --out look       coarse and short cases, in about ten seconds
  matpoint study papers --only T1,T4             some problems only

Exit codes: 0 every finding came out as known, 1 one did not, 2 a fault in the arguments.")]
    Papers(PapersArgs),
    /// Measure how close the simulator comes to known answers: orders of convergence, statics, vibrations, energy, time saved.
    #[command(after_help = "Examples:
  matpoint study accuracy                        everything; writes docs/accuracy.md and docs/accuracy/
  matpoint study accuracy --quick --out look     coarse and short cases, in about a minute
  matpoint study accuracy --only T1,cook         some problems only

Exit codes: 0 every finding came out as known, 1 one did not, 2 a fault in the arguments.")]
    Accuracy(AccuracyArgs),
    /// Measure how fast particles are stepped, beside what the machine can do.
    #[command(after_help = "Examples:
  matpoint study throughput                      everything; writes docs/performance.md
  matpoint study throughput --quick --out look   small scenes, a few repetitions
  matpoint study throughput --only machine,common

Other codes are in it where benches/peers/run has been run in the same folder. Keep the machine free of other work.

Exit codes: 0 every requirement is met (--quick judges none), 1 one is not, 2 a fault in the arguments.")]
    Throughput(ThroughputArgs),
    /// Hold a simulation and step it on orders from standard input: what is timed by `throughput`.
    #[command(hide = true)]
    Stopwatch,
    /// Draw the scenes of the gallery.
    #[command(after_help = "Examples:
  matpoint study gallery                         writes docs/gallery.md and docs/gallery/")]
    Gallery(GalleryArgs),
}

const RUN_EXAMPLES: &str = "Examples:
  matpoint run beam.toml                                    only the summary
  matpoint run beam.toml --record beam.rrd                  then watch with: rerun beam.rrd
  matpoint run beam.toml --record beam.mcap --snapshots 0.5 for ROS 2 and Foxglove, and to go on from
  matpoint run --from beam.mcap@0.5 --record rest.mcap      goes on as if it had not been cut
  matpoint run beam.toml --csv out --picture out/beam.svg   tables and a picture
  matpoint run beam.toml --set material.rubber.young=2e6 --set grid.cell=0.1
  matpoint run beam.toml --until 0.5 --threads 4

How often is recorded stands in the scene: record.every [s] or record.every_steps (frames), record.history [s] (rows).";

#[derive(Args)]
struct SceneArgs {
    /// Scene file: TOML, or JSON with the ending .json.
    scene: PathBuf,
    /// Override a value of the scene, such as grid.cell=0.1; may be given several times.
    #[arg(long = "set", value_name = "KEY=VALUE", value_parser = key_value)]
    overrides: Vec<(String, String)>,
}

#[derive(Args)]
struct RunArgs {
    /// Scene file: TOML, or JSON with the ending .json.
    #[arg(required_unless_present = "from")]
    scene: Option<PathBuf>,
    /// Override a value of the scene, such as grid.cell=0.1; may be given several times.
    #[arg(long = "set", value_name = "KEY=VALUE", value_parser = key_value)]
    overrides: Vec<(String, String)>,
    /// Go on from a snapshot of a recording, such as beam.mcap@0.5, instead of starting a scene.
    #[arg(long, value_name = "RUN@TIME", value_parser = snapshot, conflicts_with_all = ["scene", "overrides"])]
    from: Option<(PathBuf, f64)>,
    /// Record the run: .mcap for ROS 2 and Foxglove, .rrd for Rerun, .pvd for ParaView; may be given several times. A URL such as
    /// rerun+http://127.0.0.1:9876/proxy shows the run in a Rerun viewer while it is computed.
    #[arg(long, value_name = "FILE")]
    record: Vec<PathBuf>,
    /// Write history.csv (energies, probes, reactions) and particles.csv (the last frame) to a folder.
    #[arg(long, value_name = "DIR")]
    csv: Option<PathBuf>,
    /// Draw the last frame; the file ends in .svg or .png.
    #[arg(long, value_name = "FILE")]
    picture: Option<PathBuf>,
    /// Write over recordings, tables and pictures that exist.
    #[arg(long)]
    force: bool,
    /// What to record of each particle beside its position, such as velocity,stress,von_mises.
    #[arg(long, value_name = "NAME,...", value_delimiter = ',')]
    variables: Option<Vec<String>>,
    /// Show the cells of the background grid that hold particles, in .rrd recordings.
    #[arg(long)]
    cells: bool,
    /// How numbers of particles are recorded: f32 or f64.
    #[arg(long, value_name = "f32|f64", default_value = "f32")]
    precision: Precision,
    /// Record a snapshot, from which --from can go on, about every so many simulated seconds, and at the end.
    #[arg(long, value_name = "T", value_parser = seconds)]
    snapshots: Option<f64>,
    /// What happens when recording cannot keep up: the run waits, or frames are dropped and counted [default: wait for files, drop for a
    /// viewer].
    #[arg(long, value_name = "wait|drop")]
    when_full: Option<WhenFull>,
    /// Go on without a recording that fails, for example because the disk is full; the error is told at the end.
    #[arg(long)]
    keep_going: bool,
    /// Stop at this time [s] instead of time.end.
    #[arg(long, value_name = "T", value_parser = seconds, allow_negative_numbers = true)]
    until: Option<f64>,
    /// Number of threads; all cores if left out. The result does not depend on it.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..))]
    threads: Option<u16>,
    /// Show no progress bar.
    #[arg(long, short)]
    quiet: bool,
}

#[derive(Args)]
struct InspectArgs {
    /// Recording: .mcap or .rrd.
    run: PathBuf,
    /// Print a variable as a table instead: its times, and particles where it is one of particles.
    #[arg(long, value_name = "VARIABLE", group = "what")]
    csv: Option<String>,
    /// Draw it instead, without a display; the file ends in .png or .svg.
    #[arg(long, visible_alias = "png", value_name = "FILE", group = "what")]
    picture: Option<PathBuf>,
    /// Frames to draw, on one sheet; the last one only if left out.
    #[arg(long, value_name = "N", default_value_t = 1, requires = "picture")]
    frames: usize,
    /// Print how far another recording is from it over time instead.
    #[arg(long, value_name = "OTHER", group = "what")]
    compare: Option<PathBuf>,
    /// Write over a picture that exists.
    #[arg(long)]
    force: bool,
}

#[derive(Args)]
struct ReplayArgs {
    /// Recording: .mcap or .rrd.
    run: PathBuf,
    /// rrd, mcap or vtk, for a file beside the recording; a file that ends in .rrd, .mcap or .pvd; or ros2, to publish it.
    #[arg(long, value_name = "FORMAT|FILE")]
    to: PathBuf,
    /// Write over a file that exists.
    #[arg(long)]
    force: bool,
    /// With --to ros2, arguments of matpoint-node, such as --loop or --ros-args -p real_time_factor:=0.5.
    #[arg(last = true, value_name = "NODE ARGUMENTS")]
    node: Vec<std::ffi::OsString>,
}

#[derive(Args)]
struct GalleryArgs {
    /// Folder for gallery.md and the folder gallery with its pictures.
    #[arg(long, value_name = "DIR", default_value = "docs")]
    out: PathBuf,
}

#[derive(Args)]
struct StudyArgs {
    /// Coarse and short cases only.
    #[arg(long)]
    quick: bool,
    /// Folder for the report and for the folder of its figures.
    #[arg(long, value_name = "DIR", default_value = "docs")]
    out: PathBuf,
    /// Show no progress bar.
    #[arg(long, short)]
    quiet: bool,
}

#[derive(Args)]
struct PapersArgs {
    #[command(flatten)]
    study: StudyArgs,
    /// Problems to run, such as T1,T4; all if left out.
    #[arg(long, value_name = "ID,...", value_delimiter = ',', value_parser = |text: &str| problem(&papers::STUDY, text))]
    only: Vec<String>,
}

#[derive(Args)]
struct AccuracyArgs {
    #[command(flatten)]
    study: StudyArgs,
    /// Problems to run, such as T1,cook; all if left out.
    #[arg(long, value_name = "ID,...", value_delimiter = ',', value_parser = |text: &str| problem(&accuracy::STUDY, text))]
    only: Vec<String>,
}

#[derive(Args)]
struct ThroughputArgs {
    #[command(flatten)]
    study: StudyArgs,
    /// Parts to measure, such as machine,common; all if left out.
    #[arg(long, value_name = "PART,...", value_delimiter = ',', value_parser = clap::builder::PossibleValuesParser::new(throughput::parts()))]
    only: Vec<String>,
}

fn snapshot(text: &str) -> Result<(PathBuf, f64), String> {
    let split = text.rsplit_once('@').and_then(|(path, time)| Some((PathBuf::from(path), time.parse::<f64>().ok()?)));
    split.filter(|(_, time)| time.is_finite()).ok_or_else(|| "expected RUN@TIME, such as beam.mcap@0.5".to_owned())
}

fn problem(study: &Study, text: &str) -> Result<String, String> {
    let known: Vec<&str> = study.problems().iter().map(|p| p.id).collect();
    match known.iter().find(|id| id.eq_ignore_ascii_case(text)) {
        Some(id) => Ok((*id).to_owned()),
        None => Err(format!("expected one of {}", known.join(", "))),
    }
}

fn key_value(text: &str) -> Result<(String, String), String> {
    match text.split_once('=') {
        Some((key, value)) if !key.trim().is_empty() => Ok((key.trim().to_owned(), value.trim().to_owned())),
        _ => Err("expected KEY=VALUE, such as grid.cell=0.1".to_owned()),
    }
}

fn seconds(text: &str) -> Result<f64, String> {
    match text.parse() {
        Ok(time) if f64::is_finite(time) && time > 0.0 => Ok(time),
        _ => Err("expected a positive number of seconds".to_owned()),
    }
}

fn main() -> ExitCode {
    let outcome = match Cli::parse().command {
        Command::Run(args) => cli::run(&args),
        Command::Inspect(args) => cli::inspect(&args),
        Command::Replay(args) => cli::replay(&args),
        Command::Study(StudyCommand::Gallery(args)) => cli::gallery(&args),
        Command::Check(args) => cli::check(&args),
        Command::Describe(args) => cli::describe(&args),
        Command::Study(StudyCommand::Papers(args)) => cli::study(&papers::STUDY, &args.study, &args.only),
        Command::Study(StudyCommand::Accuracy(args)) => cli::study(&accuracy::STUDY, &args.study, &args.only),
        Command::Study(StudyCommand::Throughput(args)) => cli::throughput(&args.study, &args.only),
        Command::Study(StudyCommand::Stopwatch) => throughput::serve().map_err(Failure::Output),
        Command::Schema => cli::schema(),
    };
    match outcome {
        Ok(()) => ExitCode::SUCCESS,
        // Whoever read our output has seen enough: `matpoint schema | head`.
        Err(Failure::Output(error)) if error.kind() == std::io::ErrorKind::BrokenPipe => ExitCode::SUCCESS,
        Err(failure) => {
            // Not `eprintln!`: that panics where stderr is closed.
            let _ = std::io::Write::write_all(&mut std::io::stderr(), format!("{failure}\n").as_bytes());
            failure.exit_code()
        }
    }
}
