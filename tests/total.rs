//! The total-Lagrangian formulation.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

use matpoint::scene::Scene;

fn t2(cells: usize, degree: usize, extra: &str) -> [f64; 4] {
    let text = format!(
        r#"
        title = "T2"
        dimension = 1
        grid = {{ origin = [0], size = [1], cell = {} }}
        material.m = {{ law = "hypo_elastic", young = 50.0, density = 25.0 }}
        body.bar = {{ material = "m", shape = {{ box = {{ min = [0], max = [1] }} }}, velocity = ["0.1*sin(PI*x)"] }}
        boundary.left = {{ face = "x-", fixed = ["x"] }}
        boundary.right = {{ face = "x+", fixed = ["x"] }}
        method = {{ formulation = "total", degree = {degree}{extra} }}
        time = {{ end = 0.5, step = 1e-4 }}
        exact = {{ reference = "tests/reference/tielen_bar_large.csv" }}
        "#,
        1.0 / cells as f64
    );
    let mut sim = Scene::from_toml(&text).unwrap().build().unwrap();
    let before = sim.get("energy/total").unwrap()[0];
    sim.step(0.5).unwrap();
    let drift = sim.get("energy/total").unwrap()[0] / before - 1.0;
    [sim.get("error/displacement").unwrap()[0], sim.get("error/stress").unwrap()[0], drift, sim.max_step()]
}

#[test]
fn bar_with_7_percent_strain() {
    for degree in [1, 2, 3, 5] {
        for cells in [8, 16, 32] {
            println!("degree {degree}, {cells} cells: {:?}", t2(cells, degree, ""));
        }
    }
    println!("4th {:?}", t2(16, 5, ", integrator = \"symplectic4\""));
}
