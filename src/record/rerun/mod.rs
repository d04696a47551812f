//! Recordings for the [Rerun](https://rerun.io) viewer: particles, energies and probes over simulated time.

use super::columns::{self, Series};
use super::particles::{all_von_mises, spacing};
use super::{RecordError, Sink};
use crate::Simulation;
use crate::color::viridis;
use ::rerun::blueprint::components::PanelState;
use ::rerun::blueprint::{Blueprint, BlueprintPanel, Horizontal, SelectionPanel, Spatial3DView, Tabs, TextDocumentView, TimePanel};
use ::rerun::blueprint::{ContainerLike, TimeSeriesView, Vertical};
use ::rerun::components::{Scalar, Vector3D};
use ::rerun::{AnyValues, AsComponents, Boxes3D, Points3D, RecordingStream, RecordingStreamBuilder, Scalars, SeriesLines};
use std::path::{Path, PathBuf};

const PARTICLES: &str = "world/particles";

/// Streams a run to an `.rrd` file, which `rerun FILE` opens; what was written before a crash can be read.
///
/// Particles are `world/particles`: positions (f32, missing axes zero), colours by von Mises stress from zero to the largest seen so
/// far (logged as `color_scale/von_mises_Pa`), and the columns `velocity`, `von_mises` and `pressure`; `body` does not
/// change. Every series of the history stands under the name of its variable. Timelines: `sim_time` and `step`.
pub struct RerunSink {
    path: PathBuf,
    stream: Option<RecordingStream>,
    series: Vec<Series>,
    dimension: usize,
    largest: f64,
    closed: bool,
}

impl RerunSink {
    /// A sink for the file `path`.
    pub fn new(path: impl AsRef<Path>) -> Self {
        let path = path.as_ref().to_path_buf();
        Self { path, stream: None, series: Vec::new(), dimension: 0, largest: 0.0, closed: false }
    }

    /// Records to `stream` instead of a file.
    fn open(&mut self, stream: RecordingStream, sim: &mut Simulation) -> Result<(), RecordError> {
        // Wall-clock timelines would make every recording differ.
        stream.set_log_tick_enabled(false);
        stream.set_log_time_enabled(false);
        self.stream = Some(stream);
        let description = sim.describe();
        self.series = columns::series(&description);
        self.dimension = description.dimension;
        self.largest = 0.0;
        self.log_fixed(sim)
    }

    /// What does not change: the grid, the scene, the width and the body of each particle, the names of curves.
    fn log_fixed(&self, sim: &mut Simulation) -> Result<(), RecordError> {
        let scene = sim.scene();
        let pad = |v: &[f64], scale: f64| std::array::from_fn::<f32, 3, _>(|a| v.get(a).map_or(0.0, |&x| (scale * x) as f32));
        let half = pad(&scene.grid.size, 0.5);
        let corner = pad(&scene.grid.origin, 1.0);
        let grid = Boxes3D::from_centers_and_half_sizes([std::array::from_fn::<_, 3, _>(|a| corner[a] + half[a])], [half]);
        // Scenes in the plane are read with y up, scenes in space with z up.
        let up =
            if self.dimension == 3 { ::rerun::ViewCoordinates::RIGHT_HAND_Z_UP() } else { ::rerun::ViewCoordinates::RIGHT_HAND_Y_UP() };
        let text = scene.to_toml();
        let spacing = spacing(scene);
        self.log_static("world", &up)?;
        self.log_static("world/grid", &grid.with_colors([0x9090_90ff]).with_fill_mode(::rerun::FillMode::MajorWireframe))?;
        self.log_static("scene", &::rerun::TextDocument::new(text))?;

        let body = sim.get("particle/body")?;
        // Neighbours just touch where the spacing is the same along all axes.
        let radius = |b: &f64| spacing.get(*b as usize).map_or(0.0, |s| 0.5 * s.iter().copied().fold(f64::INFINITY, f64::min) as f32);
        self.log_static(PARTICLES, &Points3D::update_fields().with_radii(body.iter().map(radius)))?;
        self.log_static(PARTICLES, &AnyValues::default().with_component::<Scalar>("body", body.iter().copied()))?;
        for series in &self.series {
            let names = series.components.iter().map(|(label, _)| {
                // `tip/displacement`, `kinetic`: the view says what kind it is.
                let last = series.variable.split_once('/').map_or("", |(_, rest)| rest);
                let component = if label.is_empty() { String::new() } else { format!(" {label}") };
                let unit = if series.unit.is_empty() { String::new() } else { format!(" [{}]", series.unit) };
                format!("{last}{component}{unit}")
            });
            self.log_static(&series.variable, &SeriesLines::new().with_names(names))?;
        }
        Ok(())
    }

