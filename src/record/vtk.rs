//! Runs for [ParaView](https://www.paraview.org): a `.vtu` file for each frame in a folder, and a `.pvd` file that lists them with their times.

use super::background::Writer;
use super::data::{About, Frame, Item};
use super::options::free;
use super::{Precision, RecordError};
use crate::draft::Draft;
use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Writes `NAME.pvd` and `NAME/0000.vtu` onwards. The list is written again with every flush, so that it is whole at any time.
pub(crate) struct VtkWriter {
    path: PathBuf,
    folder: PathBuf,
    force: bool,
    about: Option<Arc<About>>,
    /// Time \[s\] and file of each frame.
    frames: Vec<(f64, String)>,
}

impl VtkWriter {
    pub(crate) fn new(path: &Path, force: bool) -> Self {
        Self { path: path.to_path_buf(), folder: path.with_extension(""), force, about: None, frames: Vec::new() }
    }

    fn list(&self) -> Result<(), RecordError> {
        let folder = self.folder.file_name().unwrap_or_default().to_string_lossy();
        let mut text = String::from(
            "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"1.0\" byte_order=\"LittleEndian\">\n<Collection>\n",
        );
        for (time, name) in &self.frames {
            // Writing to a String cannot fail.
            let _ = writeln!(text, "<DataSet timestep=\"{time:?}\" file=\"{}/{name}\"/>", escape(&folder));
        }
        text += "</Collection>\n</VTKFile>\n";
        let mut draft = Draft::create(&self.path)?;
        draft.write(&text)?;
        draft.finish().map(drop)
    }
}

impl Writer for VtkWriter {
    fn open(&mut self, about: Arc<About>) -> Result<(), RecordError> {
        free(&self.path, self.force)?;
        free(&self.folder, self.force)?;
        std::fs::create_dir_all(&self.folder).map_err(RecordError::write(&self.folder))?;
        // Frames of a longer run before this one would be taken for frames of this one.
        for entry in std::fs::read_dir(&self.folder).map_err(RecordError::write(&self.folder))?.flatten() {
            if entry.path().extension().is_some_and(|ending| ending == "vtu") {
                std::fs::remove_file(entry.path()).map_err(RecordError::write(&entry.path()))?;
            }
        }
        self.about = Some(about);
        self.list()
    }

    fn write(&mut self, item: &Item) -> Result<(), RecordError> {
        let (Item::Frame(frame), Some(about)) = (item, &self.about) else { return Ok(()) };
        let name = format!("{:04}.vtu", self.frames.len());
        let mut draft = Draft::create(&self.folder.join(&name))?;
        draft.write_bytes(&unstructured(about, frame))?;
        draft.finish()?;
        self.frames.push((frame.time, name));
        Ok(())
    }

    fn flush(&mut self) -> Result<(), RecordError> {
        self.list()
    }

    fn close(&mut self) -> Result<Vec<PathBuf>, RecordError> {
        self.list()?;
        Ok(vec![self.path.clone()])
    }
}

/// The numbers of a file, in one block behind its text.
#[derive(Default)]
struct Block {
    bytes: Vec<u8>,
}

impl Block {
    /// Puts an array at the end, its size before it; returns the attributes that say where.
    fn put(&mut self, kind: &str, size: usize, values: impl ExactSizeIterator<Item = f64>) -> String {
        let offset = self.bytes.len();
        self.bytes.extend((values.len() as u64 * size as u64).to_le_bytes());
        for value in values {
            match kind {
                "Float32" => self.bytes.extend((value as f32).to_le_bytes()),
                "Float64" => self.bytes.extend(value.to_le_bytes()),
                "Int64" => self.bytes.extend((value as i64).to_le_bytes()),
                "Int32" => self.bytes.extend((value as i32).to_le_bytes()),
                _ => self.bytes.push(value as u8),
            }
        }
        format!("type=\"{kind}\" format=\"appended\" offset=\"{offset}\"")
    }
}

/// A frame as a `.vtu` file: particles are vertices, columns are point data.
fn unstructured(about: &About, frame: &Frame) -> Vec<u8> {
    let dimension = about.dimension();
    let particles = about.body.len();
    let (float, size) = if about.precision == Precision::Double { ("Float64", 8) } else { ("Float32", 4) };
    let mut block = Block::default();
    let mut points = String::new();
    let mut data = String::new();
    for (column, values) in about.columns.iter().zip(&frame.values) {
        let unit = if column.unit.is_empty() { String::new() } else { format!(" [{}]", column.unit) };
        let name = escape(&format!("{}{unit}", column.name));
        // Vectors have three components, whatever the dimension: ParaView draws arrows of those only.
        let vector = column.width == dimension && ["position", "velocity", "displacement"].contains(&column.name.as_str());
        let width = if vector { 3 } else { column.width };
        let number = |i: usize| match i % width {
            component if component < column.width => values[i / width * column.width + component],
            _ => 0.0,
        };
        let (kind, size) = if column.name == "body" { ("Int32", 4) } else { (float, size) };
        let place = block.put(kind, size, (0..particles * width).map(number));
        let array = format!("<DataArray Name=\"{name}\" NumberOfComponents=\"{width}\" {place}/>\n");
        if column.name == "position" { points = array } else { data += &array }
    }
    let ids = || (0..particles).map(|p| p as f64);
    let connectivity = block.put("Int64", 8, ids());
    let offsets = block.put("Int64", 8, ids().map(|p| p + 1.0));
    // 1 is a vertex.
    let types = block.put("UInt8", 1, ids().map(|_| 1.0));
    let mut file = format!(
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt64\">\n\
         <UnstructuredGrid>\n<FieldData>\n<DataArray type=\"Float64\" Name=\"TimeValue\" NumberOfTuples=\"1\" format=\"ascii\">{:?}</DataArray>\n\
         </FieldData>\n<Piece NumberOfPoints=\"{particles}\" NumberOfCells=\"{particles}\">\n<Points>\n{points}</Points>\n<PointData>\n{data}\
         </PointData>\n<Cells>\n<DataArray Name=\"connectivity\" {connectivity}/>\n<DataArray Name=\"offsets\" {offsets}/>\n\
         <DataArray Name=\"types\" {types}/>\n</Cells>\n</Piece>\n</UnstructuredGrid>\n<AppendedData encoding=\"raw\">\n_",
        frame.time
    )
    .into_bytes();
    file.extend(block.bytes);
    file.extend(b"\n</AppendedData>\n</VTKFile>\n");
    file
}

fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}
