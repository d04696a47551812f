use super::bound::dot;
use super::*;
use std::f64::consts::PI;

fn axes(gauss: usize, cell: f64) -> [GridAxis; 3] {
    let axis = |cell: f64| GridAxis { origin: -1.5, cell, cells: (3.0 / cell).round() as usize, gauss };
    [axis(cell), axis(1.2 * cell), axis(cell)]
}

fn sum(points: &[Point], f: impl Fn([f64; 3]) -> f64) -> f64 {
    points.iter().map(|point| point.weight * f(point.position)).sum()
}

/// Axes of a frame turned about an axis askew.
fn frame(angle: f64) -> [[f64; 3]; 3] {
    let axis = nalgebra::Unit::new_normalize(nalgebra::Vector3::new(0.3, -0.5, 0.8));
    let turn = nalgebra::Rotation3::from_axis_angle(&axis, angle);
    [0, 1, 2].map(|k| [0, 1, 2].map(|a| turn[(a, k)]))
}

const SIZE: [f64; 3] = [1.1, 0.7, 0.9];

/// A box of [`SIZE`] with this lower corner, along the axes of a frame.
fn turned(corner: [f64; 3], frame: &[[f64; 3]; 3]) -> Vec<Bound> {
    (0..3)
        .flat_map(|k| {
            let start = dot(&frame[k], &corner);
            [Bound::Plane { normal: frame[k].map(|n| -n), offset: -start }, Bound::Plane { normal: frame[k], offset: start + SIZE[k] }]
        })
        .collect()
}

/// Integral over such a box, by a rule that is exact.
fn exact(corner: [f64; 3], frame: &[[f64; 3]; 3], f: impl Fn([f64; 3]) -> f64) -> f64 {
    let rule = gauss_legendre(6);
    let mut sum = 0.0;
    for (r, u) in &rule {
        for (s, v) in &rule {
            for (t, w) in &rule {
                let at = [0, 1, 2].map(|a| corner[a] + r * SIZE[0] * frame[0][a] + s * SIZE[1] * frame[1][a] + t * SIZE[2] * frame[2][a]);
                sum += u * v * w * SIZE.iter().product::<f64>() * f(at);
            }
        }
    }
    sum
}

#[test]
fn polynomials_are_exact_in_boxes_anywhere() {
    let mut most = (0.0f64, 0.0f64, 0usize);
    for k in 0..60 {
        let t = f64::from(k);
        let place = [0.3 * (1.3 * t).sin(), 0.3 * (2.1 * t).cos(), 0.3 * (0.7 * t).cos()];
        // some along the grid, on its lines, and on them but for round-off
        let (corner, frame) = match k % 4 {
            0 => (place.map(|x| x - 0.5), frame(0.0)),
            1 => ([-0.5, -0.3, 0.25 + 1e-17 * t], frame(0.0)),
            2 => {
                // quarter turns, with cosines that are not quite 0
                let (sin, cos) = (0.5 * PI * t).sin_cos();
                ([0.25, 0.3, -0.25], [[cos, sin, 0.0], [-sin, cos, 0.0], [0.0, 0.0, 1.0]])
            }
            _ => {
                let frame = frame(0.37 * t);
                ([0, 1, 2].map(|a| place[a] - 0.5 * (0..3).map(|k| SIZE[k] * frame[k][a]).sum::<f64>()), frame)
            }
        };
        let solid = Solid { parts: vec![turned(corner, &frame)] };
        let made = SolidQuadrature::new(&axes(4, 0.25), &solid);
        for powers in [[0, 0, 0], [1, 0, 0], [0, 0, 1], [3, 2, 1], [2, 1, 3], [0, 6, 0]] {
            let f = |x: [f64; 3]| (0..3).map(|a| x[a].powi(powers[a])).product::<f64>();
            let (found, exact) = (sum(&made.points, f), exact(corner, &frame, f));
            most.0 = most.0.max((found - exact).abs());
            // round-off of some ten thousand points, and slivers that are nothing: 1e-13 of a cell
            assert!((found - exact).abs() < 2e-13, "{k}: {powers:?} {found} {exact}");
        }
        for side in 0..6 {
            let k = side / 2;
            let area = SIZE[(k + 1) % 3] * SIZE[(k + 2) % 3];
            for a in 0..3 {
                let of_side = made.surface.iter().filter(|point| point.bound == [0, side as u32]);
                let found: f64 = of_side.map(|point| point.area[a]).sum();
                let exact = area * frame[k][a] * if side % 2 == 0 { -1.0 } else { 1.0 };
                most.1 = most.1.max((found - exact).abs());
                assert!((found - exact).abs() < 2e-13, "{side} along {a}: {found} {exact}");
            }
        }
        assert!(made.points.iter().all(|point| point.weight > 0.0));
        let cells = made.points.chunk_by(|a, b| a.cell == b.cell).count();
        most.2 = most.2.max(made.points.len() / cells);
    }
    println!("turned boxes: integrals off by {:e}, faces by {:e}; at most {} points a cell", most.0, most.1, most.2);
}

