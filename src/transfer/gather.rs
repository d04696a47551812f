//! Grid to particles.

use super::chunk::{CELLS, CHUNK, Cell, Chunk, Fields, load, store};
use super::domains;
use super::functions::{self, Line, Local, functions, inner_functions};
use super::task::{GatherTask, Plan, Sweep};
use super::{middle, nodes, stencil};
use crate::basis::Third;
use crate::grid::{Frame, Lanes, Tile};
use crate::lanes::{LANES, Mask, Number, Real, Wide};

/// Particles that take from the grid together, a lane each: of one cell, or of two where some end in it and the others begin in the next.
#[derive(Clone, Copy)]
pub(super) struct Group {
    /// Number of the first particle in the chunk.
    pub(super) at: usize,
    /// Particles, at most as many as lanes.
    pub(super) count: usize,
    /// Particles of the first cell.
    pub(super) of_first: usize,
    /// Number of the first cell in the chunk.
    pub(super) cell: usize,
}

/// Takes the fields of the grid to the particles of a group, the first of which is in row `row`. Cells must have been [`share`]d.
///
/// # Safety
/// The rows are the caller's, and the tile covers their stencils. Of two cells both are shared, and forces are not needed.
#[inline(always)]
pub(super) unsafe fn gather<const D: usize, const W: usize, V: Real, const GRADIENT: bool, const AFFINE: bool, const TWO: bool>(
    sweep: &Sweep,
    plan: &Plan<W>,
    task: &GatherTask,
    row: usize,
    group: Group,
    tile: &Tile,
    chunk: &mut Chunk<W, V>,
) {
    let third = if AFFINE { Third::Affine } else { Third::Nothing };
    let Chunk { fields, cells, .. } = chunk;
    let at = group.at;
    let inner = TWO || fields.is_inner(at);
    let mut local = Local { xi: [V::splat(0.0); D], length: [V::splat(0.0); D] };
    for a in 0..D {
        local.xi[a] = load(&fields.xi[a], at);
        if plan.domains {
            local.length[a] = load(&fields.length[a], at);
        }
    }
    let [f0, f1, f2] = if inner {
        // the affine sum over three nodes comes from the others
        let third = if W == 3 { Third::Nothing } else { third };
        inner_functions::<D, W, V>(plan, &local, third)
    } else {
        // SAFETY: the rows are ours.
        unsafe { functions::<D, W, V>(sweep, plan, row, group.count, third) }
    };
    let mut of_three = [(V::splat(0.0), V::splat(0.0)); D];
    if AFFINE && W == 3 {
        if plan.domains {
            of_three = domains::affine_of_three(&plan.tables, &local, [&f0, &f1, &f2]);
        } else {
            for a in 0..D {
                of_three[a] = plan.tables[a].affine_of_three(local.xi[a]);
            }
        }
    }
    let node = fields.node[at % CHUNK] as usize;
    let nodes = Differences {
        cells: [&cells[group.cell % CELLS], &cells[(group.cell + 1) % CELLS]],
        lanes: V::cells(if TWO { group.of_first } else { V::LANES }),
    };
    for component in 0..D {
        let taken = if inner && W > 2 {
            let mut taken = interpolate_differences::<D, W, V, GRADIENT, AFFINE, TWO>(&f0, &f1, &f2, &nodes, 1 + component);
            if AFFINE && W == 3 {
                for a in 0..D {
                    let slot = 3 - D + a;
                    taken.third[slot] = of_three[a].1.fma(taken.slope[slot], of_three[a].0 * (taken.value - taken.third[slot]));
                }
            }
            taken
        } else {
            interpolate::<D, W, V, GRADIENT, AFFINE>(&f0, &f1, &f2, tile, &tile.momentum, node, 1 + component)
        };
        store(&mut fields.velocity[component], at, taken.value);
        for axis in 0..D {
            if GRADIENT {
                store(&mut fields.gradient[component][axis], at, taken.slope[3 - D + axis]);
            }
            if AFFINE {
                store(&mut fields.affine[component][axis], at, taken.third[3 - D + axis]);
            }
        }
    }
    if !TWO && task.needs_force() {
        // the mark is of use only to particles that may separate
        for lane in usize::from(task.separation == 0.0)..=D {
            let taken = interpolate::<D, W, V, false, false>(&f0, &f1, &f2, tile, &tile.force, node, lane);
            store(&mut fields.acceleration[lane], at, taken.value);
        }
    }
}

/// The nodes of a group, see [`Cell`].
struct Differences<'a, const W: usize, V: Real> {
    cells: [&'a Cell<W, V::Number>; 2],
    /// Lanes of the first cell.
    lanes: V::Cells,
}

