//! Shape functions at particles, a lane each.

use super::domains;
use super::gather::positions;
use super::task::{Plan, Sweep};
use crate::basis::{Axis, NO_MOMENT, OFF_EDGE, Places, Stencils, Third};
use crate::grid::Frame;
use crate::lanes::{Apart, LANES, Mask, Real, Wide};

/// Weights of the functions of a slot (see [`Stencils`]), by node.
#[derive(Clone, Copy)]
pub(super) struct Line<V, const W: usize> {
    /// N.
    pub(super) value: [V; W],
    /// dN/dx \[1/m\].
    pub(super) slope: [V; W],
    /// See [`Third`].
    pub(super) third: [V; W],
}

impl<V: Real, const W: usize> Line<V, W> {
    #[inline(always)]
    pub(super) fn zero() -> Self {
        let zero = V::splat(0.0);
        Self { value: [zero; W], slope: [zero; W], third: [zero; W] }
    }
}

/// An axis as kernels need it: places of cells, and the polynomials of the functions in inner cells.
#[derive(Clone, Copy)]
pub(super) struct AxisTable<const W: usize> {
    /// First and last of these cells; a first beyond the last where there are none.
    pub(super) cells: (f64, f64),
    /// Coefficients of N by power and function; of three functions a cell they are known.
    value: [[f64; W]; W],
    /// Of dN/dx \[1/m\], by power and function.
    slope: [[f64; W]; W],
    /// Places of the nodes, in cells from the lower edge of the cell.
    nodes: [f64; W],
    /// Lower end of the grid \[m\].
    pub(super) origin: f64,
    /// Cell size \[m\].
    pub(super) cell: f64,
    /// Its inverse.
    pub(super) inverse: f64,
    /// Cells.
    count: f64,
    /// See [`Axis::ends_of_places`].
    pub(super) ends: (f64, f64),
    /// See [`Axis::widest`].
    pub(super) widest: f64,
}

impl<const W: usize> AxisTable<W> {
    /// Of an axis, whose functions are of this width.
    pub(super) fn new(axis: &Axis) -> Self {
        let none = (f64::INFINITY, f64::NEG_INFINITY);
        let mut of = Self {
            cells: none,
            value: [[0.0; W]; W],
            slope: [[0.0; W]; W],
            nodes: [0.0; W],
            origin: axis.origin(),
            cell: axis.cell_size(),
            inverse: axis.inverse_cell(),
            count: f64::from(axis.cells()),
            ends: axis.ends_of_places(),
            widest: axis.widest(),
        };
        if let Some(inner) = axis.inner() {
            let (value, nodes) = axis.inner_piece::<W>(inner);
            (of.cells, of.nodes) = (inner.cells, *nodes);
            if W != 3 {
                of.value = *value;
                for power in 1..W {
                    for a in 0..W {
                        of.slope[power - 1][a] = power as f64 * value[power][a] * axis.inverse_cell();
                    }
                }
            }
        }
        of
    }

    /// Eight positions in cells from the lower end.
    #[inline(always)]
    pub(super) fn place<V: Wide>(&self, x: V) -> V {
        (x - V::splat(self.origin)) * V::splat(self.inverse)
    }

    /// Cell and local coordinate of eight positions, as [`Axis::cell`] has them.
    #[inline(always)]
    fn cell_of<V: Wide>(&self, x: V) -> (V, V) {
        let s = self.place(x);
        let cell = s.floor().max(V::splat(0.0)).min(V::splat(self.count - 1.0));
        (cell, (s - cell).max(V::splat(OFF_EDGE)).min(V::splat(1.0 - OFF_EDGE)))
    }

    /// What the sum with the affine weights over three nodes along an axis is made of: so many times v - v_1 and so many times dv/dx.
    ///
    /// A field is three numbers there, v = v_1 + N_0 (v_0 - v_1) + N_2 (v_2 - v_1): its value, its slope and v_1 say all. With the weights
    /// N_a (x_a - x_p) 4 / h^2 of B-splines the sum is (4 xi - 2) / h (v - v_1) + 4 xi (1 - xi) dv/dx.
    #[inline(always)]
    pub(super) fn affine_of_three<V: Real>(&self, xi: V) -> (V, V) {
        let four_xi = V::splat(4.0) * xi;
        ((four_xi - V::splat(2.0)) * V::splat(self.inverse), xi.fnma(four_xi, four_xi))
    }

