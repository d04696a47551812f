//! Shape functions of particles with domains (GIMP), a lane each. [`crate::basis::Stencils`] has them one by one, from other formulas.

use super::functions::{AxisTable, Line, Local, write_first};
use super::gather::like_first;
use super::task::Sweep;
use super::update::by_body;
use crate::basis::Third;
use crate::grid::Frame;
use crate::lanes::{LANES, Mask, Real, Wide};

/// The length of a domain \[cells\] from which on the function in the middle is nowhere small, as it is for B-splines in inner cells.
const LONG: f64 = 0.2;

/// The functions of domains as long as `length` from `low` on, both in cells and `low` from the edge of the cell that it is in; `whole` is
/// the inverse of the length.
///
/// A linear function averaged over a domain is that over its part in each cell: of a part that is the share q of the domain, as long as
/// l and from u on, the node below gets q (1 - u - l/2) and that above q (u + l/2); slopes are those of the cells times q. None of it is
/// a difference of what is nearly the same.
#[inline(always)]
fn line<const W: usize, V: Real>(table: &AxisTable<W>, low: V, length: V, whole: V, third: Third) -> Line<V, W> {
    let (zero, one, half) = (V::splat(0.0), V::splat(1.0), V::splat(0.5));
    let mut line = Line::zero();
    let inverse = V::splat(table.inverse);
    let mut left = length;
    for cell in 0..W - 1 {
        let start = if cell == 0 { low } else { zero };
        let part = if cell == W - 2 { left } else { left.min(one - start) };
        left = left - part;
        let (share, upper) = (part * whole, half.fma(part, start));
        line.value[cell] = (one - upper).fma(share, line.value[cell]);
        line.value[cell + 1] = share * upper;
        let slope = share * inverse;
        line.slope[cell] = line.slope[cell] - slope;
        line.slope[cell + 1] = slope;
    }
    if third == Third::Nothing {
        return line;
    }
    let (centre, mut moment) = (half.fma(length, low), zero);
    for a in 0..W {
        let arm = V::splat(a as f64) - centre;
        line.third[a] = line.value[a] * arm;
        moment = line.third[a].fma(arm, moment);
    }
    // the moment is at least that of the domain itself
    let scale = if third == Third::Affine { inverse / moment } else { V::splat(table.cell) };
    for a in 0..W {
        line.third[a] = line.third[a] * scale;
    }
    line
}

/// The functions of particles whose middle one is nowhere small, slot by slot.
#[inline(always)]
pub(super) fn inner_functions<const D: usize, const W: usize, V: Real>(
    tables: &[AxisTable<W>; 3],
    local: &Local<V, D>,
    third: Third,
) -> [Line<V, W>; 3] {
    let mut lines = [Line::zero(); 3];
    let whole = inverses(&local.length);
    for a in 0..D {
        lines[3 - D + a] = line(&tables[a], local.xi[a], local.length[a], whole[a], third);
    }
    lines
}

/// What the sums with the affine weights over three nodes are made of, see [`AxisTable::affine_of_three`].
///
/// In cells, N_0 is -c times its slope and N_2 is u times its own, and the weights are N_a (a - r) / m, with r the centre and m the second moment.
#[inline(always)]
pub(super) fn affine_of_three<const D: usize, const W: usize, V: Real>(
    tables: &[AxisTable<W>; 3],
    local: &Local<V, D>,
    lines: [&Line<V, W>; 3],
) -> [(V, V); D] {
    let (one, two, half) = (V::splat(1.0), V::splat(2.0), V::splat(0.5));
    let (mut of, mut under) = ([(one, one); D], [one; D]);
    for a in 0..D {
        let rest = one - local.xi[a];
        let part = local.length[a].min(rest);
        let (c, u) = (half.fnma(part, rest), half * (local.length[a] - part));
        let r = half.fma(local.length[a], local.xi[a]);
        // the sum of N_a a^2 is r + 2 N_2
        let moment = two.fma(lines[3 - D + a].value[2 % W], r.fnma(r, r));
        under[a] = moment * (c + u);
        of[a] = (c.fnma(r, u * (two - r)) * V::splat(tables[a].inverse), two * c * u);
    }
    let inverse = inverses(&under);
    for a in 0..D {
        of[a] = (of[a].0 * inverse[a], of[a].1 * inverse[a]);
    }
    of
}

/// The inverses of up to three numbers, neither large nor small, by one division.
#[inline(always)]
fn inverses<const D: usize, V: Real>(of: &[V; D]) -> [V; D] {
    let one = V::splat(1.0);
    let (a, b, c) = (of[0], if D > 1 { of[1] } else { one }, if D > 2 { of[2] } else { one });
    let ab = a * b;
    let all = one / (ab * c);
    let all_c = all * c;
    let mut inverse = [all_c * b; D];
    if D > 1 {
        inverse[1] = all_c * a;
    }
    if D > 2 {
        inverse[2] = all * ab;
    }
    inverse
}

/// Where eight particles are, with domains of these half-lengths \[m\]. Writes the places of their first nodes in a tile, and returns those
/// whose middle function may be small.
#[inline(always)]
pub(super) fn locate<const D: usize, const W: usize, V: Wide>(
    tables: &[AxisTable<W>; 3],
    x: &[V; D],
    half: &[V; D],
    frame: &Frame,
    nodes: &mut [u32; LANES],
) -> (Local<V, D>, Mask) {
    let (zero, one) = (V::splat(0.0), V::splat(1.0));
    let (mut first, mut local, mut outside) = ([zero; D], Local { xi: [zero; D], length: [zero; D] }, 0);
    for a in 0..D {
        let half = half[a] * V::splat(tables[a].inverse);
        let low = tables[a].place(x[a]) - half;
        let cell = low.floor();
        (local.xi[a], local.length[a]) = (low - cell, half + half);
        // nodes are counted from the one outside the grid
        first[a] = cell + one;
        outside |= local.length[a].below(V::splat(LONG));
    }
    write_first(&first, frame, nodes);
    (local, outside)
}

