//! Particles to grid.

use super::chunk::{CHUNK, Chunk, Packets, load};
use super::functions::{Local, functions, inner_functions};
use super::gather::{locate, positions};
use super::task::{Plan, ScatterTask, Sweep};
use super::{middle, nodes};
use crate::basis::Third;
use crate::grid::{Frame, Lanes, Tile};
use crate::lanes::{LANES, Real, Wide};

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

/// The same for each node of up to six.
macro_rules! each {
    ($node:ident of $width:ident, $body:block) => {
        each!($node of $width, $body, 0 1 2 3 4 5)
    };
    ($node:ident of $width:ident, $body:block, $($number:literal)*) => {
        $(if const { $number < $width } {
            let $node = $number;
            $body
        })*
    };
}

/// Makes the packets of `count` particles from `first` on, the first of which is number `at` of the chunk.
///
/// # Safety
/// The rows are the caller's; there are at most as many as lanes.
#[inline(always)]
pub(super) unsafe fn pack<const D: usize, const W: usize, V: Real>(
    sweep: &Sweep,
    task: &ScatterTask,
    plan: &Plan<W>,
    [momentum, affine, stressed]: [bool; 3],
    source: Source,
    first: usize,
    at: usize,
    count: usize,
    frame: &Frame,
    chunk: &mut Chunk<W, V>,
) {
    let (rows, zero) = (&sweep.rows, V::splat(0.0));
    let kick = match task.what {
        super::What::Kicked(kick) => Some(kick),
        _ => None,
    };
    let Chunk { fields, packets, .. } = chunk;
    let packets = &mut packets[at % CHUNK / V::LANES];
    let wide = V::Wide::splat(0.0);
    let (mut xi, mut length, mut mass) = ([[wide; 2]; D], [[wide; 2]; D], [wide; 2]);
    for eight in 0..V::EIGHTS {
        let start = eight * LANES;
        if start >= count {
            // lanes of no particle
            fields.set_outside(at + start, 0);
            continue;
        }
        let (row, some) = (first + start, LANES.min(count - start));
        // SAFETY: the rows are ours.
        unsafe {
            let x = positions::<D, V::Wide>(sweep, row, some);
            let of = locate::<D, W, V::Wide, V::Number>(sweep, plan, &x, row, at + start, some, frame, fields);
            for a in 0..D {
                (xi[a][eight], length[a][eight]) = (of.xi[a], of.length[a]);
            }
            mass[eight] = V::Wide::load_some(rows.mass(row), some);
        }
    }
    let mut local = Local { xi: [zero; D], length: [zero; D] };
    for a in 0..D {
        (local.xi[a], local.length[a]) = (V::join(xi[a]), V::join(length[a]));
    }
    let third = if affine { Third::Arm } else { Third::Nothing };
    let lines = if fields.are_inner(at, count) {
        inner_functions::<D, W, V>(plan, &local, third)
    } else {
        // SAFETY: the rows are ours.
        unsafe { functions::<D, W, V>(sweep, plan, first, count, third) }
    };
    let mass = V::join(mass);
    let mut base = [zero; 4];
    if momentum {
        base[0] = mass;
        for a in 0..D {
            let velocity = match source {
                // SAFETY: the rows are ours.
                Source::Rows => unsafe { some::<V>(rows.velocity.at(a, first), count) },
                Source::Chunk => load(&fields.velocity[a], at),
            };
            base[1 + a] = mass * velocity;
        }
    }
    if kick.is_some() || !momentum {
        // SAFETY: the rows are ours.
        unsafe { push::<V>(task, kick.unwrap_or(1.0), mass, &mut base, first, count) };
    }
    V::turn(base, &mut packets.base);
    for slot in 3 - D..3 {
        for node in 0..W {
            lines[slot].value[node].store_lanes(&mut packets.value[slot][node]);
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
                        Source::Rows => unsafe { some::<V>(rows.affine.at(D * a + axis, first), count) },
                        Source::Chunk => load(&fields.affine[a][axis], at),
                    };
            }
            if stressed {
                s[a] = load(&fields.force[a.min(axis)][a.max(axis)], at);
            }
        }
        let mut rest = [zero; 4];
        // one by one: a loop is left a loop, which reads the functions from memory
        each!(node of W, {
            if node != middle(W) {
                let mut more = [zero; 4];
                for a in 0..D {
                    more[1 + a] = match (affine, stressed) {
                        (true, true) => lines[slot].third[node].fma(c[a], lines[slot].slope[node] * s[a]),
                        (true, false) => lines[slot].third[node] * c[a],
                        _ => lines[slot].slope[node] * s[a],
                    };
                    rest[1 + a] = rest[1 + a] - more[1 + a];
                }
                V::turn(more, &mut packets.more[slot][node]);
            }
        });
        if slot == 2 {
            V::turn(rest, &mut packets.more[slot][middle(W)]);
        }
    }
}

/// Numbers of `count` particles in memory, zeros in the other lanes.
///
/// # Safety
/// They may be read; there are at most as many as lanes.
#[inline(always)]
unsafe fn some<V: Real>(from: *const f64, count: usize) -> V {
    let mut eights = [V::Wide::splat(0.0); 2];
    for eight in 0..V::EIGHTS {
        let start = eight * LANES;
        // SAFETY: the caller's promise.
        eights[eight] = unsafe { V::Wide::load_some(from.wrapping_add(start), count.saturating_sub(start).min(LANES)) };
    }
    V::join(eights)
}

