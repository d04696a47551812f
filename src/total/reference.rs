//! The grid of a body at time 0: shape functions at its particles, computed once, and the sums over them.

use super::ties::Ties;
use crate::basis::Axis;
use crate::basis::{BATCH, Batch, Places, Stencils, Third};
use crate::implicit::Matrix;
use crate::model::Quadrilateral;

/// Most functions along an axis that are not zero in a cell.
pub(super) const MOST: usize = 6;

/// A vector for each node.
pub(crate) type Vectors = Vec<[f64; 3]>;

/// The functions along one axis that are not zero at one place, and their slopes.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Line {
    pub(super) first: usize,
    pub(super) weight: [f64; MOST],
    /// \[1/m\]
    pub(super) slope: [f64; MOST],
}

impl Line {
    /// Along an axis that the scene does not have.
    const NONE: Self = Self { first: 0, weight: [1.0, 0.0, 0.0, 0.0, 0.0, 0.0], slope: [0.0; MOST] };

    pub(super) fn at(axis: &Axis, x: f64) -> Self {
        fn of<const W: usize>(axis: &Axis, x: f64) -> Line {
            let places = Places { position: [[x; BATCH]], half: [Batch::default()] };
            let stencils = Stencils::<W>::at::<1>(std::slice::from_ref(axis), &places, Third::Nothing);
            let mut line = Line { first: stencils.first(0)[2] as usize, weight: [0.0; MOST], slope: [0.0; MOST] };
            for k in 0..W {
                (line.weight[k], line.slope[k]) = (stencils.weight[2][k][0], stencils.slope[2][k][0]);
            }
            line
        }
        match axis.width() {
            2 => of::<2>(axis, x),
            3 => of::<3>(axis, x),
            4 => of::<4>(axis, x),
            5 => of::<5>(axis, x),
            _ => of::<6>(axis, x),
        }
    }
}

/// A point of a body with its functions.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Point {
    lines: [Line; 3],
    /// Inverse of the derivative of the place in space by that in the grid, where the grid is bent: it turns slopes.
    turn: Option<[[f64; 2]; 2]>,
}

impl Point {
    /// A slope in space from that in the grid \[1/m\].
    #[inline(always)]
    fn slope<const D: usize>(&self, g: [f64; 3]) -> [f64; D] {
        let g = match &self.turn {
            None => g,
            Some([x, y]) => [g[0] * x[0] + g[1] * y[0], g[0] * x[1] + g[1] * y[1], 0.0],
        };
        std::array::from_fn(|k| g[k])
    }

    /// First function along each axis: points with the same share all nodes.
    pub(super) fn cell(&self) -> [usize; 3] {
        std::array::from_fn(|a| self.lines[a].first)
    }
}

/// The grid of a body and its functions at the particles.
///
/// Particles share what they have in common: where they stand in rows and columns, each coordinate is kept once.
#[derive(Debug)]
pub(crate) struct Reference {
    pub(super) axes: Vec<Axis>,
    /// Functions along each axis; 1 along those that the scene does not have.
    pub(super) counts: [usize; 3],
    /// Place of its first node among those of all bodies.
    pub(super) start: usize,
    lines: [Vec<Line>; 3],
    line_of: Vec<[u32; 3]>,
    map: Option<Quadrilateral>,
    /// Of each particle of a bent grid, as in [`Point`].
    turns: Vec<[[f64; 2]; 2]>,
    /// Which functions follow others; where the body cuts cells.
    ties: Option<Ties>,
}

