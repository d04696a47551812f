//! Particle-steps per second of the whole explicit step, with the memory it takes.
//!
//! `cargo bench` runs all; `cargo bench -- 3d` the 3D block. Times on shared machines are noisy: compare within one run.

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use matpoint::Simulation;
use matpoint::scene::Scene;
use std::time::Duration;

/// A tenth of the time a wave takes through a cell [s].
fn step(side: usize) -> f64 {
    0.1 / side as f64 / 36.7
}

/// A block of `side`^3 cells with 8 particles each, falling in a grid of `margin` times its size.
fn block(side: usize, transfer: &str, integrator: &str, degree: usize, margin: f64) -> Simulation {
    let h = 1.0 / side as f64;
    let size = (1.0 + margin) / h;
    let size = size.round() * h;
    let text = format!(
        r#"
        title = "elastic block"
        dimension = 3
        grid = {{ origin = [0, 0, 0], size = [{size}, {size}, {size}], cell = {h} }}
        material.m = {{ law = "neo_hookean", young = 1e6, poisson = 0.3, density = 1e3 }}
        method = {{ basis = "bspline", degree = {degree}, transfer = "{transfer}", integrator = "{integrator}" }}
        time = {{ end = 100, step = {step} }}
        load.weight.gravity = [0, 0, -9.81]
        boundary.walls = {{ face = "x-", fixed = ["x", "y", "z"] }}
        body.b = {{ material = "m", shape = {{ box = {{ min = [0, {shift}, {shift}], max = [1, {top}, {top}] }} }}, positions = "jittered" }}
        "#,
        step = step(side),
        shift = 2.0 * h,
        top = 1.0 + 2.0 * h,
    );
    Scene::from_toml(&text).expect("a good scene").build().expect("a good scene")
}

/// Substeps of one call of `step`: a call keeps a copy of the state, which many substeps share.
const SUBSTEPS: u64 = 10;

fn throughput(c: &mut Criterion) {
    let one = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a pool");
    let mut group = c.benchmark_group("3d block, one thread, f64");
    group.sample_size(10).warm_up_time(Duration::from_millis(100)).measurement_time(Duration::from_secs(5));
    let cases = [
        (50, "apic", "usl", 2, SUBSTEPS),
        (50, "apic", "usl", 2, 1),
        (23, "apic", "usl", 2, SUBSTEPS),
        (24, "apic", "usl", 2, SUBSTEPS),
        (24, "flip", "usl", 2, SUBSTEPS),
        (24, "flip", "usf", 2, SUBSTEPS),
        (24, "flip", "usl", 1, SUBSTEPS),
        (24, "apic", "usl", 3, SUBSTEPS),
    ];
    for (side, transfer, integrator, degree, substeps) in cases {
        let mut sim = block(side, transfer, integrator, degree, 0.2);
        let n = sim.describe().particles;
        println!("{n} particles, {transfer} {integrator} degree {degree}: {} bytes a particle in all", sim.describe().memory / n);
        group.throughput(Throughput::Elements(n as u64 * substeps));
        let dt = substeps as f64 * step(side);
        group.bench_function(BenchmarkId::new(format!("{transfer} {integrator} degree {degree}, {substeps} substeps a call"), n), |b| {
            b.iter(|| one.install(|| sim.step(dt).expect("a good step")));
        });
    }
    group.finish();
}

fn domain(c: &mut Criterion) {
    let one = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a pool");
    let mut group = c.benchmark_group("the same body in a grid of 1 and 100 times the volume");
    group.sample_size(10).measurement_time(Duration::from_secs(4));
    for margin in [0.2, 4.57] {
        let mut sim = block(24, "apic", "usl", 2, margin);
        println!("margin {margin}: {} bytes", sim.describe().memory);
        group.throughput(Throughput::Elements(sim.describe().particles as u64 * SUBSTEPS));
        group.bench_function(BenchmarkId::from_parameter(format!("{:.0} times", ((1.0 + margin) / 1.2f64).powi(3))), |b| {
            b.iter(|| one.install(|| sim.step(SUBSTEPS as f64 * step(24)).expect("a good step")));
        });
    }
    group.finish();
}

/// What a call costs: `tests/python/bench.py` compares it with the call from Python.
fn fixed_cost(c: &mut Criterion) {
    let mut sim = Scene::from_toml(include_str!("scenes/one_particle.toml")).and_then(Scene::build).expect("a sound scene");
    let dt = 0.1 * sim.max_step();
    c.bench_function("one particle, one substep", |b| b.iter(|| sim.step(dt).expect("a good step")));
}

