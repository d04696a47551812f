//! The same problem in two ways: plane strain against a slab in 3D, one dimension against a strip in 2D, free bars with and without
//! lateral contraction.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

use matpoint::scene::Scene;

fn positions(text: &str, end: f64, keep: usize) -> Vec<Vec<f64>> {
    let mut sim = Scene::from_toml(text).unwrap().build().unwrap();
    sim.step(end).unwrap();
    let d = sim.describe().dimension;
    sim.get("particle/position").unwrap().chunks(d).map(|x| x[..keep].to_vec()).collect()
}

/// 2D plane strain, and the same with one cell, one particle and two held faces across.
#[test]
fn plane_strain_is_a_slab_between_walls() {
    for (law, transfer, degree) in
        [("neo_hookean", "apic", 2), ("hencky", "flip", 3), ("hypo_elastic", "flip", 2), ("linear_elastic", "flip", 1)]
    {
        let text = |z: bool| {
            let axis = |a: &str| if z { format!("{a}, ") } else { String::new() };
            let per_cell = if z { "[2, 2, 1]" } else { "[2, 2]" };
            // the third axis is put first, where slots are used differently from 2D
            format!(
                r#"
                title = "slab"
                dimension = {}
                grid = {{ origin = [0, -1 {}], size = [3, 2.5 {}], cell = 0.25 }}
                material.m = {{ law = "{law}", young = 1e4, poisson = 0.3, density = 100 }}
                method = {{ basis = "bspline", degree = {degree}, transfer = "{transfer}" }}
                time = {{ end = 1, step = 1e-3 }}
                boundary.root = {{ face = "x-", fixed = ["x", "y"] }}
                {}
                load.weight.gravity = [0, -3 {}]
                body.b = {{ material = "m", shape = {{ box = {{ min = [0, 0 {}], max = [2, 0.5 {}] }} }}, particles_per_cell = {per_cell} }}
                "#,
                if z { 3 } else { 2 },
                axis(", 0").trim_end_matches(", "),
                axis(", 0.25").trim_end_matches(", "),
                if z { "boundary.sides = { region = { box = { min = [-9, -9, -9], max = [9, 9, 9] } }, fixed = [\"z\"] }" } else { "" },
                axis(", 0").trim_end_matches(", "),
                axis(", 0").trim_end_matches(", "),
                axis(", 0.25").trim_end_matches(", "),
            )
        };
        let (plane, slab) = (positions(&text(false), 0.3, 2), positions(&text(true), 0.3, 2));
        assert_eq!(plane.len(), slab.len());
        let moved = plane.iter().flatten().fold(0.0f64, |m, v| m.max(v.abs()));
        let difference = plane.iter().flatten().zip(slab.iter().flatten()).fold(0.0f64, |m, (a, b)| m.max((a - b).abs()));
        println!("{law} {transfer} degree {degree}: largest difference {difference:.1e} m of {moved:.2} m");
        // round-off of 300 steps
        assert!(difference < 1e-11, "{law} {transfer} {degree}: {difference}");
    }
}

/// A bar free across has Young's modulus whatever its Poisson ratio.
#[test]
fn lateral_contraction_does_not_stiffen_a_free_bar() {
    let text = |poisson: f64| {
        format!(
            r#"
            title = "bar"
            dimension = 1
            plane = "stress"
            grid = {{ origin = [0], size = [1], cell = 0.1 }}
            material.m = {{ law = "linear_elastic", young = 100, poisson = {poisson}, density = 1 }}
            time = {{ end = 1, step = 1e-3 }}
            boundary.left = {{ face = "x-", fixed = ["x"] }}
            body.b = {{ material = "m", shape = {{ box = {{ min = [0], max = [1] }} }}, velocity = ["0.1*x"] }}
            "#
        )
    };
    let (with, without) = (positions(&text(0.3), 0.5, 1), positions(&text(0.0), 0.5, 1));
    let difference = with.iter().flatten().zip(without.iter().flatten()).fold(0.0f64, |m, (a, b)| m.max((a - b).abs()));
    assert!(difference < 1e-13, "{difference}");
}

/// Plane stress in 2D of a strip that is free along y as well is that bar.
#[test]
fn plane_stress_strip_is_softer_than_plane_strain() {
    let period = |plane: &str| {
        let text = format!(
            r#"
            title = "strip"
            dimension = 2
            plane = "{plane}"
            grid = {{ origin = [-0.5, -0.25], size = [3, 0.75], cell = 0.0625 }}
            material.m = {{ law = "neo_hookean", young = 100, poisson = 0.4, density = 1 }}
            time = {{ end = 1, cfl = 0.4 }}
            body.b = {{ material = "m", shape = {{ box = {{ min = [0, 0], max = [2, 0.125] }} }}, velocity = ["0.001*cos(PI*x/2)", 0] }}
            "#
        );
        let mut sim = Scene::from_toml(&text).unwrap().build().unwrap();
        let mode: Vec<f64> = sim.get("particle/position").unwrap().chunks(2).map(|x| (std::f64::consts::PI * x[0] / 2.0).cos()).collect();
        let (mut before, mut time) = (1.0, 0.0);
        loop {
            sim.step(0.002).unwrap();
            let now: f64 = sim.get("particle/velocity").unwrap().chunks(2).zip(&mode).map(|(v, m)| v[0] * m).sum();
            if now < 0.0 {
                return 4.0 * (time + 0.002 * before / (before - now));
            }
            (before, time) = (now, sim.time());
        }
    };
    // a thin strip: E for plane stress, E / (1 - nu^2) for plane strain, period 2 L / c
    let (stress, strain) = (period("stress"), period("strain"));
    let exact = [4.0 / 10.0, 4.0 / (100.0 / 0.84f64).sqrt()];
    println!("period: plane stress {stress:.4} s (exact {:.4}), plane strain {strain:.4} s (exact {:.4})", exact[0], exact[1]);
    // 32 cells over the strip and 2 across it
    assert!((stress / exact[0] - 1.0).abs() < 0.02 && (strain / exact[1] - 1.0).abs() < 0.02);
    assert!((stress / strain * 0.84f64.sqrt() - 1.0).abs() < 0.005);
}
