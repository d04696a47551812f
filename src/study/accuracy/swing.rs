//! A compliant cantilever falls under its own weight, by explicit and implicit steps, and with particles that move through a grid.

use super::tabulate;
use crate::record::von_mises;
use crate::study::tools::{chart, cloud, percent, view};
use crate::study::{Axis, Chart, Cloud, Effort, Finding, Job, Runs, Section, Series, Style};

const END: f64 = 1.1;
/// When the picture is taken \[s\]: near the first trough.
const LOW: f64 = 1.05;
/// First trough of the lower corner of the tip \[m\]: Q2 finite elements, 32 x 8.
const KNOWN: f64 = -3.305;

/// A method of solution.
struct Method {
    name: &'static str,
    /// The cell \[m\], and the lines of `[method]`.
    cell: f64,
    toml: &'static str,
    time: &'static str,
    updated: bool,
}

const fn total(name: &'static str, cell: f64, toml: &'static str, time: &'static str) -> Method {
    Method { name, cell, toml, time, updated: false }
}

const fn updated(name: &'static str, toml: &'static str, time: &'static str) -> Method {
    Method { name, cell: 0.25, toml, time, updated: true }
}

const IMPLICIT: &str = "step = 0.0025";
const VERLET: Method = total("total, Verlet", 0.25, r#"formulation = "total", degree = 3"#, "cfl = 0.8");
const METHODS: [Method; 8] = [
    VERLET,
    total("total, Newmark", 0.25, r#"formulation = "total", degree = 3, integrator = "newmark""#, IMPLICIT),
    total("total, generalised alpha", 0.25, r#"formulation = "total", degree = 3, integrator = "generalized_alpha""#, IMPLICIT),
    total("total, energy-momentum", 0.25, r#"formulation = "total", degree = 3, integrator = "energy_momentum""#, IMPLICIT),
    total("total, Verlet, half the cell", 0.125, r#"formulation = "total", degree = 3"#, "cfl = 0.8"),
    updated("updated, MUSL", "degree = 2", "cfl = 0.4"),
    updated("updated, Newmark", r#"degree = 2, integrator = "newmark""#, IMPLICIT),
    updated("updated, energy-momentum", r#"degree = 2, integrator = "energy_momentum""#, IMPLICIT),
];

fn methods(effort: Effort) -> impl Iterator<Item = &'static Method> {
    METHODS.iter().filter(move |m| {
        effort == Effort::Full || ["total, Verlet", "total, Newmark", "updated, MUSL", "updated, Newmark"].contains(&m.name)
    })
}

fn name(method: &Method) -> String {
    format!("swing/{}", method.name)
}

pub(super) fn jobs(effort: Effort) -> Vec<Job> {
    let job = |method: &Method| {
        let scene = format!(
            r#"
            title = "compliant cantilever"
            dimension = 2
            grid = {{ origin = [0, -5], size = [5, 8], cell = {} }}
            material.rubber = {{ law = "neo_hookean", young = 1e6, poisson = 0.3, density = 1050.0 }}
            body.beam = {{ material = "rubber", shape = {{ box = {{ min = [0, 0], max = [4, 1] }} }}{} }}
            boundary.root = {{ face = "x-", fixed = ["x", "y"] }}
            load.weight.gravity = [0, -10]
            probe.corner = {{ at = [4, 0] }}
            method = {{ {} }}
            time = {{ end = {END}, {} }}
            "#,
            method.cell,
            if method.updated { ", particles_per_cell = 4" } else { "" },
            method.toml,
            method.time
        );
        let corner = |sim: &mut crate::Simulation| Ok(sim.get("probe/corner/displacement")?[1]);
        Job::new(name(method), scene).every(0.005).watch("corner", corner).snapshot(LOW, ["particle/position", "particle/stress"])
    };
    methods(effort).map(job).collect()
}

/// Time \[s\] and displacement \[m\] of the first trough: of the parabola through the lowest sample and its neighbours.
fn trough(runs: &Runs, method: &Method) -> Option<[f64; 2]> {
    let curve = runs.done(&name(method))?.curve("corner");
    let lowest = (1..curve.len().checked_sub(1)?).min_by(|&a, &b| curve[a][1].total_cmp(&curve[b][1]))?;
    let [[_, a], [t, b], [after, c]] = [curve[lowest - 1], curve[lowest], curve[lowest + 1]];
    let shift = 0.5 * (a - c) / (a - 2.0 * b + c);
    Some([t + shift * (after - t), b - 0.25 * (a - c) * shift])
}

pub(super) fn section(effort: Effort, runs: &Runs) -> Section {
    let table = tabulate(
        "First trough of the lower corner of the tip",
        &["method", "time [s]", "displacement [m]", "over -3.305 m", "steps", "wall time [s]"],
        methods(effort),
        |m| {
            let (run, low) = (runs.done(&name(m)), trough(runs, m));
            let values =
                vec![low.map(|v| v[0]), low.map(|v| v[1]), low.map(|v| v[1] / KNOWN), run.map(|r| r.substeps as f64), run.map(|r| r.wall)];
            (format!("{}, cells of {} m", m.name, m.cell), values)
        },
    );
    // two that nobody could tell from Newmark's in the picture
    let shown = methods(effort).filter(|m| !["total, generalised alpha", "total, energy-momentum"].contains(&m.name));
    let curves: Vec<Series> = shown.filter_map(|m| Some(Series::new(m.name, Style::Line, runs.get(&name(m))?.curve("corner")))).collect();
    let known = Series::new("Q2 elements: -3.305 m", Style::Reference, [[0.9, KNOWN], [END, KNOWN]]);
    let figure = |file: &str, caption: &str, time: Axis, displacement: Axis| {
        chart(file, caption, Chart::new(caption, time, displacement, std::iter::once(&known).chain(&curves).cloned()))
    };
    let views = methods(effort).filter(|m| ["total, Verlet", "updated, MUSL"].contains(&m.name)).filter_map(|m| {
        let stress = |run: &crate::study::Run| Some(run.at(LOW, "particle/stress")?.chunks_exact(9).map(von_mises).collect());
        view(m.name, runs.done(&name(m))?, LOW, stress)
    });
    let caption = format!("The cantilever at {LOW} s, von Mises stress");
    let picture = Cloud::new(caption.as_str(), Axis::new("von Mises stress", "Pa"), views).columns(2);
    Section {
        title: "Compliant cantilever under sudden self-weight".into(),
        text: "L = 4 m, H = 1 m, E = 1e6 Pa, nu = 0.3, 1050 kg/m3, neo-Hookean, plane strain, g = 10 m/s2 from time 0 on. Total Lagrangian of \
               degree 3, updated Lagrangian of degree 2 with 4 x 4 particles a cell. After about 1.2 s the root corner folds and the \
               solution depends on the mesh: runs end before."
            .into(),
        tables: vec![table],
        figures: vec![
            figure("swing", "Lower corner of the tip: displacement", Axis::new("time", "s"), Axis::new("displacement", "m")),
            figure(
                "swing-trough",
                "Lower corner of the tip near the first trough",
                Axis::new("time", "s").within(1.0, END),
                Axis::new("displacement", "m").within(-3.33, -3.22),
            ),
            cloud("swing-shape", &caption, picture),
        ],
        findings: findings(effort, runs),
        ..Section::default()
    }
}

fn findings(effort: Effort, runs: &Runs) -> Vec<Finding> {
    let largest = |kind: &dyn Fn(&Method) -> bool, base: f64| {
        let of = |m: &Method| Some((m.name, trough(runs, m)?[1] / base - 1.0));
        let all = methods(effort).filter(|m| kind(m)).map(of).collect::<Option<Vec<_>>>()?;
        let most = all.iter().map(|v| v.1.abs()).fold(0.0, f64::max);
        Some((all.iter().map(|(name, v)| format!("{name} {}", percent(*v))).collect::<Vec<_>>().join(", "), most))
    };
    let coarse = |m: &Method| m.cell == VERLET.cell;
    vec![
        Finding::judge("total Lagrangian", "First trough within 0.5 % of -3.305 m.", true, || {
            let (list, most) = largest(&|m| !m.updated, KNOWN)?;
            Some((format!("{list}."), most <= 0.005))
        }),
        Finding::judge("implicit and explicit", "They agree within 0.2 %.", true, || {
            let (list, most) = largest(&|m| !m.updated && coarse(m) && m.name != VERLET.name, trough(runs, &VERLET)?[1])?;
            Some((format!("Over Verlet: {list}."), most <= 0.002))
        }),
        Finding::judge("updated Lagrangian", "First trough within 1.5 % of -3.305 m.", true, || {
            let (list, most) = largest(&|m| m.updated, KNOWN)?;
            Some((format!("{list}."), most <= 0.015))
        }),
    ]
}
