//! Bodies of the total formulation whose edge cuts the cells of their grid.

use super::Body;
use super::outline::Outline;
use super::sample::Sample;
use crate::basis::Axis;
pub(super) use crate::quadrature::Lost;
use crate::quadrature::{CutQuadrature, EdgePoint, GridAxis};
use crate::scene::{Body as SceneBody, FacePoint, OneOrEach, Scene};

/// How the grid of a body fits it.
#[derive(Debug, Clone)]
pub(crate) enum Fit {
    /// Its faces are those of the grid; or it has none of its own.
    Whole,
    /// Its edge runs through the cells.
    Cut(Cut),
    /// The grid is that of the smallest box around it, and what is in it is known to a particle only; with the reason.
    Around(&'static str),
}

/// The edge of a body that cuts cells.
#[derive(Debug, Clone)]
pub(crate) struct Cut {
    outline: Outline,
    edge: Vec<EdgePoint>,
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
    /// All points of the edge.
    pub(crate) fn edge(&self) -> &[EdgePoint] {
        &self.edge
    }

    /// The points of a face: the length of each with the outward normal.
    pub(crate) fn face(&self, name: &str) -> Vec<FacePoint> {
        let [within, of] = [0, 1].map(|k| move |point: &EdgePoint| point.curve[k] as usize);
        let on = self.edge.iter().filter(|point| self.outline.faces[within(point)][of(point)] == name);
        on.map(|point| FacePoint { position: point.position.to_vec(), area: point.area.to_vec() }).collect()
    }
}

/// The grid of a body, cells of that of the scene with rows around that keep its functions off the ends; its particles, which are points
/// that integrate over it; and its edge.
pub(super) fn cut(
    outline: Outline,
    [lower, upper]: [&[f64]; 2],
    axes: &[Axis],
    per_cell: &OneOrEach<usize>,
) -> Result<(Vec<Axis>, Vec<Sample>, Cut), Lost> {
    let around = |a: usize| {
        let (origin, cell) = (axes[a].origin(), axes[a].cell_size());
        let rows = axes[a].width() as i32;
        let first = ((lower[a] - origin) / cell).floor() as i32 - rows;
        let last = ((upper[a] - origin) / cell).ceil() as i32 + rows;
        Axis::new(origin + cell * f64::from(first), cell, (last - first) as usize, axes[a].family())
    };
    let own = vec![around(0), around(1)];
    let line = |a: usize| GridAxis {
        origin: own[a].origin(),
        cell: own[a].cell_size(),
        cells: own[a].cells() as usize,
        gauss: per_cell.axis(a).unwrap_or(1),
    };
    let mut quadrature = CutQuadrature::new([line(0), line(1)]);
    quadrature.prepare(&outline.loops)?;
    let samples = quadrature.points.iter().map(|point| Sample { position: point.position, volume: point.weight }).collect();
    Ok((own, samples, Cut { outline, edge: quadrature.edge }))
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
    Ok(["x", "y", "z"].iter().position(|axis| side.starts_with(axis)).map(|axis| (axis, side.ends_with('+'))))
}
