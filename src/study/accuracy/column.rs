//! A column stands under its own weight. The stress is that of the weight above, whatever the law.

use super::{kept, tabulate};
use crate::study::tools::{chart, small};
use crate::study::{Axis, Chart, Effort, Finding, Job, Runs, Section, Series, Style};

const HEIGHT: f64 = 50.0;
const YOUNG: f64 = 1e6;
const DENSITY: f64 = 80.0;
const GRAVITY: f64 = 10.0;
const CELLS: usize = 50;

/// A law, and the stretch under a stress [Pa].
struct Law {
    key: &'static str,
    name: &'static str,
    stretch: fn(f64) -> f64,
}

const LAWS: [Law; 2] =
    [Law { key: "hencky", name: "Hencky", stretch: hencky }, Law { key: "neo_hookean", name: "neo-Hookean", stretch: neo_hookean }];

/// P = E ln F / F, by Newton's method.
fn hencky(stress: f64) -> f64 {
    (0..20).fold(1.0f64, |f, _| f - (f.ln() - stress / YOUNG * f) / (1.0 / f - stress / YOUNG))
}

/// P = E (F - 1 / F) / 2.
fn neo_hookean(stress: f64) -> f64 {
    stress / YOUNG + (1.0 + (stress / YOUNG).powi(2)).sqrt()
}

/// Displacement of the point that was at `x`: the strain summed from the foot up, by Simpson's rule.
fn displacement(law: &Law, x: f64) -> f64 {
    let strain = |x: f64| (law.stretch)(-DENSITY * GRAVITY * (HEIGHT - x)) - 1.0;
    let h = x / 400.0;
    (0..400).map(|k| k as f64 * h).map(|a| h / 6.0 * (strain(a) + 4.0 * strain(a + 0.5 * h) + strain(a + h))).sum()
}

fn name(law: &Law, degree: usize) -> String {
    format!("column/{}, degree {degree}", law.key)
}

pub(super) fn jobs(_: Effort) -> Vec<Job> {
    let job = |law: &Law, degree: usize| {
        let scene = format!(
            r#"
            title = "column under self-weight"
            dimension = 1
            grid = {{ origin = [0], size = [{HEIGHT}], cell = {} }}
            material.soft = {{ law = "{}", young = {YOUNG}, density = {DENSITY} }}
            body.column = {{ material = "soft", shape = {{ box = {{ min = [0], max = [{HEIGHT}] }} }} }}
            boundary.foot = {{ face = "x-", fixed = ["x"] }}
            load.weight.gravity = ["-{GRAVITY}*t"]
            probe.top = {{ at = [{HEIGHT}] }}
            method = {{ formulation = "total", degree = {degree}, integrator = "quasi_static" }}
            time = {{ end = 1.0, step = 0.25 }}
            exact = {{ stress = {{ xx = "-{DENSITY}*{GRAVITY}*({HEIGHT}-x)" }} }}
            "#,
            HEIGHT / CELLS as f64,
            law.key
        );
        Job::new(name(law, degree), scene)
            .snapshot(1.0, ["probe/top/displacement", "error/stress", "particle/position", "particle/displacement"])
    };
    LAWS.iter().flat_map(|law| (1..=3).map(move |degree| job(law, degree))).collect()
}

/// Displacement of the top \[m\], and largest error of the stress over the largest stress.
fn found(runs: &Runs, law: &Law, degree: usize) -> Option<[f64; 2]> {
    let run = runs.done(&name(law, degree))?;
    Some([kept(Some(run), 1.0, "probe/top/displacement")?, run.at(1.0, "error/stress")?.get(1)? / (DENSITY * GRAVITY * HEIGHT)])
}

pub(super) fn section(_: Effort, runs: &Runs) -> Section {
    let rows = LAWS.iter().flat_map(|law| (1..=3).map(move |degree| (law, degree)));
    let table = tabulate(
        "The column at rest",
        &["law, degree", "top, exact [m]", "top [m]", "error [m]", "largest error of stress / largest stress"],
        rows,
        |(law, degree)| {
            let (exact, ours) = (displacement(law, HEIGHT), found(runs, law, degree));
            let values = vec![Some(exact), ours.map(|v| v[0]), ours.map(|v| v[0] - exact), ours.map(|v| v[1])];
            (format!("{}, {degree}", law.name), values)
        },
    );
    let ours = LAWS.iter().filter_map(|law| {
        let run = runs.done(&name(law, 3))?;
        let (now, moved) = (run.at(1.0, "particle/position")?, run.at(1.0, "particle/displacement")?);
        let points: Vec<[f64; 2]> = now.iter().zip(moved).map(|(x, u)| [x - u, *u]).collect();
        Some(Series::new(format!("{}, degree 3", law.name), Style::Markers, points))
    });
    let exact = LAWS.iter().map(|law| {
        let points = (0..=100).map(|k| 0.01 * HEIGHT * f64::from(k)).map(|x| [x, displacement(law, x)]);
        Series::new(format!("{}, exact", law.name), Style::Reference, points)
    });
    let figure = chart(
        "column",
        "The column under its weight: displacement over the height",
        Chart::new(
            "Column under its weight: displacement",
            Axis::new("height at time 0", "m"),
            Axis::new("displacement", "m"),
            ours.chain(exact),
        ),
    );
    let findings = LAWS.iter().map(|law| {
        let claim = "Cauchy stress exact to 1e-8 of the largest at every Gauss point; displacement of the top to 1e-6 m.";
        Finding::judge(format!("{}, degree 3", law.name), claim, true, || {
            let [top, stress] = found(runs, law, 3)?;
            let error = (top - displacement(law, HEIGHT)).abs();
            Some((format!("{} of the largest; {} m.", small(stress), small(error)), stress <= 1e-8 && error <= 1e-6))
        })
    });
    Section {
        title: "Column under self-weight".into(),
        text: format!(
            "{HEIGHT} m, E = {YOUNG:e} Pa, {DENSITY} kg/m3, g = {GRAVITY} m/s2 in four steps, {CELLS} cells, quasi-static, total Lagrangian. \
             The Cauchy stress is that of the weight above for any law; the displacement is the integral of the stretch under it."
        ),
        tables: vec![table],
        figures: vec![figure],
        findings: findings.collect(),
        ..Section::default()
    }
}