/// Figures of a body with spheres: errors of volume, second moments, area and of the divergence theorem; points of a cut cell over those of a
/// whole one.
fn figures(solid: &Solid, gauss: usize, cell: f64, [volume, second, area]: [f64; 3], middle: [f64; 3]) -> [f64; 5] {
    let axes = axes(gauss, cell);
    let made = SolidQuadrature::new(&axes, solid);
    assert!(made.points.iter().all(|point| point.weight > 0.0));
    let inside = |x: &[f64; 3]| {
        let within = |bounds: &Vec<Bound>| bounds.iter().all(|bound| bound.distance(x) < 0.0);
        within(&solid.parts[0]) && !solid.parts[1..].iter().any(within)
    };
    assert!(made.points.iter().all(|point| inside(&point.position)));
    let square = |x: &[f64; 3]| (0..3).map(|a| (x[a] - middle[a]).powi(2)).sum::<f64>();
    let areas: f64 = made.surface.iter().map(|point| dot(&point.area, &point.area).sqrt()).sum();
    // div (x^3, x y z, z^2 y)
    let field = |[x, y, z]: [f64; 3]| [x * x * x, x * y * z, z * z * y];
    let out: f64 = made.surface.iter().map(|point| dot(&field(point.position), &point.area)).sum();
    let within = sum(&made.points, |[x, y, z]| 3.0 * x * x + x * z + 2.0 * z * y);
    let whole = gauss.pow(3);
    let (mut cut, mut in_cut) = (0, 0);
    for cell in made.points.chunk_by(|a, b| a.cell == b.cell) {
        if cell.len() != whole {
            cut += 1;
            in_cut += cell.len();
        }
    }
    [
        (sum(&made.points, |_| 1.0) - volume).abs() / volume,
        (sum(&made.points, |x| square(&x)) - second).abs() / second,
        (areas - area).abs() / area,
        (out - within).abs() / within.abs(),
        f64::from(in_cut as u32) / f64::from(cut * whole as u32),
    ]
}

fn ball(center: [f64; 3], radius: f64) -> Vec<Bound> {
    vec![Bound::Sphere { center, radius }]
}

/// A hollow sphere with radii of 3.6 and 1.6 of the largest cells.
#[test]
fn spheres_converge_with_the_order_of_the_rule() {
    let middle = [0.031, -0.047, 0.013];
    let of = |r: f64| [4.0 / 3.0 * PI * r.powi(3), 0.8 * PI * r.powi(5), 4.0 * PI * r * r];
    let (outer, inner) = (of(0.9), of(0.4));
    let hollow = [outer[0] - inner[0], outer[1] - inner[1], outer[2] + inner[2]];
    let solid = Solid { parts: vec![ball(middle, 0.9), ball(middle, 0.4)] };
    for gauss in [2, 3, 4, 6] {
        let all = [0.25, 0.125, 0.0625].map(|cell| {
            let found = figures(&solid, gauss, cell, hollow, middle);
            let [volume, second, area, divergence, more] = found.map(|v| format!("{v:.1e}"));
            println!("hollow sphere, {gauss} points, cell {cell}: volume off by {volume}, second moment {second}, area {area}, divergence theorem {divergence}; {more} times the points of a whole cell in a cut one");
            found
        });
        // over two halvings, in which single errors go up and down with how cells are cut: 2 n where they did not
        let orders = [0, 1, 2, 3].map(|k| (all[0][k] / all[2][k].max(1e-15)).log2() / 2.0);
        println!("   orders {orders:.1?}");
        let least = 2.0 * gauss as f64 - 2.5;
        assert!(
            gauss == 6 && all[2][..4].iter().all(|off| *off < 1e-11) || orders.iter().all(|order| *order >= least),
            "{gauss}: {orders:?}"
        );
        assert!(all.iter().all(|found| found[4] < 4.0));
    }
}

