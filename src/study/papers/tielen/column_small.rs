//! T3: a column that suddenly feels its weight, with strains of 0.5 %: a front runs up and down.

use super::{BSPLINE, COLUMN, LINEAR, Method, PROFILE, Profile, SPLINE_COLUMN};
use super::{chart, curve_error, curves, energies, known, largest, lost, middle, percent, rms, stresses, times};
use crate::study::reference::small_column;
use crate::study::{Axis, Chart, Effort, Figure, Finding, Job, Panel, Runs, Section, Series, Style};

const HEIGHT: f64 = 25.0;
/// End of all runs \[s\].
const END: f64 = 0.5;
/// Cells without and with crossing: 50 and 80 nodes.
const CELLS: [usize; 2] = [49, 79];
/// Largest stress of the exact solution: twice that at rest, at the foot.
const STRESS: f64 = 2.0 * 9.81 * HEIGHT;
/// Largest velocity of the exact solution in the middle: that of free fall until the wave from the foot is there.
const SPEED: f64 = 9.81 * 0.5 * HEIGHT / 223.606_797_749_979;

fn name(method: &Method, cells: usize) -> String {
    format!("T3/{}/{cells} cells", method.key)
}

/// Just below the middle: the particles of a cell are half a cell apart, and the middle of the column is that of a cell.
fn place(cells: usize) -> f64 {
    0.5 * HEIGHT - 0.25 * HEIGHT / cells as f64
}

fn scene(method: &Method, cells: usize) -> String {
    format!(
        r#"
        title = "Tielen 2016, column under self-weight, small deformations"
        dimension = 1
        grid = {{ origin = [0], size = [{HEIGHT}], cell = {cell} }}
        material.soil = {{ law = "linear_elastic", young = 5e4, density = 1 }}
        body.column = {{ material = "soil", shape = {{ box = {{ min = [0], max = [{HEIGHT}] }} }}, particles_per_cell = 2 }}
        boundary.foot = {{ face = "x-", fixed = ["x"] }}
        load.weight.gravity = [-9.81]
        probe.middle = {{ at = [{place}] }}
        time = {{ end = {END}, step = 1e-4 }}
        [method]
        integrator = "musl"
        {method}
        "#,
        cell = HEIGHT / cells as f64,
        place = place(cells),
        method = method.toml,
    )
}

pub(super) fn jobs(_: Effort) -> Vec<Job> {
    let cases = [(&LINEAR, CELLS[0])].into_iter().chain(COLUMN.map(|method| (method, CELLS[1])));
    let job = |(method, cells)| {
        let job = Job::new(name(method, cells), scene(method, cells)).every(1e-3);
        energies(middle(job)).snapshot(END, PROFILE)
    };
    cases.map(job).collect()
}

pub(super) fn section(_: Effort, runs: &Runs) -> Section {
    Section {
        title: "T3 Column under self-weight, small deformations (Tielen 2016, sections 5.1.3, 6.2.3, 7.2.3)".into(),
        text: "Height 25 m, E = 5e4 Pa, density 1 kg/m3, g = -9.81 m/s2 from time 0 on, 2 particles a cell, step 1e-4 s; 49 cells, where \
               the thesis sees no particle cross, and 79 cells, where it does. The reference is the analytic solution (4.2), its series \
               summed. The captions of figures 5.14 and 5.17 name each other's number of degrees of freedom; we follow the text."
            .into(),
        figures: figures(runs),
        findings: findings(runs),
        ..Section::default()
    }
}

fn figures(runs: &Runs) -> Vec<Figure> {
    let [coarse, fine] = CELLS;
    // the few cells are one curve more, in a colour of their own
    let motion = |name_of: &'static str, column: usize, offset: f64| {
        let exact = known(0.0, END, 500, |t| offset * place(fine) + small_column(place(fine), t)[column]);
        let few = runs.get(&name(&LINEAR, coarse)).map(|run| run.curve(name_of)).unwrap_or_default();
        // drawn relative to the place of the particle in the finer grid
        let shift = offset * (place(fine) - place(coarse));
        let few = few.into_iter().map(move |[t, v]| [t, v + shift]);
        [Series::new(format!("linear, {coarse} cells"), Style::Line, few).color(5)]
            .into_iter()
            .chain(curves(runs, &COLUMN, |m| name(m, fine), name_of))
            .chain([Series::new("equation (4.2)", Style::Reference, exact)])
            .collect::<Vec<_>>()
    };
    let few = runs.get(&name(&LINEAR, coarse)).and_then(|run| Profile::of(run, END));
    let few = Series::new(format!("linear, {coarse} cells"), Style::Joined, few.iter().flat_map(Profile::stress_points)).color(5);
    let exact = Series::new("equation (4.2)", Style::Reference, known(0.0, HEIGHT, 500, |y| small_column(y, END)[2]));
    let stress = [few].into_iter().chain(stresses(runs, &COLUMN, |m| name(m, fine), END)).chain([exact]);
    vec![
        chart(
            "t3-motion",
            "Figures 5.12, 5.15, 6.11, 7.13 (position) and 5.13, 5.16, 6.12, 7.14 (velocity) of the particle below the middle, 79 cells and 49 cells",
            Chart::stacked(
                "T3: particle below the middle, 79 cells",
                Axis::new("time", "s"),
                [
                    Panel { y: Axis::new("position", "m"), series: motion("position", 0, 1.0) },
                    Panel { y: Axis::new("velocity", "m/s"), series: motion("velocity", 1, 0.0) },
                ],
            ),
        ),
        chart(
            "t3-stress",
            "Figures 5.14, 5.17, 6.13, 7.15: stress over the column at 0.5 s, 79 cells and 49 cells",
            Chart::new("T3: stress at t = 0.5 s", Axis::new("height at time 0", "m"), Axis::new("stress", "Pa"), stress),
        ),
    ]
}

