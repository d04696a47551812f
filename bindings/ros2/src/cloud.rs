//! The particles as `sensor_msgs/PointCloud2`.

use crate::interfaces::Bytes;
use crate::interfaces::standard::{Header, PointCloud2, PointField};
use crate::parameters::{Mode, Settings};
use matpoint::Simulation;
use matpoint::component::ComponentError;
use matpoint::record::{pressure, von_mises};
use std::sync::Arc;
use std::time::Duration;

const FLOAT32: u8 = 7;
const UINT32: u8 = 6;

/// What stands in a point: positions, and the columns asked for.
#[derive(Debug, Clone, PartialEq)]
pub struct Layout {
    columns: Vec<Column>,
    fields: Vec<PointField>,
    point_step: usize,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Column {
    Position,
    Velocity,
    VonMises,
    Pressure,
    Displacement,
    Body,
    Id,
}

impl Column {
    /// Names of the fields, each of four bytes.
    fn fields(self) -> (&'static [&'static str], u8) {
        match self {
            Self::Position => (&["x", "y", "z"], FLOAT32),
            Self::Velocity => (&["vx", "vy", "vz"], FLOAT32),
            Self::VonMises => (&["von_mises"], FLOAT32),
            Self::Pressure => (&["pressure"], FLOAT32),
            Self::Displacement => (&["dx", "dy", "dz"], FLOAT32),
            Self::Body => (&["body"], UINT32),
            Self::Id => (&["id"], UINT32),
        }
    }
}

impl Layout {
    /// Positions and the columns named by `particles.fields`.
    pub fn new(names: &[String]) -> Self {
        let named = names.iter().filter_map(|name| {
            Some(match name.as_str() {
                "velocity" => Column::Velocity,
                "von_mises" => Column::VonMises,
                "pressure" => Column::Pressure,
                "displacement" => Column::Displacement,
                "body" => Column::Body,
                "id" => Column::Id,
                _ => return None,
            })
        });
        let (mut columns, mut fields) = (Vec::new(), Vec::new());
        for column in std::iter::once(Column::Position).chain(named) {
            if columns.contains(&column) {
                continue;
            }
            columns.push(column);
            let (names, datatype) = column.fields();
            let first = fields.len();
            let field = |(i, name): (usize, &&str)| PointField { name: (*name).into(), offset: 4 * (first + i) as u32, datatype, count: 1 };
            fields.extend(names.iter().enumerate().map(field));
        }
        let point_step = 4 * fields.len();
        Self { columns, fields, point_step }
    }

    /// Bytes of a point.
    pub fn point_step(&self) -> usize {
        self.point_step
    }

    /// The cloud of every `stride`-th particle.
    ///
    /// # Errors
    /// A state that cannot be measured.
    pub fn build(&self, sim: &mut Simulation, dimension: usize, stride: usize, header: Header) -> Result<PointCloud2, ComponentError> {
        let points = sim.get("particle/mass")?.len().div_ceil(stride);
        let mut data = vec![0u8; points * self.point_step];
        let mut at = 0;
        for column in &self.columns {
            match column {
                Column::Position => self.vectors(&mut data, at, sim.get("particle/position")?, dimension, stride),
                Column::Velocity => self.vectors(&mut data, at, sim.get("particle/velocity")?, dimension, stride),
                Column::Displacement => self.vectors(&mut data, at, sim.get("particle/displacement")?, dimension, stride),
                Column::VonMises => self.scalars(&mut data, at, sim.get("particle/stress")?.chunks_exact(9).step_by(stride).map(von_mises)),
                Column::Pressure => self.scalars(&mut data, at, sim.get("particle/stress")?.chunks_exact(9).step_by(stride).map(pressure)),
                Column::Body => self.words(&mut data, at, sim.get("particle/body")?.iter().step_by(stride).map(|&b| b as u32)),
                Column::Id => self.words(&mut data, at, (0..points).map(|i| (i * stride) as u32)),
            }
            at += 4 * column.fields().0.len();
        }
        Ok(PointCloud2::row(header, self.fields.clone(), self.point_step, Bytes(Arc::new(data))))
    }

