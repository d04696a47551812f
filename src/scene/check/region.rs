//! Shapes: whether they make sense, and how they lie in the grid.

use super::super::{Grid, OneOrEach};
use super::{AXES, Check, Shape};
use crate::scene::fault::{counted, plain, short};

/// Most corners of a polygon: each edge is compared with each other.
const MOST_CORNERS: usize = 10_000;

/// Equal boxes side by side: the cells of the grid, or the parts of cells that particles stand for.
#[derive(Debug, Clone)]
pub(super) struct Cells {
    /// Lower corner of the first \[m\].
    pub(super) origin: Vec<f64>,
    /// Upper corner of the last \[m\].
    pub(super) end: Vec<f64>,
    /// Extent of one along each axis \[m\].
    pub(super) size: Vec<f64>,
}

impl Cells {
    /// The cells of a grid that has been checked.
    pub(super) fn new(grid: &Grid, dimension: usize) -> Self {
        Self {
            origin: grid.origin.clone(),
            end: grid.origin.iter().zip(&grid.size).map(|(origin, size)| origin + size).collect(),
            size: (0..dimension).filter_map(|axis| grid.cell.axis(axis)).collect(),
        }
    }

    /// Each cell cut into as many equal parts along each axis.
    pub(super) fn split(&self, parts: &OneOrEach<usize>) -> Self {
        let part = |(axis, size): (usize, &f64)| size / parts.axis(axis).unwrap_or(1) as f64;
        Self { size: self.size.iter().enumerate().map(part).collect(), ..self.clone() }
    }

    /// First and last centre between `low - slack` and `high + slack` along an axis, by number.
    fn range(&self, axis: usize, low: &[f64], high: &[f64], slack: f64) -> (f64, f64) {
        let number = |x: f64| (x - self.origin[axis]) / self.size[axis] - 0.5;
        // Round-off must not lose a centre that lies on the edge.
        ((number(low[axis] - slack) - 1e-9).ceil(), (number(high[axis] + slack) + 1e-9).floor())
    }

    /// How many centres lie between two corners.
    pub(super) fn count(&self, low: &[f64], high: &[f64], slack: f64) -> f64 {
        let along = |axis| {
            let (first, last) = self.range(axis, low, high, slack);
            (last - first + 1.0).max(0.0)
        };
        (0..self.size.len()).map(along).product()
    }

    /// Whether one of the centres between two corners is `wanted`.
    pub(super) fn any(&self, low: &[f64], high: &[f64], slack: f64, wanted: impl Fn(&[f64]) -> bool) -> bool {
        let dimension = self.size.len();
        let ranges: Vec<(f64, f64)> = (0..dimension).map(|axis| self.range(axis, low, high, slack)).collect();
        if ranges.iter().any(|(first, last)| last < first) {
            return false;
        }
        let mut number: Vec<f64> = ranges.iter().map(|range| range.0).collect();
        let mut x = vec![0.0; dimension];
        loop {
            for axis in 0..dimension {
                x[axis] = self.origin[axis] + (number[axis] + 0.5) * self.size[axis];
            }
            if wanted(&x) {
                return true;
            }
            // Count up, the first axis fastest.
            let Some(axis) = (0..dimension).find(|&axis| number[axis] < ranges[axis].1) else { return false };
            number[axis] += 1.0;
            for lower in 0..axis {
                number[lower] = ranges[lower].0;
            }
        }
    }
}

