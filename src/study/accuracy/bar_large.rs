//! T2: the vibrating bar of Tielen (2016), chapter 6, with 7 % strain.

use super::{convergence, tabulate};
use crate::study::reference::Table;
use crate::study::tools::{rms, small, stress_xx};
use crate::study::{Axis, Effort, Finding, Job, Runs, Section, Series, Style};

const END: f64 = 0.5;
const STEP: f64 = 1e-4;

/// A method of solution.
struct Method {
    name: &'static str,
    toml: &'static str,
    particles: &'static str,
    color: usize,
    style: Style,
}

const THESIS: Method = Method {
    name: "thesis' method",
    toml: r#"basis = "bspline", mass = "consistent", quadrature = "splines", quadrature_of = "force_and_velocity""#,
    particles: ", particles_per_cell = 4",
    color: 0,
    style: Style::Reference,
};
const DEGREE_3: Method = total("degree 3", r#"formulation = "total", degree = 3"#, 2);
const DEGREE_5: Method = total("degree 5", r#"formulation = "total", degree = 5"#, 4);
const METHODS: [Method; 5] = [
    THESIS,
    total("degree 2", r#"formulation = "total", degree = 2"#, 1),
    DEGREE_3,
    DEGREE_5,
    total("degree 5, fourth order in time", r#"formulation = "total", degree = 5, integrator = "symplectic4""#, 0),
];

/// The particles of the total Lagrangian are Gauss points.
const fn total(name: &'static str, toml: &'static str, color: usize) -> Method {
    Method { name, toml, particles: "", color, style: Style::Joined }
}

fn grids(effort: Effort) -> Vec<usize> {
    effort.pick(vec![8, 16], vec![4, 8, 16, 32])
}

fn name(method: &Method, cells: usize) -> String {
    format!("T2/{}, {cells} cells", method.name)
}

pub(super) fn jobs(effort: Effort) -> Vec<Job> {
    let job = |method: &Method, cells: usize| {
        let scene = format!(
            r#"
            title = "Tielen 2016, vibrating bar, large deformations"
            dimension = 1
            grid = {{ origin = [0], size = [1], cell = {} }}
            material.elastic = {{ law = "hypo_elastic", young = 50.0, density = 25.0 }}
            body.bar = {{ material = "elastic", shape = {{ box = {{ min = [0], max = [1] }} }}, velocity = ["0.1*sin(PI*x)"]{} }}
            boundary.left = {{ face = "x-", fixed = ["x"] }}
            boundary.right = {{ face = "x+", fixed = ["x"] }}
            method = {{ {} }}
            time = {{ end = {END}, step = {STEP} }}
            "#,
            1.0 / cells as f64,
            method.particles,
            method.toml
        );
        Job::new(name(method, cells), scene).snapshot(END, ["particle/position", "particle/displacement", "particle/stress"])
    };
    let grids = grids(effort);
    METHODS.iter().flat_map(|m| grids.iter().map(move |&cells| job(m, cells))).collect()
}

/// RMS errors of displacement \[m\] and stress \[Pa\] at the particles.
fn errors(runs: &Runs, method: &Method, cells: usize) -> Option<[f64; 2]> {
    let run = runs.done(&name(method, cells))?;
    let (position, moved) = (run.at(END, "particle/position")?, run.at(END, "particle/displacement")?);
    let known = Table::bar();
    let exact: Vec<[f64; 3]> = position.iter().zip(moved).map(|(x, u)| known.over_place(END, x - u, 6)).collect();
    let stress = stress_xx(run.at(END, "particle/stress")?);
    Some([rms(moved.iter().zip(&exact).map(|(u, e)| u - e[0])), rms(stress.iter().zip(&exact).map(|(s, e)| s - e[2]))])
}

pub(super) fn section(effort: Effort, runs: &Runs) -> Section {
    let grids = grids(effort);
    let kinds = [("displacement", "m"), ("stress", "Pa")];
    let header: Vec<&str> = ["cells"].into_iter().chain(METHODS.iter().map(|m| m.name)).collect();
    let tables = (0..2).map(|kind| {
        let (what, unit) = kinds[kind];
        let row = |cells: usize| (cells.to_string(), METHODS.iter().map(|m| Some(errors(runs, m, cells)?[kind])).collect());
        tabulate(&format!("RMS error of the {what} at {END} s [{unit}]"), &header, grids.iter().copied(), row)
    });
    let figures = (0..2).map(|kind| {
        let (what, unit) = kinds[kind];
        let series = METHODS.iter().map(|m| {
            let points = grids.iter().filter_map(|&cells| Some([cells as f64, errors(runs, m, cells)?[kind]]));
            Series::new(m.name, m.style, points).color(m.color)
        });
        let axis = Axis::new(format!("RMS error [{unit}]"), "");
        convergence(&format!("t2-{what}"), &format!("T2: RMS error of the {what} at {END} s"), "cells", &grids, axis, series)
    });
    let finding = |method: &Method, [most_u, most_s]: [f64; 2]| {
        let claim = format!("RMS errors at most {most_u:e} m and {most_s:e} Pa.");
        Finding::judge(format!("16 cells, {}", method.name), claim, true, || {
            let [u, s] = errors(runs, method, 16)?;
            let [u_thesis, s_thesis] = errors(runs, &THESIS, 16)?;
            let seen =
                format!("{} m and {} Pa (the thesis' method, here: {} and {}).", small(u), small(s), small(u_thesis), small(s_thesis));
            Some((seen, u <= most_u && s <= most_s))
        })
    };
    Section {
        title: "T2 Vibrating bar, large deformations (Tielen 2016, chapter 6)".into(),
        text: format!(
            "1 m, E = 50 Pa, 25 kg/m3, fixed at both ends, v = 0.1 sin(pi x) m/s, 7 % strain, steps of {STEP} s. Beside the thesis' best \
             method (updated Lagrangian, quadratic B-splines, spline quadrature, consistent mass) the total Lagrangian with velocity Verlet, \
             and of degree 5 with the symplectic scheme of fourth order. The reference is a spectral solution of 13 digits, which between \
             its 65 points is good to about 1e-12 m."
        ),
        tables: tables.collect(),
        figures: figures.collect(),
        findings: vec![finding(&DEGREE_5, [2e-10, 3e-7]), finding(&DEGREE_3, [3e-8, 1e-4])],
        ..Section::default()
    }
}
