//! A file that keeps its first error to itself until asked: the library must never see one, as it panics when it is dropped after some.

use std::fs::File;
use std::io::{BufWriter, Error, Result, Seek, SeekFrom, Write};
use std::sync::{Arc, Mutex, PoisonError};

/// The file. After an error nothing is written any more, and everything seems to go well.
pub(super) struct Latch {
    file: BufWriter<File>,
    failure: Failure,
    /// Where the next byte belongs.
    position: u64,
    /// Length of what was written.
    end: u64,
}

/// The first error of a [`Latch`].
#[derive(Clone, Default)]
pub(super) struct Failure(Arc<Mutex<Option<Error>>>);

impl Failure {
    /// The error, if there was one: told once, "failed before" afterwards.
    pub(super) fn check(&self) -> Result<()> {
        let mut slot = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        match slot.take() {
            Some(error) => {
                *slot = Some(Error::other("it failed before"));
                Err(error)
            }
            None => Ok(()),
        }
    }

    fn is_set(&self) -> bool {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).is_some()
    }

    fn note(&self, outcome: Result<()>) {
        if let Err(error) = outcome {
            self.0.lock().unwrap_or_else(PoisonError::into_inner).get_or_insert(error);
        }
    }
}

impl Latch {
    pub(super) fn new(file: File) -> (Self, Failure) {
        let failure = Failure::default();
        (Self { file: BufWriter::with_capacity(1 << 20, file), failure: failure.clone(), position: 0, end: 0 }, failure)
    }

    /// Hands the last bytes to the system.
    pub(super) fn finish(mut self) {
        let _ = self.flush();
    }

    fn attempt(&mut self, work: impl FnOnce(&mut BufWriter<File>) -> Result<()>) {
        if !self.failure.is_set() {
            let outcome = work(&mut self.file);
            self.failure.note(outcome);
        }
    }
}

impl Write for Latch {
    fn write(&mut self, bytes: &[u8]) -> Result<usize> {
        self.attempt(|file| file.write_all(bytes));
        self.position += bytes.len() as u64;
        self.end = self.end.max(self.position);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> Result<()> {
        self.attempt(Write::flush);
        Ok(())
    }
}

impl Seek for Latch {
    fn seek(&mut self, to: SeekFrom) -> Result<u64> {
        let before = self.position;
        self.position = match to {
            SeekFrom::Start(position) => position,
            SeekFrom::Current(by) => self.position.saturating_add_signed(by),
            SeekFrom::End(by) => self.end.saturating_add_signed(by),
        };
        // Asking where it is must not empty the buffer.
        if self.position != before {
            let position = self.position;
            self.attempt(|file| file.seek(SeekFrom::Start(position)).map(drop));
        }
        Ok(self.position)
    }
}
