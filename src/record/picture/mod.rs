//! A picture of the last frame: SVG, 900 px wide, true to scale, without any dependency.

mod frame;
mod line;
mod plane;
mod solid;

use super::particles::{all_von_mises, spacing};
use super::options::free;
use super::{RecordError, Sink};
use crate::Simulation;
use crate::component::ComponentError;
use crate::draft::Draft;
use crate::scene::Scene;
use std::path::{Path, PathBuf};

/// Most particles in one picture; a viewer gets slow with more.
const MOST_DRAWN: usize = 20_000;

/// Draws the last frame of a run, coloured by von Mises stress, over the undeformed bodies.
pub struct PictureSink {
    path: PathBuf,
    draft: Option<Draft>,
    file: Option<PathBuf>,
    force: bool,
}

impl PictureSink {
    /// A sink for the SVG file `path`.
    pub fn new(path: impl AsRef<Path>) -> Self {
        Self { path: path.as_ref().to_path_buf(), draft: None, file: None, force: false }
    }

    /// Whether a picture that is there is written over.
    pub fn force(self, force: bool) -> Self {
        Self { force, ..self }
    }
}

impl Sink for PictureSink {
    fn begin(&mut self, _: &mut Simulation) -> Result<(), RecordError> {
        free(&self.path, self.force)?;
        self.draft = Some(Draft::create(&self.path)?);
        Ok(())
    }

    fn finish(&mut self, sim: &mut Simulation) -> Result<(), RecordError> {
        if let Some(mut draft) = self.draft.take() {
            let snapshot = Snapshot::take(sim)?;
            draft.write(&match snapshot.dimension() {
                1 => line::draw(&snapshot),
                2 => plane::draw(&snapshot),
                _ => solid::draw(&snapshot),
            })?;
            self.file = Some(draft.finish()?);
        }
        Ok(())
    }

    fn files(&self) -> Vec<PathBuf> {
        self.file.iter().cloned().collect()
    }
}

/// What is drawn: a copy of the last frame.
struct Snapshot {
    scene: Scene,
    time: f64,
    /// Where each particle is \[m\], `dimension` numbers a particle.
    position: Vec<f64>,
    /// Where each particle was at time 0 \[m\].
    initial: Vec<f64>,
    /// Deformation gradient, 9 numbers a particle in C-order.
    gradient: Vec<f64>,
    /// Cauchy stress \[Pa\], 9 numbers a particle.
    stress: Vec<f64>,
    /// Von Mises stress \[Pa\].
    von_mises: Vec<f64>,
    /// Number of the body of each particle.
    body: Vec<usize>,
    /// Distance of neighbours at time 0 \[m\]: body, axis.
    spacing: Vec<Vec<f64>>,
    /// Name and position \[m\] of each probe.
    probes: Vec<(String, Vec<f64>)>,
}

impl Snapshot {
    fn take(sim: &mut Simulation) -> Result<Self, ComponentError> {
        let scene = sim.scene().clone();
        let time = sim.time();
        let mut read = |name: &str| sim.get(name).map(<[f64]>::to_vec);
        let position = read("particle/position")?;
        let initial = position.iter().zip(read("particle/displacement")?).map(|(x, u)| x - u).collect();
        let stress = read("particle/stress")?;
        let body = read("particle/body")?.into_iter().map(|b| b as usize).collect();
        let probe = |name: &String| Ok((name.clone(), read(&format!("probe/{name}/position"))?));
        let gradient_name = "particle/deformation_gradient";
        Ok(Self {
            probes: scene.probe.keys().map(probe).collect::<Result<_, ComponentError>>()?,
            gradient: sim.get(gradient_name)?.to_vec(),
            von_mises: all_von_mises(&stress),
            spacing: spacing(&scene),
            scene,
            time,
            position,
            initial,
            stress,
            body,
        })
    }

    fn dimension(&self) -> usize {
        self.scene.dimension
    }

    fn len(&self) -> usize {
        self.von_mises.len()
    }

    /// Edge `axis` of the cuboid around particle `p`: at time 0 and now, `D` coordinates \[m\].
    fn edge<const D: usize>(&self, p: usize, axis: usize) -> ([f64; D], [f64; D]) {
        let length = self.spacing[self.body[p]][axis];
        let before = std::array::from_fn(|row| if row == axis { length } else { 0.0 });
        let now = std::array::from_fn(|row| self.gradient[9 * p + 3 * row + axis] * length);
        (before, now)
    }

    /// Coordinates of particle `p` in `all`, one of the arrays of positions.
    fn at<const D: usize>(all: &[f64], p: usize) -> [f64; D] {
        std::array::from_fn(|axis| all[D * p + axis])
    }
}
