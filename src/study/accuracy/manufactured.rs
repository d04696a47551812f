//! Manufactured solutions on the unit interval, square and cube: u_i = A sin(pi X_i) sin(pi c t + phase_i), finite strain, the body force
//! that this takes. All that is smooth and fitted to the grid is there, in three dimensions: what is left is the order of the method.

use super::{convergence, kept, order, tabulate};
use crate::study::{Axis, Effort, Finding, Job, Runs, Section, Series, Style};
use std::f64::consts::PI;

/// A dimension with the grids that each degree is run on.
struct Case {
    dimension: usize,
    grids: &'static [usize],
    degrees: std::ops::RangeInclusive<usize>,
}

const QUICK: [Case; 3] = [
    Case { dimension: 1, grids: &[4, 8, 16, 32], degrees: 1..=4 },
    Case { dimension: 2, grids: &[4, 6, 8, 12], degrees: 1..=4 },
    Case { dimension: 3, grids: &[4, 6], degrees: 1..=2 },
];
const FULL: [Case; 3] = [
    Case { dimension: 1, grids: &[4, 8, 16, 32], degrees: 1..=4 },
    Case { dimension: 2, grids: &[4, 6, 8, 12, 16, 24], degrees: 1..=4 },
    Case { dimension: 3, grids: &[4, 6, 8, 12], degrees: 1..=4 },
];
const AMPLITUDE: f64 = 0.05;

fn cases(effort: Effort) -> &'static [Case] {
    effort.pick(&QUICK, &FULL)
}

/// Young's modulus \[Pa\] and Poisson's ratio; the density is 1 kg/m3.
fn elasticity(dimension: usize) -> (f64, f64) {
    if dimension == 1 { (100.0, 0.0) } else { (1e4, 0.3) }
}

/// An eighth of a period \[s\]: displacement and velocity are both large.
fn end(dimension: usize) -> f64 {
    0.25 / elasticity(dimension).0.sqrt()
}

fn name(dimension: usize, cells: usize, degree: usize) -> String {
    format!("manufactured/{dimension}D, {cells} cells, degree {degree}")
}

fn scene(dimension: usize, cells: usize, degree: usize) -> String {
    let (young, poisson) = elasticity(dimension);
    let (mu, lambda) = (0.5 * young / (1.0 + poisson), young * poisson / ((1.0 + poisson) * (1.0 - 2.0 * poisson)));
    let c = young.sqrt();
    // phases 0, pi, pi: at rest and undeformed at time 0
    let axes = &["x", "y", "z"][..dimension];
    let amplitude = |a: usize| if a == 0 { AMPLITUDE } else { -AMPLITUDE };
    let wave = |a: usize| format!("({}*sin(PI*{c}*t))", amplitude(a));
    let stretch = |a: usize| format!("(1+PI*cos(PI*{})*{})", axes[a], wave(a));
    let log = (0..dimension).map(|a| format!("ln{}", stretch(a))).collect::<Vec<_>>().join("+");
    let displacement = |a: usize| format!("sin(PI*{})*{}", axes[a], wave(a));
    let force = |a: usize| format!("PI^2*{}*({mu}-{}-({lambda}*({log}-1)-{mu})/{}^2)", displacement(a), c * c, stretch(a));
    let velocity = |a: usize| format!("{}*sin(PI*{})", amplitude(a) * PI * c, axes[a]);
    let each = |f: &dyn Fn(usize) -> String| (0..dimension).map(|a| format!("\"{}\"", f(a))).collect::<Vec<_>>().join(", ");
    let sides = axes.iter().flat_map(|axis| ["-", "+"].map(|side| (*axis, side)));
    let held: String = sides
        .enumerate()
        .map(|(i, (axis, side))| format!("boundary.b{i} = {{ face = \"{axis}{side}\", fixed = [\"{axis}\"] }}\n"))
        .collect();
    format!(
        r#"
        title = "a manufactured solution"
        dimension = {dimension}
        grid = {{ origin = {zeros:?}, size = {ones:?}, cell = {cell} }}
        material.rubber = {{ law = "neo_hookean", young = {young}, poisson = {poisson}, density = 1.0 }}
        body.block = {{ material = "rubber", shape = {{ box = {{ min = {zeros:?}, max = {ones:?} }} }}, velocity = [{velocity}] }}
        {held}
        load.source.body_force = {{ body = "block", value = [{force}] }}
        method = {{ formulation = "total", degree = {degree}, integrator = "symplectic4" }}
        time = {{ end = {end}, cfl = 0.5 }}
        exact = {{ displacement = [{displacement}] }}
        "#,
        zeros = vec![0.0; dimension],
        ones = vec![1.0; dimension],
        cell = 1.0 / cells as f64,
        end = end(dimension),
        velocity = each(&velocity),
        force = each(&force),
        displacement = each(&displacement),
    )
}

