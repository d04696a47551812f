//! High order with particles that move through the grid: cubic B-splines, consistent mass, splines through the particles, Gauss points.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

use matpoint::Simulation;
use matpoint::scene::Scene;

const METHOD: &str =
    r#"degree = 3, mass = "consistent", mass_residual = 1e-13, quadrature = "splines", quadrature_of = "force_and_velocity""#;

fn build(text: &str) -> Simulation {
    Scene::from_toml(text).unwrap().build().unwrap()
}

/// Errors of displacement \[m\] and stress \[Pa\].
fn errors(sim: &mut Simulation) -> [f64; 2] {
    ["error/displacement", "error/stress"].map(|name| sim.get(name).unwrap()[0])
}

/// Order between the first and the last grid, by halving.
fn order(found: &[[f64; 2]]) -> [f64; 2] {
    let (first, last) = (found[0], found[found.len() - 1]);
    [0, 1].map(|k| (first[k] / last[k]).log2() / (found.len() - 1) as f64)
}

/// The bar of Tielen 2016, chapter 6, at 0.5 s.
fn large_bar(cells: usize, step: f64) -> [f64; 2] {
    let mut sim = build(&format!(
        r#"
        title = "T2"
        dimension = 1
        grid = {{ origin = [0], size = [1], cell = {} }}
        material.m = {{ law = "hypo_elastic", young = 50.0, density = 25.0 }}
        body.bar = {{ material = "m", shape = {{ box = {{ min = [0], max = [1] }} }}, velocity = ["0.1*sin(PI*x)"], particles_per_cell = 4 }}
        boundary.left = {{ face = "x-", fixed = ["x"] }}
        boundary.right = {{ face = "x+", fixed = ["x"] }}
        method = {{ {METHOD} }}
        time = {{ end = 0.5, step = {step} }}
        exact = {{ reference = "tests/reference/tielen_bar_large.csv" }}
        "#,
        1.0 / cells as f64
    ));
    sim.step(0.5).unwrap();
    errors(&mut sim)
}

/// The method of the thesis has 7e-7 m and 2.7e-3 Pa with 16 cells. Steps go with the square of the cell, so that their error, of second
/// order, falls as fast as that of the cells.
#[test]
fn a_bar_with_7_percent_strain() {
    let found = [(16, 1e-4), (32, 2.5e-5), (64, 6.25e-6)].map(|(cells, step)| large_bar(cells, step));
    let order = order(&found);
    println!("T2, 16, 32, 64 cells: {found:?}, orders {order:?}");
    assert!(found[0][0] <= 5e-8 && found[0][1] <= 2e-4);
    assert!(order[0] >= 3.5 && order[1] >= 3.0);
}

/// A manufactured solution u = A sin(pi X) sin(pi c t) with finite strain, of neo-Hookean rubber, at a quarter of its period.
fn manufactured(cells: usize, amplitude: f64, positions: &str) -> [f64; 2] {
    let c = 10.0;
    let wave = format!("({amplitude}*sin(PI*{c}*t))");
    let stretch = format!("(1+PI*cos(PI*x)*{wave})");
    let displacement = format!("sin(PI*x)*{wave}");
    let end = 0.25 / c;
    let mut sim = build(&format!(
        r#"
        title = "manufactured"
        dimension = 1
        grid = {{ origin = [0], size = [1], cell = {} }}
        material.m = {{ law = "neo_hookean", young = 100, density = 1 }}
        body.bar = {{ material = "m", shape = {{ box = {{ min = [0], max = [1] }} }}, velocity = ["{amplitude}*PI*{c}*sin(PI*x)"], particles_per_cell = 4, positions = "{positions}" }}
        boundary.left = {{ face = "x-", fixed = ["x"] }}
        boundary.right = {{ face = "x+", fixed = ["x"] }}
        load.source.body_force = {{ body = "bar", value = ["PI^2*{displacement}*(50+50/{stretch}^2-{c}^2)"] }}
        method = {{ {METHOD} }}
        time = {{ end = {end}, step = {} }}
        exact = {{ displacement = ["{displacement}"], stress.xx = "50*({stretch}^2-1)/{stretch}" }}
        "#,
        1.0 / cells as f64,
        // a step goes with the square of the cell
        end / (cells * cells) as f64,
    ));
    sim.step(end).unwrap();
    errors(&mut sim)
}