impl Reference {
    /// `places` are those of the particles \[m\].
    pub(super) fn new(axes: &[Axis], map: Option<&Quadrilateral>, start: usize, places: impl Iterator<Item = [f64; 3]>) -> Self {
        let mut counts = [1; 3];
        for (count, axis) in counts.iter_mut().zip(axes) {
            *count = axis.functions() as usize;
        }
        let mut known: [std::collections::HashMap<u64, u32>; 3] = Default::default();
        let mut lines: [Vec<Line>; 3] = Default::default();
        let (mut line_of, mut turns) = (Vec::new(), Vec::new());
        for mut place in places {
            if let Some(map) = map {
                place = map.inverse(place);
                turns.push(turn(map, place));
                // the same along a line, up to the round-off of the inverse
                for (x, axis) in place.iter_mut().zip(axes) {
                    let fine = axis.cell_size() * 2f64.powi(-36);
                    *x = (*x / fine).round() * fine;
                }
            }
            line_of.push(std::array::from_fn(|a| {
                *known[a].entry(place[a].to_bits()).or_insert_with(|| {
                    lines[a].push(axes.get(a).map_or(Line::NONE, |axis| Line::at(axis, place[a])));
                    lines[a].len() as u32 - 1
                })
            }));
        }
        Self { axes: axes.to_vec(), counts, start, lines, line_of, map: map.cloned(), turns, ties: None }
    }

    /// Of a body with these points of its edge; `volumes` are those of the particles. Where `extends` is false no function follows others.
    pub(super) fn cut(mut self, volumes: &[f64], edge: impl Iterator<Item = [f64; 3]>, extends: bool) -> Self {
        self.ties = Some(Ties::new(&self, volumes, edge, extends));
        self
    }

    pub(super) fn ties(&self) -> Option<&Ties> {
        self.ties.as_ref()
    }

    /// Whether node number `i` of the grid stands for itself.
    pub(super) fn is_own(&self, i: usize) -> bool {
        self.ties.as_ref().is_none_or(|ties| ties.is_own(i))
    }

    /// Nodes of this grid that follow others hand on the forces that they got.
    pub(super) fn fold(&self, force: &mut [[f64; 3]]) {
        if let Some(ties) = &self.ties {
            ties.fold(&mut force[self.start..self.start + self.len()]);
        }
    }

    /// Nodes of this grid that follow others go where those lead.
    pub(super) fn spread(&self, field: &mut [[f64; 3]]) {
        if let Some(ties) = &self.ties {
            ties.spread(&mut field[self.start..self.start + self.len()]);
        }
    }

    /// Adds a dense block over `d` components of nodes of a cell to a matrix.
    pub(super) fn add(&self, matrix: &mut Matrix, nodes: &[u32], d: usize, block: &[f64]) {
        match &self.ties {
            Some(ties) => ties.add(matrix, nodes, self.start as u32, d, block),
            None => matrix.add(nodes, block),
        }
    }

    /// The functions along an axis at the coordinates of the particles, in the order in which these first occur.
    pub(super) fn lines(&self, axis: usize) -> &[Line] {
        &self.lines[axis]
    }

    /// Whether particle number `p` has these places among the lines of the axes.
    pub(super) fn stands_at(&self, p: usize, place: [usize; 3]) -> bool {
        (0..3).all(|a| self.line_of[p][a] as usize == place[a])
    }

    /// Number of nodes.
    pub(super) fn len(&self) -> usize {
        self.counts.iter().product()
    }

    /// The functions at any place of the body.
    pub(super) fn point(&self, place: [f64; 3]) -> Point {
        let at = self.map.as_ref().map_or(place, |map| map.inverse(place));
        Point {
            lines: std::array::from_fn(|a| self.axes.get(a).map_or(Line::NONE, |axis| Line::at(axis, at[a]))),
            turn: self.map.as_ref().map(|map| turn(map, at)),
        }
    }

    /// Functions along each axis that are not zero in a cell.
    pub(super) fn widths(&self) -> [usize; 3] {
        std::array::from_fn(|a| self.axes.get(a).map_or(1, Axis::width))
    }

    /// Numbers of the functions of a cell, given its first one along each axis: ascending.
    pub(super) fn functions(&self, [i, j, k]: [usize; 3]) -> impl Iterator<Item = usize> + use<> {
        let ([u, v, w], [_, ny, nz]) = (self.widths(), self.counts);
        (i..i + u).flat_map(move |i| (j..j + v).flat_map(move |j| (k..k + w).map(move |k| (i * ny + j) * nz + k)))
    }

