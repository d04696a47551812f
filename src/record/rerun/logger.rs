//! What is logged, and under which names.

use super::super::Precision;
use super::super::columns::Series;
use super::super::data::{About, Frame, Item, Level, Row};
use super::super::lattice::Lattice;
use super::super::particles::von_mises;
use super::layout;
use crate::color::viridis;
use ::rerun::external::arrow::array::{ArrayRef, Float32Array, Float64Array, UInt8Array, UInt16Array};
use ::rerun::{
    AnyValues, Arrows2D, Arrows3D, AsComponents, Boxes2D, Boxes3D, Image, LineStrips2D, LineStrips3D, Points2D, Points3D, RecordingStream,
    RecordingStreamBuilder, RecordingStreamError, Scalars, SeriesLines, TextDocument, TextLog, TextLogLevel,
};
use std::sync::Arc;

pub(super) const PARTICLES: &str = "world/particles";
pub(super) const INFO: &str = "info";
pub(super) const SNAPSHOT: &str = "snapshot";
pub(super) const EVENTS: &str = "events";

type Outcome = Result<(), RecordingStreamError>;

/// A recording with the layout of the viewer.
pub(super) fn builder(about: &About) -> RecordingStreamBuilder {
    RecordingStreamBuilder::new("matpoint")
        .recording_name(about.scene.title.as_str())
        .send_properties(false)
        .with_blueprint(layout::blueprint(about))
}

/// Logs items to a stream.
///
/// Particles are `world/particles`: positions (f32), and a column for each variable recorded. Every series of the history stands under the name
/// of its variable, unit in the name of the curve. Timelines: `sim_time` and `step`.
pub(super) struct Logger {
    stream: RecordingStream,
    about: Arc<About>,
    lattice: Lattice,
    /// Largest value of the colour so far.
    largest: f64,
    /// Longest arrow so far \[N\].
    longest: f64,
    /// Whether frames are coloured at once, or when all are known.
    colored: bool,
    shown: f64,
    /// Positions of the last frame.
    position: Option<Arc<Vec<f64>>>,
    /// Particles next to each loaded face.
    loaded: Vec<(String, Vec<usize>)>,
}

impl Logger {
    pub(super) fn new(stream: RecordingStream, about: Arc<About>) -> Result<Self, RecordingStreamError> {
        // Wall-clock timelines would make every recording differ.
        stream.set_log_tick_enabled(false);
        stream.set_log_time_enabled(false);
        let lattice = Lattice::new(&about);
        let loaded = layout::loaded(&about);
        let logger = Self { stream, about, lattice, largest: 0.0, longest: 0.0, colored: false, shown: 0.0, position: None, loaded };
        logger.log_fixed()?;
        Ok(logger)
    }

    /// Colours frames as they come.
    pub(super) fn colored(self) -> Self {
        Self { colored: true, ..self }
    }

    pub(super) fn stream(&self) -> &RecordingStream {
        &self.stream
    }

    /// The column that colours the particles, and the value of the brightest colour: round, so that a legend reads well.
    pub(super) fn range(&self) -> Option<Shade> {
        Shade::of(&self.about).map(|shade| Shade { largest: layout::round(self.largest), ..shade })
    }

    fn fixed(&self, entity: &str, what: &dyn AsComponents) -> Outcome {
        self.stream.log_static(entity, what)
    }