    fn stamp(&self, time: f64, step: u64) {
        if let Some(stream) = &self.stream {
            stream.set_duration_secs("sim_time", time);
            stream.set_time_sequence("step", step as i64);
        }
    }

    fn log(&self, entity: &str, what: &dyn AsComponents) -> Result<(), RecordError> {
        self.stream.as_ref().map_or(Ok(()), |stream| stream.log(entity, what)).map_err(|error| self.failed(error))
    }

    fn log_static(&self, entity: &str, what: &dyn AsComponents) -> Result<(), RecordError> {
        self.stream.as_ref().map_or(Ok(()), |stream| stream.log_static(entity, what)).map_err(|error| self.failed(error))
    }

    fn failed(&self, source: ::rerun::RecordingStreamError) -> RecordError {
        RecordError::Rerun { path: self.path.clone(), source: Box::new(source) }
    }
}

impl Sink for RerunSink {
    fn begin(&mut self, sim: &mut Simulation) -> Result<(), RecordError> {
        // A plain file error names its cause; Rerun's own does not.
        std::fs::File::create(&self.path).map_err(RecordError::write(&self.path))?;
        let series = columns::series(&sim.describe());
        let stream = builder(&sim.scene().title, &series).save(&self.path).map_err(|error| self.failed(error))?;
        self.open(stream, sim)
    }

    fn frame(&mut self, sim: &mut Simulation, step: u64) -> Result<(), RecordError> {
        self.stamp(sim.time(), step);
        let stress = sim.get("particle/stress")?;
        let von_mises = all_von_mises(stress);
        let pressures: Vec<f64> = stress.chunks_exact(9).map(pressure).collect();
        self.largest = von_mises.iter().copied().fold(self.largest, f64::max);
        let scale = if self.largest > 0.0 { 1.0 / self.largest } else { 0.0 };
        let colors = von_mises.iter().map(|v| {
            let [r, g, b] = viridis(scale * v);
            ::rerun::Color::from_rgb(r, g, b)
        });
        let shown = Points3D::new(points(sim.get("particle/position")?, self.dimension)).with_colors(colors);
        let columns = AnyValues::default()
            .with_component::<Vector3D>("velocity", points(sim.get("particle/velocity")?, self.dimension))
            .with_component::<Scalar>("von_mises", von_mises)
            .with_component::<Scalar>("pressure", pressures);
        // One row for both, so that a frame is one row in a table too.
        self.log(PARTICLES, &[&shown as &dyn AsComponents, &columns])?;
        self.log("color_scale/von_mises_Pa", &Scalars::single(self.largest))
    }

    fn history(&mut self, sim: &mut Simulation, step: u64) -> Result<(), RecordError> {
        self.stamp(sim.time(), step);
        for series in &self.series {
            let values = sim.get(&series.variable)?;
            self.log(&series.variable, &Scalars::new(series.components.iter().map(|&(_, index)| values[index])))?;
        }
        Ok(())
    }

    fn finish(&mut self, _: &mut Simulation) -> Result<(), RecordError> {
        // Dropping the last handle writes the footer; the flush before it is what can report an error.
        if let Some(stream) = self.stream.take() {
            self.closed = true;
            stream.flush_blocking().map_err(|source| RecordError::Flush { path: self.path.clone(), source: Box::new(source) })?;
        }
        Ok(())
    }

    fn files(&self) -> Vec<PathBuf> {
        if self.closed { vec![self.path.clone()] } else { Vec::new() }
    }
}

/// Pressure \[Pa\] of a 3x3 stress in C-order, positive in compression.
fn pressure(s: &[f64]) -> f64 {
    -(s[0] + s[4] + s[8]) / 3.0
}

/// Space padded to three coordinates, as f32 for viewers: missing ones are zero.
fn points(flat: &[f64], dimension: usize) -> impl Iterator<Item = [f32; 3]> + '_ {
    flat.chunks_exact(dimension).map(|x| std::array::from_fn(|axis| x.get(axis).map_or(0.0, |&v| v as f32)))
}

