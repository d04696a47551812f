//! Cook's membrane: a tapered panel, clamped on the left, sheared on the right. Its grid is bent to fit it.

use super::{convergence, kept, tabulate};
use crate::record::{pressure, von_mises};
use crate::study::tools::{chart, cloud, percent, view};
use crate::study::{Axis, Chart, Cloud, Effort, Figure, Finding, Job, Run, Runs, Section, Series, Style};

/// Displacement of the middle of the right edge in plane stress \[m\].
const KNOWN: f64 = 23.964;
const CLAIMED: f64 = 23.96;
/// The same with nu = 0.4999 in plane strain \[m\]: where 64 cells of degree 4 lead from below (18.44) and above (18.49).
const SOFT: f64 = 18.48;

/// A variant of the problem.
struct Variant {
    name: &'static str,
    plane: &'static str,
    law: &'static str,
    poisson: f64,
    more: &'static str,
    /// Share of the load: what is linear is the same for all laws.
    share: f64,
}

const STRESS: Variant = Variant { name: "plane stress", plane: "stress", law: "linear_elastic", poisson: 1.0 / 3.0, more: "", share: 1.0 };
const LOCKED: Variant = Variant { name: "nu = 0.4999", plane: "strain", law: "neo_hookean", poisson: 0.4999, more: "", share: 1e-2 };
const FREE: Variant = Variant { name: "nu = 0.4999, mean dilatation", more: ", mean_dilatation = true", ..LOCKED };
const VARIANTS: [Variant; 3] = [STRESS, LOCKED, FREE];
const DEGREES: [usize; 2] = [1, 2];

fn grids(effort: Effort) -> &'static [usize] {
    effort.pick(&[4, 8, 16], &[4, 8, 16, 32, 64])
}

fn name(variant: &Variant, degree: usize, cells: usize) -> String {
    format!("cook/{}, degree {degree}, {cells} cells", variant.name)
}

pub(super) fn jobs(effort: Effort) -> Vec<Job> {
    let job = |variant: &Variant, degree: usize, cells: usize| {
        let scene = format!(
            r#"
            title = "Cook's membrane"
            dimension = 2
            plane = "{}"
            grid = {{ origin = [0, 0], size = [57.6, 60], cell = [{}, {}] }}
            material.rubber = {{ law = "{}", young = 1.0, poisson = {}, density = 1.0 }}
            body.membrane = {{ material = "rubber", shape = {{ polygon = {{ points = [[0, 0], [48, 44], [48, 60], [0, 44]] }} }} }}
            boundary.root = {{ region = {{ box = {{ min = [-1, -1], max = [0, 45] }} }}, fixed = ["x", "y"] }}
            load.shear.traction = {{ body = "membrane", face = "edge2", value = [0, "t/16"] }}
            probe.middle = {{ at = [48, 52] }}
            method = {{ formulation = "total", degree = {degree}, integrator = "quasi_static"{} }}
            time = {{ end = {}, step = {} }}
            "#,
            variant.plane,
            57.6 / cells as f64,
            30.0 / cells as f64,
            variant.law,
            variant.poisson,
            variant.more,
            variant.share,
            variant.share
        );
        let share = variant.share;
        let job = Job::new(name(variant, degree, cells), scene)
            .keep(share, "up", move |sim| Ok(vec![sim.get("probe/middle/displacement")?[1] / share]));
        if cells == 16 { job.snapshot(share, ["particle/position", "particle/stress"]) } else { job }
    };
    let grids = grids(effort);
    let kinds = VARIANTS.iter().flat_map(|variant| DEGREES.map(|degree| (variant, degree)));
    kinds.flat_map(|(variant, degree)| grids.iter().rev().map(move |&cells| job(variant, degree, cells))).collect()
}

fn up(runs: &Runs, variant: &Variant, degree: usize, cells: usize) -> Option<f64> {
    kept(runs.done(&name(variant, degree, cells)), variant.share, "up")
}

pub(super) fn section(effort: Effort, runs: &Runs) -> Section {
    let grids = grids(effort);
    let columns: Vec<(&Variant, usize)> = VARIANTS.iter().flat_map(|variant| DEGREES.map(|degree| (variant, degree))).collect();
    let titles: Vec<String> = columns.iter().map(|(variant, degree)| format!("{}, degree {degree}", variant.name)).collect();
    let header: Vec<&str> = ["cells along a side"].into_iter().chain(titles.iter().map(String::as_str)).collect();
    let title = format!("Displacement of the middle of the right edge [m]; known: {KNOWN} in plane stress, {SOFT} with nu = 0.4999");
    let table = tabulate(&title, &header, grids, |&cells| {
        (cells.to_string(), columns.iter().map(|(variant, degree)| up(runs, variant, *degree, cells)).collect())
    });
    Section {
        title: "Cook's membrane".into(),
        text: "48 m wide, 44 m high on the left and 16 m on the right, E = 1 Pa, a dead shear traction of 1 N in all on the right edge; n x n \
               cells bent to fit it, quasi-static, total Lagrangian, one step. Plane stress with nu = 1/3, linear elastic; plane strain with \
               nu = 0.4999, neo-Hookean under a hundredth of the load (what is given is a hundred times the displacement), with and without \
               the mean dilatation of a cell."
            .into(),
        tables: vec![table],
        figures: figures(grids, runs),
        findings: findings(effort, runs),
        ..Section::default()
    }
}

