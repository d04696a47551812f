//! B2: a bar held at one end, in its first mode.

use super::{INTEGRATORS, centre, chart, drift, energy, errors, known, largest, motion, percent, times};
use crate::step::Wrong;
use crate::study::{Axis, Cell, Effort, Figure, Finding, Job, Panel, Run, Runs, Section, Series, Style, Table, value};
use std::f64::consts::PI;

/// Amplitude of the velocity \[m/s\]; the paper does not give it.
const SPEED: f64 = 0.1;
/// Wave number and speed of waves: E = 10 Pa, density 1 kg/m3, length 1 m.
const BETA: f64 = 0.5 * PI;
const WAVE: f64 = 3.162_277_660_168_379_5;
/// End of all runs \[s\]; a period takes 1.26 s.
const END: f64 = 10.0;
/// Particles and nodes of figures 13 to 18.
const SIZES: [(usize, usize); 5] = [(3, 2), (7, 2), (3, 4), (7, 8), (13, 14)];

fn name(basis: &str, integrator: &str, size: (usize, usize)) -> String {
    format!("B2/{basis}/{integrator}/{} particles, {} nodes", size.0, size.1)
}

fn wrong_name() -> String {
    "B2/linear/usf/improper boundary".into()
}

/// Velocity and displacement of the centre of mass: the means of (34) and (35).
fn exact(t: f64) -> [f64; 2] {
    let (omega, mean) = (BETA * WAVE, 2.0 / PI);
    [SPEED * mean * (omega * t).cos(), SPEED * mean / omega * (omega * t).sin()]
}

/// A period \[s\].
const PERIOD: f64 = 4.0 / WAVE;

fn scene(basis: &str, integrator: &str, (particles, nodes): (usize, usize)) -> String {
    format!(
        r#"
        title = "Buzzi et al. 2008, vibration of a bar"
        dimension = 1
        grid = {{ origin = [0], size = [1], cell = {cell} }}
        material.bar = {{ law = "linear_elastic", young = 10, density = 1 }}
        boundary.wall = {{ face = "x-", fixed = ["x"] }}
        method = {{ basis = "{basis}", integrator = "{integrator}" }}
        time = {{ end = {END}, step = 1e-3 }}
        [body.bar]
        material = "bar"
        shape = {{ box = {{ min = [0], max = [1] }} }}
        particles_per_cell = {per_cell}
        velocity = ["{SPEED}*sin(PI/2*x)"]
        "#,
        cell = 1.0 / (nodes - 1) as f64,
        per_cell = particles / (nodes - 1),
    )
}

pub(super) fn jobs(_: Effort) -> Vec<Job> {
    let cases = INTEGRATORS.iter().flat_map(|(integrator, _)| {
        let linear = SIZES.map(|size| ("linear", *integrator, size));
        linear.into_iter().chain([("gimp", *integrator, SIZES[3]), ("gimp", *integrator, SIZES[4])])
    });
    let job = |(basis, integrator, size)| watched(Job::new(name(basis, integrator, size), scene(basis, integrator, size)));
    let wrong = Job::new(wrong_name(), scene("linear", "usf", SIZES[3])).wrong(Wrong::ImproperBoundary);
    cases.map(job).chain([watched(wrong)]).collect()
}

/// Watches the centre of mass, and the particle next to the wall.
fn watched(job: Job) -> Job {
    centre(job.every(0.02)).watch("wall", value("particle/displacement", 0))
}

/// Exact displacement of the particle next to the wall, of 7 \[m\].
fn beside_wall(t: f64) -> f64 {
    let omega = BETA * WAVE;
    SPEED / omega * (omega * t).sin() * (BETA / 14.0).sin()
}

