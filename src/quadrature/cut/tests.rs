use super::*;
use std::f64::consts::PI;

fn axes(gauss: usize) -> [GridAxis; 2] {
    [GridAxis { origin: -1.0, cell: 0.25, cells: 12, gauss }, GridAxis { origin: -1.0, cell: 0.2, cells: 15, gauss }]
}

fn prepared(gauss: usize, loops: &[Vec<Curve>]) -> CutQuadrature {
    let mut cut = CutQuadrature::new(axes(gauss));
    cut.prepare(loops).unwrap();
    cut
}

/// A polygon, and the integral of x^m y^n over it by Green's theorem with a rule that is exact.
fn polygon(corners: &[[f64; 2]]) -> Vec<Curve> {
    (0..corners.len()).map(|i| Curve::Segment(corners[i], corners[(i + 1) % corners.len()])).collect()
}

fn exact(curves: &[Curve], m: i32, n: i32) -> f64 {
    let rule = gauss_legendre(12);
    let along = |curve: &Curve| -> f64 {
        rule.iter()
            .map(|(s, weight)| {
                let [place, slope] = curve.at(*s);
                weight * place[0].powi(m + 1) / f64::from(m + 1) * place[1].powi(n) * slope[1]
            })
            .sum()
    };
    curves.iter().map(along).sum()
}

fn sum(cut: &CutQuadrature, f: impl Fn([f64; 3]) -> f64) -> f64 {
    cut.points.iter().map(|point| point.weight * f(point.position)).sum()
}

/// A rectangle of 1.1 by 0.7, moved and turned.
fn rectangle(place: [f64; 2], angle: f64) -> Vec<Curve> {
    let (sin, cos) = angle.sin_cos();
    let corner = |[x, y]: [f64; 2]| [place[0] + cos * x - sin * y, place[1] + sin * x + cos * y];
    polygon(&[[0.0, 0.0], [1.1, 0.0], [1.1, 0.7], [0.0, 0.7]].map(corner))
}

#[test]
fn polynomials_are_exact_in_rectangles_anywhere() {
    for k in 0..200 {
        let t = f64::from(k);
        let place = [0.5 + 0.15 * (1.3 * t).sin(), 0.5 + 0.15 * (2.1 * t).cos()];
        // some along the grid and on its lines
        let (place, angle) = match k % 4 {
            0 => ([0.5, 0.4], 0.5 * PI * (t / 4.0).floor()),
            1 => ([0.25 * (t / 4.0 % 4.0).floor(), 0.2 + 1e-12 * t], 0.0),
            _ => (place, 0.37 * t),
        };
        let curves = rectangle(place, angle);
        let cut = prepared(4, std::slice::from_ref(&curves));
        for (m, n) in [(0, 0), (1, 0), (0, 1), (3, 2), (2, 4)] {
            let (found, exact) = (sum(&cut, |x| x[0].powi(m) * x[1].powi(n)), exact(&curves, m, n));
            // round-off; along a grid line the edge may stray by 1e-9 of a cell, but here by 1e-12 times 200
            assert!((found - exact).abs() < 1e-12, "{k}: x^{m} y^{n} {found} {exact}");
        }
        assert!(cut.points.iter().all(|point| point.weight > 0.0), "{k}");
        // cell by cell: no cell has more than its area
        assert!(cut.cells.iter().all(|cell| cell.share < 1.0 + 1e-12));
        let out: [f64; 2] = std::array::from_fn(|a| cut.edge.iter().map(|point| point.area[a]).sum());
        assert!(out.iter().all(|sum| sum.abs() < 1e-14));
    }
}

#[test]
fn a_rectangle_along_the_grid_is_made_of_full_cells() {
    let cut = prepared(3, &[polygon(&[[-0.5, 0.0], [0.5, 0.0], [0.5, 0.4], [-0.5, 0.4]])]);
    assert_eq!(cut.cells.len(), 8);
    assert!(cut.cells.iter().all(|cell| (cell.share - 1.0).abs() < 1e-13));
    // and one that fills the grid
    let cut = prepared(3, &[polygon(&[[-1.0, -1.0], [2.0, -1.0], [2.0, 2.0], [-1.0, 2.0]])]);
    assert_eq!(cut.cells.len(), 12 * 15);
}

#[test]
fn a_ring_converges_with_the_order_of_the_rule() {
    let circle = |radius: f64, sign: f64| -> Vec<Curve> {
        (0..4).map(|k| Curve::Arc { center: [0.31, 0.47], radius, start: sign * 0.5 * PI * f64::from(k), turn: sign * 0.5 * PI }).collect()
    };
    let loops = [circle(0.9, 1.0), circle(0.5, -1.0)];
    let errors = [2, 4, 6].map(|gauss| {
        let cut = prepared(gauss, &loops);
        let area = sum(&cut, |_| 1.0);
        let second = sum(&cut, |x| (x[0] - 0.31).powi(2) + (x[1] - 0.47).powi(2));
        let (r, s) = (0.9f64, 0.5f64);
        (area - PI * (r * r - s * s)).abs() + (second - 0.5 * PI * (r.powi(4) - s.powi(4))).abs()
    });
    println!("{errors:?}");
    assert!(errors[0] < 1e-5 && errors[1] < 1e-9 && errors[2] < 1e-13);
    assert!(prepared(4, &loops).points.iter().all(|point| point.weight > 0.0));
}

/// A hole that reaches through a side of a cell leaves two parts of it.
#[test]
fn cells_that_fall_into_parts_have_positive_weights() {
    for k in 0..400 {
        let t = f64::from(k);
        let center = [0.5 + 0.3 * (1.7 * t).sin(), 0.5 + 0.3 * (2.9 * t).cos()];
        let radius = 0.6 + 0.3 * (0.618 * t).fract();
        let hole = (0..4).map(|k| Curve::Arc { center, radius, start: -0.5 * PI * f64::from(k), turn: -0.5 * PI }).collect();
        let cut = prepared(4, &[polygon(&[[-1.0, -1.0], [2.0, -1.0], [2.0, 2.0], [-1.0, 2.0]]), hole]);
        let area = sum(&cut, |_| 1.0);
        // of the order of the rule, for arcs as long as a cell
        assert!((area - (9.0 - PI * radius * radius)).abs() < 1e-9, "{k}: {area}");
        let worst = cut.points.iter().map(|point| point.weight).fold(f64::INFINITY, f64::min);
        println!("{k} {radius} {worst}");
    }
}

#[test]
fn a_bent_cubic_edge_keeps_area_and_normal() {
    // a bulging side: y = 0.2 s (1 - s)
    let bulge = Curve::Cubic([[0.9, 0.6], [-0.8, 0.17], [0.0, -0.2], [0.0, 0.03]]);
    let curves =
        vec![Curve::Segment([0.1, 0.1], [0.9, 0.1]), Curve::Segment([0.9, 0.1], [0.9, 0.6]), bulge, Curve::Segment([0.1, 0.6], [0.1, 0.1])];
    let cut = prepared(4, std::slice::from_ref(&curves));
    assert!((sum(&cut, |_| 1.0) - exact(&curves, 0, 0)).abs() < 1e-13);
    assert!((sum(&cut, |x| x[0] * x[1]) - exact(&curves, 1, 1)).abs() < 1e-8);
}

#[test]
fn an_edge_that_is_not_finite_is_lost() {
    let mut cut = CutQuadrature::new(axes(3));
    assert!(cut.prepare(&[polygon(&[[0.0, 0.0], [f64::NAN, 0.0], [0.0, 1.0]])]).is_err());
}
