//! What a scene does not use costs nothing: a plain scene against the same scene in which something is declared and has nothing to do.

use super::{Bench, Entry, Scratch, thousandths};
use crate::study::Section;
use crate::study::tools::tabulate;

/// A block of 13 824 particles at the wall of its grid, without gravity and without boundaries.
struct Plain {
    transfer: &'static str,
    law: &'static str,
    /// More of the scene.
    more: &'static str,
    /// Whether its halves are bodies of their own.
    halves: bool,
}

const PLAIN: Plain = Plain { transfer: "flip", law: "neo_hookean", more: "", halves: false };

impl Plain {
    fn scene(&self) -> String {
        let body = |name: &str, low: f64, high: f64| {
            format!(
                r#"
                [body.{name}]
                material = "rubber"
                shape = {{ box = {{ min = [0, 0.2, {low}], max = [0.6, 0.8, {high}] }} }}
                particles_per_cell = 2
                velocity = [0, "0.1*z", "-0.1*y"]"#
            )
        };
        let bodies = if self.halves { body("block", 0.2, 0.5) + &body("upper", 0.5, 0.8) } else { body("block", 0.2, 0.8) };
        format!(
            r#"
            title = "plain block"
            dimension = 3
            grid = {{ origin = [0, 0, 0], size = [1, 1, 1], cell = 0.05 }}
            material.rubber = {{ law = "{}", young = 1e6, poisson = 0.3, density = 1e3 }}
            method = {{ transfer = "{}", integrator = "usl" }}
            time = {{ end = 100, step = 1e-4 }}
            {}
            {bodies}
            "#,
            self.law, self.transfer, self.more
        )
    }
}

/// A feature: a scene that declares it without use for it, if that is possible, and one that uses it.
struct Pair {
    feature: &'static str,
    idle: Option<(&'static str, Entry)>,
    used: (&'static str, Entry),
}

/// Calls of `step` in a timing, a substep each.
const CALLS: u64 = 10;

fn entry(name: String, plain: &Plain) -> Entry {
    Entry::scene(name, plain.scene(), 1).calls(CALLS)
}

fn pairs(scratch: &Scratch) -> Vec<Pair> {
    let declared = |feature: &str, more| entry(format!("{feature}, idle"), &Plain { more, ..PLAIN });
    let used = |feature: &str, plain: Plain| entry(format!("{feature}, used"), &plain);
    let recorded = |entry: Entry, name: &str, every: f64| {
        let path = scratch.0.join(name);
        entry.with(|task| task.record = Some((path, every)))
    };
    const PROBE: &str = "probe.corner = { at = [0.6, 0.8, 0.8] }";
    let with_probe = Plain { more: PROBE, ..PLAIN };
    vec![
        Pair {
            feature: "contact",
            idle: None,
            used: ("two halves in contact", used("contact", Plain { more: "contact = { friction = 0 }", halves: true, ..PLAIN })),
        },
        Pair {
            feature: "history of a law",
            idle: None,
            used: ("law with a rate", used("history of a law", Plain { law: "hypo_elastic", ..PLAIN })),
        },
        Pair { feature: "affine matrix", idle: None, used: ("APIC", used("affine matrix", Plain { transfer: "apic", ..PLAIN })) },
        Pair {
            feature: "probes",
            idle: Some(("a probe that nobody reads", declared("probes", PROBE))),
            used: ("read in each step", used("probes", with_probe).with(|task| task.get = vec!["probe/corner/displacement".into()])),
        },
        Pair {
            feature: "recording",
            idle: Some(("a recorder with nothing due", recorded(entry("recording, idle".into(), &PLAIN), "idle.pvd", 1e6))),
            used: ("a frame in each step", recorded(entry("recording, used".into(), &PLAIN), "used.pvd", 1e-4)),
        },
        Pair {
            feature: "energies",
            idle: None,
            used: ("read in each step", used("energies", PLAIN).with(|task| task.get = vec!["energy/total".into()])),
        },
        Pair {
            feature: "tractions",
            idle: Some((
                "set from outside, never set",
                declared("tractions", r#"load.end.traction = { body = "block", face = "x+", value = "external" }"#),
            )),
            used: (
                "1 kPa on a face",
                used("tractions", Plain { more: r#"load.end.traction = { body = "block", face = "x+", value = [1e3, 0, 0] }"#, ..PLAIN }),
            ),
        },
        Pair {
            feature: "prescribed boundaries",
            idle: Some((
                "on a face that no body reaches",
                declared("prescribed boundaries", r#"boundary.far = { face = "x+", fixed = ["x"] }"#),
            )),
            used: (
                "on the face where the body is",
                used("prescribed boundaries", Plain { more: r#"boundary.near = { face = "x-", fixed = ["x"] }"#, ..PLAIN }),
            ),
        },
    ]
}

/// Most of the time that a scene with something idle may take.
const MOST: f64 = 1.01;
const NOTHING: &str = "plain";
const AGAIN: &str = "plain, once more";

pub(super) fn section(bench: &mut Bench) -> Result<Section, String> {
    let scratch = Scratch::new()?;
    let mut entries = vec![entry(NOTHING.into(), &PLAIN), entry(AGAIN.into(), &PLAIN)];
    // how far from 1 a ratio is by chance
    let mut rows = vec![("nothing", [Some(("the plain scene once more", AGAIN.to_owned())), None])];
    for pair in pairs(&scratch) {
        let names = [pair.idle.as_ref().map(|(what, entry)| (*what, entry.name.clone())), Some((pair.used.0, pair.used.1.name.clone()))];
        entries.extend(pair.idle.map(|idle| idle.1).into_iter().chain([pair.used.1]));
        rows.push((pair.feature, names));
    }
    // it is about hundredths
    let race = bench.race_anew("skip", &entries, bench.effort.pick(1, 11), bench.effort.pick(3, 7))?;
    let time = |name: &str| race.ratio(NOTHING, name);
    let of = |names: &[Option<(&str, String)>; 2], which: usize| names[which].as_ref().and_then(|(_, name)| time(name));
    let table = tabulate(
        "Time over that of the plain scene",
        &["feature: declared and idle / in use", "idle", "in use"],
        &rows,
        |(feature, names)| {
            let what = |which: usize, absent| names[which].as_ref().map_or(absent, |(what, _)| *what);
            (
                format!("{feature}: {} / {}", what(0, "cannot be declared without use"), what(1, "-")),
                [0, 1].map(|which| of(names, which).map(thousandths)).to_vec(),
            )
        },
    );
    let findings = rows[1..].iter().filter(|(_, names)| names[0].is_some()).flat_map(|(feature, names)| {
        bench.judge(feature, "At most 1.01 times the time of the plain scene while it has nothing to do.", || {
            let ratio = of(names, 0)?;
            Some((format!("{ratio:.3} times."), ratio <= MOST))
        })
    });
    Ok(Section {
        title: "What a scene does not use".into(),
        text: format!(
            "A plain block of 13 824 particles (FLIP, quadratic B-splines, stress last; no boundary, load, probe or recording) against the same \
             scene in which one thing is declared but has nothing to do, and one in which it is in use. {CALLS} calls of `step` a timing, of one \
             substep each; one thread. The first row says how far from 1 a ratio is by chance; where the memory of a process lies moves it by \
             a hundredth or two, so that all are started anew again and again. `cargo bench --bench instructions` counts the instructions of such pairs, which are the same in each run, and \
             holds them to the same figure."
        ),
        tables: vec![table],
        findings: findings.collect(),
        failures: race.faults,
        ..Section::default()
    })
}
