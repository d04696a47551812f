//! Internal forces of a lattice of points, strip by strip: eight neighbouring cells along one axis are the lanes of a vector, and sums are
//! factorised axis by axis (as in Kronbichler and Kormann 2012, A generic interface for parallel cell-based finite element operator
//! application), so that a point costs a few functions an axis instead of their product.
//!
//! A strip is followed along the first axis. Sums over the other axes belong to a layer of nodes, and are made once for all `W` cells along the
//! way that see it; what the cells push goes the same way back.

use super::law::{Kernel, Law, Seen};
use super::{Block, Lattice, Line, WideLine};
use crate::total::wide::{LANES, Wide};
use std::ops::Range;

/// Memory of one sweep: nothing in it is remembered.
#[derive(Debug, Clone, Default)]
pub(super) struct Scratch<const D: usize> {
    /// Sums over nodes of the layers at hand: fields (value, slope along the lanes, slope along the third axis) of each component.
    layers: Vec<Block<D>>,
    /// What the points push there.
    pushes: Vec<Block<D>>,
    /// Displacement gradients at the points of a strip of cells, then stresses.
    points: Vec<Block<D>>,
}

/// A part of a body whose internal forces are summed in one go.
pub(super) struct Piece<'a, const D: usize> {
    /// Its cells along the axis that bodies are cut across: the third, in a plane the first.
    pub(super) cells: Range<usize>,
    /// Displacement from the first layer of nodes on \[m\].
    pub(super) displacement: &'a [f64],
    /// Forces from the first layer of nodes on \[N\], to be added to.
    pub(super) force: &'a mut [f64],
    pub(super) scratch: &'a mut Scratch<D>,
    pub(super) seen: &'a mut Seen,
}

/// Adds the internal forces of a piece. Unsafe to call where the processor lacks the instructions that it was chosen for.
pub(super) type Sweep<const D: usize, const W: usize> = unsafe fn(&Lattice<D, W>, &Law, Kernel<D>, Piece<'_, D>);

#[inline(always)]
fn sweep<V: Wide, const D: usize, const W: usize>(lattice: &Lattice<D, W>, law: &Law, kernel: Kernel<D>, piece: Piece<'_, D>) {
    let Piece { cells, displacement, force, scratch, seen } = piece;
    let [q0, q1, q2] = lattice.points;
    scratch.layers.resize(W * q1 * q2, super::zero());
    scratch.pushes.resize(W * q1 * q2, super::zero());
    scratch.points.resize(q0 * q1 * q2, super::zero());
    let columns = if D > 2 { cells.len() } else { 1 };
    for column in 0..columns {
        let across = if D > 2 { &lattice.lines[1][(cells.start + column) * q2..][..q2] } else { &lattice.lines[1][..0] };
        let along = if D > 2 { &lattice.lines[0][..] } else { &lattice.lines[0][cells.start * q0..cells.end * q0] };
        for (strip, lanes) in lattice.lanes.chunks_exact(q1).enumerate() {
            let way = Way { across, along, lanes, start: column * lattice.strides[2] + strip * LANES };
            march::<V, D, W>(lattice, law, kernel, &way, displacement, force, scratch, seen);
        }
    }
}

/// A strip of eight cells and its way through the body.
struct Way<'a, const W: usize> {
    /// Functions along the third axis, by point.
    across: &'a [[Line<W>; 2]],
    /// Functions along the way, by cell and point.
    along: &'a [[Line<W>; 2]],
    /// Functions along the lanes, by point.
    lanes: &'a [[WideLine<W>; 2]],
    /// Place of its first node.
    start: usize,
}