    /// The B-splines at places of one of these cells.
    #[inline(always)]
    pub(super) fn splines<V: Real>(&self, xi: V, third: Third) -> Line<V, W> {
        let mut line = Line::zero();
        if W == 3 {
            // the B-splines of three functions a cell, from the local coordinate and what is left of the cell
            let (half, rest, inverse) = (V::splat(0.5), V::splat(1.0) - xi, V::splat(self.inverse));
            let (low, high) = (half * rest, half * xi);
            (line.value[0], line.value[1], line.value[2]) = (low * rest, xi.fma(rest, half), high * xi);
            (line.slope[0], line.slope[1], line.slope[2]) = (-(rest * inverse), (rest - xi) * inverse, xi * inverse);
        }
        // the second moment of B-splines far from the ends, in squares of cells; that of linear functions varies
        let moment = W as f64 / 12.0;
        let scale = V::splat(if third == Third::Affine { 1.0 / (self.cell * moment) } else { self.cell });
        for a in 0..W {
            if W != 3 {
                line.value[a] = polynomial(&self.value, a, 1, xi);
                line.slope[a] = polynomial(&self.slope, a, 2, xi);
            }
            if third != Third::Nothing {
                // the affine weights of linear functions are their slopes wherever the particle is
                let linear = W == 2 && third == Third::Affine;
                line.third[a] = if linear { line.slope[a] } else { line.value[a] * ((V::splat(self.nodes[a]) - xi) * scale) };
            }
        }
        line
    }
}

/// Polynomial `a` of a table by power, whose last `zeros` - 1 powers have no part in it.
#[inline(always)]
fn polynomial<const W: usize, V: Real>(table: &[[f64; W]; W], a: usize, zeros: usize, xi: V) -> V {
    let mut sum = V::splat(table[W - zeros][a]);
    for power in zeros..W {
        sum = sum.fma(xi, V::splat(table[W - 1 - power][a]));
    }
    sum
}

/// Where particles are in their cells, by axis.
#[derive(Clone, Copy)]
pub(super) struct Local<V, const D: usize> {
    /// Local coordinate, of a domain that of its lower end; of use only where the functions are those of inner cells.
    pub(super) xi: [V; D],
    /// Length of the domain \[cells\]; of use only where there are domains.
    pub(super) length: [V; D],
}

/// The functions at particles in inner cells, slot by slot.
#[inline(always)]
pub(super) fn inner_functions<const D: usize, const W: usize, V: Real>(
    plan: &Plan<W>,
    local: &Local<V, D>,
    third: Third,
) -> [Line<V, W>; 3] {
    if const { W == 3 || W == 4 } && plan.domains {
        return domains::inner_functions(&plan.tables, local, third);
    }
    let mut lines = [Line::zero(); 3];
    for a in 0..D {
        // in slots: the last axis is slot 2
        lines[3 - D + a] = plan.tables[a].splines(local.xi[a], third);
    }
    lines
}

/// The functions at `count` particles from `first` on, wherever they are.
///
/// # Safety
/// The rows are the caller's; there are at most as many as lanes.
#[inline(always)]
pub(super) unsafe fn functions<const D: usize, const W: usize, V: Real>(
    sweep: &Sweep,
    plan: &Plan<W>,
    first: usize,
    count: usize,
    third: Third,
) -> [Line<V, W>; 3] {
    // SAFETY: the caller's promise; this is compiled for the instructions of the lanes.
    let made = unsafe { V::apart(Anywhere::<D, W> { sweep, plan, first, count, third }) };
    // number by number: else those of inner cells, which take the same place, would go through memory too
    let mut lines = [Line::zero(); 3];
    for slot in 3 - D..3 {
        for a in 0..W {
            lines[slot].value[a] = made[slot].value[a];
            lines[slot].slope[a] = made[slot].slope[a];
            lines[slot].third[a] = made[slot].third[a];
        }
    }
    lines
}

/// See [`functions`].
struct Anywhere<'a, const D: usize, const W: usize> {
    sweep: &'a Sweep<'a>,
    plan: &'a Plan<W>,
    first: usize,
    count: usize,
    third: Third,
}

