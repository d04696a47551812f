//! A small scene, stepped by a controller: what is left of a step when there is little to compute, and whether memory grows.

use super::stopwatch::{Stopwatch, Task};
use super::{Bench, Entry, scenes, three};
use crate::study::Section;
use crate::study::tools::tabulate;

const ALL: &str = "set, step, get";
const STEP: &str = "step";
const MANY: &str = "step of 100 substeps, a substep of it";
/// Particles of A2.
const PARTICLES: f64 = 288.0;
/// Longest step that is allowed, everything included \[s\].
const MOST: f64 = 15e-6;

fn control(task: &mut Task) {
    task.set = Some(("load/tip/force".into(), vec![0.0, -0.1]));
    task.get = vec!["probe/tip/displacement".into(), "particle/position".into()];
}

pub(super) fn section(bench: &mut Bench) -> Result<Section, String> {
    let calls = bench.effort.pick(500, 5000);
    let entries = vec![
        Entry::scene(ALL, scenes::a2(), 1).calls(calls).with(control),
        Entry::scene(STEP, scenes::a2(), 1).calls(calls),
        Entry::scene(MANY, scenes::a2(), 100).calls(calls / 100),
    ];
    let race = bench.race("small", &entries, bench.rounds())?;
    let each = |name: &str| race.median(name).map(|rate| PARTICLES / rate);
    let times = tabulate("Time of a call", &["", "microseconds"], [ALL, STEP, MANY], |name| {
        (name.to_owned(), vec![each(name).map(|seconds| three(1e6 * seconds))])
    });

    let steps: u64 = bench.effort.pick(5_000, 1_000_000);
    let mut task = Task::new(scenes::a2());
    control(&mut task);
    let mut watch = Stopwatch::start(bench.program, &task, 1, None)?;
    // what is made at the first steps is made now
    watch.step(1000, 1)?;
    let before = watch.resident();
    watch.step(steps, 1)?;
    let after = watch.resident();
    let resident = before.clone().ok().zip(after.ok());
    let mut failures = race.faults.clone();
    failures.extend(before.err().map(|fault| ("resident memory".to_owned(), fault)));
    let memory = tabulate(
        &format!("Resident memory of the process over {steps} calls of set, step and get"),
        &["", "KiB"],
        [("after 1000 calls", resident.map(|r| r.0)), ("at the end", resident.map(|r| r.1))],
        |(name, bytes)| (name.to_owned(), vec![bytes.map(|bytes| bytes as f64 / 1024.0)]),
    );
    let mut findings = bench.judge("one step, everything included", "At most 15 microseconds.", || {
        let seconds = each(ALL)?;
        Some((format!("{:.1} microseconds.", 1e6 * seconds), seconds <= MOST))
    });
    findings.extend(bench.judge("a million steps", "No growth of memory.", || {
        let (before, after) = resident?;
        // a page or two are the system's
        Some((format!("{} KiB more.", after.saturating_sub(before) / 1024), after <= before + (64 << 10)))
    }));
    Ok(Section {
        title: "A small scene, step by step: A2".into(),
        text: format!(
            "The cantilever of Andersen and Andersen (2007): {PARTICLES} particles in the plane, B-splines of degree 2, stress first. In each call \
             the force at the tip is set, `step` takes one substep, and the displacement of the tip and the positions of all particles are read."
        ),
        tables: vec![times, memory],
        findings,
        failures,
        ..Section::default()
    })
}
