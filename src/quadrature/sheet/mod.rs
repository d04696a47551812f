//! Quadrature of a plane body whose particles keep their neighbours, however it is turned, bent and placed in the grid.
//!
//! The body is the image of a square, in which its particles stand in rows and columns that never change (of a ring: of a circle's worth of
//! columns, joined). Splines through the particles give position and fields as functions on the square. The image of its sides is the
//! edge of the body, whose cells [`CutQuadrature`] fills with points; the place of a point in the square comes from Newton's method.

mod interpolation;
#[cfg(test)]
mod tests;

use interpolation::{Interpolation, Place};

use super::cut::{Curve, CutQuadrature, EdgePoint, Lost};
use super::{GridAxis, Point};

/// Steps after which Newton's method has failed.
const MOST_STEPS: usize = 40;
/// Step, in distances of sites, after which the next would be round-off.
const LAST_STEP: f64 = 1e-7;

/// Why a body could not be filled with points.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Trouble {
    /// Its edge cannot be followed.
    Edge(Lost),
    /// It is folded, or not finite, at a particle or a point \[m\].
    Folded([f64; 2]),
}

/// A part of a side of the square that is one cubic.
#[derive(Debug, Clone, Copy)]
struct Part {
    /// Axis across the side, and whether it is its upper one.
    side: (usize, bool),
    /// Places along the side where it starts and ends.
    range: [f64; 2],
}

/// A point of the edge on the square.
#[derive(Debug, Clone, Copy)]
pub(crate) struct SidePoint {
    /// Axis across the side, and whether it is its upper one.
    pub(crate) side: (usize, bool),
    /// Place along the side.
    pub(crate) along: f64,
    /// Length along the side that it stands for.
    pub(crate) share: f64,
}

/// The points of a body, and how fields at its particles lead to values there.
#[derive(Debug, Clone)]
pub(crate) struct SheetQuadrature {
    lines: [Interpolation; 2],
    cut: CutQuadrature,
    /// Of the position \[m\].
    coefficients: Vec<[f64; 2]>,
    /// Of each point.
    places: Vec<[Place; 2]>,
    /// Of each point of the edge.
    edge_places: Vec<[Place; 2]>,
    sides: Vec<SidePoint>,
    /// By cell of the box around the particles, one of them.
    near: Vec<u32>,
    /// The functions at the sites, by axis.
    sites: [Vec<Place>; 2],
}

impl SheetQuadrature {
    /// For particles at `sites` of the square, by axis; around a ring they are even.
    pub(crate) fn new(sites: [&[f64]; 2], joined: bool, axes: [GridAxis; 2]) -> Self {
        let second = if joined { Interpolation::Periodic(sites[1].len()) } else { Interpolation::open(sites[1]) };
        let lines = [Interpolation::open(sites[0]), second];
        let sites = [0, 1].map(|a| sites[a].iter().map(|s| lines[a].at(*s)).collect());
        let (coefficients, places, edge_places) = (Vec::new(), Vec::new(), Vec::new());
        Self { lines, cut: CutQuadrature::new(axes), coefficients, places, edge_places, sides: Vec::new(), near: Vec::new(), sites }
    }

    /// The points, cell by cell.
    pub(crate) fn points(&self) -> &[Point] {
        &self.cut.points
    }

    /// The points of the edge.
    pub(crate) fn edge(&self) -> &[EdgePoint] {
        &self.cut.edge
    }

    /// Where the points of the edge are on the square.
    pub(crate) fn sides(&self) -> &[SidePoint] {
        &self.sides
    }

    /// Makes the points for particles at `position` \[m\], row by row.
    pub(crate) fn prepare(&mut self, position: [&[f64]; 2]) -> Result<(), Trouble> {
        let mut coefficients = Vec::new();
        self.fit(position, &mut coefficients);
        self.coefficients = coefficients.as_chunks::<2>().0.to_vec();
        for a in &self.sites[0] {
            for b in &self.sites[1] {
                let (x, slope) = self.position(&[*a, *b]);
                if determinant(&slope).is_none() {
                    return Err(Trouble::Folded(x));
                }
            }
        }
        let parts = self.parts();
        let loops: Vec<Vec<Curve>> = parts.iter().map(|parts| parts.iter().map(|part| self.curve(part)).collect()).collect();
        self.cut.prepare(&loops).map_err(Trouble::Edge)?;
        let side_point = |point: &EdgePoint| {
            let part = &parts[point.curve[0] as usize][point.curve[1] as usize];
            let [from, to] = part.range;
            SidePoint { side: part.side, along: from + point.parameter * (to - from), share: point.share * (to - from).abs() }
        };
        self.sides = self.cut.edge.iter().map(side_point).collect();
        self.edge_places = self.sides.iter().map(|point| self.on_side(point.side, point.along)).collect();
        self.invert(position)
    }