impl<const D: usize, const W: usize, V: Real> Apart<V> for Anywhere<'_, D, W> {
    type Result = [Line<V, W>; 3];
    #[inline(always)]
    unsafe fn carry_out(self) -> [Line<V, W>; 3] {
        // SAFETY: the caller's promise.
        unsafe { anywhere::<D, W, V, V::Wide>(self.sweep, self.plan, self.first, self.count, self.third) }
    }
}

/// See [`functions`].
#[inline(always)]
unsafe fn anywhere<const D: usize, const W: usize, V: Real<Wide = E>, E: Wide>(
    sweep: &Sweep,
    plan: &Plan<W>,
    first: usize,
    count: usize,
    third: Third,
) -> [Line<V, W>; 3] {
    let axes = &sweep.model.axes;
    let mut of = [[Line::zero(); 3]; 2];
    for eight in 0..V::EIGHTS {
        let start = eight * LANES;
        if start >= count {
            continue;
        }
        let (row, some) = (first + start, LANES.min(count - start));
        if plan.splines {
            // SAFETY: the caller's promise.
            let x = unsafe { positions::<D, E>(sweep, row, some) };
            for a in 0..D {
                of[eight][3 - D + a] = splines(&axes[a], &plan.tables[a], x[a], third);
            }
            continue;
        }
        // SAFETY: the caller's promise.
        let stencils = one_by_one::<D, W>(axes, &unsafe { sweep.rows.places::<D>(sweep.model, row, row + some) }, third);
        for slot in 3 - D..3 {
            for a in 0..W {
                of[eight][slot].value[a] = E::load_eight(&stencils.weight[slot][a]);
                of[eight][slot].slope[a] = E::load_eight(&stencils.slope[slot][a]);
                of[eight][slot].third[a] = E::load_eight(&stencils.third[slot][a]);
            }
        }
    }
    let mut lines = [Line::zero(); 3];
    for slot in 3 - D..3 {
        for a in 0..W {
            lines[slot].value[a] = V::join([of[0][slot].value[a], of[1][slot].value[a]]);
            lines[slot].slope[a] = V::join([of[0][slot].slope[a], of[1][slot].slope[a]]);
            lines[slot].third[a] = V::join([of[0][slot].third[a], of[1][slot].third[a]]);
        }
    }
    lines
}

/// Elements and domains.
#[cold]
#[inline(never)]
fn one_by_one<const D: usize, const W: usize>(axes: &[Axis], places: &Places<D>, third: Third) -> Stencils<W> {
    Stencils::at::<D>(axes, places, third)
}

/// B-splines at eight places: class by class of the cells that they are in, which most often is one.
#[inline(always)]
fn splines<const W: usize, V: Wide>(axis: &Axis, table: &AxisTable<W>, x: V, third: Third) -> Line<V, W> {
    let (zero, h, inverse) = (V::splat(0.0), V::splat(table.cell), V::splat(table.inverse));
    let mut line = Line::zero();
    let (cell, xi) = table.cell_of(x);
    let (mut cells, mut moment, mut done) = ([0.0; LANES], zero, 0);
    cell.store_lanes(&mut cells);
    while done != Mask::MAX {
        let this = cells[done.trailing_ones() as usize % LANES];
        let (coefficients, nodes) = axis.piece::<W>(axis.class(this as i32));
        // all inner cells are of one class, any other is alone
        let (first, last) = if table.cells.0 <= this && this <= table.cells.1 { table.cells } else { (this, this) };
        let here = V::splat(first).at_most(cell) & cell.at_most(V::splat(last));
        for a in 0..W {
            let (mut value, mut slope) = (V::splat(coefficients[W - 1][a]), zero);
            for power in 1..W {
                slope = slope.fma(xi, value);
                value = value.fma(xi, V::splat(coefficients[W - 1 - power][a]));
            }
            line.value[a] = value.select(here, line.value[a]);
            line.slope[a] = (slope * inverse).select(here, line.slope[a]);
            if third != Third::Nothing {
                line.third[a] = ((V::splat(nodes[a]) - xi) * h).select(here, line.third[a]);
            }
        }
        // also where a place is no number, so that this ends
        done |= here | 1 << (done.trailing_ones() % LANES as u32);
    }
    if third == Third::Nothing {
        return line;
    }
    for a in 0..W {
        let arm = line.third[a];
        line.third[a] = line.value[a] * arm;
        moment = line.third[a].fma(arm, moment);
    }
    if third == Third::Affine {
        // on a node the moment vanishes, and the weights tend to the slopes; those of linear functions always are
        let vanishes = moment.below(V::splat(NO_MOMENT * table.cell * table.cell));
        for a in 0..W {
            line.third[a] = if W == 2 { line.slope[a] } else { line.slope[a].select(vanishes, line.third[a] / moment) };
        }
    }
    line
}

