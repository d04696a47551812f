//! Loads and boundaries: resultants, reactions, work, and a bar under end load against its exact solution.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

use matpoint::scene::Scene;
use std::f64::consts::PI;

/// A bar fixed at the left whose right end is pulled by p0 from time 0 on: thesis eq. (4.2) with g = 0, written for a pull.
#[test]
fn bar_under_sudden_end_traction_follows_the_exact_solution() {
    let (length, young, pull) = (25.0, 5e4, 100.0);
    for load in ["traction", "pressure"] {
        let value = if load == "pressure" { format!("[{}]", -pull) } else { format!("[{pull}]") };
        let text = format!(
            r#"
            title = "bar under end load"
            dimension = 1
            grid = {{ origin = [0], size = [25.5], cell = 0.25 }}
            material.m = {{ law = "linear_elastic", young = {young}, density = 1 }}
            body.bar = {{ material = "m", shape = {{ box = {{ min = [0], max = [25] }} }}, particles_per_cell = 2 }}
            boundary.wall = {{ face = "x-", fixed = ["x"] }}
            load.pull.{load} = {{ body = "bar", face = "x+", value = {value} }}
            probe.end = {{ at = [25] }}
            time = {{ end = 0.5, cfl = 0.2 }}
            "#
        );
        let mut sim = Scene::from_toml(&text).unwrap().build().unwrap();
        let speed = (young / 1.0f64).sqrt();
        let exact = |x: f64, t: f64| {
            let series: f64 = (1..4000)
                .map(|n| {
                    let m = (2 * n - 1) as f64;
                    let sign = if n % 2 == 1 { -1.0 } else { 1.0 };
                    sign * 8.0 * length * pull / (young * PI * PI * m * m)
                        * (speed * m * PI * t / (2.0 * length)).cos()
                        * (m * PI * x / (2.0 * length)).sin()
                })
                .sum();
            pull * x / young + series
        };
        let (mut sum, mut largest) = (0.0, 0.0f64);
        for k in 1..=100 {
            let dt = 0.005 * k as f64 - sim.time();
            sim.step(dt).unwrap();
            let (ours, theirs) = (sim.get("probe/end/displacement").unwrap()[0], exact(length, sim.time()));
            sum += (ours - theirs).powi(2);
            largest = largest.max(theirs.abs());
        }
        let rms = (sum / 100.0f64).sqrt() / largest;
        println!("end {load}: RMS of the end's displacement {:.3} % of the largest", 100.0 * rms);
        // a shock in 100 cells: the front is a cell or two wide
        assert!(rms < 0.01);
        let (external, total) = (sim.get("energy/external").unwrap()[0], sim.get("energy/total").unwrap()[0]);
        assert!(total.abs() < 0.01 * external, "the work of the load is the energy of the bar: {total} of {external}");
    }
}

/// Momentum is the impulse of loads and reactions, exactly.
#[test]
fn momentum_is_the_impulse_of_loads_and_reactions() {
    for method in [
        r#"transfer = "flip", integrator = "usf""#,
        r#"transfer = "flip", integrator = "usl", degree = 3"#,
        r#"transfer = "apic", integrator = "usl""#,
        r#"transfer = "apic", degree = 4"#,
        r#"transfer = "asflip", integrator = "usl""#,
        r#"transfer = "asflip", integrator = "usf", degree = 3"#,
        r#"transfer = "pic", degree = 1"#,
        r#"transfer = "flip", degree = 1"#,
        r#"basis = "gimp""#,
        r#"basis = "cubic""#,
        r#"basis = "serendipity", transfer = "pic""#,
        r#"mass = "consistent", mass_residual = 1e-13"#,
        r#"mass = "consistent", mass_residual = 1e-13, transfer = "pic""#,
        r#"mass = "consistent", mass_residual = 1e-13, balance_mass = "lumped", integrator = "usf", flip_share = 0.9"#,
        r#"mass = "fmpm", fmpm_order = 3, transfer = "pic""#,
        r#"quadrature = "least_squares""#,
    ] {
        let text = format!(
            r#"
            title = "impulse"
            dimension = 2
            grid = {{ origin = [0, -2], size = [4, 4], cell = 0.25 }}
            material.m = {{ law = "neo_hookean", young = 1e4, poisson = 0.3, density = 100 }}
            method = {{ {method} }}
            time = {{ end = 1, cfl = 0.4 }}
            body.b = {{ material = "m", shape = {{ box = {{ min = [0, 0], max = [2, 0.5] }} }}, positions = "jittered", particles_per_cell = 3 }}
            boundary.root = {{ face = "x-", fixed = ["x", "y"] }}
            load.tip.traction = {{ body = "b", face = "x+", value = [20, -60] }}
            load.push.point_force = {{ body = "b", at = [1, 0.25], value = [0, 7] }}
            load.weight.gravity = [0, -0.5]
            "#
        );
        let mut sim = Scene::from_toml(&text).unwrap().build().unwrap();
        let mass: f64 = sim.get("particle/mass").unwrap().iter().sum();
        let mut impulse = [0.0; 2];
        let mut size = 0.0f64;
        // Velocities are half a step before the time, so loads and reactions act over half the first step more than half the last:
        // tiny steps at both ends make that negligible against the tolerance, and one call is one substep.
        let mut last = 0.0;
        for k in 0..400 {
            let dt = if k == 0 || k == 399 { 1e-12 } else { 5e-4 };
            let report = sim.step(dt).unwrap();
            assert_eq!(report.substeps, 1);
            let reaction = sim.get("boundary/root/reaction").unwrap().to_vec();
            for a in 0..2 {
                impulse[a] += 0.5 * (last + dt) * reaction[a];
            }
            last = dt;
            size = size.max(sim.get("momentum/linear").unwrap().iter().fold(0.0, |m, v| m.max(v.abs())));
        }
        let t = sim.time();
        let momentum = sim.get("momentum/linear").unwrap().to_vec();
        impulse[0] += 20.0 * 0.5 * t;
        impulse[1] += (-60.0 * 0.5 + 7.0 - 0.5 * mass) * t;
        println!("{method}: momentum {momentum:.4?}, impulse {impulse:.4?}, largest {size:.3}");
        for a in 0..2 {
            assert!((momentum[a] - impulse[a]).abs() < 1e-9 * size, "{method}: {momentum:?} {impulse:?}");
        }
    }
}

