//! `method = "auto"`: what is chosen, and that it runs.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

use matpoint::scene::{Formulation, Integrator, Scene};

const BEAM: &str = r#"
    title = "beam"
    dimension = 2
    grid = { origin = [0, -1], size = [5, 3], cell = 0.5 }
    material.m = { law = "neo_hookean", young = 1e6, poisson = 0.3, density = 1000.0 }
    body.beam = { material = "m", shape = { box = { min = [0, 0], max = [4, 1] } } }
    boundary.root = { face = "x-", fixed = ["x", "y"] }
    load.tip.traction = { body = "beam", face = "x+", value = [0, "-1e3*t/200"] }
    method = "auto"
    time = { end = 200.0 }
"#;

/// The slowest period of that beam is about 3 s: a load that grows over 200 s is slow, one over 1 s is not. Its stable step is
/// about 3 ms.
#[test]
fn the_method_follows_from_the_scene() {
    use Formulation::{Total, Updated};
    use Integrator::{GeneralizedAlpha, Musl, QuasiStatic, Verlet};
    let second = "\n body.other = { material = \"m\", shape = { box = { min = [4.5, 0], max = [5, 1] } } }";
    let replaced = |from: &str, to: &str| BEAM.replace(from, to);
    let short = replaced("end = 200.0", "end = 1.0");
    let cases = [
        (BEAM.to_owned(), Total, 3, false, QuasiStatic),
        (replaced("0.3", "0.49"), Total, 2, true, QuasiStatic),
        (short.clone(), Total, 3, false, Verlet),
        (short.replace("end = 1.0", "end = 1.0, step = 0.02"), Total, 3, false, GeneralizedAlpha),
        (short.replace("end = 1.0", "end = 1.0, error = 1e-4"), Total, 3, false, GeneralizedAlpha),
        (replaced("end = 200.0", "end = 200.0, cfl = 0.5"), Total, 3, false, Verlet),
        (replaced("value = [0, \"-1e3*t/200\"]", "value = \"external\""), Total, 3, false, Verlet),
        (replaced("value = [0, \"-1e3*t/200\"]", "value = [0, -5]"), Total, 3, false, Verlet),
        (replaced("fixed = [\"x\", \"y\"]", "fixed = [\"x\"]"), Total, 3, false, Verlet),
        (BEAM.to_owned() + second, Updated, 2, false, Musl),
        (BEAM.to_owned() + second + "\n contact = { friction = 0.1 }", Updated, 2, false, Musl),
        (replaced("face = \"x-\"", "face = \"y-\""), Updated, 2, false, Musl),
        (
            replaced("box = { min = [0, 0], max = [4, 1] }", "disk = { center = [1, 0.5], radius = 1 }").replace("\"x+\"", "\"outer\""),
            Updated,
            2,
            false,
            Musl,
        ),
    ];
    for (text, formulation, degree, mean_dilatation, integrator) in cases {
        let mut sim = Scene::from_toml(&text).unwrap().build().unwrap();
        let method = &sim.scene().method;
        let found = (method.formulation, method.degree, method.mean_dilatation, method.integrator);
        let choices = sim.describe().choices;
        assert_eq!(found, (formulation, Some(degree), mean_dilatation, Some(integrator)), "{text}\n{choices:?}");
        assert!(choices.iter().all(|choice| !choice.why.is_empty()) && choices.len() >= 3);
        println!("{}", choices.iter().map(|c| format!("{} = {}: {}", c.part, c.chosen, c.why)).collect::<Vec<_>>().join("\n"));
        let first = 1e-2 * sim.scene().time.end;
        sim.step(first.min(0.05)).unwrap();
        // what was chosen is a scene that chooses the same
        let again = Scene::from_toml(&sim.scene().to_toml()).unwrap();
        assert_eq!(&again, sim.scene());
    }
}

/// The scene as written keeps the word.
#[test]
fn the_word_is_kept_and_faults_name_it() {
    let scene = Scene::from_toml(BEAM).unwrap();
    assert!(scene.to_toml().contains("method = \"auto\"") && Scene::from_json(&scene.to_json()).unwrap() == scene);
    let fault = |text: &str| Scene::from_toml(text).unwrap_err().to_string();
    let mistyped = fault(&BEAM.replace("\"auto\"", "\"automatic\""));
    assert!(mistyped.contains("method: is the text \"automatic\"; must be a table") && mistyped.contains("\"auto\""), "{mistyped}");
    let key = fault(&BEAM.replace("\"auto\"", "{ degre = 3 }"));
    assert!(key.contains("unknown key `degre`; did you mean `degree`?"), "{key}");
    let mixed = Scene { method: matpoint::scene::Method { auto: true, degree: Some(2), ..Default::default() }, ..scene };
    assert!(mixed.check().unwrap_err().to_string().contains("method: is automatic"));
}
