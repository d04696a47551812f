//! `matpoint run`.

use super::{Failure, warn};
use crate::RunArgs;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use matpoint::Simulation;
use matpoint::component::{ComponentError, Description, Fallback};
use matpoint::record::{self, CsvSink, EnergyWatch, Options, Progress, Recording, RunError, Sink, Summary};
use matpoint::text::{digits, duration, grouped, pairs, rate, si};
use std::io::Write;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// Ticks of the progress bar from start to end.
const TICKS: u64 = 1000;

/// Runs a scene, records it, prints a summary.
pub(crate) fn run(args: &RunArgs) -> Result<(), Failure> {
    let mut files = file_sinks(args)?;
    if let Some(threads) = args.threads {
        rayon::ThreadPoolBuilder::new().num_threads(threads.into()).build_global()?;
    }
    let mut sim = start(args)?;
    warn(sim.scene());
    let until = args.until.unwrap_or(sim.scene().time.end);
    let mut watch = EnergyWatch::default();
    let particles = sim.describe().particles;
    let bar = progress_bar(args.quiet);
    let start = Instant::now();

    let mut sinks: Vec<&mut dyn Sink> = vec![&mut watch];
    sinks.extend(files.iter_mut().map(|sink| &mut **sink as &mut dyn Sink));
    let outcome = record::run(&mut sim, until, &mut sinks, &mut |at| show(&bar, at, particles, start));
    bar.finish_and_clear();
    let written: Vec<PathBuf> = files.iter().flat_map(|sink| sink.files()).collect();
    let dropped = files.iter().map(|sink| sink.dropped()).sum();
    let summary = outcome.map_err(|error| match error {
        RunError::Begin(error) => Failure::Open(error),
        error => Failure::Run { error, files: written.clone() },
    })?;
    print(args, &mut sim, &summary, &watch, start.elapsed().as_secs_f64(), &written, dropped)
}

/// The simulation at its start: of a scene, or of a snapshot.
fn start(args: &RunArgs) -> Result<Simulation, Failure> {
    let Some((path, time)) = &args.from else {
        return Ok(Simulation::load(args.scene.as_deref().unwrap_or(Path::new("")), &args.overrides)?);
    };
    let (scene, snapshot) = Recording::open(path).and_then(|recording| recording.snapshot(*time)).map_err(Failure::Open)?;
    let mut sim = scene.build()?;
    sim.restore(&snapshot.bytes)?;
    Ok(sim)
}

/// The sinks asked for. No file is opened yet; a stream that cannot be undone comes last.
fn file_sinks(args: &RunArgs) -> Result<Vec<Box<dyn Sink>>, Failure> {
    let options = Options {
        force: args.force,
        variables: args.variables.clone(),
        precision: args.precision,
        snapshots: args.snapshots,
        when_full: args.when_full,
        keep_going: args.keep_going,
        cells: args.cells,
        ..Options::default()
    };
    if let Some(path) = args.picture.as_ref().filter(|path| !["svg", "png"].iter().any(|e| path.extension().is_some_and(|x| x == *e))) {
        return Err(Failure::Ending { option: "picture", path: path.clone(), ending: "svg" });
    }
    // A folder may have a dot in its name.
    let tables = args.csv.iter().map(|folder| Box::new(CsvSink::new(folder).force(args.force)) as Box<dyn Sink>);
    let others = args.picture.iter().chain(&args.record).map(|path| record::sink_for(path, &options).map_err(Failure::Open));
    tables.map(Ok).chain(others).collect()
}

/// A bar on stderr; indicatif draws nothing where that is no terminal.
fn progress_bar(quiet: bool) -> ProgressBar {
    let target = if quiet { ProgressDrawTarget::hidden() } else { ProgressDrawTarget::stderr() };
    let style = ProgressStyle::with_template("{bar:30} {percent:>3} %  {msg}").unwrap_or_else(|_| ProgressStyle::default_bar());
    ProgressBar::with_draw_target(Some(TICKS), target).with_style(style)
}

fn show(bar: &ProgressBar, at: Progress, particles: usize, start: Instant) {
    if bar.is_hidden() {
        return;
    }
    let share = at.time / at.until;
    let elapsed = start.elapsed().as_secs_f64();
    let speed = at.substeps as f64 * particles as f64 / elapsed;
    let left = if share > 0.0 { duration((elapsed / share - elapsed).ceil()) } else { "-".to_owned() };
    bar.set_message(format!("t = {} / {} s  {}  {left} left", digits(at.time), digits(at.until), rate(speed)));
    bar.set_position((share * TICKS as f64) as u64);
}

