//! Quadrature of a plane body of any shape in the cells of the grid: Gauss points in cells that it fills, and in cells that its edge cuts
//! points that integrate polynomials exactly over what is inside.
//!
//! The edge is a set of closed loops of smooth curves. Walking along a loop from cell to cell gives the piece of edge in each cell, and where
//! the body begins and ends on each grid line. What is inside a cut cell is a sum of cones: from an apex to all of its boundary, pieces of
//! edge and of grid lines. On a cone x = apex + r (b - apex) the integral is one over the boundary point b and one over r with weight r, both by
//! Gauss rules: exact for polynomials where the edge is straight, of the order of the rules where it is bent, and with positive weights
//! where the apex sees all of the boundary.

mod curve;
#[cfg(test)]
mod tests;

pub(crate) use curve::Curve;

use super::gauss::gauss_legendre;
use super::{GridAxis, Point};

/// How far beyond its cell, in cells, an edge that runs along a grid line may stray by round-off.
const ROUND_OFF: f64 = 1e-9;
/// Share of a cell below which there is nothing in it.
const NOTHING: f64 = 1e-14;

/// The walk along an edge did not lead back to where it began, or its end is not finite.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Lost {
    /// Where \[m\].
    pub(crate) position: [f64; 2],
}

/// A point of the edge.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct EdgePoint {
    /// Loop and curve in it.
    pub(crate) curve: [u32; 2],
    /// Parameter on the curve.
    pub(crate) parameter: f64,
    /// Share of the parameter interval: lengths are this times the derivative of the position.
    pub(crate) share: f64,
    /// Point of [`Point::cell`].
    pub(crate) cell: [i32; 2],
    /// \[m\]
    pub(crate) position: [f64; 2],
    /// Outward unit normal times length \[m\].
    pub(crate) area: [f64; 2],
}

/// A cell of a body.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Cell {
    pub(crate) index: [i32; 2],
    /// Part of it that is in the body.
    pub(crate) share: f64,
    /// Its points.
    pub(crate) points: std::ops::Range<usize>,
}

/// The quadrature of a body.
#[derive(Debug, Clone)]
pub(crate) struct CutQuadrature {
    pub(super) axes: [GridAxis; 2],
    /// Gauss points on \[0, 1\].
    rule: Vec<(f64, f64)>,
    /// Cell by cell, the last axis fastest.
    pub(crate) cells: Vec<Cell>,
    pub(crate) points: Vec<Point>,
    /// In the order of the walk, loop by loop.
    pub(crate) edge: Vec<EdgePoint>,
    /// Pieces of edge, with their points among `edge`.
    pieces: Vec<Piece>,
    /// By axis, where grid lines across it are crossed, sorted.
    crossings: [Vec<Crossing>; 2],
}

/// A piece of edge within a cell.
#[derive(Debug, Clone)]
struct Piece {
    cell: [i32; 2],
    points: std::ops::Range<usize>,
    /// Where it starts and ends \[m\].
    ends: [[f64; 2]; 2],
}

/// An edge that crosses a grid line.
#[derive(Debug, Clone, Copy)]
struct Crossing {
    /// Number of the line.
    line: i32,
    /// Cell along the line.
    cell: i32,
    /// Place along the line \[m\].
    place: f64,
    /// +1 where the body begins, -1 where it ends.
    step: i32,
}

/// A stretch of the walk on which both coordinates are monotone.
struct Stretch {
    curve: [u32; 2],
    range: [f64; 2],
}

/// A point of the boundary of what is inside a cell: position, and outward normal times length \[m\].
type Boundary = ([f64; 2], [f64; 2]);

impl CutQuadrature {
    pub(crate) fn new(axes: [GridAxis; 2]) -> Self {
        // three points make forces on cubic edges exact
        let rule = gauss_legendre(axes[0].gauss.max(axes[1].gauss).max(3));
        let (cells, points, edge, pieces) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
        Self { axes, rule, cells, points, edge, pieces, crossings: [Vec::new(), Vec::new()] }
    }

    /// Makes the points of a body within these loops, each with the body on its left. What lies beyond the grid is left out.
    pub(crate) fn prepare(&mut self, loops: &[Vec<Curve>]) -> Result<(), Lost> {
        self.cells.clear();
        self.points.clear();
        self.edge.clear();
        self.pieces.clear();
        self.crossings.iter_mut().for_each(Vec::clear);
        for (number, curves) in loops.iter().enumerate() {
            self.walk(number as u32, curves)?;
        }
        for crossings in &mut self.crossings {
            crossings.sort_by(|a, b| (a.line, a.cell).cmp(&(b.line, b.cell)).then(a.place.total_cmp(&b.place)));
        }
        self.fill();
        Ok(())
    }

