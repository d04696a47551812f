//! B-splines of degree 1 to 5 along one axis, with open knots at the ends of the grid (Tielen 2016, section 6.1).

/// Highest degree on offer.
pub(crate) const MAX_DEGREE: usize = 5;
const MAX_WIDTH: usize = MAX_DEGREE + 1;

/// How far outside the grid, in cells, a position still counts as on its edge: round-off of positions, not motion.
const EDGE_TOLERANCE: f64 = 1e-9;

/// A particle exactly on a node would give the next node no mass but, with linear functions and at open ends, a slope: that node's velocity
/// would be 0/0. So local coordinates keep this much off the edges of a cell, which shifts nothing beyond round-off.
const OFF_EDGE: f64 = 1e-14;

/// The splines of one axis. In cell `c` the functions `c` to `c + degree` are not zero; each is a polynomial of the local coordinate.
#[derive(Debug, Clone)]
pub(crate) struct Spline {
    origin: f64,
    cell: f64,
    inverse: f64,
    cells: i32,
    degree: usize,
    /// Coefficients by class of cell, power of the local coordinate, function.
    pieces: Vec<f64>,
    /// Greville points in cells from the origin: where the coefficient of a function acts like a nodal value. Only the first and
    /// last few are tabled, between them they are evenly spaced.
    greville: Vec<f64>,
    /// Cells at an end that see the repeated knots.
    border: i32,
}

impl Spline {
    pub(crate) fn new(origin: f64, cell: f64, cells: usize, degree: usize) -> Self {
        let cells = cells as i32;
        let border = (degree as i32 - 1).max(0);
        let mut spline = Self { origin, cell, inverse: 1.0 / cell, cells, degree, pieces: Vec::new(), greville: Vec::new(), border };
        let classes: Vec<i32> =
            if cells <= 2 * border + 1 { (0..cells).collect() } else { (0..=border).chain(cells - border..cells).collect() };
        for &c in &classes {
            spline.tabulate(c);
        }
        spline
    }

    /// Number of functions.
    pub(crate) fn functions(&self) -> i32 {
        self.cells + self.degree as i32
    }
    pub(crate) fn degree(&self) -> usize {
        self.degree
    }
    pub(crate) fn origin(&self) -> f64 {
        self.origin
    }
    #[inline(always)]
    pub(crate) fn cell_size(&self) -> f64 {
        self.cell
    }
    /// Smallest cell size of several axes \[m\].
    pub(crate) fn smallest_cell(axes: &[Self]) -> f64 {
        axes.iter().map(Self::cell_size).fold(f64::INFINITY, f64::min)
    }
    #[inline(always)]
    pub(crate) fn inverse_cell(&self) -> f64 {
        self.inverse
    }

    /// Cell and local coordinate of a position in the grid. Cells are half-open, the last one is closed.
    #[inline(always)]
    pub(crate) fn cell(&self, x: f64) -> (i32, f64) {
        let s = (x - self.origin) * self.inverse;
        // `as` saturates, so that even a wild position yields a cell that exists
        let cell = (s.floor() as i32).clamp(0, self.cells - 1);
        (cell, (s - cell as f64).clamp(OFF_EDGE, 1.0 - OFF_EDGE))
    }

    /// Whether a position lies in the grid, its edges included. False for NaN.
    #[inline(always)]
    pub(crate) fn holds(&self, x: f64) -> bool {
        let s = (x - self.origin) * self.inverse;
        s >= -EDGE_TOLERANCE && s <= self.cells as f64 + EDGE_TOLERANCE
    }

    /// Polynomial coefficients of the functions in cells of a class, by power and function, and their Greville points, in cells from the
    /// lower edge of the cell.
    #[inline(always)]
    pub(super) fn piece<const W: usize>(&self, class: usize) -> (&[[f64; W]; W], &[f64; W]) {
        (&self.pieces.as_chunks::<W>().0.as_chunks::<W>().0[class], &self.greville.as_chunks::<W>().0[class])
    }

