//! Shape functions at eight particles, a lane each.

use crate::basis::{Axis, Inner, OFF_EDGE, Places, Stencils, Third};
use crate::lanes::{LANES, Real};

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

/// The functions at eight places in inner cells, slot by slot.
#[inline(always)]
pub(super) fn inner_functions<const D: usize, const W: usize, V: Real>(
    axes: &[Axis],
    inner: &[Option<Inner>; 3],
    xi: &[V; D],
    third: Third,
) -> [Line<V, W>; 3] {
    let zero = V::splat(0.0);
    let unused = Line { value: [zero; W], slope: [zero; W], third: [zero; W] };
    // in slots: the last axis is slot 2
    let of = [D.wrapping_sub(3), D.wrapping_sub(2), D - 1];
    [
        if D == 3 { inside(&axes[of[0]], inner[of[0]], xi[of[0]], third) } else { unused },
        if D >= 2 { inside(&axes[of[1]], inner[of[1]], xi[of[1]], third) } else { unused },
        inside(&axes[of[2]], inner[of[2]], xi[of[2]], third),
    ]
}

/// The functions at eight places anywhere.
#[inline(always)]
pub(super) fn functions<const D: usize, const W: usize, V: Real>(
    axes: &[Axis],
    x: &[V; D],
    half: &[V; D],
    third: Third,
) -> [Line<V, W>; 3] {
    let mut places = Places { position: [[0.0; LANES]; D], half: [[0.0; LANES]; D] };
    for number in 0..D {
        x[number].store(&mut places.position[number]);
        half[number].store(&mut places.half[number]);
    }
    let stencils = one_by_one::<D, W>(axes, &places, third);
    [loaded(&stencils, 0), loaded(&stencils, 1), loaded(&stencils, 2)]
}

/// Cells that see the same polynomials.
#[inline(always)]
fn inside<const W: usize, V: Real>(axis: &Axis, inner: Option<Inner>, xi: V, third: Third) -> Line<V, W> {
    let zero = V::splat(0.0);
    let mut line = Line { value: [zero; W], slope: [zero; W], third: [zero; W] };
    let Some(inner) = inner else { return line };
    let (coefficients, nodes) = axis.inner_piece::<W>(inner);
    let h = axis.cell_size();
    // the second moment of B-splines far from the ends, in squares of cells; that of linear functions varies
    let moment = W as f64 / 12.0;
    let scale = V::splat(if third == Third::Affine { 1.0 / (h * moment) } else { h });
    for a in 0..W {
        let mut slope = V::splat(coefficients[W - 1][a]);
        let mut value = slope.fma(xi, V::splat(coefficients[W - 2][a]));
        for power in 2..W {
            slope = slope.fma(xi, value);
            value = value.fma(xi, V::splat(coefficients[W - 1 - power][a]));
        }
        line.value[a] = value;
        line.slope[a] = slope * V::splat(axis.inverse_cell());
        if third != Third::Nothing {
            // the affine weights of linear functions are their slopes wherever the particle is
            let linear = W == 2 && third == Third::Affine;
            line.third[a] = if linear { line.slope[a] } else { value * ((V::splat(nodes[a]) - xi) * scale) };
        }
    }
    line
}

/// A slot of stencils in memory.
#[inline(always)]
fn loaded<const W: usize, V: Real>(stencils: &Stencils<W>, slot: usize) -> Line<V, W> {
    let zero = V::splat(0.0);
    let mut line = Line { value: [zero; W], slope: [zero; W], third: [zero; W] };
    for a in 0..W {
        line.value[a] = V::load(&stencils.weight[slot][a]);
        line.slope[a] = V::load(&stencils.slope[slot][a]);
        line.third[a] = V::load(&stencils.third[slot][a]);
    }
    line
}

/// Cells near the ends of the grid, elements and domains.
#[cold]
#[inline(never)]
fn one_by_one<const D: usize, const W: usize>(axes: &[Axis], places: &Places<D>, third: Third) -> Stencils<W> {
    Stencils::at::<D>(axes, places, third)
}

/// Cell and local coordinate of eight positions, as [`Axis::cell`] has them.
#[inline(always)]
pub(super) fn cell_of<V: Real>(axis: &Axis, x: V) -> (V, V) {
    let s = (x - V::splat(axis.origin())) * V::splat(axis.inverse_cell());
    let cell = s.floor().max(V::splat(0.0)).min(V::splat(f64::from(axis.cells() - 1)));
    (cell, (s - cell).max(V::splat(OFF_EDGE)).min(V::splat(1.0 - OFF_EDGE)))
}