    fn edge_of_cell(&self, axis: usize, cell: i32) -> f64 {
        self.axes[axis].origin + self.axes[axis].cell * f64::from(cell)
    }

    /// Walks along a loop.
    fn walk(&mut self, number: u32, curves: &[Curve]) -> Result<(), Lost> {
        let mut stretches = Vec::new();
        let mut turns = Vec::new();
        for (k, curve) in curves.iter().enumerate() {
            turns.clear();
            turns.extend([0.0, 1.0]);
            (0..2).for_each(|axis| curve.turns(axis, &mut turns));
            turns.sort_by(f64::total_cmp);
            turns.dedup();
            stretches.extend(turns.windows(2).map(|range| Stretch { curve: [number, k as u32], range: [range[0], range[1]] }));
        }
        let Some((start, middle, mut cell)) = self.start(&stretches, curves) else {
            return Err(Lost { position: curves.first().map_or([f64::NAN; 2], |curve| curve.at(0.5)[0]) });
        };
        // the stretch of the start is walked in two parts
        stretches.rotate_left(start);
        let last = Stretch { curve: stretches[0].curve, range: [stretches[0].range[0], middle] };
        stretches[0].range[0] = middle;
        stretches.push(last);
        // An edge that wavers about a grid line is in the cell it has been in before: the second walk knows where it comes from.
        let known = (self.edge.len(), self.pieces.len(), [self.crossings[0].len(), self.crossings[1].len()]);
        for _ in 0..2 {
            let first = cell;
            for stretch in &stretches {
                self.step(stretch, &curves[stretch.curve[1] as usize], &mut cell)?;
            }
            if cell == first {
                return Ok(());
            }
            self.edge.truncate(known.0);
            self.pieces.truncate(known.1);
            (0..2).for_each(|a| self.crossings[a].truncate(known.2[a]));
        }
        Err(Lost { position: curves[0].at(0.0)[0] })
    }

    /// Where it is clear in which cell a loop runs: the stretch, the parameter, and the cell.
    fn start(&self, stretches: &[Stretch], curves: &[Curve]) -> Option<(usize, f64, [i32; 2])> {
        let (mut best, mut found) = (0.0, None);
        // two places on each stretch: one may be a corner of cells
        for (i, share) in (0..stretches.len()).flat_map(|i| [(i, 0.37), (i, 0.59)]) {
            let stretch = &stretches[i];
            let middle = stretch.range[0] + share * (stretch.range[1] - stretch.range[0]);
            let [place, slope] = curves[stretch.curve[1] as usize].at(middle);
            let inward = [-slope[1], slope[0]];
            let length = slope[0].hypot(slope[1]);
            let (mut clear, mut cell) = (f64::INFINITY, [0; 2]);
            for axis in 0..2 {
                let at = (place[axis] - self.axes[axis].origin) / self.axes[axis].cell;
                let off = at - at.round();
                if off.abs() > ROUND_OFF {
                    cell[axis] = at.floor() as i32;
                    clear = clear.min(off.abs());
                } else {
                    // along a grid line: the cell is on the side of the body
                    cell[axis] = at.round() as i32 - i32::from(inward[axis] < 0.0);
                    clear = clear.min(0.5 * inward[axis].abs() / length);
                }
            }
            if clear > best && clear.is_finite() {
                (best, found) = (clear, Some((i, middle, cell)));
            }
        }
        found
    }

    /// Goes along a stretch, from cell to cell.
    fn step(&mut self, stretch: &Stretch, curve: &Curve, cell: &mut [i32; 2]) -> Result<(), Lost> {
        let [from, to] = stretch.range.map(|s| curve.at(s)[0]);
        if !to.iter().all(|x| x.is_finite()) {
            return Err(Lost { position: from });
        }
        // parameter, axis, and up or down
        let mut events: Vec<(f64, usize, i32)> = Vec::new();
        for axis in 0..2 {
            let slack = ROUND_OFF * self.axes[axis].cell;
            let direction = if to[axis] > from[axis] { 1 } else { -1 };
            let mut at = cell[axis];
            loop {
                let edge = self.edge_of_cell(axis, at + i32::from(direction > 0));
                if f64::from(direction) * (to[axis] - edge) <= slack {
                    break;
                }
                // round-off may have led across before
                let behind = f64::from(direction) * (from[axis] - edge) >= 0.0;
                events.push((if behind { stretch.range[0] } else { curve.crossing(axis, edge, stretch.range) }, axis, direction));
                at += direction;
            }
        }
        events.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut start = stretch.range[0];
        for (s, axis, direction) in events {
            self.add_piece(stretch, curve, [start, s], *cell);
            start = s;
            let across = 1 - axis;
            let place = curve.at(s)[0][across].clamp(self.edge_of_cell(across, cell[across]), self.edge_of_cell(across, cell[across] + 1));
            // with the body on the left, it is above where the edge leads to the right, and to the left where it leads up
            let step = if axis == 0 { direction } else { -direction };
            self.crossings[axis].push(Crossing { line: cell[axis] + i32::from(direction > 0), cell: cell[across], place, step });
            cell[axis] += direction;
        }
        self.add_piece(stretch, curve, [start, stretch.range[1]], *cell);
        Ok(())
    }

