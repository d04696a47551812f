//! Particles to grid.

use super::{Rows, fma, nodes, scale};
use crate::basis::Stencil;
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
}

/// # Safety
/// As [`super::Kernels::scatter`].
#[inline(always)]
pub(super) unsafe fn scatter<const D: usize, const W: usize, const FMA: bool>(task: &ScatterTask, range: Range<usize>, tile: &mut Tile) {
    // the four kinds of particle loops, so that none pays for what it does not do
    // SAFETY: the caller's promise.
    unsafe {
        match (task.model.needs.affine, task.forces) {
            (false, false) => particles::<D, W, FMA, false, false>(task, range, tile),
            (false, true) => particles::<D, W, FMA, false, true>(task, range, tile),
            (true, false) => particles::<D, W, FMA, true, false>(task, range, tile),
            (true, true) => particles::<D, W, FMA, true, true>(task, range, tile),
        }
    }
}

/// # Safety
/// As [`super::Kernels::scatter`].
#[inline(always)]
unsafe fn particles<const D: usize, const W: usize, const FMA: bool, const AFFINE: bool, const FORCES: bool>(
    task: &ScatterTask,
    range: Range<usize>,
    tile: &mut Tile,
) {
    let rows = &task.rows;
    for p in range {
        // SAFETY: row p is ours.
        let (position, velocity) = unsafe { (rows.vector::<D, 3>(&rows.position, p), rows.vector::<D, 3>(&rows.velocity, p)) };
        let stencil = Stencil::<W>::at::<D, AFFINE>(&task.model.axes, position);
        let mass = rows.mass[p];
        let mut momentum = Lanes::default();
        momentum[0] = mass;
        for a in 0..D {
            momentum[1 + a] = mass * velocity[a];
        }
        // m C by slot of the arm: column `slot` of the affine matrix
        let mut affine = [Lanes::default(); 3];
        if AFFINE {
            // SAFETY: row p is ours.
            let c = unsafe { rows.tensor::<D>(&rows.affine, p) };
            for a in 0..D {
                for k in 0..D {
                    affine[3 - D + k][1 + a] = mass * c[a][k];
                }
            }
        }
        // -V0 tau by slot of the gradient, and m b
        let mut stress = [Lanes::default(); 3];
        let mut body_force = Lanes::default();
        if FORCES {
            // SAFETY: row p is ours.
            let (f, lateral, history) = unsafe { (rows.tensor::<D>(&rows.deformation, p), rows.lateral(p), rows.history(p)) };
            let tau = task.model.material(rows.body[p]).kirchhoff(&embed(&f, lateral), &history);
            for a in 0..D {
                for k in 0..D {
                    stress[3 - D + k][1 + a] = -rows.volume[p] * tau[(a, k)];
                }
            }
            for (a, b) in task.body_force.iter().enumerate() {
                body_force[1 + a] = mass * b[p];
            }
        }
        add::<D, W, FMA, AFFINE, FORCES>(&stencil, momentum, &affine, body_force, &stress, tile);
    }
}

/// Adds the contributions of one particle: m_i += m N, p_i += N (m v + m C (x_i - x_p)), f_i += N m b - V0 tau grad N.
#[inline(always)]
fn add<const D: usize, const W: usize, const FMA: bool, const AFFINE: bool, const FORCES: bool>(
    s: &Stencil<W>,
    momentum: Lanes,
    affine: &[Lanes; 3],
    body_force: Lanes,
    stress: &[Lanes; 3],
    tile: &mut Tile,
) {
    let start = tile.frame.index(s.first);
    let stride = tile.frame.stride;
    for i in 0..nodes::<D, W>(0) {
        let (n0, d0, g0) = (s.weight[0][i], s.slope[0][i], s.weight[0][i] * s.arm[0][i]);
        let mut p0 = scale(n0, momentum);
        let (mut p1, mut p2) = (Lanes::default(), Lanes::default());
        if AFFINE {
            p0 = fma::<FMA>(g0, affine[0], p0);
            (p1, p2) = (scale(n0, affine[1]), scale(n0, affine[2]));
        }
        let (mut f0, mut f1, mut f2) = (Lanes::default(), Lanes::default(), Lanes::default());
        if FORCES {
            f0 = fma::<FMA>(d0, stress[0], scale(n0, body_force));
            (f1, f2) = (scale(n0, stress[1]), scale(n0, stress[2]));
        }
        for j in 0..nodes::<D, W>(1) {
            let (n1, d1, g1) = (s.weight[1][j], s.slope[1][j], s.weight[1][j] * s.arm[1][j]);
            let mut q0 = scale(n1, p0);
            let mut q2 = Lanes::default();
            if AFFINE {
                q0 = fma::<FMA>(g1, p1, q0);
                q2 = scale(n1, p2);
            }
            let (mut h0, mut h2) = (Lanes::default(), Lanes::default());
            if FORCES {
                h0 = fma::<FMA>(d1, f1, scale(n1, f0));
                h2 = scale(n1, f2);
            }
            let row = start + i * stride[0] + j * stride[1];
            let momenta = &mut tile.momentum[row..row + W];
            for k in 0..W {
                let mut sum = fma::<FMA>(s.weight[2][k], q0, momenta[k]);
                if AFFINE {
                    sum = fma::<FMA>(s.weight[2][k] * s.arm[2][k], q2, sum);
                }
                momenta[k] = sum;
            }
            if FORCES {
                let forces = &mut tile.force[row..row + W];
                for k in 0..W {
                    forces[k] = fma::<FMA>(s.slope[2][k], h2, fma::<FMA>(s.weight[2][k], h0, forces[k]));
                }
            }
        }
    }
}
