//! Internal forces of a law of small strain: the stiffness of a body, assembled once, axis by axis.
//!
//! The functions of a lattice are products of one an axis, and so are the shares of the volume of its points: a sum over the points of a product of
//! slopes is a product of sums along the axes. With four banded matrices an axis,
//!
//! M = sum N_m N_n,  K = sum N_m' N_n',  C = sum N_m' N_n  and its transpose T,
//!
//! the block of the stiffness between components i and j, of lambda dN_m/dx_i dN_n/dx_j + mu dN_m/dx_j dN_n/dx_i and, for i = j, mu grad N_m . grad N_n,
//! is a sum of Kronecker products: for i = j one an axis a, with K along a, M along the others, times lambda + 2 mu if a is i, else mu; for
//! i != j lambda times C along i and T along j, plus mu times T along i and C along j, M along the third. So a node takes, at degree p in
//! space, (12 + 21 + 12) (2 p + 1) products: 225 at degree 2, where the sums over the points take about 1,000, and the stiffness as a table 1,125.
//! Near the ends of the axes nothing is different: matrices have rows of their own there.

use super::law::Seen;
use super::{FEW, Forces, Grid, GridAxis};
use crate::lines::Lines;
use crate::material::Lame;
use crate::total::reference::Reference;
use crate::total::wide::{Instructions, LANES, Portable, Wide};
use rayon::prelude::*;
use std::ops::Range;

/// The matrices of an axis.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Kind {
    M,
    K,
    C,
    T,
}
use Kind::{C, K, M, T};
const KINDS: [Kind; 4] = [M, K, C, T];
/// Entries of a diagonal of eight nodes, of all kinds.
const ENTRIES: usize = 4 * LANES;

/// The matrices of an axis: rows of as many numbers as there are functions that meet.
#[derive(Debug)]
struct Bands {
    nodes: usize,
    /// Functions on either side that meet one.
    half: usize,
    rows: [Vec<f64>; 4],
}

impl Bands {
    fn new(axis: &GridAxis, nodes: usize, width: usize) -> Self {
        let half = width - 1;
        let row = 2 * half + 1;
        let mut rows = KINDS.map(|_| vec![0.0; nodes * row]);
        for (line, share) in axis.lines.iter().zip(&axis.shares) {
            for m in 0..width {
                for n in 0..width {
                    let at = (line.first + m) * row + half + n - m;
                    let products = [line.weight[m] * line.weight[n], line.slope[m] * line.slope[n], line.slope[m] * line.weight[n]];
                    for (kind, product) in [M, K, C].into_iter().zip(products) {
                        rows[kind as usize][at] += share * product;
                    }
                    rows[T as usize][at] += share * line.weight[m] * line.slope[n];
                }
            }
        }
        Self { nodes, half, rows }
    }

    /// Along an axis that the scene does not have.
    fn none() -> Self {
        Self { nodes: 1, half: 0, rows: [vec![1.0], vec![0.0], vec![0.0], vec![0.0]] }
    }

    /// The entries of row `m` that are there: column and value.
    fn row(&self, kind: Kind, m: usize) -> impl Iterator<Item = (usize, f64)> + '_ {
        let row = 2 * self.half + 1;
        let entries = self.rows[kind as usize][m * row..][..row].iter().enumerate();
        entries.filter_map(move |(d, value)| Some(((m + d).checked_sub(self.half).filter(|n| *n < self.nodes)?, *value)))
    }
}

/// A share of a row of numbers in a sum, and where the row begins.
type Share = (f64, usize);

/// Numbers at nodes; nothing in it is remembered.
#[derive(Default)]
struct Scratch {
    /// Displacements of the planes that meet, component by component.
    displacement: Lines,
    /// Of a plane, times the matrices of the first axis, by component and kind.
    first: Lines,
    /// A row of each of the sums over the second axis, by component and kind of the last, with zeros at either end.
    second: Lines,
}

