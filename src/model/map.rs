//! Bodies whose fitted grid is bent: where a place of the grid is in space.

use crate::scene::Shape;
use nalgebra::{Matrix3, Vector3};

/// From the grid of a body to space. Along both axes of the grid lengths are about those in space.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Quadrilateral {
    /// In the order of the grid: low low, high low, high high, low high \[m\].
    corners: [Vector3<f64>; 4],
    /// Lengths of the grid \[m\].
    pub(crate) lengths: [f64; 2],
}

impl Quadrilateral {
    /// Of a polygon with four corners; `None` for other shapes.
    pub(crate) fn new(shape: &Shape) -> Option<Self> {
        let Shape::Polygon { points } = shape else { return None };
        let [a, b, c, d] = &points[..] else { return None };
        let [a, b, c, d] = [a, b, c, d].map(|p| Vector3::new(p[0], p[1], 0.0));
        // against the clock
        let corners = if (b - a).cross(&(c - a)).z > 0.0 { [a, b, c, d] } else { [a, d, c, b] };
        let [a, b, c, d] = corners;
        let lengths = [0.5 * ((b - a).norm() + (c - d).norm()), 0.5 * ((d - a).norm() + (c - b).norm())];
        Some(Self { corners, lengths })
    }

    /// Whether it is nowhere folded over.
    pub(crate) fn is_convex(&self) -> bool {
        (0..4).all(|i| {
            let [a, b, c] = [0, 1, 2].map(|k| self.corners[(i + k) % 4]);
            (b - a).cross(&(c - b)).z > 0.0
        })
    }

    /// Where a place of the grid is \[m\].
    pub(crate) fn place(&self, at: [f64; 3]) -> [f64; 3] {
        let [a, b, c, d] = self.corners;
        let (s, t) = (at[0] / self.lengths[0], at[1] / self.lengths[1]);
        (a * ((1.0 - s) * (1.0 - t)) + b * (s * (1.0 - t)) + c * (s * t) + d * ((1.0 - s) * t)).into()
    }

    /// Derivative of the place in space by that in the grid \[-\].
    pub(crate) fn jacobian(&self, at: [f64; 3]) -> Matrix3<f64> {
        let [a, b, c, d] = self.corners;
        let (s, t) = (at[0] / self.lengths[0], at[1] / self.lengths[1]);
        let along = ((b - a) * (1.0 - t) + (c - d) * t) / self.lengths[0];
        let up = ((d - a) * (1.0 - s) + (c - b) * s) / self.lengths[1];
        Matrix3::from_columns(&[along, up, Vector3::z()])
    }

    /// The place of the grid that is at `place`, by Newton's method.
    pub(crate) fn inverse(&self, place: [f64; 3]) -> [f64; 3] {
        let mut at = [0.5 * self.lengths[0], 0.5 * self.lengths[1], 0.0];
        for _ in 0..20 {
            let miss = Vector3::from(place) - Vector3::from(self.place(at));
            let Some(inverse) = self.jacobian(at).try_inverse() else { break };
            let step = inverse * miss;
            (0..2).for_each(|a| at[a] += step[a]);
            if step.norm() <= 1e-15 * self.lengths[0].max(self.lengths[1]) {
                break;
            }
        }
        at
    }

    /// Name on the grid of an edge of the polygon, `edge1` and on.
    pub(crate) fn side(&self, shape: &Shape, edge: &str) -> Option<&'static str> {
        let Shape::Polygon { points } = shape else { return None };
        let number = edge.strip_prefix("edge")?.parse().ok().filter(|number| (1..=points.len()).contains(number))?;
        let end = |k: usize| Vector3::new(points[k % 4][0], points[k % 4][1], 0.0);
        let (from, to) = (end(number - 1), end(number));
        let middle = (from + to) * 0.5;
        let names = ["y-", "x+", "y+", "x-"];
        (0..4).find(|&i| ((self.corners[i] + self.corners[(i + 1) % 4]) * 0.5 - middle).norm() == 0.0).map(|i| names[i])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_inverse_undoes_the_map() {
        let points = vec![vec![0.0, 0.0], vec![0.0, 44.0], vec![48.0, 60.0], vec![48.0, 44.0]];
        let shape = Shape::Polygon { points };
        let map = Quadrilateral::new(&shape).unwrap();
        assert!(map.is_convex());
        for at in [[0.0, 0.0, 0.0], [10.0, 5.0, 0.0], [map.lengths[0], map.lengths[1], 0.0]] {
            let back = map.inverse(map.place(at));
            assert!((0..3).all(|a| (back[a] - at[a]).abs() < 1e-12 * map.lengths[0]));
            // the map is linear along each axis: any difference is exact
            let h = 1e-3;
            let along: Vec<f64> =
                (0..2).map(|i| (map.place([at[0] + h, at[1], 0.0])[i] - map.place([at[0] - h, at[1], 0.0])[i]) / (2.0 * h)).collect();
            assert!((0..2).all(|i| (map.jacobian(at)[(i, 0)] - along[i]).abs() < 1e-10));
        }
        // the last edge but one goes down on the right
        assert_eq!(map.side(&shape, "edge3"), Some("x+"));
        assert_eq!(map.side(&shape, "edge1"), Some("x-"));
        assert_eq!(map.side(&shape, "edge5"), None);
    }
}
