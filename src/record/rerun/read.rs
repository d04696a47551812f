//! Reading `.rrd` recordings back, cut off ones too; colouring them when all is known; giving those that were cut off their footer.

use super::super::data::{About, Event, Frame, Item, Level, Row, Snapshot};
use super::super::read::{Reader, rebuild};
use super::super::{Options, Precision, RecordError};
use super::encoder;
use super::logger::{EVENTS, INFO, PARTICLES, SNAPSHOT, Shade};
use ::re_log_encoding::{DecoderApp, RRD_FOURCC, StreamFooter};
use ::rerun::external::arrow::array::{Array, ArrayRef, AsArray, ListArray};
use ::rerun::external::arrow::datatypes::{Float32Type, Float64Type, UInt8Type, UInt16Type};
use ::rerun::log::{Chunk, LogMsg, RowId};
use ::rerun::{Points2D, Points3D, Scalars, TextLog};
use std::collections::{BTreeMap, VecDeque};
use std::fs::File;
use std::io::{BufReader, Read, Seek, SeekFrom};
use std::path::Path;
use std::sync::Arc;

/// The messages of a file up to where it is cut off.
fn messages(path: &Path) -> Result<impl Iterator<Item = LogMsg> + use<>, RecordError> {
    let mut file = File::open(path).map_err(RecordError::read(path))?;
    let mut head = [0; 4];
    if file.read_exact(&mut head).is_err() || head != RRD_FOURCC {
        return Err(RecordError::content(path, "is no RRD file of this version of Rerun"));
    }
    file.rewind().map_err(RecordError::read(path))?;
    let decoder: Box<dyn Iterator<Item = _>> = Box::new(DecoderApp::decode_lazy(BufReader::with_capacity(1 << 20, file)));
    Ok(decoder.map_while(Result::ok))
}

/// The chunks of the recording in a file, those of the blueprint left out.
fn chunks(path: &Path) -> Result<impl Iterator<Item = Chunk> + use<>, RecordError> {
    Ok(messages(path)?.filter_map(|message| match message {
        LogMsg::ArrowMsg(store, message) if store.is_recording() => Chunk::from_arrow_msg(&message).ok(),
        _ => None,
    }))
}

fn is_whole(path: &Path) -> std::io::Result<bool> {
    let mut file = File::open(path)?;
    // A whole file ends in the mark of the format, that of its footer, and the number of entries.
    let mut tail = [0; 12];
    if file.seek(SeekFrom::End(0))? < tail.len() as u64 {
        return Ok(false);
    }
    file.seek(SeekFrom::End(-(tail.len() as i64)))?;
    file.read_exact(&mut tail)?;
    Ok(tail[..4] == RRD_FOURCC && tail[4..8] == StreamFooter::RRD_IDENTIFIER)
}

/// One cell of a chunk as plain numbers.
fn numbers(array: &ArrayRef) -> Vec<f64> {
    if let Some(array) = array.as_primitive_opt::<Float64Type>() {
        array.values().to_vec()
    } else if let Some(array) = array.as_primitive_opt::<Float32Type>() {
        array.values().iter().map(|&v| f64::from(v)).collect()
    } else if let Some(array) = array.as_primitive_opt::<UInt16Type>() {
        array.values().iter().map(|&v| f64::from(v)).collect()
    } else if let Some(array) = array.as_primitive_opt::<UInt8Type>() {
        array.values().iter().map(|&v| f64::from(v)).collect()
    } else if let Some(array) = array.as_fixed_size_list_opt() {
        numbers(array.values())
    } else {
        Vec::new()
    }
}

/// Time \[s\] and step of each row of a chunk.
fn stamps(chunk: &Chunk) -> Vec<(f64, u64)> {
    let times = |name: &'static str| chunk.timelines().get(&name.into()).map(|t| t.times_raw().to_vec()).unwrap_or_default();
    let steps = times("step");
    times("sim_time").iter().enumerate().map(|(i, &t)| (t as f64 / 1e9, steps.get(i).map_or(0, |&s| s.max(0) as u64))).collect()
}

/// The lists of one component, by its name.
fn lists<'a>(chunk: &'a Chunk, name: &str) -> Option<&'a ListArray> {
    chunk.components().iter().find(|(found, _)| found.as_str() == name).map(|(_, column)| &column.list_array)
}

/// A cell of a component.
fn cell(chunk: &Chunk, name: &str, row: usize) -> Option<Vec<f64>> {
    lists(chunk, name).filter(|list| list.is_valid(row)).map(|list| numbers(&list.value(row)))
}

