//! 7 DATA OUT: what a run leaves behind. Sinks see a [`Simulation`] from outside, as any adapter does.
//!
//! A [`Recorder`] knows when each [`Sink`] is due; [`run`] steps a simulation from one such time to the next. What no sink asks for is never
//! computed. Where a run stops to record is said by the scene alone, so a result does not depend on who listens.

mod background;
mod columns;
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

pub use csv::CsvSink;
pub use data::{About, Column, Event, Frame, Item, Level, Row, Snapshot};
pub use energy::EnergyWatch;
pub use error::RecordError;
pub use options::{Options, Precision, WhenFull};
pub use picture::PictureSink;
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
];

/// The sink for a path, by its ending: `.mcap` for ROS 2 and Foxglove, `.rrd` for Rerun, `.pvd` for ParaView, `.svg` for a picture of the last
/// state, none for a folder of CSV tables. `rerun+http://127.0.0.1:9876/proxy` is a Rerun viewer that looks on.
///
/// # Errors
/// An ending that nothing is written for.
pub fn sink_for(path: &Path, options: &Options) -> Result<Box<dyn Sink>, RecordError> {
    let background = |writer: Box<dyn background::Writer>| Box::new(background::Background::new(writer, options));
    #[cfg(feature = "rerun")]
    if let Some(url) = path.to_str().filter(|path| path.starts_with("rerun+") || path.starts_with("rerun://")) {
        return Ok(background(Box::new(rerun::LiveWriter::new(url))));
    }
    let ending = path.extension().map(|ending| ending.to_string_lossy().to_lowercase());
    match ending.as_deref() {
        #[cfg(feature = "mcap")]
        Some("mcap") => Ok(background(Box::new(mcap::McapWriter::new(path, options.force)))),
        #[cfg(feature = "rerun")]
        Some("rrd") => Ok(background(Box::new(rerun::RrdWriter::new(path, options.force)))),
        Some("pvd") => Ok(background(Box::new(vtk::VtkWriter::new(path, options.force)))),
        Some("svg") => Ok(Box::new(PictureSink::new(path).force(options.force))),
        None => Ok(Box::new(CsvSink::new(path).force(options.force))),
        Some(_) => Err(RecordError::Ending { path: path.to_path_buf() }),
    }
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
