//! The fast path of explicit steps: bodies that are boxes of whole cells with the same points in each, so that functions at points are few
//! tables an axis, and eight cells fit in the lanes of a vector.
//!
//! Which bodies have it is decided here, once; the sums over particles (`force.rs`) are the path of all others, and its twin in tests.
//! Laws of small strain need no points at all (`assembled`).

mod assembled;
pub(super) mod kick;
mod law;
mod spread;
mod sweep;
#[cfg(test)]
mod tests;

use super::reference::Reference;
use super::wide::{Instructions, LANES, Lane};
use crate::basis::Family;
use crate::model::{Body, Model};
use crate::state::Particles;
use assembled::Assembled;
pub(crate) use law::Seen;
use law::{Kernel, Law};
use rayon::prelude::*;
pub(crate) use spread::Spread;
use sweep::{Piece, Scratch, Sweep};

/// A tensor of each of eight points: slope along the axes of a lattice, then component.
type Block<const D: usize> = [[Lane; D]; D];

const fn zero<const D: usize>() -> Block<D> {
    [[Lane::ZERO; D]; D]
}

/// The functions along an axis at a point, and their slopes \[1/m\].
#[derive(Debug, Clone, Copy)]
struct Line<const W: usize> {
    weight: [f64; W],
    slope: [f64; W],
}

/// The same for eight neighbouring cells; zero in those that the body does not have.
#[derive(Debug, Clone, Copy)]
struct WideLine<const W: usize> {
    weight: [Lane; W],
    slope: [Lane; W],
}

/// Tables of a body. Its axes are: the one that strips of cells are followed along, the one that is contiguous in memory and has the lanes, and
/// in space a third. Each table has the functions, and the functions times shares of the volume: the latter push.
#[derive(Debug)]
struct Lattice<const D: usize, const W: usize> {
    /// Points of a cell along each axis; 1 along those that are not there.
    points: [usize; 3],
    /// Along the first and third axis, by cell and point.
    lines: [Vec<[Line<W>; 2]>; 2],
    /// Along the second, by eight cells and point.
    lanes: Vec<[WideLine<W>; 2]>,
    /// From a node to the next along the first axis, to the next component, and to the next node along the third axis, in numbers.
    strides: [usize; 3],
}

/// A body with the memory of its sums.
struct Rows<const D: usize, const W: usize> {
    lattice: Lattice<D, W>,
    law: Law,
    sweep: Sweep<D, W>,
    kernel: Kernel<D>,
    /// Axis of the scene by axis of the lattice; an axis that the scene does not have may be among them.
    axes: [usize; D],
    /// Nodes along each axis of the scene.
    counts: [usize; 3],
    /// Its first node.
    start: usize,
    /// First cell of each piece, and the end, along the axis that the body is cut across.
    cuts: Vec<usize>,
    /// Numbers from one layer of nodes across that axis to the next.
    layer: usize,
    displacement: Vec<f64>,
    force: Vec<f64>,
    scratch: Vec<Scratch<D>>,
    seen: Vec<Seen>,
}

/// Internal forces of a body.
pub(crate) trait Forces: Send + Sync {
    /// Sets the internal forces of its nodes \[N\] at a displacement \[m\] of all nodes.
    fn set(&mut self, displacement: &[[f64; 3]], force: &mut [[f64; 3]], looks: bool) -> Seen;
}

/// The fast sums of all bodies, if all have them.
pub(super) fn all(
    model: &Model,
    particles: &Particles,
    references: &[&Reference],
    instructions: Instructions,
) -> Option<Vec<(Box<dyn Forces>, Spread)>> {
    if model.implicit.is_some() || model.mean_dilatation {
        return None;
    }
    let one = |(body, reference): (&Body, &&Reference)| of(model, body, particles, reference, instructions);
    model.bodies.iter().zip(references).map(one).collect()
}

