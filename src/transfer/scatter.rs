//! Particles to grid.

use super::chunk::{CHUNK, Chunk, load};
use super::functions::{functions, inner_functions};
use super::gather::places;
use super::nodes;
use super::task::{Plan, ScatterTask, Sweep};
use crate::basis::Third;
use crate::grid::{Lanes, Tile};
use crate::lanes::{LANES, Mask, Real};

/// The field that packets are for.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Field {
    /// Mass and momentum, with forces where they are merged.
    Momentum,
    Force,
}

/// Where the velocities and affine matrices of a chunk are.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Source {
    /// With the particles.
    Rows,
    /// In the chunk, where the gather of the same sweep put them.
    Chunk,
}

/// The middle node of a slot, whose e is minus the sum of the others.
const fn middle(width: usize) -> usize {
    width / 2
}

/// Makes the packets of `count` particles from `first` on, the first of which is number `at` of the chunk. Stresses are in the chunk.
///
/// # Safety
/// The rows are the caller's; there are at most [`LANES`].
#[inline(always)]
pub(super) unsafe fn pack<const D: usize, const W: usize, V: Real>(
    sweep: &Sweep,
    task: &ScatterTask,
    plan: &Plan,
    field: Field,
    source: Source,
    first: usize,
    at: usize,
    count: usize,
    chunk: &mut Chunk<W>,
) {
    let (rows, zero) = (&sweep.rows, V::splat(0.0));
    let momentum = field == Field::Momentum;
    let kick = match task.what {
        super::What::Kicked(kick) => Some(kick),
        _ => None,
    };
    let (affine, stress) = (momentum && sweep.model.needs.affine, !momentum || kick.is_some());
    let (axes, third) = (&sweep.model.axes, if affine { Third::Arm } else { Third::Nothing });
    let lines = if chunk.outside[at % CHUNK / LANES] & ((1u32 << count) - 1) as Mask == 0 {
        let mut xi = [zero; D];
        for a in 0..D {
            xi[a] = load(&chunk.xi[a], at);
        }
        inner_functions::<D, W, V>(axes, &plan.inner, &xi, third)
    } else {
        // SAFETY: the rows are ours.
        let (x, half) = unsafe { places::<D, V>(sweep, first, count) };
        functions::<D, W, V>(axes, &x, &half, third)
    };
    // SAFETY: a number a particle.
    let mass = unsafe { V::load_some(rows.mass.as_ptr().add(first), count) };
    let mut base = [zero; 4];
    if momentum {
        base[0] = mass;
        for a in 0..D {
            let velocity = match source {
                // SAFETY: the rows are ours.
                Source::Rows => unsafe { V::load_some(rows.velocity.at(a, first), count) },
                Source::Chunk => load(&chunk.velocity[a], at),
            };
            base[1 + a] = mass * velocity;
        }
    }
    if stress {
        for (a, of) in task.body_force.iter().enumerate() {
            // SAFETY: a number a particle.
            let force = mass * unsafe { V::load_some(of.as_ptr().add(first), count) };
            base[1 + a] = V::splat(kick.unwrap_or(1.0)).fma(force, base[1 + a]);
        }
    }
    V::turn(base, &mut chunk.packets[at % CHUNK / LANES].base);
    for slot in 3 - D..3 {
        for node in 0..W {
            lines[slot].value[node].store(&mut chunk.packets[at % CHUNK / LANES].value[slot][node]);
        }
        if !(affine || stress) {
            continue;
        }
        let axis = slot + D - 3;
        let (mut c, mut s) = ([zero; D], [zero; D]);
        for a in 0..D {
            if affine {
                c[a] = mass
                    * match source {
                        // SAFETY: the rows are ours, and there is an affine matrix.
                        Source::Rows => unsafe { V::load_some(rows.affine.at(D * a + axis, first), count) },
                        Source::Chunk => load(&chunk.affine[a][axis], at),
                    };
            }
            if stress {
                s[a] = load(&chunk.force[a][axis], at);
            }
        }
        for node in 0..W {
            if node == middle(W) {
                continue;
            }
            let mut more = [zero; 4];
            for a in 0..D {
                more[1 + a] = match (affine, stress) {
                    (true, true) => lines[slot].third[node].fma(c[a], lines[slot].slope[node] * s[a]),
                    (true, false) => lines[slot].third[node] * c[a],
                    _ => lines[slot].slope[node] * s[a],
                };
            }
            V::turn(more, &mut chunk.packets[at % CHUNK / LANES].more[slot][node]);
        }
    }
}