/// Where eight particles are, if the functions of the grid are B-splines. Writes the places of their first nodes in a tile, and returns
/// those whose functions are not those of inner cells.
#[inline(always)]
pub(super) fn locate<const D: usize, const W: usize, V: Wide>(
    tables: &[AxisTable<W>; 3],
    x: &[V; D],
    frame: &Frame,
    nodes: &mut [u32; LANES],
) -> (Local<V, D>, Mask) {
    let zero = V::splat(0.0);
    let (mut cells, mut xi, mut outside) = ([zero; D], [zero; D], 0);
    for a in 0..D {
        let s = tables[a].place(x[a]);
        cells[a] = s.floor();
        xi[a] = s - cells[a];
        if W == 2 {
            // on a node a linear function vanishes but its slope does not: the other node would have no mass, and so no velocity
            xi[a] = xi[a].max(V::splat(OFF_EDGE)).min(V::splat(1.0 - OFF_EDGE));
        }
        let (first, last) = tables[a].cells;
        outside |= cells[a].below(V::splat(first)) | V::splat(last).below(cells[a]);
    }
    if outside != 0 {
        // perhaps on the very end of the grid
        for a in 0..D {
            (cells[a], xi[a]) = tables[a].cell_of(x[a]);
        }
    }
    write_first(&cells, frame, nodes);
    (Local { xi, length: [zero; D] }, outside)
}

/// The places in a tile of the nodes with these numbers.
#[inline(always)]
pub(super) fn write_first<const D: usize, V: Wide>(numbers: &[V; D], frame: &Frame, nodes: &mut [u32; LANES]) {
    let mut index = V::splat(0.0);
    for a in 0..D {
        // whole numbers far below 2^53
        index = (numbers[a] - V::splat(f64::from(frame.low[3 - D + a]))).fma(V::splat(frame.step(3 - D + a) as f64), index);
    }
    // negative where a particle is not in the tile, which never is: then far beyond it
    index.store_indices(nodes);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::basis::Family;
    use crate::lanes::Plain;

    /// Eight at once against one by one, with eight particles in one cell and with eight far apart.
    fn check<const W: usize>(cells: usize) {
        let axis = Axis::new(-1.0, 0.5, cells, Family::OpenSpline(W - 1));
        let table = AxisTable::<W>::new(&axis);
        let length = 0.5 * cells as f64;
        for third in [Third::Nothing, Third::Arm, Third::Affine] {
            for (start, apart) in (0..=100).flat_map(|n| [1e-3, 0.124].map(|apart| (n as f64 / 100.0, apart))) {
                let x: [f64; LANES] = std::array::from_fn(|lane| -1.0 + length * (start + apart * lane as f64).rem_euclid(1.0));
                let ours = splines::<W, Plain>(&axis, &table, Plain::load_eight(&x), third);
                let theirs = Stencils::<W>::at::<1>(std::slice::from_ref(&axis), &Places { position: [x], half: [[0.0; LANES]] }, third);
                for a in 0..W {
                    let pairs = [(ours.value, theirs.weight), (ours.slope, theirs.slope), (ours.third, theirs.third)];
                    for (ours, theirs) in pairs {
                        let mut numbers = [0.0; LANES];
                        ours[a].store_lanes(&mut numbers);
                        for lane in 0..LANES {
                            // polynomials of a few terms; affine weights divide by moments that are small beside a node
                            let bound = if third == Third::Affine { 1e-6 } else { 1e-13 };
                            assert!((numbers[lane] - theirs[2][a][lane]).abs() < bound, "{W} {cells} cells at {}", x[lane]);
                        }
                    }
                }
            }
        }
    }

    #[test]
    fn splines_at_eight_places_are_those_at_one() {
        for cells in [4, 5, 12] {
            check::<2>(cells);
            check::<3>(cells);
            check::<4>(cells);
            check::<6>(cells);
        }
    }
}