/// A body with its stiffness. Its axes are the first, second and last of the scene; of those that are not there the functions are 1.
pub(super) struct Assembled {
    dimension: usize,
    /// First node in the state.
    start: usize,
    axes: [Bands; 3],
    /// Numbers from one row of nodes to the next, a whole number of lanes.
    pitch: usize,
    /// The sums over the second axis, by component and kind of the last: for each row of a plane, what it is made of, rows of [`Scratch::first`].
    sums: Vec<Vec<Vec<Share>>>,
    /// The matrices of the last axis: for eight nodes, diagonal by diagonal, those of each kind.
    diagonals: Lines,
    sweep: Sweep,
    scratch: Vec<Scratch>,
}

impl Assembled {
    pub(super) fn new(grid: &Grid, Lame { lambda, mu }: Lame, reference: &Reference, instructions: Instructions) -> Self {
        let dimension = reference.axes.len();
        let width = reference.axes[0].width();
        // in a plane without threads the sums over one axis are all that is beside the last
        let nodes: usize = reference.counts.iter().product();
        let slot = |a: usize| match (dimension, a) {
            (1, _) | (_, 2) | (2, 1) => 2,
            (2, _) if nodes < FEW => 1,
            _ => a,
        };
        let mut axes = [Bands::none(), Bands::none(), Bands::none()];
        for (a, axis) in grid.axes.iter().enumerate() {
            if let Some(axis) = axis {
                axes[slot(a)] = Bands::new(axis, reference.counts[a], width);
            }
        }
        let pitch = axes[2].nodes.next_multiple_of(LANES);
        let row = 2 * axes[2].half + 1;
        let mut diagonals = Lines::zeros(pitch / LANES * row * ENTRIES);
        for (at, entry) in diagonals.numbers_mut().iter_mut().enumerate() {
            let (chunk, d, kind, lane) = (at / ENTRIES / row, at / ENTRIES % row, at % ENTRIES / LANES, at % LANES);
            *entry = axes[2].rows[kind].get((chunk * LANES + lane) * row + d).copied().unwrap_or(0.0);
        }
        let mut sums = vec![vec![Vec::new(); axes[1].nodes]; 4 * dimension];
        let mut add = |target: usize, kinds: [Kind; 3], source: usize, factor: f64| {
            for (y, row) in sums[4 * target + kinds[2] as usize].iter_mut().enumerate() {
                let place = |n: usize| ((4 * source + kinds[0] as usize) * axes[1].nodes + n) * pitch;
                // internal forces are minus what stresses do
                row.extend(axes[1].row(kinds[1], y).map(|(n, value)| (-factor * value, place(n))));
            }
        };
        for i in 0..dimension {
            for j in (0..dimension).filter(|j| *j != i) {
                for (of_i, of_j, factor) in [(C, T, lambda), (T, C, mu)] {
                    let mut kinds = [M; 3];
                    (kinds[slot(i)], kinds[slot(j)]) = (of_i, of_j);
                    add(i, kinds, j, factor);
                }
            }
            for a in 0..dimension {
                let mut kinds = [M; 3];
                kinds[slot(a)] = K;
                add(i, kinds, i, if a == i { lambda + 2.0 * mu } else { mu });
            }
        }
        Self { dimension, start: reference.start, axes, pitch, sums, diagonals, sweep: choose(instructions), scratch: Vec::new() }
    }

    /// Nodes of a plane across the first axis.
    fn nodes(&self) -> usize {
        self.axes[1].nodes * self.axes[2].nodes
    }

    /// Numbers of a row with zeros at either end.
    fn padded(&self) -> usize {
        self.pitch + 2 * LANES
    }

    /// Numbers of a component in a plane.
    fn plane(&self) -> usize {
        self.axes[1].nodes * self.pitch
    }
}

