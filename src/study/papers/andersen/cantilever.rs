//! A2: a cantilever is pulled down at its tip by a force that grows for as long as the beam takes to swing once.

use super::{ALL, BSPLINE, CONSISTENT, CUBIC, Element, LAGRANGE, LINEAR, LUMPED, PAPER, SERENDIPITY};
use super::{chart, cloud, each, energies, percent, places, rms, stress_xx, table, view};
use crate::study::{Axis, Cell, Chart, Cloud, Effort, Figure, Finding, Job, Panel, Run, Runs, Section, Series, Style, Table, View};

/// End of the runs, and of the growth of the force \[s\].
const END: f64 = 20.0;
/// The force of the figures but the last \[N\]; the particle gets the share of its mass in the beam.
const FORCE: f64 = 100.0;
/// The force of figure 12.
const LARGE: f64 = 800.0;
const CELL: f64 = 0.5;
/// Cells with which the load sits on a particle at the same place.
const FINE: f64 = CELL / 3.0;
/// What a snapshot holds.
const STATE: [&str; 3] = ["particle/position", "particle/displacement", "particle/stress"];
/// Elements that are run with consistent mass too.
const MATRIX: [&Element; 4] = [&LINEAR, &SERENDIPITY, &LAGRANGE, &BSPLINE];
/// Elements that are run with finer cells too.
const FINER: [&Element; 3] = [&LINEAR, &CUBIC, &BSPLINE];

fn name(element: &Element, mass: &str, force: f64, cell: f64) -> String {
    let fineness = if cell < CELL { ", fine" } else { "" };
    format!("A2/{}/{mass}, {force} N{fineness}", element.key)
}

fn usual(element: &Element) -> String {
    name(element, LUMPED, FORCE, CELL)
}

fn scene(element: &Element, mass: &str, force: f64, cell: f64, step: f64) -> String {
    format!(
        r#"
        title = "Andersen 2007, cantilever"
        dimension = 2
        plane = "strain"
        grid = {{ origin = [0, -1], size = [9, 3], cell = {cell} }}
        material.steel = {{ law = "hypo_elastic", young = 3e5, poisson = 0, density = 1e3 }}
        body.beam = {{ material = "steel", shape = {{ box = {{ min = [0, 0], max = [8, 1] }} }}, particles_per_cell = 3 }}
        boundary.wall = {{ face = "x-", fixed = ["x", "y"] }}
        time = {{ end = {END}, step = {step} }}
        method = {{ basis = "{basis}", mass = "{mass}", integrator = "usf" }}
        [load.tip.point_force]
        body = "beam"
        at = [{x}, {y}]
        value = [0, "-{force}/288*t/{END}"]
        "#,
        x = 8.0 - 1.0 / 12.0,
        y = 1.0 - 1.0 / 12.0,
        basis = element.basis,
    )
}

pub(super) fn jobs(effort: Effort) -> Vec<Job> {
    // the quick runs take larger steps; the beam hardly notices
    let step = effort.pick(0.01, 0.003);
    let job = |element: &Element, mass: &str, force: f64, cell: f64| {
        let job = Job::new(name(element, mass, force, cell), scene(element, mass, force, cell, step)).snapshot(END, STATE);
        // the deflection near the tip, as in figure 11
        energies(job).every(effort.pick(1.0, 0.2)).watch("tip", |sim| {
            let moved = sim.get("particle/displacement")?.to_vec();
            let start: Vec<[f64; 2]> = places(sim.get("particle/position")?).iter().zip(places(&moved)).map(|(x, u)| less(*x, u)).collect();
            Ok(axis_deflections(&start, &places(&moved)).last().map_or(f64::NAN, |p| p[1]))
        })
    };
    let mut jobs: Vec<Job> =
        ALL.iter().filter(|e| effort == Effort::Full || PAPER.contains(e)).map(|e| job(e, LUMPED, FORCE, CELL)).collect();
    let large = effort.pick(&[&CUBIC][..], &[&LINEAR, &SERENDIPITY, &LAGRANGE, &CUBIC, &BSPLINE][..]);
    jobs.extend(large.iter().map(|e| job(e, LUMPED, LARGE, CELL)));
    if effort == Effort::Full {
        jobs.extend(MATRIX.iter().map(|e| job(e, CONSISTENT, FORCE, CELL)));
        jobs.extend(FINER.map(|e| job(e, LUMPED, FORCE, FINE)));
    }
    jobs
}

/// Places or displacements of the particles.
type Points = Vec<[f64; 2]>;

