//! Quadrature of a body in space in the cells of the grid: Gauss points in cells that it fills, and in cells that its surface cuts points with
//! positive weights that integrate over what is inside; points of the surface, too. Between planes polynomials are integrated exactly, at spheres
//! with the order of the rules.
//!
//! The body is a convex region less others, its holes, which are wholly inside and apart from each other. In a cut cell coordinates are
//! integrated one after the other ([`column`]). That converges where no surface turns away from the axis of the columns: with planes nothing
//! turns, at spheres the axis is that along which the surface is steepest, and a cell in which there is none is split.

mod bound;
mod column;
#[cfg(test)]
mod tests;

pub(crate) use bound::Bound;

use super::gauss::gauss_legendre;
use super::{GridAxis, Point};
use bound::reach;
use column::{Active, Column, Rules};

/// Where surfaces along the sides of cells belong, and points of several surfaces, over the cell: round-off.
const SLACK: f64 = 1e-9;
/// Lengths that are nothing, over the cell.
const NOTHING: f64 = 1e-13;
/// Least cosine between the normal of a sphere and the axis along which it is integrated; 0.577 could not be had everywhere. Measured with 4
/// points along an axis on spheres of 3.6 and 1.6 cells (`tests.rs`): at 0.4, 0.45, 0.5, 0.55 the volume is off by 2.3e-7, 2.2e-7, 2.2e-7 and 8.5e-8
/// of it, with 2.5, 2.5, 2.8 and 4.0 times the points of a whole cell in a cut one.
const STEEP: f64 = 0.45;
/// How often a cell is split at most: then pieces are too small to matter.
const SPLITS: u32 = 24;
/// Orders of the axes of a column, the outermost first.
const ORDERS: [[usize; 3]; 6] = [[0, 1, 2], [1, 0, 2], [0, 2, 1], [2, 0, 1], [1, 2, 0], [2, 1, 0]];

/// A body: what is within all bounds of the first part, and not within all bounds of any other.
#[derive(Debug, Clone)]
pub(crate) struct Solid {
    pub(crate) parts: Vec<Vec<Bound>>,
}

/// A point of the surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct SurfacePoint {
    /// Part and bound in it.
    pub(crate) bound: [u32; 2],
    /// \[m\]
    pub(crate) position: [f64; 3],
    /// Outward unit normal times area \[m2\].
    pub(crate) area: [f64; 3],
}

/// The quadrature of a body.
#[derive(Debug, Clone, Default)]
pub(crate) struct SolidQuadrature {
    /// Cell by cell, the last axis fastest.
    pub(crate) points: Vec<Point>,
    pub(crate) surface: Vec<SurfacePoint>,
}

/// What makes the points of a body.
struct Filling<'a> {
    solid: &'a Solid,
    /// Gauss points of whole cells, by axis.
    whole: [Vec<(f64, f64)>; 3],
    rules: Rules,
    /// On planes, and on spheres.
    on_surface: [Rules; 2],
    /// Largest extent of a cell \[m\].
    cell: f64,
    made: SolidQuadrature,
}

impl SolidQuadrature {
    /// Makes the points of a body. What lies beyond the grid is left out.
    pub(crate) fn new(axes: &[GridAxis; 3], solid: &Solid) -> Self {
        let n = axes.iter().map(|axis| axis.gauss).max().unwrap_or(1);
        let mut filling = Filling {
            solid,
            whole: [0, 1, 2].map(|a| gauss_legendre(axes[a].gauss)),
            rules: Rules::new(n),
            // three make the forces of pressure exact where fields are quadratic; areas of spheres converge more slowly than volumes, and their
            // points are no particles
            on_surface: [Rules::new(n.max(3)), Rules::new(n + 2)],
            cell: axes.iter().map(|axis| axis.cell).fold(0.0, f64::max),
            made: Self::default(),
        };
        let end = |a: usize, cell: usize| axes[a].origin + axes[a].cell * cell as f64;
        for i in 0..axes[0].cells {
            for j in 0..axes[1].cells {
                for k in 0..axes[2].cells {
                    let index = [i, j, k];
                    let [low, high] = [0, 1].map(|up| [0, 1, 2].map(|a| end(a, index[a] + up)));
                    filling.fill(index.map(|i| i as i32), low, high, 0);
                }
            }
        }
        filling.made
    }
}