/// RMS errors over the run of position (over its way) and velocity (over its largest), and of the stress at the end (over the largest).
fn errors(runs: &Runs, method: &Method, cells: usize) -> Option<[f64; 3]> {
    let run = runs.done(&name(method, cells))?;
    let place = place(cells);
    let way = largest(known(0.0, END, 500, |t| small_column(place, t)[0]).into_iter().map(|p| p[1]));
    let position = curve_error(run, "position", 0.0..=END, |t| place + small_column(place, t)[0]) / way;
    let velocity = curve_error(run, "velocity", 0.0..=END, |t| small_column(place, t)[1]) / SPEED;
    Some([position, velocity, rms(stress_errors(runs, method, cells)?.iter().map(|e| e[1])) / STRESS])
}

fn stress_errors(runs: &Runs, method: &Method, cells: usize) -> Option<Vec<[f64; 2]>> {
    Some(Profile::of(runs.done(&name(method, cells))?, END)?.stress_errors(|y| small_column(y, END)[2]))
}

fn findings(runs: &Runs) -> Vec<Finding> {
    let [coarse, fine] = CELLS;
    let all = |e: [f64; 3]| {
        format!(
            "RMS errors: position {} of the way, velocity {}, stress at {END} s {} of the largest",
            percent(e[0]),
            percent(e[1]),
            percent(e[2])
        )
    };
    vec![
        Finding::judge(
            "5.12, 5.13, 5.14",
            "Linear functions, 49 cells: position as the analytic solution; the velocity oscillates around it where that is constant; the stress corresponds well.",
            true,
            || {
                let e = errors(runs, &LINEAR, coarse)?;
                Some((format!("{}.", all(e)), e[0] < 0.01 && e[1] > e[0] && e[2] < 0.05))
            },
        ),
        Finding::judge(
            "5.15, 5.16",
            "Linear functions, 79 cells: particles cross, position and velocity go wrong, energy is lost.",
            true,
            || {
                let ([few, many], lost) =
                    ([errors(runs, &LINEAR, coarse)?, errors(runs, &LINEAR, fine)?], lost(runs.done(&name(&LINEAR, fine))?)?);
                let seen = format!(
                    "RMS errors: position {} of the way (49 cells {}), velocity {} ({}); {} of the energy of motion is lost.",
                    percent(many[0]),
                    percent(few[0]),
                    percent(many[1]),
                    percent(few[1]),
                    percent(lost)
                );
                Some((seen, many[0] > 3.0 * few[0] && many[1] > few[1] && lost > 0.0))
            },
        ),
        Finding::judge("5.17", "Linear functions, 79 cells: unrealistically high stresses, the front is not reproduced.", true, || {
            let (few, many) = (stress_errors(runs, &LINEAR, coarse)?, stress_errors(runs, &LINEAR, fine)?);
            let [few, many] = [few, many].map(|e| largest(e.iter().map(|e| e[1])) / STRESS);
            let seen = format!(
                "The largest error of the stress is {} of the largest exact stress, with 49 cells {}.",
                percent(many),
                percent(few)
            );
            Some((seen, many > 3.0 * few && many > 0.2))
        }),
        Finding::judge("6.11, 6.12", "B-splines, 79 cells: position and velocity correspond well again.", true, || {
            let (linear, spline) = (errors(runs, &LINEAR, fine)?, errors(runs, &BSPLINE, fine)?);
            Some((
                format!("{}: the position is {} closer than with linear functions.", all(spline), times(linear[0] / spline[0])),
                spline[0] < 0.01 && spline[1] < 0.1,
            ))
        }),
        Finding::judge("6.13", "B-splines: the front is reproduced, with slight oscillations.", true, || {
            let (linear, spline) = (errors(runs, &LINEAR, fine)?[2], errors(runs, &BSPLINE, fine)?[2]);
            let seen = format!("RMS error of the stress {} of the largest, with linear functions {}.", percent(spline), percent(linear));
            Some((seen, spline < 0.05 && spline < 0.3 * linear))
        }),
        Finding::judge("7.13, 7.14", "The spline-based method: no visible difference from B-splines.", true, || {
            let (bspline, spline) = (errors(runs, &BSPLINE, fine)?, errors(runs, &SPLINE_COLUMN, fine)?);
            Some((format!("{}.", all(spline)), spline[0] < 0.01 && (spline[1] - bspline[1]).abs() < 0.02))
        }),
        Finding::judge("7.15", "The spline-based method: the stress oscillates less in the upper part.", true, || {
            let upper = |method: &Method| {
                Some(rms(stress_errors(runs, method, fine)?.iter().filter(|e| e[0] > 0.5 * HEIGHT).map(|e| e[1])) / STRESS)
            };
            let (bspline, spline) = (upper(&BSPLINE)?, upper(&SPLINE_COLUMN)?);
            Some((
                format!("RMS error in the upper half {} of the largest stress, with B-splines {}.", percent(spline), percent(bspline)),
                spline < bspline,
            ))
        }),
    ]
}
