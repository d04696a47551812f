//! Buzzi, Pedroso and Giacomini 2008: one material point (B1) and a bar of several (B2), with stress updated first and last.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

use matpoint::Simulation;
use matpoint::scene::Scene;
use std::f64::consts::PI;

/// Largest errors of velocity and position over a run, relative to their amplitudes, and the range of the total energy.
struct Curve {
    velocity: f64,
    position: f64,
    /// Total energy at the end less the one at the start, over the one at the start.
    drift: f64,
}

fn follow(sim: &mut Simulation, end: f64, samples: usize, exact: impl Fn(f64) -> (f64, f64), amplitude: (f64, f64)) -> Curve {
    let start = sim.get("energy/total").unwrap()[0];
    let mut curve = Curve { velocity: 0.0, position: 0.0, drift: 0.0 };
    for k in 1..=samples {
        let dt = end * k as f64 / samples as f64 - sim.time();
        sim.step(dt).unwrap();
        let (velocity, position) = exact(sim.time());
        let mass: f64 = sim.get("particle/mass").unwrap().iter().sum();
        curve.velocity = curve.velocity.max((sim.get("momentum/linear").unwrap()[0] / mass - velocity).abs() / amplitude.0);
        let weights = sim.get("particle/mass").unwrap().to_vec();
        let centre: f64 = sim.get("particle/position").unwrap().iter().zip(&weights).map(|(x, m)| x * m).sum::<f64>() / mass;
        curve.position = curve.position.max((centre - position).abs() / amplitude.1);
    }
    curve.drift = sim.get("energy/total").unwrap()[0] / start - 1.0;
    curve
}

const OMEGA: f64 = 2.0 * PI;

/// B1: one particle in one cell of length 1; v = v0 cos wt, x = x0 exp(v0 / (L w) sin wt) (equations 32 and 33).
fn single(integrator: &str, dt: f64) -> Curve {
    let text = format!(
        r#"
        title = "Buzzi 2008, single material point"
        dimension = 1
        grid = {{ origin = [0], size = [1], cell = 1 }}
        material.bar = {{ law = "linear_elastic", young = {young}, density = 1 }}
        body.point = {{ material = "bar", shape = {{ box = {{ min = [0], max = [1] }} }}, particles_per_cell = 1, velocity = [0.1] }}
        boundary.wall = {{ face = "x-", fixed = ["x"] }}
        method = {{ basis = "linear", integrator = "{integrator}" }}
        time = {{ end = 10, step = {dt} }}
        "#,
        young = 4.0 * PI * PI,
    );
    let mut sim = Scene::from_toml(&text).unwrap().build().unwrap();
    let exact = |t: f64| (0.1 * (OMEGA * t).cos(), 0.5 * (0.1 / OMEGA * (OMEGA * t).sin()).exp());
    follow(&mut sim, 10.0, 100, exact, (0.1, 0.05 / OMEGA))
}

#[test]
fn single_point_follows_the_exact_curve_and_usf_keeps_the_energy() {
    let (first, last) = (single("usf", 1e-3), single("usl", 1e-3));
    for (name, c) in [("USF", &first), ("USL", &last)] {
        println!(
            "B1 {name} dt 1e-3: velocity {:.2e}, position {:.2e} of the amplitude, energy drift {:.3e} over 10 periods",
            c.velocity, c.position, c.drift
        );
    }
    assert!(first.drift.abs() < 0.01, "USF keeps the energy");
    assert!(last.drift < 0.0 && last.drift.abs() > 10.0 * first.drift.abs(), "USL dissipates");
    // USF is a leapfrog of this oscillator: error of phase (w dt)^2 / 24 a radian over 63 radians. The position moves with the nodal
    // velocity, which has got its full kick where the particle gets N times that: an error of dt v0 (1 - N).
    assert!(first.velocity < 2e-4 && first.position < 0.02);
    // the amplitude of USL decays like the root of its energy
    let decayed = 1.0 - (1.0 + last.drift).sqrt();
    assert!((last.velocity / decayed - 1.0).abs() < 0.05 && last.position < 1.1 * decayed);
}

