//! Plane bodies as images of the unit square at time 0: what their rows and columns of particles lie along.

use super::sample::{Sample, up_to_the_ends};
use super::{Quadrilateral, side_of_box};
use crate::scene::Shape;
use std::f64::consts::PI;

/// From the unit square to a body.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Chart {
    Box {
        min: [f64; 2],
        max: [f64; 2],
    },
    Quadrilateral(Quadrilateral),
    /// By radius and angle: the upper side of the second axis is joined to the lower one.
    Ring {
        center: [f64; 2],
        inner: f64,
        outer: f64,
    },
}

impl Chart {
    /// Of a box, a polygon with four corners or a ring; `None` for other shapes.
    pub(crate) fn new(shape: &Shape) -> Option<Self> {
        match shape {
            Shape::Box { min, max } => Some(Self::Box { min: [min[0], min[1]], max: [max[0], max[1]] }),
            Shape::Ring { center, inner, outer } => Some(Self::Ring { center: [center[0], center[1]], inner: *inner, outer: *outer }),
            _ => Quadrilateral::new(shape).filter(Quadrilateral::is_convex).map(Self::Quadrilateral),
        }
    }

    /// Whether the second axis leads around.
    pub(crate) fn is_joined(&self) -> bool {
        matches!(self, Self::Ring { .. })
    }

    /// Lengths along the axes, in the middle \[m\].
    fn lengths(&self) -> [f64; 2] {
        match self {
            Self::Box { min, max } => [0, 1].map(|a| max[a] - min[a]),
            Self::Quadrilateral(map) => map.lengths,
            Self::Ring { inner, outer, .. } => [outer - inner, PI * (inner + outer)],
        }
    }

    /// Position at time 0 of a place on the square \[m\].
    pub(crate) fn place(&self, at: [f64; 2]) -> [f64; 3] {
        match self {
            Self::Box { min, max } => [min[0] + at[0] * (max[0] - min[0]), min[1] + at[1] * (max[1] - min[1]), 0.0],
            Self::Quadrilateral(map) => map.place([at[0] * map.lengths[0], at[1] * map.lengths[1], 0.0]),
            Self::Ring { center, inner, outer } => {
                let (radius, (sin, cos)) = (inner + at[0] * (outer - inner), (2.0 * PI * at[1]).sin_cos());
                [center[0] + radius * cos, center[1] + radius * sin, 0.0]
            }
        }
    }

    /// Length \[m\] at time 0 per length along an axis of the square.
    pub(crate) fn stretch(&self, axis: usize, at: [f64; 2]) -> f64 {
        match self {
            Self::Box { .. } => self.lengths()[axis],
            Self::Quadrilateral(map) => {
                map.lengths[axis] * map.jacobian([at[0] * map.lengths[0], at[1] * map.lengths[1], 0.0]).column(axis).norm()
            }
            Self::Ring { inner, outer, .. } if axis == 0 => outer - inner,
            Self::Ring { inner, outer, .. } => 2.0 * PI * (inner + at[0] * (outer - inner)),
        }
    }

    /// The side of the square that is a face of the body: the axis across it, and whether it is the upper one.
    pub(crate) fn side(&self, shape: &Shape, face: &str) -> Option<(usize, bool)> {
        let name = match self {
            Self::Box { .. } => face,
            Self::Quadrilateral(map) => map.side(shape, face)?,
            Self::Ring { .. } => return Some((0, face == "outer")),
        };
        side_of_box(name)
    }

    /// Even particles along both axes, about as far apart as `spacing` \[m\] says, the last axis fastest; and where they are on the square.
    ///
    /// Those at the ends stand on the edge of the body, with half a share: what is known there need not be extrapolated. From half a spacing
    /// away small waves at a free edge grew whatever the step (an expanding ring, 40 cells a metre, degree 3: folded after a fifth of its
    /// period).
    pub(super) fn sample(&self, spacing: [f64; 2]) -> (Vec<Sample>, [Vec<f64>; 2]) {
        let lengths = self.lengths();
        let axes = [0, 1].map(|a| {
            let count = (lengths[a] / spacing[a]).round().max(1.0);
            if a == 1 && self.is_joined() {
                (0..count as usize).map(|i| ((i as f64 + 0.5) / count, 1.0 / count)).collect::<Vec<_>>()
            } else {
                up_to_the_ends(count)
            }
        });
        let of = |(s, s_share): (f64, f64), (t, t_share): (f64, f64)| {
            // exact for a part of a box, a quadrilateral or a ring: the area is linear along each axis
            let area = match self {
                Self::Quadrilateral(map) => map.jacobian([s * lengths[0], t * lengths[1], 0.0]).determinant() * lengths[0] * lengths[1],
                Self::Box { .. } | Self::Ring { .. } => self.stretch(0, [s, t]) * self.stretch(1, [s, t]),
            };
            Sample { position: self.place([s, t]), volume: area * s_share * t_share }
        };
        let samples = axes[0].iter().flat_map(|s| axes[1].iter().map(move |t| of(*s, *t))).collect();
        (samples, axes.map(|line| line.iter().map(|(site, _)| *site).collect()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn particles_fill_their_body_and_stretches_are_slopes() {
        let slanted = Shape::Polygon { points: vec![vec![0.0, 0.0], vec![2.0, 0.3], vec![2.2, 1.4], vec![-0.1, 1.0]] };
        let shapes = [
            (Shape::Box { min: vec![0.1, 0.2], max: vec![1.0, 0.7] }, 0.45),
            (Shape::Ring { center: vec![1.0, 2.0], inner: 0.75, outer: 1.25 }, PI),
            // shoelace
            (slanted, 0.5 * (2.0 * 1.4 - 2.2 * 0.3 + 2.2 * 1.0 + 0.1 * 1.4)),
        ];
        for (shape, area) in shapes {
            let chart = Chart::new(&shape).unwrap();
            let (samples, sites) = chart.sample([0.1, 0.1]);
            assert_eq!(samples.len(), sites[0].len() * sites[1].len());
            // round-off
            assert!((samples.iter().map(|s| s.volume).sum::<f64>() - area).abs() < 1e-12, "{shape:?}");
            for axis in 0..2 {
                let at = |by: f64| {
                    let mut at = [0.3, 0.8];
                    at[axis] += by;
                    nalgebra::Vector3::from(chart.place(at))
                };
                // a central difference
                assert!(((at(1e-5) - at(-1e-5)).norm() / 2e-5 - chart.stretch(axis, [0.3, 0.8])).abs() < 1e-7);
            }
            for face in shape.faces() {
                let (axis, upper) = chart.side(&shape, &face.name).unwrap();
                for along in [0.1, 0.7] {
                    let mut at = [along; 2];
                    at[axis] = f64::from(u8::from(upper));
                    let place = chart.place(at);
                    let nearest = face
                        .points(&[1e-3; 2])
                        .iter()
                        .map(|p| (p.position[0] - place[0]).hypot(p.position[1] - place[1]))
                        .fold(1.0, f64::min);
                    assert!(nearest < 1e-3, "{}", face.name);
                }
            }
        }
    }
}
