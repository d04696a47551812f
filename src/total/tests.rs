//! Residuals and tangents of whole bodies against finite differences.

use super::implicit::Step;
use super::reference::Vectors;
use super::{Total, Updated};
use crate::implicit::Balance;
use crate::model::Model;
use crate::scene::Scene;
use crate::state::{Nodes, State};

/// A beam with loads that follow it, in some law, method and dimension.
fn scene(dimension: usize, law: &str, plane: &str, method: &str) -> Scene {
    let list = |first: f64, other: f64| format!("{:?}", (0..dimension).map(|a| if a == 0 { first } else { other }).collect::<Vec<_>>());
    let (zero, load) = (list(0.0, 0.0), list(1.0, -2.0));
    let side = if dimension == 1 { "x+" } else { "y+" };
    let axes = &["\"x\"", "\"y\"", "\"z\""][..dimension].join(", ");
    Scene::from_toml(&format!(
        r#"
        title = "tangent"
        dimension = {dimension}
        plane = "{plane}"
        grid = {{ origin = {}, size = {}, cell = 0.5 }}
        material.m = {{ law = "{law}", young = 100.0, poisson = {}, density = 2.0 }}
        body.beam = {{ material = "m", shape = {{ box = {{ min = {zero}, max = {} }} }} }}
        boundary.root = {{ face = "x-", fixed = [{axes}] }}
        load.side.pressure = {{ body = "beam", face = "{side}", value = [5] }}
        load.weight.gravity = {load}
        method = {{ degree = 2, {method} }}
        time = {{ end = 1.0, step = 0.05 }}
        "#,
        list(0.0, -1.0),
        list(2.0, 2.0),
        if dimension == 1 { 0.0 } else { 0.3 },
        list(1.5, 0.5),
    ))
    .unwrap()
}

/// Noise between -1 and 1, the same each time.
fn noise(seed: &mut u64) -> f64 {
    *seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
    (*seed >> 33) as f64 / f64::from(1u32 << 30) - 1.0
}

pub(super) fn field(n: usize, dimension: usize, size: f64, seed: &mut u64) -> Vectors {
    (0..n).map(|_| std::array::from_fn(|a| if a < dimension { size * noise(seed) } else { 0.0 })).collect()
}

/// A body that is bent and moves: its grid, and the state.
pub(super) fn prepare(model: &Model, mut state: State, seed: &mut u64) -> (Total, State) {
    let d = model.dimension;
    let mut total = if model.total {
        let mut total = Total::new(model, &state);
        total.start(model, &mut state);
        total
    } else {
        // deformed already, and sorted into the cells it has come to
        let mut updated = Updated::new(model);
        for p in 0..state.particles.len() {
            let f: Vec<f64> = (0..d * d).map(|k| if k % (d + 1) == 0 { 1.0 } else { 0.0 } + 0.05 * noise(seed)).collect();
            state.particles.deformation.set_row(p, &f);
        }
        let lookup = updated.stepper.lookup(&state).to_vec();
        Total::of_now(model, &state, lookup)
    };
    total.begin(model);
    let n = total.acceleration.len();
    state.nodes = Nodes { displacement: field(n, d, 0.01, seed), velocity: field(n, d, 0.1, seed), acceleration: field(n, d, 1.0, seed) };
    for held in &total.held {
        state.nodes.displacement[held.node][held.axis] = 0.0;
    }
    if model.total {
        // history of laws that have one is that of the start of the step
        total.update(model, &mut state, 0.0).ok().unwrap();
    } else {
        state.nodes.displacement.fill([0.0; 3]);
    }
    (total, state)
}