    fn vectors(&self, data: &mut [u8], at: usize, values: &[f64], dimension: usize, stride: usize) {
        for (point, value) in data.chunks_exact_mut(self.point_step).zip(values.chunks_exact(dimension).step_by(stride)) {
            for (axis, v) in value.iter().enumerate() {
                let start = at + 4 * axis;
                point[start..start + 4].copy_from_slice(&(*v as f32).to_le_bytes());
            }
        }
    }

    fn scalars(&self, data: &mut [u8], at: usize, values: impl Iterator<Item = f64>) {
        self.words(data, at, values.map(|v| (v as f32).to_bits()));
    }

    fn words(&self, data: &mut [u8], at: usize, values: impl Iterator<Item = u32>) {
        for (point, word) in data.chunks_exact_mut(self.point_step).zip(values) {
            point[at..at + 4].copy_from_slice(&word.to_le_bytes());
        }
    }
}

/// Points of `point_step` bytes in a message of at most `bytes` bytes of them; one at least.
pub fn points_in(bytes: usize, point_step: usize) -> usize {
    (bytes / point_step.max(1)).max(1)
}

/// Every how many-th of `particles` is sent, in points of `point_step` bytes.
pub fn stride(settings: &Settings, particles: usize, point_step: usize) -> usize {
    match settings.mode {
        Mode::Strided => settings.stride.max(particles.div_ceil(points_in(settings.max_bytes, point_step))).max(1),
        Mode::Whole | Mode::Tiles => 1,
    }
}

/// What is said once where particles are left out that nobody asked to leave out.
pub fn thinned(settings: &Settings, particles: usize, stride: usize) -> Option<String> {
    (stride > 1 && settings.stride == 0).then(|| {
        format!(
            "~/particles has every {stride}th of {particles} particles: receivers with default buffers lose larger clouds; particles.mode \
             `tiles` or `whole` sends all"
        )
    })
}

/// Points in a tile, of `point_step` bytes each, and the time over which the tiles of a cloud are sent: most of the `period` \[s\] until the
/// next one. `None` where a cloud is one message.
pub fn tiling(settings: &Settings, point_step: usize, period: f64) -> Option<(usize, Duration)> {
    (settings.mode == Mode::Tiles).then(|| (points_in(settings.max_bytes, point_step), Duration::from_secs_f64(0.9 * period)))
}

/// Every `stride`-th point of a cloud.
pub fn thin(cloud: PointCloud2, stride: usize) -> PointCloud2 {
    if stride <= 1 {
        return cloud;
    }
    let step = cloud.point_step as usize;
    let data = cloud.data.0.chunks_exact(step).step_by(stride).flatten().copied().collect();
    PointCloud2::row(cloud.header, cloud.fields, step, Bytes(Arc::new(data)))
}