    /// The sides that are edges, as loops with the body on the left.
    fn parts(&self) -> Vec<Vec<Part>> {
        let along = |side: (usize, bool), forward: bool| {
            let breaks = self.lines[1 - side.0].breaks();
            let mut parts: Vec<Part> = breaks.windows(2).map(|range| Part { side, range: [range[0], range[1]] }).collect();
            if !forward {
                parts.reverse();
                parts.iter_mut().for_each(|part| part.range.reverse());
            }
            parts
        };
        if self.lines[1].is_periodic() {
            vec![along((0, true), true), along((0, false), false)]
        } else {
            vec![[along((1, false), true), along((0, true), true), along((1, true), false), along((0, false), false)].concat()]
        }
    }

    fn on_side(&self, (axis, upper): (usize, bool), along: f64) -> [Place; 2] {
        let mut at = [along; 2];
        at[axis] = f64::from(u8::from(upper));
        [self.lines[0].at(at[0]), self.lines[1].at(at[1])]
    }

    /// The cubic along a part: the one with its places and slopes at the ends.
    fn curve(&self, part: &Part) -> Curve {
        let [from, to] = part.range;
        let length = to - from;
        // within the part: at a break between cubics place and slope are the same on both sides
        let ends = part.range.map(|along| {
            let (place, slopes) = self.position(&self.on_side(part.side, along));
            (place, [0, 1].map(|k| length * slopes[k][1 - part.side.0]))
        });
        let mut cubic = [[0.0; 2]; 4];
        for k in 0..2 {
            let (x0, x1, d0, d1) = (ends[0].0[k], ends[1].0[k], ends[0].1[k], ends[1].1[k]);
            let coefficients = [x0, d0, 3.0 * (x1 - x0) - 2.0 * d0 - d1, 2.0 * (x0 - x1) + d0 + d1];
            (0..4).for_each(|m| cubic[m][k] = coefficients[m]);
        }
        Curve::Cubic(cubic)
    }

    /// Position at a place of the square, and its derivatives: \[component\]\[axis\] \[m\].
    fn position(&self, [a, b]: &[Place; 2]) -> ([f64; 2], [[f64; 2]; 2]) {
        let (mut x, mut slope) = ([0.0; 2], [[0.0; 2]; 2]);
        self.each(&[*a, *b], |index, i, j| {
            let c = self.coefficients[index];
            for k in 0..2 {
                x[k] += a.weight[i] * b.weight[j] * c[k];
                slope[k][0] += a.slope[i] * b.weight[j] * c[k];
                slope[k][1] += a.weight[i] * b.slope[j] * c[k];
            }
        });
        (x, slope)
    }

    /// Calls `f(coefficient, i, j)` for the functions that are not zero at a place.
    #[inline(always)]
    fn each(&self, [a, b]: &[Place; 2], mut f: impl FnMut(usize, usize, usize)) {
        let columns = self.lines[1].len();
        for i in 0..self.lines[0].width() {
            let row = (a.first as usize + i) * columns;
            for j in 0..self.lines[1].width() {
                // only the second axis may be joined
                let column = b.first as usize + j;
                f(row + if column >= columns { column % columns } else { column }, i, j);
            }
        }
    }

