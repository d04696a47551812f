//! T4: the column under its weight with strains of 9 %.

use super::{BSPLINE, COLUMN, LINEAR, Method, PROFILE, Profile, SPLINE_BAR, SPLINE_COLUMN};
use super::{chart, curves, energies, known, largest, lost, middle, percent, rms, stresses, times};
use crate::study::Effort;
use crate::study::reference::Table as Known;
use crate::study::runner::End;
use crate::study::{Axis, Cell, Chart, Figure, Finding, Job, Panel, Runs, Section, Series, Style, Table};
use std::ops::RangeInclusive;

/// End of all runs \[s\].
const END: f64 = 0.5;
const CELLS: usize = 64;
/// What the thesis gave up here: consistent mass, and splines for the projection of velocities too. Nearly empty nodes are lumped.
const CONSISTENT: Method = Method { key: "consistent", name: "spline-based, consistent mass", color: 3, ..SPLINE_BAR };
/// The same, and no node is taken for nearly empty.
const UNGUARDED: Method = Method {
    key: "unguarded",
    name: "the same, no node lumped",
    toml: r#"
        basis = "bspline"
        mass = "consistent"
        quadrature = "splines"
        quadrature_of = "force_and_velocity"
        mass_tolerance = 0.0"#,
    color: 4,
};
/// All that is run.
const ALL: [&Method; 5] = [&LINEAR, &BSPLINE, &SPLINE_COLUMN, &CONSISTENT, &UNGUARDED];
/// Period of the column in small motion \[s\]: four heights at the speed of sound.
const PERIOD: f64 = 0.4;

fn name(method: &Method) -> String {
    format!("T4/{}", method.key)
}

fn scene(method: &Method, place: f64) -> String {
    format!(
        r#"
        title = "Tielen 2016, column under self-weight, large deformations"
        dimension = 1
        grid = {{ origin = [0], size = [1], cell = {cell} }}
        material.soil = {{ law = "hypo_elastic", young = 1e5, density = 1e3 }}
        body.column = {{ material = "soil", shape = {{ box = {{ min = [0], max = [1] }} }}, particles_per_cell = 4 }}
        boundary.foot = {{ face = "x-", fixed = ["x"] }}
        load.weight.gravity = [-9.81]
        probe.middle = {{ at = [{place}] }}
        time = {{ end = {END}, step = 1e-4 }}
        [method]
        integrator = "musl"
        {method}
        "#,
        cell = 1.0 / CELLS as f64,
        method = method.toml,
    )
}

pub(super) fn jobs(_: Effort) -> Vec<Job> {
    let place = Known::column_middle().place();
    let job = |method: &Method| energies(middle(Job::new(name(method), scene(method, place)).every(5e-4))).snapshot(END, PROFILE);
    ALL.map(job).into()
}

pub(super) fn section(_: Effort, runs: &Runs) -> Section {
    Section {
        title: "T4 Column under self-weight, large deformations (Tielen 2016, sections 5.1.4, 6.2.4, 7.2.4)".into(),
        text: "Height 1 m, E = 1e5 Pa, density 1e3 kg/m3, g = -9.81 m/s2 from time 0 on, 64 cells, 4 particles a cell, step 1e-4 s. The \
               reference is a mesh of characteristics of the same law over time, and 4000 finite elements over the height."
            .into(),
        tables: vec![table(runs)],
        figures: figures(runs),
        findings: findings(runs),
        ..Section::default()
    }
}

fn table(runs: &Runs) -> Table {
    let row = |method: &Method| {
        let motion = motion_errors(runs, method, 0.0..=END);
        let stress = stress_errors(runs, method).map(|e| e[0]);
        let shares = [motion.map(|e| e[0]), motion.map(|e| e[1]), stress];
        (method.name.to_owned(), shares.map(|share| Cell { paper: None, ours: share.map(|s| 100.0 * s) }).to_vec())
    };
    Table {
        title: "RMS errors in % of the largest exact value: position and velocity over the run, stress at its end".into(),
        header: ["method", "position", "velocity", "stress"].map(str::to_owned).to_vec(),
        rows: ALL.map(row).into(),
        beside: "paper",
        band: None,
    }
}