impl Filling<'_> {
    /// The surfaces that come within `near` of a box; `None` where they leave nothing of it.
    fn actives(&self, low: &[f64; 3], high: &[f64; 3], near: f64) -> Option<Vec<Active>> {
        let mut actives = Vec::new();
        for (part, bounds) in self.solid.parts.iter().enumerate() {
            let start = actives.len();
            let mut outside = false;
            for (number, bound) in bounds.iter().enumerate() {
                let [least, most] = bound.range(low, high);
                outside |= least >= -near;
                if most > near {
                    actives.push(Active { bound: *bound, part: part as u32, number: number as u32 });
                }
            }
            match (outside, part) {
                (true, 0) => return None,
                (true, _) => actives.truncate(start),
                // wholly in a hole
                (false, 1..) if actives.len() == start => return None,
                (false, _) => {}
            }
        }
        Some(actives)
    }

    /// Makes the points of a cell or of a part of one.
    fn fill(&mut self, cell: [i32; 3], low: [f64; 3], high: [f64; 3], splits: u32) {
        let cuts = self.actives(&low, &high, NOTHING * self.cell);
        // a surface along a side of the cell does not cut it, but has points there
        let near = self.actives(&low, &high, -4.0 * SLACK * self.cell).unwrap_or_default();
        if cuts.is_none() && near.is_empty() {
            return;
        }
        let worth = |axes: &[usize; 3]| worth(&near, &low, &high, *axes);
        let best = ORDERS.into_iter().max_by(|a, b| worth(a).total_cmp(&worth(b))).unwrap_or(ORDERS[0]);
        if worth(&best) < STEEP && splits < SPLITS {
            let (axis, place) = split(&near, &low, &high);
            let (mut middle_high, mut middle_low) = (high, low);
            (middle_high[axis], middle_low[axis]) = (place, place);
            self.fill(cell, low, middle_high, splits + 1);
            self.fill(cell, middle_low, high, splits + 1);
            return;
        }
        let (slack, nothing) = (SLACK * self.cell, NOTHING * self.cell);
        let points = &mut self.made.points;
        match cuts {
            Some(cuts) if cuts.is_empty() => {
                for (x, u) in &self.whole[0] {
                    for (y, v) in &self.whole[1] {
                        for (z, w) in &self.whole[2] {
                            let at = [*x, *y, *z];
                            let position = std::array::from_fn(|a| low[a] + at[a] * (high[a] - low[a]));
                            let weight = u * v * w * (0..3).map(|a| high[a] - low[a]).product::<f64>();
                            points.push(Point { cell, position, weight });
                        }
                    }
                }
            }
            Some(cuts) => {
                let column = |axes| Column { actives: &cuts, low, high, axes, slack, nothing, rules: &self.rules };
                let count = |axes: &[usize; 3]| {
                    let mut count = 0;
                    column(*axes).volume(|_, _| count += 1);
                    count
                };
                // planes are exact in any order: that with the fewest points
                let flat = cuts.iter().all(|active| matches!(active.bound, Bound::Plane { .. }));
                let axes = if flat { ORDERS.into_iter().min_by_key(count).unwrap_or(best) } else { best };
                column(axes).volume(|position, weight| points.push(Point { cell, position, weight }));
            }
            None => {}
        }
        for (number, active) in near.iter().enumerate() {
            let (axes, rules) = match &active.bound {
                // the same axes in all cells: then none is missed or counted twice along their sides
                Bound::Plane { normal, .. } => (across(normal), &self.on_surface[0]),
                Bound::Sphere { .. } => (best, &self.on_surface[1]),
            };
            let column = Column { actives: &near, low, high, axes, slack, nothing, rules };
            let bound = [active.part, active.number];
            column.surface(number, |position, area| self.made.surface.push(SurfacePoint { bound, position, area }));
        }
    }
}

/// The order of the axes with that last along which a plane is steepest.
fn across(normal: &[f64; 3]) -> [usize; 3] {
    let last = (0..3).max_by(|a, b| normal[*a].abs().total_cmp(&normal[*b].abs())).unwrap_or(2);
    [(last + 1) % 3, (last + 2) % 3, last]
}

/// Least cosine, in a box, between the normal of a sphere and the last axis, and between that of its circles at the ends of the last axis and
/// the middle axis. Planes have no such need.
fn worth(actives: &[Active], low: &[f64; 3], high: &[f64; 3], [first, middle, last]: [usize; 3]) -> f64 {
    let mut worth = 1.0f64;
    for active in actives {
        let Bound::Sphere { center, radius } = &active.bound else { continue };
        let [x, y, z] = [first, middle, last].map(|a| reach(center[a], low[a], high[a]));
        // what is left for the coordinate along the last axis of points of the sphere in the box
        let square = (z[0] * z[0]).max(radius * radius - x[1] * x[1] - y[1] * y[1]);
        worth = worth.min(square.max(0.0).sqrt() / radius);
        for end in [low[last], high[last]] {
            let square = radius * radius - (end - center[last]).powi(2);
            if square > x[0] * x[0] + y[0] * y[0] && square < x[1] * x[1] + y[1] * y[1] {
                let left = (y[0] * y[0]).max(square - x[1] * x[1]);
                worth = worth.min((left.max(0.0) / square).sqrt());
            }
        }
    }
    worth
}

/// Where a box is split best: at the end of a sphere, at its middle, or half-way.
fn split(actives: &[Active], low: &[f64; 3], high: &[f64; 3]) -> (usize, f64) {
    let length = |a: usize| high[a] - low[a];
    let spheres = actives.iter().filter_map(|active| match &active.bound {
        Bound::Sphere { center, radius } => Some((*center, *radius)),
        Bound::Plane { .. } => None,
    });
    for (center, radius) in spheres {
        let places = (0..3).flat_map(|a| [-radius, radius, 0.0].map(|by| (a, center[a] + by)));
        // a thin slice is no gain
        let found = places.filter(|&(a, place)| place > low[a] + 0.1 * length(a) && place < high[a] - 0.1 * length(a));
        if let Some(found) = found.min_by_key(|&(a, place)| usize::from(place == center[a])) {
            return found;
        }
    }
    let axis = (0..3).max_by(|a, b| length(*a).total_cmp(&length(*b))).unwrap_or(0);
    (axis, 0.5 * (low[axis] + high[axis]))
}