/// A recording with the layout of the viewer: space on the left, curves and the scene on the right.
fn builder(title: &str, series: &[Series]) -> RecordingStreamBuilder {
    // What shares a unit shares a view; the rest is in the recording, for views of the user's own.
    let chosen = |fits: &dyn Fn(&str) -> bool| -> Vec<String> {
        series.iter().filter(|s| fits(&s.variable)).map(|s| format!("/{}", s.variable)).collect()
    };
    const ENERGIES: [&str; 4] = ["energy/kinetic", "energy/strain", "energy/external", "energy/total"];
    let views = [
        ("energies", chosen(&|name| ENERGIES.contains(&name))),
        ("probe displacements", chosen(&|name| name.starts_with("probe/") && name.ends_with("/displacement"))),
        ("reactions", chosen(&|name| name.starts_with("boundary/"))),
    ];
    let shown = views.into_iter().filter(|(_, contents)| !contents.is_empty());
    let curves = shown.map(|(name, contents)| ContainerLike::from(TimeSeriesView::new(name).with_contents(contents)));
    let text = TextDocumentView::new("scene").with_origin("/scene");
    let right = Tabs::new([Vertical::new(curves).with_name("curves").into(), text.into()]);
    let space = Spatial3DView::new("particles").with_origin("/world");
    // Activated, not only offered as default: a default layout is applied too late by some viewers.
    let blueprint = Blueprint::new(Horizontal::new([space.into(), right.into()]).with_column_shares(vec![2.0, 1.0]))
        .with_time_panel(TimePanel::new().with_timeline("sim_time").with_state(PanelState::Collapsed))
        .with_blueprint_panel(BlueprintPanel::from_state(PanelState::Hidden))
        .with_selection_panel(SelectionPanel::from_state(PanelState::Hidden));
    RecordingStreamBuilder::new("matpoint").recording_name(title).send_properties(false).with_blueprint(blueprint)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Scene;
    use ::rerun::log::{Chunk, LogMsg};

    /// What was logged under `entity`: time \[ns\] and the bytes of one component, in the order of time.
    fn logged<T: Copy>(messages: &[LogMsg], entity: &str, read: impl Fn(&Chunk) -> Vec<Vec<T>>) -> Vec<(i64, Vec<T>)> {
        let mut rows = Vec::new();
        for message in messages {
            let LogMsg::ArrowMsg(store, message) = message else { continue };
            let chunk = Chunk::from_arrow_msg(message).unwrap();
            if store.is_blueprint() || chunk.is_static() || chunk.entity_path().to_string() != entity {
                continue;
            }
            let times = chunk.timelines()[&"sim_time".into()].times_raw().to_vec();
            let values = read(&chunk);
            assert_eq!(times.len(), values.len(), "{entity}");
            rows.extend(times.into_iter().zip(values));
        }
        rows.sort_by_key(|row| row.0);
        rows
    }

    fn positions(messages: &[LogMsg]) -> Vec<(i64, Vec<[f32; 3]>)> {
        let component = Points3D::descriptor_positions().component;
        logged(messages, "/world/particles", |chunk| chunk.iter_slices::<[f32; 3]>(component).map(<[_]>::to_vec).collect())
    }

    fn scalars(messages: &[LogMsg], entity: &str) -> Vec<(i64, Vec<f64>)> {
        let component = Scalars::descriptor_scalars().component;
        logged(messages, entity, |chunk| chunk.iter_slices::<f64>(component).map(<[_]>::to_vec).collect())
    }

    /// Three frames and five rows, 0.01 s apart.
    fn record() -> (Vec<LogMsg>, usize) {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("launch_scripts/scenes/cantilever.toml");
        let mut sim = Scene::load_with(path, &[]).unwrap().build().unwrap();
        let mut sink = RerunSink::new("never written.rrd");
        let series = columns::series(&sim.describe());
        let (stream, storage) = builder("test", &series).memory().unwrap();
        sink.open(stream, &mut sim).unwrap();
        for row in 0..5 {
            sink.history(&mut sim, row).unwrap();
            if row % 2 == 0 {
                sink.frame(&mut sim, row).unwrap();
            }
            sim.step(0.01).unwrap();
        }
        let particles = sim.describe().particles;
        (storage.take(), particles)
    }

    #[test]
    fn frames_and_rows_are_all_there_and_the_same_in_every_run() {
        let (messages, particles) = record();
        let frames = positions(&messages);
        assert_eq!(frames.iter().map(|f| f.0).collect::<Vec<_>>(), [0, 20_000_000, 40_000_000]);
        assert!(frames.iter().all(|f| f.1.len() == particles));
        assert!(frames[0].1 != frames[2].1, "particles move");
        let tip = scalars(&messages, "/probe/tip/displacement");
        assert_eq!(tip.iter().map(|r| r.1.len()).collect::<Vec<_>>(), [2; 5]);
        assert_eq!(scalars(&messages, "/energy/kinetic").len(), 5);

        let (again, _) = record();
        assert_eq!(positions(&again), frames);
        assert_eq!(scalars(&again, "/probe/tip/displacement"), tip);
    }
}