/// Adds body forces times `scale` to what goes to the nodes by value.
///
/// # Safety
/// The rows are the caller's; there are at most as many as lanes.
#[inline(always)]
unsafe fn push<V: Real>(task: &ScatterTask, scale: f64, mass: V, base: &mut [V; 4], first: usize, count: usize) {
    for (a, of) in task.body_force.iter().enumerate() {
        // SAFETY: a number a particle.
        let force = mass * unsafe { some::<V>(of.as_ptr().add(first), count) };
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
    chunk: &mut Chunk<W, V>,
) {
    let mut base = [V::splat(0.0); 4];
    // SAFETY: the rows are ours.
    unsafe {
        let mass = some::<V>(sweep.rows.mass(first), count);
        push::<V>(task, 1.0, mass, &mut base, first, count);
    }
    V::turn(base, &mut chunk.packets[at % CHUNK / V::LANES].base);
}

/// Adds the packets of the first `count` particles of the chunk to a field of the tile: run by run of particles in one cell, whose sums
/// stay in registers.
#[inline(always)]
pub(super) fn add<const D: usize, const W: usize, V: Real, const MORE: bool>(
    chunk: &Chunk<W, V>,
    count: usize,
    tile: &mut Tile,
    field: Field,
) {
    let stride = tile.frame.stride;
    let to = if field == Field::Momentum { &mut tile.momentum } else { &mut tile.force };
    let mut start = 0;
    while start < count {
        let end = chunk.fields.end_of_run(start, count);
        let node = chunk.fields.node[start % CHUNK] as usize;
        let last = node + (nodes::<D, W>(0) - 1) * stride[0] + (nodes::<D, W>(1) - 1) * stride[1] + W;
        assert!(last <= to.len(), "a tile covers the stencils of its particles");
        // SAFETY: the packets are there, and so are the nodes.
        unsafe {
            let to = to.as_mut_ptr().add(node);
            // of functions far from the ends the middle one is nowhere small, so that it may be what the others leave of all
            if W > 2 && chunk.fields.is_inner(start) {
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
    chunk: &Chunk<W, V>,
    start: usize,
    end: usize,
    to: *mut Lanes,
    stride: [usize; 2],
) {
    let zero = V::splat(0.0);
    let rows_of = const { W.div_ceil(V::NODES) };
    // sums of a row of nodes along slot 2 each
    let mut sums = [[[zero; 3]; W]; W];
    for l in start..end {
        // SAFETY: the particle is in the chunk.
        let (packets, lane) = unsafe { (chunk.packets.get_unchecked(l / V::LANES), l % V::LANES) };
        let base = V::at_all(packets.base(lane));
        for q in 0..rows_of {
            let (pair, e2) = row_of::<W, V, MORE>(packets, q, lane);
            // N_k b + e2_k
            let row = if MORE { base.fma(pair, e2) } else { base * pair };
            // the same along slot 1
            let mut rows = [row; W];
            if D >= 2 {
                let e1 = if MORE { across::<W, V, ALL>(packets, 1, lane, pair) } else { [zero; W] };
                for j in 0..W {
                    if !(ALL && j == middle(W)) {
                        let weight = V::all(packets.value(1, j, lane));
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
            let e0 = if MORE { across::<W, V, ALL>(packets, 0, lane, pair) } else { [zero; W] };
            for i in 0..W {
                for j in 0..W {
                    if ALL && i == middle(W) {
                        sums[i][j][q] = sums[i][j][q] + rows[j];
                        continue;
                    }
                    if MORE && ALL && j == middle(W) {
                        sums[i][j][q] = sums[i][j][q] + e0[i];
                    } else if MORE {
                        sums[i][j][q] = e0[i].fma(V::all(packets.value(1, j, lane)), sums[i][j][q]);
                    }
                    sums[i][j][q] = rows[j].fma(V::all(packets.value(0, i, lane)), sums[i][j][q]);
                }
            }
        }
    }
    for q in 0..rows_of {
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
            for q in 0..rows_of {
                // SAFETY: the caller's promise.
                unsafe {
                    sums[i][j][q].add_to(to.add(i * stride[0] + j * stride[1] + V::NODES * q).cast(), V::NODES.min(W - V::NODES * q))
                };
            }
        }
    }
}

/// N and e of slot 2 at number `q` of the rows of nodes along it.
#[inline(always)]
fn row_of<const W: usize, V: Real, const MORE: bool>(packets: &Packets<W, V>, q: usize, lane: usize) -> (V, V) {
    let k = V::NODES * q;
    let mut n = [V::Number::default(); 4];
    let mut e = [packets.more(2, k, lane); 4];
    for node in 0..4 {
        if node < V::NODES && k + node < W {
            n[node] = packets.value(2, k + node, lane);
            e[node] = packets.more(2, k + node, lane);
        }
    }
    let zero = V::splat(0.0);
    match V::NODES.min(W - k) {
        1 => (V::all(n[0]), if MORE { V::at_all(e[0]) } else { zero }),
        2 => (V::spread([n[0], n[1]]), if MORE { V::at_each([e[0], e[1]]) } else { zero }),
        3 => (V::spread([n[0], n[1], n[2]]), if MORE { V::at_each([e[0], e[1], e[2]]) } else { zero }),
        _ => (V::spread(n), if MORE { V::at_each(e) } else { zero }),
    }
}

/// e of slot 0 or 1 times N at a row of nodes along slot 2; the middle one only where it does not stand for all.
#[inline(always)]
fn across<const W: usize, V: Real, const ALL: bool>(packets: &Packets<W, V>, s: usize, lane: usize, pair: V) -> [V; W] {
    let zero = V::splat(0.0);
    let (mut e, mut rest) = ([zero; W], zero);
    for node in 0..W {
        if node != middle(W) {
            e[node] = V::at_all(packets.more(s, node, lane)) * pair;
            rest = rest - e[node];
        }
    }
    if !ALL {
        e[middle(W)] = rest;
    }
    e
}