    /// The nodes that are coupled in the cells of the body, cell by cell, ascending.
    pub(super) fn cells(&self) -> Vec<Vec<u32>> {
        if let Some(ties) = &self.ties {
            let ends = |cell: &[usize; 3]| ties.ends(self.functions(*cell).map(|node| node as u32));
            return ties.cells().iter().map(|cell| ends(cell).into_iter().map(|node| self.start as u32 + node).collect()).collect();
        }
        let mut known = std::collections::HashSet::new();
        let mut cells = Vec::new();
        for p in 0..self.line_of.len() {
            let point = self.particle(p);
            if known.insert(point.cell()) {
                let mut nodes = Vec::new();
                self.each_slowly(&point, |node, _, _| nodes.push(node as u32));
                cells.push(nodes);
            }
        }
        cells
    }

    /// The functions at particle number `p` of the body.
    pub(super) fn particle(&self, p: usize) -> Point {
        let of = self.line_of[p];
        Point { lines: std::array::from_fn(|a| self.lines[a][of[a] as usize]), turn: self.turns.get(p).copied() }
    }

    /// Calls `f(node, weight, gradient)` for each function that is not zero at a point.
    #[inline(always)]
    pub(super) fn each<const D: usize, const W: usize>(&self, point: &Point, mut f: impl FnMut(usize, f64, [f64; D])) {
        let [x, y, z] = &point.lines;
        let (ny, nz) = (self.counts[1], self.counts[2]);
        for a in 0..W {
            for b in 0..if D > 1 { W } else { 1 } {
                let row = self.start + ((x.first + a) * ny + y.first + b) * nz + z.first;
                let (wx, wy) = (x.weight[a], y.weight[b]);
                let (gx, gy, w) = (x.slope[a] * wy, wx * y.slope[b], wx * wy);
                for c in 0..if D > 2 { W } else { 1 } {
                    let all = [gx * z.weight[c], gy * z.weight[c], w * z.slope[c]];
                    f(row + c, w * z.weight[c], point.slope(all));
                }
            }
        }
    }

    /// As [`each`](Self::each), for dimension and width that are not constants.
    pub(super) fn each_slowly(&self, point: &Point, mut f: impl FnMut(usize, f64, [f64; 3])) {
        let [x, y, z] = &point.lines;
        let width = |a: usize| self.axes.get(a).map_or(1, Axis::width);
        for a in 0..width(0) {
            for b in 0..width(1) {
                for c in 0..width(2) {
                    let node = self.start + ((x.first + a) * self.counts[1] + y.first + b) * self.counts[2] + z.first + c;
                    let (wx, wy, wz) = (x.weight[a], y.weight[b], z.weight[c]);
                    f(node, wx * wy * wz, point.slope([x.slope[a] * wy * wz, wx * y.slope[b] * wz, wx * wy * z.slope[c]]));
                }
            }
        }
    }

    /// Number along each axis of node number `i` of the grid.
    pub(super) fn index(&self, i: usize) -> [i32; 3] {
        [i / (self.counts[1] * self.counts[2]), i / self.counts[2] % self.counts[1], i % self.counts[2]].map(|i| i as i32)
    }

    /// Position at time 0 of node number `i` of the body (its Greville point) \[m\].
    pub(super) fn place(&self, i: usize) -> [f64; 3] {
        let index = self.index(i);
        let at = std::array::from_fn(|a| self.axes.get(a).map_or(0.0, |axis| axis.node_position(index[a])));
        self.map.as_ref().map_or(at, |map| map.place(at))
    }
}

fn turn(map: &Quadrilateral, at: [f64; 3]) -> [[f64; 2]; 2] {
    let inverse = map.jacobian(at).try_inverse().unwrap_or_else(nalgebra::Matrix3::identity);
    [[inverse[(0, 0)], inverse[(0, 1)]], [inverse[(1, 0)], inverse[(1, 1)]]]
}
