use super::super::taylor::functions;
use super::*;

/// SplitMix64, uniform in \[0, 1).
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    }
}

/// Particles that fill the unit cube, or what of it `keep` says.
struct Cloud {
    position: Vec<Vec<f64>>,
    volume: Vec<f64>,
}

impl Cloud {
    /// `per_axis` particles an axis, each moved by up to `jitter` of its spacing.
    fn new(dimension: usize, per_axis: usize, jitter: f64, keep: impl Fn(&[f64; 3]) -> bool) -> Self {
        let spacing = 1.0 / per_axis as f64;
        let mut random = Random(7);
        let mut cloud = Self { position: vec![Vec::new(); dimension], volume: Vec::new() };
        for p in 0..per_axis.pow(dimension as u32) {
            let index = [p % per_axis, p / per_axis % per_axis, p / per_axis.pow(2)];
            let x = index.map(|i| (i as f64 + 0.5 + jitter * (2.0 * random.next() - 1.0)) * spacing);
            if keep(&x) {
                (0..dimension).for_each(|a| cloud.position[a].push(x[a]));
                cloud.volume.push(spacing.powi(dimension as i32));
            }
        }
        cloud
    }
    fn quadrature(&self, cells: usize, gauss: usize, full_share: f64) -> CellQuadrature {
        let axis = GridAxis { origin: 0.0, cell: 1.0 / cells as f64, cells, gauss };
        let mut quadrature = CellQuadrature::new(&vec![axis; self.position.len()], full_share);
        quadrature.prepare(&self.position.iter().map(|c| &c[..]).collect::<Vec<_>>(), &self.volume);
        quadrature
    }
    fn field(&self, f: impl Fn([f64; 3]) -> f64) -> Vec<f64> {
        (0..self.volume.len()).map(|p| f(std::array::from_fn(|a| self.position.get(a).map_or(0.0, |c| c[p])))).collect()
    }
}

#[test]
fn quadratics_are_exact_with_random_particles() {
    let f = |[x, y, z]: [f64; 3]| 1.0 + 2.0 * x - y + 0.5 * z + 3.0 * x * x - x * y + 2.0 * y * y + y * z - z * z + 0.7 * x * z;
    for dimension in 1..=3 {
        let cloud = Cloud::new(dimension, 8, 0.4, |_| true);
        let quadrature = cloud.quadrature(2, 3, FULL_SHARE);
        assert!(quadrature.cells().iter().all(|cell| cell.fit.unwrap().functions == functions(dimension, 2)));
        let mut values = Vec::new();
        quadrature.evaluate([&cloud.field(f), &cloud.field(|x| -2.0 * f(x))], &mut values);
        assert_eq!(values.len(), quadrature.points().len());
        for (point, value) in quadrature.points().iter().zip(&values) {
            // round-off 1e-16 times the condition, which the threshold of the pivots bounds
            assert!((value[0] - f(point.position)).abs() < 1e-12 && (value[1] + 2.0 * f(point.position)).abs() < 1e-12);
        }
    }
}

/// Degree of the fit of one cell from 0 to 1 whose particles stand at these places.
fn degree(dimension: usize, places: &[[f64; 2]]) -> usize {
    let volume = vec![1.0 / places.len() as f64; places.len()];
    let position = (0..dimension).map(|a| places.iter().map(|x| x[a]).collect()).collect();
    let found = Cloud { position, volume }.quadrature(1, 1, FULL_SHARE).cells()[0].fit.unwrap().functions;
    (0..3).find(|degree| functions(dimension, *degree) == found).unwrap()
}

#[test]
fn too_few_or_badly_placed_particles_lower_the_degree() {
    let line = |places: &[f64]| degree(1, &places.iter().map(|x| [*x, 0.0]).collect::<Vec<_>>());
    assert_eq!(line(&[0.1, 0.5, 0.9]), 2);
    assert_eq!(line(&[0.1, 0.6]), 1);
    assert_eq!(line(&[0.1]), 0);
    assert_eq!(line(&[0.5, 0.5]), 0);
    assert_eq!(line(&[0.5, 0.501, 0.502, 0.503]), 0);
    assert_eq!(line(&[0.1, 0.101, 0.9, 0.901]), 1);
    let plane: Vec<[f64; 2]> = (0..9).map(|i| [0.2 + 0.3 * (i % 3) as f64, 0.2 + 0.3 * (i / 3) as f64]).collect();
    assert_eq!(degree(2, &plane), 2);
    // 2 x 2 particles do not know the squares
    assert_eq!(degree(2, &[[0.2, 0.2], [0.2, 0.8], [0.8, 0.2], [0.8, 0.8]]), 1);
    // on one line across the plane
    assert_eq!(degree(2, &[0.1, 0.2, 0.3, 0.5, 0.7, 0.8, 0.9].map(|s| [s, s])), 0);
}

