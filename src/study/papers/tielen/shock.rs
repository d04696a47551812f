//! T5: a column that is suddenly loaded on top. Stress stiffens it in compression, so the front is a shock.

use super::{BSPLINE, COLUMN, LINEAR, Method, SPLINE_COLUMN};
use super::{chart, curves, middle, percent};
use crate::study::Effort;
use crate::study::reference::Table as Known;
use crate::study::report::number;
use crate::study::{Axis, Cell, Chart, Figure, Finding, Job, Panel, Run, Runs, Section, Series, Style, Table};

/// End of all runs \[s\].
const END: f64 = 0.5;
const YOUNG: f64 = 1e5;
const DENSITY: f64 = 1e3;
/// Load on top \[Pa\].
const LOAD: f64 = -1e4;
/// Wall times of the thesis \[s\].
const THESIS: [(&Method, f64); 2] = [(&LINEAR, 2300.0), (&SPLINE_COLUMN, 1830.0)];

fn name(method: &Method) -> String {
    format!("T5/{}", method.key)
}

/// Cells and particles a cell: 321 and 258 degrees of freedom in the thesis. B-splines without splines for the force are ours.
fn size(effort: Effort, method: &Method) -> (usize, usize) {
    let linear = method.key == LINEAR.key;
    effort.pick(if linear { (80, 4) } else { (64, 4) }, if linear { (320, 10) } else { (256, 4) })
}

/// The thesis does not give the step; this is a tenth of what the finest grid allows.
fn step(effort: Effort) -> f64 {
    effort.pick(1e-4, 2e-5)
}

/// The solution at the particle just below the middle: 1/6400 below it with the linear functions of the thesis, 1/2048 with splines.
fn known(method: &Method) -> Known {
    Known::column_top().near(if method.key == LINEAR.key { 0.5 - 1.0 / 6400.0 } else { 0.5 - 1.0 / 2048.0 })
}

fn scene(effort: Effort, method: &Method) -> String {
    let (cells, particles) = size(effort, method);
    format!(
        r#"
        title = "Tielen 2016, column under a top load"
        dimension = 1
        grid = {{ origin = [0], size = [1], cell = {cell} }}
        material.soil = {{ law = "hypo_elastic", young = {YOUNG}, density = {DENSITY} }}
        body.column = {{ material = "soil", shape = {{ box = {{ min = [0], max = [1] }} }}, particles_per_cell = {particles} }}
        boundary.foot = {{ face = "x-", fixed = ["x"] }}
        load.top.traction = {{ body = "column", face = "x+", value = [{LOAD}] }}
        probe.middle = {{ at = [{place}] }}
        time = {{ end = {END}, step = {step} }}
        [method]
        integrator = "musl"
        {method}
        "#,
        cell = 1.0 / cells as f64,
        place = known(method).place(),
        step = step(effort),
        method = method.toml,
    )
}

pub(super) fn jobs(effort: Effort) -> Vec<Job> {
    COLUMN.map(|method| middle(Job::new(name(method), scene(effort, method)).every(5e-4)).alone()).into()
}

/// Speed of the first front \[m/s\] over the undeformed column (Rankine and Hugoniot): density U^2 = [stress] / [stretch].
fn front_speed() -> f64 {
    let stretch = 1.0 / (1.0 - LOAD / YOUNG);
    (LOAD / (stretch - 1.0) / DENSITY).sqrt()
}

/// Speed behind it \[m/s\].
fn speed_behind() -> f64 {
    let stretch = 1.0 / (1.0 - LOAD / YOUNG);
    front_speed() * (1.0 - stretch)
}

/// Speed of the front from the top to the watched particle \[m/s\]: it is there when the velocity first passes half of that behind it.
fn measured_speed(run: &Run, place: f64) -> Option<f64> {
    let half = -0.5 * speed_behind();
    let curve = run.curve("velocity");
    let at = curve.windows(2).find(|w| w[1][1] < half)?;
    let time = at[0][0] + (half - at[0][1]) / (at[1][1] - at[0][1]) * (at[1][0] - at[0][0]);
    Some((1.0 - place) / time)
}

/// Mean error (L1) of the displacement and of the velocity over the run, over the mean of the reference.
fn errors(runs: &Runs, method: &Method) -> Option<[f64; 2]> {
    let (run, exact) = (runs.done(&name(method))?, known(method));
    let sum = |points: Vec<[f64; 2]>| points.into_iter().map(|p| p[1].abs()).sum::<f64>();
    let relative = |watched, column, offset| sum(exact.errors(run, watched, column, offset)) / sum(exact.curve(column, END));
    Some([relative("position", 0, exact.place()), relative("velocity", 1, 0.0)])
}

fn wall(runs: &Runs, method: &Method) -> Option<f64> {
    Some(runs.done(&name(method))?.wall)
}

pub(super) fn section(effort: Effort, runs: &Runs) -> Section {
    Section {
        title: "T5 Column under a top load (Tielen 2016, chapter 8)".into(),
        text: format!(
            "Height 1 m, E = 1e5 Pa, density 1e3 kg/m3, no gravity, -1e4 Pa on top from time 0 on, step {:e} s (the thesis does not give it). \
             The load makes a shock of {} m/s (Rankine and Hugoniot). The reference has sharp fronts, and the energy that shocks must lose is lost \
             in it; methods without dissipation, and the finite elements of the thesis, ring behind a front, so errors are means (L1). Wall times are those of single runs with nothing beside them.",
            step(effort),
            number(front_speed())
        ),
        tables: tables(effort, runs),
        figures: figures(effort, runs),
        findings: findings(effort, runs),
        ..Section::default()
    }
}

