//! Particles to grid.

use super::lanes::Vector;
use super::{Rows, nodes};
use crate::basis::{BATCH, Stencils, Third};
use crate::grid::{Lanes, Tile};
use crate::material::embed;
use crate::model::Model;
use std::ops::Range;

/// What to add to the grid.
#[derive(Clone, Copy)]
pub(crate) struct ScatterTask<'a> {
    pub(crate) model: &'a Model,
    pub(crate) rows: Rows<'a>,
    /// Whether forces are added beside mass and momentum.
    pub(crate) forces: bool,
    /// Body force (an acceleration) of each particle \[m/s2\] by axis; empty where all particles have the same.
    pub(crate) body_force: &'a [Vec<f64>],
    /// Particles whose stress is integrated elsewhere; empty where there are none.
    pub(crate) relieved: &'a [bool],
}

/// # Safety
/// As [`super::Kernels::scatter`].
#[inline(always)]
pub(super) unsafe fn scatter<const D: usize, const W: usize, V: Vector>(task: &ScatterTask, range: Range<usize>, tile: &mut Tile) {
    // the four kinds of particle loops, so that none pays for what it does not do
    // SAFETY: the caller's promise.
    unsafe {
        match (task.model.needs.affine, task.forces) {
            (false, false) => particles::<D, W, V, false, false>(task, range, tile),
            (false, true) => particles::<D, W, V, false, true>(task, range, tile),
            (true, false) => particles::<D, W, V, true, false>(task, range, tile),
            (true, true) => particles::<D, W, V, true, true>(task, range, tile),
        }
    }
}

/// # Safety
/// As [`super::Kernels::scatter`].
#[inline(always)]
unsafe fn particles<const D: usize, const W: usize, V: Vector, const AFFINE: bool, const FORCES: bool>(
    task: &ScatterTask,
    range: Range<usize>,
    tile: &mut Tile,
) {
    // First the numbers of a few particles, then their sums: the sums then wait for nothing.
    let third = if AFFINE { Third::Arm } else { Third::Nothing };
    let (mut stencils, mut packets) = (Stencils::<W>::default(), [Packet::default(); BATCH]);
    let mut start = range.start;
    while start < range.end {
        let count = BATCH.min(range.end - start);
        // SAFETY: these rows are ours.
        stencils.set::<D>(&task.model.axes, &unsafe { task.rows.places(task.model, start, start + count) }, third);
        for (packet, p) in packets[..count].iter_mut().zip(start..) {
            // SAFETY: row p is ours.
            unsafe { packet.fill::<D, AFFINE, FORCES>(task, p) };
        }
        for (lane, packet) in packets[..count].iter().enumerate() {
            add::<D, W, V, AFFINE, FORCES>(&stencils, lane, packet, tile);
        }
        start += count;
    }
}

/// What one particle adds to the grid.
#[derive(Clone, Copy, Default)]
struct Packet {
    /// m, m v.
    momentum: Lanes,
    /// m C by slot of the arm: column `slot` of the affine matrix.
    affine: [Lanes; 3],
    /// m b.
    body_force: Lanes,
    /// -V0 tau by slot of the gradient.
    stress: [Lanes; 3],
}

