//! O. Buzzi, D. M. Pedroso, A. Giacomini, Caveats on the implementation of the generalized material point method, CMES 31 (2008).
//!
//! [`point`] is B1 (sections 5.1, 5.2, 5.4), [`bar`] B2 (5.1, 5.3, 5.5) and [`disks`] B3 (5.6).

mod bar;
mod disks;
mod point;

use crate::study::tools::{chart, energies, known, largest, percent, rms, times};
use crate::study::{Axis, Chart, Effort, Job, Panel, Problem, Run, Runs, Section, Series, Style};

/// When the stress is updated, in the two ways of the paper.
const INTEGRATORS: [(&str, &str); 2] = [("usf", "USF"), ("usl", "USL")];
/// Shape functions of the paper: its names for them, and ours in scenes.
const BASES: [(&str, &str); 2] = [("linear", "MPM"), ("gimp", "GIMP")];

/// B1 to B3.
pub(super) fn problems() -> [Problem; 3] {
    type Jobs = fn(Effort) -> Vec<Job>;
    let problem = |id, title, jobs: Jobs, section: fn(Effort, &Runs) -> Section| Problem { id, title, jobs, section };
    [
        problem("B1", "Buzzi et al. 2008, vibration of one material point", point::jobs, point::section),
        problem("B2", "Buzzi et al. 2008, vibration of a bar", bar::jobs, bar::section),
        problem("B3", "Buzzi et al. 2008, two bouncing disks", disks::jobs, disks::section),
    ]
}

/// Watches energies, and velocity and displacement of the centre of mass of particles that are all as heavy.
fn centre(job: Job) -> Job {
    let mean = |name: &'static str| {
        move |sim: &mut crate::Simulation| {
            let values = sim.get(name)?;
            Ok(values.iter().sum::<f64>() / values.len() as f64)
        }
    };
    energies(job).watch("velocity", mean("particle/velocity")).watch("displacement", mean("particle/displacement"))
}

/// What is known of the centre of mass at a time: velocity \[m/s\] and displacement \[m\].
type Known = fn(f64) -> [f64; 2];

/// Largest errors of velocity and displacement of the centre of mass, over their largest exact values, up to a time.
fn errors(run: &Run, exact: impl Fn(f64) -> [f64; 2], end: f64) -> [f64; 2] {
    [("velocity", 0), ("displacement", 1)].map(|(name, column)| {
        let points: Vec<[f64; 2]> = run.curve(name).into_iter().filter(|p| p[0] <= end * (1.0 + 1e-9)).collect();
        let top = largest(points.iter().map(|p| exact(p[0])[column]));
        largest(points.iter().map(|p| p[1] - exact(p[0])[column])) / top
    })
}

/// Energy at the end over that at the start, less 1.
fn drift(run: &Run) -> Option<f64> {
    let energy = run.samples("energy");
    Some(energy.last()? / energy.first()? - 1.0)
}

/// How much the total energy swings about the straight line through it, over its first value (RMS).
fn swing(run: &Run) -> Option<f64> {
    let points = run.curve("energy");
    let n = points.len() as f64;
    let mean = |column: usize| points.iter().map(|p| p[column]).sum::<f64>() / n;
    let (time, energy) = (mean(0), mean(1));
    let slope =
        points.iter().map(|p| (p[0] - time) * (p[1] - energy)).sum::<f64>() / points.iter().map(|p| (p[0] - time).powi(2)).sum::<f64>();
    let first = points.first()?[1];
    Some(rms(points.iter().map(|p| p[1] - energy - slope * (p[0] - time))) / first)
}

/// Velocity and displacement of the centre of mass by several runs, with what is known.
fn motion(title: &str, runs: &Runs, cases: &[(String, String)], exact: Known, end: f64) -> Chart {
    let panel = |name: &'static str, unit, column: usize| {
        let curves = cases.iter().filter_map(|(job, label)| {
            let points = runs.get(job)?.curve(name).into_iter().filter(|p| p[0] <= end * (1.0 + 1e-9));
            Some(Series::new(label, Style::Line, points))
        });
        let exact = Series::new("exact", Style::Reference, known(0.0, end, 1000, |t| exact(t)[column]));
        Panel { y: Axis::new(name, unit), series: curves.chain([exact]).collect() }
    };
    Chart::stacked(title, Axis::new("time", "s"), [panel("velocity", "m/s", 0), panel("displacement", "m", 1)])
}

/// Kinetic, stored and total energy, a panel a run.
fn energy(title: &str, runs: &Runs, cases: &[(String, String)]) -> Chart {
    let panel = |(job, label): &(String, String)| {
        let run = runs.get(job)?;
        let curves = [("kinetic", "kinetic"), ("strain", "stored"), ("energy", "total")];
        let series = curves.map(|(name, shown)| Series::new(shown, Style::Line, run.curve(name))).into();
        Some(Panel { y: Axis::new(label, "J"), series })
    };
    Chart::stacked(title, Axis::new("time", "s"), cases.iter().filter_map(panel))
}
