//! Integrals over what surfaces leave of a box, and over the part of a surface in it: coordinate by coordinate.
//!
//! Along the last axis a column is cut where it crosses a surface. Along the middle one the columns of a slice change where two surfaces meet,
//! or where one meets an end of the box; along the first one slices change where three do so. Between such places all is smooth, so that Gauss
//! rules converge; for planes polynomials stay polynomials, one degree higher with each axis (dimension reduction: R. Saye 2015, SIAM J. Sci.
//! Comput. 37, A993-A1019; of several surfaces 2022, J. Comput. Phys. 448, 110720. Here all roots are known in closed form).

use super::bound::{Bound, meet};
use crate::quadrature::gauss::gauss_legendre;

/// A surface that cuts a box.
#[derive(Debug, Clone, Copy)]
pub(super) struct Active {
    pub(super) bound: Bound,
    /// Convex part that it bounds: 0 is the whole, others are holes.
    pub(super) part: u32,
    /// Its number in that part.
    pub(super) number: u32,
}

/// Gauss rules along the axes of a column: n points along the inner two and n + 1 along the outermost make polynomials up to the degree
/// 2 n - 2 exact between planes.
pub(super) struct Rules {
    outer: Vec<(f64, f64)>,
    inner: Vec<(f64, f64)>,
}

impl Rules {
    pub(super) fn new(n: usize) -> Self {
        Self { outer: gauss_legendre(n + 1), inner: gauss_legendre(n) }
    }
}

/// A box that surfaces cut.
pub(super) struct Column<'a> {
    /// Those of a part follow each other.
    pub(super) actives: &'a [Active],
    pub(super) low: [f64; 3],
    pub(super) high: [f64; 3],
    /// From the outermost in.
    pub(super) axes: [usize; 3],
    /// By how much a point may miss a surface that it lies on \[m\].
    pub(super) slack: f64,
    /// Lengths up to this are nothing \[m\].
    pub(super) nothing: f64,
    pub(super) rules: &'a Rules,
}