/// A turned box with a sphere in it that shares cells with its faces, and one with a box: exact where all is flat.
#[test]
fn holes_that_share_cells_with_faces_are_integrated() {
    let (corner, frame) = ([-0.55, -0.1, -0.5], frame(0.4));
    let middle = [0, 1, 2].map(|a| corner[a] + (0..3).map(|k| 0.5 * SIZE[k] * frame[k][a]).sum::<f64>());
    let volume: f64 = SIZE.iter().product();
    let second = exact(corner, &frame, |x| (0..3).map(|a| (x[a] - middle[a]).powi(2)).sum());
    let area = 2.0 * (SIZE[0] * SIZE[1] + SIZE[1] * SIZE[2] + SIZE[2] * SIZE[0]);
    let r = 0.34f64;
    let round = Solid { parts: vec![turned(corner, &frame), ball(middle, r)] };
    let left = [volume - 4.0 / 3.0 * PI * r.powi(3), second - 0.8 * PI * r.powi(5), area + 4.0 * PI * r * r];
    let found = figures(&round, 4, 0.25, left, middle);
    println!("box with a sphere: {found:?}");
    // that of the sphere, of 1.4 cells
    assert!(found[..4].iter().all(|off| *off < 2e-4));

    // a cube of half the size: 1/8 of the volume, 1/32 of the second moment
    let inner = turned(corner, &frame).into_iter().map(|bound| match bound {
        Bound::Plane { normal, offset } => Bound::Plane { normal, offset: 0.5 * (offset + dot(&normal, &middle)) },
        sphere => sphere,
    });
    let flat = Solid { parts: vec![turned(corner, &frame), inner.collect()] };
    let left = [volume * 7.0 / 8.0, second * 31.0 / 32.0, area * 1.25];
    let found = figures(&flat, 4, 0.25, left, middle);
    println!("box with a box: {found:?}");
    // round-off
    assert!(found[..4].iter().all(|off| *off < 1e-12));
}

/// A sphere that touches grid lines and planes, is smaller than a cell, or larger than many; nothing is lost, and nothing takes for ever.
#[test]
fn spheres_anywhere_have_their_volume() {
    let mut worst = [0.0f64; 2];
    for (center, radius) in [
        ([0.0, 0.0, 0.0], 0.5),
        ([0.0, 0.0, 0.0], 0.25),
        ([0.125, 0.1, 0.0], 0.375),
        ([0.1, 0.1, 0.1], 0.02),
        ([0.25, 0.3, 0.0], 0.004),
        ([1e-12, -1e-9, 1e-15], 0.75),
        ([0.01, 0.02, 0.03], 1.3),
    ] {
        let solid = Solid { parts: vec![ball(center, radius)] };
        let exact = [4.0 / 3.0 * PI * f64::powi(radius, 3), 0.8 * PI * f64::powi(radius, 5), 4.0 * PI * radius * radius];
        let found = figures(&solid, 4, 0.25, exact, center);
        println!("sphere of {radius}: {found:?}");
        worst = [worst[0].max(found[0]), worst[1].max(found[2])];
    }
    // that of a sphere which is as large as a cell or smaller, in eight pieces
    assert!(worst[0] < 1e-4 && worst[1] < 1e-4, "{worst:?}");
}
