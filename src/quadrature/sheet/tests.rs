use super::*;
use std::f64::consts::PI;

fn axes() -> [GridAxis; 2] {
    [0, 1].map(|_| GridAxis { origin: -2.0, cell: 0.125, cells: 32, gauss: 4 })
}

fn even(n: usize) -> Vec<f64> {
    (0..n).map(|i| (i as f64 + 0.5) / n as f64).collect()
}

/// A sheet of `n` by `m` particles under a map.
fn sheet([n, m]: [usize; 2], joined: bool, map: impl Fn(f64, f64) -> [f64; 2]) -> (SheetQuadrature, [Vec<f64>; 2]) {
    let places: Vec<[f64; 2]> = even(n).iter().flat_map(|s| even(m).iter().map(|t| map(*s, *t)).collect::<Vec<_>>()).collect();
    let columns = [0, 1].map(|a| places.iter().map(|x| x[a]).collect::<Vec<f64>>());
    let mut sheet = SheetQuadrature::new([&even(n), &even(m)], joined, axes());
    sheet.prepare([&columns[0], &columns[1]]).unwrap();
    (sheet, columns)
}

/// Area and a second moment of a sheared ring, whose particles have turned by an angle that depends on the radius.
fn ring(n: usize) -> ([f64; 2], SheetQuadrature) {
    let map = |s: f64, t: f64| {
        let (r, angle) = (0.75 + 0.5 * s, 2.0 * PI * t + 0.3 * (PI * s).sin());
        [0.03 + r * angle.cos(), 0.01 + r * angle.sin()]
    };
    let (sheet, columns) = sheet([n, 10 * n], true, map);
    // a field that is known where the points are
    let field: Vec<f64> = columns[0].iter().zip(&columns[1]).map(|(x, y)| (2.0 * x + y).sin()).collect();
    let (mut coefficients, mut values) = (Vec::new(), Vec::new());
    sheet.fit([&field], &mut coefficients);
    sheet.at_points::<1>(&coefficients, &mut values);
    let area: f64 = sheet.points().iter().map(|point| point.weight).sum();
    let miss = sheet.points().iter().zip(&values).map(|(p, v)| (v[0] - (2.0 * p.position[0] + p.position[1]).sin()).abs());
    ([(area - PI * (1.25f64.powi(2) - 0.75f64.powi(2))).abs(), miss.fold(0.0, f64::max)], sheet)
}

#[test]
fn a_ring_that_is_sheared_converges_with_the_order_of_the_splines() {
    let ([area, field], coarse) = ring(24);
    let ([finer_area, finer_field], _) = ring(48);
    println!("{area:e} {field:e}, {finer_area:e} {finer_field:e}");
    assert!((area / finer_area).log2() > 3.5 && (field / finer_field).log2() > 3.5);
    assert!(coarse.points().iter().all(|point| point.weight > 0.0));
    // both rims are closed
    for a in 0..2 {
        assert!(coarse.edge().iter().map(|point| point.area[a]).sum::<f64>().abs() < 1e-13);
    }
    // and along each the square is gone through once
    for upper in [false, true] {
        let length: f64 = coarse.sides().iter().filter(|point| point.side == (0, upper)).map(|point| point.share).sum();
        assert!((length - 1.0).abs() < 1e-13);
    }
}

/// A square under a linear map is integrated exactly wherever it lies.
#[test]
fn a_turned_square_is_exact() {
    for k in 0..60 {
        let (sin, cos) = (0.1 * f64::from(k)).sin_cos();
        let map = |s: f64, t: f64| [-0.2 + cos * 1.1 * s - sin * 0.7 * t, 0.1 + sin * 1.1 * s + cos * 0.7 * t];
        let (sheet, columns) = sheet([7, 5], false, map);
        let area: f64 = sheet.points().iter().map(|point| point.weight).sum();
        // round-off of some hundred cells
        assert!((area - 0.77).abs() < 1e-13, "{k}: {area}");
        // positions are a field like any other
        let (mut coefficients, mut values) = (Vec::new(), Vec::new());
        sheet.fit([&columns[0], &columns[1]], &mut coefficients);
        sheet.at_points::<2>(&coefficients, &mut values);
        for (point, value) in sheet.points().iter().zip(&values) {
            assert!((point.position[0] - value[0]).abs() < 1e-13 && (point.position[1] - value[1]).abs() < 1e-13);
        }
        sheet.at_edge::<2>(&coefficients, &mut values);
        for (point, value) in sheet.edge().iter().zip(&values) {
            assert!((point.position[0] - value[0]).abs() < 1e-13 && (point.position[1] - value[1]).abs() < 1e-13);
        }
    }
}

#[test]
fn a_folded_sheet_is_refused() {
    let mut sheet = SheetQuadrature::new([&even(6), &even(6)], false, axes());
    let x: Vec<f64> = (0..36).map(|p| [0.1, 0.2, 0.3, 0.25, 0.1, 0.0][p / 6]).collect();
    let y: Vec<f64> = (0..36).map(|p| 0.1 * (p % 6) as f64).collect();
    assert!(sheet.prepare([&x, &y]).is_err());
    let x: Vec<f64> = (0..36).map(|p| if p == 7 { f64::NAN } else { 0.1 * (p / 6) as f64 }).collect();
    assert!(sheet.prepare([&x, &y]).is_err());
}
