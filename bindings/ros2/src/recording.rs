//! Recordings while the node runs: started and ended by the parameter `record` or by the service `~/record`.

use crate::args::Level;
use crate::interfaces::matpoint::{RecordRequest, RecordResponse};
use crate::node::{NodeError, Ros};
use crate::parameters::{Settings, Value};
use crate::session::Session;
use matpoint::Simulation;
use matpoint::record::{Options, RecordError, Recorder, RosNames, sink_for};
use std::path::{Path, PathBuf};

/// Begins a recording at `path`; what is recorded is what is published, and has the names of `node`.
fn begin(sim: &mut Simulation, path: &Path, node: &str, settings: &Settings) -> Result<Recorder<'static>, RecordError> {
    let ros = RosNames { node: node.into(), frame: settings.frame_id.clone() };
    let sink = sink_for(path, &Options { ros, ..settings.record_options.clone() })?;
    Recorder::begin(sim, vec![sink], (settings.record_every > 0.0).then_some(settings.record_every), None)
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
        match begin(&mut self.sim, Path::new(&wanted), &self.name, &self.parameters.settings) {
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
    use crate::parameters::Parameters;
    use matpoint::record::{Item, Precision, Recording};
    use matpoint::scene::Scene;

    #[test]
    fn recordings_are_made_as_the_parameters_say_and_written_over_only_if_so_asked() {
        let scene = concat!(env!("CARGO_MANIFEST_DIR"), "/../../launch_scripts/scenes/cantilever.toml");
        let mut sim = Scene::load(scene).unwrap().build().unwrap();
        let mut parameters = Parameters::default();
        let mut set = |name: &str, value| {
            parameters.set(vec![(name.into(), value)], true).unwrap();
            parameters.settings.clone()
        };
        set("frame_id", Value::Text("table".into()));
        set("record.every", Value::Double(0.02));
        set("record.precision", Value::Text("f64".into()));
        set("record.snapshots", Value::Double(0.05));
        let settings = set("record.variables", Value::Texts(vec!["velocity".into()]));
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("run.mcap");
        let mut recorder = begin(&mut sim, &path, "/lab/beam", &settings).unwrap();
        for _ in 0..10 {
            sim.step(0.01).unwrap();
            recorder.offer(&mut sim).unwrap();
        }
        assert_eq!(recorder.finish(&mut sim).unwrap(), std::slice::from_ref(&path));

        let recording = Recording::open(&path).unwrap();
        let about = recording.about().clone();
        assert_eq!((about.ros.node.as_str(), about.ros.frame.as_str()), ("/lab/beam", "table"));
        assert_eq!(about.precision, Precision::Double);
        assert_eq!(about.columns.iter().map(|c| c.name.as_str()).collect::<Vec<_>>(), ["position", "velocity"]);
        let items: Vec<Item> = recording.map(Result::unwrap).collect();
        let frames: Vec<_> = items.iter().filter_map(|item| if let Item::Frame(frame) = item { Some(frame) } else { None }).collect();
        assert_eq!(frames.len(), 6);
        assert_eq!(frames[5].values[1].as_slice(), sim.get("particle/velocity").unwrap());
        assert_eq!(items.iter().filter(|item| matches!(item, Item::Snapshot(_))).count(), 2);
        // The uncompressed part of the file names the topics.
        let text = String::from_utf8_lossy(&std::fs::read(&path).unwrap()).into_owned();
        assert!(
            ["/clock", "/lab/beam/particles", "/lab/beam/state", "/lab/beam/scene", "/rosout"].iter().all(|topic| text.contains(topic))
        );

        let again = begin(&mut sim, &path, "/lab/beam", &settings).err().unwrap().to_string();
        assert!(again.contains("exists") && again.contains("record.force"), "{again}");
        let settings = set("record.force", Value::Bool(true));
        begin(&mut sim, &path, "/lab/beam", &settings).unwrap().finish(&mut sim).unwrap();
        let wrong = begin(&mut sim, Path::new("run.bag"), "/lab/beam", &settings).err().unwrap().to_string();
        assert!(wrong.contains("`run.bag`: recordings end in .mcap"), "{wrong}");
    }
}
