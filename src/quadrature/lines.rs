//! Quadrature of a body whose particles form a lattice, with splines along its lines (Tielen 2016, section 7.2, in up to three dimensions).
//!
//! Axis by axis: along the first axis every line of the lattice is a graph over x. At each Gauss point in x all lines are evaluated, which
//! gives the lattice of the section there, of one dimension less; the same goes on in y and z.
//!
//! A body's end counts as upright: it is the mean over its lines. That keeps the volume of a body with inclined or bent ends but moves
//! parts of it: integrals are then wrong in proportion to the inclination, however fine the grid (a unit square turned by 0.02 rad: 0.2 %
//! of the integral of an exponential).

#[cfg(test)]
mod tests;

use super::gauss::gauss_legendre;
use super::spline::{Bundle, NotIncreasing, Place, factor};
use super::{GridAxis, Point};
use nalgebra::Matrix3;
use std::ops::Range;

/// Part of a half cell below which the body does not count as in it: round-off of the body's end.
const SLIVER: f64 = 1e-12;

/// A line of particles that turns back (or a position that is not finite): the lattice is folded, or turned by 90 degrees and more.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Folded {
    /// The axis along which the line should lead.
    pub(crate) axis: usize,
    /// Place in the lattice of the particle that does not lie above its neighbour below. Where a section between particles is folded,
    /// the nearest one below.
    pub(crate) index: [usize; 3],
}

/// What turns half the spacing of the particles of a lattice into their half-lengths, from their deformation gradient: the stretch of
/// an axis while the position along the axes before it is held, which is where the sections are taken. These are the pivots of the
/// elimination of F: its diagonal where it is triangular, and det F is their product.
pub(crate) fn stretches(deformation: &Matrix3<f64>) -> [f64; 3] {
    let f = deformation;
    let minor = f[(0, 0)] * f[(1, 1)] - f[(0, 1)] * f[(1, 0)];
    [f[(0, 0)], minor / f[(0, 0)], f.determinant() / minor]
}

/// Position and half-length by axis: x, half-length along x, y, ...; 0 and 1 for axes beyond the dimension.
type Geometry = [f64; 6];

/// Memory for the fields on their way from the particles to the points; kept by the caller, so that no step allocates.
#[derive(Debug, Clone)]
pub(crate) struct Scratch<const K: usize> {
    now: Vec<[f64; K]>,
    next: Vec<[f64; K]>,
    bends: Vec<[f64; K]>,
}

impl<const K: usize> Default for Scratch<K> {
    fn default() -> Self {
        Self { now: Vec::new(), next: Vec::new(), bends: Vec::new() }
    }
}

/// The points of a body, and how fields at its particles lead to values there.
#[derive(Debug, Clone)]
pub(crate) struct LineQuadrature {
    counts: [usize; 3],
    stages: Vec<Stage>,
    points: Vec<Point>,
    /// Point of the last stage by place among `points`.
    order: Vec<u32>,
    scratch: Scratch<6>,
}

impl LineQuadrature {
    /// For a lattice of `counts` particles by axis, stored with the last axis fastest; axes beyond those of the grid have 1. `ends` are weights of
    /// the particles of a row, from its lower and upper end on, that give the place where the body ends.
    pub(crate) fn new(counts: [usize; 3], ends: &[[Vec<f64>; 2]; 3], axes: &[GridAxis]) -> Self {
        debug_assert!(!axes.is_empty() && counts[axes.len()..].iter().all(|&c| c == 1) && counts.iter().all(|&c| c > 0));
        let stage = |a: usize| Stage::new(a, axes[a], counts[a], counts[a + 1..].iter().product(), ends[a].clone());
        let stages = (0..axes.len()).map(stage).collect();
        Self { counts, stages, points: Vec::new(), order: Vec::new(), scratch: Scratch::default() }
    }

    /// The grid, axis by axis.
    pub(crate) fn axes(&self) -> Vec<GridAxis> {
        self.stages.iter().map(|stage| stage.grid).collect()
    }

    /// The points of the last [`prepare`](Self::prepare), cell by cell with the last axis fastest.
    pub(crate) fn points(&self) -> &[Point] {
        &self.points
    }

