//! 7 DATA OUT: what a run leaves behind. Sinks see a [`Simulation`] from outside, as any adapter does.
//!
//! A [`Recorder`] knows when each [`Sink`] is due; [`run`] steps a simulation from one such time to the next. What no sink asks for is never
//! computed. Where a run stops to record is said by the scene alone, so a result does not depend on who listens.

mod columns;
mod csv;
mod energy;
mod particles;
mod picture;
mod recorder;
#[cfg(feature = "rerun")]
mod rerun;
mod run;

pub use csv::CsvSink;
pub use energy::EnergyWatch;
pub use picture::PictureSink;
pub use recorder::Recorder;
#[cfg(feature = "rerun")]
pub use rerun::RerunSink;
pub use run::{Progress, RunError, Summary, run};

use crate::Simulation;
use crate::component::ComponentError;
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

    /// Called once at the end, also of a run that failed: `sim` is then where it was before the failed step.
    fn finish(&mut self, sim: &mut Simulation) -> Result<(), RecordError> {
        let _ = sim;
        Ok(())
    }

    /// The files that are complete, for the user to open.
    fn files(&self) -> Vec<PathBuf> {
        Vec::new()
    }
}

/// The sink for a path, by its ending: `.rrd` for Rerun, `.svg` for a picture of the last state, none for a folder of CSV tables.
///
/// # Errors
/// An ending that nothing is written for.
pub fn sink_for(path: &Path) -> Result<Box<dyn Sink>, RecordError> {
    let ending = path.extension().map(|ending| ending.to_string_lossy().to_lowercase());
    match ending.as_deref() {
        #[cfg(feature = "rerun")]
        Some("rrd") => Ok(Box::new(RerunSink::new(path))),
        Some("svg") => Ok(Box::new(PictureSink::new(path))),
        None => Ok(Box::new(CsvSink::new(path))),
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
    fn finish(&mut self, sim: &mut Simulation) -> Result<(), RecordError> {
        (**self).finish(sim)
    }
    fn files(&self) -> Vec<PathBuf> {
        (**self).files()
    }
}

#[cfg(feature = "rerun")]
const RERUN: &str = ".rrd (Rerun), ";
#[cfg(not(feature = "rerun"))]
const RERUN: &str = "";

/// A recording that could not be made.
#[derive(Debug, thiserror::Error)]
pub enum RecordError {
    /// Nothing is written for files with that ending.
    #[error("`{}`: recordings end in {}.svg (a picture of the last state), or have no ending (a folder of CSV tables)", path.display(), RERUN)]
    Ending {
        /// The file asked for.
        path: PathBuf,
    },
    /// A file cannot be created, written or renamed.
    #[error("cannot write `{}`: {source}", path.display())]
    Write {
        /// The file, or the folder that should hold it.
        path: PathBuf,
        /// What the system says.
        source: std::io::Error,
    },
    /// A variable cannot be read.
    #[error(transparent)]
    Component(#[from] ComponentError),
    /// The Rerun recording cannot be written.
    #[cfg(feature = "rerun")]
    #[error("cannot write `{}`: {source}", path.display())]
    Rerun {
        /// The recording.
        path: PathBuf,
        /// What Rerun says.
        source: Box<::rerun::RecordingStreamError>,
    },
    /// The end of the Rerun recording did not reach the file.
    #[cfg(feature = "rerun")]
    #[error("cannot write `{}`: {source}", path.display())]
    Flush {
        /// The recording.
        path: PathBuf,
        /// What Rerun says.
        source: Box<::rerun::sink::SinkFlushError>,
    },
}

impl RecordError {
    /// For `map_err` on file operations.
    pub(crate) fn write(path: &Path) -> impl FnOnce(std::io::Error) -> Self + '_ {
        move |source| Self::Write { path: path.to_path_buf(), source }
    }
}
