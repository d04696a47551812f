//! B-splines along one axis: of degree 1 to 5 with open knots at the ends of the grid (Tielen 2016, section 6.1), and the uniform cubic ones
//! of Andersen (2007, section 3.4).

use super::axis::Pieces;

/// Highest degree on offer.
const MAX_DEGREE: usize = 5;
const MAX_WIDTH: usize = MAX_DEGREE + 1;

/// Cells at an end that see the repeated knots.
pub(super) fn border(degree: usize) -> i32 {
    (degree as i32 - 1).max(0)
}

/// Pieces of each class of cells (see `Axis::class`) for open knots.
pub(super) fn open(cells: i32, degree: usize) -> Pieces {
    let border = border(degree);
    let classes: Vec<i32> = if border == 0 {
        vec![0]
    } else if cells <= 2 * border + 1 {
        (0..cells).collect()
    } else {
        (0..=border).chain(cells - border..cells).collect()
    };
    let mut pieces = Pieces::default();
    for c in classes {
        tabulate(&mut pieces, cells, degree, c);
    }
    pieces
}

/// The cubic splines of Andersen (2007, eq. 23): those of a cell far from the ends, in every cell. Their nodes are the corners of the cells,
/// the first of a cell one below it.
pub(super) fn uniform_cubic() -> Pieces {
    let mut pieces = Pieces::default();
    tabulate(&mut pieces, 9, 3, 4);
    pieces
}

/// Knot `j` of an open knot vector, in cells.
fn knot(cells: i32, degree: usize, j: i32) -> f64 {
    (j - degree as i32).clamp(0, cells) as f64
}

/// Mean of the inner knots of function `i`, in cells.
pub(super) fn greville_point(cells: i32, degree: usize, i: i32) -> f64 {
    (1..=degree as i32).map(|j| knot(cells, degree, i + j)).sum::<f64>() / degree as f64
}

/// Integral of function `i`, in cells: 1 unless its support is cut by an end.
pub(super) fn share(cells: i32, degree: usize, i: i32) -> f64 {
    (knot(cells, degree, i + degree as i32 + 1) - knot(cells, degree, i)) / (degree + 1) as f64
}

/// See `Axis::extension`. The coefficient of function `i` in a polynomial is its blossom at the inner knots of the function (de Boor 1978,
/// chapter IX): of x^m the elementary symmetric polynomial of degree m over its number of terms.
pub(super) fn extension(cells: i32, degree: usize, i: i32, first: i32) -> Vec<f64> {
    let n = degree + 1;
    let origin = greville_point(cells, degree, first + degree as i32 / 2);
    let blossom = |i: i32| {
        let mut symmetric = vec![0.0; n];
        symmetric[0] = 1.0;
        for j in 1..=degree as i32 {
            let t = (knot(cells, degree, i + j) - origin) / degree as f64;
            (1..n).rev().for_each(|m| symmetric[m] += t * symmetric[m - 1]);
        }
        symmetric
    };
    // the numbers of terms are the same on both sides
    let columns: Vec<Vec<f64>> = (0..n as i32).map(|k| blossom(first + k)).collect();
    let matrix = nalgebra::DMatrix::from_fn(n, n, |m, k| columns[k][m]);
    let right = nalgebra::DVector::from_vec(blossom(i));
    // functions in a row that are not zero in a common cell are independent
    matrix.lu().solve(&right).map_or_else(|| vec![f64::NAN; n], |x| x.as_slice().to_vec())
}

/// Cox-de Boor recursion (Tielen 2016, section 6.1) carried out on polynomials of the local coordinate of cell `c`.
fn tabulate(pieces: &mut Pieces, cells: i32, degree: usize, c: i32) {
    let (p, span) = (degree, c + degree as i32);
    let knot = |j: i32| knot(cells, degree, j);
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
                let (start, length) = (knot(i), knot(i + k as i32) - knot(i));
                add_linear(&mut functions[a], &lower[a - 1], (c as f64 - start) / length, 1.0 / length);
            }
            if a < k {
                // (t_{i+k+1} - x) / (t_{i+k+1} - t_{i+1}) N_{i+1,k-1}; that function is lower[a]
                let (end, length) = (knot(i + k as i32 + 1), knot(i + k as i32 + 1) - knot(i + 1));
                add_linear(&mut functions[a], &lower[a], (end - c as f64) / length, -1.0 / length);
            }
        }
    }
    for power in 0..=p {
        pieces.coefficients.extend((0..=p).map(|a| functions[a][power]));
    }
    for a in 0..=p as i32 {
        pieces.places.push(greville_point(cells, degree, c + a) - c as f64);
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
    use super::super::axis::OFF_EDGE;
    use super::super::{Axis, BATCH, Batch, Family, Places, Stencils, Third};

    /// Round-off of sums of at most six terms of order `degree^2`.
    const ROUND_OFF: f64 = 2e-13;

    fn at<const W: usize>(spline: &Axis, x: f64, third: Third) -> (i32, [f64; W], [f64; W], [f64; W]) {
        let s = Stencils::<W>::at::<1>(std::slice::from_ref(spline), &Places { position: [[x; BATCH]], half: [Batch::default()] }, third);
        (s.first(0)[2], s.weight[2].map(|b| b[0]), s.slope[2].map(|b| b[0]), s.third[2].map(|b| b[0]))
    }

    fn check<const W: usize>(cells: usize) {
        let spline = Axis::new(-1.0, 0.5, cells, Family::OpenSpline(W - 1));
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
        let spline = Axis::new(0.0, 1.0, 9, Family::OpenSpline(2));
        let (_, weights, ..) = at::<3>(&spline, 4.25, Third::Nothing);
        let xi: f64 = 0.25;
        let exact = [0.5 * (1.0 - xi).powi(2), 0.5 + xi - xi * xi, 0.5 * xi * xi];
        for a in 0..3 {
            assert!((weights[a] - exact[a]).abs() < 1e-15);
        }
    }

    #[test]
    fn only_the_end_function_is_not_zero_at_an_end_of_the_grid() {
        let spline = Axis::new(0.0, 0.1, 10, Family::OpenSpline(3));
        let (_, weights, ..) = at::<4>(&spline, 0.0, Third::Nothing);
        assert!((weights[0] - 1.0).abs() < ROUND_OFF && weights[1..].iter().all(|w| w.abs() < ROUND_OFF));
        let (first, weights, ..) = at::<4>(&spline, 1.0, Third::Nothing);
        assert!((weights[3] - 1.0).abs() < ROUND_OFF && first + 4 == spline.functions());
    }

    #[test]
    fn smoothness_across_cells_is_degree_minus_one() {
        let spline = Axis::new(0.0, 1.0, 12, Family::OpenSpline(3));
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
        let spline = Axis::new(0.0, 0.25, 4, Family::OpenSpline(2));
        assert_eq!(spline.cell(0.25), (1, OFF_EDGE));
        assert_eq!(spline.cell(1.0), (3, 1.0 - OFF_EDGE));
        assert!(spline.holds(-1.7e-18) && spline.cell(-1.7e-18).0 == 0);
        assert!(!spline.holds(1.001) && !spline.holds(-0.001) && !spline.holds(f64::NAN));
    }
}