    /// Position of function `i` \[m\]: its Greville point.
    pub(crate) fn node_position(&self, i: i32) -> f64 {
        self.origin + self.cell * self.greville_point(i)
    }

    /// Cells of one class have the same polynomials: each cell near an end is its own class, all others are one.
    #[inline(always)]
    pub(super) fn class(&self, cell: i32) -> usize {
        let (border, cells) = (self.border, self.cells);
        let class = if cells <= 2 * border + 1 || cell < border {
            cell
        } else if cell >= cells - border {
            2 * border + 1 - (cells - cell)
        } else {
            border
        };
        class as usize
    }

    fn knot(&self, j: i32) -> f64 {
        (j - self.degree as i32).clamp(0, self.cells) as f64
    }

    fn greville_point(&self, i: i32) -> f64 {
        (1..=self.degree as i32).map(|j| self.knot(i + j)).sum::<f64>() / self.degree as f64
    }

    /// Cox-de Boor recursion (Tielen 2016, section 6.1) carried out on polynomials of the local coordinate of cell `c`.
    fn tabulate(&mut self, c: i32) {
        let p = self.degree;
        let span = c + p as i32;
        let mut functions = [[0.0f64; MAX_WIDTH]; MAX_WIDTH + 1];
        functions[0][0] = 1.0;
        // functions[a] is N_{span - k + a} of degree k; start from degree 0, where only N_span is 1
        for k in 1..=p {
            let lower = functions;
            functions = [[0.0; MAX_WIDTH]; MAX_WIDTH + 1];
            for a in 0..=k {
                let i = span - k as i32 + a as i32;
                if a > 0 {
                    // (x - t_i) / (t_{i+k} - t_i) N_{i,k-1}; that function is lower[a - 1]
                    let (start, length) = (self.knot(i), self.knot(i + k as i32) - self.knot(i));
                    add_linear(&mut functions[a], &lower[a - 1], (c as f64 - start) / length, 1.0 / length);
                }
                if a < k {
                    // (t_{i+k+1} - x) / (t_{i+k+1} - t_{i+1}) N_{i+1,k-1}; that function is lower[a]
                    let (end, length) = (self.knot(i + k as i32 + 1), self.knot(i + k as i32 + 1) - self.knot(i + 1));
                    add_linear(&mut functions[a], &lower[a], (end - c as f64) / length, -1.0 / length);
                }
            }
        }
        for power in 0..=p {
            self.pieces.extend((0..=p).map(|a| functions[a][power]));
        }
        for a in 0..=p as i32 {
            self.greville.push(self.greville_point(c + a) - c as f64);
        }
    }
}

