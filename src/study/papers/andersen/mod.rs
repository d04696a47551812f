//! S. M. Andersen and L. Andersen, Material-point method analysis of bending in elastic beams, DCE Technical Memorandum 7, Aalborg 2007.
//!
//! [`bar`] is A1 (section 4, figures 4 to 8), [`cantilever`] A2 (4.1, figures 9 to 12), [`impact`] A3 (4.2, figures 13 to 17) and
//! [`rigid`] the appendix. The paper updates the stress first (USF) and lumps the mass where it does not say otherwise.

mod bar;
mod cantilever;
mod impact;
mod impact_findings;
mod rigid;

use crate::study::runner::End;
use crate::study::tools::{chart, cloud, largest, percent, places, rms, small, stress_xx, table, view};
use crate::study::{Effort, Job, Problem, Run, Runs, Section, value};

/// An element of the paper, or a basis of ours beside them.
#[derive(PartialEq)]
struct Element {
    /// Part of the names of jobs.
    key: &'static str,
    /// Name in charts.
    name: &'static str,
    /// Basis in scenes.
    basis: &'static str,
    /// Colour in charts.
    color: usize,
}

const LINEAR: Element = Element { key: "4-node", name: "4-node", basis: "linear", color: 0 };
const SERENDIPITY: Element = Element { key: "8-node", name: "8-node", basis: "serendipity", color: 1 };
const LAGRANGE: Element = Element { key: "9-node", name: "9-node", basis: "lagrange", color: 2 };
const CUBIC: Element = Element { key: "cubic", name: "cubic splines", basis: "cubic", color: 3 };
const BSPLINE: Element = Element { key: "bspline", name: "quadratic B-splines", basis: "bspline", color: 4 };
const GIMP: Element = Element { key: "gimp", name: "GIMP", basis: "gimp", color: 5 };

/// The elements of the paper, in its order.
const PAPER: [&Element; 4] = [&LINEAR, &SERENDIPITY, &LAGRANGE, &CUBIC];
/// Those of the paper and ours beside them.
const ALL: [&Element; 6] = [&LINEAR, &SERENDIPITY, &LAGRANGE, &CUBIC, &BSPLINE, &GIMP];

/// Mass matrices in scenes.
const LUMPED: &str = "lumped";
const CONSISTENT: &str = "consistent";

/// A1, A2, A3 and the appendix.
pub(super) fn problems() -> [Problem; 4] {
    type Jobs = fn(Effort) -> Vec<Job>;
    let problem = |id, title, jobs: Jobs, section: fn(Effort, &Runs) -> Section| Problem { id, title, jobs, section };
    [
        problem("A1", "Andersen 2007, free vibration of a bar", bar::jobs, bar::section),
        problem("A2", "Andersen 2007, cantilever", cantilever::jobs, cantilever::section),
        problem("A3", "Andersen 2007, a box falls on a beam", impact::jobs, impact::section),
        problem("AX", "Andersen 2007, appendix: negative mass", rigid::jobs, rigid::section),
    ]
}

/// Watches the measures of energy: eqs 25 to 32 of the paper.
fn energies(job: Job) -> Job {
    ["kinetic", "strain", "total", "nodal_kinetic", "interpolation_error", "algorithmic_error"]
        .into_iter()
        .fold(job, |job, name| job.watch(name, value(format!("energy/{name}"), 0)))
}

/// Largest change of the total energy, over that at time 0.
fn drift(run: &Run) -> Option<f64> {
    let total = run.samples("total");
    let first = *total.first()?;
    Some(largest(total.iter().map(|e| e / first - 1.0)))
}

/// `4-node 1.6 %, cubic splines 4.28 %`: a number of each element that has one.
fn each(elements: &[&Element], of: impl Fn(&Element) -> Option<f64>, text: impl Fn(f64) -> String) -> String {
    let words: Vec<String> = elements.iter().filter_map(|e| Some(format!("{} {}", e.name, text(of(e)?)))).collect();
    words.join(", ")
}

/// When a run stopped \[s\] because a nodal mass had turned negative.
fn negative_mass(run: &Run) -> Option<f64> {
    let End::Failed(reason) = &run.end else { return None };
    let time = reason.strip_prefix("at t = ")?.split(' ').next()?;
    time.parse().ok().filter(|_| reason.contains("negative"))
}