impl Packet {
    /// # Safety
    /// Row `p` is the caller's.
    #[inline(always)]
    unsafe fn fill<const D: usize, const AFFINE: bool, const FORCES: bool>(&mut self, task: &ScatterTask, p: usize) {
        let rows = &task.rows;
        // SAFETY: row p is ours.
        let velocity = unsafe { rows.vector::<D, 3>(&rows.velocity, p) };
        let mass = rows.mass[p];
        self.momentum[0] = mass;
        for a in 0..D {
            self.momentum[1 + a] = mass * velocity[a];
        }
        if AFFINE {
            // SAFETY: row p is ours.
            let c = unsafe { rows.tensor::<D>(&rows.affine, p) };
            for a in 0..D {
                for k in 0..D {
                    self.affine[3 - D + k][1 + a] = mass * c[a][k];
                }
            }
        }
        if FORCES {
            // SAFETY: row p is ours.
            let (f, lateral, history) = unsafe { (rows.tensor::<D>(&rows.deformation, p), rows.lateral(p), rows.history(p)) };
            let relieved = !task.relieved.is_empty() && task.relieved[p];
            let weight = if relieved { 0.0 } else { -rows.volume[p] };
            let tau = task.model.material(rows.body[p]).kirchhoff(&embed(&f, lateral), &history);
            for a in 0..D {
                for k in 0..D {
                    self.stress[3 - D + k][1 + a] = weight * tau[(a, k)];
                }
            }
            for (a, b) in task.body_force.iter().enumerate() {
                self.body_force[1 + a] = mass * b[p];
            }
        }
    }
}

/// Adds the contributions of one particle: m_i += m N, p_i += N (m v + m C (x_i - x_p)), f_i += N m b - V0 tau grad N.
#[inline(always)]
fn add<const D: usize, const W: usize, V: Vector, const AFFINE: bool, const FORCES: bool>(
    s: &Stencils<W>,
    lane: usize,
    packet: &Packet,
    tile: &mut Tile,
) {
    let load = |l: &Lanes| V::load(l);
    let (momentum, body_force) = (V::load(&packet.momentum), V::load(&packet.body_force));
    let (affine, stress) = (packet.affine.each_ref().map(load), packet.stress.each_ref().map(load));
    let start = tile.frame.index(s.first(lane));
    let stride = tile.frame.stride;
    for i in 0..nodes::<D, W>(0) {
        let (n0, d0, g0) = (s.weight[0][i][lane], s.slope[0][i][lane], s.third[0][i][lane]);
        let mut p0 = V::scale(n0, momentum);
        let (mut p1, mut p2) = (V::zero(), V::zero());
        if AFFINE {
            p0 = V::fma(g0, affine[0], p0);
            (p1, p2) = (V::scale(n0, affine[1]), V::scale(n0, affine[2]));
        }
        let (mut f0, mut f1, mut f2) = (V::zero(), V::zero(), V::zero());
        if FORCES {
            f0 = V::fma(d0, stress[0], V::scale(n0, body_force));
            (f1, f2) = (V::scale(n0, stress[1]), V::scale(n0, stress[2]));
        }
        for j in 0..nodes::<D, W>(1) {
            let (n1, d1, g1) = (s.weight[1][j][lane], s.slope[1][j][lane], s.third[1][j][lane]);
            let mut q0 = V::scale(n1, p0);
            let mut q2 = V::zero();
            if AFFINE {
                q0 = V::fma(g1, p1, q0);
                q2 = V::scale(n1, p2);
            }
            let (mut h0, mut h2) = (V::zero(), V::zero());
            if FORCES {
                h0 = V::fma(d1, f1, V::scale(n1, f0));
                h2 = V::scale(n1, f2);
            }
            let row = start + i * stride[0] + j * stride[1];
            let momenta: &mut [Lanes; W] = row_of(&mut tile.momentum, row);
            for k in 0..W {
                let mut sum = V::fma(s.weight[2][k][lane], q0, V::load(&momenta[k]));
                if AFFINE {
                    sum = V::fma(s.third[2][k][lane], q2, sum);
                }
                sum.store(&mut momenta[k]);
            }
            if FORCES {
                let forces: &mut [Lanes; W] = row_of(&mut tile.force, row);
                for k in 0..W {
                    V::fma(s.slope[2][k][lane], h2, V::fma(s.weight[2][k][lane], h0, V::load(&forces[k]))).store(&mut forces[k]);
                }
            }
        }
    }
}

/// The `W` nodes from `start` on. The tile covers the cells of its bin.
#[inline(always)]
fn row_of<const W: usize>(nodes: &mut [Lanes], start: usize) -> &mut [Lanes; W] {
    nodes[start..].first_chunk_mut().expect("a tile covers the stencils of its particles")
}
