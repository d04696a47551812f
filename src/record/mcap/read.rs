//! Reading `.mcap` recordings back, cut off ones too, and giving those their index again.

use super::super::data::{About, Event, Item, Level, Row, Snapshot};
use super::super::read::{Reader, rebuild};
use super::super::{Options, Precision, RecordError, RosNames};
use super::latch::Latch;
use super::layout::Layout;
use super::messages::{Said, said};
use super::{METADATA, SNAPSHOT, TOPICS, Topic, write_options};
use crate::messages::{ComponentState, DiagnosticArray, Log, PointCloud2};
use ::mcap::records::Record;
use ::mcap::sans_io::{LinearReadEvent, LinearReader, LinearReaderOptions};
use ::mcap::{Channel, Message, Schema, parse_record};
use std::borrow::Cow;
use std::collections::{BTreeMap, HashMap};
use std::fs::File;
use std::io::{Read, Seek, SeekFrom};
use std::path::Path;
use std::sync::Arc;

/// What every whole file begins and ends with.
const MAGIC: &[u8] = ::mcap::MAGIC;

/// The records of a file up to where it is cut off, those in chunks too.
struct Records {
    file: File,
    reader: LinearReader,
}

impl Records {
    fn open(path: &Path) -> Result<Self, RecordError> {
        let mut file = File::open(path).map_err(RecordError::read(path))?;
        let mut magic = [0; MAGIC.len()];
        if file.read_exact(&mut magic).is_err() || magic != *MAGIC {
            return Err(RecordError::content(path, "is no MCAP file"));
        }
        file.rewind().map_err(RecordError::read(path))?;
        let options = LinearReaderOptions::default().with_skip_end_magic(true).with_validate_chunk_crcs(true);
        Ok(Self { file, reader: LinearReader::new_with_options(options) })
    }

    fn next(&mut self) -> Option<Record<'static>> {
        loop {
            match self.reader.next_event()? {
                Ok(LinearReadEvent::ReadRequest(wanted)) => {
                    let read = self.file.read(self.reader.insert(wanted)).ok()?;
                    self.reader.notify_read(read);
                }
                Ok(LinearReadEvent::Record { data, opcode }) => return Some(parse_record(opcode, data).ok()?.into_owned()),
                // The file is cut off here, or damaged: nothing behind it can be trusted.
                Err(_) => return None,
            }
        }
    }
}

/// Whether the file was completed.
fn is_whole(path: &Path) -> std::io::Result<bool> {
    let mut file = File::open(path)?;
    let mut magic = [0; MAGIC.len()];
    if file.seek(SeekFrom::End(0))? < 2 * MAGIC.len() as u64 {
        return Ok(false);
    }
    file.seek(SeekFrom::End(-(MAGIC.len() as i64)))?;
    file.read_exact(&mut magic)?;
    Ok(magic == *MAGIC)
}

/// Reads a recording item by item.
pub(crate) struct McapReader {
    records: Records,
    about: Arc<About>,
    layout: Layout,
    topics: HashMap<u16, Topic>,
    whole: bool,
    /// A row whose diagnostics are still to come.
    row: Option<(u64, Row)>,
    /// Substeps at the time of the last row \[ns\].
    step: (u64, u64),
}

impl McapReader {
    pub(crate) fn open(path: &Path) -> Result<Self, RecordError> {
        let whole = is_whole(path).map_err(RecordError::read(path))?;
        let mut records = Records::open(path)?;
        let mut topics = HashMap::new();
        let metadata = loop {
            match records.next() {
                Some(Record::Metadata(found)) if found.name == METADATA => break found.metadata,
                // Channels are told before that.
                Some(Record::Channel(channel)) => note(&mut topics, channel.id, &channel.topic),
                Some(_) => {}
                None => return Err(RecordError::content(path, "is no recording of matpoint: it has no metadata of that name")),
            }
        };
        let text = |key: &str| metadata.get(key).cloned().unwrap_or_default();
        let options = Options {
            variables: Some(text("columns").split(',').map(str::to_owned).collect()),
            ros: RosNames { node: text("node"), frame: text("frame_id") },
            precision: if text("precision") == "f64" { Precision::Double } else { Precision::Single },
            ..Options::default()
        };
        let about = Arc::new(rebuild(path, &text("scene"), text("version"), text("commit"), &options)?);
        let layout = Layout::new(&about);
        Ok(Self { records, about, layout, topics, whole, row: None, step: (0, 0) })
    }