fn text(chunk: &Chunk, name: &str) -> String {
    let cell = lists(chunk, name).filter(|list| !list.is_empty()).map(|list| list.value(0));
    cell.and_then(|cell| cell.as_string_opt::<i32>().filter(|s| !s.is_empty()).map(|s| s.value(0).to_owned())).unwrap_or_default()
}

/// Reads a recording item by item. Curves are stored apart from the frames: they are gathered first, frames are read one by one.
pub(crate) struct RrdReader {
    about: Arc<About>,
    whole: bool,
    /// Rows, events and snapshots in the order of time.
    others: VecDeque<Item>,
    frames: Box<dyn Iterator<Item = Frame>>,
    next: Option<Frame>,
}

impl RrdReader {
    pub(crate) fn open(path: &Path) -> Result<Self, RecordError> {
        let whole = is_whole(path).map_err(RecordError::read(path))?;
        let info = chunks(path)?.find(|chunk| chunk.entity_path().to_string().trim_start_matches('/') == INFO);
        let Some(info) = info else { return Err(RecordError::content(path, "is no recording of matpoint: it has no entity `info`")) };
        let options = Options {
            variables: Some(text(&info, "columns").split(',').map(str::to_owned).collect()),
            precision: if text(&info, "precision") == "f64" { Precision::Double } else { Precision::Single },
            ..Options::default()
        };
        let about = Arc::new(rebuild(path, &text(&info, "scene"), text(&info, "version"), text(&info, "commit"), &options)?);
        let others = others(path, &about)?;
        let theirs = about.clone();
        let frames = chunks(path)?.flat_map(move |chunk| frames(&theirs, &chunk));
        Ok(Self { about, whole, others, frames: Box::new(frames), next: None })
    }
}

impl Iterator for RrdReader {
    type Item = Result<Item, RecordError>;
    fn next(&mut self) -> Option<Self::Item> {
        if self.next.is_none() {
            self.next = self.frames.next();
        }
        let first = match (&self.next, self.others.front()) {
            (Some(frame), Some(other)) => other.time() <= frame.time,
            (None, _) => true,
            (Some(_), None) => false,
        };
        let item = if first { self.others.pop_front() } else { self.next.take().map(Item::Frame) };
        item.map(Ok)
    }
}

impl Reader for RrdReader {
    fn about(&self) -> &Arc<About> {
        &self.about
    }
    fn is_whole(&self) -> bool {
        self.whole
    }
}

/// The frames in a chunk.
fn frames(about: &About, chunk: &Chunk) -> Vec<Frame> {
    if chunk.is_static() || chunk.entity_path().to_string().trim_start_matches('/') != PARTICLES {
        return Vec::new();
    }
    let dimension = about.dimension();
    let name = if dimension == 3 { Points3D::descriptor_positions() } else { Points2D::descriptor_positions() };
    let frame = |(row, (time, step)): (usize, (f64, u64))| {
        let mut values = Vec::new();
        for column in &about.columns {
            let numbers = match cell(chunk, &column.name, row) {
                Some(numbers) => numbers,
                None => {
                    let all = cell(chunk, name.component.as_str(), row)?;
                    let width = if dimension == 3 { 3 } else { 2 };
                    all.chunks_exact(width).flat_map(|point| point[..dimension].to_vec()).collect()
                }
            };
            values.push(Arc::new(numbers));
        }
        Some(Frame { time, step, values })
    };
    stamps(chunk).into_iter().enumerate().filter_map(frame).collect()
}

