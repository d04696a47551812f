use super::*;
use std::f64::consts::PI;

/// A lattice over the unit cube of `dimension` axes, deformed.
struct Body {
    counts: [usize; 3],
    position: Vec<Vec<f64>>,
    half_length: Vec<Vec<f64>>,
}

/// The ends of evenly spaced particles are half a spacing beyond them.
fn ends(counts: [usize; 3]) -> [[Vec<f64>; 2]; 3] {
    let weights = |n: usize| match n {
        1 => vec![1.0],
        2 => vec![1.5, -0.5],
        3 => [15.0, -10.0, 3.0].iter().map(|w| w / 8.0).collect(),
        _ => [35.0, -35.0, 21.0, -5.0].iter().map(|w| w / 16.0).collect(),
    };
    counts.map(|n| [weights(n), weights(n)])
}

impl Body {
    /// `map` gives the position and the diagonal of the deformation gradient at a place of the undeformed body.
    fn new(dimension: usize, per_axis: usize, map: impl Fn([f64; 3]) -> ([f64; 3], [f64; 3])) -> Self {
        let counts = std::array::from_fn(|a| if a < dimension { per_axis } else { 1 });
        let mut body = Self { counts, position: vec![Vec::new(); dimension], half_length: vec![Vec::new(); dimension] };
        let spacing = 1.0 / per_axis as f64;
        for p in 0..counts.iter().product() {
            let index = [p / (counts[1] * counts[2]), p / counts[2] % counts[1], p % counts[2]];
            let (x, stretch) = map(index.map(|i| (i as f64 + 0.5) * spacing));
            for a in 0..dimension {
                body.position[a].push(x[a]);
                body.half_length[a].push(0.5 * spacing * stretch[a]);
            }
        }
        body
    }
    fn try_quadrature(&self, axes: &[GridAxis]) -> Result<LineQuadrature, Folded> {
        let mut lines = LineQuadrature::new(self.counts, &ends(self.counts), axes);
        let [position, half_length] = [&self.position, &self.half_length].map(|table| table.iter().map(|c| &c[..]).collect::<Vec<_>>());
        lines.prepare(&position, &half_length).map(|()| lines)
    }
    fn quadrature(&self, axes: &[GridAxis]) -> LineQuadrature {
        self.try_quadrature(axes).unwrap()
    }
    /// A field at the particles.
    fn field(&self, f: impl Fn([f64; 3]) -> f64) -> Vec<f64> {
        let at = |p: usize| std::array::from_fn(|a| self.position.get(a).map_or(0.0, |c| c[p]));
        (0..self.counts.iter().product()).map(|p| f(at(p))).collect()
    }
    fn integral(&self, axes: &[GridAxis], f: impl Fn([f64; 3]) -> f64) -> f64 {
        let lines = self.quadrature(axes);
        let mut values = Vec::new();
        lines.evaluate([&self.field(f)], &mut Scratch::default(), &mut values);
        lines.points().iter().zip(&values).map(|(point, [value])| point.weight * value).sum()
    }
}

/// `cells` cells a unit length, whose faces are not those of the body, with room around.
fn shifted(dimension: usize, cells: usize) -> Vec<GridAxis> {
    let cell = 1.0 / cells as f64;
    (0..dimension).map(|a| GridAxis { origin: -(2.3 + 0.1 * a as f64) * cell, cell, cells: 2 * cells + 5, gauss: 2 }).collect()
}

fn rest(x: [f64; 3]) -> ([f64; 3], [f64; 3]) {
    (x, [1.0; 3])
}

fn volume(lines: &LineQuadrature) -> f64 {
    lines.points().iter().map(|p| p.weight).sum()
}

#[test]
fn full_cells_have_tielens_points() {
    let axis = GridAxis { origin: 0.0, cell: 0.5, cells: 2, gauss: 2 };
    let lines = Body::new(1, 8, rest).quadrature(&[axis]);
    let (quarter, root) = (0.125, (1.0_f64 / 3.0).sqrt());
    let expected: Vec<f64> = [0.0, 0.5]
        .iter()
        .flat_map(|left| [1.0, 3.0].map(|m| left + m * quarter))
        .flat_map(|m| [m - quarter * root, m + quarter * root])
        .collect();
    assert_eq!(lines.points().len(), 8);
    for (i, (point, expected)) in lines.points().iter().zip(expected).enumerate() {
        // round-off of numbers up to 1 (formulas of Tielen 2016, section 7.2)
        assert!((point.position[0] - expected).abs() < 1e-15 && (point.weight - quarter).abs() < 1e-15);
        assert_eq!(point.cell, [i as i32 / 4, 0, 0]);
    }
}