fn figures(grids: &[usize], runs: &Runs) -> Vec<Figure> {
    let points = |variant: &Variant, degree: usize, of: &dyn Fn(f64) -> f64| -> Vec<[f64; 2]> {
        grids.iter().filter_map(|&cells| Some([cells as f64, of(up(runs, variant, degree, cells)?)])).collect()
    };
    let soft = [(&LOCKED, "without"), (&FREE, "with")].into_iter().enumerate();
    let soft: Vec<Series> = soft
        .flat_map(|(i, (variant, word))| {
            DEGREES.map(|degree| {
                let name = format!("degree {degree}, {word} mean dilatation");
                Series::new(name, Style::Joined, points(variant, degree, &|v| v)).color(2 * i + degree - 1)
            })
        })
        .chain([Series::new("converged: 18.48 m", Style::Reference, grids.iter().map(|&n| [n as f64, SOFT]))])
        .collect();
    let hard = DEGREES.map(|degree| {
        let error = |v: f64| (v / KNOWN - 1.0).abs();
        Series::new(format!("degree {degree}"), Style::Joined, points(&STRESS, degree, &error)).color(degree - 1)
    });
    let cells = Axis::new("cells along a side", "").log().marks(grids.iter().map(|&n| n as f64));
    let caption = "Cook's membrane, nu = 0.4999: displacement of the middle of the right edge";
    let locking = Chart::new(caption, cells, Axis::new("displacement", "m"), soft);
    let state = |variant: &'static Variant, degree: usize, of: fn(&[f64]) -> f64| {
        let run = runs.done(&name(variant, degree, 16))?;
        view(variant.name, run, variant.share, |run: &Run| {
            Some(run.at(variant.share, "particle/stress")?.chunks_exact(9).map(of).collect())
        })
    };
    let stress = Cloud::new(
        "Cook's membrane, plane stress, 16 x 16 cells: von Mises stress",
        Axis::new("von Mises stress", "Pa"),
        state(&STRESS, 2, von_mises),
    );
    let check = [&LOCKED, &FREE].into_iter().filter_map(|variant| state(variant, 1, pressure));
    let check =
        Cloud::new("Cook's membrane, nu = 0.4999, degree 1, 16 x 16 cells: pressure", Axis::new("pressure", "Pa"), check).columns(2);
    vec![
        convergence(
            "cook-stress-error",
            "Cook's membrane, plane stress: error of the displacement over 23.964 m",
            "cells along a side",
            grids,
            Axis::new("relative error", ""),
            hard,
        ),
        chart("cook-locking", caption, locking),
        cloud("cook-shape", "Plane stress, degree 2, 16 x 16 cells: the membrane under its load, true to scale, von Mises stress", stress),
        cloud("cook-pressure", "nu = 0.4999, degree 1, 16 x 16 cells: pressure without and with the mean dilatation", check),
    ]
}

fn findings(effort: Effort, runs: &Runs) -> Vec<Finding> {
    let plane = Finding::judge("plane stress", "23.96 m within 0.3 %, degree 2, 16 x 16 cells.", true, || {
        let found = up(runs, &STRESS, 2, 16)?;
        Some((format!("{found:.4} m: {}.", percent(found / CLAIMED - 1.0)), (found / CLAIMED - 1.0).abs() <= 0.003))
    });
    let finest = effort.pick(16, 64);
    let locking = DEGREES.into_iter().zip([0.02, 0.002]).map(|(degree, most)| {
        let claim = format!("With the mean dilatation it does not lock: within {} of {SOFT} m from 16 x 16 cells on.", percent(most));
        Finding::judge(format!("nu = 0.4999, degree {degree}"), claim, true, || {
            let grids = grids(effort).iter().filter(|&&n| n >= 16);
            let errors = grids.map(|&n| Some((up(runs, &FREE, degree, n)? / SOFT - 1.0).abs())).collect::<Option<Vec<_>>>()?;
            let [without, with] = [&LOCKED, &FREE].map(|variant| up(runs, variant, degree, 16));
            let (without, with) = (without?, with?);
            let seen = format!(
                "16 x 16 cells: {with:.3} m with, {without:.3} m without; {finest} x {finest}: {:.3} and {:.3} m.",
                up(runs, &FREE, degree, finest)?,
                up(runs, &LOCKED, degree, finest)?
            );
            Some((seen, errors.iter().all(|e| *e <= most)))
        })
    });
    [plane].into_iter().chain(locking).collect()
}
