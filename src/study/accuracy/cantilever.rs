//! A cantilever is bent by a dead tip load until it points almost in the direction of the load.

use super::{convergence, kept, tabulate};
use crate::study::tools::{cloud, places, small, stress_xx};
use crate::study::{Axis, Cell, Cloud, Effort, Finding, Job, Runs, Section, Series, Style, Table, View};

/// A load, and where it takes the tip.
struct Load {
    /// P L^2 / E I.
    size: f64,
    /// Steps in which it is applied.
    steps: usize,
    /// Tip displacement over length, along and across: Q2 finite elements of the same continuum, to 5e-6.
    continuum: Option<[f64; 2]>,
    /// The same of a line that cannot be stretched or sheared (Mattiasson 1981).
    elastica: [f64; 2],
}

const LOADS: [Load; 3] = [
    Load { size: 1.0, steps: 1, continuum: Some([-0.056694, 0.303753]), elastica: [-0.056433236, 0.301720774] },
    Load { size: 2.0, steps: 4, continuum: None, elastica: [-0.160641721, 0.493457480] },
    Load { size: 10.0, steps: 10, continuum: Some([-0.559307, 0.824310]), elastica: [-0.554995598, 0.810609025] },
];
/// Cells over the height, and degree, of what is claimed, and of what is taken for exact.
const CLAIMED: (usize, usize) = (4, 3);
const FINE: (usize, usize) = (6, 4);
/// Of the picture.
const SHOWN: (usize, usize) = (2, 3);
const HEIGHTS: [usize; 3] = [1, 2, 4];

fn degrees(effort: Effort) -> Vec<usize> {
    effort.pick(vec![3], vec![1, 2, 3])
}

fn name(load: &Load, (cells, degree): (usize, usize)) -> String {
    format!("cantilever/{}, {cells} cells, degree {degree}", load.size)
}

pub(super) fn jobs(effort: Effort) -> Vec<Job> {
    let job = |load: &Load, mesh: (usize, usize)| {
        // E = 12e6, L = 10, h = 1: E I = 1e6 for a unit of thickness
        let scene = format!(
            r#"
            title = "cantilever under a dead tip load"
            dimension = 2
            grid = {{ origin = [0, 0], size = [10, 1], cell = {} }}
            material.rubber = {{ law = "neo_hookean", young = 12e6, poisson = 0.0, density = 1000.0 }}
            body.beam = {{ material = "rubber", shape = {{ box = {{ min = [0, 0], max = [10, 1] }} }} }}
            boundary.root = {{ face = "x-", fixed = ["x", "y"] }}
            load.tip.traction = {{ body = "beam", face = "x+", value = [0, "{}*t"] }}
            probe.tip = {{ at = [10, 0.5] }}
            method = {{ formulation = "total", degree = {}, integrator = "quasi_static" }}
            time = {{ end = 1.0, step = {} }}
            "#,
            1.0 / mesh.0 as f64,
            1e4 * load.size,
            mesh.1,
            1.0 / load.steps as f64
        );
        let state: &[&str] = if mesh == SHOWN { &["particle/position", "particle/displacement", "particle/stress"] } else { &[] };
        Job::new(name(load, mesh), scene)
            .snapshot(1.0, ["probe/tip/displacement", "boundary/root/reaction"])
            .snapshot(1.0, state.iter().copied())
    };
    let meshes: Vec<_> = degrees(effort).into_iter().flat_map(|degree| HEIGHTS.map(|cells| (cells, degree))).chain([FINE]).collect();
    LOADS.iter().flat_map(|load| meshes.iter().map(move |&mesh| job(load, mesh))).collect()
}

/// Tip displacement over length, along and across.
fn tip(runs: &Runs, load: &Load, mesh: (usize, usize)) -> Option<[f64; 2]> {
    let tip = runs.done(&name(load, mesh))?.at(1.0, "probe/tip/displacement")?;
    Some([tip[0] / 10.0, tip[1] / 10.0])
}

/// What is known of the continuum: by others, or by our finest mesh.
fn known(runs: &Runs, load: &Load) -> Option<[f64; 2]> {
    load.continuum.or_else(|| tip(runs, load, FINE))
}

fn apart(a: [f64; 2], b: [f64; 2]) -> f64 {
    f64::max((a[0] - b[0]).abs(), (a[1] - b[1]).abs())
}

