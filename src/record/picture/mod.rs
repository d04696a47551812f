//! Pictures of frames: SVG, 900 px wide, true to scale, or PNG; one, or several on a sheet.

mod frame;
mod line;
mod plane;
#[cfg(feature = "png")]
mod raster;
mod sheet;
mod solid;

pub use sheet::{picture_of, sheet};

use super::lattice::Lattice;
use super::options::free;
use super::particles::{all_von_mises, spacing};
use super::{RecordError, Sink};
use crate::Simulation;
use crate::component::ComponentError;
use crate::draft::Draft;
use crate::scene::Scene;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Most particles in one picture; a viewer gets slow with more.
const MOST_DRAWN: usize = 20_000;

/// A picture as the bytes of a file: PNG where the path ends so, SVG otherwise.
///
/// # Errors
/// A PNG that this program was built without.
pub(crate) fn encode(path: &Path, svg: String) -> Result<Vec<u8>, RecordError> {
    if !path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("png")) {
        return Ok(svg.into_bytes());
    }
    #[cfg(feature = "png")]
    return raster::png(&svg).map_err(|reason| RecordError::content(path, reason));
    #[cfg(not(feature = "png"))]
    Err(RecordError::Ending { path: path.to_path_buf() })
}

/// Draws the last frame of a run, coloured by von Mises stress, over the undeformed bodies.
pub struct PictureSink {
    path: PathBuf,
    draft: Option<Draft>,
    file: Option<PathBuf>,
    force: bool,
}

impl PictureSink {
    /// A sink for the SVG or PNG file `path`.
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
            draft.write_bytes(&encode(&self.path, snapshot.draw())?)?;
            self.file = Some(draft.finish()?);
        }
        Ok(())
    }

    fn files(&self) -> Vec<PathBuf> {
        self.file.iter().cloned().collect()
    }
}

/// What says how particles are deformed.
enum Deformed {
    /// Deformation gradient, 9 numbers a particle in C-order.
    Gradient(Vec<f64>),
    /// Where their neighbours are.
    Lattice(Arc<Lattice>),
}

/// What is drawn: a copy of a frame.
struct Snapshot {
    scene: Scene,
    time: f64,
    /// Where each particle is \[m\], `dimension` numbers a particle.
    position: Vec<f64>,
    /// Where each particle was at time 0 \[m\].
    initial: Vec<f64>,
    /// What particles have become.
    shape: Deformed,
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
    /// Colours reach at least up to this von Mises stress \[Pa\]: pictures on a sheet share them.
    largest: f64,
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
            shape: Deformed::Gradient(sim.get(gradient_name)?.to_vec()),
            largest: 0.0,
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

    /// As SVG.
    fn draw(&self) -> String {
        match self.dimension() {
            1 => line::draw(self),
            2 => plane::draw(self),
            _ => solid::draw(self),
        }
    }

    fn len(&self) -> usize {
        self.von_mises.len()
    }

    /// Edge `axis` of the cuboid around particle `p`: at time 0 and now, `D` coordinates \[m\].
    fn edge<const D: usize>(&self, p: usize, axis: usize) -> ([f64; D], [f64; D]) {
        let length = self.spacing[self.body[p]][axis];
        let before = std::array::from_fn(|row| if row == axis { length } else { 0.0 });
        let now = match &self.shape {
            Deformed::Gradient(gradient) => std::array::from_fn(|row| gradient[9 * p + 3 * row + axis] * length),
            Deformed::Lattice(lattice) => {
                let edge = lattice.edge(&self.position, p, axis);
                std::array::from_fn(|row| edge[row])
            }
        };
        (before, now)
    }

    /// Coordinates of particle `p` in `all`, one of the arrays of positions.
    fn at<const D: usize>(all: &[f64], p: usize) -> [f64; D] {
        std::array::from_fn(|axis| all[D * p + axis])
    }
}
