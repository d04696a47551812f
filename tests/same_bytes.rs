//! One scene written as TOML and built in Rust gives the same bytes; `tests/python/test_same_bytes.py` compares those that Python gets.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

use indexmap::indexmap;
use matpoint::scene::{
    Axis, Body, Boundary, Expr, External, Grid, Law, Load, Material, Method, OneOrEach, Plane, Probe, Record, Scene, Shape, Signal, Time,
    Traction, Transfer,
};
use std::path::Path;

fn built_in_rust() -> Scene {
    let numbers = |values: &[f64]| values.iter().map(|&v| Expr::Number(v)).collect::<Vec<_>>();
    let beam = Body {
        material: "rubber".into(),
        shape: Shape::Box { min: vec![0.0, 0.0], max: vec![4.0, 1.0] },
        particles_per_cell: None,
        positions: None,
        seed: 0,
        velocity: vec![Expr::Number(0.0), Expr::Formula("0.1*x".into())],
    };
    let tip = Traction { body: "beam".into(), face: "x+".into(), value: Signal::External(External::External) };
    Scene {
        title: "the same from TOML, Rust and Python".into(),
        dimension: 2,
        plane: Plane::Strain,
        grid: Grid { origin: vec![0.0, -2.0], size: vec![5.0, 4.0], cell: OneOrEach::One(0.5) },
        material: indexmap! { "rubber".into() => Material { law: Law::NeoHookean, young: 1e6, poisson: 0.3, density: 100.0 } },
        body: indexmap! { "beam".into() => beam },
        boundary: indexmap! { "root".into() => Boundary {
            face: Some("x-".into()), region: None, surface: None, fixed: vec![Axis::X, Axis::Y], velocity: indexmap! {}
        } },
        load: indexmap! {
            "weight".into() => Load::Gravity(Signal::Components(numbers(&[0.0, -9.81]))),
            "tip".into() => Load::Traction(tip),
        },
        probe: indexmap! { "tip".into() => Probe { body: None, at: vec![4.0, 0.5] } },
        contact: None,
        method: Method { transfer: Transfer::Apic, ..Method::default() },
        time: Time { end: 1.0, step: None, cfl: None, error: None },
        record: Record::default(),
        exact: None,
    }
}

/// A thousand steps under a load that changes with each.
fn snapshot(scene: Scene) -> Vec<u8> {
    let mut sim = scene.build().unwrap();
    for step in 0..1000 {
        sim.set("load/tip/traction", &[0.0, f64::from(step % 7) - 3.0]).unwrap();
        sim.step(1e-3).unwrap();
    }
    sim.save()
}

#[test]
fn toml_and_rust_give_the_same_bytes() {
    let read = snapshot(Scene::load(Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/same_bytes/scene.toml")).unwrap());
    assert!(read == snapshot(built_in_rust()));
    // for the test in Python
    std::fs::write(Path::new(env!("CARGO_TARGET_TMPDIR")).join("same_bytes.snapshot"), read).unwrap();
}