impl Forces for Assembled {
    fn set(&mut self, displacement: &[[f64; 3]], force: &mut [[f64; 3]], looks: bool) -> Seen {
        let planes = self.axes[0].nodes;
        let all = self.start..self.start + planes * self.nodes();
        let (displacement, force) = (&displacement[all.clone()], &mut force[all]);
        let most = if planes * self.plane() < FEW { 1 } else { rayon::current_num_threads() };
        let each = planes.div_ceil(most);
        let mut scratch = std::mem::take(&mut self.scratch);
        scratch.resize_with(planes.div_ceil(each).max(scratch.len()), Scratch::default);
        let work = |(piece, (force, scratch)): (usize, (&mut [[f64; 3]], &mut Scratch))| {
            let first = piece * each;
            // SAFETY: the sweep was chosen for instructions that the processor has
            unsafe { (self.sweep)(self, first..(first + each).min(planes), displacement, force, scratch) };
        };
        if most > 1 {
            force.par_chunks_mut(each * self.nodes()).zip(&mut scratch).enumerate().for_each(work);
        } else {
            force.chunks_mut(each * self.nodes()).zip(&mut scratch).enumerate().for_each(work);
        }
        self.scratch = scratch;
        Seen::nothing(looks)
    }
}

/// Sets the forces of some planes of nodes. Unsafe to call where the processor lacks the instructions that it was chosen for.
type Sweep = unsafe fn(&Assembled, Range<usize>, &[[f64; 3]], &mut [[f64; 3]], &mut Scratch);

/// Plane by plane, the matrices of the first axis; row by row of it, those of the second, then those of the last.
#[inline(always)]
fn sweep<V: Wide>(of: &Assembled, planes: Range<usize>, displacement: &[[f64; 3]], force: &mut [[f64; 3]], scratch: &mut Scratch) {
    let (plane, half) = (of.plane(), of.axes[0].half);
    let ring = 2 * half + 1;
    scratch.displacement.resize(ring * of.dimension * plane);
    scratch.first.resize(4 * of.dimension * plane);
    scratch.second.resize(4 * of.dimension * of.padded());
    let (taken, first, second) = (scratch.displacement.numbers_mut(), scratch.first.numbers_mut(), scratch.second.numbers_mut());
    for x in planes.start.saturating_sub(half)..planes.end + half {
        if x < of.axes[0].nodes {
            take(of, &displacement[x * of.nodes()..][..of.nodes()], &mut taken[x % ring * of.dimension * plane..]);
        }
        if x < planes.start + half {
            continue;
        }
        let done = x - half;
        first_axis::<V>(of, done, taken, first);
        let nodes = &mut force[(done - planes.start) * of.nodes()..][..of.nodes()];
        for (y, row) in nodes.chunks_exact_mut(of.axes[2].nodes).enumerate() {
            for (sum, to) in of.sums.iter().zip(second.chunks_exact_mut(of.padded())) {
                combine::<V>(&sum[y], first, &mut to[LANES..][..of.pitch]);
            }
            match of.dimension {
                1 => last_axis::<V, 1>(of, second, row),
                2 => last_axis::<V, 2>(of, second, row),
                _ => last_axis::<V, 3>(of, second, row),
            }
        }
    }
}

/// Takes the displacements of a plane.
#[inline(always)]
fn take(of: &Assembled, nodes: &[[f64; 3]], to: &mut [f64]) {
    for component in 0..of.dimension {
        for (row, to) in nodes.chunks_exact(of.axes[2].nodes).zip(to[component * of.plane()..].chunks_exact_mut(of.pitch)) {
            for (to, node) in to.iter_mut().zip(row) {
                *to = node[component];
            }
        }
    }
}

/// The matrices of the first axis times the planes that meet plane `x`.
#[inline(always)]
fn first_axis<V: Wide>(of: &Assembled, x: usize, displacement: &[f64], to: &mut [f64]) {
    const TOGETHER: usize = 2 * LANES;
    let (plane, bands) = (of.plane(), &of.axes[0]);
    let ring = 2 * bands.half + 1;
    let meets = x.saturating_sub(bands.half)..(x + bands.half + 1).min(bands.nodes);
    for component in 0..of.dimension {
        let mut at = 0;
        while at < plane {
            let parts = if at + TOGETHER <= plane { 2 } else { 1 };
            let mut sums = [[V::zero(); 2]; 4];
            for n in meets.clone() {
                let entry = x * ring + n + bands.half - x;
                let start = (n % ring * of.dimension + component) * plane + at;
                for part in 0..2 {
                    if part < parts {
                        let u = V::load_at(displacement, start + part * LANES);
                        for kind in 0..4 {
                            sums[kind][part] = V::splat(bands.rows[kind][entry]).fma(u, sums[kind][part]);
                        }
                    }
                }
            }
            for kind in 0..4 {
                for part in 0..2 {
                    if part < parts {
                        sums[kind][part].store_at(to, (4 * component + kind) * plane + at + part * LANES);
                    }
                }
            }
            at += parts * LANES;
        }
    }
}

