//! A file that appears only when it is whole.

use crate::record::RecordError;
use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};

/// Writes to `NAME.part` and takes the name when finished, so that a run that dies leaves an older file as it was.
pub(crate) struct Draft {
    path: PathBuf,
    part: PathBuf,
    out: Option<BufWriter<File>>,
}

impl Draft {
    /// Opens the file; its folder must be there.
    pub(crate) fn create(path: &Path) -> Result<Self, RecordError> {
        let mut part = path.as_os_str().to_owned();
        part.push(".part");
        let part = PathBuf::from(part);
        // Found now, not after an hour of computing.
        if path.is_dir() {
            return Err(RecordError::Write { path: path.to_path_buf(), source: std::io::ErrorKind::IsADirectory.into() });
        }
        let file = File::create(&part).map_err(RecordError::write(path))?;
        Ok(Self { path: path.to_path_buf(), part, out: Some(BufWriter::new(file)) })
    }

    /// Writes `text` at the end.
    pub(crate) fn write(&mut self, text: &str) -> Result<(), RecordError> {
        self.write_bytes(text.as_bytes())
    }

    /// Writes `bytes` at the end.
    pub(crate) fn write_bytes(&mut self, bytes: &[u8]) -> Result<(), RecordError> {
        match &mut self.out {
            Some(out) => out.write_all(bytes).map_err(RecordError::write(&self.path)),
            None => Ok(()),
        }
    }

    /// Gives the file its name, which is returned.
    pub(crate) fn finish(mut self) -> Result<PathBuf, RecordError> {
        if let Some(mut out) = self.out.take() {
            out.flush().map_err(RecordError::write(&self.path))?;
            std::fs::rename(&self.part, &self.path).map_err(RecordError::write(&self.path))?;
        }
        Ok(std::mem::take(&mut self.path))
    }
}

impl Drop for Draft {
    fn drop(&mut self) {
        // Nobody is left to hear of an error here; the worst that stays is a `.part` file.
        if self.out.take().is_some() {
            let _ = std::fs::remove_file(&self.part);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn old_file_stays_until_the_new_one_is_whole() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.csv");
        std::fs::write(&path, "old").unwrap();
        let mut draft = Draft::create(&path).unwrap();
        draft.write("new").unwrap();
        drop(draft);
        assert_eq!(std::fs::read_to_string(&path).unwrap(), "old");
        assert_eq!(std::fs::read_dir(dir.path()).unwrap().count(), 1);
        let mut draft = Draft::create(&path).unwrap();
        draft.write("new").unwrap();
        assert_eq!(draft.finish().unwrap(), path);
        assert_eq!(std::fs::read_to_string(&path).unwrap(), "new");
        assert_eq!(std::fs::read_dir(dir.path()).unwrap().count(), 1);
    }
}