#[test]
fn cells_at_the_surface_are_left_to_particles() {
    // the body ends within the column of cells 6 and on the face between rows 7 and 8
    let cloud = Cloud::new(2, 40, 0.0, |x| x[0] < 0.64 && x[1] < 0.8);
    let quadrature = cloud.quadrature(10, 2, FULL_SHARE);
    for cell in quadrature.cells() {
        // column 6 is cut, row 7 has no row above; the sides of the grid do not count
        assert_eq!(cell.fit.is_some(), cell.index[0] < 6 && cell.index[1] < 7, "{:?}", cell.index);
    }
    let points: f64 = quadrature.points().iter().map(|p| p.weight).sum();
    let particles: f64 = quadrature.left().map(|p| cloud.volume[p]).sum();
    // round-off of sums of some hundred numbers; the particles kept make 26 / 40 by 32 / 40
    assert!((points + particles - 0.65 * 0.8).abs() < 1e-13);
    assert!((points - 0.6 * 0.7).abs() < 1e-13);
    assert!(quadrature.points().is_sorted_by_key(|p| p.cell));
}

#[test]
fn a_surface_across_the_grid_lets_no_cut_cell_pass() {
    let cloud = Cloud::new(2, 40, 0.0, |x| x[0] + x[1] < 0.97);
    let quadrature = cloud.quadrature(10, 2, FULL_SHARE);
    for cell in quadrature.cells() {
        let upper_corner = (cell.index[0] + cell.index[1] + 2) as f64 / 10.0;
        assert!(cell.fit.is_none() || upper_corner < 0.97, "{:?}", cell.index);
    }
    assert!(quadrature.points().len() > 100);
}

#[test]
fn a_cell_with_a_gap_is_left_to_particles() {
    let cloud = Cloud::new(2, 40, 0.0, |x| !(x[0] > 0.5 && x[0] < 0.6 && x[1] > 0.5 && x[1] < 0.57));
    let quadrature = cloud.quadrature(10, 2, FULL_SHARE);
    let left: Vec<[i32; 3]> = quadrature.cells().iter().filter(|cell| cell.fit.is_none()).map(|cell| cell.index).collect();
    assert_eq!(left, [[5, 5, 0]]);
}

#[test]
fn integrals_are_of_third_order_with_jittered_particles() {
    for (dimension, cells) in [(1, &[4, 8, 16, 32, 64][..]), (2, &[4, 8, 16, 32]), (3, &[2, 4, 8])] {
        let rate = [1.3, -0.8, 0.6];
        let f = |x: [f64; 3]| (0..dimension).map(|a| rate[a] * x[a]).sum::<f64>().exp();
        // with a weight, so that not only the means of the cells count
        let weight = |x: [f64; 3]| 1.0 + x[0] * x[0];
        let norm = |n: usize| {
            let cloud = Cloud::new(dimension, 4 * n, 0.4, |_| true);
            let quadrature = cloud.quadrature(n, 3, FULL_SHARE);
            let mut values = Vec::new();
            quadrature.evaluate([&cloud.field(f)], &mut values);
            let rows = || quadrature.points().iter().zip(&values);
            let square: f64 = rows().map(|(p, v)| p.weight * (v[0] - f(p.position)).powi(2)).sum();
            let integral: f64 = rows().map(|(p, v)| p.weight * weight(p.position) * (v[0] - f(p.position))).sum();
            [square.sqrt(), integral.abs()]
        };
        let errors: Vec<[f64; 2]> = cells.iter().map(|n| norm(*n)).collect();
        let orders: Vec<[f64; 2]> = errors.windows(2).map(|e| [0, 1].map(|i| (e[0][i] / e[1][i]).log2())).collect();
        println!("{dimension}D: errors {errors:?}, orders {orders:.2?}");
        // The rest of the fit is of third order. Its sign changes at random from cell to cell, so the integral scatters, around and
        // mostly above: it is judged over all refinements.
        let over_all = (errors[0][1] / errors[errors.len() - 1][1]).log2() / (errors.len() - 1) as f64;
        assert!(orders.iter().all(|o| o[0] > 2.7) && over_all > 2.8, "{dimension}D: {orders:?} {over_all}");
    }
}