pub(super) fn section(_: Effort, runs: &Runs) -> Section {
    Section {
        title: "B2 Vibration of a bar (Buzzi et al. 2008, sections 5.1, 5.3, 5.5)".into(),
        text: format!(
            "Length 1 m, E = 10 Pa, density 1 kg/m3, held at its left end, v0 = {SPEED} sin(pi x/2L) m/s (the paper does not give the \
             amplitude), linear elastic, step 0.001 s. The centre of mass is compared with the mean of (34) and (35); the period is \
             {PERIOD:.3} s."
        ),
        tables: vec![table(runs)],
        figures: figures(runs),
        findings: findings(runs),
        ..Section::default()
    }
}

fn table(runs: &Runs) -> Table {
    let mut rows = Vec::new();
    for (basis, sizes) in [("linear", &SIZES[..]), ("gimp", &SIZES[3..])] {
        for &size in sizes {
            let cells = INTEGRATORS.iter().flat_map(|(integrator, _)| {
                let run = runs.done(&name(basis, integrator, size));
                let [first, _] = run.map_or([None; 2], |run| errors(run, exact, PERIOD).map(Some));
                let [velocity, displacement] = run.map_or([None; 2], |run| errors(run, exact, END).map(Some));
                [first, velocity, displacement, run.and_then(drift)].map(|ours| Cell { paper: None, ours })
            });
            let label = if basis == "linear" { "MPM" } else { "GIMP" };
            rows.push((format!("{label}, {} particles, {} nodes", size.0, size.1), cells.collect()));
        }
    }
    let columns = INTEGRATORS.iter().flat_map(|(_, i)| ["v, first period", "v", "u", "energy"].map(|what| format!("{i}: {what}")));
    Table {
        title: format!("Largest errors of velocity and displacement over {END} s, over their amplitudes, and change of the total energy"),
        header: ["case".to_owned()].into_iter().chain(columns).collect(),
        rows,
        beside: "paper",
        band: None,
    }
}

fn figures(runs: &Runs) -> Vec<Figure> {
    let gimp: Vec<(String, String)> = INTEGRATORS.map(|(i, label)| (name("gimp", i, SIZES[4]), format!("GIMP, {label}"))).into();
    let sizes: Vec<(String, String)> =
        SIZES[..4].iter().map(|&size| (name("linear", "usf", size), format!("{} particles, {} nodes", size.0, size.1))).collect();
    let walls = [(name("linear", "usf", SIZES[3]), "correct".to_owned()), (wrong_name(), "improper".to_owned())];
    let mut boundary = motion("B2: correct and improper boundary conditions", runs, &walls, exact, END);
    let curves = walls.iter().filter_map(|(job, label)| Some(Series::new(label, Style::Line, runs.get(job)?.curve("wall"))));
    let series = curves.chain([Series::new("exact", Style::Reference, known(0.0, END, 1000, beside_wall))]).collect();
    boundary.panels.push(Panel { y: Axis::new("displacement at the wall", "m"), series });
    vec![
        chart(
            "b2-gimp",
            "Figures 13a, 14a: velocity and displacement of the centre of mass, GIMP with USF and USL, 13 particles, 14 nodes",
            motion("B2: centre of mass, GIMP, 13 particles, 14 nodes", runs, &gimp, exact, END),
        ),
        chart(
            "b2-gimp-energy",
            "Figures 13b, 14b: energies, GIMP with USF and USL, 13 particles, 14 nodes",
            energy("B2: energies, GIMP, 13 particles, 14 nodes", runs, &gimp),
        ),
        chart(
            "b2-mesh",
            "Figures 17 (3 and 7 particles, 2 nodes) and 18 (3 and 7 particles, 4 and 8 nodes): centre of mass, MPM with USF",
            motion("B2: centre of mass, MPM with USF", runs, &sizes, exact, 2.0 * PERIOD),
        ),
        chart(
            "b2-boundary",
            "Figures 23 (correct boundary conditions) and 24 (improper): centre of mass, and the particle next to the wall, MPM with USF, 7 particles, 8 nodes",
            boundary,
        ),
        chart(
            "b2-boundary-energy",
            "Figures 23 and 24: energies with correct and improper boundary conditions",
            energy("B2: energies, correct and improper boundary conditions", runs, &walls),
        ),
    ]
}

