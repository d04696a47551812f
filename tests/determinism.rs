//! The same bytes for any number of threads, and for a run that is cut in two by a snapshot.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

use matpoint::Simulation;
use matpoint::component::StepError;
use matpoint::scene::Scene;

/// A body of more than 4,096 particles, so that work is shared, that moves over many cells and is sorted again and again.
fn scene(dimension: usize, transfer: &str) -> String {
    // one of each: rate law and potential, plane stress, all integrators
    let (law, plane, integrator) = match (dimension, transfer) {
        (2, "apic") => ("hypo_elastic", "strain", "usl"),
        (2, _) => ("neo_hookean", "stress", "usf"),
        (_, "apic") => ("neo_hookean", "strain", "musl"),
        _ => ("hypo_elastic", "strain", "usl"),
    };
    let (size, velocity) = match dimension {
        2 => ("[4, 4]", r#"["2+sin(3*y)", "1+cos(2*x)"]"#),
        _ => ("[2, 2, 1]", r#"["2+sin(3*y)", "1+cos(2*x)", "0.5*z"]"#),
    };
    let list = |v: f64| format!("{:?}", vec![v; dimension]);
    format!(
        r#"
        title = "threads"
        dimension = {dimension}
        plane = "{plane}"
        grid = {{ origin = {}, size = {}, cell = 0.125 }}
        material.m = {{ law = "{law}", young = 1e4, poisson = 0.3, density = 100 }}
        method = {{ transfer = "{transfer}", integrator = "{integrator}" }}
        time = {{ end = 1, cfl = 0.4 }}
        boundary.floor = {{ face = "y-", fixed = ["y"] }}
        load.weight.gravity = {:?}
        load.push.traction = {{ body = "b", face = "x-", value = {:?} }}
        body.b = {{ material = "m", shape = {{ box = {{ min = {}, max = {size} }} }}, particles_per_cell = 3, velocity = {velocity} }}
        "#,
        list(0.0),
        list(10.0),
        [0.0, -9.81, 0.0][..dimension].to_vec(),
        [30.0, 5.0, 0.0][..dimension].to_vec(),
        list(0.0),
    )
}

fn build(dimension: usize, transfer: &str) -> Simulation {
    Scene::from_toml(&scene(dimension, transfer)).unwrap().build().unwrap()
}

#[test]
fn threads_do_not_change_a_bit() {
    let single = r#"apic", precision = "single"#;
    for (dimension, transfer) in
        [(2, "flip"), (2, "apic"), (2, "asflip"), (3, "apic"), (3, "asflip"), (3, "flip"), (2, single), (3, single)]
    {
        let run = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| {
                let mut sim = build(dimension, transfer);
                assert!(sim.describe().particles > 4096);
                for _ in 0..3 {
                    sim.step(0.02).unwrap();
                }
                (sim.save(), sim.get("energy/total").unwrap()[0].to_bits(), sim.get("boundary/floor/reaction").unwrap()[1].to_bits())
            })
        };
        let one = run(1);
        for threads in [2, 3, 4] {
            assert!(run(threads) == one, "{threads} threads, {dimension}D {transfer}");
        }
    }
}

#[test]
fn a_restored_run_gives_the_same_bytes() {
    for (dimension, transfer) in [(2, "apic"), (2, "flip"), (2, "asflip"), (3, "apic"), (3, "asflip"), (3, "flip")] {
        let mut whole = build(dimension, transfer);
        whole.step(0.02).unwrap();
        let cut = whole.save();
        // looking does not disturb
        whole.get("particle/velocity").unwrap();
        whole.get("energy/kinetic").unwrap();
        whole.step(0.03).unwrap();

        let mut restored = build(dimension, transfer);
        restored.restore(&cut).unwrap();
        assert!(restored.save() == cut);
        restored.step(0.03).unwrap();
        assert!(restored.save() == whole.save(), "{dimension}D {transfer}");
        assert_eq!(restored.get("particle/stress").unwrap(), whole.get("particle/stress").unwrap());

        let mut again = build(dimension, transfer);
        let fresh = again.save();
        again.step(0.01).unwrap();
        again.reset();
        assert!(again.save() == fresh, "reset goes back to time 0");
    }
}

