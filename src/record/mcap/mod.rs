//! Runs as [MCAP](https://mcap.dev): what the ROS 2 node would publish, as `ros2 bag play`, Foxglove and Rerun read it.

mod latch;
mod layout;
mod messages;
mod read;

pub use messages::Messages;
pub(super) use read::{McapReader, repair};

use super::background::Writer;
use super::data::{About, Event, Frame, Item, Row, Snapshot};
use super::{RecordError, options};
use crate::messages::{Clock, Time};
use ::mcap::records::{MessageHeader, Metadata};
use ::mcap::{Attachment, Compression, WriteOptions};
use latch::{Failure, Latch};
use std::borrow::Cow;
use std::collections::BTreeMap;
use std::fs::File;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Name of the metadata record.
const METADATA: &str = "matpoint";
/// Name of the attachment with the scene.
const SCENE: &str = "scene.toml";
/// Media type of snapshots.
const SNAPSHOT: &str = "application/x-matpoint-snapshot";

/// Topics with their types; `~` stands for the name of the node.
const TOPICS: [(Topic, &str, &str); 6] = [
    (Topic::Clock, "/clock", "rosgraph_msgs/Clock"),
    (Topic::Particles, "~/particles", "sensor_msgs/PointCloud2"),
    (Topic::State, "~/state", "matpoint_msgs/ComponentState"),
    (Topic::Scene, "~/scene", "matpoint_msgs/SceneDescription"),
    (Topic::Diagnostics, "/diagnostics", "diagnostic_msgs/DiagnosticArray"),
    (Topic::Log, "/rosout", "rcl_interfaces/Log"),
];

#[derive(Clone, Copy)]
enum Topic {
    Clock,
    Particles,
    State,
    Scene,
    Diagnostics,
    Log,
}

/// Writes an `.mcap` file: chunks compressed with zstd, index, statistics, metadata, the scene as an attachment. What was flushed before a kill
/// can be read.
pub(crate) struct McapWriter {
    path: PathBuf,
    force: bool,
    open: Option<Open>,
}

struct Open {
    out: ::mcap::Writer<Latch>,
    failure: Failure,
    channels: [u16; 6],
    sequence: [u32; 6],
    messages: Messages,
    buffer: Vec<u8>,
}

impl McapWriter {
    pub(crate) fn new(path: &Path, force: bool) -> Self {
        Self { path: path.to_path_buf(), force, open: None }
    }
}

/// How files are written; `repair` writes them the same way. Level 1 is three times as fast as the usual one and a few per cent larger.
fn write_options() -> WriteOptions {
    WriteOptions::new()
        .profile("ros2")
        .library(concat!("matpoint ", env!("CARGO_PKG_VERSION")))
        .compression(Some(Compression::Zstd))
        .compression_level(1)
        .compression_threads(0)
        .chunk_size(Some(4 << 20))
}

impl Writer for McapWriter {
    fn open(&mut self, about: Arc<About>) -> Result<(), RecordError> {
        let file = options::create(&self.path, self.force)?;
        let open = Open::new(about, file).map_err(RecordError::format(&self.path))?;
        open.failure.check().map_err(RecordError::write(&self.path))?;
        self.open = Some(open);
        Ok(())
    }

    fn write(&mut self, item: &Item) -> Result<(), RecordError> {
        let Some(open) = &mut self.open else { return Ok(()) };
        match item {
            Item::Frame(frame) => open.frame(frame),
            Item::Row(row) => open.row(row),
            Item::Event(event) => open.event(event),
            Item::Snapshot(snapshot) => open.snapshot(snapshot),
        }
        .map_err(RecordError::format(&self.path))?;
        open.failure.check().map_err(RecordError::write(&self.path))
    }

    fn flush(&mut self) -> Result<(), RecordError> {
        let Some(open) = &mut self.open else { return Ok(()) };
        open.out.flush().map_err(RecordError::format(&self.path))?;
        open.failure.check().map_err(RecordError::write(&self.path))
    }

    fn close(&mut self) -> Result<Vec<PathBuf>, RecordError> {
        let Some(mut open) = self.open.take() else { return Ok(Vec::new()) };
        open.out.finish().map_err(RecordError::format(&self.path))?;
        open.out.into_inner().finish();
        open.failure.check().map_err(RecordError::write(&self.path))?;
        Ok(vec![self.path.clone()])
    }
}