/// A cloud in pieces of at most `points` points, in order; they share stamp and frame.
pub fn tiles(cloud: &PointCloud2, points: usize) -> impl ExactSizeIterator<Item = PointCloud2> {
    let step = cloud.point_step as usize;
    let piece = move |tile: &[u8]| PointCloud2::row(cloud.header.clone(), cloud.fields.clone(), step, Bytes(Arc::new(tile.to_vec())));
    cloud.data.0.chunks(points * step).map(piece)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::parameters::Parameters;
    use matpoint::scene::Scene;

    fn cantilever() -> Simulation {
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../launch_scripts/scenes/cantilever.toml");
        let mut sim = Scene::load(path).unwrap().build().unwrap();
        sim.step(0.1).unwrap();
        sim
    }

    fn floats(cloud: &PointCloud2, name: &str) -> Vec<f32> {
        let offset = cloud.fields.iter().find(|f| f.name == name).unwrap().offset as usize;
        let read = |p: &[u8]| f32::from_le_bytes(p[offset..offset + 4].try_into().unwrap());
        cloud.data.0.chunks_exact(cloud.point_step as usize).map(read).collect()
    }

    #[test]
    fn a_cloud_has_the_values_of_the_variables() {
        let mut sim = cantilever();
        let all: Vec<String> = crate::parameters::FIELDS.iter().map(|&f| f.to_owned()).collect();
        let layout = Layout::new(&all);
        assert_eq!(layout.point_step(), 4 * (3 + 3 + 1 + 1 + 3 + 1 + 1));
        let cloud = layout.build(&mut sim, 2, 7, Header::default()).unwrap();
        let particles = sim.describe().particles;
        assert_eq!(cloud.width as usize, particles.div_ceil(7));
        assert_eq!(cloud.data.0.len(), (cloud.row_step * cloud.height) as usize);
        let column = |values: &[f64], width: usize, axis: usize| -> Vec<f32> {
            values.chunks_exact(width).step_by(7).map(|v| v[axis] as f32).collect()
        };
        assert_eq!(floats(&cloud, "y"), column(sim.get("particle/position").unwrap(), 2, 1));
        assert_eq!(floats(&cloud, "vx"), column(sim.get("particle/velocity").unwrap(), 2, 0));
        assert_eq!(floats(&cloud, "dy"), column(sim.get("particle/displacement").unwrap(), 2, 1));
        assert!(floats(&cloud, "z").iter().chain(&floats(&cloud, "vz")).all(|&v| v == 0.0));
        let stress: Vec<f64> = sim.get("particle/stress").unwrap()[63..72].to_vec();
        assert_eq!(floats(&cloud, "von_mises")[1], von_mises(&stress) as f32);
        assert_eq!(floats(&cloud, "pressure")[1], pressure(&stress) as f32);
        assert_eq!(floats(&cloud, "id")[3].to_bits(), 21);
    }

    #[test]
    fn a_thinned_cloud_is_the_one_of_that_stride() {
        let mut sim = cantilever();
        let layout = Layout::new(&["id".to_owned()]);
        let mut build = |stride| layout.build(&mut sim, 2, stride, Header::default()).unwrap();
        let whole = build(1);
        assert_eq!(thin(whole.clone(), 7), build(7));
        assert_eq!(thin(whole.clone(), 1), whole);
    }

    #[test]
    fn tiles_are_the_cloud_cut_in_order() {
        let mut sim = cantilever();
        let layout = Layout::new(&[]);
        let cloud = layout.build(&mut sim, 2, 1, Header { frame_id: "map".into(), ..Default::default() }).unwrap();
        let cut: Vec<_> = tiles(&cloud, 500).collect();
        assert_eq!(cut.iter().map(|t| t.width).collect::<Vec<_>>(), [500, 500, 152]);
        let joined: Vec<u8> = cut.iter().flat_map(|t| t.data.0.iter().copied()).collect();
        assert_eq!(joined, *cloud.data.0);
        assert!(cut.iter().all(|t| t.header == cloud.header && t.row_step as usize == t.data.0.len()));
    }

    #[test]
    fn measures_of_stress_and_strides() {
        let pure_shear = [0.0, 2.0, 0.0, 2.0, 0.0, 0.0, 0.0, 0.0, 0.0];
        assert!((von_mises(&pure_shear) - 2.0 * 3f64.sqrt()).abs() < 1e-12);
        assert_eq!(pressure(&[3.0, 0.0, 0.0, 0.0, 6.0, 0.0, 0.0, 0.0, 0.0]), -3.0);
        let settings = Settings { max_bytes: 80_000, ..Parameters::default().settings };
        assert_eq!([5000, 5001, 100_000].map(|particles| stride(&settings, particles, 16)), [1, 2, 20]);
        assert_eq!(stride(&Settings { max_bytes: 1, ..settings.clone() }, 3, 16), 3);
        assert_eq!(stride(&Settings { mode: Mode::Whole, ..settings }, 100_000, 16), 1);
    }
}
