//! Runs for the [Rerun](https://rerun.io) viewer: as an `.rrd` file, or live.

mod layout;
mod logger;
mod read;

pub(super) use read::{RrdReader, repair};

use super::background::Writer;
use super::data::{About, Item};
use super::{RecordError, options};
use ::re_log_encoding::{Encoder, EncodingOptions};
use ::rerun::log::LogMsg;
use ::rerun::sink::MemorySinkStorage;
use logger::Logger;
use std::fs::File;
use std::io::BufWriter;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Bytes of frames after which what was logged goes to the file.
const DRAIN: usize = 16 << 20;

/// Writes an `.rrd` file: chunks compressed with LZ4, footer, blueprint. What was flushed before a kill can be read.
///
/// The encoder is driven here and not by the SDK, so that an error of the disk is an error of the recording.
pub(crate) struct RrdWriter {
    path: PathBuf,
    force: bool,
    open: Option<Open>,
}

struct Open {
    logger: Logger,
    storage: MemorySinkStorage,
    encoder: Encoder<BufWriter<File>>,
    pending: usize,
}

impl RrdWriter {
    pub(crate) fn new(path: &Path, force: bool) -> Self {
        Self { path: path.to_path_buf(), force, open: None }
    }
}

fn encoder(file: File) -> Result<Encoder<BufWriter<File>>, ::re_log_encoding::EncodeError> {
    let version = ::rerun::build_info().version;
    Encoder::new_eager(version, EncodingOptions::PROTOBUF_COMPRESSED, BufWriter::with_capacity(1 << 20, file))
}

impl Open {
    fn drain(&mut self, path: &Path) -> Result<(), RecordError> {
        self.pending = 0;
        self.storage.take().iter().try_for_each(|message| self.encoder.append(message).map(drop)).map_err(RecordError::format(path))
    }
}

impl Writer for RrdWriter {
    fn open(&mut self, about: Arc<About>) -> Result<(), RecordError> {
        let file = options::create(&self.path, self.force)?;
        let fail = |error: ::rerun::RecordingStreamError| RecordError::format(&self.path)(error);
        let (stream, storage) = logger::builder(&about).memory().map_err(fail)?;
        let encoder = encoder(file).map_err(RecordError::format(&self.path))?;
        let logger = Logger::new(stream, about).map_err(RecordError::format(&self.path))?;
        let mut open = Open { logger, storage, encoder, pending: 0 };
        open.drain(&self.path)?;
        self.open = Some(open);
        // What is in the file at once: who it is of.
        self.flush()
    }

    fn write(&mut self, item: &Item) -> Result<(), RecordError> {
        let Some(open) = &mut self.open else { return Ok(()) };
        open.logger.log(item).map_err(RecordError::format(&self.path))?;
        if let Item::Frame(frame) = item {
            open.pending += frame.values.iter().map(|values| 4 * values.len()).sum::<usize>();
        }
        if open.pending > DRAIN { open.drain(&self.path) } else { Ok(()) }
    }

    fn flush(&mut self) -> Result<(), RecordError> {
        let Some(open) = &mut self.open else { return Ok(()) };
        open.drain(&self.path)?;
        open.encoder.flush_blocking().map_err(RecordError::format(&self.path))
    }

    fn close(&mut self) -> Result<Vec<PathBuf>, RecordError> {
        self.flush()?;
        let Some(mut open) = self.open.take() else { return Ok(Vec::new()) };
        // Now that the range of the colours is known, every frame gets them.
        open.logger.legend().map_err(RecordError::format(&self.path))?;
        read::colors(&self.path, open.logger.range(), &mut |message: &LogMsg| {
            open.encoder.append(message).map(drop).map_err(RecordError::format(&self.path))
        })?;
        open.drain(&self.path)?;
        open.encoder.finish().map_err(RecordError::format(&self.path))?;
        let out = open.encoder.into_inner().map_err(RecordError::format(&self.path))?;
        out.into_inner().map_err(|e| RecordError::write(&self.path)(e.into_error()))?;
        Ok(vec![self.path.clone()])
    }
}

/// Shows a run in a viewer while it is computed. The range of the colours grows with what is seen.
pub(crate) struct LiveWriter {
    url: String,
    logger: Option<Logger>,
}

impl LiveWriter {
    pub(crate) fn new(url: &str) -> Self {
        Self { url: url.to_owned(), logger: None }
    }
}

impl Writer for LiveWriter {
    fn open(&mut self, about: Arc<About>) -> Result<(), RecordError> {
        let path = Path::new(&self.url);
        let stream = logger::builder(&about).connect_grpc_opts(self.url.clone()).map_err(RecordError::format(path))?;
        let logger = Logger::new(stream, about).map_err(RecordError::format(path))?;
        self.logger = Some(logger.colored());
        Ok(())
    }

    fn write(&mut self, item: &Item) -> Result<(), RecordError> {
        self.logger.as_mut().map_or(Ok(()), |logger| logger.log(item)).map_err(RecordError::format(Path::new(&self.url)))
    }

    fn flush(&mut self) -> Result<(), RecordError> {
        let flush = |logger: &Logger| logger.stream().flush_with_timeout(std::time::Duration::from_secs(5));
        self.logger.as_ref().map_or(Ok(()), flush).map_err(RecordError::format(Path::new(&self.url)))
    }

    fn close(&mut self) -> Result<Vec<PathBuf>, RecordError> {
        self.flush().map(|()| Vec::new())
    }

    fn is_live(&self) -> bool {
        true
    }
}
