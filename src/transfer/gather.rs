//! Grid to particles.

use super::chunk::{Chunk, store};
use super::functions::{Line, functions};
use super::task::{Plan, Sweep};
use super::{Rows, nodes};
use crate::basis::Third;
use crate::grid::{Lanes, Tile};
use crate::lanes::{LANES, Real};

/// Takes the fields of the grid to `count` particles from `first` on, the first of which is number `at` of the chunk. All are in one cell.
///
/// # Safety
/// The rows are the caller's, and the tile covers their stencils; there are at most [`LANES`].
#[inline(always)]
pub(super) unsafe fn gather<const D: usize, const W: usize, V: Real, const GRADIENT: bool, const AFFINE: bool, const INCREMENT: bool>(
    sweep: &Sweep,
    plan: &Plan,
    first: usize,
    at: usize,
    count: usize,
    tile: &Tile,
    chunk: &mut Chunk<W>,
) {
    let third = if AFFINE { Third::Affine } else { Third::Nothing };
    // SAFETY: the rows are ours.
    let (x, half) = unsafe { places::<D, V>(sweep, first, count) };
    let [f0, f1, f2] = functions::<D, W, V>(&sweep.model.axes, &plan.inner, &x, &half, third);
    let node = chunk.node[at] as usize;
    for component in 0..D {
        let taken = interpolate::<D, W, V, GRADIENT, AFFINE>(&f0, &f1, &f2, tile, &tile.momentum, node, 1 + component);
        store(&mut chunk.velocity[component], at, taken.value);
        for axis in 0..D {
            if GRADIENT {
                store(&mut chunk.gradient[component][axis], at, taken.slope[3 - D + axis]);
            }
            if AFFINE {
                store(&mut chunk.affine[component][axis], at, taken.third[3 - D + axis]);
            }
        }
    }
    if INCREMENT {
        // the mark is of use only to particles that may separate
        let marked = sweep.gather.is_some_and(|task| task.separation > 0.0);
        for lane in usize::from(!marked)..=D {
            let taken = interpolate::<D, W, V, false, false>(&f0, &f1, &f2, tile, &tile.force, node, lane);
            store(&mut chunk.acceleration[lane], at, taken.value);
        }
    }
}

/// Position and half-length of the domain of up to eight particles by axis; lanes beyond `count` are like the first.
///
/// # Safety
/// The rows are the caller's; `count` is at least 1 and at most [`LANES`].
#[inline(always)]
pub(super) unsafe fn places<const D: usize, V: Real>(sweep: &Sweep, first: usize, count: usize) -> ([V; D], [V; D]) {
    let rows: &Rows = &sweep.rows;
    let zero = V::splat(0.0);
    let (mut x, mut half) = ([zero; D], [zero; D]);
    for a in 0..D {
        // SAFETY: the rows are ours.
        x[a] = unsafe { V::load_some(rows.position.at(a, first), count) };
        if count < LANES {
            x[a] = x[a].select(((1u32 << count) - 1) as u8, V::splat(x[a].first()));
        }
    }
    if sweep.model.domains.is_some() {
        // SAFETY: the rows are ours.
        let places = unsafe { rows.places::<D>(sweep.model, first, first + count) };
        for a in 0..D {
            half[a] = V::load(&places.half[a]);
        }
    }
    (x, half)
}

/// A component of a field at eight particles.
struct Taken<V> {
    value: V,
    /// Its derivative by slot.
    slope: [V; 3],
    /// The sum with the affine weights, by slot.
    third: [V; 3],
}

/// Sums over the stencil, slot by slot: what is common to a row of nodes is computed once a row.
#[inline(always)]
fn interpolate<const D: usize, const W: usize, V: Real, const GRADIENT: bool, const AFFINE: bool>(
    f0: &Line<V, W>,
    f1: &Line<V, W>,
    f2: &Line<V, W>,
    tile: &Tile,
    field: &[Lanes],
    node: usize,
    lane: usize,
) -> Taken<V> {
    let zero = V::splat(0.0);
    let stride = tile.frame.stride;
    let last = node + (nodes::<D, W>(0) - 1) * stride[0] + (nodes::<D, W>(1) - 1) * stride[1] + W;
    assert!(last <= field.len(), "a tile covers the stencils of its particles");
    let (mut value, mut slope, mut third) = (zero, [zero; 3], [zero; 3]);
    for i in 0..nodes::<D, W>(0) {
        // sums over slots 1 and 2: value; derivative along slot 1, slot 2; moment along slot 1, slot 2
        let (mut v, mut d1, mut d2, mut m1, mut m2) = (zero, zero, zero, zero, zero);
        for j in 0..nodes::<D, W>(1) {
            let start = node + i * stride[0] + j * stride[1];
            // SAFETY: see above.
            let row = unsafe { &*field.as_ptr().add(start).cast::<[Lanes; W]>() };
            let first = V::splat(row[0][lane]);
            let (mut sum, mut sloped, mut turned) = (f2.value[0] * first, zero, zero);
            if GRADIENT {
                sloped = f2.slope[0] * first;
            }
            if AFFINE {
                turned = f2.third[0] * first;
            }
            for k in 1..W {
                let next = V::splat(row[k][lane]);
                sum = f2.value[k].fma(next, sum);
                if GRADIENT {
                    sloped = f2.slope[k].fma(next, sloped);
                }
                if AFFINE {
                    turned = f2.third[k].fma(next, turned);
                }
            }
            if D == 1 {
                (v, d2, m2) = (sum, sloped, turned);
            } else if j == 0 {
                v = f1.value[0] * sum;
                if GRADIENT {
                    (d1, d2) = (f1.slope[0] * sum, f1.value[0] * sloped);
                }
                if AFFINE {
                    (m1, m2) = (f1.third[0] * sum, f1.value[0] * turned);
                }
            } else {
                v = f1.value[j].fma(sum, v);
                if GRADIENT {
                    (d1, d2) = (f1.slope[j].fma(sum, d1), f1.value[j].fma(sloped, d2));
                }
                if AFFINE {
                    (m1, m2) = (f1.third[j].fma(sum, m1), f1.value[j].fma(turned, m2));
                }
            }
        }
        if D < 3 {
            (value, slope, third) = (v, [zero, d1, d2], [zero, m1, m2]);
        } else if i == 0 {
            value = f0.value[0] * v;
            if GRADIENT {
                slope = [f0.slope[0] * v, f0.value[0] * d1, f0.value[0] * d2];
            }
            if AFFINE {
                third = [f0.third[0] * v, f0.value[0] * m1, f0.value[0] * m2];
            }
        } else {
            value = f0.value[i].fma(v, value);
            if GRADIENT {
                slope = [f0.slope[i].fma(v, slope[0]), f0.value[i].fma(d1, slope[1]), f0.value[i].fma(d2, slope[2])];
            }
            if AFFINE {
                third = [f0.third[i].fma(v, third[0]), f0.value[i].fma(m1, third[1]), f0.value[i].fma(m2, third[2])];
            }
        }
    }
    Taken { value, slope, third }
}
