//! Tielen 2016, the bar with large deformations (T2: 7 % strain, particles cross cells) against a spectral solution that is exact to
//! 13 digits (`tests/reference/tielen_bar_large.csv`: Fourier in space, DOP853 in time).

#![allow(clippy::unwrap_used, reason = "a test may panic")]

use matpoint::scene::Scene;

/// RMS error of displacement and stress at t = 0.5 s.
fn errors(basis: &str, cells: usize) -> (f64, f64) {
    let text = format!(
        r#"
        title = "Tielen 2016, vibrating bar, large deformations"
        dimension = 1
        grid = {{ origin = [0], size = [1], cell = {cell} }}
        material.rubber = {{ law = "hypo_elastic", young = 50, density = 25 }}
        boundary.left = {{ face = "x-", fixed = ["x"] }}
        boundary.right = {{ face = "x+", fixed = ["x"] }}
        time = {{ end = 0.5, step = 1e-4 }}
        body.bar = {{ material = "rubber", shape = {{ box = {{ min = [0], max = [1] }} }}, particles_per_cell = 4, velocity = ["0.1*sin(PI*x)"] }}
        method = {{ basis = "{basis}", integrator = "musl" }}
        exact = {{ reference = {file:?} }}
        "#,
        cell = 1.0 / cells as f64,
        file = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/reference/tielen_bar_large.csv"),
    );
    let mut sim = Scene::from_toml(&text).unwrap().build().unwrap();
    assert!(sim.get("error/displacement").unwrap()[0].is_nan(), "the table begins at 0.1 s");
    sim.step(0.5).unwrap();
    (sim.get("error/displacement").unwrap()[0], sim.get("error/stress").unwrap()[0])
}

/// An independent 60-line prototype of the thesis' algorithm gave, for quadratic B-splines, these errors (two digits).
#[test]
fn quadratic_b_splines_converge_as_the_prototype_does() {
    for (cells, displacement, stress) in [(8, 6.1e-4, 0.29), (16, 2.0e-4, 0.10), (32, 5.2e-5, 0.03)] {
        let (u, s) = errors("bspline", cells);
        println!("T2 quadratic B-splines, {cells:2} cells: displacement {u:.2e} m ({displacement:.1e}), stress {s:.3} Pa ({stress})");
        // the prototype's numbers have two digits
        assert!((u / displacement - 1.0).abs() < 0.05 && (s / stress - 1.0).abs() < 0.2, "{cells} cells: {u:e} {s}");
    }
}

#[test]
fn linear_functions_do_not_converge_once_particles_cross_cells() {
    let coarse = errors("linear", 16);
    let fine = errors("linear", 32);
    println!("T2 linear, 16 and 32 cells: displacement {:.2e} and {:.2e} m, stress {:.2} and {:.2} Pa", coarse.0, fine.0, coarse.1, fine.1);
    // the thesis' finding (figures 5.8 to 5.11): twice the cells, no smaller error
    assert!(fine.0 > 0.7 * coarse.0 && fine.1 > 0.7 * coarse.1);
    assert!(fine.1 > 0.2, "the stress oscillates by more than a tenth of its amplitude of 3.5 Pa");
}