    /// Finds the places of the points on the square.
    fn invert(&mut self, position: [&[f64]; 2]) -> Result<(), Trouble> {
        let counts = [self.lines[0].len(), self.lines[1].len()];
        let axes = self.cut.axes;
        let cell_of = |x: f64, a: usize| ((x - axes[a].origin) / axes[a].cell).floor() as i32;
        let bounds: [[i32; 2]; 2] = [0, 1].map(|a| {
            let (low, high) = position[a].iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), x| (l.min(*x), h.max(*x)));
            [cell_of(low, a), cell_of(high, a)]
        });
        let extent = bounds.map(|[low, high]| (high - low + 1) as usize);
        let mut near = std::mem::take(&mut self.near);
        near.clear();
        near.resize(extent[0] * extent[1], u32::MAX);
        for p in 0..position[0].len() {
            let at = [0, 1].map(|a| (cell_of(position[a][p], a) - bounds[a][0]) as usize);
            near[at[0] * extent[1] + at[1]] = p as u32;
        }
        // a particle of the cell, or of one beside it
        let particle = |cell: [i32; 2]| {
            let around = [[0, 0], [-1, 0], [1, 0], [0, -1], [0, 1], [-1, -1], [1, 1], [-1, 1], [1, -1]];
            around.iter().find_map(|step| {
                let at = [0, 1].map(|a| cell[a] + step[a] - bounds[a][0]);
                let inside = (0..2).all(|a| at[a] >= 0 && at[a] < extent[a] as i32);
                Some(near[inside.then(|| at[0] as usize * extent[1] + at[1] as usize)?]).filter(|p| *p != u32::MAX)
            })
        };
        let mut places = std::mem::take(&mut self.places);
        places.clear();
        let mut at = [0.5; 2];
        for cell in &self.cut.cells {
            if let Some(p) = particle([cell.index[0], cell.index[1]]) {
                // even sites are near enough to start from
                at = [(p as usize / counts[1]) as f64, (p as usize % counts[1]) as f64];
                (0..2).for_each(|a| at[a] = (at[a] + 0.5) / counts[a] as f64);
            }
            for point in &self.cut.points[cell.points.clone()] {
                let target = [point.position[0], point.position[1]];
                at = self.find(target, at).ok_or(Trouble::Folded(target))?;
                places.push([self.lines[0].at(at[0]), self.lines[1].at(at[1])]);
            }
        }
        (self.near, self.places) = (near, places);
        Ok(())
    }

    /// The place on the square that is at `target`, by Newton's method from a place near it.
    fn find(&self, target: [f64; 2], mut at: [f64; 2]) -> Option<[f64; 2]> {
        let spacing = [0, 1].map(|a| 1.0 / self.lines[a].len() as f64);
        for _ in 0..MOST_STEPS {
            let (x, slope) = self.position(&[self.lines[0].at(at[0]), self.lines[1].at(at[1])]);
            let miss = [target[0] - x[0], target[1] - x[1]];
            let det = determinant(&slope)?;
            let mut by = [(miss[0] * slope[1][1] - miss[1] * slope[0][1]) / det, (miss[1] * slope[0][0] - miss[0] * slope[1][0]) / det];
            let size = (by[0] / spacing[0]).abs().max((by[1] / spacing[1]).abs());
            // no further than the map is alike
            let shorten = (2.0 / size).min(1.0);
            for a in 0..2 {
                by[a] *= shorten;
                at[a] += by[a];
                if !self.lines[a].is_periodic() {
                    at[a] = at[a].clamp(-spacing[a], 1.0 + spacing[a]);
                }
            }
            if size < LAST_STEP {
                return Some(at);
            }
        }
        None
    }

    /// Coefficients of `fields` at the particles, the fields of a function side by side.
    pub(crate) fn fit<const K: usize>(&self, fields: [&[f64]; K], coefficients: &mut Vec<f64>) {
        let columns = self.lines[1].len();
        coefficients.clear();
        coefficients.extend((0..fields[0].len()).flat_map(|p| fields.map(|field| field[p])));
        for row in coefficients.chunks_mut(columns * K) {
            self.lines[1].solve(row, K);
        }
        self.lines[0].solve(coefficients, columns * K);
    }

    /// Values at the points of fields with these coefficients.
    pub(crate) fn at_points<const K: usize>(&self, coefficients: &[f64], values: &mut Vec<[f64; K]>) {
        self.at(&self.places, coefficients, values);
    }

    /// Values at the points of the edge.
    pub(crate) fn at_edge<const K: usize>(&self, coefficients: &[f64], values: &mut Vec<[f64; K]>) {
        self.at(&self.edge_places, coefficients, values);
    }

    fn at<const K: usize>(&self, places: &[[Place; 2]], coefficients: &[f64], values: &mut Vec<[f64; K]>) {
        let coefficients = coefficients.as_chunks::<K>().0;
        values.clear();
        values.extend(places.iter().map(|place| {
            let mut sum = [0.0; K];
            self.each(place, |index, i, j| {
                let weight = place[0].weight[i] * place[1].weight[j];
                (0..K).for_each(|k| sum[k] += weight * coefficients[index][k]);
            });
            sum
        }));
    }
}

/// Determinant of the map, where it is not turned inside out (or not a number).
fn determinant(slope: &[[f64; 2]; 2]) -> Option<f64> {
    let det = slope[0][0] * slope[1][1] - slope[0][1] * slope[1][0];
    (det > 0.0).then_some(det)
}
