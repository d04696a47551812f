//! Where velocity is held.

use super::{Body, cut, fault, side_of_box};
use crate::basis::Axis;
use crate::scene::{self, Fault, Formula, Shape};

/// Where and how the velocity of the grid is held.
#[derive(Debug, Clone)]
pub(crate) struct Boundary {
    pub(crate) name: String,
    region: Region,
    /// Velocity as a formula of t by axis; `None` where it is free.
    pub(super) velocity: [Option<Formula>; 3],
}

#[derive(Debug, Clone)]
enum Region {
    /// The first or last function of an axis.
    Face {
        axis: usize,
        upper: bool,
    },
    Shape(Shape),
    /// A face of a body, by its number; the axis and end of the grid where that is fitted to it.
    Surface {
        body: usize,
        face: String,
        end: Option<(usize, bool)>,
    },
}

impl Boundary {
    pub(super) fn new(name: &str, described: &scene::Boundary, scene: &scene::Scene, bodies: &[Body]) -> Result<Self, Fault> {
        let region = match (&described.face, &described.region, &described.surface) {
            (Some(face), ..) => {
                let (axis, upper) = side_of_box(face).unwrap_or_default();
                Region::Face { axis, upper }
            }
            (None, Some(shape), _) => Region::Shape(shape.clone()),
            (None, None, Some(surface)) => {
                let body = scene.body.get_index_of(&surface.body).unwrap_or_default();
                let end = cut::surface_end(&bodies[body], &scene.body[body], &surface.face, scene)
                    .map_err(|message| Fault::new(format!("boundary.{name}.surface"), message))?;
                Region::Surface { body, face: surface.face.clone(), end }
            }
            (None, None, None) => return Err(Fault::new(format!("boundary.{name}"), "needs a `face`, a `region` or a `surface`")),
        };
        let mut velocity = [None, None, None];
        for axis in &described.fixed {
            velocity[*axis as usize] = Some(scene::Expr::Number(0.0).compile(&["t"]).map_err(fault(format!("boundary.{name}.fixed")))?);
        }
        for (axis, expr) in &described.velocity {
            velocity[*axis as usize] = Some(expr.compile(&["t"]).map_err(fault(format!("boundary.{name}.velocity")))?);
        }
        Ok(Self { name: name.into(), region, velocity })
    }

    /// The face of a body that it holds, with the number of the body.
    pub(crate) fn surface(&self) -> Option<(usize, &str)> {
        match &self.region {
            Region::Surface { body, face, .. } => Some((*body, face)),
            Region::Face { .. } | Region::Shape(_) => None,
        }
    }

    /// Whether the node of the own grid of a body lies on the face of that body that it holds.
    pub(crate) fn holds_end(&self, number: usize, axes: &[Axis], node: &[i32; 3]) -> bool {
        matches!(&self.region, Region::Surface { body, end: Some((axis, upper)), .. }
            if *body == number && axes[*axis].ends(node[*axis], *upper))
    }

    /// Whether the node of a body's own grid lies in the region: on the face of the grid of the scene, or in the shape.
    pub(crate) fn holds_place(&self, axes: &[Axis], place: &[f64]) -> bool {
        let slack = 1e-9 * Axis::smallest_cell(axes);
        match &self.region {
            Region::Face { axis, upper } => {
                let end = axes[*axis].clamped(if *upper { f64::INFINITY } else { f64::NEG_INFINITY });
                (place[*axis] - end).abs() <= slack
            }
            Region::Shape(shape) => shape.contains(place, slack),
            Region::Surface { .. } => false,
        }
    }
    /// Whether the node (for B-splines: the Greville point) lies in the region.
    pub(crate) fn holds(&self, axes: &[Axis], node: &[i32]) -> bool {
        match &self.region {
            Region::Face { axis, upper } => axes[*axis].ends(node[*axis], *upper),
            Region::Shape(shape) => {
                // a node outside the grid is held with the nearest one on its edge
                let place: Vec<f64> = node.iter().zip(axes).map(|(&i, axis)| axis.clamped(axis.node_position(i))).collect();
                let slack = 1e-9 * Axis::smallest_cell(axes);
                shape.contains(&place, slack)
            }
            Region::Surface { .. } => false,
        }
    }
    /// Velocity along `axis` at `time` \[m/s\]; `None` where it is free.
    pub(crate) fn velocity(&self, axis: usize, time: f64) -> Option<f64> {
        self.velocity[axis].as_ref().map(|f| f.eval(&[time]))
    }
    /// Holds the same nodes, but still.
    pub(crate) fn stop(&mut self) {
        for formula in self.velocity.iter_mut().flatten() {
            *formula = Formula::constant(0.0);
        }
    }
    pub(crate) fn holds_axis(&self, axis: usize) -> bool {
        self.velocity[axis].is_some()
    }
}