#[test]
fn where_the_body_ends_in_a_half_cell_its_points_move_inside() {
    let axis = GridAxis { origin: -0.2, cell: 0.8, cells: 4, gauss: 2 };
    let lines = Body::new(1, 6, rest).quadrature(&[axis]);
    // half cells end at 0.2, 0.6, 1.0, ...: the body, from 0 to 1, covers half of the first
    let first: Vec<f64> = lines.points()[..2].iter().map(|p| p.position[0]).collect();
    let expected = gauss_legendre(2).iter().map(|(at, _)| 0.2 * at).collect::<Vec<f64>>();
    assert_eq!(lines.points().len(), 6);
    for i in 0..2 {
        // round-off of numbers below 1
        assert!((first[i] - expected[i]).abs() < 1e-15 && (lines.points()[i].weight - 0.1).abs() < 1e-15);
    }
    assert!((volume(&lines) - 1.0).abs() < 1e-15);
}

#[test]
fn what_lies_beyond_the_grid_is_left_out() {
    let axis = |origin: f64, cells: usize| [GridAxis { origin, cell: 0.25, cells, gauss: 3 }];
    let body = Body::new(1, 10, rest);
    // round-off of sums of a few weights below 1
    assert!((volume(&body.quadrature(&axis(0.5, 10))) - 0.5).abs() < 1e-15);
    assert!((volume(&body.quadrature(&axis(-0.5, 3))) - 0.25).abs() < 1e-15);
    assert_eq!(body.quadrature(&axis(3.0, 5)).points().len(), 0);
    assert_eq!(body.quadrature(&axis(-3.0, 5)).points().len(), 0);
}

#[test]
fn points_stand_cell_by_cell_and_in_their_cell() {
    let axes = shifted(3, 3);
    let lines = Body::new(3, 6, |[x, y, z]| ([x + 0.1 * y, y + 0.2 * x * z, z + 0.1 * x], [1.0; 3])).quadrature(&axes);
    assert!(lines.points().is_sorted_by_key(|p| p.cell));
    for point in lines.points() {
        assert!(point.weight > 0.0);
        for a in 0..3 {
            let local = (point.position[a] - axes[a].origin) / axes[a].cell - point.cell[a] as f64;
            // Gauss points lie inside their half cell
            assert!((0.0..1.0).contains(&local), "{local}");
        }
    }
}

#[test]
fn volume_between_straight_edges_is_exact() {
    // a trapezoid with two upright sides, and a wedge: every line and every half-length is linear, which splines reproduce
    let map = |[x, y, z]: [f64; 3]| {
        ([0.1 + 1.2 * x, y * (1.0 + 0.3 * x) + 0.2 * x, z * (1.0 + 0.1 * x) - 0.3 * y], [1.2, 1.0 + 0.3 * x, 1.0 + 0.1 * x])
    };
    // round-off of sums of some thousand weights
    assert!((volume(&Body::new(2, 7, map).quadrature(&shifted(2, 3))) - 1.2 * 1.15).abs() < 1e-12);
    // the integral of (1 + 0.3 x) (1 + 0.1 x)
    assert!((volume(&Body::new(3, 7, map).quadrature(&shifted(3, 3))) - 1.2 * (1.15 + 0.05 + 0.01)).abs() < 1e-12);
    // two inclined ends: the upright ends in their place leave the area as it is
    let inclined = Body::new(2, 7, |[x, y, _]| ([x * (1.0 + 0.2 * y), y, 0.0], [1.0 + 0.2 * y, 1.0, 1.0]));
    assert!((volume(&inclined.quadrature(&shifted(2, 3))) - 1.1).abs() < 1e-12);
}

#[test]
fn volume_of_a_turned_body_is_exact() {
    let turned = Matrix3::new(1.1, -0.3, 0.2, 0.25, 0.9, 0.1, -0.1, 0.3, 1.2);
    for dimension in [2, 3] {
        let mut f = Matrix3::identity();
        f.view_mut((0, 0), (dimension, dimension)).copy_from(&turned.view((0, 0), (dimension, dimension)));
        let map = |x: [f64; 3]| (*(f * nalgebra::Vector3::from(x)).as_ref(), stretches(&f));
        let axes = vec![GridAxis { origin: -1.0, cell: 0.3, cells: 12, gauss: 2 }; dimension];
        // sections of a body that is deformed alike everywhere are all of one size: round-off of sums of some thousand weights
        assert!((volume(&Body::new(dimension, 7, map).quadrature(&axes)) - f.determinant()).abs() < 1e-12);
    }
}