    fn message(&mut self, topic: Topic, nanos: u64, data: &[u8]) -> Option<Item> {
        // Behind the encapsulation.
        let data = data.get(4..)?;
        // Nanoseconds are rounded: the time as it was meant, where it has few digits.
        let time = nanos as f64 / 1e9;
        match topic {
            Topic::Particles => {
                let (cloud, _) = cdr_encoding::from_bytes::<PointCloud2, byteorder::LittleEndian>(data).ok()?;
                let step = if self.step.0 == nanos { self.step.1 } else { 0 };
                self.layout.frame(&cloud, time, step).map(Item::Frame)
            }
            Topic::State => {
                let (state, _) = cdr_encoding::from_bytes::<ComponentState, byteorder::LittleEndian>(data).ok()?;
                self.step = (nanos, state.substeps);
                let row = row(&self.about, &state, time);
                self.row.replace((nanos, row)).map(|(_, row)| Item::Row(row))
            }
            Topic::Diagnostics => {
                let (array, _) = cdr_encoding::from_bytes::<DiagnosticArray, byteorder::LittleEndian>(data).ok()?;
                let (_, mut row) = self.row.take_if(|(time, _)| *time == nanos)?;
                fill(&self.about, &mut row, &array);
                Some(Item::Row(row))
            }
            Topic::Log => {
                let (log, _) = cdr_encoding::from_bytes::<Log, byteorder::LittleEndian>(data).ok()?;
                let level = match log.level {
                    0..30 => Level::Info,
                    30..40 => Level::Warning,
                    _ => Level::Error,
                };
                let step = if self.step.0 == nanos { self.step.1 } else { 0 };
                Some(Item::Event(Event { time, step, level, text: log.msg }))
            }
            Topic::Clock | Topic::Scene => None,
        }
    }
}

/// Takes note of a channel, if its topic is one of ours, whatever the name of the node.
fn note(topics: &mut HashMap<u16, Topic>, channel: u16, name: &str) {
    let same = |topic: &str| topic.strip_prefix('~').map_or(topic == name, |end| name.ends_with(end));
    topics.extend(TOPICS.iter().filter(|(_, topic, _)| same(topic)).map(|&(topic, ..)| (channel, topic)));
}

impl Iterator for McapReader {
    type Item = Result<Item, RecordError>;

    fn next(&mut self) -> Option<Self::Item> {
        loop {
            let Some(record) = self.records.next() else { return self.row.take().map(|(_, row)| Ok(Item::Row(row))) };
            match record {
                Record::Channel(channel) => note(&mut self.topics, channel.id, &channel.topic),
                Record::Message { header, data } => {
                    if let Some(&topic) = self.topics.get(&header.channel_id)
                        && let Some(item) = self.message(topic, header.log_time, &data)
                    {
                        return Some(Ok(item));
                    }
                }
                Record::Attachment { header, data, .. } if header.media_type == SNAPSHOT => {
                    let time = header.name.trim_start_matches("snapshot ").parse().unwrap_or(header.log_time as f64 / 1e9);
                    return Some(Ok(Item::Snapshot(Snapshot { time, step: header.create_time, bytes: data.into_owned() })));
                }
                _ => {}
            }
        }
    }
}

impl Reader for McapReader {
    fn about(&self) -> &Arc<About> {
        &self.about
    }
    fn is_whole(&self) -> bool {
        self.whole
    }
}