/// Everything but the frames.
fn others(path: &Path, about: &About) -> Result<VecDeque<Item>, RecordError> {
    // Nanoseconds, then the order in which things are told.
    let mut rows: BTreeMap<(u64, u64), Vec<Vec<f64>>> = BTreeMap::new();
    let mut rest: Vec<Item> = Vec::new();
    let names: Vec<(&str, &[(&str, usize)])> = about.series.iter().map(|s| (s.variable.as_str(), s.components.as_slice())).collect();
    for chunk in chunks(path)?.filter(|chunk| !chunk.is_static()) {
        let entity = chunk.entity_path().to_string();
        let entity = entity.trim_start_matches('/');
        for (row, (time, step)) in stamps(&chunk).into_iter().enumerate() {
            if entity == EVENTS {
                let get = |name: &str| {
                    lists(&chunk, name).map(|l| l.value(row)).and_then(|c| c.as_string_opt::<i32>().map(|s| s.value(0).to_owned()))
                };
                let text = get(TextLog::descriptor_text().component.as_str()).unwrap_or_default();
                let level = match get(TextLog::descriptor_level().component.as_str()).as_deref() {
                    Some("ERROR") => Level::Error,
                    Some("WARN") => Level::Warning,
                    _ => Level::Info,
                };
                rest.push(Item::Event(Event { time, step, level, text }));
            } else if entity == SNAPSHOT {
                let bytes = cell(&chunk, "bytes", row).unwrap_or_default().iter().map(|&b| b as u8).collect();
                rest.push(Item::Snapshot(Snapshot { time, step, bytes }));
            } else if let Some(place) = names
                .iter()
                .position(|(name, _)| *name == entity)
                .or_else(|| about.inputs.iter().position(|v| v.name == entity).map(|i| names.len() + i))
            {
                let Some(found) = cell(&chunk, Scalars::descriptor_scalars().component.as_str(), row) else { continue };
                let values = match names.get(place) {
                    Some((_, components)) => {
                        let width = components.iter().map(|c| c.1 + 1).max().unwrap_or(1);
                        let mut values = vec![f64::NAN; width];
                        components.iter().zip(&found).for_each(|(&(_, index), &value)| values[index] = value);
                        if let ([_, b, c, d, _, f, g, h, _], 6) = (&mut values[..], components.len()) {
                            (*d, *g, *h) = (*b, *c, *f);
                        }
                        values
                    }
                    None => found,
                };
                let nanos = (time * 1e9).round() as u64;
                let all = rows.entry((nanos, step)).or_insert_with(|| vec![vec![f64::NAN]; names.len() + about.inputs.len()]);
                all[place] = values;
            }
        }
    }
    let rows = rows
        .into_iter()
        .enumerate()
        .map(|(count, ((nanos, step), values))| Item::Row(Row { time: nanos as f64 / 1e9, step, count: count as u64, values }));
    let mut all: Vec<Item> = rows.chain(rest).collect();
    all.sort_by(|a, b| a.time().total_cmp(&b.time()));
    Ok(all.into())
}

/// Colours for every frame of a file, handed to `append` as messages of the same recording.
pub(super) fn colors(
    path: &Path,
    shade: Option<Shade>,
    append: &mut dyn FnMut(&LogMsg) -> Result<(), RecordError>,
) -> Result<(), RecordError> {
    // Where the path is no plain file there is nothing to read back.
    let (Some(shade), true) = (shade, path.is_file()) else { return Ok(()) };
    for message in messages(path)? {
        let LogMsg::ArrowMsg(store, message) = message else { continue };
        let Ok(chunk) = Chunk::from_arrow_msg(&message) else { continue };
        if !store.is_recording() || chunk.is_static() || chunk.entity_path().to_string().trim_start_matches('/') != PARTICLES {
            continue;
        }
        for row in 0..chunk.num_rows() {
            let Some(values) = cell(&chunk, &shade.name, row) else { continue };
            let colors: Vec<_> = values.chunks_exact(shade.width()).map(|v| shade.color(shade.value(v))).collect();
            let mut point = ::rerun::TimePoint::default();
            for column in chunk.timelines().values() {
                point.insert(*column.timeline(), column.times_raw()[row]);
            }
            let spatial = lists(&chunk, Points3D::descriptor_positions().component.as_str()).is_some();
            let chunk = Chunk::builder(chunk.entity_path().clone());
            let chunk = if spatial {
                chunk.with_archetype(RowId::new(), point, &Points3D::update_fields().with_colors(colors))
            } else {
                chunk.with_archetype(RowId::new(), point, &Points2D::update_fields().with_colors(colors))
            };
            let chunk = chunk.build().map_err(RecordError::format(path))?;
            let message = chunk.to_arrow_msg().map_err(RecordError::format(path))?;
            append(&LogMsg::ArrowMsg(store.clone(), message))?;
        }
    }
    Ok(())
}

/// Writes all of `path` that can be read to `to`, with colours and a footer.
pub(crate) fn repair(path: &Path, to: File) -> Result<(), RecordError> {
    let mut out = encoder(to).map_err(RecordError::format(path))?;
    for message in messages(path)? {
        out.append(&message).map_err(RecordError::format(path))?;
    }
    let mut reader = RrdReader::open(path)?;
    let shade = Shade::over(&reader.about, &mut reader.frames);
    colors(path, shade, &mut |message| out.append(message).map(drop).map_err(RecordError::format(path)))?;
    out.finish().map_err(RecordError::format(path))?;
    out.into_inner().map_err(RecordError::format(path))?.into_inner().map(drop).map_err(|e| RecordError::write(path)(e.into_error()))
}