    /// What does not change: the grid, the scene, the width and the body of each particle, the names of curves.
    fn log_fixed(&self) -> Outcome {
        let about = &*self.about;
        let (grid, dimension) = (&about.scene.grid, about.dimension());
        let at = |v: &[f64], a: usize| v.get(a).map_or(0.0, |&x| x as f32);
        let half: [f32; 3] = std::array::from_fn(|a| 0.5 * at(&grid.size, a));
        let middle: [f32; 3] = std::array::from_fn(|a| at(&grid.origin, a) + half[a]);
        if dimension == 3 {
            self.fixed("world", &::rerun::ViewCoordinates::RIGHT_HAND_Z_UP())?;
            let room = Boxes3D::from_centers_and_half_sizes([middle], [half]);
            self.fixed("world/grid", &room.with_colors([layout::GRAY]).with_fill_mode(::rerun::FillMode::MajorWireframe))?;
        } else {
            let half = if dimension == 1 { [half[0], 0.25 * half[0]] } else { [half[0], half[1]] };
            // Plane views have y down: seen from behind, it is up.
            self.fixed("world", &::rerun::Transform3D::from_scale([1.0, -1.0, 1.0]))?;
            self.fixed("world/grid", &Boxes2D::from_centers_and_half_sizes([[middle[0], middle[1]]], [half]).with_colors([layout::GRAY]))?;
        }
        self.fixed("scene", &TextDocument::from_markdown(format!("```toml\n{}\n```", about.scene.to_toml())))?;
        let columns = about.columns.iter().map(|c| c.name.as_str()).collect::<Vec<_>>().join(",");
        let text = |text: &str| -> ArrayRef { Arc::new(::rerun::external::arrow::array::StringArray::from(vec![text])) };
        let info = AnyValues::default()
            .with_component_from_data("scene", text(&about.scene.to_toml()))
            .with_component_from_data("version", text(&about.version))
            .with_component_from_data("commit", text(&about.commit))
            .with_component_from_data("columns", text(&columns))
            .with_component_from_data("precision", text(if about.precision == Precision::Double { "f64" } else { "f32" }));
        let method = about.description.method.iter().map(|(what, choice)| format!("{what}: {choice}")).collect::<Vec<_>>().join("\n");
        self.fixed(INFO, &info.with_component_from_data("method", text(&method)))?;

        // As wide as the volume of the particle: neighbours just touch.
        let radius =
            |b: &u32| about.spacing.get(*b as usize).map_or(0.0, |s| 0.5 * s.iter().product::<f64>().powf(1.0 / s.len() as f64) as f32);
        let radii = about.body.iter().map(radius);
        if dimension == 3 {
            self.fixed(PARTICLES, &Points3D::update_fields().with_radii(radii))?;
        } else {
            self.fixed(PARTICLES, &Points2D::update_fields().with_radii(radii))?;
        }
        for series in &about.series {
            self.fixed(&series.variable, &SeriesLines::new().with_names(names(series)))?;
        }
        Ok(())
    }

    pub(super) fn log(&mut self, item: &Item) -> Outcome {
        let (time, step) = match item {
            Item::Frame(frame) => (frame.time, frame.step),
            Item::Row(row) => (row.time, row.step),
            Item::Event(event) => (event.time, event.step),
            Item::Snapshot(snapshot) => (snapshot.time, snapshot.step),
        };
        self.stream.set_duration_secs("sim_time", time);
        self.stream.set_time_sequence("step", step as i64);
        match item {
            Item::Frame(frame) => self.frame(frame),
            Item::Row(row) => self.row(row),
            Item::Event(event) => {
                let level = match event.level {
                    Level::Info => TextLogLevel::INFO,
                    Level::Warning => TextLogLevel::WARN,
                    Level::Error => TextLogLevel::ERROR,
                };
                self.stream.log(EVENTS, &TextLog::new(event.text.as_str()).with_level(level))
            }
            Item::Snapshot(snapshot) => {
                let bytes: ArrayRef = Arc::new(UInt8Array::from(snapshot.bytes.clone()));
                self.stream.log(SNAPSHOT, &AnyValues::default().with_component_from_data("bytes", bytes))
            }
        }
    }

    fn frame(&mut self, frame: &Frame) -> Outcome {
        let about = self.about.clone();
        let mut extra = AnyValues::default();
        let double = about.precision == Precision::Double;
        for (column, values) in about.columns.iter().zip(&frame.values).filter(|(c, _)| double || c.name != "position") {
            let array: ArrayRef = match (double, column.name.as_str()) {
                (_, "body") => Arc::new(UInt16Array::from_iter_values(values.iter().map(|&v| v as u16))),
                (true, _) => Arc::new(Float64Array::from(values.to_vec())),
                (false, _) => Arc::new(Float32Array::from_iter_values(values.iter().map(|&v| v as f32))),
            };
            // Names of variables are plain words, which is all that it asks for.
            if let Ok(name) = ::rerun::ComponentIdentifier::try_new(&column.name) {
                extra = extra.with_component_from_data(name, array);
            }
        }
        let position = &frame.values[0];
        self.position = Some(position.clone());
        let shade = Shade::of(&about);
        if let Some(shade) = &shade {
            let largest = shade.values(frame).fold(0.0, |a: f64, v| a.max(v.abs()));
            self.largest = self.largest.max(largest);
        }
        let colors = match (self.colored, self.range()) {
            (true, Some(shade)) => Some(shade.values(frame).map(|v| shade.color(v)).collect::<Vec<_>>()),
            _ => None,
        };
        // One row for both, so that a frame is one row in a table too.
        if about.dimension() == 3 {
            let mut points = Points3D::new(spread::<3>(position, 3));
            points = if let Some(colors) = colors { points.with_colors(colors) } else { points };
            self.stream.log(PARTICLES, &[&points as &dyn AsComponents, &extra])?;
            let lines = self.lattice.outline(position);
            let strips = lines.iter().map(|line| line.map(|p| p.map(|v| v as f32)));
            self.stream.log(
                "world/outline",
                &LineStrips3D::new(strips).with_colors([layout::INK]).with_radii([::rerun::Radius::new_ui_points(1.5)]),
            )?;
        } else {
            let mut points = Points2D::new(spread::<2>(position, about.dimension()));
            points = if let Some(colors) = colors { points.with_colors(colors) } else { points };
            self.stream.log(PARTICLES, &[&points as &dyn AsComponents, &extra])?;
            let lines = self.lattice.outline(position);
            let strips = lines.iter().map(|line| line.map(|p| [p[0] as f32, p[1] as f32]));
            self.stream.log(
                "world/outline",
                &LineStrips2D::new(strips).with_colors([layout::INK]).with_radii([::rerun::Radius::new_ui_points(1.5)]),
            )?;
        }
        if about.cells {
            self.cells(position)?;
        }
        if self.colored { self.legend() } else { Ok(()) }
    }

