//! A2: the cantilever of Andersen and Andersen (2007), whose tip force grows for as long as the beam takes to swing once: the motion, to
//! more digits than any of the paper's methods has.

use super::tabulate;
use crate::study::tools::{chart, largest, percent, small, table};
use crate::study::{Axis, Chart, Effort, Finding, Job, Panel, Run, Runs, Section, Series, Style};

/// End of the growth of the force \[s\].
const END: f64 = 20.0;
/// Time between samples \[s\]: that of the study of the papers.
const EVERY: f64 = 0.2;
/// Mesh and step of a run: cells along a sixth of a metre, and the share of the stable step; the force of the paper \[N\].
struct Mesh {
    name: &'static str,
    cells: usize,
    cfl: f64,
    force: f64,
}

const BASE: Mesh = Mesh { name: "cells of 1/6 m", cells: 1, cfl: 0.8, force: 100.0 };
const STEPS: Mesh = Mesh { name: "cells of 1/6 m, half the step", cells: 1, cfl: 0.4, force: 100.0 };
const FINE: Mesh = Mesh { name: "cells of 1/12 m", cells: 2, cfl: 0.8, force: 100.0 };
const LARGE: Mesh = Mesh { name: "cells of 1/6 m, 800 N", cells: 1, cfl: 0.8, force: 800.0 };

fn meshes(effort: Effort) -> &'static [Mesh] {
    effort.pick(&[BASE], &[FINE, STEPS, BASE, LARGE])
}

/// End of the runs \[s\].
fn end(effort: Effort) -> f64 {
    effort.pick(4.0, END)
}

fn name(mesh: &Mesh) -> String {
    format!("A2/{}", mesh.name)
}

pub(super) fn jobs(effort: Effort) -> Vec<Job> {
    let job = |mesh: &Mesh| {
        // the force of a particle of the paper, spread over its sixth of a metre squared: cells end where it does
        let scene = format!(
            r#"
            title = "Andersen 2007, cantilever"
            dimension = 2
            plane = "strain"
            grid = {{ origin = [0, 0], size = [8, 1], cell = {cell} }}
            material.steel = {{ law = "hypo_elastic", young = 3e5, poisson = 0, density = 1e3 }}
            body.beam = {{ material = "steel", shape = {{ box = {{ min = [0, 0], max = [8, 1] }} }} }}
            boundary.wall = {{ face = "x-", fixed = ["x", "y"] }}
            load.tip.body_force = {{ body = "beam", value = [0, "-{acceleration}*t/{END}*(1+sign(x-8+1/6))/2*(1+sign(y-1+1/6))/2"] }}
            probe.tip = {{ at = [8, 0.5] }}
            method = {{ formulation = "total", degree = {degree} }}
            time = {{ end = {end}, cfl = {cfl} }}
            "#,
            cell = 1.0 / 6.0 / mesh.cells as f64,
            acceleration = mesh.force / 288.0 * 36.0 / 1e3,
            degree = effort.pick(2, 3),
            cfl = mesh.cfl,
            end = end(effort),
        );
        Job::new(name(mesh), scene).every(EVERY).watch("tip", |sim| Ok(-sim.get("probe/tip/displacement")?[1]))
    };
    meshes(effort).iter().map(job).collect()
}

/// Deflection of the tip by the Ritz expansion: time \[s\] and deflection \[m\].
fn ritz() -> Vec<[f64; 2]> {
    table(include_str!("../../../tests/reference/andersen_cantilever_tip.csv"))
}

fn ritz_at(time: f64) -> Option<f64> {
    ritz().into_iter().find(|row| (row[0] - time).abs() < 1e-9).map(|row| row[1])
}

/// Largest difference of two deflections over all samples, the first scaled, over the last of the second.
fn apart(run: &Run, scale: f64, other: impl Fn(f64) -> Option<f64>) -> Option<f64> {
    let rows = run.curve("tip").into_iter().map(|[t, v]| Some(v * scale - other(t)?)).collect::<Option<Vec<_>>>()?;
    Some(largest(rows) / other(*run.times.last()?)?)
}

fn sample(run: &Run, time: f64) -> Option<f64> {
    run.curve("tip").into_iter().find(|p| (p[0] - time).abs() < 1e-9).map(|p| p[1])
}

