//! B1: one material point in one cell, an oscillator with an exact solution.

use super::{BASES, INTEGRATORS, centre, chart, drift, energy, errors, largest, motion, percent, swing, times};
use crate::step::Wrong;
use crate::study::Effort;
use crate::study::report::number;
use crate::study::{Axis, Cell, Chart, Figure, Finding, Job, Run, Runs, Section, Series, Style, Table};
use std::f64::consts::PI;

/// Angular frequency \[1/s\]: root of E over density and the square of the length; the period is 1 s.
const OMEGA: f64 = 2.0 * PI;
/// First velocity \[m/s\]; the paper does not give it.
const SPEED: f64 = 0.1;
/// End of all runs \[s\].
const END: f64 = 10.0;
/// The step of figures 9 to 12 \[s\].
const STEP: f64 = 1e-3;

/// Steps, the longest first \[s\].
fn steps(effort: Effort) -> &'static [f64] {
    effort.pick(&[0.1, 1e-2, STEP], &[0.1, 1e-2, STEP, 1e-4])
}

fn name(basis: &str, integrator: &str, step: f64) -> String {
    format!("B1/{basis}/{integrator}/{step:e} s")
}

fn wrong_name() -> String {
    "B1/linear/usf/product of mass and velocity".into()
}

/// Velocity and displacement: equations (32) and (33).
fn exact(t: f64) -> [f64; 2] {
    let phase = OMEGA * t;
    [SPEED * phase.cos(), 0.5 * (SPEED / OMEGA * phase.sin()).exp() - 0.5]
}

fn scene(basis: &str, integrator: &str, step: f64) -> String {
    format!(
        r#"
        title = "Buzzi et al. 2008, one material point"
        dimension = 1
        grid = {{ origin = [0], size = [1], cell = 1 }}
        material.bar = {{ law = "linear_elastic", young = {young}, density = 1 }}
        boundary.wall = {{ face = "x-", fixed = ["x"] }}
        method = {{ basis = "{basis}", integrator = "{integrator}" }}
        time = {{ end = {END}, step = {step} }}
        [body.point]
        material = "bar"
        shape = {{ box = {{ min = [0], max = [1] }} }}
        particles_per_cell = 1
        velocity = [{SPEED}]
        "#,
        young = OMEGA * OMEGA,
    )
}

pub(super) fn jobs(effort: Effort) -> Vec<Job> {
    let mut jobs = Vec::new();
    for (basis, _) in BASES {
        for (integrator, _) in INTEGRATORS {
            for &step in steps(effort) {
                jobs.push(centre(Job::new(name(basis, integrator, step), scene(basis, integrator, step)).every(step.max(0.02))));
            }
        }
    }
    let wrong = Job::new(wrong_name(), scene("linear", "usf", STEP)).every(0.02).wrong(Wrong::ProductMomentum);
    jobs.push(centre(wrong));
    jobs
}

/// The error measure (38) over time.
fn measure(run: &Run) -> Vec<[f64; 2]> {
    run.curve("velocity").into_iter().map(|[t, v]| [t, (exact(t)[0] - v).abs() / (1.0 + exact(t)[0].abs())]).collect()
}

fn top(run: &Run) -> f64 {
    largest(measure(run).iter().map(|p| p[1]))
}

pub(super) fn section(effort: Effort, runs: &Runs) -> Section {
    Section {
        title: "B1 One material point (Buzzi et al. 2008, sections 5.1, 5.2, 5.4)".into(),
        text: format!(
            "A cell of 1 m with a material point in its middle, its left node held; E = 4 pi^2 Pa, density 1 kg/m3, v0 = {SPEED} m/s (the paper \
             does not give it), linear elastic. The exact solution is (32) and (33), with a period of 1 s. With GIMP the domain of the \
             particle is the whole cell."
        ),
        tables: tables(effort, runs),
        figures: figures(effort, runs),
        findings: findings(effort, runs),
        ..Section::default()
    }
}