    /// The cells of the background grid that hold particles.
    fn cells(&self, position: &[f64]) -> Outcome {
        let (centers, half) = layout::cells(&self.about, position);
        if self.about.dimension() == 3 {
            let boxes = Boxes3D::from_centers_and_half_sizes(centers, [half]);
            let boxes = boxes.with_fill_mode(::rerun::FillMode::MajorWireframe);
            self.stream.log("world/cells", &boxes.with_colors([layout::GRAY]).with_radii([::rerun::Radius::new_ui_points(0.5)]))
        } else {
            let boxes = Boxes2D::from_centers_and_half_sizes(centers.map(|[x, y, _]| [x, y]), [[half[0], half[1]]]);
            self.stream.log("world/cells", &boxes.with_colors([layout::GRAY]).with_radii([::rerun::Radius::new_ui_points(0.5)]))
        }
    }

    fn row(&mut self, row: &Row) -> Outcome {
        let about = self.about.clone();
        for (series, values) in about.series.iter().zip(&row.values) {
            self.stream.log(series.variable.as_str(), &Scalars::new(series.components.iter().map(|&(_, index)| values[index])))?;
            if let Some(name) = series.variable.strip_prefix("boundary/").and_then(|name| name.strip_suffix("/reaction")) {
                self.arrow(&format!("world/reaction/{name}"), layout::boundary_place(&about, name), values, name)?;
            }
            if let Some(name) = series.variable.strip_prefix("probe/").and_then(|name| name.strip_suffix("/position")) {
                self.probe(name, values)?;
            }
        }
        for (input, values) in about.inputs.iter().zip(&row.values[about.series.len()..]) {
            self.stream.log(input.name.as_str(), &Scalars::new(values.iter().copied()))?;
        }
        for (name, mut place, value) in layout::loads(&about, row) {
            // The face has moved since time 0.
            let name_of_load = name.split('/').next().unwrap_or_default();
            if let (Some((_, near)), Some(position)) = (self.loaded.iter().find(|(load, _)| load == name_of_load), &self.position) {
                for &p in near {
                    let d = about.dimension();
                    (0..d).for_each(|a| place[a] += (position[d * p + a] - about.initial[d * p + a]) / near.len() as f64);
                }
            }
            self.arrow(&format!("world/load/{name}"), place, &value, &name)?;
        }
        Ok(())
    }

    fn probe(&self, name: &str, position: &[f64]) -> Outcome {
        let (entity, radius) = (format!("world/probe/{name}"), [::rerun::Radius::new_ui_points(5.0)]);
        if self.about.dimension() == 3 {
            self.stream
                .log(entity, &Points3D::new(spread::<3>(position, 3)).with_radii(radius).with_labels([name]).with_colors([layout::MARK]))
        } else {
            let dimension = self.about.dimension();
            self.stream.log(
                entity,
                &Points2D::new(spread::<2>(position, dimension)).with_radii(radius).with_labels([name]).with_colors([layout::MARK]),
            )
        }
    }

    /// A force as an arrow; the longest so far is a sixth of the grid long.
    fn arrow(&mut self, entity: &str, place: [f64; 3], value: &[f64], name: &str) -> Outcome {
        let length = value.iter().map(|v| v * v).sum::<f64>().sqrt();
        self.longest = self.longest.max(length);
        let size = self.about.scene.grid.size.iter().copied().fold(0.0, f64::max);
        let scale = if self.longest > 0.0 { size / 6.0 / self.longest } else { 0.0 };
        let vector: [f32; 3] = std::array::from_fn(|a| value.get(a).map_or(0.0, |v| (scale * v) as f32));
        let (radius, label) =
            ([::rerun::Radius::new_ui_points(2.0)], format!("{name} {}", crate::text::si(length, layout::arrow_unit(entity))));
        if self.about.dimension() == 3 {
            let arrows = Arrows3D::from_vectors([vector]).with_origins([place.map(|v| v as f32)]);
            self.stream.log(entity, &arrows.with_radii(radius).with_labels([label]).with_colors([layout::MARK]))
        } else {
            let arrows = Arrows2D::from_vectors([[vector[0], vector[1]]]).with_origins([[place[0] as f32, place[1] as f32]]);
            self.stream.log(entity, &arrows.with_radii(radius).with_labels([label]).with_colors([layout::MARK]))
        }
    }