impl Check<'_> {
    /// Whether a shape makes sense in itself; finds nothing new.
    pub(super) fn fits(&self, shape: &Shape) -> bool {
        Check { scene: self.scene, dimension: self.dimension, cells: None, faults: Vec::new() }.region("", shape)
    }

    /// Faults of a shape in itself; whether there are none.
    pub(super) fn region(&mut self, path: &str, shape: &Shape) -> bool {
        let found = self.faults.len();
        match shape {
            Shape::Box { min, max } => {
                if self.vector(&format!("{path}.box.min"), min) & self.vector(&format!("{path}.box.max"), max) {
                    for axis in (0..self.dimension).filter(|&axis| min[axis] >= max[axis]) {
                        let message = format!("is {}; must be above min, which is {}", plain(max[axis]), plain(min[axis]));
                        self.fault(&format!("{path}.box.max[{axis}]"), message);
                    }
                }
            }
            Shape::Disk { center, radius } => {
                self.only_in(2, &format!("{path}.disk"));
                self.round(&format!("{path}.disk"), center, &[("radius", *radius)]);
            }
            Shape::Sphere { center, radius } => {
                self.only_in(3, &format!("{path}.sphere"));
                self.round(&format!("{path}.sphere"), center, &[("radius", *radius)]);
            }
            Shape::Ring { center, inner, outer } => {
                let path = format!("{path}.ring");
                self.only_in(2, &path);
                self.round(&path, center, &[("inner", *inner), ("outer", *outer)]);
                let inside_out = inner >= outer;
                self.require(!inside_out, &format!("{path}.outer"), || {
                    format!("is {}; must be above inner, which is {}", plain(*outer), plain(*inner))
                });
            }
            Shape::Polygon { points } => {
                self.only_in(2, &format!("{path}.polygon"));
                self.polygon(&format!("{path}.polygon.points"), points);
            }
            Shape::HalfSpace { point, normal } => {
                self.vector(&format!("{path}.half_space.point"), point);
                let path = format!("{path}.half_space.normal");
                if self.vector(&path, normal) {
                    self.require(normal.iter().any(|n| *n != 0.0), &path, || "is zero; must point somewhere".into());
                }
            }
            Shape::Union(parts) => self.parts(&format!("{path}.union"), parts, 1),
            Shape::Difference(parts) => self.parts(&format!("{path}.difference"), parts, 2),
            Shape::Intersection(parts) => self.parts(&format!("{path}.intersection"), parts, 1),
        }
        self.faults.len() == found
    }

    fn only_in(&mut self, dimension: usize, path: &str) {
        let own = self.dimension;
        let instead = ["box", "disk", "sphere"][own - 1];
        self.require(own == dimension, path, || format!("is for dimension {dimension}; the scene has dimension {own}, use a {instead}"));
    }

    fn round(&mut self, path: &str, center: &[f64], radii: &[(&str, f64)]) {
        self.vector(&format!("{path}.center"), center);
        for (name, radius) in radii {
            self.positive(&format!("{path}.{name}"), *radius);
        }
    }

    fn parts(&mut self, path: &str, parts: &[Shape], least: usize) {
        self.require(parts.len() >= least, path, || format!("has {}; must have at least {least}", counted(parts.len(), "part")));
        for (index, part) in parts.iter().enumerate() {
            self.region(&format!("{path}[{index}]"), part);
        }
    }

    fn polygon(&mut self, path: &str, points: &[Vec<f64>]) {
        let n = points.len();
        let enough =
            self.require((3..=MOST_CORNERS).contains(&n), path, || format!("has {}; must have 3 to {MOST_CORNERS}", counted(n, "corner")));
        let placed = (0..n).fold(true, |right, i| self.vector(&format!("{path}[{i}]"), &points[i]) & right);
        if !enough || !placed || self.dimension != 2 {
            return;
        }
        if let Some(i) = (0..n).find(|&i| points[i] == points[(i + 1) % n]) {
            let message = if i + 1 == n { "repeats the first corner; leave it out" } else { "is the same as the corner after it" };
            return self.fault(&format!("{path}[{i}]"), message);
        }
        let cross = |i: usize, j: usize| segments_meet([&points[i], &points[i + 1]], [&points[j], &points[(j + 1) % n]]);
        // Neighbours share a corner, and so do the first edge and the last.
        let crossing = (0..n - 1).find_map(|i| (i + 2..n).find(|&j| (i, j) != (0, n - 1) && cross(i, j)).map(|j| (i, j)));
        if let Some((i, j)) = crossing {
            return self.fault(path, format!("crosses itself: edge{} meets edge{}", i + 1, j + 1));
        }
        let (low, high) = Shape::Polygon { points: points.to_vec() }.bounds(2);
        let area: f64 = (0..n).map(|i| turn(&points[0], &points[i], &points[(i + 1) % n])).sum::<f64>() / 2.0;
        let flat = area.abs() <= 1e-12 * (high[0] - low[0]).max(high[1] - low[1]).powi(2);
        self.require(!flat, path, || "has no area".into());
    }

    /// Lower and upper corner of a body; a fault where it is empty or has no end.
    pub(super) fn extent(&mut self, path: &str, shape: &Shape) -> Option<(Vec<f64>, Vec<f64>)> {
        let (low, high) = shape.bounds(self.dimension);
        let bounded = low.iter().chain(&high).all(|x| x.is_finite());
        let empty = low.iter().zip(&high).any(|(low, high)| low > high);
        self.require(!empty, path, || "is empty: its parts have no point in common".into());
        self.require(empty || bounded, path, || {
            "has no end, as a half_space alone has none; make it an intersection with a box or another bounded shape".into()
        });
        (bounded && !empty).then_some((low, high))
    }

    /// A fault for every side of the grid that a body reaches over.
    pub(super) fn inside_grid(&mut self, path: &str, cells: &Cells, low: &[f64], high: &[f64]) -> bool {
        let mut inside = true;
        for axis in 0..self.dimension {
            let slack = 1e-9 * cells.size[axis];
            let sides = [('-', cells.origin[axis] - low[axis], cells.origin[axis]), ('+', high[axis] - cells.end[axis], cells.end[axis])];
            for (sign, over, end) in sides {
                inside &= self.require(over <= slack, path, || {
                    format!("reaches {} m outside the grid on side {}{sign}; the grid ends at {}", short(over), AXES[axis], short(end))
                });
            }
        }
        inside
    }

    /// A fault where a region lies beside the grid.
    pub(super) fn touches_grid(&mut self, path: &str, shape: &Shape) {
        let Some(cells) = &self.cells else { return };
        let (low, high) = shape.bounds(self.dimension);
        let touches = (0..self.dimension).all(|axis| {
            let slack = 1e-9 * cells.size[axis];
            low[axis] <= cells.end[axis] + slack && high[axis] >= cells.origin[axis] - slack
        });
        self.require(touches, path, || "lies outside the grid, so that it holds nothing".into());
    }
}