/// The fast sums of a body.
fn of(
    model: &Model,
    body: &Body,
    particles: &Particles,
    reference: &Reference,
    instructions: Instructions,
) -> Option<(Box<dyn Forces>, Spread)> {
    let open = reference.axes.iter().all(|axis| matches!(axis.family(), Family::OpenSpline(_)));
    if !open || body.map.is_some() || reference.ties().is_some() {
        return None;
    }
    let grid = Grid::new(reference, &particles.volume[body.particles.clone()])?;
    if let Some(lame) = law::small_strain(&body.material, model.embedding) {
        let forces = Assembled::new(&grid, lame, reference, instructions);
        return Some((Box::new(forces), Spread::new(grid, reference, body.density, body.particles.len())));
    }
    let law = Law::new(&body.material, model.embedding)?;
    fn boxed<const D: usize, const W: usize>(grid: &Grid, law: Law, reference: &Reference, instructions: Instructions) -> Box<dyn Forces> {
        Box::new(Rows::<D, W>::new(grid, law, reference, instructions))
    }
    let choice = match (model.dimension, reference.axes[0].width()) {
        (1 | 2, 2) => boxed::<2, 2>,
        (1 | 2, 3) => boxed::<2, 3>,
        (1 | 2, 4) => boxed::<2, 4>,
        (1 | 2, 5) => boxed::<2, 5>,
        (1 | 2, 6) => boxed::<2, 6>,
        (3, 2) => boxed::<3, 2>,
        (3, 3) => boxed::<3, 3>,
        (3, 4) => boxed::<3, 4>,
        (3, 5) => boxed::<3, 5>,
        (3, 6) => boxed::<3, 6>,
        _ => return None,
    };
    let forces = choice(&grid, law, reference, instructions);
    Some((forces, Spread::new(grid, reference, body.density, body.particles.len())))
}

/// The points of a body along each axis of the scene.
struct Grid {
    axes: [Option<GridAxis>; 3],
}

/// The points of a body along an axis, in ascending order.
struct GridAxis {
    cells: usize,
    per_cell: usize,
    lines: Vec<super::reference::Line>,
    /// Share of each in the volume of a point, such that the product over the axes is the volume.
    shares: Vec<f64>,
}

impl Grid {
    /// `None` where the particles are no such lattice: they come cell by cell, the last axis fastest.
    fn new(reference: &Reference, volumes: &[f64]) -> Option<Self> {
        let mut axes = [None, None, None];
        for (a, axis) in reference.axes.iter().enumerate() {
            let lines = reference.lines(a).to_vec();
            let cells = axis.cells() as usize;
            let per_cell = lines.len() / cells;
            let full = lines.len() == per_cell * cells && lines.iter().enumerate().all(|(i, line)| line.first == i / per_cell.max(1));
            if per_cell == 0 || !full {
                return None;
            }
            axes[a] = Some(GridAxis { cells, per_cell, lines, shares: Vec::new() });
        }
        let mut grid = Self { axes };
        let n = grid.axes.iter().flatten().map(|axis| axis.lines.len()).product::<usize>();
        if n != volumes.len() || (0..n).any(|p| !reference.stands_at(p, grid.place(p))) {
            return None;
        }
        grid.share(volumes).then_some(grid)
    }

    /// Which point along each axis particle `p` is.
    fn place(&self, p: usize) -> [usize; 3] {
        let each = |a: usize| self.axes[a].as_ref().map_or([1, 1], |axis| [axis.cells, axis.per_cell]);
        let per_cell: usize = (0..3).map(|a| each(a)[1]).product();
        let (mut cell, mut point) = (p / per_cell, p % per_cell);
        let mut place = [0; 3];
        for a in (0..3).rev() {
            let [cells, points] = each(a);
            place[a] = cell % cells * points + point % points;
            (cell, point) = (cell / cells, point / points);
        }
        place
    }

    /// Finds the shares; tells whether there are such.
    fn share(&mut self, volumes: &[f64]) -> bool {
        for a in 0..3 {
            let mut shares = vec![0.0; self.axes[a].as_ref().map_or(0, |axis| axis.lines.len())];
            for (p, volume) in volumes.iter().enumerate() {
                let place = self.place(p);
                if (0..3).all(|b| b == a || place[b] == 0) && !shares.is_empty() {
                    // the first axis has the volume of the first point, the others are relative to it
                    shares[place[a]] = if a == 0 { *volume } else { volume / volumes[0] };
                }
            }
            if let Some(axis) = &mut self.axes[a] {
                axis.shares = shares;
            }
        }
        let product = |p: usize| {
            let place = self.place(p);
            (0..3).map(|a| self.axes[a].as_ref().map_or(1.0, |axis| axis.shares[place[a]])).product::<f64>()
        };
        // a point of no share would not be seen to be inverted
        (0..volumes.len()).all(|p| volumes[p] > 0.0 && (product(p) / volumes[p] - 1.0).abs() < 1e-12)
    }
}

/// Pieces that a body is cut into at most; two colours of them work at the same time.
const PIECES: usize = 32;
/// Points below which threads cost more than they bring.
pub(super) const FEW: usize = 20_000;