fn tables(effort: Effort, runs: &Runs) -> Vec<Table> {
    let row = |&step: &f64| {
        let cell = |basis: &str, integrator: &str| {
            let run = runs.done(&name(basis, integrator, step));
            let [velocity, displacement] = run.map_or([None; 2], |run| errors(run, exact, END).map(Some));
            [velocity, displacement, run.and_then(drift)].map(|ours| Cell { paper: None, ours })
        };
        let cells = BASES.iter().flat_map(|(basis, _)| INTEGRATORS.iter().flat_map(move |(integrator, _)| cell(basis, integrator)));
        (format!("{step:e}"), cells.collect())
    };
    let columns = BASES.iter().flat_map(|(_, basis)| {
        INTEGRATORS.iter().flat_map(move |(_, integrator)| ["v", "u", "energy"].map(|what| format!("{basis} {integrator}: {what}")))
    });
    vec![Table {
        title:
            "Largest errors of velocity and displacement over the run, over their amplitudes, and change of the total energy, by step [s]"
                .into(),
        header: ["step".to_owned()].into_iter().chain(columns).collect(),
        rows: steps(effort).iter().map(row).collect(),
        beside: "paper",
        band: None,
    }]
}

fn figures(effort: Effort, runs: &Runs) -> Vec<Figure> {
    let four: Vec<(String, String)> = BASES
        .iter()
        .flat_map(|(basis, b)| INTEGRATORS.map(|(integrator, i)| (name(basis, integrator, STEP), format!("{b}, {i}"))))
        .collect();
    let two = [(name("linear", "usf", STEP), "correct (26)".to_owned()), (wrong_name(), "wrong (39)".to_owned())];
    let error = |(basis, label): (&'static str, &'static str)| {
        let ends = [steps(effort).first(), steps(effort).last()].into_iter().flatten();
        ends.filter_map(move |&step| {
            Some(Series::new(format!("{label}, {step:e} s"), Style::Line, measure(runs.get(&name(basis, "usf", step))?)))
        })
    };
    // a step of 0.1 s is a tenth of a period: USL has lost all by then, and would hide the others
    let by_step = steps(effort)[1..]
        .iter()
        .map(|&step| (name("linear", "usl", step), format!("USL, {step:e} s")))
        .chain([(name("linear", "usf", STEP), format!("USF, {STEP:e} s"))])
        .filter_map(|(job, label)| Some(Series::new(label, Style::Line, runs.get(&job)?.curve("energy"))));
    let time = || Axis::new("time", "s");
    vec![
        chart(
            "b1-motion",
            "Figures 9a, 10a (MPM, USF and USL), 11a, 12a (GIMP): velocity and displacement, step 0.001 s",
            motion("B1: one material point, step 1e-3 s", runs, &four, exact, END),
        ),
        chart(
            "b1-energy",
            "Figures 9b, 10b (MPM, USF and USL), 11b, 12b (GIMP): energies, step 0.001 s",
            energy("B1: energies, step 1e-3 s", runs, &four),
        ),
        chart(
            "b1-error",
            "Figure 15: error of the velocity (38) with the longest and the shortest step, USF",
            Chart::new(
                "B1: error of the velocity, USF",
                time(),
                Axis::new("error measure (38)", "").log().within(1e-9, 1.0),
                error(BASES[0]).chain(error(BASES[1])),
            ),
        ),
        chart(
            "b1-step",
            "Figure 16: total energy with USL at several steps, MPM, and with USF",
            Chart::new("B1: total energy, MPM", time(), Axis::new("total energy", "J"), by_step),
        ),
        chart(
            "b1-projection",
            "Figures 19a, 20a: velocity and displacement, momentum of the nodes taken correctly and as the product (39), USF, step 0.001 s",
            motion("B1: momentum of the nodes, correct and wrong", runs, &two, exact, END),
        ),
        chart(
            "b1-projection-energy",
            "Figures 19b, 20b: energies, momentum of the nodes taken correctly and as the product (39), USF, step 0.001 s",
            energy("B1: energies, correct and wrong momentum of the nodes", runs, &two),
        ),
    ]
}