pub(super) fn section(effort: Effort, runs: &Runs) -> Section {
    let row = |load: &Load| {
        let (ours, known) = (tip(runs, load, CLAIMED), known(runs, load));
        let cell = |axis: usize| Cell { paper: known.map(|v| v[axis]), ours: ours.map(|v| v[axis]) };
        let line = |axis: usize| Cell { paper: None, ours: Some(load.elastica[axis]) };
        (load.size.to_string(), vec![cell(0), cell(1), line(0), line(1)])
    };
    let tips = Table {
        title: "Tip displacement over length, degree 3, 4 cells over the height".into(),
        header: ["P L^2 / E I", "along", "across", "elastica along", "elastica across"].map(str::to_owned).to_vec(),
        rows: LOADS.iter().map(row).collect(),
        beside: "continuum",
        band: None,
    };
    let degrees = degrees(effort);
    let error = |load: &Load, mesh| Some(apart(tip(runs, load, mesh)?, tip(runs, load, FINE)?));
    let rows = degrees.iter().flat_map(|&degree| HEIGHTS.map(|cells| (cells, degree)));
    let errors = tabulate(
        "Largest error of tip displacement over length, against degree 4 and 6 cells",
        &["degree, cells over the height", "P L^2 / E I = 1", "2", "10"],
        rows,
        |mesh| (format!("{}, {}", mesh.1, mesh.0), LOADS.iter().map(|load| error(load, mesh)).collect()),
    );
    let series = degrees.iter().flat_map(|&degree| {
        LOADS.iter().enumerate().filter(|(_, load)| load.size != 2.0).map(move |(i, load)| {
            let points = HEIGHTS.iter().filter_map(|&cells| Some([cells as f64, error(load, (cells, degree))?]));
            Series::new(format!("degree {degree}, load {}", load.size), Style::Joined, points).color(2 * (degree - 1) + i / 2)
        })
    });
    let curves = convergence(
        "cantilever-error",
        "Cantilever: largest error of tip displacement over length, against degree 4 and 6 cells",
        "cells over the height",
        &HEIGHTS,
        Axis::new("error", ""),
        series,
    );
    let findings = LOADS.iter().map(|load| {
        let whose = if load.continuum.is_some() { "the continuum's (Q2 elements)" } else { "that of degree 4 with 6 cells" };
        let claim = format!("Tip displacement over length within 1e-4 of {whose}, degree 3, 4 cells over the height.");
        Finding::judge(format!("P L^2 / E I = {}", load.size), claim, true, || {
            let run = runs.done(&name(load, CLAIMED))?;
            let (ours, known) = (tip(runs, load, CLAIMED)?, known(runs, load)?);
            let force = 1e4 * load.size;
            let balance = (kept(Some(run), 1.0, "boundary/root/reaction")? / force)
                .abs()
                .max((run.at(1.0, "boundary/root/reaction")?.get(1)? / force + 1.0).abs());
            let seen = format!(
                "{:.6} along and {:.6} across: {} apart; load steps {}, Newton iterations {}; reaction and load balance to {}.",
                ours[0],
                ours[1],
                small(apart(ours, known)),
                run.substeps,
                run.iterations,
                small(balance)
            );
            Some((seen, apart(ours, known) <= 1e-4))
        })
    });
    Section {
        title: "Cantilever under a dead tip load".into(),
        text:
            "L = 10 m, h = 1 m, E = 12e6 Pa, nu = 0, neo-Hookean, plane strain, the whole root clamped, a dead shear traction on the whole \
               end; quasi-static, total Lagrangian. The elastica is a line that cannot be stretched or sheared: the continuum is softer."
                .into(),
        tables: vec![tips, errors],
        figures: vec![picture(runs), curves],
        findings: findings.collect(),
        ..Section::default()
    }
}

/// The beam at rest and under all loads, in one view.
fn picture(runs: &Runs) -> crate::study::Figure {
    let mut all = View { title: "at rest, and under loads P L^2 / E I = 1, 2 and 10".into(), points: Vec::new(), values: Vec::new() };
    for (i, load) in LOADS.iter().enumerate() {
        let Some(run) = runs.done(&name(load, SHOWN)) else { continue };
        let state = ["particle/position", "particle/displacement", "particle/stress"].map(|name| run.at(1.0, name));
        let [Some(position), Some(moved), Some(stress)] = state else { continue };
        let now = places(position);
        if i == 0 {
            all.points.extend(now.iter().zip(places(moved)).map(|(x, u)| [x[0] - u[0], x[1] - u[1]]));
            all.values.extend(now.iter().map(|_| 0.0));
        }
        all.values.extend(stress_xx(stress));
        all.points.extend(now);
    }
    let picture = Cloud::new("Cantilever under a dead tip load: stress xx", Axis::new("stress xx", "Pa"), [all]);
    cloud("cantilever", "The cantilever at rest and under the three loads, true to scale, stress xx", picture)
}
