//! Recordings read back: the same items that were recorded, whatever the format.

use super::RecordError;
use super::data::{About, Item, Snapshot};
use crate::scene::Scene;
use std::fs::File;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// A format that can be read.
pub(crate) trait Reader: Iterator<Item = Result<Item, RecordError>> {
    /// What the recording is of.
    fn about(&self) -> &Arc<About>;
    /// Whether the file was completed.
    fn is_whole(&self) -> bool;
}

/// A recording, read item by item in the order of time. A file that was cut off ends early.
pub struct Recording {
    path: PathBuf,
    reader: Box<dyn Reader>,
}

impl Recording {
    /// Opens an `.mcap` or `.rrd` recording.
    ///
    /// # Errors
    /// A file that cannot be read, or is no recording of matpoint.
    pub fn open(path: &Path) -> Result<Self, RecordError> {
        let reader: Option<Box<dyn Reader>> = None;
        #[cfg(feature = "mcap")]
        let reader = if is(path, "mcap") { Some(Box::new(super::mcap::McapReader::open(path)?) as Box<dyn Reader>) } else { reader };
        #[cfg(feature = "rerun")]
        let reader = if is(path, "rrd") { Some(Box::new(super::rerun::RrdReader::open(path)?) as Box<dyn Reader>) } else { reader };
        let reader = reader.ok_or_else(|| {
            RecordError::content(path, "cannot be read back: .mcap and .rrd can (where this matpoint was built with them)")
        })?;
        Ok(Self { path: path.to_path_buf(), reader })
    }

    /// What it is of.
    pub fn about(&self) -> &Arc<About> {
        self.reader.about()
    }

    /// Whether the file was completed; one that is being written, or whose writer died, was not.
    pub fn is_whole(&self) -> bool {
        self.reader.is_whole()
    }

    /// Where it is.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The snapshot at a time, to a billionth.
    ///
    /// # Errors
    /// No such snapshot: the error lists the times of those that there are.
    pub fn snapshot(self, time: f64) -> Result<(Scene, Snapshot), RecordError> {
        let (path, scene) = (self.path.clone(), self.about().scene.clone());
        let mut times = Vec::new();
        for item in self {
            if let Item::Snapshot(snapshot) = item? {
                if (snapshot.time - time).abs() <= 1e-9 * time.abs().max(1.0) {
                    return Ok((scene, snapshot));
                }
                times.push(format!("{}", snapshot.time));
            }
        }
        let reason = match times.as_slice() {
            [] => "has no snapshots: record it with --snapshots SECONDS".to_owned(),
            _ => format!("has no snapshot at {time} s; it has some at {} s", times.join(", ")),
        };
        Err(RecordError::content(&path, reason))
    }
}

impl Iterator for Recording {
    type Item = Result<Item, RecordError>;
    fn next(&mut self) -> Option<Self::Item> {
        self.reader.next()
    }
}

/// What a recording is of, from what stands in it.
#[cfg(any(feature = "mcap", feature = "rerun"))]
pub(super) fn rebuild(path: &Path, scene: &str, version: String, commit: String, options: &super::Options) -> Result<About, RecordError> {
    let parsed = Scene::from_toml(scene).and_then(Scene::build);
    let mut sim = parsed.map_err(|error| RecordError::content(path, format!("holds a scene that this matpoint cannot read: {error}")))?;
    Ok(About { version, commit, ..About::new(&mut sim, options)? })
}

/// What became of a file that was cut off.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Repair {
    /// It is whole.
    NotNeeded,
    /// Its index was written again.
    Done,
    /// Somebody writes it.
    BeingWritten,
}

/// Gives a recording that was cut off its index again, so that every reader takes it. What can be read stays as it is; the file is replaced
/// only when the new one is whole. A file that is being written is left alone.
///
/// # Errors
/// A file that is no recording, or a folder that cannot be written to.
pub fn repair(path: &Path) -> Result<Repair, RecordError> {
    if Recording::open(path)?.is_whole() {
        return Ok(Repair::NotNeeded);
    }
    let file = File::open(path).map_err(RecordError::read(path))?;
    if let Err(std::fs::TryLockError::WouldBlock) = file.try_lock() {
        return Ok(Repair::BeingWritten);
    }
    let part = path.with_added_extension("part");
    let to = File::create(&part).map_err(RecordError::write(&part))?;
    match mend(path, to).and_then(|()| std::fs::rename(&part, path).map_err(RecordError::write(path))) {
        Ok(()) => Ok(Repair::Done),
        Err(error) => {
            let _ = std::fs::remove_file(&part);
            Err(error)
        }
    }
}

/// Writes what can be read of a recording to another file.
fn mend(path: &Path, to: File) -> Result<(), RecordError> {
    #[cfg(feature = "mcap")]
    if is(path, "mcap") {
        return super::mcap::repair(path, to);
    }
    #[cfg(feature = "rerun")]
    if is(path, "rrd") {
        return super::rerun::repair(path, to);
    }
    drop(to);
    Err(RecordError::content(path, "is of a format that this matpoint was built without"))
}

#[cfg(any(feature = "mcap", feature = "rerun"))]
fn is(path: &Path, format: &str) -> bool {
    super::ending(path).as_deref() == Some(format)
}
