//! What single precision costs in error: T2 and A2, in both precisions.

use super::common::SINGLE_PRECISION;
use super::{Bench, scenes};
use crate::scene::Scene;
use crate::study::Section;
use crate::study::reference::Table as Known;
use crate::study::tools::{rms, tabulate};

/// Displacements and stresses of all particles at the end of a run.
struct Fields {
    position: Vec<f64>,
    displacement: Vec<f64>,
    stress: Vec<f64>,
}

fn run(scene: &str) -> Result<Fields, String> {
    // a key that is not known is told without the list of those that are
    let text = |error: &dyn std::fmt::Display| error.to_string().split("; allowed:").next().unwrap_or_default().to_owned();
    let mut sim = Scene::from_toml(scene).and_then(Scene::build).map_err(|e| text(&e))?;
    sim.step(sim.scene().time.end).map_err(|e| text(&e))?;
    let mut get = |name: &str| sim.get(name).map(<[f64]>::to_vec).map_err(|e| text(&e));
    Ok(Fields { position: get("particle/position")?, displacement: get("particle/displacement")?, stress: get("particle/stress")? })
}

/// RMS of the difference over the RMS of the second.
fn apart(ours: &[f64], other: &[f64]) -> f64 {
    rms(ours.iter().zip(other).map(|(a, b)| a - b)) / rms(other.iter().copied())
}

/// RMS errors of displacement and stress of T2 against the spectral reference, over the RMS of the reference.
fn errors(fields: &Fields, end: f64) -> [f64; 2] {
    let known = Known::bar();
    let places = fields.position.iter().zip(&fields.displacement);
    let exact: Vec<[f64; 3]> = places.map(|(x, u)| known.over_place(end, x - u, 6)).collect();
    let stress: Vec<f64> = fields.stress.iter().step_by(9).copied().collect();
    let column = |index: usize| -> Vec<f64> { exact.iter().map(|e| e[index]).collect() };
    [apart(&fields.displacement, &column(0)), apart(&stress, &column(2))]
}

pub(super) fn section(bench: &mut Bench) -> Result<Section, String> {
    let t2_end = 0.5;
    let cells = bench.effort.pick(8, 32);
    let t2 = |method: &str| scenes::t2(cells, method, t2_end);
    let a2_end = bench.effort.pick(2.0, 20.0);
    let a2 = |method: &str| {
        format!(
            "{}\nload.tip.point_force = {{ body = \"beam\", at = [7.9166666667, 0.9166666667], value = [0, \"-100/288*t/20\"] }}\n",
            scenes::a2_unloaded(method, a2_end)
        )
    };
    let mut rows: Vec<(String, [Option<f64>; 2])> = Vec::new();
    let mut failures = Vec::new();
    let mut both = |name: &str, double: &Fields, single: Result<Fields, String>| {
        let single = single.map_err(|fault| failures.push((format!("{name} in single precision"), fault))).ok();
        let of = |field: fn(&Fields) -> &[f64]| single.as_ref().map(|single| apart(field(single), field(double)));
        let row = [of(|f| f.displacement.as_slice()), of(|f| f.stress.as_slice())];
        rows.push((format!("{name}: single less double, over double"), row));
        single
    };
    let double = run(&t2(""))?;
    let single = both("T2", &double, run(&t2(SINGLE_PRECISION)));
    both("A2", &run(&a2(""))?, run(&a2(SINGLE_PRECISION)));
    rows.push(("T2, double: error, over the exact solution".into(), errors(&double, t2_end).map(Some)));
    let known = single.map(|single| errors(&single, t2_end));
    rows.push(("T2, single: error, over the exact solution".into(), [0, 1].map(|kind| known.map(|k| k[kind]))));
    let two = |value: f64| format!("{value:.1e}").parse().unwrap_or(value);
    let table = tabulate("RMS over all particles", &["", "displacement", "stress"], rows, |(name, values)| {
        (name, values.map(|value| value.map(two)).to_vec())
    });
    Ok(Section {
        title: "Single precision".into(),
        text: format!(
            "T2: the vibrating bar of Tielen (2016), {cells} cells, quadratic B-splines, MUSL, at {t2_end} s; its exact solution is the reference \
             of `matpoint study accuracy`. A2: the cantilever of Andersen and Andersen (2007), stress first, at {a2_end} s. All else alike, only \
             `method.precision` differs."
        ),
        tables: vec![table],
        failures,
        ..Section::default()
    })
}
