//! The stable step: a fixed step above it is refused with the number that would do; just below it every basis, integrator and transfer
//! lives, walls and free ends included.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

use matpoint::scene::Scene;

fn bar(dimension: usize, degree: usize, integrator: &str, transfer: &str, time: &str) -> String {
    let (size, body, velocity) = match dimension {
        1 => ("[3]", "min = [0], max = [2]", r#"["0.001*sin(7*x)+0.0005*sin(60*x)"]"#),
        _ => ("[3, 1.5]", "min = [0, 0.5], max = [2, 1]", r#"["0.001*sin(7*x)", "0.001*sin(5*x)*sin(40*y)"]"#),
    };
    let list = |v: f64| format!("{:?}", vec![v; dimension]);
    format!(
        r#"
        title = "stability"
        dimension = {dimension}
        grid = {{ origin = {}, size = {size}, cell = 0.125 }}
        material.m = {{ law = "linear_elastic", young = 100, poisson = 0.3, density = 1 }}
        method = {{ basis = "bspline", degree = {degree}, integrator = "{integrator}", transfer = "{transfer}" }}
        boundary.root = {{ face = "x-", fixed = {} }}
        body.b = {{ material = "m", shape = {{ box = {{ {body} }} }}, velocity = {velocity} }}
        time = {{ end = 1, {time} }}
        "#,
        list(0.0),
        if dimension == 1 { r#"["x"]"# } else { r#"["x", "y"]"# },
    )
}

#[test]
fn a_step_above_the_stable_one_is_refused_with_the_number_that_would_do() {
    let error = Scene::from_toml(&bar(1, 2, "usl", "flip", "step = 0.5")).unwrap().build().err().unwrap().to_string();
    assert!(error.contains("time.step") && error.contains("stable step"), "{error}");
    let advised: f64 = error.split("at most ").nth(1).unwrap().split(',').next().unwrap().parse().unwrap();
    Scene::from_toml(&bar(1, 2, "usl", "flip", &format!("step = {advised}"))).unwrap().build().expect("the advised step is taken");
}

#[test]
fn every_method_lives_just_below_the_stable_step() {
    for dimension in [1, 2] {
        for degree in 1..=5 {
            for integrator in ["usf", "usl", "musl"] {
                for transfer in ["flip", "pic", "apic", "asflip"] {
                    // which is for smooth functions, and moves particles before the stress is updated or with it
                    if transfer == "asflip" && (degree == 1 || integrator == "musl") {
                        continue;
                    }
                    let name = format!("{dimension}D degree {degree} {integrator} {transfer}");
                    let mut sim = Scene::from_toml(&bar(dimension, degree, integrator, transfer, "cfl = 0.95")).unwrap().build().unwrap();
                    let start = sim.get("energy/total").unwrap()[0];
                    let step = 0.95 * sim.max_step();
                    let report = sim.step(2000.0 * step).unwrap_or_else(|e| panic!("{name}: {e}"));
                    let end = sim.get("energy/total").unwrap()[0];
                    println!(
                        "{name}: stable step {:.3} h/c, {} substeps, energy {:.4} of the start",
                        sim.max_step() / 0.125 * (134.6f64).sqrt(),
                        report.substeps,
                        end / start
                    );
                    // leapfrog energy oscillates by up to 1 / (1 - 0.95^2) = 10 at the highest mode; growth would be exponential
                    assert!(end < 11.0 * start, "{name}: energy grew {} times", end / start);
                }
            }
        }
    }
}