    fn add_piece(&mut self, stretch: &Stretch, curve: &Curve, [from, to]: [f64; 2], cell: [i32; 2]) {
        if to <= from {
            return;
        }
        let start = self.edge.len();
        for (at, weight) in &self.rule {
            let parameter = from + at * (to - from);
            let share = weight * (to - from);
            let [position, slope] = curve.at(parameter);
            let area = [share * slope[1], -share * slope[0]];
            self.edge.push(EdgePoint { curve: stretch.curve, parameter, share, cell, position, area });
        }
        self.pieces.push(Piece { cell, points: start..self.edge.len(), ends: [from, to].map(|s| curve.at(s)[0]) });
    }

    /// The parts of the edge of a cell that are in the body: on the grid line across an axis with a number, along a cell.
    fn inside(&self, axis: usize, line: i32, cell: i32) -> Vec<[f64; 2]> {
        let crossings = &self.crossings[axis];
        let first = crossings.partition_point(|c| c.line < line);
        let mut depth = 0;
        let mut parts = Vec::new();
        let mut low = self.edge_of_cell(1 - axis, cell);
        for crossing in crossings[first..].iter().take_while(|c| c.line == line && c.cell <= cell) {
            if crossing.cell == cell {
                if depth > 0 && crossing.place > low {
                    parts.push([low, crossing.place]);
                }
                low = crossing.place;
            }
            depth += crossing.step;
        }
        let high = self.edge_of_cell(1 - axis, cell + 1);
        if depth > 0 && high > low {
            parts.push([low, high]);
        }
        parts
    }

    /// Makes the points of all cells of the grid.
    fn fill(&mut self) {
        let mut pieces = std::mem::take(&mut self.pieces);
        pieces.sort_by_key(|piece| piece.cell);
        let is_cell = |cell: &[i32; 2]| (0..2).all(|a| cell[a] >= 0 && cell[a] < self.axes[a].cells as i32);
        let mut all: Vec<([i32; 2], &[Piece])> = pieces.chunk_by(|a, b| a.cell == b.cell).map(|own| (own[0].cell, own)).collect();
        let cut: Vec<[i32; 2]> = all.iter().map(|(cell, _)| *cell).collect();
        // a cell without edge is full where the body covers the grid line on its left
        for on_line in self.crossings[0].chunk_by(|a, b| a.line == b.line) {
            let mut depth = 0;
            for (here, next) in on_line.iter().zip(on_line[1..].iter().map(|c| c.cell).chain([i32::MIN])) {
                depth += here.step;
                for row in here.cell + 1..if depth > 0 { next } else { i32::MIN } {
                    if cut.binary_search(&[here.line, row]).is_err() {
                        all.push(([here.line, row], &[]));
                    }
                }
            }
        }
        all.retain(|(cell, _)| is_cell(cell));
        all.sort_by_key(|(cell, _)| *cell);
        for (index, own) in all {
            let start = self.points.len();
            if own.is_empty() {
                self.fill_cell(index);
            } else {
                self.fill_part(index, own);
            }
            let area: f64 = self.points[start..].iter().map(|point| point.weight).sum();
            let share = area / (self.axes[0].cell * self.axes[1].cell);
            if share > NOTHING {
                self.cells.push(Cell { index, share, points: start..self.points.len() });
            } else {
                self.points.truncate(start);
            }
        }
        self.pieces = pieces;
    }

    fn fill_cell(&mut self, index: [i32; 2]) {
        let [lines, rows] = [0, 1].map(|a| gauss_legendre(self.axes[a].gauss));
        let [x, y] = [0, 1].map(|a| self.edge_of_cell(a, index[a]));
        let [dx, dy] = [0, 1].map(|a| self.axes[a].cell);
        for (s, v) in &lines {
            for (t, w) in &rows {
                self.push([x + s * dx, y + t * dy], v * w * dx * dy, index);
            }
        }
    }