impl Column<'_> {
    /// Whether a point is in the body.
    fn is_inside(&self, x: &[f64; 3]) -> bool {
        let mut groups = self.actives.chunk_by(|a, b| a.part == b.part);
        groups.all(|group| group.iter().all(|active| active.bound.distance(x) <= 0.0) == (group[0].part == 0))
    }

    /// Whether a point where surfaces of a part meet is on that part, and in the box.
    fn is_corner(&self, part: u32, x: &[f64; 3], slack: f64) -> bool {
        (0..3).all(|a| x[a] >= self.low[a] - slack && x[a] <= self.high[a] + slack)
            && self.actives.iter().filter(|active| active.part == part).all(|active| active.bound.distance(x) <= slack)
    }

    /// Where slices change along the first axis, or columns along the middle one in the slice at `slice`; where those of surface number `of`
    /// do, if given. `ends` are those of the last axis.
    fn breaks(&self, of: Option<usize>, ends: [f64; 2], slice: Option<f64>) -> Vec<f64> {
        let [first, middle, last] = self.axes;
        let along = if slice.is_some() { middle } else { first };
        let mut sides = vec![Bound::across(last, ends[0]), Bound::across(last, ends[1])];
        match slice {
            Some(place) => sides.push(Bound::across(first, place)),
            None => sides.extend([Bound::across(middle, self.low[middle]), Bound::across(middle, self.high[middle])]),
        }
        let n = self.actives.len();
        let all: Vec<&Bound> = self.actives.iter().map(|active| &active.bound).chain(&sides).collect();
        let mut breaks = vec![self.low[along], self.high[along]];
        for i in 0..n {
            let part = self.actives[i].part;
            for j in i + 1..all.len() {
                if j < n && self.actives[j].part != part {
                    continue;
                }
                // in a slice the third is the slice itself
                let thirds = if slice.is_some() { all.len() - 1..all.len() } else { j + 1..all.len() };
                for k in thirds.filter(|&k| k > j && (k >= n || self.actives[k].part == part)) {
                    if of.is_some_and(|of| of != i && of != j && of != k) {
                        continue;
                    }
                    meet([all[i], all[j], all[k]], |x| {
                        if x[along] > self.low[along] && x[along] < self.high[along] && self.is_corner(part, &x, 2.0 * self.slack) {
                            breaks.push(x[along]);
                        }
                    });
                }
            }
        }
        breaks.sort_by(f64::total_cmp);
        breaks
    }

    fn intervals<'b>(&self, breaks: &'b [f64]) -> impl Iterator<Item = [f64; 2]> + 'b {
        let nothing = self.nothing;
        breaks.windows(2).map(|ends| [ends[0], ends[1]]).filter(move |[from, to]| to - from > nothing)
    }

    /// Calls `f` with places along the first two axes and their weight.
    fn base(&self, of: Option<usize>, ends: [f64; 2], mut f: impl FnMut([f64; 3], f64)) {
        let [first, middle, _] = self.axes;
        let mut place = [0.0; 3];
        for [low, high] in self.intervals(&self.breaks(of, ends, None)) {
            for (s, weight) in &self.rules.outer {
                place[first] = low + s * (high - low);
                let outer = weight * (high - low);
                for [low, high] in self.intervals(&self.breaks(of, ends, Some(place[first]))) {
                    for (s, weight) in &self.rules.inner {
                        place[middle] = low + s * (high - low);
                        f(place, outer * weight * (high - low));
                    }
                }
            }
        }
    }

    /// Calls `f` with the points of what is inside, and their weights.
    pub(super) fn volume(&self, mut f: impl FnMut([f64; 3], f64)) {
        let last = self.axes[2];
        let ends = [self.low[last], self.high[last]];
        let mut breaks = Vec::new();
        self.base(None, ends, |mut place, base| {
            breaks.clear();
            breaks.extend(ends);
            for active in self.actives {
                active.bound.roots(&place, last, |root| {
                    let mut at = place;
                    at[last] = root;
                    if root > ends[0] && root < ends[1] && self.is_corner(active.part, &at, self.slack) {
                        breaks.push(root);
                    }
                });
            }
            breaks.sort_by(f64::total_cmp);
            for [low, high] in self.intervals(&breaks) {
                place[last] = 0.5 * (low + high);
                if !self.is_inside(&place) {
                    continue;
                }
                for (s, weight) in &self.rules.inner {
                    place[last] = low + s * (high - low);
                    f(place, base * weight * (high - low));
                }
            }
        });
    }

    /// Calls `f` with the points of a surface in the box, given by its number: position, and normal out of the body times area.
    ///
    /// A plane that runs along an end of the box is in the box on whose side the body is: as if it lay deeper in the body by the slack.
    pub(super) fn surface(&self, number: usize, mut f: impl FnMut([f64; 3], [f64; 3])) {
        let last = self.axes[2];
        let Active { bound, part, .. } = self.actives[number];
        let out = if part == 0 { 1.0 } else { -1.0 };
        let shift = if let Bound::Plane { normal, .. } = &bound { out * self.slack * normal[last].signum() } else { 0.0 };
        let ends = [self.low[last] + shift, self.high[last] + shift];
        let others = |x: &[f64; 3]| {
            let mut all = self.actives.iter().enumerate().filter(|(k, active)| *k != number && active.part == part);
            all.all(|(_, active)| active.bound.distance(x) <= 0.0)
        };
        self.base(Some(number), ends, |place, base| {
            bound.roots(&place, last, |root| {
                let mut at = place;
                at[last] = root;
                if root >= ends[0] && root < ends[1] && others(&at) {
                    let normal = bound.normal(&at);
                    f(at, normal.map(|n| out * base * n / normal[last].abs()));
                }
            });
        });
    }
}