pub(super) fn jobs(effort: Effort) -> Vec<Job> {
    let mut jobs = Vec::new();
    // the longest first: they run side by side
    for case in cases(effort).iter().rev() {
        for degree in case.degrees.clone().rev() {
            for &cells in case.grids.iter().rev() {
                let job = Job::new(name(case.dimension, cells, degree), scene(case.dimension, cells, degree));
                jobs.push(job.snapshot(end(case.dimension), ["error/displacement"]));
            }
        }
    }
    jobs
}

/// Points (cells, error) of a degree.
fn errors(runs: &Runs, case: &Case, degree: usize) -> Vec<[f64; 2]> {
    let error = |cells: usize| kept(runs.done(&name(case.dimension, cells, degree)), end(case.dimension), "error/displacement");
    case.grids.iter().filter_map(|&cells| Some([cells as f64, error(cells)?])).collect()
}

pub(super) fn section(effort: Effort, runs: &Runs) -> Section {
    let cases = cases(effort);
    let tables = cases.iter().map(|case| {
        let header: Vec<String> =
            ["degree".to_owned()].into_iter().chain(case.grids.iter().map(|n| format!("{n} cells"))).chain(["order".to_owned()]).collect();
        let header: Vec<&str> = header.iter().map(String::as_str).collect();
        tabulate(&format!("{}D: RMS error of the displacement [m]", case.dimension), &header, case.degrees.clone(), |degree| {
            let found = errors(runs, case, degree);
            (degree.to_string(), found.iter().map(|e| Some(e[1])).chain([order(&found)]).collect())
        })
    });
    let figures = cases.iter().map(|case| {
        let series = case.degrees.clone().filter_map(|degree| {
            let found = errors(runs, case, degree);
            let order = order(&found)?;
            Some(Series::new(format!("degree {degree}: order {order:.2}"), Style::Joined, found).color(degree - 1))
        });
        let name = format!("manufactured-{}d", case.dimension);
        let caption = format!("Manufactured solution in {}D: RMS error of the displacement", case.dimension);
        convergence(&name, &caption, "cells along an axis", case.grids, Axis::new("RMS error [m]", ""), series)
    });
    let finding = |case: &Case| {
        let (first, last) = (case.degrees.start(), case.degrees.end());
        let claim = format!("Observed order at least p + 0.8 for degrees p = {first} to {last} over {} grids.", case.grids.len());
        Finding::judge(format!("{}D", case.dimension), claim, true, || {
            let found: Vec<Vec<[f64; 2]>> = case.degrees.clone().map(|degree| errors(runs, case, degree)).collect();
            let whole = found.iter().all(|errors| errors.len() == case.grids.len());
            let orders = found.iter().map(|errors| order(errors)).collect::<Option<Vec<f64>>>()?;
            let list: Vec<String> = orders.iter().map(|order| format!("{order:.2}")).collect();
            let holds = case.degrees.clone().zip(&orders).all(|(degree, order)| *order >= degree as f64 + 0.8);
            whole.then(|| (format!("{}.", list.join(", ")), holds))
        })
    };
    Section {
        title: "Manufactured solutions".into(),
        text: format!(
            "On the unit interval, square and cube u_i = A sin(pi X_i) sin(pi c t + phase_i), A = {AMPLITUDE} m, phases 0, pi, pi, c = \
             sqrt(E / density), no displacement normal to the faces, and the body force that makes this the solution: 16 % strain in \
             neo-Hookean rubber, nu = 0.3 in 2D and 3D. Total Lagrangian, consistent mass, the symplectic scheme of fourth order with steps \
             so short that the errors are those in space; at an eighth of a period. Order: slope of log error over log cells, by least \
             squares over all grids."
        ),
        tables: tables.collect(),
        figures: figures.collect(),
        findings: cases.iter().map(finding).collect(),
        ..Section::default()
    }
}
