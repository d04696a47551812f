//! Particles to grid.

use super::chunk::{CHUNK, Chunk, load};
use super::functions::{functions, inner_functions};
use super::gather::{locate, places};
use super::task::{Plan, ScatterTask, Sweep};
use super::update::Eight;
use super::{nodes, update};
use crate::basis::Third;
use crate::grid::{Frame, Lanes, Tile};
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

/// Makes the packets of `count` particles from `first` on, the first of which is number `at` of the chunk.
///
/// # Safety
/// The rows are the caller's; there are at most [`LANES`].
#[inline(always)]
pub(super) unsafe fn pack<const D: usize, const W: usize, V: Real>(
    sweep: &Sweep,
    task: &ScatterTask,
    plan: &Plan<W>,
    field: Field,
    source: Source,
    eight: &Eight<V, D>,
    first: usize,
    at: usize,
    count: usize,
    frame: &Frame,
    chunk: &mut Chunk<W>,
) {
    let (rows, axes, zero) = (&sweep.rows, &sweep.model.axes, V::splat(0.0));
    let momentum = field == Field::Momentum;
    let kick = match task.what {
        super::What::Kicked(kick) => Some(kick),
        _ => None,
    };
    let affine = momentum && sweep.model.needs.affine;
    let stressed = !momentum || task.packs_stress(affine);
    let mut stress = [[zero; D]; D];
    if stressed {
        // SAFETY: the rows are ours.
        stress = unsafe { update::stress::<D, W, V>(sweep, plan, kick.unwrap_or(1.0), task.relieved, eight, first, at, count, chunk) };
    }
    // SAFETY: the rows are ours.
    let xi = unsafe { locate::<D, W, V>(sweep, plan, &eight.position, first, at, count, frame, chunk) };
    let third = if affine { Third::Arm } else { Third::Nothing };
    let lines = if chunk.outside[at % CHUNK / LANES] & ((1u32 << count) - 1) as Mask == 0 {
        inner_functions::<D, W, V>(&plan.tables, &xi, third)
    } else {
        // SAFETY: the rows are ours.
        let (x, half) = unsafe { places::<D, V>(sweep, first, count) };
        functions::<D, W, V>(axes, plan, &x, &half, third)
    };
    // SAFETY: a number a particle.
    let mass = unsafe { V::load_some(rows.mass(first), count) };
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
    if kick.is_some() || !momentum {
        // SAFETY: the rows are ours.
        unsafe { push::<V>(task, kick.unwrap_or(1.0), mass, &mut base, first, count) };
    }
    V::turn(base, &mut chunk.packets[at % CHUNK / LANES].base);
    for slot in 3 - D..3 {
        for node in 0..W {
            lines[slot].value[node].store(&mut chunk.packets[at % CHUNK / LANES].value[slot][node]);
        }
        if !(affine || stressed) {
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
            s[a] = stress[a][axis];
        }
        let mut rest = [zero; 4];
        for node in 0..W {
            if node == middle(W) {
                continue;
            }
            let mut more = [zero; 4];
            for a in 0..D {
                more[1 + a] = match (affine, stressed) {
                    (true, true) => lines[slot].third[node].fma(c[a], lines[slot].slope[node] * s[a]),
                    (true, false) => lines[slot].third[node] * c[a],
                    _ => lines[slot].slope[node] * s[a],
                };
                rest[1 + a] = rest[1 + a] - more[1 + a];
            }
            V::turn(more, &mut chunk.packets[at % CHUNK / LANES].more[slot][node]);
        }
        if slot == 2 {
            V::turn(rest, &mut chunk.packets[at % CHUNK / LANES].more[slot][middle(W)]);
        }
    }
}

/// Adds body forces times `scale` to what goes to the nodes by value.
///
/// # Safety
/// The rows are the caller's; there are at most [`LANES`].
#[inline(always)]
unsafe fn push<V: Real>(task: &ScatterTask, scale: f64, mass: V, base: &mut [V; 4], first: usize, count: usize) {
    for (a, of) in task.body_force.iter().enumerate() {
        // SAFETY: a number a particle.
        let force = mass * unsafe { V::load_some(of.as_ptr().add(first), count) };
        base[1 + a] = V::splat(scale).fma(force, base[1 + a]);
    }
}