fn less(a: [f64; 2], b: [f64; 2]) -> [f64; 2] {
    [a[0] - b[0], a[1] - b[1]]
}

/// Mean downward displacement of the two rows of particles beside the axis, over x at time 0.
fn axis_deflections(start: &[[f64; 2]], moved: &[[f64; 2]]) -> Vec<[f64; 2]> {
    let nearest = start.iter().map(|x| (x[1] - 0.5).abs()).fold(f64::INFINITY, f64::min);
    let mut beside: Vec<[f64; 2]> =
        start.iter().zip(moved).filter(|(x, _)| (x[1] - 0.5).abs() < 1.5 * nearest).map(|(x, u)| [x[0], -u[1]]).collect();
    beside.sort_by(|a, b| a[0].total_cmp(&b[0]));
    beside.chunks_exact(2).map(|two| [0.5 * (two[0][0] + two[1][0]), 0.5 * (two[0][1] + two[1][1])]).collect()
}

/// Positions at time 0 and displacements at the end.
fn last(run: &Run) -> Option<(Points, Points)> {
    let moved = places(run.at(END, "particle/displacement")?);
    let start = places(run.at(END, "particle/position")?).into_iter().zip(&moved).map(|(x, u)| less(x, *u)).collect();
    Some((start, moved))
}

fn deflections(run: &Run) -> Option<Vec<[f64; 2]>> {
    let (start, moved) = last(run)?;
    Some(axis_deflections(&start, &moved))
}

/// What a deflection at the end is compared with, for the force of 100 N.
#[derive(Clone, Copy)]
enum Known {
    /// At rest under the last force.
    Static = 1,
    /// Of the motion under the growing force.
    Dynamic = 2,
    /// Eq. 34 of the paper.
    Formula = 3,
}

fn known(of: Known, force: f64) -> Vec<[f64; 2]> {
    let rows: Vec<[f64; 4]> = table(include_str!("../../../../tests/reference/andersen_cantilever.csv"));
    rows.into_iter().map(|row| [row[0], force / FORCE * row[of as usize]]).collect()
}

/// Deflection near the tip over the known one.
fn tip_ratio(run: &Run, of: Known, force: f64) -> Option<f64> {
    Some(deflections(run)?.last()?[1] / known_at(of, force, deflections(run)?.last()?[0])?)
}

/// Between the rows of the table, in a straight line; beyond the last row with its slope.
fn known_at(of: Known, force: f64, x: f64) -> Option<f64> {
    let rows = known(of, force);
    let at = rows.partition_point(|row| row[0] < x).clamp(1, rows.len().checked_sub(1)?);
    let ([a, u], [b, v]) = (rows[at - 1], rows[at]);
    Some(u + (v - u) * (x - a) / (b - a))
}

/// Known stress xx by particle of the coarse grid: x, y, value.
fn known_stress() -> Vec<[f64; 3]> {
    table(include_str!("../../../../tests/reference/andersen_cantilever_stress.csv"))
}

/// Our stress xx and the known one at each place of the known.
fn stresses(run: &Run) -> Option<Vec<([f64; 2], f64, f64)>> {
    let ((start, _), ours) = (last(run)?, stress_xx(run.at(END, "particle/stress")?));
    let near = |x: f64, y: f64| start.iter().position(|s| (s[0] - x).abs() < 1e-6 && (s[1] - y).abs() < 1e-6);
    known_stress().into_iter().map(|[x, y, value]| Some(([x, y], ours[near(x, y)?], value))).collect()
}

/// RMS error of the stress over the RMS of the known.
fn stress_error(run: &Run) -> Option<f64> {
    let pairs = stresses(run)?;
    Some(rms(pairs.iter().map(|(_, a, b)| a - b)) / rms(pairs.iter().map(|(_, _, b)| *b)))
}

/// Spread of the stress along `axis` among the nine particles of a cell, over that of the known: RMS over the cells.
fn spread_in_cells(run: &Run, axis: usize) -> Option<f64> {
    let pairs = stresses(run)?;
    let (mut ours, mut exact) = (Vec::new(), Vec::new());
    for (x, a, b) in &pairs {
        // the particle two places on, in the same cell
        let mut next = *x;
        next[axis] += 1.0 / 3.0;
        let same = (next[axis] / CELL).floor() == (x[axis] / CELL).floor();
        let other = pairs.iter().find(|(y, _, _)| same && (y[0] - next[0]).abs() < 1e-6 && (y[1] - next[1]).abs() < 1e-6);
        if let Some((_, c, d)) = other {
            ours.push(c - a);
            exact.push(d - b);
        }
    }
    Some(rms(ours) / rms(exact))
}