/// `to += (constant + slope xi) * polynomial`.
fn add_linear(to: &mut [f64; MAX_WIDTH], polynomial: &[f64; MAX_WIDTH], constant: f64, slope: f64) {
    for power in 0..MAX_WIDTH {
        to[power] += constant * polynomial[power];
        if power + 1 < MAX_WIDTH {
            to[power + 1] += slope * polynomial[power];
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::{BATCH, Stencils, Third};
    use super::*;

    /// Round-off of sums of at most six terms of order `degree^2`.
    const ROUND_OFF: f64 = 2e-13;

    fn at<const W: usize>(spline: &Spline, x: f64, third: Third) -> (i32, [f64; W], [f64; W], [f64; W]) {
        let s = Stencils::<W>::at::<1>(std::slice::from_ref(spline), &[[x; BATCH]], third);
        (s.first(0)[2], s.weight[2].map(|b| b[0]), s.slope[2].map(|b| b[0]), s.third[2].map(|b| b[0]))
    }

    fn check<const W: usize>(cells: usize) {
        let spline = Spline::new(-1.0, 0.5, cells, W - 1);
        let end = -1.0 + 0.5 * cells as f64;
        for step in 0..=997 {
            let x = -1.0 + (end + 1.0) * step as f64 / 997.0;
            let (first, weights, slopes, arms) = at::<W>(&spline, x, Third::Arm);
            assert!(first >= 0 && first + W as i32 <= spline.functions());
            let (mut sum, mut slope, mut place, mut gradient) = (0.0, 0.0, 0.0, 0.0);
            for a in 0..W {
                let node = spline.node_position(first + a as i32);
                assert!(weights[a] >= -ROUND_OFF, "B-splines are not negative");
                assert!((arms[a] - weights[a] * (node - x)).abs() < ROUND_OFF);
                sum += weights[a];
                slope += slopes[a];
                place += weights[a] * node;
                gradient += slopes[a] * node;
            }
            assert!((sum - 1.0).abs() < ROUND_OFF, "partition of unity");
            assert!(slope.abs() < 10.0 * ROUND_OFF, "gradient of a constant is {slope}");
            assert!((place - x).abs() < ROUND_OFF, "x is reproduced by the Greville points");
            assert!((gradient - 1.0).abs() < 10.0 * ROUND_OFF, "gradient of x is {gradient}");
        }
    }

    #[test]
    fn reproduces_linear_functions_with_open_knots_in_any_number_of_cells() {
        for cells in 1..=14 {
            check::<2>(cells);
            check::<3>(cells);
            check::<4>(cells);
            check::<5>(cells);
            check::<6>(cells);
        }
    }

    #[test]
    fn interior_quadratic_is_the_textbook_one() {
        let spline = Spline::new(0.0, 1.0, 9, 2);
        let (_, weights, ..) = at::<3>(&spline, 4.25, Third::Nothing);
        let xi: f64 = 0.25;
        let exact = [0.5 * (1.0 - xi).powi(2), 0.5 + xi - xi * xi, 0.5 * xi * xi];
        for a in 0..3 {
            assert!((weights[a] - exact[a]).abs() < 1e-15);
        }
    }

    #[test]
    fn only_the_end_function_is_not_zero_at_an_end_of_the_grid() {
        let spline = Spline::new(0.0, 0.1, 10, 3);
        let (_, weights, ..) = at::<4>(&spline, 0.0, Third::Nothing);
        assert!((weights[0] - 1.0).abs() < ROUND_OFF && weights[1..].iter().all(|w| w.abs() < ROUND_OFF));
        let (first, weights, ..) = at::<4>(&spline, 1.0, Third::Nothing);
        assert!((weights[3] - 1.0).abs() < ROUND_OFF && first + 4 == spline.functions());
    }

    #[test]
    fn smoothness_across_cells_is_degree_minus_one() {
        let spline = Spline::new(0.0, 1.0, 12, 3);
        let value = |x: f64, i: i32| {
            let (first, weights, slopes, _) = at::<4>(&spline, x, Third::Nothing);
            let a = i - first;
            if (0..4).contains(&a) { (weights[a as usize], slopes[a as usize]) } else { (0.0, 0.0) }
        };
        for i in 0..spline.functions() {
            for knot in 1..12 {
                let (below, above) = (value(knot as f64 - 1e-9, i), value(knot as f64, i));
                // slopes are at most 3 and second derivatives at most 12 here
                assert!((below.0 - above.0).abs() < 1e-8 && (below.1 - above.1).abs() < 1e-7);
            }
        }
    }

    #[test]
    fn a_position_on_an_edge_belongs_to_the_upper_cell_and_at_the_far_end_to_the_last() {
        let spline = Spline::new(0.0, 0.25, 4, 2);
        assert_eq!(spline.cell(0.25), (1, OFF_EDGE));
        assert_eq!(spline.cell(1.0), (3, 1.0 - OFF_EDGE));
        assert!(spline.holds(-1.7e-18) && spline.cell(-1.7e-18).0 == 0);
        assert!(!spline.holds(1.001) && !spline.holds(-0.001) && !spline.holds(f64::NAN));
    }
}