/// Half-lengths \[m\] of the domains of up to eight particles by axis; lanes beyond `count` are like the first.
///
/// # Safety
/// The rows are the caller's; `count` is at least 1 and at most [`LANES`].
#[inline(always)]
pub(super) unsafe fn halves<const D: usize, V: Wide>(sweep: &Sweep, first: usize, count: usize) -> [V; D] {
    let mut half = [V::splat(0.0); D];
    for a in 0..D {
        // SAFETY: the rows are ours.
        half[a] = unsafe { by_body(sweep, first, count, |body| body.half[a]) };
        if sweep.model.domains == Some(true) {
            // SAFETY: the rows are ours.
            half[a] = half[a] * unsafe { V::load_some(sweep.rows.deformation.at(a * (D + 1), first), count) };
        }
        half[a] = like_first(half[a], count);
    }
    half
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::basis::{Axis, Family, Places, Stencils};
    use crate::lanes::Plain;

    /// All lanes of a number.
    fn lanes(v: Plain) -> [f64; LANES] {
        let mut numbers = [0.0; LANES];
        v.store_lanes(&mut numbers);
        numbers
    }

    /// Domains of many lengths and places, as parts of cells, against differences of integrals.
    fn check_domains<const W: usize>(follow: bool) {
        let axis = Axis::new(-1.0, 0.5, 12, Family::Domains { follow });
        let table = AxisTable::<W>::new(&axis);
        let widest = if follow { 2.0 } else { 1.0 };
        let frame = Frame::default();
        for step in 0..=400 {
            let length = LONG + (widest - LONG) * f64::from(step % 20) / 19.0;
            let x: [f64; LANES] = std::array::from_fn(|lane| 5.5 * (f64::from(step) / 400.0 + 0.124 * lane as f64).fract() - 0.75);
            let half = 0.5 * length * axis.cell_size();
            let places = Places { position: [x], half: [[half; LANES]] };
            let mut nodes = [0; LANES];
            let tables = [table; 3];
            let (local, outside) = locate::<1, W, Plain>(&tables, &[Plain::load_eight(&x)], &[Plain::splat(half)], &frame, &mut nodes);
            // the shortest may be just below
            assert!(outside == 0 || step % 20 == 0);
            let whole = Plain::splat(1.0) / local.length[0];
            for third in [Third::Nothing, Third::Arm, Third::Affine] {
                let ours = line(&table, local.xi[0], local.length[0], whole, third);
                let theirs = Stencils::<W>::at::<1>(std::slice::from_ref(&axis), &places, third);
                for lane in 0..LANES {
                    assert_eq!(nodes[lane] as i32, theirs.first(lane)[2]);
                    for a in 0..W {
                        let pairs = [(ours.value, theirs.weight), (ours.slope, theirs.slope), (ours.third, theirs.third)];
                        for (ours, theirs) in pairs {
                            // differences of integrals over a fifth of a cell, weights over a moment of a hundredth of one
                            assert!((lanes(ours[a])[lane] - theirs[2][a][lane]).abs() < 1e-12, "{W} at {} of {length}", x[lane]);
                        }
                    }
                }
            }
        }
    }

    #[test]
    fn domains_in_lanes_are_those_one_by_one() {
        check_domains::<3>(false);
        check_domains::<4>(true);
    }

    /// The sum with the affine weights, written out and from value and slope.
    fn check_affine_of_three(family: Family, lengths: &[f64]) {
        let axis = Axis::new(0.0, 0.5, 12, family);
        let (table, domains) = (AxisTable::<3>::new(&axis), matches!(family, Family::Domains { .. }));
        let field = [0.3, -1.7, 2.9].map(Plain::splat);
        for length in lengths.iter().map(|&length| Plain::splat(length)) {
            for step in 0..50 {
                let xi = Plain::load_eight(&std::array::from_fn(|lane| f64::from(LANES as i32 * step + lane as i32) / 400.0));
                let (line, (a, b)) = if domains {
                    let line = line(&table, xi, length, Plain::splat(1.0) / length, Third::Affine);
                    let [of_three] = affine_of_three(&[table; 3], &Local { xi: [xi], length: [length] }, [&line; 3]);
                    (line, of_three)
                } else {
                    (table.splines(xi, Third::Affine), table.affine_of_three(xi))
                };
                let [mut value, mut slope, mut third] = [Plain::splat(0.0); 3];
                for a in 0..3 {
                    value = value + line.value[a] * field[a];
                    slope = slope + line.slope[a] * field[a];
                    third = third + line.third[a] * field[a];
                }
                let difference = lanes(a * (value - field[1]) + b * slope - third);
                // weights of about 10, with a denominator of down to a hundredth
                assert!(difference.iter().all(|d| d.abs() < 1e-11), "{family:?}: {difference:?}");
            }
        }
    }

    #[test]
    fn affine_sums_of_three_nodes_come_from_value_and_slope() {
        check_affine_of_three(Family::OpenSpline(2), &[0.0]);
        check_affine_of_three(Family::Domains { follow: false }, &[LONG, 0.5, 0.77, 1.0]);
    }
}