/// A dead traction alone: exact to round-off, whatever the deformation.
#[test]
fn dead_traction_gives_exactly_its_impulse() {
    for degree in 1..=5 {
        let text = format!(
            r#"
            title = "impulse"
            dimension = 2
            grid = {{ origin = [-1, -1], size = [4, 3], cell = 0.25 }}
            material.m = {{ law = "neo_hookean", young = 1e3, poisson = 0.3, density = 100 }}
            method = {{ basis = "bspline", degree = {degree} }}
            time = {{ end = 1, step = 1e-3 }}
            body.b = {{ material = "m", shape = {{ disk = {{ center = [0.6, 0.4], radius = 0.5 }} }}, positions = "jittered" }}
            load.push.traction = {{ body = "b", face = "outer", value = [3, -4] }}
            "#
        );
        let mut sim = Scene::from_toml(&text).unwrap().build().unwrap();
        sim.step(0.3).unwrap();
        let momentum = sim.get("momentum/linear").unwrap();
        let area = PI; // circumference of radius 0.5
        for (p, t) in momentum.iter().zip([3.0, -4.0]) {
            assert!((p - t * area * 0.3).abs() < 1e-12 * 4.0 * area, "degree {degree}: {p}");
        }
    }
}

/// Reaction at rest is the weight: gravity ramped up slowly on a column.
#[test]
fn reaction_of_a_resting_column_is_its_weight() {
    let text = r#"
        title = "column at rest"
        dimension = 2
        plane = "strain"
        grid = { origin = [0, 0], size = [0.5, 2], cell = 0.25 }
        material.m = { law = "hencky", young = 1e5, poisson = 0.3, density = 100 }
        method = { transfer = "apic" }
        time = { end = 2, cfl = 0.5 }
        body.column = { material = "m", shape = { box = { min = [0, 0], max = [0.5, 1] } } }
        boundary.floor = { face = "y-", fixed = ["y"] }
        boundary.left = { face = "x-", fixed = ["x"] }
        boundary.right = { face = "x+", fixed = ["x"] }
        load.weight.gravity = [0, "-9.81*min(t,1)"]
    "#;
    let mut sim = Scene::from_toml(text).unwrap().build().unwrap();
    sim.step(1.5).unwrap();
    let weight = sim.get("particle/mass").unwrap().iter().sum::<f64>() * 9.81;
    sim.step(0.5).unwrap();
    let floor = sim.get("boundary/floor/reaction").unwrap().to_vec();
    // a reaction is a force, however short the step
    sim.step(1e-5).unwrap();
    let short = sim.get("boundary/floor/reaction").unwrap()[1];
    assert!((short / weight - 1.0).abs() < 0.05, "{short} N for {weight} N");
    let (left, right) = (sim.get("boundary/left/reaction").unwrap()[0], sim.get("boundary/right/reaction").unwrap()[0]);
    println!("reaction {:.4} N for a weight of {weight:.4} N; walls {left:.3} and {right:.3} N", floor[1]);
    // what is left of the vibration of the ramp
    assert!((floor[1] / weight - 1.0).abs() < 1e-3);
    assert!(left > 0.0 && (left + right).abs() < 1e-9 * weight, "walls push inwards, equally");
}