    /// Makes the points for particles at `position` with `half_length` (above 0, see [`stretches`]), by axis \[m\] and in the order of
    /// the lattice. What lies beyond the grid is left out. After an error there are no points.
    pub(crate) fn prepare(&mut self, position: &[&[f64]], half_length: &[&[f64]]) -> Result<(), Folded> {
        let dimension = self.stages.len();
        let particle = |p: usize| {
            let mut row = [0.0, 1.0, 0.0, 1.0, 0.0, 1.0];
            for a in 0..dimension {
                (row[2 * a], row[2 * a + 1]) = (position[a][p], half_length[a][p]);
            }
            row
        };
        self.points.clear();
        self.order.clear();
        self.scratch.now.clear();
        self.scratch.now.extend((0..self.counts.iter().product()).map(particle));
        let body = [Point { cell: [0; 3], position: [0.0; 3], weight: 1.0 }];
        for axis in 0..dimension {
            let (before, rest) = self.stages.split_at_mut(axis);
            let stage = &mut rest[0];
            let sections = before.last().map_or(&body[..], |s| &s.points);
            if let Err((section, fold)) = stage.prepare(sections, &self.scratch.now) {
                let folded = self.folded(axis, section, fold);
                self.stages.iter_mut().for_each(|stage| stage.starts.clear());
                return Err(folded);
            }
            if axis + 1 < dimension {
                stage.carry(&mut self.scratch);
            }
        }
        self.sort();
        Ok(())
    }

    /// Values at the points of `fields` at the particles, in the order of the lattice.
    pub(crate) fn evaluate<const K: usize>(&self, fields: [&[f64]; K], scratch: &mut Scratch<K>, values: &mut Vec<[f64; K]>) {
        scratch.now.clear();
        scratch.now.extend((0..self.counts.iter().product()).map(|p| fields.map(|field| field[p])));
        for stage in &self.stages {
            stage.carry(scratch);
        }
        values.clear();
        values.extend(self.order.iter().map(|&p| scratch.now[p as usize]));
    }

    /// Puts the points of the last stage in the order of the cells.
    fn sort(&mut self) {
        let Some(last) = self.stages.last() else { return };
        let made = |p: u32| &last.points[p as usize];
        self.order.extend(0..last.points.len() as u32);
        // points in one layer of cells across the first axis already stand together: short sorts
        for layer in self.order.chunk_by_mut(|&p, &q| made(p).cell[0] == made(q).cell[0]) {
            layer.sort_unstable_by_key(|&p| (made(p).cell, p));
        }
        self.points.extend(self.order.iter().map(|&p| *made(p)));
    }

    /// Follows a fold in a section back to the lattice: line `n` of a stage is knot `n` of the sections it makes.
    fn folded(&self, axis: usize, mut section: usize, fold: NotIncreasing) -> Folded {
        let mut knot = fold.knot * self.stages[axis].lines + fold.line;
        for stage in self.stages[..axis].iter().rev() {
            knot = stage.places[section * stage.lines + knot].lower as usize;
            section = stage.starts.partition_point(|&start| start <= section) - 1;
        }
        let [_, n1, n2] = self.counts;
        Folded { axis, index: [knot / (n1 * n2), knot / n2 % n1, knot % n2] }
    }
}

/// The lines along one axis, in every section made by the axes before it.
#[derive(Debug, Clone)]
struct Stage {
    axis: usize,
    grid: GridAxis,
    /// Gauss points and weights on \[0, 1\].
    rule: Vec<(f64, f64)>,
    /// Particles on a line.
    knots: usize,
    /// Lines of a section.
    lines: usize,
    /// Weights of the particles of a line next to its lower and upper end, whose sum is the place of the end.
    ends: [Vec<f64>; 2],
    /// By section, knot and line \[m\].
    abscissae: Vec<f64>,
    /// As [`factor`] gives them, in the same order.
    inverse_pivots: Vec<f64>,
    /// First point of each section, and the end of the last.
    starts: Vec<usize>,
    /// Points, section by section; axes to come are still 0.
    points: Vec<Point>,
    /// Place of each point on each line of its section.
    places: Vec<Place>,
}

impl Stage {
    fn new(axis: usize, grid: GridAxis, knots: usize, lines: usize, ends: [Vec<f64>; 2]) -> Self {
        let (abscissae, inverse_pivots, starts) = (Vec::new(), Vec::new(), Vec::new());
        let rule = gauss_legendre(grid.gauss);
        Self { axis, grid, rule, knots, lines, ends, abscissae, inverse_pivots, starts, points: Vec::new(), places: Vec::new() }
    }