impl<const W: usize, V: Real> Differences<'_, W, V> {
    /// Number `n` of pair `q` along slot 2, of each cell in its lanes.
    #[inline(always)]
    fn at<const TWO: bool>(&self, i: usize, j: usize, q: usize, n: usize) -> V {
        let numbers = [self.cells[0].rows[i][j][q][n], self.cells[1].rows[i][j][q][n]];
        if TWO { V::of_cells(numbers, self.lanes) } else { V::all(numbers[0]) }
    }
}

/// Makes cell number `cell` of the chunk that of particle `at`, if its particles share it.
///
/// Of functions far from the ends the middle one is nowhere small, so differences from it are no loss.
#[inline(always)]
pub(super) fn share<const D: usize, const W: usize, V: Real>(chunk: &mut Chunk<W, V>, at: usize, tile: &Tile, cell: usize) {
    if W > 2 && chunk.fields.is_inner(at) {
        subtract::<D, W, V, V::Wide>(tile, &tile.momentum, chunk.fields.node[at % CHUNK] as usize, &mut chunk.cells[cell % CELLS]);
    }
}

/// The nodes of a cell from `node` on as differences, taken in double precision.
#[inline(always)]
fn subtract<const D: usize, const W: usize, V: Real<Wide = E>, E: Wide>(
    tile: &Tile,
    field: &[Lanes],
    node: usize,
    cell: &mut Cell<W, V::Number>,
) {
    let stride = tile.frame.stride;
    let last = node + (nodes::<D, W>(0) - 1) * stride[0] + (nodes::<D, W>(1) - 1) * stride[1] + W;
    assert!(last <= field.len(), "a tile covers the stencils of its particles");
    let (middle, pairs) = (middle(W), W / 2);
    let mut rows = [[[E::splat(0.0); 4]; W]; W];
    for i in 0..nodes::<D, W>(0) {
        for j in 0..nodes::<D, W>(1) {
            let start = node + i * stride[0] + j * stride[1];
            // SAFETY: see above.
            let row = unsafe { &*field.as_ptr().add(start).cast::<[Lanes; W]>() };
            let of_middle = E::at_all(&row[middle]);
            rows[i][j][3] = of_middle;
            for q in 0..pairs {
                // of an odd number of others the last is alone
                let (first, second) = (middle_first(2 * q + 1, middle), middle_first((2 * q + 2).min(W - 1), middle));
                rows[i][j][q] = E::at_each([&row[first], &row[second]]) - of_middle;
            }
        }
    }
    for q in 0..4 {
        if q == 3 || q < pairs {
            for i in 0..nodes::<D, W>(0) {
                for j in 0..nodes::<D, W>(1) {
                    if nodes::<D, W>(1) > 1 && j != middle {
                        rows[i][j][q] = rows[i][j][q] - rows[i][middle][q];
                    }
                }
            }
            for j in 0..nodes::<D, W>(1) {
                for i in 0..nodes::<D, W>(0) {
                    if nodes::<D, W>(0) > 1 && i != middle {
                        rows[i][j][q] = rows[i][j][q] - rows[middle][j][q];
                    }
                }
            }
        }
    }
    for i in 0..nodes::<D, W>(0) {
        for j in 0..nodes::<D, W>(1) {
            for q in 0..4 {
                if q == 3 || q < pairs {
                    V::store_eight(rows[i][j][q], &mut cell.rows[i][j][q]);
                }
            }
        }
    }
}

