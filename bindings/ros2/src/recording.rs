//! Recordings while the node runs: started and ended by the parameter `record` or by the service `~/record`.

use crate::args::Level;
use crate::interfaces::matpoint::{RecordRequest, RecordResponse};
use crate::node::{NodeError, Ros};
use crate::parameters::Value;
use crate::session::Session;
use matpoint::Simulation;
use matpoint::record::{CsvSink, RecordError, Recorder, Sink};
use std::path::{Path, PathBuf};

/// A recording that cannot begin.
#[derive(Debug, thiserror::Error)]
pub enum RecordingError {
    /// The path is taken.
    #[error("`{}` exists; recordings do not overwrite anything", .0.display())]
    Exists(PathBuf),
    /// Neither a Rerun file nor a folder.
    #[error("`{}` ends in .{ending}; a recording is a file that ends in .rrd, or a folder for CSV", path.display())]
    Ending {
        /// As given.
        path: PathBuf,
        /// Its ending.
        ending: String,
    },
    /// Built without.
    #[error("this node was built without the feature `rerun`: it cannot write .rrd; give a folder for CSV")]
    NoRerun,
    /// A sink fails.
    #[error(transparent)]
    Sink(#[from] RecordError),
}

/// Opens a recording at `path`; particle frames every `every` simulated seconds, 0 for what the scene says.
///
/// # Errors
/// A path that is taken or of no known kind; a file that cannot be made.
pub fn begin(sim: &mut Simulation, path: &Path, every: f64) -> Result<Recorder<'static>, RecordingError> {
    let taken = path.is_file() || path.is_dir() && std::fs::read_dir(path).is_ok_and(|mut entries| entries.next().is_some());
    if taken {
        return Err(RecordingError::Exists(path.to_path_buf()));
    }
    let sink: Box<dyn Sink> = match path.extension().map(|ending| ending.to_string_lossy().to_ascii_lowercase()).as_deref() {
        #[cfg(feature = "rerun")]
        Some("rrd") => Box::new(matpoint::record::RerunSink::new(path)),
        #[cfg(not(feature = "rerun"))]
        Some("rrd") => return Err(RecordingError::NoRerun),
        Some(ending) => return Err(RecordingError::Ending { path: path.to_path_buf(), ending: ending.to_owned() }),
        None => Box::new(CsvSink::new(path)),
    };
    Ok(Recorder::begin(sim, vec![sink], (every > 0.0).then_some(every), None)?)
}

/// Serves `~/record`.
///
/// # Errors
/// DDS refuses.
pub fn serve(ros: &mut Ros) -> Result<(), NodeError> {
    ros.serve("~/record", "matpoint_msgs", "Record", |session, request: RecordRequest, reply| {
        let changed = session.parameters.set(vec![("record".into(), Value::Text(request.path))], false).map_err(|e| e.to_string());
        let outcome = changed.and_then(|()| session.follow_record_parameter());
        let message = outcome.as_ref().err().cloned().unwrap_or_default();
        let files = outcome.iter().flatten().map(|file| file.display().to_string()).collect();
        reply.send(RecordResponse { success: outcome.is_ok(), message, files });
    })
}

impl Session {
    /// Begins and ends recordings so that what the parameter `record` says is recorded. Gives the files that were completed by that.
    ///
    /// # Errors
    /// The old recording cannot be closed, or the new one not begun; nothing is recorded then.
    pub fn follow_record_parameter(&mut self) -> Result<Vec<PathBuf>, String> {
        let wanted = self.parameters.settings.record.clone();
        if self.recording.as_ref().is_some_and(|(path, _)| *path == wanted) {
            return Ok(Vec::new());
        }
        let files = self.end_recording()?;
        if wanted.is_empty() {
            return Ok(files);
        }
        match begin(&mut self.sim, Path::new(&wanted), self.parameters.settings.record_every) {
            Ok(recorder) => {
                self.outlets.log(Level::Info, format!("recording to {wanted}"));
                self.recording = Some((wanted, recorder));
                Ok(files)
            }
            Err(error) => {
                self.forget_record_parameter();
                Err(error.to_string())
            }
        }
    }

    /// Closes the recording under way.
    ///
    /// # Errors
    /// It cannot be closed.
    pub fn end_recording(&mut self) -> Result<Vec<PathBuf>, String> {
        let Some((path, recorder)) = self.recording.take() else { return Ok(Vec::new()) };
        let files = recorder.finish(&mut self.sim).map_err(|error| error.to_string())?;
        self.outlets.log(Level::Info, format!("recorded {path}"));
        Ok(files)
    }

    /// Offers the state to the recording under way, and gives that up when it fails: the simulation goes on.
    pub fn record(&mut self) {
        let Some((path, recorder)) = &mut self.recording else { return };
        if let Err(error) = recorder.offer(&mut self.sim) {
            self.outlets.log(Level::Error, format!("recording to {path} ended: {error}"));
            let _ = self.end_recording();
            self.forget_record_parameter();
        }
    }

    fn forget_record_parameter(&mut self) {
        // An empty text is always allowed.
        let _ = self.parameters.set(vec![("record".into(), Value::Text(String::new()))], false);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use matpoint::scene::Scene;

    #[test]
    fn recordings_are_whole_and_overwrite_nothing() {
        let scene = concat!(env!("CARGO_MANIFEST_DIR"), "/../../launch_scripts/scenes/cantilever.toml");
        let mut sim = Scene::load(scene).unwrap().build().unwrap();
        let folder = std::env::temp_dir().join(format!("matpoint-recording-{}", std::process::id()));
        let mut recorder = begin(&mut sim, &folder, 0.02).unwrap();
        for _ in 0..10 {
            sim.step(0.01).unwrap();
            recorder.offer(&mut sim).unwrap();
        }
        let files = recorder.finish(&mut sim).unwrap();
        assert!(!files.is_empty() && files.iter().all(|f| f.starts_with(&folder) && f.is_file()));
        let again = begin(&mut sim, &folder, 0.02).err().unwrap();
        std::fs::remove_dir_all(&folder).unwrap();
        assert!(again.to_string().ends_with("exists; recordings do not overwrite anything"));
        let wrong = begin(&mut sim, Path::new("run.bag"), 0.0).err().unwrap();
        assert_eq!(wrong.to_string(), "`run.bag` ends in .bag; a recording is a file that ends in .rrd, or a folder for CSV");
    }
}
