//! Tielen 2016, one-dimensional bar and column: tables 5.1 and 6.1 cell by cell, and the column of section 5.1.3.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

use matpoint::scene::Scene;

/// T1: bar fixed at both ends, small deformations (table 4.1 of the thesis). MUSL with FLIP, as in its section 3.2.
fn bar(basis: &str, cells: usize, per_cell: usize) -> String {
    format!(
        r#"
        title = "Tielen 2016, vibrating bar, small deformations"
        dimension = 1
        grid = {{ origin = [0], size = [25], cell = {cell} }}
        material.rubber = {{ law = "linear_elastic", young = 100, density = 1 }}
        boundary.left = {{ face = "x-", fixed = ["x"] }}
        boundary.right = {{ face = "x+", fixed = ["x"] }}
        time = {{ end = 0.02, step = 1e-5 }}
        [body.bar]
        material = "rubber"
        shape = {{ box = {{ min = [0], max = [25] }} }}
        particles_per_cell = {per_cell}
        velocity = ["0.1*sin(PI*x/25)"]
        [method]
        {basis}
        integrator = "musl"
        [exact]
        displacement = ["0.1/(0.4*PI)*sin(0.4*PI*t)*sin(PI*x/25)"]
        "#,
        cell = 25.0 / cells as f64,
    )
}

/// RMS error of the displacement at t = 0.02 s.
fn error(basis: &str, cells: usize, per_cell: usize) -> f64 {
    let mut sim = Scene::from_toml(&bar(basis, cells, per_cell)).unwrap().build().unwrap();
    sim.step(0.02).unwrap();
    sim.get("error/displacement").unwrap()[0]
}

/// Every cell of a table within 0.5 %: its numbers have five digits, and details of the algorithm (when positions are updated) change
/// them by 0.1 %.
fn compare(basis: &str, table: &[(usize, [f64; 3])]) {
    for (cells, row) in table {
        for (per_cell, published) in [4, 6, 8].into_iter().zip(row) {
            let ours = error(basis, *cells, per_cell);
            println!("{basis:40} {cells:3} cells {per_cell} PPC: thesis {published:.4e}, ours {ours:.4e}, ratio {:.4}", ours / published);
            assert!((ours / published - 1.0).abs() < 0.005, "{basis}, {cells} cells, {per_cell} PPC: {ours:e} for {published:e}");
        }
    }
}

#[test]
fn table_5_1_linear() {
    compare(
        r#"basis = "linear""#,
        &[
            (4, [1.4537e-4, 1.4363e-4, 1.4303e-4]),
            (8, [3.7630e-5, 3.7162e-5, 3.7002e-5]),
            (16, [9.4898e-6, 9.3709e-6, 9.3300e-6]),
            (32, [2.3776e-6, 2.3478e-6, 2.3375e-6]),
            (64, [5.9473e-7, 5.8725e-7, 5.8469e-7]),
        ],
    );
}

#[test]
fn table_6_1_quadratic_b_splines() {
    compare(
        r#"basis = "bspline""#,
        &[
            (4, [1.6123e-4, 1.6140e-4, 1.6147e-4]),
            (8, [6.6466e-5, 6.6895e-5, 6.7050e-5]),
            (16, [2.2700e-5, 2.2899e-5, 2.2970e-5]),
            (32, [7.5351e-6, 7.6116e-6, 7.6389e-6]),
            (64, [2.4741e-6, 2.4995e-6, 2.5086e-6]),
        ],
    );
}

/// T3: column under sudden self-weight, small deformations, 50 degrees of freedom, 2 PPC (figure 5.12).
#[test]
fn column_under_self_weight() {
    let (height, young, density, gravity) = (25.0, 5e4f64, 1.0, -9.81);
    let cells = 49;
    // the particle just below the middle, as in figure 5.12: the middle lies half-way between two
    let middle = 0.5 * height - 0.25 * height / cells as f64;
    let text = format!(
        r#"
        title = "Tielen 2016, column, small deformations"
        dimension = 1
        grid = {{ origin = [0], size = [25], cell = {cell} }}
        material.soil = {{ law = "linear_elastic", young = 5e4, density = 1 }}
        body.column = {{ material = "soil", shape = {{ box = {{ min = [0], max = [25] }} }}, particles_per_cell = 2 }}
        boundary.bottom = {{ face = "x-", fixed = ["x"] }}
        load.weight.gravity = [-9.81]
        probe.middle = {{ at = [{middle}] }}
        time = {{ end = 0.5, step = 1e-4 }}
        method = {{ basis = "linear", integrator = "musl" }}
        "#,
        cell = height / cells as f64,
    );
    let mut sim = Scene::from_toml(&text).unwrap().build().unwrap();
    // equation (4.2) of the thesis with g of its sign convention: p0 = 0
    let exact = |y: f64, t: f64| {
        let g = -gravity;
        let series: f64 = (1..2000)
            .map(|n| {
                let m = (2 * n - 1) as f64;
                let u = 16.0 * height * height * density * g / (m.powi(3) * std::f64::consts::PI.powi(3) * young);
                u * ((young / density).sqrt() * m * std::f64::consts::PI * t / (2.0 * height)).cos()
                    * (m * std::f64::consts::PI * y / (2.0 * height)).sin()
            })
            .sum();
        0.5 * density * g * y * y / young - density * g * height * y / young + series
    };
    let (mut sum, mut largest) = (0.0, 0.0f64);
    let samples = 200;
    for k in 1..=samples {
        let t = 0.5 * k as f64 / samples as f64;
        let dt = t - sim.time();
        sim.step(dt).unwrap();
        let ours = sim.get("probe/middle/displacement").unwrap()[0];
        let theirs = exact(middle, t);
        sum += (ours - theirs).powi(2);
        largest = largest.max(theirs.abs());
    }
    let rms = (sum / samples as f64).sqrt();
    println!("column: RMS of the middle particle {rms:.3e} m, {:.3} % of the largest displacement {largest:.4} m", 100.0 * rms / largest);
    assert!(rms < 0.005 * largest);
}