#[test]
fn manufactured_solutions_with_even_and_jittered_particles() {
    for positions in ["uniform", "jittered"] {
        for amplitude in [0.05, 0.1] {
            let found = [8, 16, 32, 64].map(|cells| manufactured(cells, amplitude, positions));
            let order = order(&found);
            println!("A = {amplitude}, {positions}, 8 to 64 cells: {found:?}, orders {order:?}");
            assert!(order[0] >= 3.5 && order[1] >= 3.0);
        }
    }
}

/// The unit square with u_i = +-A sin(pi X_i) sin(pi c t): no displacement normal to the faces, finite strain, neo-Hookean rubber (B5).
fn manufactured_square(cells: usize) -> [f64; 2] {
    let (young, poisson, c, amplitude): (f64, f64, f64, f64) = (1e4, 0.3, 100.0, 0.05);
    let (mu, lambda) = (young / (2.0 * (1.0 + poisson)), young * poisson / ((1.0 + poisson) * (1.0 - 2.0 * poisson)));
    let wave = |sign: f64| format!("({}*sin(PI*{c}*t))", sign * amplitude);
    let stretch = [("x", 1.0), ("y", -1.0)].map(|(axis, sign)| format!("(1+PI*cos(PI*{axis})*{})", wave(sign)));
    let log = format!("(ln{}+ln{})", stretch[0], stretch[1]);
    let displacement = [("x", 1.0), ("y", -1.0)].map(|(axis, sign)| format!("sin(PI*{axis})*{}", wave(sign)));
    let force = [0, 1].map(|a| format!("PI^2*{}*({mu}-{}-({lambda}*({log}-1)-{mu})/{}^2)", displacement[a], c * c, stretch[a]));
    let speed = amplitude * std::f64::consts::PI * c;
    let end = 0.25 / c;
    let mut sim = build(&format!(
        r#"
        title = "manufactured"
        dimension = 2
        grid = {{ origin = [0, 0], size = [1, 1], cell = {} }}
        material.m = {{ law = "neo_hookean", young = {young}, poisson = {poisson}, density = 1 }}
        body.block = {{ material = "m", shape = {{ box = {{ min = [0, 0], max = [1, 1] }} }}, velocity = ["{speed}*sin(PI*x)", "-{speed}*sin(PI*y)"], particles_per_cell = 4 }}
        boundary.xl = {{ face = "x-", fixed = ["x"] }}
        boundary.xu = {{ face = "x+", fixed = ["x"] }}
        boundary.yl = {{ face = "y-", fixed = ["y"] }}
        boundary.yu = {{ face = "y+", fixed = ["y"] }}
        load.source.body_force = {{ body = "block", value = ["{}", "{}"] }}
        method = {{ {METHOD} }}
        time = {{ end = {end}, step = {} }}
        exact = {{ displacement = ["{}", "{}"], stress.xx = "({mu}*({}^2-1)+{lambda}*{log})/({}*{})" }}
        "#,
        1.0 / cells as f64,
        force[0],
        force[1],
        end / (cells * cells) as f64,
        displacement[0],
        displacement[1],
        stretch[0],
        stretch[0],
        stretch[1],
    ));
    sim.step(end).unwrap();
    errors(&mut sim)
}

#[test]
fn a_manufactured_square() {
    let found = [4, 8].map(manufactured_square);
    let order = order(&found);
    println!("square, 4 and 8 cells: {found:?}, orders {order:?}");
    assert!(order[0] >= 3.5 && order[1] >= 2.8);
}
