//! `matpoint inspect` and `matpoint replay`.

use super::Failure;
use crate::{InspectArgs, ReplayArgs};
use matpoint::record::{self, Item, Level, Recording, Repair, picture_of};
use matpoint::text::{bytes, digits, grouped, pairs, table};
use std::io::Write;
use std::path::{Path, PathBuf};

/// Tells what is in a recording; repairs it first where it was cut off.
pub(crate) fn inspect(args: &InspectArgs) -> Result<(), Failure> {
    let repaired = record::repair(&args.run);
    // A folder that cannot be written to does not keep anybody from reading.
    let note = match &repaired {
        Ok(Repair::NotNeeded) => None,
        Ok(Repair::Done) => Some("was cut off; all that could be read has its index again".to_owned()),
        Ok(Repair::BeingWritten) => Some("is being written".to_owned()),
        Err(error) => Some(format!("was cut off and cannot be repaired: {error}")),
    };
    if let Some(name) = &args.csv {
        return csv(&args.run, name);
    }
    if let Some(path) = &args.picture {
        let svg = picture_of(&args.run, args.frames).map_err(Failure::Open)?;
        record::write_picture(path, svg, args.force).map_err(Failure::Open)?;
        writeln!(std::io::stdout().lock(), "wrote {}", path.display())?;
        return Ok(());
    }
    if let Some(other) = &args.compare {
        return compare(&args.run, other);
    }
    summary(&args.run, note)
}

fn summary(path: &Path, note: Option<String>) -> Result<(), Failure> {
    let recording = Recording::open(path).map_err(Failure::Open)?;
    let about = recording.about().clone();
    let (mut frames, mut rows) = (0u64, 0u64);
    let mut range = [f64::INFINITY, f64::NEG_INFINITY];
    let (mut events, mut snapshots) = (Vec::new(), Vec::new());
    let mut energy = record::EnergyWatch::default();
    for item in recording {
        let time = match item.map_err(Failure::Open)? {
            Item::Frame(frame) => {
                frames += 1;
                frame.time
            }
            Item::Row(row) => {
                rows += 1;
                if let Some([kinetic, strain, total]) = about.energies(&row) {
                    energy.see(kinetic, strain, total);
                }
                row.time
            }
            Item::Event(event) => {
                let time = event.time;
                events.push(event);
                time
            }
            Item::Snapshot(snapshot) => {
                snapshots.push(digits(snapshot.time));
                snapshot.time
            }
        };
        range = [range[0].min(time), range[1].max(time)];
    }
    let size = std::fs::metadata(path)?.len();
    let mut lines = Vec::new();
    lines.extend(note.map(|note| ("file", note)));
    lines.push(("made by", format!("matpoint {} {}", about.version, about.commit.get(..12).unwrap_or_default())));
    lines.push(("dimension", about.dimension().to_string()));
    lines.push(("particles", grouped(about.description.particles as u64)));
    lines
        .push(("method", about.description.method.iter().map(|(what, choice)| format!("{what}: {choice}")).collect::<Vec<_>>().join("; ")));
    lines.push(("recorded", about.columns.iter().map(|c| c.name.as_str()).collect::<Vec<_>>().join(", ")));
    lines.push(("frames, rows", format!("{frames}, {rows}")));
    if range[0] <= range[1] {
        lines.push(("time", format!("{} to {} s", digits(range[0]), digits(range[1]))));
    }
    let each = size as f64 / (frames.max(1) as f64 * about.description.particles as f64);
    lines.push(("size", format!("{}, {} bytes a particle and frame", bytes(size as usize), digits(each))));
    lines.push(("energy drift", format!("{} of the largest kinetic + strain energy", digits(energy.drift()))));
    if !snapshots.is_empty() {
        lines.push(("snapshots", format!("at {} s", snapshots.join(", "))));
    }
    let mut out = std::io::stdout().lock();
    writeln!(out, "{}\n{}", about.scene.title, pairs(lines))?;
    for event in events {
        let word = match event.level {
            Level::Info => "info",
            Level::Warning => "warning",
            Level::Error => "error",
        };
        writeln!(out, "  t = {} s  {word}: {}", digits(event.time), event.text)?;
    }
    let variables = about.variables().into_iter().map(|(name, unit)| [name, unit]);
    writeln!(out, "variables, for --csv\n{}", table(["name", "unit"], &variables.collect::<Vec<_>>()))?;
    Ok(())
}

/// A table on standard output: of a series a line each time, of a column of particles a line each time and particle.
fn csv(path: &Path, name: &str) -> Result<(), Failure> {
    let recording = Recording::open(path).map_err(Failure::Open)?;
    let chosen = recording.about().choose(name).map_err(Failure::Open)?;
    let mut out = std::io::BufWriter::new(std::io::stdout().lock());
    writeln!(out, "{}", chosen.header())?;
    for item in recording {
        chosen.lines(&item.map_err(Failure::Open)?, &mut |line| out.write_all(line.as_bytes()))?;
    }
    out.flush()?;
    Ok(())
}

fn compare(first: &Path, second: &Path) -> Result<(), Failure> {
    let comparison = record::compare(first, second).map_err(Failure::Open)?;
    let mut out = std::io::stdout().lock();
    for (name, unit, size, list) in &comparison.columns {
        let unit = if unit.is_empty() { String::new() } else { format!(" [{unit}]") };
        writeln!(out, "{name}{unit}, root mean square {}", digits(*size))?;
        let rows: Vec<[String; 3]> = list.iter().map(|d| [format!("{}", d.time), digits(d.rms), digits(d.largest)]).collect();
        writeln!(out, "{}", table(["time [s]", "rms difference", "largest"], &rows))?;
    }
    if !comparison.same_particles {
        writeln!(out, "other particles: fields of {} were interpolated", second.display())?;
    }
    if comparison.unmatched > 0 {
        writeln!(out, "{} frames of one have no frame of the other at their time", comparison.unmatched)?;
    }
    Ok(())
}

/// Writes a recording in another format, or publishes it.
pub(crate) fn replay(args: &ReplayArgs) -> Result<(), Failure> {
    if args.to.as_os_str() == "ros2" {
        return Err(super::ros2::replay(&args.run, &args.node));
    }
    if !args.node.is_empty() {
        return Err(Failure::NodeArguments);
    }
    let to = match args.to.to_str() {
        Some("rrd") => args.run.with_extension("rrd"),
        Some("mcap") => args.run.with_extension("mcap"),
        Some("vtk") => args.run.with_extension("pvd"),
        _ => args.to.clone(),
    };
    if to == args.run {
        return Err(Failure::Itself(to));
    }
    let recording = Recording::open(&args.run).map_err(Failure::Open)?;
    let files: Vec<PathBuf> = record::replay(recording, &to, args.force).map_err(Failure::Open)?;
    files.iter().try_for_each(|file| writeln!(std::io::stdout().lock(), "wrote {}", file.display()))?;
    Ok(())
}
