//! The fast sums against their slow twin, the sums over particles.

use super::{Instructions, all};
use crate::model::Model;
use crate::scene::Scene;
use crate::state::State;
use crate::total::Total;
use crate::total::fast::Fast;
use crate::total::reference::{Reference, Vectors};
use crate::total::tests::field;

fn scene(dimension: usize, degree: usize, law: &str, plane: &str, body: &str, method: &str, cell: f64) -> Scene {
    Scene::from_toml(&text(dimension, degree, law, plane, body, method, cell)).unwrap()
}

/// A body of more than eight cells along an axis, with loads; some law, method and dimension.
fn text(dimension: usize, degree: usize, law: &str, plane: &str, body: &str, method: &str, cell: f64) -> String {
    let formulas = ["\"x*sin(3*t)\"", "\"1+x\"", "\"y*z\""];
    let list = |all: [f64; 3]| format!("{:?}", &all[..dimension]);
    format!(
        r#"
        title = "twins"
        dimension = {dimension}
        plane = "{plane}"
        grid = {{ origin = {}, size = {}, cell = {cell} }}
        material.m = {{ law = "{law}", young = 100.0, poisson = {}, density = 2.0 }}
        body.beam = {{ material = "m", shape = {{ box = {{ min = {}, max = {} }} }}, {body} }}
        boundary.root = {{ face = "x-", velocity = {{ {} }} }}
        load.side.pressure = {{ body = "beam", face = "x+", value = [5] }}
        load.weight.gravity = {}
        load.wind.body_force = {{ body = "beam", value = [{}] }}
        load.end.traction = {{ body = "beam", face = "x+", value = [{}] }}
        method = {{ formulation = "total", degree = {degree}, {method} }}
        time = {{ end = 1.0, cfl = 0.5 }}
        "#,
        list([0.0; 3]),
        list([4.0, 2.0, 2.0]),
        if dimension == 1 { 0.0 } else { 0.3 },
        list([0.0; 3]),
        list([2.75, 1.5, 0.5]),
        &["x = \"0.1*sin(t)\"", "y = 0", "z = 0"][..dimension].join(", "),
        list([1.0, -2.0, 0.5]),
        &formulas[..dimension].join(", "),
        &formulas[..dimension].join(", "),
    )
}

/// Both paths at time 0.
fn twins(scene: &Scene, instructions: Instructions) -> (Model, Total, State, Total, State) {
    let (model, state) = Model::new(scene).unwrap();
    let (mut slow, mut fast) = (Total::new(&model, &state), Total::new(&model, &state));
    slow.fast = None;
    let references: Vec<&Reference> = fast.bodies.iter().map(|body| &body.reference).collect();
    let sums = all(&model, &state.particles, &references, instructions).unwrap();
    fast.fast = Some(Fast::new(sums, &fast.bodies, &fast.held, model.dimension));
    let (mut of_slow, mut of_fast) = (state.clone(), state);
    slow.start(&model, &mut of_slow);
    fast.start(&model, &mut of_fast);
    slow.begin(&model);
    fast.begin(&model);
    (model, slow, of_slow, fast, of_fast)
}

fn difference(a: &Vectors, b: &Vectors) -> f64 {
    let largest = a.iter().flatten().fold(0.0f64, |m, v| m.max(v.abs()));
    a.iter().flatten().zip(b.iter().flatten()).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max) / largest
}

/// Internal forces, and how much of the stable step is left, at a displacement that is different at each node.
#[test]
fn forces_are_those_of_the_twin() {
    let mut worst = 0.0f64;
    for (dimension, plane) in [(1, "strain"), (1, "stress"), (2, "strain"), (2, "stress"), (3, "strain")] {
        for degree in 1..=5 {
            for law in ["linear_elastic", "neo_hookean", "hencky"] {
                for body in ["", "particles_per_cell = 2, positions = \"uniform\"", "particles_per_cell = 1"] {
                    let scene = scene(dimension, degree, law, plane, body, "mass = \"lumped\"", 0.25);
                    for instructions in Instructions::known() {
                        let (model, mut slow, mut state, mut fast, _) = twins(&scene, instructions);
                        state.nodes.displacement = field(state.nodes.velocity.len(), dimension, 0.01, &mut 5);
                        let mut of_fast = state.clone();
                        slow.update(&model, &mut state, 0.0).unwrap();
                        fast.update(&model, &mut of_fast, 0.0).unwrap();
                        let error = difference(&slow.internal, &fast.internal);
                        // sums of some hundred products in another order, and strains of a tenth that are differences of numbers near 1
                        assert!(error < 3e-13, "{dimension}D {plane} {degree} {law} {body} {instructions:?}: {error:e}");
                        worst = worst.max(error);
                        slow.keep_pace(&model, &mut state);
                        fast.keep_pace(&model, &mut of_fast);
                        assert!((state.pace - of_fast.pace).abs() < 1e-12, "{law}: {} {}", state.pace, of_fast.pace);
                        assert!(law == "linear_elastic" || state.pace < 0.99);
                    }
                }
            }
        }
    }
    println!("relative difference at most {worst:e}");
}

