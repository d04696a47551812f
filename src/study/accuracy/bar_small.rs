//! T1: the vibrating bar of Tielen (2016), chapter 5. The thesis' errors fall to 1e-9 m; round-off is at 1e-16 m.

use super::{convergence, kept, tabulate};
use crate::study::tools::small;
use crate::study::{Axis, Effort, Finding, Job, Runs, Section, Series, Style};

const END: f64 = 0.02;
const STEP: f64 = 1e-3;
/// Cells, and the RMS error of the thesis' best method: table 7.1, 4 particles a cell \[m\].
const THESIS: [(usize, f64); 5] = [(4, 4.9665e-6), (8, 5.4447e-7), (16, 6.4964e-8), (32, 7.9865e-9), (64, 1.0137e-9)];

fn degrees(effort: Effort) -> Vec<usize> {
    effort.pick(vec![3, 5], vec![1, 2, 3, 4, 5])
}

fn name(cells: usize, degree: usize) -> String {
    format!("T1/{cells} cells, degree {degree}")
}

pub(super) fn jobs(effort: Effort) -> Vec<Job> {
    let job = |cells: usize, degree: usize| {
        let scene = format!(
            r#"
            title = "Tielen 2016, vibrating bar, small deformations"
            dimension = 1
            grid = {{ origin = [0], size = [25], cell = {} }}
            material.elastic = {{ law = "linear_elastic", young = 100.0, density = 1.0 }}
            body.bar = {{ material = "elastic", shape = {{ box = {{ min = [0], max = [25] }} }}, velocity = ["0.1*sin(PI*x/25)"] }}
            boundary.left = {{ face = "x-", fixed = ["x"] }}
            boundary.right = {{ face = "x+", fixed = ["x"] }}
            method = {{ formulation = "total", degree = {degree}, integrator = "symplectic4" }}
            time = {{ end = {END}, step = {STEP} }}
            exact = {{ displacement = ["0.1/(10*PI/25)*sin(10*PI/25*t)*sin(PI*x/25)"] }}
            "#,
            25.0 / cells as f64
        );
        Job::new(name(cells, degree), scene).snapshot(END, ["error/displacement"])
    };
    let degrees = degrees(effort);
    THESIS.iter().flat_map(|&(cells, _)| degrees.iter().map(move |&degree| (cells, degree))).map(|(c, d)| job(c, d)).collect()
}

fn error(runs: &Runs, cells: usize, degree: usize) -> Option<f64> {
    kept(runs.done(&name(cells, degree)), END, "error/displacement")
}

pub(super) fn section(effort: Effort, runs: &Runs) -> Section {
    let degrees = degrees(effort);
    let header: Vec<String> =
        ["cells".to_owned(), "thesis' best".to_owned()].into_iter().chain(degrees.iter().map(|d| format!("degree {d}"))).collect();
    let header: Vec<&str> = header.iter().map(String::as_str).collect();
    let table = tabulate("RMS error of the displacement at 0.02 s [m]", &header, THESIS, |(cells, thesis)| {
        (cells.to_string(), [Some(thesis)].into_iter().chain(degrees.iter().map(|&d| error(runs, cells, d))).collect())
    });
    let series = degrees.iter().map(|&d| {
        let points = THESIS.iter().filter_map(|&(cells, _)| Some([cells as f64, error(runs, cells, d)?]));
        Series::new(format!("degree {d}"), Style::Joined, points).color(d - 1)
    });
    let thesis = Series::new("thesis' best (table 7.1)", Style::Reference, THESIS.map(|(cells, e)| [cells as f64, e]));
    let figure = convergence(
        "t1",
        "T1: RMS error of the displacement at 0.02 s",
        "cells",
        &THESIS.map(|(cells, _)| cells),
        Axis::new("RMS error [m]", ""),
        series.chain([thesis]),
    );
    let finding = Finding::judge("64 cells, degree 5", "RMS error at most 1e-12 m (the thesis' best: 1.01e-9 m).", true, || {
        let error = error(runs, 64, 5)?;
        Some((format!("{} m.", small(error)), error <= 1e-12))
    });
    Section {
        title: "T1 Vibrating bar, small deformations (Tielen 2016, chapter 5)".into(),
        text: format!(
            "25 m, E = 100 Pa, 1 kg/m3, fixed at both ends, v = 0.1 sin(pi x / L) m/s. Total Lagrangian, B-splines, consistent mass, steps \
             of {STEP} s of the symplectic scheme of fourth order. The bar moves by 2 mm in {END} s: errors end at round-off."
        ),
        tables: vec![table],
        figures: vec![figure],
        findings: vec![finding],
        ..Section::default()
    }
}