impl<const D: usize, const W: usize> Rows<D, W> {
    fn new(grid: &Grid, law: Law, reference: &Reference, instructions: Instructions) -> Self {
        let cells = |a: usize| grid.axes[a].as_ref().map_or(1, |axis| axis.cells);
        // lanes along the axis that fills them best, else the last: its nodes are neighbours in the state too
        let real = reference.axes.len();
        let waste = |a: usize| (cells(a).next_multiple_of(LANES) * 1000) / cells(a);
        let lane = (0..real).rev().min_by_key(|a| waste(*a)).unwrap_or(0);
        let mut others: Vec<usize> = (0..3).filter(|a| *a != lane).collect();
        if D > 2 {
            // pieces are cut across the longer of the others, or the one whose layers follow each other in the state
            others.sort_by_key(|a| (cells(*a), std::cmp::Reverse(*a)));
        } else {
            others.sort_by_key(|a| *a >= real);
        }
        let axes: [usize; D] = std::array::from_fn(|k| [others[0], lane, others[1]][k]);
        let table = |k: usize| -> Vec<[Line<W>; 2]> {
            let Some(axis) = axes.get(k).and_then(|a| grid.axes[*a].as_ref()) else { return vec![[Line::alone(1.0), Line::alone(1.0)]] };
            axis.lines.iter().zip(&axis.shares).map(|(line, share)| [Line::new(line, 1.0), Line::new(line, *share)]).collect()
        };
        let per_cell = |k: usize| axes.get(k).and_then(|a| grid.axes[*a].as_ref()).map_or(1, |axis| axis.per_cell);
        let count = |k: usize| axes.get(k).map_or(1, |a| cells(*a)) + if k < D { W - 1 } else { 0 };
        let points = [per_cell(0), per_cell(1), per_cell(2)];
        let along = table(1);
        let strips = (count(1) - (W - 1)).div_ceil(LANES);
        let mut lanes = Vec::with_capacity(strips * points[1]);
        for strip in 0..strips {
            for q in 0..points[1] {
                lanes.push([0, 1].map(|way| {
                    let of = |lane: usize| along.get((strip * LANES + lane) * points[1] + q).map(|both| both[way]);
                    let pick =
                        |c: usize, get: fn(&Line<W>, usize) -> f64| Lane(std::array::from_fn(|lane| of(lane).map_or(0.0, |l| get(&l, c))));
                    WideLine {
                        weight: std::array::from_fn(|c| pick(c, |l, c| l.weight[c])),
                        slope: std::array::from_fn(|c| pick(c, |l, c| l.slope[c])),
                    }
                }));
            }
        }
        // internal forces are minus what stresses do
        for [_, push] in &mut lanes {
            for lane in push.weight.iter_mut().chain(&mut push.slope) {
                lane.0.iter_mut().for_each(|v| *v = -*v);
            }
        }
        let pitch = (strips * LANES + W - 1).next_multiple_of(LANES);
        let strides = if D > 2 { [pitch, count(0) * pitch, D * count(0) * pitch] } else { [D * pitch, pitch, 0] };
        let (layer, length) = (strides[Self::CUT], count(Self::CUT) - (W - 1));
        // pieces of one colour must not share layers; in a plane each repeats the sums of its first layers
        let shortest = if D > 2 { W - 1 } else { 8 * (W - 1) };
        let pieces = (length / shortest.max(length.div_ceil(PIECES))).max(1);
        let cuts: Vec<usize> = (0..=pieces).map(|i| i * length / pieces).collect();
        let numbers = layer * count(Self::CUT);
        Self {
            lattice: Lattice { points, lines: [table(0), table(2)], lanes, strides },
            law,
            sweep: sweep::choose(instructions),
            kernel: law.kind.kernel(instructions),
            axes,
            counts: reference.counts,
            start: reference.start,
            cuts,
            layer,
            displacement: vec![0.0; numbers],
            force: vec![0.0; numbers],
            scratch: vec![Scratch::default(); pieces],
            seen: vec![Seen::nothing(false); pieces],
        }
    }

    /// Nodes from one to the next along an axis of the lattice, in the state.
    fn stride(&self, axis: usize) -> usize {
        self.axes.get(axis).map_or(0, |a| self.counts[a + 1..].iter().product())
    }

    /// Axis of the lattice that the body is cut across.
    const CUT: usize = if D > 2 { 2 } else { 0 };

    /// Lines of nodes along the lanes in a layer: the first node of each in the state, from that of the layer, and its place in the layer.
    fn lines(&self) -> impl Iterator<Item = [usize; 2]> + use<D, W> {
        let (number, stride, first) = if D > 2 { (self.counts[self.axes[0]], self.stride(0), self.lattice.strides[0]) } else { (1, 0, 0) };
        (0..number).map(move |j| [j * stride, j * first])
    }

    /// Whether threads bring more than they cost.
    fn shares(&self) -> bool {
        rayon::current_num_threads() > 1 && self.displacement.len() / D * self.lattice.points.iter().product::<usize>() >= FEW
    }