/// Simulated seconds as nanoseconds.
fn nanos(time: f64) -> u64 {
    (time.max(0.0) * 1e9).round() as u64
}

impl Open {
    fn new(about: Arc<About>, file: File) -> ::mcap::McapResult<Self> {
        let (file, failure) = Latch::new(file);
        let mut out = write_options().create(file)?;
        let mut channels = [0; 6];
        for (channel, (_, topic, kind)) in channels.iter_mut().zip(TOPICS) {
            let name = kind.replace('/', "/msg/");
            let schema = out.add_schema(&name, "ros2msg", crate::messages::schema(kind).as_bytes())?;
            *channel = out.add_channel(
                schema,
                &topic.replace('~', &about.ros.node),
                "cdr",
                &BTreeMap::from([("offered_qos_profiles".into(), String::new())]),
            )?;
        }
        let mut metadata = BTreeMap::from([
            ("title".to_owned(), about.scene.title.clone()),
            ("version".to_owned(), about.version.clone()),
            ("commit".to_owned(), about.commit.clone()),
            ("scene".to_owned(), about.scene.to_toml()),
            ("precision".to_owned(), if about.precision == super::Precision::Double { "f64" } else { "f32" }.to_owned()),
            ("node".to_owned(), about.ros.node.clone()),
            ("frame_id".to_owned(), about.ros.frame.clone()),
            ("columns".to_owned(), about.columns.iter().map(|c| c.name.as_str()).collect::<Vec<_>>().join(",")),
        ]);
        metadata.extend(about.description.method.iter().map(|(what, choice)| (format!("method.{what}"), choice.clone())));
        out.write_metadata(&Metadata { name: METADATA.into(), metadata })?;
        let scene = Cow::Owned(about.scene.to_toml().into_bytes());
        out.attach(&Attachment { log_time: 0, create_time: 0, name: SCENE.into(), media_type: "application/toml".into(), data: scene })?;
        let messages = Messages::new(about);
        let scene = messages.scene();
        let mut open = Self { out, failure, channels, sequence: [0; 6], messages, buffer: Vec::new() };
        open.put(Topic::Scene, 0, &scene)?;
        // What is in the file at once: who it is of.
        open.out.flush()?;
        Ok(open)
    }

    fn put(&mut self, topic: Topic, time: u64, message: &impl serde::Serialize) -> ::mcap::McapResult<()> {
        let topic = topic as usize;
        self.buffer.clear();
        // The encapsulation: CDR, little-endian.
        self.buffer.extend([0, 1, 0, 0]);
        cdr_encoding::to_writer::<_, byteorder::LittleEndian, _>(&mut self.buffer, message)
            .map_err(|error| ::mcap::McapError::Io(std::io::Error::other(error.to_string())))?;
        self.sequence[topic] += 1;
        let header = MessageHeader { channel_id: self.channels[topic], sequence: self.sequence[topic], log_time: time, publish_time: time };
        self.out.write_to_known_channel(&header, &self.buffer)
    }

    fn frame(&mut self, frame: &Frame) -> ::mcap::McapResult<()> {
        let cloud = self.messages.cloud(frame);
        self.put(Topic::Particles, nanos(frame.time), &cloud)
    }

    fn row(&mut self, row: &Row) -> ::mcap::McapResult<()> {
        let time = nanos(row.time);
        self.put(Topic::Clock, time, &Clock { clock: Time::from_nanos(time) })?;
        let (state, diagnostics) = (self.messages.state(row), self.messages.diagnostics(row));
        self.put(Topic::State, time, &state)?;
        self.put(Topic::Diagnostics, time, &diagnostics)
    }

    fn event(&mut self, event: &Event) -> ::mcap::McapResult<()> {
        let log = self.messages.log(event);
        self.put(Topic::Log, nanos(event.time), &log)
    }

    fn snapshot(&mut self, snapshot: &Snapshot) -> ::mcap::McapResult<()> {
        // The exact time stands in the name: nanoseconds would round it.
        self.out.attach(&Attachment {
            log_time: nanos(snapshot.time),
            create_time: snapshot.step,
            name: format!("snapshot {:?}", snapshot.time),
            media_type: SNAPSHOT.into(),
            data: Cow::Borrowed(&snapshot.bytes),
        })
    }
}
