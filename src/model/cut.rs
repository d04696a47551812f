//! Bodies of the total formulation whose edge or surface cuts the cells of their grid.

use super::outline::Outline;
use super::sample::Sample;
use super::skin::Skin;
use super::{Body, side_of_box};
use crate::basis::Axis;
pub(super) use crate::quadrature::Lost;
use crate::quadrature::{CutQuadrature, GridAxis, Point, SolidQuadrature};
use crate::scene::{Body as SceneBody, FacePoint, OneOrEach, Scene};

/// How the grid of a body fits it.
#[derive(Debug, Clone)]
pub(crate) enum Fit {
    /// Its faces are those of the grid; or it has none of its own.
    Whole,
    /// Its edge or surface runs through the cells.
    Cut(Cut),
    /// The grid is that of the smallest box around it, and what is in it is known to a particle only; with the reason.
    Around(&'static str),
}

/// The edge or surface of a body that cuts cells, point by point.
#[derive(Debug, Clone)]
pub(crate) struct Cut {
    dimension: usize,
    /// Names of the faces.
    faces: Vec<String>,
    points: Vec<CutPoint>,
}

/// A point of a face.
#[derive(Debug, Clone, Copy)]
pub(crate) struct CutPoint {
    /// Number of the face.
    face: usize,
    /// \[m\]
    pub(crate) position: [f64; 3],
    /// Outward unit normal times area, in a plane times length \[m2, m\].
    pub(crate) area: [f64; 3],
}

impl Fit {
    pub(crate) fn cut(&self) -> Option<&Cut> {
        match self {
            Self::Cut(cut) => Some(cut),
            Self::Whole | Self::Around(_) => None,
        }
    }
}

impl Cut {
    fn new(dimension: usize, points: impl Iterator<Item = (String, [f64; 3], [f64; 3])>) -> Self {
        let mut cut = Self { dimension, faces: Vec::new(), points: Vec::new() };
        for (name, position, area) in points {
            let known = cut.faces.iter().position(|face| *face == name);
            let face = known.unwrap_or_else(|| {
                cut.faces.push(name);
                cut.faces.len() - 1
            });
            cut.points.push(CutPoint { face, position, area });
        }
        cut
    }

    /// All points.
    pub(crate) fn points(&self) -> &[CutPoint] {
        &self.points
    }

    /// The points of a face.
    pub(crate) fn face<'a>(&'a self, name: &str) -> impl Iterator<Item = &'a CutPoint> {
        let number = self.faces.iter().position(|face| face == name);
        self.points.iter().filter(move |point| Some(point.face) == number)
    }

    /// The points of a face for a load.
    pub(super) fn face_points(&self, name: &str) -> Vec<FacePoint> {
        let cut = |x: &[f64; 3]| x[..self.dimension].to_vec();
        self.face(name).map(|point| FacePoint { position: cut(&point.position), area: cut(&point.area) }).collect()
    }
}

/// The grid of a body, its particles, which are points that integrate over it, and its edge or surface.
pub(super) type Made = (Vec<Axis>, Vec<Sample>, Cut);

/// The grid of a body, cells of that of the scene with rows around that keep its functions off the ends, each axis with its number of particles.
fn around([lower, upper]: [&[f64]; 2], axes: &[Axis], per_cell: &OneOrEach<usize>) -> (Vec<Axis>, Vec<GridAxis>) {
    let around = |a: usize| {
        let (origin, cell) = (axes[a].origin(), axes[a].cell_size());
        let rows = axes[a].width() as i32;
        let first = ((lower[a] - origin) / cell).floor() as i32 - rows;
        let last = ((upper[a] - origin) / cell).ceil() as i32 + rows;
        Axis::new(origin + cell * f64::from(first), cell, (last - first) as usize, axes[a].family())
    };
    let own: Vec<Axis> = (0..axes.len()).map(around).collect();
    let line = |a: usize| GridAxis::of(&own[a], per_cell.axis(a).unwrap_or(1));
    let lines = (0..axes.len()).map(line).collect();
    (own, lines)
}

fn samples(points: &[Point]) -> Vec<Sample> {
    points.iter().map(|point| Sample { position: point.position, volume: point.weight }).collect()
}

/// A plane body.
pub(super) fn cut(outline: &Outline, bounds: [&[f64]; 2], axes: &[Axis], per_cell: &OneOrEach<usize>) -> Result<Made, Lost> {
    let (own, lines) = around(bounds, axes, per_cell);
    let mut quadrature = CutQuadrature::new([lines[0], lines[1]]);
    quadrature.prepare(&outline.loops)?;
    let edge = quadrature.edge.iter().map(|point| {
        let [within, of] = point.curve.map(|number| number as usize);
        let [[x, y], [u, v]] = [point.position, point.area];
        (outline.faces[within][of].clone(), [x, y, 0.0], [u, v, 0.0])
    });
    Ok((own, samples(&quadrature.points), Cut::new(2, edge)))
}

/// A body in space.
pub(super) fn cut_in_space(skin: &Skin, bounds: [&[f64]; 2], axes: &[Axis], per_cell: &OneOrEach<usize>) -> Made {
    let (own, lines) = around(bounds, axes, per_cell);
    let quadrature = SolidQuadrature::new(&[lines[0], lines[1], lines[2]], &skin.solid);
    let surface = quadrature.surface.iter().map(|point| {
        let [part, number] = point.bound.map(|number| number as usize);
        (skin.faces[part][number].clone(), point.position, point.area)
    });
    (own, samples(&quadrature.points), Cut::new(3, surface))
}

/// Axis and end of the grid of a body that are a face of it, where the grid is fitted to it; why the face cannot be held, if so.
pub(super) fn surface_end(body: &Body, described: &SceneBody, face: &str, scene: &Scene) -> Result<Option<(usize, bool)>, String> {
    if !scene.method.is_total() {
        return Ok(None);
    }
    let side = match (&body.fit, &body.map) {
        (Fit::Cut(_), _) if !body.material.has_potential() => {
            return Err("holds a face that cuts cells, for which the material must have a stored energy, as hypo_elastic has not".into());
        }
        (Fit::Cut(_), _) if scene.method.mean_dilatation => {
            return Err("holds a face that cuts cells, which does not go with `method.mean_dilatation`".into());
        }
        (Fit::Cut(_), _) => return Ok(None),
        (Fit::Around(why), _) => return Err(format!("holds a face of `{}`, whose edge is not known: {why}; take a region", body.name)),
        (Fit::Whole, Some(map)) => map.side(&described.shape, face).unwrap_or_default(),
        (Fit::Whole, None) => face,
    };
    Ok(side_of_box(side))
}