/// The pass that ends a call of `step` begins the next one, if it is as long as those before. Whoever has nothing to go on with, after a
/// restart, gets the same bytes.
#[test]
fn calls_that_go_on_and_calls_that_begin_anew_give_the_same_bytes() {
    let single = r#"apic", precision = "single"#;
    for (dimension, transfer) in [(2, "apic"), (2, "flip"), (3, "apic"), (3, "flip"), (3, single)] {
        let (mut whole, mut anew) = (build(dimension, transfer), build(dimension, transfer));
        // as short as a substep, as several, and not what was expected
        for dt in [1e-3, 1e-3, 1e-3, 0.02, 0.02, 1e-3, 1e-3, 2e-3, 0.02, 0.02, 0.02] {
            anew.restore(&whole.save()).unwrap();
            whole.step(dt).unwrap();
            anew.step(dt).unwrap();
            assert!(whole.save() == anew.save(), "{dimension}D {transfer}, {dt} s until {} s", whole.time());
        }
    }
}

#[test]
fn an_interrupted_step_leaves_no_trace() {
    let mut sim = build(2, "apic");
    sim.step(0.005).unwrap();
    let before = sim.save();
    let mut asked = 0;
    let mut four_times = || {
        asked += 1;
        asked <= 4
    };
    let error = sim.step_while(0.5, &mut four_times).unwrap_err();
    assert_eq!(asked, 5, "asked after each substep");
    assert!(matches!(error, StepError::Interrupted { time } if time > 0.005 && time < 0.505), "{error}");
    assert!(sim.save() == before);

    let mut whole = build(2, "apic");
    for dt in [0.005, 0.01] {
        whole.step(dt).unwrap();
    }
    sim.step(0.01).unwrap();
    assert!(sim.save() == whole.save());
}

#[test]
fn shared_values_stay_as_they_were() {
    let mut sim = build(2, "flip");
    let before = sim.share("particle/position").unwrap();
    let copy = before.to_vec();
    let again = sim.share("particle/position").unwrap();
    assert!(std::ptr::eq(before.as_ptr(), again.as_ptr()), "computed once a step");
    sim.step(0.01).unwrap();
    assert!(sim.get("particle/position").unwrap() != copy.as_slice());
    assert_eq!(*before, copy);
}

#[test]
fn a_snapshot_of_something_else_is_refused_and_changes_nothing() {
    let mut sim = build(2, "apic");
    sim.step(0.005).unwrap();
    let good = sim.save();
    let other = build(2, "flip").save();
    let mut damaged = good.clone();
    damaged.truncate(good.len() / 2);
    let mut garbage = good.clone();
    for byte in garbage.iter_mut().skip(30).step_by(7) {
        *byte ^= 0x5a;
    }
    // one byte wrong anywhere: refused, or another state of the same scene; never a panic, and stepping it is safe
    for place in (0..good.len()).step_by(good.len() / 97) {
        let mut one = good.clone();
        one[place] ^= 0x81;
        if sim.restore(&one).is_ok() {
            let _ = sim.step(0.001);
            sim.restore(&good).unwrap();
        }
    }
    let mut longer = good.clone();
    longer.push(0);
    for (bytes, word) in [
        (&longer[..], "damaged"),
        (&other[..], "another scene"),
        (&damaged[..], "damaged"),
        (&garbage[..], "damaged"),
        (&b""[..], "no snapshot"),
        (&b"hello, world, what?"[..], "no snapshot"),
    ] {
        let error = sim.restore(bytes).unwrap_err().to_string();
        assert!(error.contains(word), "{error}");
        assert!(sim.save() == good);
    }
}