/// A row from what a state message says; the rest is not known yet.
fn row(about: &About, state: &ComponentState, time: f64) -> Row {
    let first = |vector: [f64; 3]| vector[..about.dimension()].to_vec();
    let mut values: Vec<Vec<f64>> = Vec::new();
    for series in &about.series {
        let probe = |name: &str| state.probes.iter().find(|p| p.name == name);
        values.push(match said(&series.variable) {
            Some(Said::Energy(i)) => vec![[state.kinetic_energy, state.strain_energy, state.external_work, state.total_energy][i]],
            Some(Said::Momentum) => first(state.momentum.array()),
            Some(Said::RealTimeFactor) => vec![state.real_time_factor],
            Some(Said::Probe(name, quantity)) => probe(name).map_or(Vec::new(), |probe| match quantity {
                0 => first(probe.position.array()),
                1 => first(probe.displacement.array()),
                2 => first(probe.velocity.array()),
                _ => probe.stress.to_vec(),
            }),
            Some(Said::Reaction(name)) => {
                state.reactions.iter().find(|r| r.name == name).map_or(Vec::new(), |reaction| first(reaction.force.array()))
            }
            None => vec![f64::NAN; series.components.iter().map(|c| c.1 + 1).max().unwrap_or(1)],
        });
    }
    values.extend(state.loads.iter().map(|load| load.value.clone()));
    Row { time, step: state.substeps, count: state.steps, values }
}

/// Fills in what the diagnostics say.
fn fill(about: &About, row: &mut Row, array: &DiagnosticArray) {
    for pair in array.status.iter().flat_map(|status| &status.values) {
        let name = pair.key.split(" [").next().unwrap_or_default();
        let values: Option<Vec<f64>> = pair.value.split(' ').map(|number| number.parse().ok()).collect();
        if let (Some(index), Some(values)) = (about.series.iter().position(|s| s.variable == name), values) {
            row.values[index] = values;
        }
    }
}

/// Writes all of `path` that can be read to `to`, with an index.
pub(crate) fn repair(path: &Path, to: File) -> Result<(), RecordError> {
    let fail = |error: ::mcap::McapError| RecordError::format(path)(error);
    let mut records = Records::open(path)?;
    let (to, failure) = Latch::new(to);
    let mut out = write_options().create(to).map_err(fail)?;
    let mut schemas: HashMap<u16, Arc<Schema<'static>>> = HashMap::new();
    let mut channels: HashMap<u16, Arc<Channel<'static>>> = HashMap::new();
    while let Some(record) = records.next() {
        match record {
            Record::Schema { header, data } => {
                schemas.insert(header.id, Arc::new(Schema { id: header.id, name: header.name, encoding: header.encoding, data }));
            }
            Record::Channel(c) => {
                let schema = schemas.get(&c.schema_id).cloned();
                let metadata: BTreeMap<String, String> = c.metadata;
                let channel = Channel { id: c.id, topic: c.topic, schema, message_encoding: c.message_encoding, metadata };
                channels.insert(c.id, Arc::new(channel));
            }
            Record::Message { header, data } => {
                let Some(channel) = channels.get(&header.channel_id).cloned() else { continue };
                let (log_time, publish_time) = (header.log_time, header.publish_time);
                out.write(&Message { channel, sequence: header.sequence, log_time, publish_time, data }).map_err(fail)?;
            }
            Record::Metadata(metadata) => out.write_metadata(&metadata).map_err(fail)?,
            Record::Attachment { header, data, .. } => {
                let (log_time, create_time, name, media_type) = (header.log_time, header.create_time, header.name, header.media_type);
                let data = Cow::Borrowed(&*data);
                out.attach(&::mcap::Attachment { log_time, create_time, name, media_type, data }).map_err(fail)?;
            }
            _ => {}
        }
    }
    out.finish().map_err(fail)?;
    out.into_inner().finish();
    failure.check().map_err(RecordError::write(path))
}