/// As [`interpolate`], from differences. Of three nodes the third is that with the middle one alone, see [`functions::AxisTable::affine_of_three`].
#[inline(always)]
fn interpolate_differences<const D: usize, const W: usize, V: Real, const GRADIENT: bool, const AFFINE: bool, const TWO: bool>(
    f0: &Line<V, W>,
    f1: &Line<V, W>,
    f2: &Line<V, W>,
    nodes_of: &Differences<W, V>,
    lane: usize,
) -> Taken<V> {
    let (zero, middle) = (V::splat(0.0), middle(W));
    let by_slope = AFFINE && W == 3;
    // sums so far: value; slope along each slot; third along each slot, or the value with the middle node alone along it
    let (mut value, mut slope, mut third) = (zero, [zero; 3], [zero; 3]);
    for at_i in 0..nodes::<D, W>(0) {
        // the middle one first
        let i = if D < 3 { 0 } else { middle_first(at_i, middle) };
        let (mut v, mut d1, mut d2, mut m1, mut m2) = (zero, zero, zero, zero, zero);
        for at_j in 0..nodes::<D, W>(1) {
            let j = if D < 2 { 0 } else { middle_first(at_j, middle) };
            let of_middle = nodes_of.at::<TWO>(i, j, 3, lane % 4);
            let (mut sum, mut sloped, mut turned) = (of_middle, zero, of_middle);
            for at_k in 1..W {
                let k = middle_first(at_k, middle);
                let difference = nodes_of.at::<TWO>(i, j, (at_k - 1) / 2, 4 * ((at_k - 1) % 2) + lane % 4);
                sum = f2.value[k].fma(difference, sum);
                if GRADIENT || by_slope {
                    sloped = if at_k == 1 { f2.slope[k] * difference } else { f2.slope[k].fma(difference, sloped) };
                }
                if AFFINE && !by_slope {
                    turned = if at_k == 1 { f2.third[k] * difference } else { f2.third[k].fma(difference, turned) };
                }
            }
            if at_j == 0 {
                (v, d2, m1, m2) = (sum, sloped, sum, turned);
                continue;
            }
            v = f1.value[j].fma(sum, v);
            if GRADIENT || by_slope {
                d1 = if at_j == 1 { f1.slope[j] * sum } else { f1.slope[j].fma(sum, d1) };
                d2 = f1.value[j].fma(sloped, d2);
            }
            if AFFINE {
                m2 = f1.value[j].fma(turned, m2);
            }
            if AFFINE && !by_slope {
                m1 = if at_j == 1 { f1.third[j] * sum } else { f1.third[j].fma(sum, m1) };
            }
        }
        if at_i == 0 {
            (value, slope, third) = (v, [zero, d1, d2], [v, m1, m2]);
            continue;
        }
        value = f0.value[i].fma(v, value);
        if GRADIENT || by_slope {
            let along = if at_i == 1 { f0.slope[i] * v } else { f0.slope[i].fma(v, slope[0]) };
            slope = [along, f0.value[i].fma(d1, slope[1]), f0.value[i].fma(d2, slope[2])];
        }
        if AFFINE {
            third = [third[0], f0.value[i].fma(m1, third[1]), f0.value[i].fma(m2, third[2])];
        }
        if AFFINE && !by_slope {
            third[0] = if at_i == 1 { f0.third[i] * v } else { f0.third[i].fma(v, third[0]) };
        }
    }
    Taken { value, slope, third }
}

/// Counts the nodes of a slot, the middle one first.
#[inline(always)]
const fn middle_first(at: usize, middle: usize) -> usize {
    if at == 0 {
        middle
    } else if at <= middle {
        at - 1
    } else {
        at
    }
}

/// Finds the first nodes in a tile of `count` particles from `first` on at `x`, the first of which is number `at` of the chunk. Returns
/// where in their cells they are.
///
/// # Safety
/// The rows are the caller's, with these positions; there are at most [`LANES`].
#[inline(always)]
pub(super) unsafe fn locate<const D: usize, const W: usize, V: Wide, N: Number>(
    sweep: &Sweep,
    plan: &Plan<W>,
    x: &[V; D],
    first: usize,
    at: usize,
    count: usize,
    frame: &Frame,
    fields: &mut Fields<N>,
) -> Local<V, D> {
    let to = fields.node[at % CHUNK..].first_chunk_mut().expect("there is room for eight from any particle on");
    let (local, outside) = if plan.splines {
        functions::locate(&plan.tables, x, frame, to)
    } else if const { W == 3 || W == 4 } && plan.domains {
        // SAFETY: the rows are ours.
        let half = unsafe { domains::halves::<D, V>(sweep, first, count) };
        domains::locate(&plan.tables, x, &half, frame, to)
    } else {
        stencil::first_nodes::<D, W, V>(&sweep.model.axes, x, frame, to);
        (Local { xi: *x, length: *x }, Mask::MAX)
    };
    fields.set_outside(at, outside);
    local
}

/// Positions of up to eight particles by axis; lanes beyond `count` are like the first.
///
/// # Safety
/// The rows are the caller's; `count` is at least 1 and at most [`LANES`].
#[inline(always)]
pub(super) unsafe fn positions<const D: usize, V: Wide>(sweep: &Sweep, first: usize, count: usize) -> [V; D] {
    let mut x = [V::splat(0.0); D];
    for a in 0..D {
        // SAFETY: the rows are ours.
        x[a] = like_first(unsafe { V::load_some(sweep.rows.position.at(a, first), count) }, count);
    }
    x
}

/// The first `count` lanes; the others are like the first.
#[inline(always)]
pub(super) fn like_first<V: Wide>(v: V, count: usize) -> V {
    if count < LANES { v.select(((1u32 << count) - 1) as u8, V::splat(v.first())) } else { v }
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
