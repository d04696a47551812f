use super::*;
use crate::interfaces::standard::{Vector3, Wrench};
use crate::parameters::{Parameters, Value};
use matpoint::scene::Scene;

const SCENE: &str = r#"
    title = "two loads"
    dimension = 2
    grid = { origin = [0, -1], size = [3, 3], cell = 0.5 }
    material.rubber = { law = "neo_hookean", young = 1e5, density = 1e3 }
    body.bar = { material = "rubber", shape = { box = { min = [0, 0], max = [2, 1] } } }
    load.tip.traction = { body = "bar", face = "x+", value = "external" }
    load.top.pressure = { body = "bar", face = "y+", value = "external" }
    time = { end = 1 }
"#;

fn simulation() -> (Simulation, Rules) {
    let sim = Scene::from_toml(SCENE).unwrap().build().unwrap();
    let rules = Rules { loads: Load::all(&sim.describe().variables), frame: "map".into() };
    (sim, rules)
}

fn vector(frame: &str, v: [f64; 3]) -> Vector3Stamped {
    Vector3Stamped { header: Header { frame_id: frame.into(), ..Default::default() }, vector: Vector3::from_slice(&v) }
}

#[test]
fn only_commands_that_fit_are_taken() {
    let (_, rules) = simulation();
    assert_eq!(
        rules.loads.iter().map(|l| (l.topic(), l.kind.as_str(), l.components)).collect::<Vec<_>>(),
        [("~/load/tip".into(), "traction", 2), ("~/load/top".into(), "pressure", 1)]
    );
    assert_eq!(rules.vector(0, &vector("", [1.0, 2.0, 0.0])).unwrap().value, [1.0, 2.0]);
    assert_eq!(rules.vector(1, &vector("map", [1.0, 0.0, 0.0])).unwrap().value, [1.0]);
    assert_eq!(rules.vector(0, &vector("map", [0.0; 3])).unwrap().value, [0.0, 0.0]);
    assert!(matches!(rules.vector(0, &vector("odom", [1.0, 2.0, 0.0])), Err(Refusal::Frame { .. })));
    assert!(matches!(rules.vector(0, &vector("", [1.0, 2.0, 3.0])), Err(Refusal::Size { expected: 2, found: 3, .. })));
    assert!(matches!(rules.vector(1, &vector("", [1.0, 2.0, 0.0])), Err(Refusal::Size { expected: 1, found: 2, .. })));
    assert_eq!(rules.vector(0, &vector("", [f64::NAN, 0.0, 0.0])), Err(Refusal::NotFinite));
    assert_eq!(rules.vector(0, &vector("", [0.0, 0.0, f64::INFINITY])), Err(Refusal::NotFinite));
    let mut wrench = WrenchStamped { wrench: Wrench { force: Vector3::from_slice(&[1.0]), ..Default::default() }, ..Default::default() };
    assert!(rules.wrench(0, &wrench).is_ok());
    wrench.wrench.torque.z = 1.0;
    assert_eq!(rules.wrench(0, &wrench), Err(Refusal::Torque));

    let named = LoadCommand { name: "tip".into(), value: vec![1.0, 2.0], hold: 3.0, ..Default::default() };
    assert_eq!(rules.named(&named), Ok(Command { load: 0, value: vec![1.0, 2.0], hold: Some(3.0), stamp: Time::default() }));
    let changed = |f: &dyn Fn(&mut LoadCommand)| {
        let mut other = named.clone();
        f(&mut other);
        rules.named(&other).unwrap_err().to_string()
    };
    assert_eq!(changed(&|c| c.name = "tap".into()), "no external load `tap`; there are: tip, top");
    assert_eq!(changed(&|c| c.kind = "pressure".into()), "load `tip` is a traction, not a pressure");
    assert_eq!(changed(&|c| c.value.clear()), "load `tip` takes 2 values, not 0");
    assert_eq!(changed(&|c| c.hold = -1.0), "the hold time is -1 s; it must be 0 or more");
}

#[test]
fn a_command_is_late_when_its_state_is_past() {
    let command = |time: f64| Command { load: 0, value: vec![], hold: None, stamp: Time::from_seconds(time) };
    let thrice = 3.0 * 0.005;
    assert!(command(0.01).late(thrice));
    assert!(!command(thrice).late(thrice) && !command(0.0).late(thrice) && !command(1.7e9).late(thrice));
}

/// The traction at the start of each of ten steps of 0.1 s, after a command at time 0 that holds for 0.3 s.
fn run(changes: &[(&str, Value)]) -> (Vec<f64>, u64) {
    let (mut sim, rules) = simulation();
    let mut parameters = Parameters::default();
    let all = [("step", Value::Double(0.1)), ("command.timeout", Value::Double(0.3))];
    parameters.set(all.iter().chain(changes).map(|(n, v)| ((*n).to_owned(), v.clone())).collect(), true).unwrap();
    let settings = &parameters.settings;
    let mut loads = Loads::new(rules.loads.clone());
    loads.command(rules.vector(0, &vector("", [8.0, 0.0, 0.0])).unwrap(), sim.time(), settings);
    let mut seen = Vec::new();
    for _ in 0..10 {
        loads.apply(&mut sim, settings).unwrap();
        seen.push(sim.get("load/tip/traction").unwrap()[0]);
        sim.step(0.1).unwrap();
    }
    (seen, loads.timeouts)
}

#[test]
fn a_command_holds_then_ends() {
    assert_eq!(run(&[]), (vec![8.0, 8.0, 8.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0], 1));
    assert_eq!(run(&[("command.after", Value::Text("hold".into()))]), (vec![8.0; 10], 1));
    assert_eq!(run(&[("command.timeout", Value::Double(0.0))]), (vec![8.0; 10], 0));
    let (decayed, timeouts) = run(&[("command.decay", Value::Double(0.4))]);
    for (value, expected) in decayed.iter().zip([8.0, 8.0, 8.0, 8.0, 6.0, 4.0, 2.0, 0.0, 0.0, 0.0]) {
        assert!((value - expected).abs() < 1e-4, "{decayed:?}");
    }
    assert_eq!(timeouts, 1);
}
