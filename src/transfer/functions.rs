//! Shape functions at particles, a lane each.

use super::task::Sweep;
use crate::basis::{Axis, OFF_EDGE, Places, Stencils, Third};
use crate::grid::Frame;
use crate::lanes::{LANES, Mask, Real, Wide};

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

/// An axis as kernels need it: places of cells, and the polynomials of the functions in inner cells.
#[derive(Clone, Copy)]
pub(super) struct AxisTable<const W: usize> {
    /// First and last of these cells; a first beyond the last where there are none.
    pub(super) cells: (f64, f64),
    /// Coefficients of N by power and function.
    value: [[f64; W]; W],
    /// Of dN/dx \[1/m\], by power and function.
    slope: [[f64; W]; W],
    /// Places of the nodes, in cells from the lower edge of the cell.
    nodes: [f64; W],
    /// Lower end of the grid \[m\].
    pub(super) origin: f64,
    /// Cell size \[m\].
    cell: f64,
    /// Its inverse.
    pub(super) inverse: f64,
    /// Cells.
    count: f64,
    /// See [`Axis::ends_of_places`].
    pub(super) ends: (f64, f64),
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
        };
        if let Some(inner) = axis.inner() {
            let (value, nodes) = axis.inner_piece::<W>(inner);
            (of.cells, of.value, of.nodes) = (inner.cells, *value, *nodes);
            for power in 1..W {
                for a in 0..W {
                    of.slope[power - 1][a] = power as f64 * value[power][a] * axis.inverse_cell();
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

    /// The functions at eight places of one of these cells.
    #[inline(always)]
    fn at<V: Real>(&self, xi: V, third: Third) -> Line<V, W> {
        let zero = V::splat(0.0);
        let mut line = Line { value: [zero; W], slope: [zero; W], third: [zero; W] };
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

/// The functions at eight places in inner cells, slot by slot.
#[inline(always)]
pub(super) fn inner_functions<const D: usize, const W: usize, V: Real>(
    tables: &[AxisTable<W>; 3],
    xi: &[V; D],
    third: Third,
) -> [Line<V, W>; 3] {
    let zero = V::splat(0.0);
    let unused = Line { value: [zero; W], slope: [zero; W], third: [zero; W] };
    // in slots: the last axis is slot 2
    let of = [D.wrapping_sub(3), D.wrapping_sub(2), D - 1];
    [
        if D == 3 { tables[of[0]].at(xi[of[0]], third) } else { unused },
        if D >= 2 { tables[of[1]].at(xi[of[1]], third) } else { unused },
        tables[of[2]].at(xi[of[2]], third),
    ]
}

/// The functions at `count` particles from `first` on, wherever they are.
///
/// # Safety
/// The rows are the caller's; there are at most as many as lanes.
#[inline(always)]
pub(super) unsafe fn functions<const D: usize, const W: usize, V: Real>(
    sweep: &Sweep,
    first: usize,
    count: usize,
    third: Third,
) -> [Line<V, W>; 3] {
    let mut of = [Stencils::<W>::default(); 2];
    for eight in 0..V::EIGHTS {
        // lanes of no particle are like the last
        let (start, end) = ((first + eight * LANES).min(first + count - 1), (first + (eight + 1) * LANES).min(first + count));
        // SAFETY: the caller's promise.
        of[eight] = one_by_one::<D, W>(&sweep.model.axes, &unsafe { sweep.rows.places::<D>(sweep.model, start, end) }, third);
    }
    [loaded(&of, 0), loaded(&of, 1), loaded(&of, 2)]
}

/// A slot of stencils in memory.
#[inline(always)]
fn loaded<const W: usize, V: Real>(of: &[Stencils<W>; 2], slot: usize) -> Line<V, W> {
    let zero = V::splat(0.0);
    let mut line = Line { value: [zero; W], slope: [zero; W], third: [zero; W] };
    for a in 0..W {
        line.value[a] = V::join([V::Wide::load_eight(&of[0].weight[slot][a]), V::Wide::load_eight(&of[1].weight[slot][a])]);
        line.slope[a] = V::join([V::Wide::load_eight(&of[0].slope[slot][a]), V::Wide::load_eight(&of[1].slope[slot][a])]);
        line.third[a] = V::join([V::Wide::load_eight(&of[0].third[slot][a]), V::Wide::load_eight(&of[1].third[slot][a])]);
    }
    line
}

/// Cells near the ends of the grid, elements and domains.
#[cold]
#[inline(never)]
fn one_by_one<const D: usize, const W: usize>(axes: &[Axis], places: &Places<D>, third: Third) -> Stencils<W> {
    Stencils::at::<D>(axes, places, third)
}

/// Local coordinates of eight positions in their cells. Writes the places of their first nodes in a tile, and returns those whose
/// functions are not those of inner cells; the functions of the grid are B-splines.
#[inline(always)]
pub(super) fn locate<const D: usize, const W: usize, V: Wide>(
    tables: &[AxisTable<W>; 3],
    x: &[V; D],
    frame: &Frame,
    nodes: &mut [u32; LANES],
) -> ([V; D], Mask) {
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
    let mut index = zero;
    for a in 0..D {
        // whole numbers far below 2^53
        index = (cells[a] - V::splat(f64::from(frame.low[3 - D + a]))).fma(V::splat(frame.step(3 - D + a) as f64), index);
    }
    // negative where a particle is not in the tile, which never is: then far beyond it
    index.store_indices(nodes);
    (xi, outside)
}