pub(super) fn section(effort: Effort, runs: &Runs) -> Section {
    let get = |mesh: &Mesh| runs.done(&name(mesh));
    let at = |mesh: &Mesh, time: f64| sample(get(mesh)?, time);
    let best = effort.pick(BASE, FINE);
    let rows = (1..=20).map(f64::from).filter(|t| t % effort.pick(1.0, 2.0) == 0.0 && *t <= end(effort));
    let deflections = tabulate(
        "Deflection of the tip at x = 8 m, y = 0.5 m [m], F = 100 N",
        &["time [s]", "Ritz", &format!("ours, {}", best.name), "finer less coarser mesh", "half less whole step", "ours less Ritz"],
        rows,
        |time| {
            let (ritz, fine, base) = (ritz_at(time), at(&FINE, time), at(&BASE, time));
            let less = |a: Option<f64>, b: Option<f64>| Some(a? - b?);
            let ours = if effort == Effort::Quick { base } else { fine };
            (time.to_string(), vec![ritz, ours, less(fine, base), less(at(&STEPS, time), base), less(ours, ritz)])
        },
    );
    let costs = tabulate("The runs", &["mesh", "steps", "wall time [s]", "largest difference from Ritz / tip"], meshes(effort), |mesh| {
        let run = get(mesh);
        let apart = run.and_then(|r| apart(r, 100.0 / mesh.force, ritz_at));
        (mesh.name.into(), vec![run.map(|r| r.substeps as f64), run.map(|r| r.wall), apart])
    });
    let ours =
        meshes(effort).iter().filter(|m| m.force == 100.0).filter_map(|m| Some(Series::new(m.name, Style::Line, get(m)?.curve("tip"))));
    let errors = meshes(effort).iter().filter(|m| m.force == 100.0).filter_map(|m| {
        let error = |[t, v]: [f64; 2]| Some([t, v - ritz_at(t)?]);
        Some(Series::new(m.name, Style::Line, get(m)?.curve("tip").into_iter().filter_map(error)))
    });
    let known = Series::new("Ritz expansion", Style::Reference, ritz());
    let figure = chart(
        "a2",
        "A2: deflection of the tip, and its difference from the Ritz expansion",
        Chart::stacked(
            "A2: deflection of the tip, F = 100 N",
            Axis::new("time", "s"),
            [
                Panel { y: Axis::new("deflection", "m"), series: ours.chain([known]).collect() },
                Panel { y: Axis::new("less Ritz", "m"), series: errors.collect() },
            ],
        ),
    );
    Section {
        title: "A2 Cantilever with a growing tip force (Andersen 2007): a dynamic reference".into(),
        text: format!(
            "8 m x 1 m, E = 3e5 Pa, nu = 0, 1e3 kg/m3; F / 288 pulls the upper right particle of the paper's 288 down, spread over its sixth \
             of a metre squared, and grows from 0 to its full size in {END} s. Total Lagrangian, B-splines of degree {}, velocity Verlet. \
             Beside it the reference of `matpoint study papers`: linear elastodynamics by a Ritz expansion in Legendre polynomials \
             (`tests/reference/andersen_tielen.py`), which shares nothing with it.",
            effort.pick(2, 3)
        ),
        tables: vec![deflections, costs],
        figures: vec![figure],
        findings: findings(effort, runs, &best),
        ..Section::default()
    }
}

fn findings(effort: Effort, runs: &Runs, best: &Mesh) -> Vec<Finding> {
    let get = |mesh: &Mesh| runs.done(&name(mesh));
    let same = Finding::judge("the paper's reference", "It is met within 1e-4 of the last deflection at all samples.", true, || {
        let apart = apart(get(best)?, 1.0, ritz_at)?;
        let last = sample(get(best)?, end(effort))?;
        Some((format!("{last:.9e} m at {} s; at most {} of it apart.", end(effort), small(apart)), apart <= 1e-4))
    });
    if effort == Effort::Quick {
        return vec![same];
    }
    let converged =
        Finding::judge("two meshes, two steps", "They differ by less than 1e-5 of the last deflection at all samples.", true, || {
            let base = |t: f64| sample(get(&BASE)?, t);
            let (meshes, steps) = (apart(get(&FINE)?, 1.0, base)?, apart(get(&STEPS)?, 1.0, base)?);
            Some((format!("Meshes: {}. Steps: {}.", small(meshes), small(steps)), meshes < 1e-5 && steps < 1e-5))
        });
    let linear = Finding::judge(
        "F = 800 N",
        "Linear theory, which the reference of the papers' figure 12 is, is good to 0.1 %.",
        true,
        || {
            let off = apart(get(&LARGE)?, 1.0 / 8.0, |t| sample(get(&BASE)?, t))?;
            let [usual, large] = [(BASE, 1.0), (LARGE, 8.0)].map(|(mesh, scale)| apart(get(&mesh)?, 1.0 / scale, ritz_at));
            let seen = format!(
                "An eighth of the deflection is at most {} of the last from that under 100 N. From Ritz they are {} and {} apart: nearly in \
             proportion to the force, so that most of what is left under 100 N is the work of finite displacements too.",
                percent(off),
                small(large?),
                small(usual?)
            );
            Some((seen, off < 1e-3))
        },
    );
    vec![converged, same, linear]
}