#[inline(always)]
fn march<V: Wide, const D: usize, const W: usize>(
    lattice: &Lattice<D, W>,
    law: &Law,
    kernel: Kernel<D>,
    way: &Way<'_, W>,
    displacement: &[f64],
    force: &mut [f64],
    scratch: &mut Scratch<D>,
    seen: &mut Seen,
) {
    let [q0, q1, q2] = lattice.points;
    let pairs = q1 * q2;
    let cells = way.along.len() / q0;
    for layer in 0..W - 1 {
        gather::<V, D, W>(lattice, way, displacement, layer, &mut scratch.layers[layer * pairs..][..pairs]);
    }
    for cell in 0..cells {
        let last = (cell + W - 1) % W;
        gather::<V, D, W>(lattice, way, displacement, cell + W - 1, &mut scratch.layers[last * pairs..][..pairs]);
        let along = &way.along[cell * q0..][..q0];
        for pair in 0..pairs {
            deform::<V, D, W>(&scratch.layers, pairs, pair, cell, along, &mut scratch.points[pair * q0..][..q0]);
        }
        // SAFETY: this kernel was chosen for the same instructions as the one it is called from
        unsafe { kernel(law, &mut scratch.points, seen) };
        for pair in 0..pairs {
            push::<V, D, W>(&mut scratch.pushes, pairs, pair, cell, along, &scratch.points[pair * q0..][..q0]);
        }
        scatter::<V, D, W>(lattice, way, force, cell, &scratch.pushes[cell % W * pairs..][..pairs]);
    }
    for layer in cells..cells + W - 1 {
        scatter::<V, D, W>(lattice, way, force, layer, &scratch.pushes[layer % W * pairs..][..pairs]);
    }
}

/// Lines of nodes along the third axis that a cell sees.
const fn lines(d: usize, w: usize) -> usize {
    if d > 2 { w } else { 1 }
}

/// Sums over the nodes of a layer.
#[inline(always)]
fn gather<V: Wide, const D: usize, const W: usize>(
    lattice: &Lattice<D, W>,
    way: &Way<'_, W>,
    displacement: &[f64],
    layer: usize,
    sums: &mut [Block<D>],
) {
    let [_, q1, q2] = lattice.points;
    let [first, second, third] = lattice.strides;
    for d in 0..D {
        let at = way.start + layer * first + d * second;
        let mut u = [[V::zero(); W]; W];
        for a in 0..lines(D, W) {
            for c in 0..W {
                u[a][c] = V::load_at(displacement, at + a * third + c);
            }
        }
        for (q, [lane, _]) in way.lanes.iter().enumerate() {
            let (mut value, mut slope) = ([V::zero(); W], [V::zero(); W]);
            for a in 0..lines(D, W) {
                value[a] = V::load(&lane.weight[0]).mul(u[a][0]);
                slope[a] = V::load(&lane.slope[0]).mul(u[a][0]);
                for c in 1..W {
                    value[a] = V::load(&lane.weight[c]).fma(u[a][c], value[a]);
                    slope[a] = V::load(&lane.slope[c]).fma(u[a][c], slope[a]);
                }
            }
            if D > 2 {
                for r in 0..q2 {
                    let [across, _] = &way.across[r];
                    let (weight, steep) = (V::splat(across.weight[0]), V::splat(across.slope[0]));
                    let (mut all, mut along, mut third) = (weight.mul(value[0]), weight.mul(slope[0]), steep.mul(value[0]));
                    for a in 1..W {
                        let (weight, steep) = (V::splat(across.weight[a]), V::splat(across.slope[a]));
                        all = weight.fma(value[a], all);
                        along = weight.fma(slope[a], along);
                        third = steep.fma(value[a], third);
                    }
                    let sum = &mut sums[r * q1 + q];
                    all.store(&mut sum[0][d]);
                    along.store(&mut sum[1][d]);
                    third.store(&mut sum[D - 1][d]);
                }
            } else {
                value[0].store(&mut sums[q][0][d]);
                slope[0].store(&mut sums[q][1][d]);
            }
        }
    }
}

/// Displacement gradients at the points of a cell that share their place across the way.
#[inline(always)]
fn deform<V: Wide, const D: usize, const W: usize>(
    layers: &[Block<D>],
    pairs: usize,
    pair: usize,
    cell: usize,
    along: &[[Line<W>; 2]],
    points: &mut [Block<D>],
) {
    for (point, [line, _]) in points.iter_mut().zip(along) {
        let mut gradient = [[V::zero(); D]; D];
        for b in 0..W {
            let layer = &layers[(cell + b) % W * pairs + pair];
            let (weight, slope) = (V::splat(line.weight[b]), V::splat(line.slope[b]));
            for k in 0..D {
                let share = if k == 0 { slope } else { weight };
                for i in 0..D {
                    gradient[k][i] = share.fma(V::load(&layer[k][i]), gradient[k][i]);
                }
            }
        }
        for k in 0..D {
            for i in 0..D {
                gradient[k][i].store(&mut point[k][i]);
            }
        }
    }
}

