//! Section 5.2 of the thesis: the bar of T1 with quadratic Lagrange elements, which are negative in places.

use super::bar_small::{curve_step, scene};
use super::{LAGRANGE, LAGRANGE_LUMPED, LINEAR, Method, PROFILE, Profile};
use super::{chart, known, percent, rms};
use crate::step::Wrong;
use crate::study::Effort;
use crate::study::reference::small_bar;
use crate::study::report::number;
use crate::study::runner::End;
use crate::study::{Axis, Chart, Figure, Finding, Job, Runs, Series, Style, value};

fn coarse_job(method: &Method) -> String {
    format!("T1/{}/4 elements", method.key)
}

/// A bar with a free end that moves into an empty element: there the function of the last node is negative.
fn free_end(effort: Effort) -> String {
    let scene = scene(&LAGRANGE_LUMPED, 8, 16, FREE_END, curve_step(effort));
    scene.replace("max = [25]", "max = [18.75]").replace("velocity = [\"0.1*sin(PI*x/25)\"]", "velocity = [\"sin(PI*x/37.5)\"]")
}

/// End of those runs \[s\]: the bar is longest then.
const FREE_END: f64 = 2.0;

fn free_job(wrong: bool) -> String {
    format!("{}, free end{}", coarse_job(&LAGRANGE_LUMPED), if wrong { ", negative mass used" } else { "" })
}

/// As [`coarse_job`], 3.125 times as fast: as many particles leave their element as with the 100 of the thesis.
fn crossing_job(method: &Method) -> String {
    format!("{}, particles cross", coarse_job(method))
}

/// Share of 100 particles that an element of ours has.
const FASTER: f64 = 3.125;

pub(super) fn jobs(effort: Effort) -> Vec<Job> {
    let mut jobs = Vec::new();
    // an element of the quadratic family spans two cells of the grid; a cell holds at most 16 particles along an axis
    let step = curve_step(effort);
    for (method, cells) in [(&LINEAR, 4), (&LAGRANGE, 8), (&LAGRANGE_LUMPED, 8)] {
        let scene = scene(method, cells, 16, 0.5, step);
        if method.key != LINEAR.key {
            let faster = scene.replace("velocity = [\"0.1*", &format!("velocity = [\"{}*", 0.1 * FASTER));
            jobs.push(Job::new(crossing_job(method), faster).snapshot(0.5, PROFILE));
        }
        jobs.push(Job::new(coarse_job(method), scene).snapshot(0.5, PROFILE));
    }
    let free = |wrong| Job::new(free_job(wrong), free_end(effort)).every(0.01).watch("energy", value("energy/total", 0));
    jobs.extend([free(false), free(true).wrong(Wrong::NegativeMass)]);
    jobs
}

/// Figures 5.24 and 5.25.
pub(super) fn figure(runs: &Runs) -> Figure {
    let displacement = [&LINEAR, &LAGRANGE, &LAGRANGE_LUMPED].into_iter().filter_map(|m| {
        let profile = Profile::of(runs.get(&coarse_job(m))?, 0.5)?;
        Some(Series::new(m.name, Style::Line, profile.start.iter().zip(&profile.displacement).map(|(&x, &u)| [x, u])).color(m.color))
    });
    let shape = Series::new("equation (4.1)", Style::Reference, known(0.0, 25.0, 200, |x| small_bar(x, 0.5)[0]));
    chart(
        "t1-lagrange",
        "Figures 5.24, 5.25: displacement at 0.5 s with 4 elements (the text has 100 particles in each, the captions 4; ours have 16 with linear, 32 with quadratic functions)",
        Chart::new(
            "T1: displacement at t = 0.5 s, 4 elements",
            Axis::new("position at time 0", "m"),
            Axis::new("displacement", "m"),
            displacement.chain([shape]),
        ),
    )
}

/// RMS error of the displacement at 0.5 s with 4 elements \[m\], and the same of the bar that is faster, over how much faster it is.
fn coarse_error(runs: &Runs, method: &Method, faster: bool) -> Option<f64> {
    let (job, factor) = if faster { (crossing_job(method), FASTER) } else { (coarse_job(method), 1.0) };
    let profile = Profile::of(runs.done(&job)?, 0.5)?;
    Some(rms(profile.start.iter().zip(&profile.displacement).map(|(&x, &u)| u / factor - small_bar(x, 0.5)[0])))
}

/// Section 5.2 of the thesis.
pub(super) fn findings(runs: &Runs) -> Vec<Finding> {
    let further = |method: &Method| {
        let (linear, quadratic) = (coarse_error(runs, &LINEAR, false)?, coarse_error(runs, method, false)?);
        let seen = format!(
            "RMS error of the displacement at 0.5 s: quadratic {} m, linear {} m. Where particles leave their element, which 100 in each would do \
             and ours do at {FASTER} times the speed, it is {} m (over that factor).",
            number(quadratic),
            number(linear),
            number(coarse_error(runs, method, true)?)
        );
        Some((seen, quadratic > linear))
    };
    vec![
        Finding::judge(
            "5.24, 5.25",
            "Linear functions differ less from the solution than quadratic Lagrange functions (lumped mass).",
            false,
            || further(&LAGRANGE_LUMPED),
        ),
        Finding::judge("5.24, 5.25", "The same with the consistent mass.", false, || further(&LAGRANGE)),
        Finding::judge(
            "text of section 5.2",
            "Lagrange functions are negative in places, so lumped masses may be: then lumping cannot be applied.",
            true,
            || {
                let End::Failed(reason) = &runs.get(&free_job(false))?.end else { return Some(("It runs.".into(), false)) };
                let seen = format!("It can while all elements are full. A free end that moves into an empty one ends the run: {reason}.");
                Some((seen, reason.contains("negative")))
            },
        ),
        Finding::judge("text of section 5.2", "Negative entries of the mass might make the scheme unstable.", false, || {
            let run = runs.get(&free_job(true))?;
            let energy = run.samples("energy");
            let (first, last) = (energy.first()?, energy.last()?);
            let seen = match &run.end {
                End::Failed(reason) => format!("Used all the same, they end the run after {} s: {reason}.", number(*run.times.last()?)),
                _ => format!(
                    "Used all the same in that bar, the one negative mass does not: the energy changes by {} in {FREE_END} s.",
                    percent(last / first - 1.0)
                ),
            };
            Some((seen, !run.is_done() || last / first > 1.1))
        }),
    ]
}
