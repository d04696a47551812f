//! The total-Lagrangian formulation, explicit: against exact solutions, and the orders at which they are met.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

use matpoint::Simulation;
use matpoint::scene::Scene;

fn build(text: &str) -> Simulation {
    Scene::from_toml(text).unwrap().build().unwrap()
}

fn value(sim: &mut Simulation, name: &str) -> f64 {
    sim.get(name).unwrap()[0]
}

/// The vibrating bar of Tielen 2016, chapter 5, after 0.02 s: error of the displacement.
fn small_bar(cells: usize, degree: usize) -> f64 {
    let mut sim = build(&format!(
        r#"
        title = "T1"
        dimension = 1
        grid = {{ origin = [0], size = [25], cell = {} }}
        material.m = {{ law = "linear_elastic", young = 100.0, density = 1.0 }}
        body.bar = {{ material = "m", shape = {{ box = {{ min = [0], max = [25] }} }}, velocity = ["0.1*sin(PI*x/25)"] }}
        boundary.left = {{ face = "x-", fixed = ["x"] }}
        boundary.right = {{ face = "x+", fixed = ["x"] }}
        method = {{ formulation = "total", degree = {degree}, integrator = "symplectic4" }}
        time = {{ end = 0.02, step = 1e-3 }}
        exact = {{ displacement = ["0.1/(10*PI/25)*sin(10*PI/25*t)*sin(PI*x/25)"] }}
        "#,
        25.0 / cells as f64
    ));
    sim.step(0.02).unwrap();
    value(&mut sim, "error/displacement")
}

/// The best of the thesis is 1.01e-9 with 64 cells (table 7.1).
#[test]
fn a_bar_with_small_strain() {
    let error = small_bar(64, 5);
    println!("T1, 64 cells, degree 5: {error:e} m");
    assert!(error <= 1e-12);
}

/// The bar of Tielen 2016, chapter 6, at 0.5 s: errors of displacement and stress.
fn large_bar(cells: usize, degree: usize) -> [f64; 2] {
    let mut sim = build(&format!(
        r#"
        title = "T2"
        dimension = 1
        grid = {{ origin = [0], size = [1], cell = {} }}
        material.m = {{ law = "hypo_elastic", young = 50.0, density = 25.0 }}
        body.bar = {{ material = "m", shape = {{ box = {{ min = [0], max = [1] }} }}, velocity = ["0.1*sin(PI*x)"] }}
        boundary.left = {{ face = "x-", fixed = ["x"] }}
        boundary.right = {{ face = "x+", fixed = ["x"] }}
        method = {{ formulation = "total", degree = {degree} }}
        time = {{ end = 0.5, step = 1e-4 }}
        exact = {{ reference = "tests/reference/tielen_bar_large.csv" }}
        "#,
        1.0 / cells as f64
    ));
    sim.step(0.5).unwrap();
    [value(&mut sim, "error/displacement"), value(&mut sim, "error/stress")]
}

/// Limits: those of a prototype in 60 lines that shares no code with this one, with room for its other quadrature.
#[test]
fn a_bar_with_7_percent_strain() {
    for (degree, displacement, stress) in [(3, 3e-8, 1e-4), (5, 2e-10, 3e-7)] {
        let [u, s] = large_bar(16, degree);
        println!("T2, 16 cells, degree {degree}: {u:e} m, {s:e} Pa");
        assert!(u <= displacement && s <= stress);
    }
}

/// A manufactured solution on the unit interval, square or cube: u_i = A sin(pi X_i) sin(pi c t + phase), finite strain (B4, B5).
fn manufactured(dimension: usize, cells: usize, degree: usize) -> f64 {
    let (young, poisson): (f64, f64) = if dimension == 1 { (100.0, 0.0) } else { (1e4, 0.3) };
    let (mu, lambda) = (young / (2.0 * (1.0 + poisson)), young * poisson / ((1.0 + poisson) * (1.0 - 2.0 * poisson)));
    let (c, amplitude) = (young.sqrt(), 0.05);
    // phases 0, pi, pi: at rest and undeformed at time 0
    let axes = &["x", "y", "z"][..dimension];
    let wave = |a: usize| format!("({}*sin(PI*{c}*t))", if a == 0 { amplitude } else { -amplitude });
    let stretch = |a: usize| format!("(1+PI*cos(PI*{})*{})", axes[a], wave(a));
    let log = (0..dimension).map(|a| format!("ln{}", stretch(a))).collect::<Vec<_>>().join("+");
    let each = |f: &dyn Fn(usize) -> String| (0..dimension).map(|a| format!("\"{}\"", f(a))).collect::<Vec<_>>().join(", ");
    let displacement = |a: usize| format!("sin(PI*{})*{}", axes[a], wave(a));
    let force = |a: usize| format!("PI^2*{}*({mu}-{}-({lambda}*({log}-1)-{mu})/{}^2)", displacement(a), c * c, stretch(a));
    let velocity = |a: usize| format!("{}*sin(PI*{})", if a == 0 { amplitude } else { -amplitude } * std::f64::consts::PI * c, axes[a]);
    let held: String = (0..dimension)
        .map(|a| {
            format!(
                "boundary.{0}l = {{ face = \"{0}-\", fixed = [\"{0}\"] }}\nboundary.{0}u = {{ face = \"{0}+\", fixed = [\"{0}\"] }}\n",
                axes[a]
            )
        })
        .collect();
    let mut sim = build(&format!(
        r#"
        title = "manufactured"
        dimension = {dimension}
        grid = {{ origin = {zeros:?}, size = {ones:?}, cell = {cell} }}
        material.m = {{ law = "neo_hookean", young = {young}, poisson = {poisson}, density = 1.0 }}
        body.block = {{ material = "m", shape = {{ box = {{ min = {zeros:?}, max = {ones:?} }} }}, velocity = [{velocity}] }}
        {held}
        load.source.body_force = {{ body = "block", value = [{force}] }}
        method = {{ formulation = "total", degree = {degree}, integrator = "symplectic4" }}
        time = {{ end = 1.0, cfl = 0.2 }}
        exact = {{ displacement = [{displacement}] }}
        "#,
        zeros = vec![0.0; dimension],
        ones = vec![1.0; dimension],
        cell = 1.0 / cells as f64,
        velocity = each(&velocity),
        force = each(&force),
        displacement = each(&displacement),
    ));
    // an eighth of a period: displacement and velocity are both large
    sim.step(0.25 / c).unwrap();
    value(&mut sim, "error/displacement")
}

/// Order p + 1 in displacement, the best that degree p can do, in 1D, 2D and 3D.
#[test]
fn manufactured_solutions_converge_at_the_best_order() {
    // all degrees on four grids in three dimensions take minutes: the study of accuracy does them
    let cases: [(usize, &[usize], usize); 3] = [(1, &[4, 8, 16, 32], 4), (2, &[4, 6, 8, 12], 4), (3, &[4, 6], 3)];
    for (dimension, grids, most) in cases {
        for degree in 1..=most {
            let errors: Vec<f64> = grids.iter().map(|&cells| manufactured(dimension, cells, degree)).collect();
            let (first, last) = (grids[0] as f64, grids[grids.len() - 1] as f64);
            let order = (errors[0] / errors[errors.len() - 1]).log2() / (last / first).log2();
            println!("{dimension}D, degree {degree}, cells {grids:?}: {errors:?}, order {order:.2}");
            assert!(order >= degree as f64 + 0.8, "{dimension}D, degree {degree}: {order}");
        }
    }
}