pub(super) fn section(effort: Effort, runs: &Runs) -> Section {
    Section {
        title: "A2 Cantilever with a growing tip force (Andersen 2007, section 4.1)".into(),
        text: format!(
            "8 m x 1 m, E = 3e5 Pa, nu = 0, density 1e3 kg/m3, 288 particles in cells of {CELL} m (19 x 7 nodes), stress first, lumped mass \
             where nothing else is said; the upper right particle is pulled down by F/288, which grows from 0 to its full size in {END} s. \
             The paper takes the end for the rest under the last force, but the beam swings with a period of 23.107 s: its tip is then \
             {:.4} times as far down as at rest. The dynamic reference is linear elastodynamics with the same load, by a Ritz expansion in Legendre polynomials.",
            ratio_of_motion()
        ),
        tables: vec![deflection_table(runs)],
        figures: figures(effort, runs),
        findings: findings(effort, runs),
        ..Section::default()
    }
}

/// Dynamic over static deflection near the tip.
fn ratio_of_motion() -> f64 {
    let tip = |of| known(of, FORCE).last().map_or(f64::NAN, |p| p[1]);
    tip(Known::Dynamic) / tip(Known::Static)
}

fn deflection_table(runs: &Runs) -> Table {
    let kinds = [(LUMPED, CELL, ""), (CONSISTENT, CELL, ", consistent mass"), (LUMPED, FINE, ", cells of a third")];
    let mut rows = Vec::new();
    for (mass, cell, words) in kinds {
        for element in ALL {
            let Some(run) = runs.done(&name(element, mass, FORCE, cell)) else { continue };
            let ratio = |of| Cell { paper: None, ours: tip_ratio(run, of, FORCE) };
            let error = Cell { paper: None, ours: if cell < CELL { None } else { stress_error(run) } };
            rows.push((
                format!("{}{words}", element.name),
                vec![ratio(Known::Dynamic), ratio(Known::Static), ratio(Known::Formula), error],
            ));
        }
    }
    let header = ["", "tip / dynamic", "tip / static", "tip / formula (34)", "RMS error of stress xx / RMS"].map(str::to_owned).to_vec();
    Table { title: "Deflection near the tip and stress at 20 s, F = 100 N".into(), header, rows, beside: "exact", band: None }
}

fn figures(effort: Effort, runs: &Runs) -> Vec<Figure> {
    let get = |e: &Element| runs.done(&usual(e));
    let start = get(&LINEAR).and_then(|run| {
        let (start, _) = last(run)?;
        let height = start.iter().map(|x| x[1]).collect();
        Some(View { title: format!("{} particles", start.len()), points: start, values: height })
    });
    let known_view = {
        let rows = known_stress();
        let points = rows.iter().map(|row| [row[0], row[1]]).collect();
        View { title: "dynamic reference".into(), points, values: rows.iter().map(|row| row[2]).collect() }
    };
    let pattern = |e: &&Element| view(e.name, get(e)?, END, |run| Some(stress_xx(run.at(END, "particle/stress")?)));
    let views = PAPER.iter().filter_map(pattern).chain([known_view]).chain([&BSPLINE].iter().filter_map(pattern));
    let deflection = |e: &&Element| Some(Series::new(e.name, Style::Joined, deflections(get(e)?)?).color(e.color));
    let reference = |name: &str, of, force| Series::new(name, Style::Reference, known(of, force));
    let shown = effort.pick(&PAPER[..], &ALL[..]);
    let axis = ALL.iter().filter_map(deflection).chain([
        reference("dynamic reference", Known::Dynamic, FORCE),
        reference("static", Known::Static, FORCE),
        reference("formula (34)", Known::Formula, FORCE),
    ]);
    let history = shown.iter().filter_map(|e| Some(Series::new(e.name, Style::Line, get(e)?.curve("tip")).color(e.color)));
    let exact: Vec<[f64; 2]> = table(include_str!("../../../../tests/reference/andersen_cantilever_tip.csv"));
    vec![
        cloud(
            "a2-start",
            "Figure 9: the particles of the cantilever at time 0",
            Cloud::new("A2: particles at time 0", Axis::new("y", "m"), start),
        ),
        cloud(
            "a2-stress",
            "Figure 10: stress xx at 20 s, F = 100 N, in 4-node, 8-node, 9-node elements and cubic splines, of the reference and in B-splines",
            Cloud::new("A2: stress xx at 20 s", Axis::new("stress xx", "Pa"), views).columns(2),
        ),
        chart(
            "a2-deflection",
            "Figure 11: deflection of the axis at 20 s, F = 100 N",
            Chart::new("A2: deflection of the axis at 20 s, F = 100 N", Axis::new("x at time 0", "m"), Axis::new("deflection", "m"), axis),
        ),
        chart(
            "a2-tip",
            "Beside figure 11: deflection near the tip over time",
            Chart::stacked(
                "A2: deflection near the tip, F = 100 N",
                Axis::new("time", "s"),
                [Panel {
                    y: Axis::new("deflection", "m"),
                    series: history.chain([Series::new("reference at x = 8 m", Style::Reference, exact)]).collect(),
                }],
            ),
        ),
        chart(
            "a2-large",
            "Figure 12: particles at 20 s with cubic splines, F = 800 N, true to scale in neither panel, and the axis by the formula and by the reference",
            large(runs),
        ),
    ]
}