/// A step begins with what looking at the state has left behind: it must be what it would have made itself.
#[test]
fn looking_at_a_state_changes_nothing() {
    let run = |scene: &str, look: bool| {
        let mut sim = Scene::from_toml(scene).unwrap().build().unwrap();
        let input = sim.describe().variables.iter().find(|v| v.name.starts_with("load/")).map(|v| v.name.clone());
        let saved = sim.save();
        for k in 0..12 {
            if look {
                sim.get("energy/total").unwrap();
                sim.get("particle/velocity").unwrap();
            }
            // Inputs change after the look, and so does the state itself.
            if let (Some(name), true) = (&input, k % 2 == 0) {
                sim.set(name, &[10.0 * f64::from(k), -20.0]).unwrap();
            }
            if k == 5 {
                sim.restore(&saved).unwrap();
            }
            if k == 8 && look {
                sim.get("energy/kinetic").unwrap();
                assert!(sim.step(-1.0).is_err());
            }
            sim.step(0.01).unwrap();
        }
        sim.save()
    };
    let external = scene(2, "apic").replace("[30.0, 5.0]", "\"external\"");
    assert!(external.contains("value = \"external\""));
    let contact = include_str!("../launch_scripts/scenes/box_on_beam.toml").to_owned();
    for scene in [external, contact, scene(2, "flip"), scene(2, "asflip"), scene(3, "apic"), scene(3, "flip")] {
        assert!(run(&scene, true) == run(&scene, false), "{scene}");
    }
}

/// The total formulation and implicit steps: any number of threads, a run cut in two, a look, going back to time 0.
#[test]
fn bodies_on_grids_of_their_own_give_the_same_bytes() {
    for (dimension, method, time) in [
        (2, "formulation = \"total\"", "cfl = 0.5"),
        (3, "formulation = \"total\", integrator = \"symplectic4\", mass = \"lumped\"", "cfl = 0.5"),
        (2, "formulation = \"total\", integrator = \"energy_momentum\"", "error = 1e-4"),
        (3, "formulation = \"total\", integrator = \"newmark\", linear_solver = \"iterative\"", "step = 5e-3"),
        (3, "formulation = \"total\", integrator = \"generalized_alpha\", mean_dilatation = true", "step = 5e-3"),
        (2, "integrator = \"newmark\"", "error = 1e-3"),
        (2, "integrator = \"energy_momentum\"", "step = 5e-3"),
    ] {
        let text = scene(dimension, "flip")
            .replace("cell = 0.125", "cell = 1")
            .replace("method = { transfer = \"flip\", ", "ignored = { ")
            .replace("particles_per_cell = 3, ", "")
            .replace("\"stress\"", "\"strain\"")
            .replace("hypo_elastic", "neo_hookean")
            .replace("time = { end = 1, cfl = 0.4 }", &format!("time = {{ end = 1, {time} }}\nmethod = {{ {method} }}"));
        let text: String = text.lines().filter(|line| !line.contains("ignored")).map(|line| format!("{line}\n")).collect();
        let build = || Scene::from_toml(&text).unwrap().build().unwrap();
        let run = |threads: usize, looks: bool, cut: bool| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| {
                let mut sim = build();
                let fresh = sim.save();
                for k in 0..4 {
                    sim.step(0.01).unwrap();
                    if looks {
                        sim.get("energy/total").unwrap();
                        sim.get("particle/stress").unwrap();
                    }
                    if cut && k == 1 {
                        let saved = sim.save();
                        sim = build();
                        sim.restore(&saved).unwrap();
                        assert!(sim.save() == saved);
                    }
                }
                let end = (sim.save(), sim.get("particle/stress").unwrap().to_vec(), sim.get("energy/total").unwrap()[0].to_bits());
                sim.reset();
                assert!(sim.save() == fresh, "{method}: reset goes back to time 0");
                end
            })
        };
        let whole = run(1, false, false);
        assert!(run(2, false, false) == whole, "{method}: threads");
        assert!(run(2, true, false) == whole, "{method}: looking");
        assert!(run(1, false, true) == whole, "{method}: restart");
    }
}