fn tables(effort: Effort, runs: &Runs) -> Vec<Table> {
    let label = |method: &Method| {
        let (cells, particles) = size(effort, method);
        format!("{}, {cells} cells, {particles} a cell", method.name)
    };
    let ours = |value: Option<f64>| Cell { paper: None, ours: value };
    let row = |method: &Method| {
        let [displacement, velocity] = errors(runs, method).map_or([None; 2], |e| e.map(Some));
        let speed = runs.get(&name(method)).and_then(|run| measured_speed(run, known(method).place()));
        let exact = Cell { paper: Some(front_speed()), ours: speed };
        (label(method), vec![ours(displacement), ours(velocity), exact])
    };
    let header = |columns: &[&str]| columns.iter().map(|c| (*c).to_owned()).collect();
    let thesis = |method: &Method| THESIS.iter().find(|(m, _)| effort == Effort::Full && m.key == method.key).map(|(_, wall)| *wall);
    let time = |method: &Method| (label(method), vec![Cell { paper: thesis(method), ours: wall(runs, method) }]);
    vec![
        Table {
            title: "Middle of the column: mean errors (L1) over the run, relative, and speed of the first front".into(),
            header: header(&["method", "displacement", "velocity", "front [m/s]"]),
            rows: COLUMN.map(row).into(),
            beside: "exact",
            band: Some([0.95, 1.05]),
        },
        Table {
            title: "Wall time [s] (text of chapter 8)".into(),
            header: header(&["method", "wall time"]),
            rows: COLUMN.map(time).into(),
            beside: "paper",
            band: None,
        },
    ]
}

fn figures(effort: Effort, runs: &Runs) -> Vec<Figure> {
    let exact = known(&SPLINE_COLUMN);
    let panel = |title: &'static str, unit, column: usize, offset: f64| {
        let reference = exact.curve(column, END).into_iter().map(|[t, v]| [t, offset + v]);
        let series = curves(runs, &COLUMN, name, title).chain([Series::new("exact", Style::Reference, reference)]).collect();
        Panel { y: Axis::new(title, unit), series }
    };
    let caption = format!(
        "Figures 8.1 (linear, {} cells) and 8.2 (spline-based, {} cells): position and velocity of the particle in the middle",
        size(effort, &LINEAR).0,
        size(effort, &SPLINE_COLUMN).0
    );
    let panels = [panel("position", "m", 0, exact.place()), panel("velocity", "m/s", 1, 0.0)];
    vec![chart("t5-motion", &caption, Chart::stacked("T5: particle in the middle under a sudden top load", Axis::new("time", "s"), panels))]
}

fn findings(effort: Effort, runs: &Runs) -> Vec<Finding> {
    let seen = |e: [f64; 2]| format!("mean error of the displacement is {}, that of the velocity {}", percent(e[0]), percent(e[1]));
    let mut all = vec![
        Finding::judge(
            "8.1",
            "Linear functions: the velocity oscillates severely over almost all the time, and the position does not correspond.",
            true,
            || {
                let e = errors(runs, &LINEAR)?;
                Some((format!("The {}.", seen(e)), e[1] > 0.1 && e[0] > 0.02))
            },
        ),
        Finding::judge("8.2", "The spline-based method: position much better, oscillations of the velocity reduced.", true, || {
            let (linear, spline) = (errors(runs, &LINEAR)?, errors(runs, &SPLINE_COLUMN)?);
            Some((
                format!("The {}; with linear functions the {}.", seen(spline), seen(linear)),
                spline[0] < linear[0] && spline[1] < linear[1],
            ))
        }),
        Finding::judge(
            "none",
            "B-splines with particles as points of integration (not in the thesis) are better than linear functions too.",
            true,
            || {
                let (linear, spline) = (errors(runs, &LINEAR)?, errors(runs, &BSPLINE)?);
                Some((
                    format!("The {}; with linear functions the {}.", seen(spline), seen(linear)),
                    spline[0] < linear[0] && spline[1] < linear[1],
                ))
            },
        ),
    ];
    if effort == Effort::Full {
        all.push(Finding::judge("none", "Both take less than 30 s.", true, || {
            let (linear, spline) = (wall(runs, &LINEAR)?, wall(runs, &SPLINE_COLUMN)?);
            Some((format!("{} s and {} s.", number(linear), number(spline)), linear < 30.0 && spline < 30.0))
        }));
        all.push(Finding::judge(
            "text of chapter 8",
            "At better quality the spline-based method takes less time than linear functions: 1830 s instead of 2300 s.",
            true,
            || {
                let (linear, spline) = (wall(runs, &LINEAR)?, wall(runs, &SPLINE_COLUMN)?);
                let seen = format!(
                    "{} s instead of {} s: a ratio of {:.3}, in the thesis {:.3}.",
                    number(spline),
                    number(linear),
                    spline / linear,
                    THESIS[1].1 / THESIS[0].1
                );
                Some((seen, spline < linear))
            },
        ));
    }
    all
}
