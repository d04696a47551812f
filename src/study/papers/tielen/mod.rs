//! R. Tielen, High order material point method, master thesis, TU Delft 2016: a bar and a column in one dimension.
//!
//! [`bar_small`] and [`quadratic`] are T1 (sections 5.1.1, 5.2, 6.2.1, 7.2.1), [`bar_large`] T2 (5.1.2, 6.2.2, 7.2.2), [`column_small`] T3 (5.1.3, 6.2.3,
//! 7.2.3), [`column_large`] T4 (5.1.4, 6.2.4, 7.2.4) and [`shock`] T5 (chapter 8).

mod bar_large;
mod bar_small;
mod column_large;
mod column_small;
mod quadratic;
mod shock;

use crate::study::tools::{chart, curve_error, energies, known, largest, lost, percent, rms, times};
use crate::study::{Effort, Job, Problem, Run, Runs, Section, Series, Style, value};

/// A method of the thesis.
struct Method {
    /// Part of the names of jobs.
    key: &'static str,
    /// Name in charts.
    name: &'static str,
    /// The lines of `[method]`.
    toml: &'static str,
    /// Colour in charts.
    color: usize,
}

/// Chapter 5.1: classical MPM.
const LINEAR: Method = Method { key: "linear", name: "linear", toml: r#"basis = "linear""#, color: 0 };
/// Chapter 6.
const BSPLINE: Method = Method { key: "bspline", name: "quadratic B-splines", toml: r#"basis = "bspline""#, color: 1 };
/// Chapter 7 for the bar: force and velocity integrated over splines, consistent mass. The thesis names it for the projection of
/// velocities and does not say which mass the balance of momentum has; its errors say consistent (see T1).
const SPLINE_BAR: Method = Method {
    key: "spline",
    name: "spline-based",
    toml: r#"
        basis = "bspline"
        mass = "consistent"
        quadrature = "splines"
        quadrature_of = "force_and_velocity""#,
    color: 2,
};
/// Chapter 7 for the column: only the force is integrated over splines, the mass is lumped.
const SPLINE_COLUMN: Method =
    Method { key: "spline", name: "spline-based", toml: "basis = \"bspline\"\nquadrature = \"splines\"", color: 2 };
/// Chapter 5.2: quadratic Lagrange elements; negative functions leave only the consistent mass.
const LAGRANGE: Method =
    Method { key: "lagrange", name: "quadratic Lagrange, consistent mass", toml: "basis = \"lagrange\"\nmass = \"consistent\"", color: 3 };
/// The same with the mass that all other methods of the thesis have.
const LAGRANGE_LUMPED: Method =
    Method { key: "lagrange lumped", name: "quadratic Lagrange, lumped mass", toml: "basis = \"lagrange\"", color: 4 };

/// The methods that the bar (T1, T2) is solved with, in the order of the chapters.
const BAR: [&Method; 3] = [&LINEAR, &BSPLINE, &SPLINE_BAR];
/// The methods that the column (T3, T4, T5) is solved with.
const COLUMN: [&Method; 3] = [&LINEAR, &BSPLINE, &SPLINE_COLUMN];

/// T1 to T5.
pub(super) fn problems() -> [Problem; 5] {
    type Jobs = fn(Effort) -> Vec<Job>;
    let problem = |id, title, jobs: Jobs, section: fn(Effort, &Runs) -> Section| Problem { id, title, jobs, section };
    [
        problem("T1", "Tielen 2016, vibrating bar, small deformations", bar_small::jobs, bar_small::section),
        problem("T2", "Tielen 2016, vibrating bar, large deformations", bar_large::jobs, bar_large::section),
        problem("T3", "Tielen 2016, column under self-weight, small deformations", column_small::jobs, column_small::section),
        problem("T4", "Tielen 2016, column under self-weight, large deformations", column_large::jobs, column_large::section),
        problem("T5", "Tielen 2016, column under a top load", shock::jobs, shock::section),
    ]
}

/// The last state of a bar or column: position at time 0, displacement and stress of each particle.
struct Profile {
    start: Vec<f64>,
    displacement: Vec<f64>,
    stress: Vec<f64>,
}

/// What a snapshot holds for a [`Profile`].
const PROFILE: [&str; 3] = ["particle/position", "particle/displacement", "particle/stress"];

impl Profile {
    fn of(run: &Run, time: f64) -> Option<Self> {
        let [position, displacement, stress] = PROFILE.map(|name| run.at(time, name));
        let displacement = displacement?.to_vec();
        let start = position?.iter().zip(&displacement).map(|(x, u)| x - u).collect();
        // xx of the 3 x 3 stress
        Some(Self { start, displacement, stress: stress?.iter().step_by(9).copied().collect() })
    }

    /// Stress over the position at time 0, in the order of the particles.
    fn stress_points(&self) -> impl Iterator<Item = [f64; 2]> {
        self.start.iter().zip(&self.stress).map(|(&x, &s)| [x, s])
    }

    /// Error of the stress at each particle, beside the position at time 0.
    fn stress_errors(&self, exact: impl Fn(f64) -> f64) -> Vec<[f64; 2]> {
        self.stress_points().map(|[x, s]| [x, s - exact(x)]).collect()
    }
}

/// Watches the probe `middle`.
fn middle(job: Job) -> Job {
    job.watch("position", value("probe/middle/position", 0)).watch("velocity", value("probe/middle/velocity", 0))
}

/// The sampled curve of each method.
fn curves<'a>(
    runs: &'a Runs,
    methods: &'a [&Method],
    job: impl Fn(&Method) -> String + 'a,
    name: &'a str,
) -> impl Iterator<Item = Series> + 'a {
    methods.iter().filter_map(move |m| Some(Series::new(m.name, Style::Line, runs.get(&job(m))?.curve(name)).color(m.color)))
}

/// The stress at a time \[s\] over the position at time 0, of each method.
fn stresses<'a>(
    runs: &'a Runs,
    methods: &'a [&Method],
    job: impl Fn(&Method) -> String + 'a,
    time: f64,
) -> impl Iterator<Item = Series> + 'a {
    methods.iter().filter_map(move |m| {
        let profile = Profile::of(runs.get(&job(m))?, time)?;
        Some(Series::new(m.name, Style::Joined, profile.stress_points()).color(m.color))
    })
}