/// Adds the packets of the first `count` particles of the chunk to a field of the tile: run by run of particles in one cell, whose sums
/// stay in registers.
#[inline(always)]
pub(super) fn add<const D: usize, const W: usize, V: Real, const MORE: bool>(
    chunk: &Chunk<W>,
    count: usize,
    tile: &mut Tile,
    field: Field,
) {
    let stride = tile.frame.stride;
    let to = if field == Field::Momentum { &mut tile.momentum } else { &mut tile.force };
    let mut start = 0;
    while start < count.min(CHUNK) {
        let node = chunk.node[start];
        let mut end = start + 1;
        while end < count.min(CHUNK) && chunk.node[end] == node {
            end += 1;
        }
        let last = node as usize + (nodes::<D, W>(0) - 1) * stride[0] + (nodes::<D, W>(1) - 1) * stride[1] + W;
        assert!(last <= to.len(), "a tile covers the stencils of its particles");
        // SAFETY: the packets are there, and so are the nodes.
        unsafe { add_run::<D, W, V, MORE>(chunk, start, end, to.as_mut_ptr().add(node as usize), stride) };
        start = end;
    }
}

/// Adds the packets from `start` to below `end`, of one cell.
///
/// # Safety
/// The stencil from node `to` on may be written, and the particles are in the chunk.
#[inline(always)]
unsafe fn add_run<const D: usize, const W: usize, V: Real, const MORE: bool>(
    chunk: &Chunk<W>,
    start: usize,
    end: usize,
    to: *mut Lanes,
    stride: [usize; 2],
) {
    let zero = V::splat(0.0);
    // sums of two nodes in a row along slot 2
    let mut sums = [[[zero; 3]; W]; W];
    for l in start..end {
        // SAFETY: the particle is in the chunk.
        let (packets, lane) = unsafe { (chunk.packets.get_unchecked(l / LANES), l % LANES) };
        let slot = V::slot(lane);
        let mut n = [[0.0; W]; 2];
        for s in 0..2 {
            for k in 0..nodes::<D, W>(s) {
                // an unused slot has one function, 1
                n[s][k] = if s < 3 - D { 1.0 } else { packets.value[s][k][lane] };
            }
        }
        let base = V::both(&packets.base[slot]);
        for q in 0..W.div_ceil(2) {
            let pair = if 2 * q + 1 < W {
                V::pair(packets.value[2][2 * q][lane], packets.value[2][2 * q + 1][lane])
            } else {
                V::splat(packets.value[2][2 * q][lane])
            };
            // N_k b + e2_k
            let mut row = base * pair;
            let (mut e0, mut e1) = ([zero; W], [zero; W]);
            if MORE {
                row = base.fma(pair, along::<W, V>(packets, slot, q));
                if D == 3 {
                    e0 = across::<W, V>(packets, 0, slot, pair);
                }
                if D >= 2 {
                    e1 = across::<W, V>(packets, 1, slot, pair);
                }
            }
            for j in 0..nodes::<D, W>(1) {
                let weight = V::splat(n[1][j]);
                let mut plane = if D >= 2 { weight * row } else { row };
                if MORE && D >= 2 {
                    plane = weight.fma(row, e1[j]);
                }
                for i in 0..nodes::<D, W>(0) {
                    if D == 3 {
                        sums[i][j][q] = V::splat(n[0][i]).fma(plane, sums[i][j][q]);
                        if MORE {
                            sums[i][j][q] = weight.fma(e0[i], sums[i][j][q]);
                        }
                    } else {
                        sums[i][j][q] = sums[i][j][q] + plane;
                    }
                }
            }
        }
    }
    for i in 0..nodes::<D, W>(0) {
        for j in 0..nodes::<D, W>(1) {
            for q in 0..W.div_ceil(2) {
                // SAFETY: the caller's promise.
                unsafe {
                    let node = to.add(i * stride[0] + j * stride[1] + 2 * q).cast::<f64>();
                    if 2 * q + 1 < W { sums[i][j][q].add_to(node) } else { sums[i][j][q].add_lower_to(node) }
                }
            }
        }
    }
}

/// e2 at nodes 2q and 2q + 1 of a particle.
#[inline(always)]
fn along<const W: usize, V: Real>(packets: &super::chunk::Packets<W>, slot: usize, q: usize) -> V {
    let of = &packets.more[2];
    let mut rest = V::splat(0.0);
    if middle(W) / 2 == q {
        let mut first = true;
        for node in 0..W {
            if node != middle(W) {
                let e = V::both(&of[node][slot]);
                rest = if first { e } else { rest + e };
                first = false;
            }
        }
        rest = -rest;
    }
    let at = |node: usize| if node == middle(W) { rest } else { V::both(&of[node][slot]) };
    if 2 * q + 1 < W { at(2 * q).select(0x0f, at(2 * q + 1)) } else { at(2 * q) }
}

/// e of slot 0 or 1 times N at two nodes along slot 2.
#[inline(always)]
fn across<const W: usize, V: Real>(packets: &super::chunk::Packets<W>, s: usize, slot: usize, pair: V) -> [V; W] {
    let mut e = [V::splat(0.0); W];
    let mut rest = V::splat(0.0);
    let mut first = true;
    for node in 0..W {
        if node != middle(W) {
            e[node] = V::both(&packets.more[s][node][slot]) * pair;
            rest = if first { e[node] } else { rest + e[node] };
            first = false;
        }
    }
    e[middle(W)] = -rest;
    e
}