    /// Takes the displacements of the state.
    fn take(&mut self, displacement: &[[f64; 3]]) {
        let mut to = std::mem::take(&mut self.displacement);
        let (component, count, stride) = (self.lattice.strides[1], self.counts[self.axes[1]], self.stride(1));
        let work = |(i, layer): (usize, &mut [f64])| {
            for [node, place] in self.lines() {
                let nodes = &displacement[self.start + i * self.stride(Self::CUT) + node..];
                for (k, axis) in self.axes.iter().enumerate() {
                    for (n, u) in layer[place + k * component..][..count].iter_mut().enumerate() {
                        *u = nodes[n * stride][*axis];
                    }
                }
            }
        };
        let layers = self.counts[self.axes[Self::CUT]];
        if self.shares() {
            to.par_chunks_mut(self.layer).take(layers).enumerate().for_each(work);
        } else {
            to.chunks_mut(self.layer).take(layers).enumerate().for_each(work);
        }
        self.displacement = to;
    }

    /// Gives the forces to the nodes of the state.
    fn give(&self, force: &mut [[f64; 3]]) {
        let (component, count, stride) = (self.lattice.strides[1], self.counts[self.axes[1]], self.stride(1));
        let work = |i: usize, nodes: &mut [[f64; 3]]| {
            let layer = &self.force[i * self.layer..];
            for [node, place] in self.lines() {
                for n in 0..count {
                    let mut all = [0.0; 3];
                    for (k, axis) in self.axes.iter().enumerate() {
                        all[*axis] = layer[place + k * component + n];
                    }
                    nodes[node + n * stride] = all;
                }
            }
        };
        let (layers, size) = (self.counts[self.axes[Self::CUT]], self.stride(Self::CUT));
        let nodes = &mut force[self.start..][..self.counts.iter().product()];
        if self.axes[Self::CUT] == 0 && self.shares() {
            nodes.par_chunks_mut(size).enumerate().for_each(|(i, layer)| work(i, layer));
        } else {
            (0..layers).for_each(|i| work(i, &mut nodes[i * size..]));
        }
    }

    fn sum(&mut self, looks: bool) {
        let shares = self.shares();
        self.seen.fill(Seen::nothing(looks));
        let Self { lattice, law, sweep, kernel, cuts, layer, displacement, force, scratch, seen, .. } = self;
        let (lattice, law, sweep, kernel, displacement) = (&*lattice, &*law, *sweep, *kernel, &*displacement);
        let work = |(i, force, scratch, seen): (usize, &mut [f64], &mut Scratch<D>, &mut Seen)| {
            let piece = Piece { cells: cuts[i]..cuts[i + 1], displacement: &displacement[cuts[i] * *layer..], force, scratch, seen };
            // SAFETY: the sweep was chosen for instructions that the processor has
            unsafe { sweep(lattice, law, kernel, piece) };
        };
        for color in 0..2 {
            let mut rest: &mut [f64] = force;
            let mut done = 0;
            let mut pieces = Vec::with_capacity(PIECES);
            for (i, (scratch, seen)) in scratch.iter_mut().zip(seen.iter_mut()).enumerate().skip(color).step_by(2) {
                // the layers that its cells see
                let (start, end) = (cuts[i] * *layer, (cuts[i + 1] + W - 1) * *layer);
                let (part, left) = std::mem::take(&mut rest).split_at_mut(end - done);
                pieces.push((i, &mut part[start - done..], scratch, seen));
                (rest, done) = (left, end);
            }
            if shares {
                pieces.into_par_iter().for_each(work);
            } else {
                pieces.into_iter().for_each(work);
            }
        }
    }
}

impl<const D: usize, const W: usize> Forces for Rows<D, W> {
    fn set(&mut self, displacement: &[[f64; 3]], force: &mut [[f64; 3]], looks: bool) -> Seen {
        self.take(displacement);
        self.force.fill(0.0);
        self.sum(looks);
        self.give(force);
        let mut seen = Seen::nothing(looks);
        self.seen.iter().for_each(|piece| seen.merge(piece));
        seen
    }
}

impl<const W: usize> Line<W> {
    fn new(line: &super::reference::Line, share: f64) -> Self {
        Self { weight: std::array::from_fn(|k| share * line.weight[k]), slope: std::array::from_fn(|k| share * line.slope[k]) }
    }

    /// Along an axis that the scene does not have.
    fn alone(share: f64) -> Self {
        Self { weight: std::array::from_fn(|k| if k == 0 { share } else { 0.0 }), slope: [0.0; W] }
    }
}