/// A block of `side` cells an axis with two particles along each axis, on a grid of its own.
fn block_of_its_own(dimension: usize, side: usize, degree: usize, law: &str, mass: &str) -> Simulation {
    let h = 1.0 / side as f64;
    let list = |value: &str| format!("[{}]", vec![value; dimension].join(", "));
    let (zeros, ones) = (list("0"), list("1"));
    let axes = &["\"x\"", "\"y\"", "\"z\""][..dimension].join(", ");
    let gravity = &["0", "-9.81", "0"][..dimension].join(", ");
    let text = format!(
        r#"
        title = "elastic block, total Lagrangian"
        dimension = {dimension}
        grid = {{ origin = {zeros}, size = {ones}, cell = {h} }}
        material.m = {{ law = "{law}", young = 1e6, poisson = 0.3, density = 1e3 }}
        method = {{ formulation = "total", degree = {degree}, mass = "{mass}" }}
        time = {{ end = 100, step = {step} }}
        load.weight.gravity = [{gravity}]
        boundary.walls = {{ face = "x-", fixed = [{axes}] }}
        body.b = {{ material = "m", shape = {{ box = {{ min = {zeros}, max = {ones} }} }}, particles_per_cell = 2 }}
        "#,
        step = step(side),
    );
    Scene::from_toml(&text).expect("a good scene").build().expect("a good scene")
}

/// The cantilever of Andersen and Andersen (2007) with 288 particles and a traction from outside.
fn small_cantilever(mass: &str) -> Simulation {
    let text = format!(
        r#"
        title = "small cantilever"
        dimension = 2
        grid = {{ origin = [0, -2], size = [9, 4], cell = 0.5 }}
        material.m = {{ law = "neo_hookean", young = 3e5, poisson = 0, density = 1e3 }}
        method = {{ formulation = "total", degree = 2, mass = "{mass}" }}
        time = {{ end = 20, step = 2e-3 }}
        load.tip.traction = {{ body = "beam", face = "x+", value = "external" }}
        boundary.root = {{ face = "x-", fixed = ["x", "y"] }}
        body.beam = {{ material = "m", shape = {{ box = {{ min = [0, 0], max = [8, 1] }} }} }}
        probe.tip = {{ at = [8, 0.5] }}
        "#
    );
    Scene::from_toml(&text).expect("a good scene").build().expect("a good scene")
}

/// Bodies on grids of their own.
fn total(c: &mut Criterion) {
    let pool = |threads: usize| rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
    let mut group = c.benchmark_group("total: block, f64");
    group.sample_size(10).warm_up_time(Duration::from_millis(200)).measurement_time(Duration::from_secs(2));
    for (threads, dimension, side, degree, law, mass) in [
        (1, 3, 24, 2, "neo_hookean", "lumped"),
        (2, 3, 24, 2, "neo_hookean", "lumped"),
        (1, 3, 24, 2, "linear_elastic", "lumped"),
        (1, 3, 24, 2, "neo_hookean", "consistent"),
        (2, 3, 24, 2, "neo_hookean", "consistent"),
        (1, 3, 50, 2, "neo_hookean", "lumped"),
        (2, 3, 50, 2, "neo_hookean", "lumped"),
        (1, 3, 24, 1, "neo_hookean", "lumped"),
        (1, 3, 24, 3, "neo_hookean", "lumped"),
        (1, 2, 160, 2, "neo_hookean", "lumped"),
        (1, 2, 160, 2, "neo_hookean", "consistent"),
    ] {
        let pool = pool(threads);
        let mut sim = block_of_its_own(dimension, side, degree, law, mass);
        let n = sim.describe().particles;
        group.throughput(Throughput::Elements(n as u64 * SUBSTEPS));
        let dt = SUBSTEPS as f64 * step(side);
        group.bench_function(BenchmarkId::new(format!("{threads} threads, {dimension}d, degree {degree}, {law}, {mass} mass"), n), |b| {
            b.iter(|| pool.install(|| sim.step(dt).expect("a good step")));
        });
    }
    group.finish();
    for mass in ["lumped", "consistent"] {
        let mut sim = small_cantilever(mass);
        let n = sim.describe().particles;
        c.bench_function(&format!("total: cantilever of {n} particles, {mass} mass, one step"), |b| {
            b.iter(|| sim.step(2e-3).expect("a good step"));
        });
        c.bench_function(&format!("total: cantilever of {n} particles, {mass} mass, one step with load and probe"), |b| {
            b.iter(|| {
                sim.set("load/tip/traction", &[0.0, -1.0]).expect("an input");
                sim.step(2e-3).expect("a good step");
                sim.get("probe/tip/displacement").expect("an output")[1]
            });
        });
    }
}

/// Scenes of a few hundred particles, a call of `step` for each substep, as a controller does it.
fn small(c: &mut Criterion) {
    let one = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a pool");
    let mut group = c.benchmark_group("small scenes, one thread, one substep a call");
    let scenes = [
        ("cantilever", include_str!("scenes/cantilever.toml")),
        ("block", include_str!("scenes/block.toml")),
        ("total", include_str!("scenes/total.toml")),
    ];
    for (name, text) in scenes {
        let mut sim = Scene::from_toml(text).and_then(Scene::build).expect("a sound scene");
        let (particles, dt) = (sim.describe().particles, sim.usual_step());
        group.throughput(Throughput::Elements(particles as u64));
        group.bench_function(BenchmarkId::new(name, particles), |b| b.iter(|| one.install(|| sim.step(dt).expect("a good step"))));
    }
    group.finish();
}

criterion_group!(benches, throughput, total, domain, small, fixed_cost);
criterion_main!(benches);