    fn push(&mut self, place: [f64; 2], weight: f64, index: [i32; 2]) {
        self.points.push(Point { cell: [index[0], index[1], 0], position: [place[0], place[1], 0.0], weight });
    }

    /// The part of a cell that is in the body, by cones. It may fall into several, each with an apex of its own.
    fn fill_part(&mut self, index: [i32; 2], own: &[Piece]) {
        let mut sides: Vec<Outline> = own
            .iter()
            .map(|piece| {
                let points = self.edge[piece.points.clone()].iter().map(|point| (point.position, point.area)).collect();
                Outline { ends: piece.ends, points, corner: false }
            })
            .collect();
        // against the clock: up on the right, to the left on top
        for (axis, upper) in [(0, false), (0, true), (1, false), (1, true)] {
            let at = self.edge_of_cell(axis, index[axis] + i32::from(upper));
            let place = |along: f64| if axis == 0 { [at, along] } else { [along, at] };
            for [from, to] in self.inside(axis, index[axis] + i32::from(upper), index[1 - axis]) {
                let out = if upper { to - from } else { from - to };
                let area = |weight: f64| if axis == 0 { [out * weight, 0.0] } else { [0.0, out * weight] };
                let points = self.rule.iter().map(|(s, weight)| (place(from + s * (to - from)), area(*weight))).collect();
                let ends = if upper == (axis == 0) { [place(from), place(to)] } else { [place(to), place(from)] };
                sides.push(Outline { ends, points, corner: true });
            }
        }
        let mut parts = chains(sides);
        // a hole belongs to what is around it
        if parts.iter().any(|part| twice_area(part) < 0.0) {
            parts = vec![parts.concat()];
        }
        for part in parts {
            self.fill_cones(index, &part);
        }
    }

    /// Points on the cones from an apex to an outline.
    fn fill_cones(&mut self, index: [i32; 2], outline: &[Outline]) {
        let boundary: Vec<&Boundary> = outline.iter().flat_map(|side| &side.points).collect();
        let mean = [0, 1].map(|a| boundary.iter().map(|(place, _)| place[a]).sum::<f64>() / boundary.len() as f64);
        // what the apex sees least of; a corner makes the cones to both of its sides empty
        let sight = |apex: &[f64; 2]| boundary.iter().map(|b| height(apex, b)).fold(f64::INFINITY, f64::min);
        let cell = self.axes[0].cell * self.axes[1].cell;
        let mut apex = (mean, sight(&mean));
        for corner in outline.iter().filter(|side| side.corner).flat_map(|side| side.ends) {
            let seen = sight(&corner);
            if seen > apex.1.min(-ROUND_OFF * cell) {
                apex = (corner, seen);
            }
        }
        let apex = apex.0;
        for b in boundary {
            let height = height(&apex, b);
            if height.abs() <= NOTHING * cell {
                continue;
            }
            for k in 0..self.rule.len() {
                let (r, weight) = self.rule[k];
                self.push([0, 1].map(|a| apex[a] + r * (b.0[a] - apex[a])), height * r * weight, index);
            }
        }
    }
}

/// A side of what is inside a cell, with the body on its left.
#[derive(Debug, Clone)]
struct Outline {
    ends: [[f64; 2]; 2],
    points: Vec<Boundary>,
    /// Whether it is part of a grid line.
    corner: bool,
}

/// Distance of a side from an apex times its length.
fn height(apex: &[f64; 2], (place, area): &Boundary) -> f64 {
    (place[0] - apex[0]) * area[0] + (place[1] - apex[1]) * area[1]
}

fn twice_area(outline: &[Outline]) -> f64 {
    let apex = outline[0].ends[0];
    outline.iter().flat_map(|side| &side.points).map(|b| height(&apex, b)).sum()
}

/// Puts sides one after the other into closed outlines: each goes on with the one that starts where it ends, but for round-off.
fn chains(mut sides: Vec<Outline>) -> Vec<Vec<Outline>> {
    let distance = |a: &[f64; 2], b: &[f64; 2]| (a[0] - b[0]).abs() + (a[1] - b[1]).abs();
    let mut chains = Vec::new();
    while let Some(first) = sides.pop() {
        let mut chain = vec![first];
        loop {
            let (start, end) = (chain[0].ends[0], chain[chain.len() - 1].ends[1]);
            let next = (0..sides.len()).min_by(|a, b| distance(&sides[*a].ends[0], &end).total_cmp(&distance(&sides[*b].ends[0], &end)));
            match next {
                Some(next) if distance(&sides[next].ends[0], &end) < distance(&start, &end) => chain.push(sides.swap_remove(next)),
                _ => break,
            }
        }
        chains.push(chain);
    }
    chains
}
