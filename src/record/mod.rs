//! 7 DATA OUT: what a run leaves behind. Sinks see a [`Simulation`] from outside, as any adapter does.
//!
//! A [`Recorder`] knows when each [`Sink`] is due; [`run`] steps a simulation from one such time to the next. What no sink asks for is never
//! computed. Where a run stops to record is said by the scene alone, so a result does not depend on who listens.

mod background;
mod choose;
mod columns;
mod compare;
mod csv;
mod data;
mod energy;
mod error;
mod lattice;
#[cfg(feature = "mcap")]
mod mcap;
mod options;
mod particles;
mod picture;
mod read;
mod recorder;
#[cfg(feature = "rerun")]
mod rerun;
mod run;
mod vtk;

pub use choose::Chosen;
pub use compare::{Comparison, Difference, compare};
pub use csv::CsvSink;
pub use data::{About, Column, Event, Frame, Item, Level, Row, Snapshot};
pub use energy::EnergyWatch;
pub use error::RecordError;
#[cfg(feature = "mcap")]
pub use mcap::Messages;
pub use options::{Options, Precision, RosNames, WhenFull};
pub use particles::{pressure, von_mises};
pub(crate) use picture::encode;
pub use picture::{PictureSink, picture_of, sheet};
pub use read::{Recording, Repair, repair};
pub use recorder::Recorder;
pub use run::{Progress, RunError, Summary, run};

use crate::Simulation;
use std::path::{Path, PathBuf};

/// Somewhere that data of a run goes. A sink opens its files in [`begin`](Self::begin), not before.
pub trait Sink: Send {
    /// Called once before the first step; opens the files, so that a path that cannot be written is found before any work is done.
    fn begin(&mut self, sim: &mut Simulation) -> Result<(), RecordError>;

    /// Called at every particle frame; `step` is the number of substeps taken since time 0.
    fn frame(&mut self, sim: &mut Simulation, step: u64) -> Result<(), RecordError> {
        let _ = (sim, step);
        Ok(())
    }

    /// Called at every row of energies and probes; `step` is the number of substeps taken since time 0.
    fn history(&mut self, sim: &mut Simulation, step: u64) -> Result<(), RecordError> {
        let _ = (sim, step);
        Ok(())
    }

    /// Called when something happened that the one who looks at the recording should know.
    fn event(&mut self, sim: &Simulation, level: Level, text: &str) -> Result<(), RecordError> {
        let _ = (sim, level, text);
        Ok(())
    }

    /// Called once at the end, also of a run that failed: `sim` is then where it was before the failed step.
    fn finish(&mut self, sim: &mut Simulation) -> Result<(), RecordError> {
        let _ = sim;
        Ok(())
    }

    /// The files that are complete, for the user to open.
    fn files(&self) -> Vec<PathBuf> {
        Vec::new()
    }

    /// Frames and rows that were not recorded because the recording could not keep up.
    fn dropped(&self) -> u64 {
        0
    }
}

/// What recordings may end in, with what is written then.
const ENDINGS: &[(&str, &str)] = &[
    #[cfg(feature = "mcap")]
    ("mcap", "ROS 2, Foxglove"),
    #[cfg(feature = "rerun")]
    ("rrd", "Rerun"),
    ("pvd", "ParaView"),
    ("svg", "a picture of the last state"),
    #[cfg(feature = "png")]
    ("png", "the same"),
];

/// The sink for a path, by its ending: `.mcap` for ROS 2 and Foxglove, `.rrd` for Rerun, `.pvd` for ParaView, `.svg` for a picture of the last
/// state, none for a folder of CSV tables. `rerun+http://127.0.0.1:9876/proxy` is a Rerun viewer that looks on.
///
/// # Errors
/// An ending that nothing is written for.
pub fn sink_for(path: &Path, options: &Options) -> Result<Box<dyn Sink>, RecordError> {
    if let Some(writer) = writer_for(path, options.force) {
        return Ok(Box::new(background::Background::new(writer, options)));
    }
    match ending(path).as_deref() {
        Some("svg") => Ok(Box::new(PictureSink::new(path).force(options.force))),
        #[cfg(feature = "png")]
        Some("png") => Ok(Box::new(PictureSink::new(path).force(options.force))),
        None => Ok(Box::new(CsvSink::new(path).force(options.force))),
        Some(_) => Err(RecordError::Ending { path: path.to_path_buf() }),
    }
}

fn ending(path: &Path) -> Option<String> {
    path.extension().map(|ending| ending.to_string_lossy().to_lowercase())
}

/// The format for a path, if it is one that works on a thread of its own.
fn writer_for(path: &Path, force: bool) -> Option<Box<dyn background::Writer>> {
    #[cfg(feature = "rerun")]
    if let Some(url) = path.to_str().filter(|path| path.starts_with("rerun+") || path.starts_with("rerun://")) {
        return Some(Box::new(rerun::LiveWriter::new(url)));
    }
    match ending(path)?.as_str() {
        #[cfg(feature = "mcap")]
        "mcap" => Some(Box::new(mcap::McapWriter::new(path, force))),
        #[cfg(feature = "rerun")]
        "rrd" => Some(Box::new(rerun::RrdWriter::new(path, force))),
        "pvd" => Some(Box::new(vtk::VtkWriter::new(path, force))),
        _ => None,
    }
}

/// Writes a picture, given as SVG, to a file that ends in `.svg` or `.png`.
///
/// # Errors
/// A file that is there already and not to be written over, or cannot be written; another ending.
pub fn write_picture(path: &Path, svg: String, force: bool) -> Result<(), RecordError> {
    if !matches!(ending(path).as_deref(), Some("svg" | "png")) {
        return Err(RecordError::Ending { path: path.to_path_buf() });
    }
    options::free(path, force)?;
    let mut draft = crate::draft::Draft::create(path)?;
    draft.write_bytes(&encode(path, svg)?)?;
    draft.finish().map(drop)
}

/// Writes a recording again, in the format that `to` ends in.
///
/// # Errors
/// A recording that cannot be read, a file that cannot be written, an ending that recordings are not written for.
pub fn replay(from: Recording, to: &Path, force: bool) -> Result<Vec<PathBuf>, RecordError> {
    let mut writer = writer_for(to, force).ok_or_else(|| RecordError::Ending { path: to.to_path_buf() })?;
    writer.open(from.about().clone())?;
    for item in from {
        writer.write(&item?)?;
    }
    writer.close()
}

impl<S: Sink + ?Sized> Sink for &mut S {
    fn begin(&mut self, sim: &mut Simulation) -> Result<(), RecordError> {
        (**self).begin(sim)
    }
    fn frame(&mut self, sim: &mut Simulation, step: u64) -> Result<(), RecordError> {
        (**self).frame(sim, step)
    }
    fn history(&mut self, sim: &mut Simulation, step: u64) -> Result<(), RecordError> {
        (**self).history(sim, step)
    }
    fn event(&mut self, sim: &Simulation, level: Level, text: &str) -> Result<(), RecordError> {
        (**self).event(sim, level, text)
    }
    fn finish(&mut self, sim: &mut Simulation) -> Result<(), RecordError> {
        (**self).finish(sim)
    }
    fn dropped(&self) -> u64 {
        (**self).dropped()
    }
    fn files(&self) -> Vec<PathBuf> {
        (**self).files()
    }
}