/// The stiffness times a direction is minus the derivative of the residual along it. Returns the largest error, over the largest derivative.
fn tangent_error(scene: &Scene) -> f64 {
    let seed = &mut 7;
    let (model, state) = Model::new(scene).unwrap();
    let (mut total, state) = prepare(&model, state, seed);
    let (n, d) = (total.acceleration.len(), model.dimension);
    let scheme = model.implicit.unwrap();
    let mut matrix = total.pattern(&model);
    let mut step = Step::new(&mut total, &model, &state, scheme, 0.05, &mut matrix);
    let (mut end, mut direction) = (field(n, d, 0.02, seed), field(n, d, 1.0, seed));
    for held in &step.total.held {
        (end[held.node][held.axis], direction[held.node][held.axis]) = (0.0, 0.0);
    }
    let h = 1e-5;
    let forces = |step: &mut Step<'_>, by: f64| {
        let moved: Vectors = end.iter().zip(&direction).map(|(e, d)| std::array::from_fn(|a| e[a] + by * d[a])).collect();
        step.residual(&moved).ok().unwrap().forces
    };
    let (up, down) = (forces(&mut step, h), forces(&mut step, -h));
    let symmetric = step.stiffen(&end).ok().unwrap();
    let components: Vec<(usize, usize)> = matrix.components().collect();
    let x: Vec<f64> = components.iter().map(|&(node, a)| direction[node][a]).collect();
    let product = matrix.multiply(&x);
    // half of a matrix that is said to be symmetric is never looked at
    let other: Vec<f64> = x.iter().map(|_| noise(seed)).collect();
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let (there, back) = (dot(&other, &product), dot(&matrix.multiply(&other), &x));
    assert!(!symmetric || (there - back).abs() < 1e-10 * there.abs(), "not symmetric: {there} {back}");
    let difference = |&(node, a): &(usize, usize)| -(up[node][a] - down[node][a]) / (2.0 * h);
    let largest = components.iter().map(|c| difference(c).abs()).fold(0.0, f64::max);
    components.iter().zip(&product).map(|(c, k)| (difference(c) - k).abs()).fold(0.0, f64::max) / largest
}

#[test]
fn stiffnesses_are_derivatives_of_residuals() {
    let (mut seen, mut worst) = (0, 0.0f64);
    for formulation in ["total", "updated"] {
        for integrator in ["quasi_static", "newmark", "generalized_alpha", "energy_momentum"] {
            for law in ["linear_elastic", "hypo_elastic", "neo_hookean", "hencky"] {
                for (dimension, plane, mean) in [
                    (1, "strain", false),
                    (2, "strain", false),
                    (2, "stress", false),
                    (2, "strain", true),
                    (3, "strain", false),
                    (3, "strain", true),
                ] {
                    let method = format!("formulation = \"{formulation}\", integrator = \"{integrator}\", mean_dilatation = {mean}");
                    let potential = matches!(law, "neo_hookean" | "hencky");
                    let conserving = integrator == "energy_momentum";
                    if conserving && law == "hypo_elastic" || mean && (conserving || !potential || formulation == "updated") {
                        continue;
                    }
                    let error = tangent_error(&scene(dimension, law, plane, &method));
                    // differences of 1e-5 leave h^2 times third derivatives, some 1e-9
                    assert!(error < 1e-6, "{dimension}D {plane} {law} {method}: {error:e}");
                    (seen, worst) = (seen + 1, worst.max(error));
                }
            }
        }
    }
    println!("{seen} combinations, relative error at most {worst:e}");
}

/// Internal forces are minus the derivative of the stored energy.
#[test]
fn forces_are_derivatives_of_the_energy() {
    for law in ["linear_elastic", "neo_hookean", "hencky"] {
        for (dimension, plane, mean) in [
            (1, "strain", false),
            (2, "strain", false),
            (2, "stress", false),
            (2, "strain", true),
            (3, "strain", false),
            (3, "strain", true),
        ] {
            if mean && law == "linear_elastic" {
                continue;
            }
            let seed = &mut 3;
            let method = format!("formulation = \"total\", integrator = \"quasi_static\", mean_dilatation = {mean}");
            let (model, state) = Model::new(&scene(dimension, law, plane, &method)).unwrap();
            let (mut total, mut state) = prepare(&model, state, seed);
            let n = total.acceleration.len();
            let (at, direction) = (field(n, dimension, 0.03, seed), field(n, dimension, 1.0, seed));
            let mut energy = |by: f64| {
                state.nodes.displacement = at.iter().zip(&direction).map(|(u, d)| std::array::from_fn(|a| u[a] + by * d[a])).collect();
                total.update(&model, &mut state, 0.0).ok().unwrap();
                total.measure(&model, &state).strain
            };
            let h = 1e-5;
            let difference = (energy(h) - energy(-h)) / (2.0 * h);
            energy(0.0);
            let work: f64 = total.internal.iter().zip(&direction).map(|(f, d)| f[0] * d[0] + f[1] * d[1] + f[2] * d[2]).sum();
            let error = (work + difference).abs() / difference.abs();
            assert!(error < 1e-7, "{dimension}D {plane} {law} {mean}: {error:e}");
        }
    }
}
