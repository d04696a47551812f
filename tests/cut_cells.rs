//! Bodies whose edge cuts the cells of their grid, in the total formulation: against exact solutions, and anywhere in the grid.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

use matpoint::Simulation;
use matpoint::scene::Scene;

fn build(text: &str) -> Simulation {
    Scene::from_toml(text).unwrap().build().unwrap()
}

fn value(sim: &mut Simulation, name: &str) -> f64 {
    sim.get(name).unwrap()[0]
}

/// Order of convergence from the first to the last of errors on these cells.
fn order(cells: &[f64], errors: &[f64]) -> f64 {
    let n = cells.len() - 1;
    (errors[0] / errors[n]).ln() / (cells[0] / cells[n]).ln()
}

/// The expanding ring, a manufactured solution: u = a g(R) X with a = A sin(100 pi t) and g = c1 + c2 R + c3 R^2 such that u_R' vanishes at
/// both radii, which are free. With nu = 0 the law of this program is P = mu (F - F^-T), mu = E / 2: diagonal in polar axes, with the
/// stretches lr = 1 + a (g + R g') and lt = 1 + a g. The acceleration that is missing is
/// b = -(100 pi)^2 a R g - (P_rr' + (P_rr - P_tt) / R) / rho along R, with P_rr' = mu (1 + 1 / lr^2) a (2 g' + R g'').
/// Errors of displacement and stress at `end`.
fn ring(cell: f64, degree: usize, end: f64, method: &str) -> [f64; 2] {
    let r = "sqrt(x^2+y^2)";
    // radii 0.4 and 0.6, A = 0.1, E = 1e7, rho = 1000: c1 = 20 / 3, c2 = -125 / 9, c3 = 250 / 27
    let a = "(.1*sin(100*PI*t))";
    let g = format!("(20/3-125/9*{r}+250/27*(x^2+y^2))");
    let radial = format!("(1+{a}*(20/3-250/9*{r}+250/9*(x^2+y^2)))");
    let around = format!("(1+{a}*{g})");
    let change = format!("(1+1/{radial}^2)*{a}*(500/9*{r}-250/9)");
    let differ = format!("({radial}-1/{radial}-{around}+1/{around})/{r}");
    let force = format!("(-1e4*PI^2*{a}*{g}-5000*({change}+{differ})/{r})");
    // Cauchy stress: P_rr / lt and P_tt / lr, turned to x and y
    let rr = format!("(({radial}-1/{radial})/{around})");
    let tt = format!("(({around}-1/{around})/{radial})");
    let mut sim = build(&format!(
        r#"
        title = "expanding ring"
        dimension = 2
        grid = {{ origin = [-0.7, -0.7], size = [1.4, 1.4], cell = {cell} }}
        material.m = {{ law = "neo_hookean", young = 1e7, density = 1000 }}
        body.ring = {{ material = "m", shape = {{ ring = {{ center = [0, 0], inner = 0.4, outer = 0.6 }} }}, velocity = ["10*PI*{g}*x", "10*PI*{g}*y"] }}
        load.source.body_force = {{ body = "ring", value = ["{force}*x", "{force}*y"] }}
        method = {{ formulation = "total", degree = {degree}, {method} }}
        time = {{ end = 1.0, cfl = 0.8 }}
        [exact]
        displacement = ["{a}*{g}*x", "{a}*{g}*y"]
        stress = {{ xx = "5e6*({rr}*x^2+{tt}*y^2)/(x^2+y^2)", yy = "5e6*({rr}*y^2+{tt}*x^2)/(x^2+y^2)", xy = "5e6*({rr}-{tt})*x*y/(x^2+y^2)" }}
        "#
    ));
    sim.step(end).unwrap();
    [value(&mut sim, "error/displacement"), value(&mut sim, "error/stress")]
}

/// Order p + 1 in displacement and p in stress, with curved free boundaries anywhere in the cells.
#[test]
fn an_expanding_ring_converges_at_the_best_order() {
    for (degree, least) in [(2, 2.7), (3, 3.7)] {
        let cells = [0.1, 0.05, 0.025];
        let errors = cells.map(|cell| ring(cell, degree, 0.003, "integrator = \"symplectic4\""));
        let [u, s] = [0, 1].map(|k| errors.map(|e| e[k]));
        let orders = [&u, &s].map(|e| order(&cells[1..], &e[1..]));
        println!("ring, degree {degree}, cells {cells:?}: displacement {u:?} m, order {:.2}; stress {s:?} Pa, order {:.2}", orders[0], orders[1]);
        assert!(orders[0] >= least && orders[1] >= least - 1.0, "degree {degree}: {orders:?}");
    }
}