fn findings(effort: Effort, runs: &Runs) -> Vec<Finding> {
    let done = |basis: &str, integrator: &str, step: f64| runs.done(&name(basis, integrator, step));
    let look = |basis, integrator| {
        let run = done(basis, integrator, STEP)?;
        let [velocity, displacement] = errors(run, exact, END);
        let drift = drift(run)?;
        let seen = format!(
            "Largest errors over {END} s: velocity {}, displacement {} of the amplitude; the energy changes by {}.",
            percent(velocity),
            percent(displacement),
            percent(drift)
        );
        Some((seen, velocity, displacement, drift))
    };
    let pair = |effort: Effort| Some((*steps(effort).first()?, *steps(effort).last()?));
    vec![
        Finding::judge("9", "MPM with USF is reasonably accurate.", true, || {
            let (seen, velocity, displacement, drift) = look("linear", "usf")?;
            Some((seen, velocity < 0.02 && displacement < 0.02 && drift.abs() < 0.01))
        }),
        Finding::judge("10", "MPM with USL dissipates, and so is less accurate in velocity and displacement.", true, || {
            let (seen, velocity, displacement, drift) = look("linear", "usl")?;
            let (_, v, u, _) = look("linear", "usf")?;
            Some((seen, drift < -0.05 && velocity > v && displacement > u))
        }),
        Finding::judge("11, 12", "GIMP dissipates as MPM does: not with USF, but with USL.", true, || {
            let ((_, _, _, first), (_, _, _, last), (_, _, _, mpm)) = (look("gimp", "usf")?, look("gimp", "usl")?, look("linear", "usl")?);
            let seen = format!("The energy changes by {} with USF and {} with USL (MPM {}).", percent(first), percent(last), percent(mpm));
            Some((seen, first.abs() < 0.01 && last < -0.05))
        }),
        Finding::judge("11, 12", "The displacement is less accurate with GIMP than with MPM for this single point.", true, || {
            let ((_, v, mpm, _), (_, w, gimp, _)) = (look("linear", "usf")?, look("gimp", "usf")?);
            let seen = format!(
                "With USF the largest error is {} of the amplitude, with MPM {}; that of the velocity {} and {}.",
                percent(gimp),
                percent(mpm),
                percent(w),
                percent(v)
            );
            Some((seen, gimp > mpm))
        }),
        Finding::judge("15", "A smaller step makes the error considerably smaller.", true, || {
            let (long, short) = pair(effort)?;
            let [coarse, fine] = [done("linear", "usf", long)?, done("linear", "usf", short)?].map(top);
            let order = (coarse / fine).log10() / (long / short).log10();
            let seen = format!(
                "MPM with USF: the largest value of (38) is {} at {long:e} s and {} at {short:e} s: order {order:.2} in the step.",
                number(coarse),
                number(fine)
            );
            Some((seen, fine < 1e-2 * coarse))
        }),
        Finding::judge("16", "The total energy swings less with a smaller step.", true, || {
            let [coarse, fine] = [done("linear", "usf", 1e-2)?, done("linear", "usf", STEP)?].map(swing);
            let seen =
                format!("MPM with USF: it swings by {} (RMS) at a step of 0.01 s and by {} at {STEP} s.", percent(coarse?), percent(fine?));
            Some((seen, fine? < 0.2 * coarse?))
        }),
        Finding::judge("16", "The dissipation of USL gets less with a smaller step.", true, || {
            // by how much it falls each second, as a share
            let rate = |run| Some(-(1.0 + drift(run)?).ln() / END);
            let list: Vec<(f64, f64)> =
                steps(effort)[1..].iter().map(|&step| Some((step, rate(done("linear", "usl", step)?)?))).collect::<Option<_>>()?;
            let text: Vec<String> = list.iter().map(|(step, rate)| format!("{} at {step:e} s", number(*rate))).collect();
            let seen = format!("MPM with USL: the rate at which the energy decays is, in 1/s, {}.", text.join(", "));
            Some((seen, list.windows(2).all(|w| w[1].1 < 0.2 * w[0].1)))
        }),
        Finding::judge(
            "19, 20",
            "Projecting mass and velocity apart, and taking their product for the momentum (39), loses much accuracy.",
            true,
            || {
                let (_, velocity, displacement, _) = look("linear", "usf")?;
                let wrong = runs.get(&wrong_name())?;
                let [v, u] = errors(wrong, exact, END);
                let seen = format!(
                    "Largest error of the velocity {} of its amplitude instead of {} ({}), of the displacement {} instead of {}; the energy changes by {}.",
                    percent(v),
                    percent(velocity),
                    times(v / velocity),
                    percent(u),
                    percent(displacement),
                    percent(drift(wrong)?)
                );
                Some((seen, v > 10.0 * velocity && u > 10.0 * displacement))
            },
        ),
    ]
}
