use super::*;

/// A spline of one field, with everything it needs.
struct Curve {
    x: Vec<f64>,
    inverse_pivots: Vec<f64>,
    values: Vec<[f64; 1]>,
    bends: Vec<[f64; 1]>,
}

impl Curve {
    fn new(x: Vec<f64>, f: impl Fn(f64) -> f64) -> Self {
        let mut inverse_pivots = vec![f64::NAN; x.len()];
        factor(1, &x, &mut inverse_pivots).unwrap();
        let values: Vec<[f64; 1]> = x.iter().map(|x| [f(*x)]).collect();
        let mut bends = vec![[f64::NAN]; x.len()];
        Bundle::new(1, &x, &inverse_pivots).bend(&values, &mut bends);
        Self { x, inverse_pivots, values, bends }
    }
    fn at(&self, x: f64, near: usize) -> f64 {
        let bundle = Bundle::new(1, &self.x, &self.inverse_pivots);
        bundle.value(&bundle.place(0, x, near), &self.values, &self.bends)[0]
    }
}

/// Knots with unequal steps on \[0, 1\].
fn uneven(n: usize) -> Vec<f64> {
    (0..n).map(|i| i as f64 / (n - 1) as f64).map(|s| s + 0.1 * (6.0 * s).sin() * s * (1.0 - s)).collect()
}

#[test]
fn linear_data_is_reproduced_also_beyond_the_ends() {
    for n in [2, 3, 4, 50] {
        let curve = Curve::new(uneven(n), |x| 3.0 - 2.0 * x);
        for x in [-0.3, 0.0, 0.2, 0.77, 1.0, 1.4] {
            // round-off 1e-16, which beyond an end grows with the cube of the distance: up to 20 steps here
            assert!((curve.at(x, 0) - (3.0 - 2.0 * x)).abs() < 1e-11, "{n} knots at {x}");
        }
    }
}

#[test]
fn one_knot_is_a_constant() {
    let curve = Curve::new(vec![0.5], |_| 7.0);
    // copied, not computed
    assert_eq!([curve.at(-1.0, 0), curve.at(0.5, 3), curve.at(2.0, 0)], [7.0; 3]);
}

#[test]
fn two_knots_are_a_straight_line_beyond_them() {
    let curve = Curve::new(vec![1.0, 3.0], |x| x * x);
    // round-off: the chord of x^2 from 1 to 3 is 4 x - 3
    assert!((curve.at(5.0, 0) - 17.0).abs() < 1e-14);
}

#[test]
fn interpolates_and_is_smooth_at_the_knots() {
    let curve = Curve::new(uneven(9), f64::exp);
    for i in 0..9 {
        assert!((curve.at(curve.x[i], 4) - curve.x[i].exp()).abs() < 1e-14, "round-off at knot {i}");
    }
    // One-sided differences over e carry an error of e times the next derivative (below 10 here) and round-off 1e-16 / e^2.
    let e = 1e-4;
    for i in 1..8 {
        let x = curve.x[i];
        let slope = |s: f64| (-curve.at(x + 2.0 * s, i) + 4.0 * curve.at(x + s, i) - 3.0 * curve.at(x, i)) / (2.0 * s);
        let bend = |s: f64| (curve.at(x, i) - 2.0 * curve.at(x + s, i) + curve.at(x + 2.0 * s, i)) / (s * s);
        assert!((slope(e) - slope(-e)).abs() < 1e-6, "slope at knot {i}");
        assert!((bend(e) - bend(-e)).abs() < 1e-2, "second derivative at knot {i}: {} {}", bend(e), bend(-e));
        assert!((bend(e) - curve.bends[i][0]).abs() < 1e-2, "second derivative at knot {i} is the one solved for");
    }
}

#[test]
fn cubics_are_reproduced_up_to_the_ends() {
    let cubic = |x: f64| 1.0 - x + 2.0 * x * x - 3.0 * x * x * x;
    for n in [4, 5, 9, 40] {
        let curve = Curve::new(uneven(n), cubic);
        for x in [-0.1, 0.0, 0.03, 0.5, 0.99, 1.0, 1.1] {
            // round-off 1e-16, which beyond an end grows with the cube of the distance: up to 4 steps here
            assert!((curve.at(x, 0) - cubic(x)).abs() < 1e-12, "{n} knots at {x}: {}", curve.at(x, 0) - cubic(x));
        }
    }
    let parabola = Curve::new(uneven(3), |x| 2.0 * x * x - x);
    for x in [-0.1, 0.3, 1.2] {
        assert!((parabola.at(x, 0) - (2.0 * x * x - x)).abs() < 1e-14, "three knots are a parabola");
    }
}

#[test]
fn order_four_up_to_the_ends() {
    let error = |n: usize| {
        let curve = Curve::new(uneven(n), |x| (7.0 * x + 0.5).sin());
        (0..=1000).map(|i| i as f64 / 1000.0).map(|x| (curve.at(x, 0) - (7.0 * x + 0.5).sin()).abs()).fold(0.0, f64::max)
    };
    for n in [65, 129] {
        let order = (error(n) / error(2 * n - 1)).log2();
        // the pre-asymptotic rest is of the size of a step
        assert!((order - 4.0).abs() < 0.2, "{n} knots: {order}");
    }
}

#[test]
fn the_start_of_the_search_does_not_matter() {
    let curve = Curve::new(uneven(20), f64::cos);
    for x in [-0.2, 0.0, 0.31, 0.99, 1.0, 1.2] {
        // the same interval, the same operations
        assert_eq!(curve.at(x, 0), curve.at(x, 10));
        assert_eq!(curve.at(x, 0), curve.at(x, 99));
    }
}

#[test]
fn lines_of_a_bundle_do_not_mix() {
    let (first, second) = (Curve::new(uneven(7), f64::exp), Curve::new((0..7).map(f64::from).collect(), f64::sin));
    let mix = |a: &[f64], b: &[f64]| a.iter().zip(b).flat_map(|(a, b)| [*a, *b]).collect::<Vec<f64>>();
    let x = mix(&first.x, &second.x);
    let mut inverse_pivots = vec![0.0; 14];
    factor(2, &x, &mut inverse_pivots).unwrap();
    let bundle = Bundle::new(2, &x, &inverse_pivots);
    // two fields: the second is the first, doubled
    let values: Vec<[f64; 2]> =
        first.values.iter().zip(&second.values).flat_map(|(a, b)| [[a[0], 2.0 * a[0]], [b[0], 2.0 * b[0]]]).collect();
    let mut bends = vec![[0.0; 2]; 14];
    bundle.bend(&values, &mut bends);
    for (line, curve, x) in [(0, &first, 0.4), (1, &second, 3.3)] {
        let value = bundle.value(&bundle.place(line, x, 0), &values, &bends);
        // the same operations, and doubling is exact
        assert_eq!(value, [curve.at(x, 0), 2.0 * curve.at(x, 0)]);
    }
}

#[test]
fn abscissae_that_do_not_increase_are_named() {
    let bad = |x: &[f64]| factor(1, x, &mut vec![0.0; x.len()]).unwrap_err().knot;
    assert_eq!(bad(&[0.0, 1.0, 1.0, 2.0]), 2);
    assert_eq!(bad(&[0.0, 2.0, 1.0]), 2);
    assert_eq!(bad(&[0.0, f64::NAN]), 1);
    assert_eq!(bad(&[0.0, 1.0, f64::INFINITY]), 2);
    assert_eq!(factor(2, &[0.0, 0.0, 1.0, -1.0], &mut [0.0; 4]), Err(NotIncreasing { knot: 1, line: 1 }));
}