fn figures(runs: &Runs) -> Vec<Figure> {
    let (curve, profile) = (Known::column_middle(), Known::column());
    let place = curve.place();
    let motion = |watched: &'static str, column: usize, offset: f64| {
        let exact = curve.curve(column, END).into_iter().map(|[t, v]| [t, offset + v]);
        curves(runs, &COLUMN, name, watched).chain([Series::new("known", Style::Reference, exact)]).collect::<Vec<_>>()
    };
    let exact = known(0.0, 1.0, 128, |x| profile.over_place(END, x, 2)[2]);
    let stress = stresses(runs, &COLUMN, name, END).chain([Series::new("known", Style::Reference, exact)]);
    vec![
        chart(
            "t4-motion",
            "Figures 5.18, 6.14, 7.16 (position) and 5.19, 6.15, 7.17 (velocity) of the particle below the middle, 64 cells",
            Chart::stacked(
                "T4: particle below the middle, 64 cells",
                Axis::new("time", "s"),
                [
                    Panel { y: Axis::new("position", "m"), series: motion("position", 0, place) },
                    Panel { y: Axis::new("velocity", "m/s"), series: motion("velocity", 1, 0.0) },
                ],
            ),
        ),
        chart(
            "t4-stress",
            "Figures 5.20, 6.16, 7.18: stress over the column at 0.5 s, 64 cells",
            Chart::new("T4: stress at t = 0.5 s, 64 cells", Axis::new("height at time 0", "m"), Axis::new("stress", "Pa"), stress),
        ),
    ]
}

/// RMS errors over some of the run of position (over its way) and velocity (over its largest).
fn motion_errors(runs: &Runs, method: &Method, times: RangeInclusive<f64>) -> Option<[f64; 2]> {
    let (run, exact) = (runs.done(&name(method))?, Known::column_middle());
    let error = |watched, column, offset| {
        let errors = exact.errors(run, watched, column, offset).into_iter().filter(|e| times.contains(&e[0]));
        rms(errors.map(|e| e[1])) / largest(exact.curve(column, END).into_iter().map(|p| p[1]))
    };
    Some([error("position", 0, exact.place()), error("velocity", 1, 0.0)])
}

/// RMS and largest error of the stress at the end, over the largest exact stress then.
fn stress_errors(runs: &Runs, method: &Method) -> Option<[f64; 2]> {
    let exact = Known::column();
    let errors = Profile::of(runs.done(&name(method))?, END)?.stress_errors(|x| exact.over_place(END, x, 2)[2]);
    let top = largest((0..=64).map(|i| exact.over_place(END, i as f64 / 64.0, 2)[2]));
    Some([rms(errors.iter().map(|e| e[1])) / top, largest(errors.iter().map(|e| e[1])) / top])
}

/// How far below its start the particle turns around, one period on, as a share of its way.
fn missing(runs: &Runs, method: &Method) -> Option<f64> {
    let (run, exact) = (runs.done(&name(method))?, Known::column_middle());
    let way = largest(exact.curve(0, END).into_iter().map(|p| p[1]));
    let back = run.curve("position").into_iter().filter(|p| (p[0] - PERIOD).abs() < 0.25 * PERIOD).map(|p| p[1]).fold(f64::MIN, f64::max);
    Some((exact.place() - back) / way)
}