fn findings(runs: &Runs) -> Vec<Finding> {
    let run = |basis: &str, integrator: &str, size| runs.done(&name(basis, integrator, size));
    let first = |size| Some(errors(run("linear", "usf", size)?, exact, PERIOD)[0]);
    let look = |integrator| {
        let run = run("gimp", integrator, SIZES[4])?;
        let ([v, u], drift) = (errors(run, exact, PERIOD), drift(run)?);
        let seen = format!(
            "Largest errors in the first period: velocity {}, displacement {} of the amplitude; the energy changes by {} in {END} s.",
            percent(v),
            percent(u),
            percent(drift)
        );
        Some((seen, v, u, drift))
    };
    vec![
        Finding::judge(
            "13",
            "GIMP with USF: with more points than one the solution becomes much better, and no dissipation is seen.",
            true,
            || {
                let (seen, v, u, drift) = look("usf")?;
                Some((seen, v < 0.1 && u < 0.1 && drift.abs() < 1e-4))
            },
        ),
        Finding::judge("14", "GIMP with USL dissipates, as MPM does.", true, || {
            let (seen, _, _, drift) = look("usl")?;
            let mpm = super::drift(run("linear", "usl", SIZES[4])?)?;
            Some((format!("{seen} With MPM it changes by {}.", percent(mpm)), drift < -1e-3 && mpm < -5e-4))
        }),
        Finding::judge(
            "17",
            "2 nodes: a relatively high error; more particles alone do not make it smaller (the text lacks the \"not\").",
            true,
            || {
                let (few, many) = (first(SIZES[0])?, first(SIZES[1])?);
                let seen = format!(
                    "Largest error of the velocity in the first period: {} of the amplitude with 3 particles, {} with 7.",
                    percent(few),
                    percent(many)
                );
                Some((seen, few > 0.2 && many > 0.8 * few))
            },
        ),
        Finding::judge("18", "More nodes and particles together make it much smaller.", true, || {
            let errors = [SIZES[0], SIZES[2], SIZES[3], SIZES[4]].map(first);
            let [two, four, eight, fourteen] = [errors[0]?, errors[1]?, errors[2]?, errors[3]?];
            let seen = format!(
                "{} with 4 nodes, {} with 8, {} with 14: with 8, {} less than with 2.",
                percent(four),
                percent(eight),
                percent(fourteen),
                times(two / eight)
            );
            Some((seen, four < 0.5 * two && eight < 0.4 * four && fourteen < eight))
        }),
        Finding::judge("23, 24", "The momentum of a held node must be zero before particles move: else they move wrongly.", true, || {
            let reach = |run: &Run| {
                largest(run.samples("wall").iter().copied()) / largest(known(0.0, PERIOD, 100, beside_wall).iter().map(|p| p[1]))
            };
            let (right, wrong) = (reach(run("linear", "usf", SIZES[3])?), reach(runs.get(&wrong_name())?));
            let seen = format!(
                "The particle next to the wall swings {} as far as it should, with correct boundary conditions {}.",
                times(wrong),
                times(right)
            );
            Some((seen, wrong > 1.5 && right < 1.2))
        }),
        Finding::judge("23, 24", "This is seen in the centre of mass.", false, || {
            let (right, wrong) = (run("linear", "usf", SIZES[3])?, runs.get(&wrong_name())?);
            let ([v, u], [w, d]) = (errors(right, exact, END), errors(wrong, exact, END));
            let seen = format!(
                "Not at {SPEED} m/s, for one of seven particles is moved a little: largest errors over {END} s: velocity {} of the amplitude (correct {}), displacement {} ({}). \
                 The paper does not give its speed.",
                percent(w),
                percent(v),
                percent(d),
                percent(u)
            );
            Some((seen, w > 1.1 * v || d > 1.1 * u))
        }),
    ]
}