#[test]
fn a_smaller_step_dissipates_less() {
    let drifts: Vec<f64> = [1e-2, 1e-3, 1e-4].iter().map(|&dt| single("usl", dt).drift).collect();
    println!("B1 USL energy drift over 10 periods at dt = 1e-2, 1e-3, 1e-4: {drifts:?}");
    // the dissipation of USL is of first order in the step
    assert!((8.0..12.0).contains(&(drifts[1] / drifts[2])));
    let errors: Vec<f64> = [1e-1, 1e-2, 1e-3].iter().map(|&dt| single("usf", dt).velocity).collect();
    println!("B1 USF velocity error at dt = 1e-1, 1e-2, 1e-3: {errors:?}");
    // 100 for each, less where the first step is no longer small against the period
    assert!(errors[0] / errors[1] > 30.0 && errors[1] / errors[2] > 90.0, "leapfrog is of second order");
}

/// B2: bar of length 1 fixed at the left, first mode (equations 34 and 35); exact centre of mass velocity is v0 cos(wt) 2/pi.
fn bar(integrator: &str, cells: usize, particles: usize, periods: f64) -> Curve {
    let per_cell = particles / cells;
    let text = format!(
        r#"
        title = "Buzzi 2008, continuum bar"
        dimension = 1
        grid = {{ origin = [0], size = [1], cell = {cell} }}
        material.bar = {{ law = "linear_elastic", young = 10, density = 1 }}
        body.bar = {{ material = "bar", shape = {{ box = {{ min = [0], max = [1] }} }}, particles_per_cell = {per_cell}, velocity = ["0.1*sin(PI/2*x)"] }}
        boundary.wall = {{ face = "x-", fixed = ["x"] }}
        method = {{ basis = "linear", integrator = "{integrator}" }}
        time = {{ end = 12.6491, step = 1e-3 }}
        "#,
        cell = 1.0 / cells as f64,
    );
    let mut sim = Scene::from_toml(&text).unwrap().build().unwrap();
    let omega = 0.5 * PI * 10f64.sqrt();
    let mass = 2.0 / PI;
    let centre = sim.get("particle/position").unwrap().iter().sum::<f64>() / particles as f64;
    let exact = |t: f64| (0.1 * mass * (omega * t).cos(), centre + 0.1 * mass / omega * (omega * t).sin());
    follow(&mut sim, 2.0 * PI / omega * periods, 100, exact, (0.1 * mass, 0.1 * mass / omega))
}

#[test]
fn bar_vibrates_in_its_first_mode() {
    let cases = [(1, 3), (1, 7), (3, 3), (7, 7), (13, 13)];
    let mut errors = Vec::new();
    for (cells, particles) in cases {
        let (first, last) = (bar("usf", cells, particles, 1.0), bar("usl", cells, particles, 1.0));
        let (long_first, long_last) = (bar("usf", cells, particles, 10.0), bar("usl", cells, particles, 10.0));
        println!(
            "B2 {particles:2} particles {:2} nodes: velocity error in the first period USF {:.4}, USL {:.4} of the amplitude; energy drift over 10 periods USF {:.2e}, USL {:.2e}",
            cells + 1,
            first.velocity,
            last.velocity,
            long_first.drift,
            long_last.drift
        );
        assert!(long_first.drift.abs() < 0.01);
        assert!(long_last.drift < 0.0 && long_last.drift.abs() > 10.0 * long_first.drift.abs());
        // the step of 1e-3 is far below what the cells resolve, so both are the same curve but for the dissipation
        assert!((first.velocity - last.velocity).abs() < 0.05);
        errors.push(first.velocity);
    }
    // figure 17: more particles in one cell do not help; figure 18: finer cells do
    assert!(errors[0] > 0.2 && errors[1] > 0.8 * errors[0]);
    assert!(errors[2] < 0.3 && errors[3] < 0.4 * errors[2] && errors[4] < 0.6 * errors[3]);
}