/// Twice the area of the triangle a, b, c, positive where it turns to the left.
fn turn(a: &[f64], b: &[f64], c: &[f64]) -> f64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

/// Whether two segments have a point in common.
fn segments_meet([a, b]: [&[f64]; 2], [c, d]: [&[f64]; 2]) -> bool {
    let sides = [turn(a, b, c), turn(a, b, d), turn(c, d, a), turn(c, d, b)];
    let opposite = |p: f64, q: f64| (p > 0.0 && q < 0.0) || (p < 0.0 && q > 0.0);
    // A corner that lies on the line of the other segment meets it where it lies between its ends.
    let between = |a: &[f64], b: &[f64], x: &[f64]| (0..2).all(|i| x[i] >= a[i].min(b[i]) && x[i] <= a[i].max(b[i]));
    let touching = [(sides[0], a, b, c), (sides[1], a, b, d), (sides[2], c, d, a), (sides[3], c, d, b)];
    (opposite(sides[0], sides[1]) && opposite(sides[2], sides[3]))
        || touching.iter().any(|&(side, from, to, x)| side == 0.0 && between(from, to, x))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_are_counted_and_searched_between_two_corners() {
        let cells = Cells { origin: vec![-1.0, 0.0], end: vec![1.0, 1.0], size: vec![0.5, 0.25] };
        // centres -0.75, -0.25, 0.25, 0.75 and 0.125, 0.375, 0.625, 0.875; those on the edge count
        assert_eq!(cells.count(&[-1.0, 0.0], &[1.0, 1.0], 0.0), 16.0);
        assert_eq!(cells.count(&[-0.25, 0.375], &[0.25, 0.376], 0.0), 2.0);
        assert_eq!(cells.count(&[0.0, 0.0], &[0.1, 1.0], 0.0), 0.0);
        let seen = std::cell::Cell::new(0);
        let count = |_: &[f64]| {
            seen.set(seen.get() + 1);
            false
        };
        assert!(!cells.any(&[-1.0, 0.0], &[1.0, 1.0], 0.0, count));
        assert_eq!(seen.get(), 16);
        assert!(cells.any(&[-1.0, 0.0], &[1.0, 1.0], 0.0, |x| x == [0.75, 0.875]));
    }

    #[test]
    fn segments_meet_across_and_at_ends_but_not_beside_each_other() {
        let meet = |a: [f64; 2], b: [f64; 2], c: [f64; 2], d: [f64; 2]| segments_meet([&a, &b], [&c, &d]);
        assert!(meet([0.0, 0.0], [2.0, 2.0], [0.0, 2.0], [2.0, 0.0]));
        assert!(meet([0.0, 0.0], [2.0, 0.0], [1.0, 0.0], [1.0, 5.0]));
        assert!(meet([0.0, 0.0], [2.0, 0.0], [1.0, 0.0], [3.0, 0.0]));
        assert!(!meet([0.0, 0.0], [2.0, 0.0], [3.0, 0.0], [4.0, 0.0]));
        assert!(!meet([0.0, 0.0], [2.0, 0.0], [1.0, 0.1], [1.0, 5.0]));
    }
}