/// Where the last step was of a lower order than its method, in words.
fn lower_order(Fallback { cells, nodes, contacts }: Fallback) -> Option<String> {
    let parts = [
        (cells, "cells integrated at their particles"),
        (nodes, "nodes with little of a body and none to follow"),
        (contacts, "nodes in contact"),
    ];
    let parts: Vec<String> = parts.iter().filter(|(count, _)| *count > 0).map(|(count, what)| format!("{count} {what}")).collect();
    (!parts.is_empty()).then(|| format!("in the last step {}", parts.join(", ")))
}

/// The summary on standard output.
fn print(
    args: &RunArgs,
    sim: &mut Simulation,
    summary: &Summary,
    watch: &EnergyWatch,
    wall: f64,
    files: &[PathBuf],
    dropped: u64,
) -> Result<(), Failure> {
    let description = sim.describe();
    let particle_steps = summary.substeps as f64 * description.particles as f64;
    let mut rows = vec![
        ("time", format!("{} s", digits(summary.end))),
        ("particles", grouped(description.particles as u64)),
        ("steps", format!("{}, the smallest {}", grouped(summary.substeps), si(summary.smallest_step, "s"))),
        ("wall time", format!("{}, {}", duration(wall), rate(particle_steps / wall))),
    ];
    if summary.iterations > 0 {
        let each = summary.iterations as f64 / summary.substeps as f64;
        let solver = if sim.residuals().is_empty() { "mass matrix" } else { "Newton" };
        rows.push((solver, format!("{} iterations, {} a step", grouped(summary.iterations), digits(each))));
    }
    rows.extend(lower_order(sim.fallback()).map(|text| ("lower order", text)));
    let energies = ["kinetic", "strain", "external", "total"].map(|kind| {
        let name = format!("energy/{kind}");
        Ok::<String, ComponentError>(format!("{kind} {}", value(sim, &description, &name)?))
    });
    rows.push(("energy", energies.into_iter().collect::<Result<Vec<_>, _>>()?.join(", ")));
    rows.push(("energy drift", format!("{} of the largest kinetic + strain energy", digits(watch.drift()))));
    rows.push(("momentum", value(sim, &description, "momentum/linear")?));
    for (name, label) in
        [("error/displacement", "displacement error"), ("error/velocity", "velocity error"), ("error/stress", "stress error")]
    {
        if let Some(unit) = unit(&description, name) {
            let error = sim.get(name)?;
            // A reference from a file knows some times only.
            let known = error.iter().all(|e| e.is_finite());
            let text = format!("RMS {} {unit}, largest {} {unit}", digits(error[0]), digits(error[1]));
            rows.push((label, if known { text } else { "the solution is not known at this time".to_owned() }));
        }
    }
    let mut out = std::io::stdout().lock();
    writeln!(out, "{}", description.title)?;
    write!(out, "{}", pairs(rows))?;
    for file in files {
        writeln!(out, "wrote {}", file.display())?;
    }
    if dropped > 0 {
        writeln!(out, "{dropped} frames and rows dropped: the recording could not keep up")?;
    }
    for path in &args.record {
        match path.extension().and_then(|ending| ending.to_str()) {
            Some("rrd") => writeln!(out, "open with: rerun {}", path.display())?,
            Some("pvd") => writeln!(out, "open with: paraview {}", path.display())?,
            Some("mcap") => writeln!(out, "open with: foxglove-studio {0}, or: ros2 bag play {0}", path.display())?,
            _ => {}
        }
    }
    if let (Some(scene), true, true) = (&args.scene, files.is_empty(), args.record.is_empty()) {
        writeln!(out, "nothing recorded; to see it: matpoint run {} --picture last.svg", scene.display())?;
    }
    Ok(())
}

fn unit(description: &Description, name: &str) -> Option<&'static str> {
    description.variables.iter().find(|variable| variable.name == name).map(|variable| variable.unit)
}

/// A small variable as text: `12.3 mJ`, `(1, 2) kg m/s`.
fn value(sim: &mut Simulation, description: &Description, name: &str) -> Result<String, ComponentError> {
    let unit = unit(description, name).unwrap_or_default();
    Ok(match sim.get(name)? {
        [single] => si(*single, unit),
        several => format!("({}) {unit}", several.iter().map(|&v| digits(v)).collect::<Vec<_>>().join(", ")),
    })
}