/// Makes packets of momentum, packed with the stress, those of forces.
///
/// # Safety
/// As [`pack`].
#[inline(always)]
pub(super) unsafe fn repack<const W: usize, V: Real>(
    sweep: &Sweep,
    task: &ScatterTask,
    first: usize,
    at: usize,
    count: usize,
    chunk: &mut Chunk<W>,
) {
    let mut base = [V::splat(0.0); 4];
    // SAFETY: the rows are ours.
    unsafe {
        let mass = V::load_some(sweep.rows.mass(first), count);
        push::<V>(task, 1.0, mass, &mut base, first, count);
    }
    V::turn(base, &mut chunk.packets[at % CHUNK / LANES].base);
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
    while start < count {
        let end = chunk.end_of_run(start, count);
        let node = chunk.node[start % CHUNK] as usize;
        let last = node + (nodes::<D, W>(0) - 1) * stride[0] + (nodes::<D, W>(1) - 1) * stride[1] + W;
        assert!(last <= to.len(), "a tile covers the stencils of its particles");
        // SAFETY: the packets are there, and so are the nodes.
        unsafe {
            let to = to.as_mut_ptr().add(node);
            // of functions far from the ends the middle one is nowhere small, so that it may be what the others leave of all
            if W > 2 && chunk.is_inner(start) {
                add_run::<D, W, V, MORE, true>(chunk, start, end, to, stride);
            } else {
                add_run::<D, W, V, MORE, false>(chunk, start, end, to, stride);
            }
        }
        start = end;
    }
}

/// Adds the packets from `start` to below `end`, of one cell. Where `ALL` is set, what goes to all nodes along slot 0 or 1 is summed in
/// the place of the middle one, which gets what the others leave of it.
///
/// # Safety
/// The stencil from node `to` on may be written, and the particles are in the chunk.
#[inline(always)]
unsafe fn add_run<const D: usize, const W: usize, V: Real, const MORE: bool, const ALL: bool>(
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
        let base = V::both(&packets.base[slot]);
        for q in 0..W.div_ceil(2) {
            let (k, is_pair) = (2 * q, 2 * q + 1 < W);
            let n2 = &packets.value[2];
            let pair = if is_pair { V::pair(n2[k][lane], n2[k + 1][lane]) } else { V::splat(n2[k][lane]) };
            // N_k b + e2_k
            let e2 = &packets.more[2];
            let row = match (MORE, is_pair) {
                (true, true) => base.fma(pair, V::halves(&e2[k][slot], &e2[k + 1][slot])),
                (true, false) => base.fma(pair, V::both(&e2[k][slot])),
                (false, _) => base * pair,
            };
            // the same along slot 1
            let mut rows = [row; W];
            if D >= 2 {
                let e1 = if MORE { across::<W, V, ALL>(packets, 1, slot, pair) } else { [zero; W] };
                for j in 0..W {
                    if !(ALL && j == middle(W)) {
                        let weight = V::splat(packets.value[1][j][lane]);
                        rows[j] = if MORE { weight.fma(row, e1[j]) } else { weight * row };
                    }
                }
            }
            if D < 3 {
                for j in 0..nodes::<D, W>(1) {
                    sums[0][j][q] = sums[0][j][q] + rows[j];
                }
                continue;
            }
            let e0 = if MORE { across::<W, V, ALL>(packets, 0, slot, pair) } else { [zero; W] };
            for i in 0..W {
                for j in 0..W {
                    if ALL && i == middle(W) {
                        sums[i][j][q] = sums[i][j][q] + rows[j];
                        continue;
                    }
                    if MORE && ALL && j == middle(W) {
                        sums[i][j][q] = sums[i][j][q] + e0[i];
                    } else if MORE {
                        sums[i][j][q] = e0[i].fma(V::splat(packets.value[1][j][lane]), sums[i][j][q]);
                    }
                    sums[i][j][q] = rows[j].fma(V::splat(packets.value[0][i][lane]), sums[i][j][q]);
                }
            }
        }
    }
    for q in 0..W.div_ceil(2) {
        if ALL && D >= 2 {
            for i in 0..nodes::<D, W>(0) {
                for j in 0..W {
                    if j != middle(W) {
                        sums[i][middle(W)][q] = sums[i][middle(W)][q] - sums[i][j][q];
                    }
                }
            }
        }
        if ALL && D == 3 {
            for j in 0..W {
                for i in 0..W {
                    if i != middle(W) {
                        sums[middle(W)][j][q] = sums[middle(W)][j][q] - sums[i][j][q];
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

/// e of slot 0 or 1 times N at two nodes along slot 2; the middle one only where it does not stand for all.
#[inline(always)]
fn across<const W: usize, V: Real, const ALL: bool>(packets: &super::chunk::Packets<W>, s: usize, slot: usize, pair: V) -> [V; W] {
    let zero = V::splat(0.0);
    let (mut e, mut rest) = ([zero; W], zero);
    for node in 0..W {
        if node != middle(W) {
            e[node] = V::both(&packets.more[s][node][slot]) * pair;
            rest = rest - e[node];
        }
    }
    if !ALL {
        e[middle(W)] = rest;
    }
    e
}