/// Sets a row to a sum of rows.
#[inline(always)]
fn combine<V: Wide>(shares: &[Share], from: &[f64], to: &mut [f64]) {
    let mut at = 0;
    while at < to.len() {
        match (to.len() - at) / LANES {
            1 => combine_part::<V, 1, LANES>(shares, from, to, &mut at),
            2 => combine_part::<V, 2, { 2 * LANES }>(shares, from, to, &mut at),
            3 => combine_part::<V, 3, { 3 * LANES }>(shares, from, to, &mut at),
            _ => combine_part::<V, 4, { 4 * LANES }>(shares, from, to, &mut at),
        }
    }
}

/// Sets the next `COUNT` numbers of the row. Every other share has sums of its own, so that none waits for the one before.
#[inline(always)]
fn combine_part<V: Wide, const P: usize, const COUNT: usize>(shares: &[Share], from: &[f64], to: &mut [f64], at: &mut usize) {
    let mut sums = [[V::zero(); P]; 2];
    for pair in shares.chunks(2) {
        for (way, (share, start)) in pair.iter().enumerate() {
            let (share, row) = (V::splat(*share), &from[start + *at..][..COUNT]);
            for part in 0..P {
                sums[way][part] = share.fma(V::load_at(row, part * LANES), sums[way][part]);
            }
        }
    }
    let to = &mut to[*at..][..COUNT];
    for part in 0..P {
        sums[0][part].add(sums[1][part]).store_at(to, part * LANES);
    }
    *at += COUNT;
}

/// The matrices of the last axis times a row of sums: the forces on its nodes.
#[inline(always)]
fn last_axis<V: Wide, const D: usize>(of: &Assembled, sums: &[f64], nodes: &mut [[f64; 3]]) {
    let half = of.axes[2].half;
    let row = 2 * half + 1;
    for (eight, (nodes, entries)) in nodes.chunks_mut(LANES).zip(of.diagonals.numbers().chunks_exact(row * ENTRIES)).enumerate() {
        // every other kind has sums of its own, so that none waits for the one before
        let mut forces = [[V::zero(); D]; 2];
        for (d, entries) in entries.chunks_exact(ENTRIES).enumerate() {
            for kind in 0..4 {
                let entry = V::load_at(entries, kind * LANES);
                for component in 0..D {
                    let sum = V::load_at(sums, (4 * component + kind) * of.padded() + (eight + 1) * LANES + d - half);
                    forces[kind % 2][component] = entry.fma(sum, forces[kind % 2][component]);
                }
            }
        }
        let mut lanes = [[0.0; LANES]; 3];
        for component in 0..D {
            forces[0][component].add(forces[1][component]).store_at(&mut lanes[component], 0);
        }
        for (lane, node) in nodes.iter_mut().enumerate() {
            *node = [lanes[0][lane], lanes[1][lane], lanes[2][lane]];
        }
    }
}

macro_rules! sweeps {
    ($name:ident, $vector:ty $(, $features:literal)?) => {
        $(#[target_feature(enable = $features)])?
        fn $name(of: &Assembled, planes: Range<usize>, displacement: &[[f64; 3]], force: &mut [[f64; 3]], scratch: &mut Scratch) {
            sweep::<$vector>(of, planes, displacement, force, scratch);
        }
    };
}
#[cfg(target_arch = "x86_64")]
sweeps!(avx512, crate::total::wide::Avx512, "avx512f");
#[cfg(target_arch = "x86_64")]
sweeps!(avx2, crate::total::wide::Avx2, "avx2,fma");
sweeps!(portable, Portable);

fn choose(instructions: Instructions) -> Sweep {
    match instructions {
        #[cfg(target_arch = "x86_64")]
        Instructions::Avx512 => avx512,
        #[cfg(target_arch = "x86_64")]
        Instructions::Avx2 => avx2,
        Instructions::Portable => portable,
    }
}