/// Orders of convergence when cells are halved, with 4 particles along a cell.
fn orders(dimension: usize, cells: &[usize], error: impl Fn(usize, &[GridAxis]) -> f64) -> Vec<f64> {
    let errors: Vec<f64> = cells.iter().map(|&n| error(4 * n, &shifted(dimension, n)).abs()).collect();
    let orders = errors.windows(2).map(|e| (e[0] / e[1]).log2()).collect();
    println!("{dimension}D: errors {errors:?}, orders {orders:.2?}");
    orders
}

#[test]
fn volume_between_bent_edges_converges() {
    // a bent upper edge, and a bent end: the stretch changes along all lines and from line to line
    let upper = |[x, y, _]: [f64; 3]| {
        let bend = 0.2 * (3.0 * x).sin();
        ([x + 0.1 * x * x, y + bend * y * y * y, 0.0], [1.0 + 0.2 * x, 1.0 + 3.0 * bend * y * y, 1.0])
    };
    let end = |[x, y, _]: [f64; 3]| {
        let bend = 0.2 * (3.0 * y).sin();
        ([x + bend * x * x * x, y + 0.1 * y * y, 0.0], [1.0 + 3.0 * bend * x * x, 1.0 + 0.2 * y, 1.0])
    };
    // areas below the edges: unit square, its stretch, and the integral of sin(3 s) (1 + 0.2 s)
    let sine = (1.0 - 3.0_f64.cos()) / 3.0;
    let area = 1.1 + 0.2 * (sine + 0.2 * ((3.0_f64).sin() / 9.0 - 3.0_f64.cos() / 3.0));
    // a bent end is a mean over lines, each as wide as its particle says: of second order
    for (map, order) in [(&upper as &dyn Fn([f64; 3]) -> ([f64; 3], [f64; 3]), 3.8..4.4), (&end, 1.9..2.1)] {
        let orders = orders(2, &[2, 4, 8, 16, 32], |n, axes| volume(&Body::new(2, n, map).quadrature(axes)) - area);
        // an end lies where a cubic through the particles beside it leads
        assert!(orders.iter().skip(2).all(|o| order.contains(o)), "{orders:?}");
    }
}

/// A deformation with straight edges, whose stretch does not change to first order at the ends.
fn squeezed(dimension: usize) -> impl Fn([f64; 3]) -> ([f64; 3], [f64; 3]) {
    move |x| {
        let (mut y, mut stretch) = (x, [1.0; 3]);
        for a in 0..dimension {
            let strength = 0.2 * if dimension == 1 { 1.0 } else { (x[(a + 1) % dimension] - 0.3 * a as f64).cos() };
            y[a] += strength * (2.0 * PI * x[a]).sin() / (2.0 * PI);
            stretch[a] += strength * (2.0 * PI * x[a]).cos();
        }
        (y, stretch)
    }
}

#[test]
fn integrals_of_smooth_functions_are_of_third_order() {
    // exp over the unit interval, by axis with other factors: no symmetry that would hide an error
    let rate = [1.3, -0.8, 0.6];
    let cells: [&[usize]; 3] = [&[4, 8, 16, 32, 64], &[4, 8, 16, 32], &[2, 4, 8]];
    for dimension in 1..=3 {
        let exact: f64 = rate[..dimension].iter().map(|r: &f64| r.exp_m1() / r).product();
        let f = |x: [f64; 3]| (0..dimension).map(|a| rate[a] * x[a]).sum::<f64>().exp();
        let orders =
            orders(dimension, cells[dimension - 1], |n, axes| Body::new(dimension, n, squeezed(dimension)).integral(axes, f) - exact);
        // the natural end condition is wrong by a second derivative on a layer of one particle: h^2 h; coarse grids scatter
        assert!(orders.iter().skip(1).all(|o| *o > 2.8), "{dimension}D: {orders:?}");
    }
}