fn large(runs: &Runs) -> Chart {
    let run = runs.done(&name(&CUBIC, LUMPED, LARGE, CELL));
    let points = run.and_then(|run| run.at(END, "particle/position")).map_or(Vec::new(), places);
    let kinds = [("dynamic reference", Known::Dynamic), ("formula (34)", Known::Formula)];
    let position = kinds.map(|(name, of)| Series::new(name, Style::Reference, known(of, LARGE).into_iter().map(|[x, v]| [x, 0.5 - v])));
    let deflection = kinds.map(|(name, of)| Series::new(name, Style::Reference, known(of, LARGE)));
    let ours = |style, points: Vec<[f64; 2]>| Series::new("cubic splines", style, points).color(CUBIC.color);
    let axis = run.and_then(deflections).unwrap_or_default();
    let panels = [
        Panel { y: Axis::new("y", "m"), series: [ours(Style::Markers, points)].into_iter().chain(position).collect() },
        Panel { y: Axis::new("deflection", "m"), series: [ours(Style::Joined, axis)].into_iter().chain(deflection).collect() },
    ];
    Chart::stacked("A2: particles and deflection of the axis at 20 s, F = 800 N", Axis::new("x", "m"), panels)
}

fn findings(effort: Effort, runs: &Runs) -> Vec<Finding> {
    let mut all = of_the_paper(runs);
    if effort == Effort::Full {
        all.push(Finding::judge("11, finer cells", "Not in the paper: finer cells lead to the dynamic reference.", true, || {
            let ratios = |e: &Element| {
                let ratio = |cell| tip_ratio(runs.done(&name(e, LUMPED, FORCE, cell))?, Known::Dynamic, FORCE);
                Some([ratio(CELL)?, ratio(FINE)?])
            };
            let rows = FINER.iter().map(|e| ratios(e)).collect::<Option<Vec<_>>>()?;
            let list = FINER.iter().zip(&rows).map(|(e, [coarse, fine])| format!("{} {coarse:.4} and {fine:.4}", e.name)).collect::<Vec<_>>();
            let seen = format!(
                "Tip over the reference with cells of {CELL} m and a third of it: {}. Six particles over the height have {:.4} of the bending \
                 stiffness, eighteen {:.4}: that alone makes good elements a little too soft.",
                list.join(", "),
                1.0 - 1.0 / 36.0,
                1.0 - 1.0 / 324.0
            );
            Some((seen, rows.iter().all(|[coarse, fine]| (fine - 1.0).abs() < 0.4 * (coarse - 1.0).abs())))
        }));
    }
    all
}