/// A prescribed pull does the work that the bar stores.
#[test]
fn work_of_a_moving_boundary_is_stored() {
    let text = r#"
        title = "pull"
        dimension = 1
        plane = "stress"
        grid = { origin = [0], size = [1], cell = 0.0625 }
        material.m = { law = "linear_elastic", young = 1e3, poisson = 0.3, density = 1 }
        time = { end = 1, cfl = 0.3 }
        body.bar = { material = "m", shape = { box = { min = [0], max = [1] } } }
        boundary.left = { face = "x-", velocity = { x = "-0.01*sin(PI*t/2)^2" } }
        boundary.right = { face = "x+", fixed = ["x"] }
    "#;
    // the wall of the grid stays where it is: matter may not pass it, so pull inwards
    let mut sim = Scene::from_toml(&text.replace("-0.01", "0.01")).unwrap().build().unwrap();
    sim.step(1.0).unwrap();
    let (stored, work) =
        (sim.get("energy/strain").unwrap()[0] + sim.get("energy/kinetic").unwrap()[0], sim.get("energy/external").unwrap()[0]);
    // the bar is shortened by the integral of the velocity, 0.005 m; stored energy E u^2 / 2
    println!("work {work:.6} J, stored {stored:.6} J, static {:.6} J", 0.5 * 1e3 * 0.005f64.powi(2));
    assert!((work / stored - 1.0).abs() < 0.01);
    assert!((stored / (0.5 * 1e3 * 0.005f64.powi(2)) - 1.0).abs() < 0.05);
}

/// A symmetric ring under inner follower pressure stays symmetric.
#[test]
fn follower_pressure_on_a_ring_moves_it_nowhere() {
    let text = r#"
        title = "ring"
        dimension = 2
        grid = { origin = [-2, -2], size = [4, 4], cell = 0.125 }
        material.m = { law = "neo_hookean", young = 1e5, poisson = 0.3, density = 100 }
        time = { end = 1 }
        body.ring = { material = "m", shape = { ring = { center = [0, 0], inner = 0.6, outer = 1 } } }
        load.inside.pressure = { body = "ring", face = "inner", value = [8e3] }
        probe.inner = { at = [0.6, 0] }
    "#;
    let mut sim = Scene::from_toml(text).unwrap().build().unwrap();
    sim.step(0.05).unwrap();
    let momentum = sim.get("momentum/linear").unwrap().to_vec();
    let size: f64 = sim.get("particle/mass").unwrap().iter().sum::<f64>();
    let stretched = sim.get("probe/inner/displacement").unwrap()[0];
    println!("net momentum {momentum:?}, mass {size:.1}, the inner face moves out by {stretched:.3} m");
    assert!(stretched > 0.02, "it grows");
    let spin = sim.get("momentum/angular").unwrap()[0];
    assert!(spin.abs() < 1e-9 * size, "nor does it turn: {spin}");
    assert!(momentum.iter().all(|p| p.abs() < 1e-9 * size));
}

/// The moment of a traction: a free square under a shear on its top alone gets the moment about the origin, to round-off in one step.
#[test]
fn traction_gives_exactly_its_moment() {
    // APIC, for FLIP with lumped mass hands particles less than the moment that the nodes got
    for degree in 1..=5 {
        let text = format!(
            r#"
            title = "moment"
            dimension = 2
            grid = {{ origin = [-3, -2], size = [7, 6], cell = 0.25 }}
            material.m = {{ law = "neo_hookean", young = 1e3, poisson = 0.3, density = 100 }}
            method = {{ basis = "bspline", degree = {degree}, transfer = "apic", integrator = "usl" }}
            time = {{ end = 1, step = 1e-3 }}
            body.b = {{ material = "m", shape = {{ box = {{ min = [0, 0], max = [1, 2] }} }} }}
            load.shear.traction = {{ body = "b", face = "y+", value = [5, 3] }}
            "#
        );
        let mut sim = Scene::from_toml(&text).unwrap().build().unwrap();
        sim.step(1e-3).unwrap();
        // moment about the origin of (5, 3) on the top, whose middle is (0.5, 2): x f_y - y f_x; all of it acts for 1e-3 s, the
        // second half in the configuration after the step, which has moved by 1e-8
        let exact = 1e-3 * (0.5 * 3.0 - 2.0 * 5.0);
        let moment = sim.get("momentum/angular").unwrap()[0];
        assert!((moment - exact).abs() < 1e-7 * exact.abs(), "degree {degree}: {moment} for {exact}");
    }
}