/// What a run gives, step for step: nodes, particles, reactions, work.
#[test]
fn steps_are_those_of_the_twin() {
    for dimension in 1..=3 {
        for law in ["linear_elastic", "neo_hookean"] {
            for method in ["mass = \"lumped\"", "mass = \"consistent\"", "mass = \"lumped\", integrator = \"symplectic4\""] {
                let scene = scene(dimension, 2, law, "strain", "", method, 0.25);
                let (model, mut slow, mut state, mut fast, mut of_fast) = twins(&scene, Instructions::known()[0]);
                let step = 0.5 * slow.stable_step(&model, &state).unwrap();
                assert!((0.5 * fast.stable_step(&model, &of_fast).unwrap() / step - 1.0).abs() < 1e-6);
                slow.forget();
                fast.forget();
                for n in 0..40 {
                    slow.advance(&model, &mut state, step).unwrap();
                    fast.advance(&model, &mut of_fast, step).unwrap();
                    let error = difference(&state.nodes.velocity, &of_fast.nodes.velocity);
                    // round-off of each step, that waves carry on: it grows like their number
                    assert!(error < 1e-13 * f64::from(n + 2), "{dimension}D {law} {method}, step {n}: {error:e}");
                }
                slow.show(&model, &mut state);
                fast.catch_up(&model, &mut of_fast).unwrap();
                for p in 0..state.particles.len() {
                    for (a, b) in state.particles.tables_mut().into_iter().zip(of_fast.particles.tables_mut()) {
                        let (a, b): ([f64; 9], [f64; 9]) = (a.row(p), b.row(p));
                        let error = a.iter().zip(&b).map(|(a, b)| (a - b).abs() / (1.0 + a.abs())).fold(0.0, f64::max);
                        assert!(error < 1e-11, "{dimension}D {law} {method}: {a:?} {b:?}");
                    }
                }
                assert!((state.external_work - of_fast.external_work).abs() < 1e-10 * state.external_work.abs());
                for (a, b) in slow.mean_reactions().zip(fast.mean_reactions()) {
                    (0..3).for_each(|k| assert!((a[k] - b[k]).abs() < 1e-9 * (1.0 + a[k].abs()), "{a:?} {b:?}"));
                }
            }
        }
    }
}

/// The same bytes with the registers of AVX-512 and AVX2, and for any number of threads.
#[test]
fn neither_registers_nor_threads_change_a_bit() {
    let bodies = [
        (2, "neo_hookean", "", 1.0 / 32.0),
        (3, "neo_hookean", "particles_per_cell = 9", 0.25),
        (2, "linear_elastic", "", 1.0 / 80.0),
        (3, "linear_elastic", "particles_per_cell = 1", 1.0 / 24.0),
    ];
    for (dimension, law, body, cell) in bodies {
        let scene = scene(dimension, 2, law, "strain", body, "mass = \"lumped\"", cell);
        let mut first: Option<Vectors> = None;
        for instructions in Instructions::known().into_iter().filter(|i| *i != Instructions::Portable) {
            for threads in 1..=4 {
                let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
                let velocity = pool.install(|| {
                    let (model, _, _, mut fast, mut state) = twins(&scene, instructions);
                    assert!(state.particles.len() > super::FEW);
                    (0..5).for_each(|_| fast.advance(&model, &mut state, 1e-4).unwrap());
                    state.nodes.velocity
                });
                assert!(*first.get_or_insert_with(|| velocity.clone()) == velocity, "{instructions:?}, {threads} threads");
            }
        }
    }
}

/// A controller's view: whoever looks, saves or restores changes nothing, and a step that fails is as if it had not been.
#[test]
fn looking_saving_and_failing_leave_no_trace() {
    use crate::component::StepError;
    for mass in ["lumped", "consistent"] {
        let scene = scene(2, 2, "neo_hookean", "strain", "", &format!("mass = \"{mass}\""), 0.25);
        let mut whole = scene.clone().build().unwrap();
        let mut looked = scene.clone().build().unwrap();
        whole.step(0.1).unwrap();
        looked.step(0.1).unwrap();
        let cut = looked.save();
        looked.get("particle/stress").unwrap();
        assert!(looked.save() == cut);
        let mut other = scene.build().unwrap();
        other.restore(&cut).unwrap();
        for sim in [&mut whole, &mut looked, &mut other] {
            sim.step(0.1).unwrap();
        }
        assert!(whole.save() == looked.save() && whole.save() == other.save());
        for name in ["particle/position", "particle/stress", "energy/total", "momentum/angular"] {
            let values: Vec<Vec<f64>> = [&mut whole, &mut looked, &mut other].map(|sim| sim.get(name).unwrap().to_vec()).to_vec();
            assert!(values[0] == values[1] && values[0] == values[2], "{name}");
        }
        // a copy of the state, as a recorder takes it
        let (mut twin, mut state) = (whole.twin(), State::default());
        whole.copy_state(&mut state);
        twin.exchange_state(&mut state);
        whole.step(0.1).unwrap();
        assert!(twin.get("particle/stress").unwrap() == other.get("particle/stress").unwrap());
        assert!(twin.time() < whole.time());
    }
    // pressed so hard that particles are turned inside out
    let text = text(2, 2, "neo_hookean", "strain", "", "mass = \"lumped\"", 0.25);
    let text = text.replace("value = [5]", "value = [2e4]").replace("cfl = 0.5", "step = 1e-3");
    let scene = Scene::from_toml(&text).unwrap();
    let mut sim = scene.build().unwrap();
    sim.step(1e-3).unwrap();
    let (before, stress) = (sim.save(), sim.get("particle/stress").unwrap().to_vec());
    match sim.step(2.0) {
        Err(StepError::Inverted { time, particle, det, position }) => {
            assert!(det <= 0.0 && time > 0.0 && particle < 594 && position.len() == 2, "{det} {time} {particle}");
        }
        other => panic!("{other:?}"),
    }
    assert!(sim.save() == before && sim.get("particle/stress").unwrap() == stress);
}