#[test]
fn fields_linear_in_space_are_exact() {
    // splines of linear data are exact along any line of a lattice that is itself deformed linearly
    let body = Body::new(3, 5, |[x, y, z]| ([x + 0.1 * y, y - 0.2 * x, z + 0.3 * x + 0.1 * y], [1.0; 3]));
    let lines = body.quadrature(&shifted(3, 2));
    let linear = |x: [f64; 3]| 1.0 + 2.0 * x[0] - 3.0 * x[1] + 0.5 * x[2];
    let (mut scratch, mut values) = (Scratch::default(), Vec::new());
    lines.evaluate([&body.field(linear), &body.field(|x| -linear(x))], &mut scratch, &mut values);
    for (point, value) in lines.points().iter().zip(&values) {
        // round-off of numbers below 10, three splines deep
        assert!((value[0] - linear(point.position)).abs() < 1e-12 && (value[0] + value[1]).abs() < 1e-12);
    }
    // the buffers may come from another body
    let small = Body::new(3, 2, rest);
    let lines = small.quadrature(&shifted(3, 2));
    lines.evaluate([&small.field(linear), &small.field(linear)], &mut scratch, &mut values);
    assert_eq!(values.len(), lines.points().len());
    assert!(lines.points().iter().zip(&values).all(|(point, v)| (v[0] - linear(point.position)).abs() < 1e-12));
}

#[test]
fn a_mirrored_body_has_mirrored_points() {
    let mirror = |[x, y, z]: [f64; 3]| [1.0 - x, y, z];
    let map = |[x, y, _]: [f64; 3]| ([x + 0.1 * x * x, y + 0.1 * x * y, 0.0], [1.0 + 0.2 * x, 1.0 + 0.1 * x, 1.0]);
    let mirrored = |x: [f64; 3]| (mirror(map(mirror(x)).0), map(mirror(x)).1);
    let (here, there) = (Body::new(2, 9, map), Body::new(2, 9, mirrored));
    let axes = shifted(2, 3);
    let mut mirrored_axes = axes.clone();
    mirrored_axes[0].origin = 1.0 - (axes[0].origin + axes[0].cell * axes[0].cells as f64);
    let f = |x: [f64; 3]| (2.0 * x[0] + x[1]).sin();
    let table = |body: &Body, axes: &[GridAxis], flip: bool| {
        let lines = body.quadrature(axes);
        let mut values = Vec::new();
        let at = |x: [f64; 3]| if flip { mirror(x) } else { x };
        lines.evaluate([&body.field(|x| f(at(x)))], &mut Scratch::default(), &mut values);
        let mut rows: Vec<[f64; 4]> =
            lines.points().iter().zip(values).map(|(p, v)| [at(p.position)[0], p.position[1], p.weight, v[0]]).collect();
        // by columns of points, whose x agree to round-off
        rows.sort_by_key(|row| row.map(|v| (v * 1e9).round() as i64));
        rows
    };
    let (here, there) = (table(&here, &axes, false), table(&there, &mirrored_axes, true));
    assert_eq!(here.len(), there.len());
    for (a, b) in here.iter().zip(&there) {
        for i in 0..4 {
            // round-off: elimination runs from the other end
            assert!((a[i] - b[i]).abs() < 1e-13, "{a:?} {b:?}");
        }
    }
}

#[test]
fn folds_are_found_in_the_lattice() {
    let mut body = Body::new(3, 5, rest);
    body.position[0][(2 * 5 + 3) * 5 + 4] = -1.0;
    assert_eq!(body.try_quadrature(&shifted(3, 2)).unwrap_err(), Folded { axis: 0, index: [2, 3, 4] });
    // an object that has failed has nothing to evaluate, and works again
    let (mut lines, mut values) = (LineQuadrature::new(body.counts, &ends(body.counts), &shifted(3, 2)), vec![[1.0]]);
    let Body { position: good, half_length: half, .. } = Body::new(3, 5, rest);
    for (position, folds) in [(&good, false), (&body.position, true), (&good, false)] {
        let slices = [position, &half].map(|table| table.iter().map(|c| &c[..]).collect::<Vec<_>>());
        assert_eq!(lines.prepare(&slices[0], &slices[1]).is_err(), folds);
        lines.evaluate([&position[0]], &mut Scratch::default(), &mut values);
        assert!(values.len() == lines.points().len() && values.is_empty() == folds);
    }
    for (axis, step) in [(1, 5), (2, 1)] {
        let mut body = Body::new(3, 5, rest);
        let particle = (2 * 5 + 3) * 5 + 4;
        body.position[axis][particle] = body.position[axis][particle - step] - 0.5;
        let folded = body.try_quadrature(&shifted(3, 2)).unwrap_err();
        // sections see the fold from a knot or two before it on, as far as the spline is bent by it
        assert!(folded.axis == axis && folded.index[0].abs_diff(2) <= 2, "{folded:?}");
    }
}