fn of_the_paper(runs: &Runs) -> Vec<Finding> {
    let get = |e: &Element| runs.done(&usual(e));
    let ratio = |e: &Element, of| tip_ratio(get(e)?, of, FORCE);
    let list = |of| each(&ALL, |e| ratio(e, of), |v| format!("{v:.4}"));
    let paper = |of| PAPER.iter().map(|e| ratio(e, of)).collect::<Option<Vec<_>>>();
    let nearest = |ratios: &[f64]| (0..ratios.len()).min_by(|&a, &b| (ratios[a] - 1.0).abs().total_cmp(&(ratios[b] - 1.0).abs()));
    vec![
        Finding::judge("9", "288 material points; the simulation shows the static deflection.", false, || {
            let ((start, _), ratio) = (last(get(&LAGRANGE)?)?, ratio_of_motion());
            let seen = format!(
                "{} particles; but the ramp is shorter than the period of 23.107 s, and the tip is then {ratio:.4} times as far down as at rest.",
                start.len()
            );
            Some((seen, start.len() == 288 && (ratio - 1.0).abs() < 0.02))
        }),
        Finding::judge("10", "8-node and 9-node elements give the right stress, linear in both directions.", true, || {
            let errors = [&SERENDIPITY, &LAGRANGE].map(|e| stress_error(get(e)?));
            let [eight, nine] = [errors[0]?, errors[1]?];
            let seen = format!("RMS error {} and {} of the RMS stress.", percent(eight), percent(nine));
            Some((seen, eight < 0.1 && nine < 0.1))
        }),
        Finding::judge(
            "10",
            "4-node elements: the stress is constant in an element, its variation along the beam is right.",
            false,
            || {
                let run = get(&LINEAR)?;
                let (along, across, error) = (spread_in_cells(run, 0)?, spread_in_cells(run, 1)?, stress_error(run)?);
                let seen = format!(
                    "Along the beam it is constant in an element ({} of the right variation), a staircase; over the height it varies by {} of the right \
                 variation, as the slope of a bilinear function does; RMS error {}.",
                    percent(along),
                    percent(across),
                    percent(error)
                );
                Some((seen, along < 0.05 && across < 0.05))
            },
        ),
        Finding::judge("10", "Cubic splines: a nonphysical variation of the stress, from the functions at the border.", true, || {
            let error = |e: &Element| stress_error(get(e)?);
            let (cubic, others) = (error(&CUBIC)?, [error(&LINEAR)?, error(&SERENDIPITY)?, error(&LAGRANGE)?]);
            let seen = format!("RMS error over the RMS stress: {}.", each(&ALL, error, percent));
            Some((seen, others.iter().all(|e| *e < cubic)))
        }),
        Finding::judge("11", "4-node elements deflect least, cubic splines most.", true, || {
            let r = paper(Known::Dynamic)?;
            let inner = [r[1], r[2]];
            Some((format!("Over the dynamic reference: {}.", list(Known::Dynamic)), inner.iter().all(|v| r[0] < *v && *v < r[3])))
        }),
        Finding::judge("11", "8-node and 9-node elements deflect almost alike.", false, || {
            let apart = ratio(&SERENDIPITY, Known::Dynamic)? / ratio(&LAGRANGE, Known::Dynamic)? - 1.0;
            let mut seen = format!("With lumped mass they are {} apart.", percent(apart));
            let matrix = |e: &Element| tip_ratio(runs.done(&name(e, CONSISTENT, FORCE, CELL))?, Known::Dynamic, FORCE);
            if let (Some(a), Some(b)) = (matrix(&SERENDIPITY), matrix(&LAGRANGE)) {
                seen += &format!(" With consistent mass they are alike, to {:.1e}.", (a / b - 1.0).abs());
            }
            Some((seen, apart.abs() < 0.01))
        }),
        Finding::judge(
            "11",
            "The cubic splines are closest to the formula; linear and quadratic elements lie significantly below it.",
            false,
            || {
                let (formula, dynamic) = (paper(Known::Formula)?, paper(Known::Dynamic)?);
                let (first, second) = (nearest(&formula)?, nearest(&dynamic)?);
                let seen = format!(
                    "Over the formula: {}. None is below it, and closest is {}, by chance: the formula knows no motion. By the dynamic reference \
                     closest is {}.",
                    list(Known::Formula),
                    PAPER[first].name,
                    PAPER[second].name
                );
                Some((seen, PAPER[first] == &CUBIC))
            },
        ),
        Finding::judge("12", "F = 800: cubic splines follow the formula in its basic features.", true, || {
            let run = runs.done(&name(&CUBIC, LUMPED, LARGE, CELL))?;
            let (formula, dynamic) = (tip_ratio(run, Known::Formula, LARGE)?, tip_ratio(run, Known::Dynamic, LARGE)?);
            let usual = ratio(&CUBIC, Known::Dynamic)?;
            let shape = shape_error(run)?;
            let seen = format!(
                "The tip is {formula:.4} times as far down as by the formula, {dynamic:.4} times as by the dynamic reference ({usual:.4} with \
                 F = 100: it is linear); scaled to the same tip the axis is off by {} of it.",
                percent(shape)
            );
            Some((seen, shape < 0.05))
        }),
    ]
}

/// RMS difference of the shape of the axis from that of the formula, both scaled to 1 at the tip.
fn shape_error(run: &Run) -> Option<f64> {
    let (ours, formula) = (deflections(run)?, known(Known::Formula, LARGE));
    let tips = [ours.last()?[1], formula.last()?[1]];
    Some(rms(ours.iter().zip(&formula).map(|(a, b)| a[1] / tips[0] - b[1] / tips[1])))
}
