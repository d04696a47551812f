//! Momentum of a free body that vibrates and moves through the grid: kept by every basis, transfer and integrator in every dimension.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

use matpoint::scene::Scene;

fn drift(dimension: usize, degree: usize, integrator: &str, transfer: &str) -> (f64, f64) {
    let cells = [16, 6, 3][dimension - 1] as f64;
    let list = |v: f64| format!("{:?}", vec![v; dimension]);
    let wave = ["1+0.05*sin(2*x)", "0.4+0.05*cos(x)", "-0.2+0.05*sin(x)"].map(|s| format!("\"{s}\""));
    let text = format!(
        r#"
        title = "free body"
        dimension = {dimension}
        grid = {{ origin = {}, size = {}, cell = 0.25 }}
        material.m = {{ law = "neo_hookean", young = 1e3, poisson = 0.2, density = 10 }}
        method = {{ basis = "bspline", degree = {degree}, integrator = "{integrator}", transfer = "{transfer}" }}
        time = {{ end = 4, step = 0.004 }}
        [body.b]
        material = "m"
        shape = {{ box = {{ min = {}, max = {} }} }}
        positions = "jittered"
        velocity = [{}]
        "#,
        list(-10.0),
        list(20.0),
        list(0.0),
        list(0.25 * cells),
        wave[..dimension].join(", "),
    );
    let mut sim = Scene::from_toml(&text).unwrap().build().unwrap();
    let size = |v: &[f64]| v.iter().map(|x| x * x).sum::<f64>().sqrt();
    let momentum = sim.get("momentum/linear").unwrap().to_vec();
    let angular = if dimension > 1 { sim.get("momentum/angular").unwrap().to_vec() } else { Vec::new() };
    let report = sim.step(4.0).unwrap_or_else(|e| panic!("{dimension}D degree {degree} {integrator} {transfer}: {e}"));
    assert_eq!(report.substeps, 1000);
    let change = |now: &[f64], then: &[f64]| now.iter().zip(then).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    let linear = change(sim.get("momentum/linear").unwrap(), &momentum) / size(&momentum);
    // against momentum times the size of the path, for the moment about the origin is taken far from the body
    let angular = if dimension > 1 { change(sim.get("momentum/angular").unwrap(), &angular) / size(&momentum) } else { 0.0 };
    (linear, angular)
}

#[test]
fn momentum_is_kept_over_1000_steps() {
    let mut worst = 0.0f64;
    let mut worst_angular = 0.0f64;
    for dimension in 1..=3 {
        for degree in 1..=5 {
            for transfer in ["pic", "flip", "apic"] {
                let (linear, angular) = drift(dimension, degree, "musl", transfer);
                worst = worst.max(linear);
                assert!(linear < 1e-12, "{dimension}D degree {degree} {transfer}: {linear:e}");
                if transfer == "apic" && degree > 1 {
                    worst_angular = worst_angular.max(angular);
                }
            }
        }
    }
    println!("largest relative drift of momentum over 1,000 steps, MUSL: {worst:.1e}; of angular momentum with APIC: {worst_angular:.1e}");
}

#[test]
fn momentum_is_kept_by_every_integrator() {
    for integrator in ["usf", "usl"] {
        for dimension in 1..=2 {
            for degree in 2..=5 {
                for transfer in ["pic", "flip", "apic", "asflip"] {
                    let (linear, angular) = drift(dimension, degree, integrator, transfer);
                    assert!(linear < 1e-12, "{integrator} {dimension}D degree {degree} {transfer}: {linear:e}");
                    println!("{integrator} {dimension}D degree {degree} {transfer}: linear {linear:.1e}, angular {angular:.1e}");
                }
            }
        }
    }
}