    /// Factors the splines and places the points of all `sections`. An error comes with its section.
    fn prepare(&mut self, sections: &[Point], geometry: &[Geometry]) -> Result<(), (usize, NotIncreasing)> {
        self.abscissae.clear();
        self.abscissae.extend(geometry.iter().map(|row| row[2 * self.axis]));
        self.inverse_pivots.clear();
        self.inverse_pivots.resize(geometry.len(), 0.0);
        self.points.clear();
        self.places.clear();
        self.starts.clear();
        self.starts.push(0);
        let size = self.knots * self.lines;
        for (s, section) in sections.iter().enumerate() {
            let range = s * size..(s + 1) * size;
            factor(self.lines, &self.abscissae[range.clone()], &mut self.inverse_pivots[range.clone()]).map_err(|fold| (s, fold))?;
            self.add_points(section, &geometry[range.clone()]);
            self.add_places(range);
            self.starts.push(self.points.len());
        }
        Ok(())
    }

    /// The points of a section: a Gauss rule on the part of every half cell that the body covers, so that no point lies outside it
    /// (Tielen 2016, section 7.2, figures 7.3 and 7.4).
    fn add_points(&mut self, section: &Point, geometry: &[Geometry]) {
        let body = [self.end(geometry, false), self.end(geometry, true)];
        let half = 0.5 * self.grid.cell;
        let edge = |i: usize| self.grid.origin + i as f64 * half;
        // from negative numbers the cast gives 0
        let index = |x: f64| ((x - self.grid.origin) / half).floor() as usize;
        for i in index(body[0])..=index(body[1]).min((2 * self.grid.cells).saturating_sub(1)) {
            let (lower, upper) = (edge(i).max(body[0]), edge(i + 1).min(body[1]));
            let length = upper - lower;
            if length > SLIVER * half {
                self.points.extend(self.rule.iter().map(|(at, share)| {
                    let mut point = *section;
                    point.cell[self.axis] = (i / 2) as i32;
                    point.position[self.axis] = lower + at * length;
                    point.weight *= share * length;
                    point
                }));
            }
        }
        debug_assert!(self.points.len() <= u32::MAX as usize);
    }

    /// Where the body ends below or above the particles of a section: the mean over the lines, by the area each covers. On a line, what the
    /// places of the particles next to the end lead to.
    fn end(&self, geometry: &[Geometry], upper: bool) -> f64 {
        let (mut sum, mut area) = (0.0, 0.0);
        for line in 0..self.lines {
            let row = |k: usize| &geometry[if upper { self.knots - 1 - k } else { k } * self.lines + line];
            let share: f64 = (self.axis + 1..3).map(|a| row(0)[2 * a + 1]).product();
            let side = if upper { 1.0 } else { -1.0 };
            // one particle leads nowhere
            let beyond = if self.knots == 1 { side * row(0)[2 * self.axis + 1] } else { 0.0 };
            let place: f64 =
                beyond + self.ends[usize::from(upper)].iter().enumerate().map(|(k, weight)| weight * row(k)[2 * self.axis]).sum::<f64>();
            sum += share * place;
            area += share;
        }
        sum / area
    }

    /// The places of the points of a section, which is the last so far.
    fn add_places(&mut self, section: Range<usize>) {
        let (lines, first) = (self.lines, self.places.len() / self.lines);
        let bundle = Bundle::new(lines, &self.abscissae[section.clone()], &self.inverse_pivots[section]);
        for (p, point) in self.points.iter().enumerate().skip(first) {
            for line in 0..lines {
                // points come sorted: the search goes on from the point before
                let near = if p == first { 0 } else { self.places[(p - 1) * lines + line].lower as usize / lines };
                self.places.push(bundle.place(line, point.position[self.axis], near));
            }
        }
    }

    /// Takes fields from the lattices of all sections to their points.
    fn carry<const K: usize>(&self, fields: &mut Scratch<K>) {
        let size = self.knots * self.lines;
        fields.bends.resize(size, [0.0; K]);
        fields.next.clear();
        for (s, range) in self.starts.windows(2).enumerate() {
            let section = s * size..(s + 1) * size;
            let values = &fields.now[section.clone()];
            let bundle = Bundle::new(self.lines, &self.abscissae[section.clone()], &self.inverse_pivots[section]);
            bundle.bend(values, &mut fields.bends);
            let places = &self.places[range[0] * self.lines..range[1] * self.lines];
            fields.next.extend(places.iter().map(|place| bundle.value(place, values, &fields.bends)));
        }
        std::mem::swap(&mut fields.now, &mut fields.next);
    }
}