/// The way back of [`deform`].
#[inline(always)]
fn push<V: Wide, const D: usize, const W: usize>(
    pushes: &mut [Block<D>],
    pairs: usize,
    pair: usize,
    cell: usize,
    along: &[[Line<W>; 2]],
    points: &[Block<D>],
) {
    for b in 0..W {
        let to = &mut pushes[(cell + b) % W * pairs + pair];
        let mut sums = [[V::zero(); D]; D];
        // the last layer, and at the start all, have not been pushed yet
        if cell > 0 && b + 1 < W {
            for k in 0..D {
                for i in 0..D {
                    sums[k][i] = V::load(&to[k][i]);
                }
            }
        }
        for (point, [_, line]) in points.iter().zip(along) {
            let (weight, slope) = (V::splat(line.weight[b]), V::splat(line.slope[b]));
            for k in 0..D {
                let share = if k == 0 { slope } else { weight };
                for i in 0..D {
                    sums[k][i] = share.fma(V::load(&point[k][i]), sums[k][i]);
                }
            }
        }
        for k in 0..D {
            for i in 0..D {
                sums[k][i].store(&mut to[k][i]);
            }
        }
    }
}

/// The way back of [`gather`].
#[inline(always)]
fn scatter<V: Wide, const D: usize, const W: usize>(
    lattice: &Lattice<D, W>,
    way: &Way<'_, W>,
    force: &mut [f64],
    layer: usize,
    pushes: &[Block<D>],
) {
    let [_, q1, q2] = lattice.points;
    let [first, second, third] = lattice.strides;
    for d in 0..D {
        let mut out = [[V::zero(); W]; W];
        for (q, [_, lane]) in way.lanes.iter().enumerate() {
            let (mut value, mut slope) = ([V::zero(); W], [V::zero(); W]);
            if D > 2 {
                for r in 0..q2 {
                    let [_, across] = &way.across[r];
                    let pushed = &pushes[r * q1 + q];
                    let (all, along, third) = (V::load(&pushed[0][d]), V::load(&pushed[1][d]), V::load(&pushed[D - 1][d]));
                    for a in 0..W {
                        let (weight, steep) = (V::splat(across.weight[a]), V::splat(across.slope[a]));
                        value[a] = weight.fma(all, steep.fma(third, value[a]));
                        slope[a] = weight.fma(along, slope[a]);
                    }
                }
            } else {
                value[0] = V::load(&pushes[q][0][d]);
                slope[0] = V::load(&pushes[q][1][d]);
            }
            for a in 0..lines(D, W) {
                for c in 0..W {
                    let steep = V::load(&lane.slope[c]).fma(slope[a], out[a][c]);
                    out[a][c] = V::load(&lane.weight[c]).fma(value[a], steep);
                }
            }
        }
        let at = way.start + layer * first + d * second;
        // neighbours along the lanes overlap: one line after the other, so that what was stored last is not loaded at once
        for c in 0..W {
            for a in 0..lines(D, W) {
                let place = at + a * third + c;
                V::load_at(force, place).add(out[a][c]).store_at(force, place);
            }
        }
    }
}

macro_rules! sweeps {
    ($module:ident, $vector:ty $(, $features:literal)?) => {
        mod $module {
            use super::{Kernel, Lattice, Law, Piece};
            $(#[target_feature(enable = $features)])?
            pub(super) fn sweep<const D: usize, const W: usize>(
                lattice: &Lattice<D, W>,
                law: &Law,
                kernel: Kernel<D>,
                piece: Piece<'_, D>,
            ) {
                super::sweep::<$vector, D, W>(lattice, law, kernel, piece);
            }
        }
    };
}
#[cfg(target_arch = "x86_64")]
sweeps!(avx512, crate::total::wide::Avx512, "avx512f");
#[cfg(target_arch = "x86_64")]
sweeps!(avx2, crate::total::wide::Avx2, "avx2,fma");
sweeps!(portable, crate::total::wide::Portable);

/// The sweep for these instructions.
pub(super) fn choose<const D: usize, const W: usize>(instructions: crate::total::wide::Instructions) -> Sweep<D, W> {
    use crate::total::wide::Instructions;
    match instructions {
        #[cfg(target_arch = "x86_64")]
        Instructions::Avx512 => avx512::sweep::<D, W>,
        #[cfg(target_arch = "x86_64")]
        Instructions::Avx2 => avx2::sweep::<D, W>,
        Instructions::Portable => portable::sweep::<D, W>,
    }
}