    /// The colours with their values, where the range has changed.
    pub(super) fn legend(&mut self) -> Outcome {
        let Some(shade) = self.range().filter(|shade| shade.largest != self.shown) else { return Ok(()) };
        self.shown = shade.largest;
        const WIDTH: usize = 256;
        const HEIGHT: usize = 12;
        let row: Vec<u8> = (0..WIDTH).flat_map(|i| viridis(i as f64 / (WIDTH - 1) as f64)).collect();
        self.fixed("legend/colors", &Image::from_rgb24(row.repeat(HEIGHT), [WIDTH as u32, HEIGHT as u32]))?;
        let low = if shade.signed { -shade.largest } else { 0.0 };
        let [low, middle, high] = [low, 0.5 * (low + shade.largest), shade.largest].map(|v| crate::text::si(v, shade.unit));
        let places = [[0.0, 9.0], [0.5 * WIDTH as f32, 9.0], [WIDTH as f32, 9.0]];
        let marks = Points2D::new(places).with_labels([low, format!("{}, {middle}", shade.title), high]);
        self.fixed("legend/values", &marks.with_radii([0.5]).with_colors([layout::INK]).with_show_labels(true))
    }
}

/// Names of the curves of a series: `tip/displacement x [m]`; the view says what kind it is.
fn names(series: &Series) -> impl Iterator<Item = String> + '_ {
    series.components.iter().map(|(label, _)| {
        let last = series.variable.split_once('/').map_or("", |(_, rest)| rest);
        let component = if label.is_empty() { String::new() } else { format!(" {label}") };
        let unit = if series.unit.is_empty() { String::new() } else { format!(" [{}]", series.unit) };
        format!("{last}{component}{unit}")
    })
}

/// Points as f32 for viewers: missing coordinates are zero.
fn spread<const N: usize>(flat: &[f64], dimension: usize) -> impl Iterator<Item = [f32; N]> + '_ {
    flat.chunks_exact(dimension).map(|x| std::array::from_fn(|axis| x.get(axis).map_or(0.0, |&v| v as f32)))
}

/// What colours a particle: a column made one number.
#[derive(Debug, Clone)]
pub(super) struct Shade {
    pub(super) column: usize,
    pub(super) name: String,
    width: usize,
    /// Both signs are worth telling apart.
    signed: bool,
    unit: &'static str,
    title: String,
    /// Value of the brightest colour.
    pub(super) largest: f64,
}

impl Shade {
    /// The von Mises stress, or the first column that was asked for.
    fn of(about: &About) -> Option<Self> {
        let wanted = ["von_mises", "stress"].iter().find_map(|name| about.column(name));
        let column = wanted.or((about.columns.len() > 1).then_some(1))?;
        let found = &about.columns[column];
        let words = found.name.replace('_', " ");
        let title = match (found.name.as_str(), found.width, about.dimension()) {
            ("stress", 9, 1) => "stress xx".into(),
            (_, 9, _) => format!("von Mises {words}"),
            ("von_mises", ..) => "von Mises stress".into(),
            (_, 1, _) => words,
            _ => format!("magnitude of {words}"),
        };
        let signed = found.name == "pressure" || found.width == 9 && about.dimension() == 1;
        Some(Self { column, name: found.name.clone(), width: found.width, signed, unit: found.unit, title, largest: 0.0 })
    }

    /// With the range of what is in `frames`.
    pub(super) fn over(about: &About, frames: &mut dyn Iterator<Item = Frame>) -> Option<Self> {
        let shade = Self::of(about)?;
        let largest = frames.fold(0.0, |largest: f64, frame| shade.values(&frame).fold(largest, |a, v| a.max(v.abs())));
        Some(Self { largest: layout::round(largest), ..shade })
    }

    fn values<'a>(&'a self, frame: &'a Frame) -> impl Iterator<Item = f64> + 'a {
        frame.values[self.column].chunks_exact(self.width).map(|v| self.value(v))
    }

    /// The number that colours a particle, from those of its column.
    pub(super) fn value(&self, v: &[f64]) -> f64 {
        match v.len() {
            1 => v[0],
            9 if self.signed => v[0],
            9 => von_mises(v),
            _ => v.iter().map(|x| x * x).sum::<f64>().sqrt(),
        }
    }

    pub(super) fn width(&self) -> usize {
        self.width
    }

    pub(super) fn color(&self, value: f64) -> ::rerun::Color {
        let share = if self.largest > 0.0 { value / self.largest } else { 0.0 };
        let [r, g, b] = viridis(if self.signed { 0.5 + 0.5 * share } else { share });
        ::rerun::Color::from_rgb(r, g, b)
    }
}
