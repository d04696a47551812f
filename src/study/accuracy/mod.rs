//! Problems with known answers: how close the simulator comes to them, above all by the total-Lagrangian formulation.
//!
//! `bar_small` and `bar_large` are bars of Tielen (2016), `manufactured` has a solution in closed form, `cantilever` and `column`
//! are statics, `swing` and `ramped` motions of beams, `conservation` is a body that swings a thousand times, `cook` a membrane,
//! `newton` and `saved` are about implicit steps: how they converge, and what they save. `cost` holds what methods of high order and the
//! classical ones take for an error.

mod bar_large;
mod bar_small;
mod cantilever;
mod column;
mod conservation;
mod cook;
mod cost;
mod manufactured;
mod newton;
mod ramped;
mod saved;
mod swing;

use super::problem::{Effort, Problem, Study};
use super::tools::{chart, tabulate};
use super::{Axis, Chart, Figure, Job, Run, Runs, Section, Series};

/// The study of accuracy.
pub const STUDY: Study = Study {
    name: "accuracy",
    title: "Accuracy, against known answers",
    text: "Every number here was computed by that command, unless it is said whose it is. Wall times are those of that run, on the machine \
           that it ran on, and differ from run to run; those that a finding is about were taken with no other run beside.",
    heads: ["what", "required", "measured"],
    problems,
};

fn problems() -> Vec<Problem> {
    type Jobs = fn(Effort) -> Vec<Job>;
    let problem = |id, title, jobs: Jobs, section: fn(Effort, &Runs) -> Section| Problem { id, title, jobs, section };
    macro_rules! race {
        ($module:ident::$race:ident) => {
            problem(
                cost::$module::$race.id,
                cost::$module::$race.title,
                |effort| cost::$module::$race.jobs(effort),
                |effort, runs| cost::$module::$race.section(effort, runs),
            )
        };
    }
    vec![
        problem("T1", "vibrating bar, small deformations", bar_small::jobs, bar_small::section),
        problem("T2", "vibrating bar, large deformations", bar_large::jobs, bar_large::section),
        race!(bar::T2),
        problem("manufactured", "manufactured solutions in 1D, 2D and 3D", manufactured::jobs, manufactured::section),
        race!(manufactured::B4),
        race!(manufactured::B5),
        race!(rings::B6),
        race!(rings::B7),
        race!(cube::CUBE),
        problem("cantilever", "cantilever under a dead tip load", cantilever::jobs, cantilever::section),
        problem("column", "column under self-weight", column::jobs, column::section),
        problem("swing", "compliant cantilever under sudden self-weight", swing::jobs, swing::section),
        problem("A2", "cantilever with a growing tip force", ramped::jobs, ramped::section),
        problem("conservation", "energy and momenta over a thousand periods", conservation::jobs, conservation::section),
        problem("cook", "Cook's membrane", cook::jobs, cook::section),
        problem("newton", "Newton's method", newton::jobs, newton::section),
        problem("saved", "a static answer, implicit and explicit", saved::jobs, saved::section),
    ]
}

/// The first number kept under a name at a time \[s\].
fn kept(run: Option<&Run>, time: f64, name: &str) -> Option<f64> {
    run?.at(time, name)?.first().copied()
}

/// The observed order: slope of the logarithm of the error over that of the number of cells, by least squares.
fn order(errors: &[[f64; 2]]) -> Option<f64> {
    let logs: Vec<[f64; 2]> = errors.iter().map(|e| e.map(f64::ln)).collect();
    let mean = |axis: usize| logs.iter().map(|p| p[axis]).sum::<f64>() / logs.len() as f64;
    let (x, y) = (mean(0), mean(1));
    let (above, below) = logs.iter().fold((0.0, 0.0), |(a, b), p| (a + (p[0] - x) * (p[1] - y), b + (p[0] - x).powi(2)));
    (logs.len() > 1).then_some(-above / below)
}

/// A chart of errors over numbers of cells, on logarithmic axes.
fn convergence(
    name: &str,
    caption: &str,
    cells: &'static str,
    grids: &[usize],
    error: Axis,
    series: impl IntoIterator<Item = Series>,
) -> Figure {
    let axis = Axis::new(cells, "").log().marks(grids.iter().map(|&n| n as f64));
    chart(name, caption, Chart::new(caption, axis, error.log(), series))
}

#[cfg(test)]
mod tests {
    #[test]
    fn order_of_a_power_is_its_exponent() {
        let errors: Vec<[f64; 2]> = [4.0f64, 6.0, 8.0, 12.0].map(|n| [n, 3.0 * n.powf(-2.5)]).to_vec();
        assert!((super::order(&errors).unwrap() - 2.5).abs() < 1e-12 && super::order(&errors[..1]).is_none());
    }
}