fn findings(runs: &Runs) -> Vec<Finding> {
    let look = |method: &Method| {
        let ([position, velocity], missing, lost) =
            (motion_errors(runs, method, 0.0..=END)?, missing(runs, method)?, lost(runs.done(&name(method))?)?);
        let seen = format!(
            "RMS errors: position {} of the way, velocity {} of the largest; after a period the particle is {} of the way from its start; {} of the energy of motion is lost.",
            percent(position),
            percent(velocity),
            percent(missing),
            percent(lost)
        );
        Some((seen, position, velocity, lost))
    };
    vec![
        Finding::judge(
            "5.18, 5.19",
            "Linear functions: both curves go wrong after some 0.05 s, the particle does not come back, energy is not conserved.",
            true,
            || {
                let (seen, position, velocity, lost) = look(&LINEAR)?;
                Some((seen, position > 0.02 && velocity > 0.1 && lost.abs() > 0.02))
            },
        ),
        Finding::judge("5.20", "Linear functions: unrealistically high stresses.", true, || {
            let [all, worst] = stress_errors(runs, &LINEAR)?;
            Some((format!("RMS error of the stress {} of the largest, at most {}.", percent(all), percent(worst)), worst > 0.3))
        }),
        Finding::judge(
            "6.14, 6.15",
            "B-splines: much better; the velocity oscillates more as time goes on, and a small dissipation remains.",
            true,
            || {
                let (seen, position, velocity, lost) = look(&BSPLINE)?;
                let (_, linear, ..) = look(&LINEAR)?;
                let half = |times| Some(motion_errors(runs, &BSPLINE, times)?[1]);
                let growth = half(0.5 * END..=END)? / half(0.0..=0.5 * END)?;
                let seen = format!(
                    "{seen} The error of the velocity is {} as large in the second half of the run as in the first.",
                    times(growth)
                );
                Some((seen, position < 0.3 * linear && velocity < 0.2 && growth > 1.0 && lost > 0.0))
            },
        ),
        Finding::judge("6.16", "B-splines: the front is reproduced; the stress still oscillates slightly.", true, || {
            let ([linear, _], [all, worst]) = (stress_errors(runs, &LINEAR)?, stress_errors(runs, &BSPLINE)?);
            let seen = format!(
                "RMS error of the stress {} of the largest (linear functions {}), at most {}.",
                percent(all),
                percent(linear),
                percent(worst)
            );
            Some((seen, all < 0.3 * linear && all < 0.1))
        }),
        Finding::judge(
            "7.16, 7.17",
            "The spline-based method: visually the reference; energy would seem to be conserved, the oscillations are gone.",
            true,
            || {
                let ((seen, position, velocity, lost), (_, before, swinging, _)) = (look(&SPLINE_COLUMN)?, look(&BSPLINE)?);
                Some((seen, position < before && velocity < swinging && lost.abs() < 0.01))
            },
        ),
        Finding::judge(
            "7.18",
            "The spline-based method: only a small difference from the reference, much less than with B-splines.",
            true,
            || {
                let ([before, _], [all, _]) = (stress_errors(runs, &BSPLINE)?, stress_errors(runs, &SPLINE_COLUMN)?);
                Some((
                    format!("RMS error of the stress {} of the largest, with B-splines {}.", percent(all), percent(before)),
                    all < 0.7 * before,
                ))
            },
        ),
        Finding::judge(
            "none",
            "The spline-based method: the position within 0.1 % of its way, B-splines at least 4 times further off.",
            true,
            || {
                let [plain, spline] = [&BSPLINE, &SPLINE_COLUMN].map(|m| motion_errors(runs, m, 0.0..=END));
                let (plain, spline) = (plain?[0], spline?[0]);
                let seen =
                    format!("RMS error {} of the way, with B-splines {}: {}.", percent(spline), percent(plain), times(plain / spline));
                Some((seen, spline <= 1e-3 && plain >= 4.0 * spline))
            },
        ),
        Finding::judge(
            "text of section 7.2.4",
            "A consistent mass leads to unrealistically high velocities where entries of the mass matrix approach zero.",
            true,
            || {
                let run = runs.get(name(&UNGUARDED).as_str())?;
                let End::Failed(reason) = &run.end else { return Some(("It runs.".into(), false)) };
                Some((format!("Without a lower limit of the mass the run ends after {:.3} s: {reason}.", run.times.last()?), true))
            },
        ),
        Finding::judge(
            "text of section 7.2.4",
            "So it cannot be had with this column, nor can splines for the projection of velocities (they oscillate).",
            false,
            || {
                let (lumped, consistent) = (motion_errors(runs, &SPLINE_COLUMN, 0.0..=END)?, motion_errors(runs, &CONSISTENT, 0.0..=END)?);
                let seen = format!(
                    "Both can where nearly empty nodes are lumped: RMS error of the position {} of the way instead of {}, of the velocity {} of the largest instead of {}.",
                    percent(consistent[0]),
                    percent(lumped[0]),
                    percent(consistent[1]),
                    percent(lumped[1])
                );
                Some((seen, consistent[0] > lumped[0]))
            },
        ),
    ]
}
