//! The rest of a cantilever under a tip load: by one quasi-static solve, and by a load that an explicit run applies so slowly that the beam
//! hardly swings.

use super::{kept, tabulate};
use crate::study::tools::{chart, largest, percent, small, times};
use crate::study::{Axis, Chart, Effort, Finding, Job, Panel, Run, Runs, Section, Series, Style};

/// For how long the full load is held \[s\]: a little more than the first period, 23.1 s.
const HELD: f64 = 24.0;

/// An explicit method.
struct Explicit {
    name: &'static str,
    body: &'static str,
    grid: &'static str,
    method: &'static str,
    cfl: f64,
    color: usize,
}

const TOTAL: Explicit = Explicit {
    name: "total Lagrangian, degree 3, Verlet",
    body: "",
    grid: "origin = [0, 0], size = [8, 1]",
    method: r#"formulation = "total", degree = 3"#,
    cfl: 0.8,
    color: 0,
};
const UPDATED: Explicit = Explicit {
    name: "updated Lagrangian, degree 2, MUSL",
    body: ", particles_per_cell = 3",
    grid: "origin = [0, -1], size = [9, 3]",
    method: "degree = 2",
    cfl: 0.4,
    color: 1,
};
const EXPLICIT: [Explicit; 2] = [TOTAL, UPDATED];

/// Degree and cells over the height of quasi-static solves; the last is taken for exact.
fn meshes(effort: Effort) -> &'static [(usize, usize)] {
    effort.pick(&[(3, 2), (3, 4)], &[(2, 2), (3, 1), (3, 2), (3, 4), (3, 12)])
}

/// The mesh of the explicit total Lagrangian.
const SAME: (usize, usize) = (3, 2);

/// In how many seconds the load grows.
fn ramps(effort: Effort) -> &'static [f64] {
    effort.pick(&[20.0, 60.0], &[20.0, 100.0, 400.0, 1600.0])
}

fn solve_name((degree, cells): (usize, usize)) -> String {
    format!("saved/degree {degree}, {cells} cells over the height")
}

fn ramp_name(method: &Explicit, ramp: f64) -> String {
    format!("saved/{}, {ramp} s", method.name)
}

/// The cantilever of A2 (Andersen 2007) under its last force, F / 288 with F = 100 N, that grows to its full size in `ramp` seconds. It is
/// spread over the end: no mesh of Gauss points has one where the particle of the paper is.
fn scene(cell: f64, grid: &str, body: &str, method: &str, ramp: f64, time: &str) -> String {
    format!(
        r#"
        title = "Andersen 2007, cantilever"
        dimension = 2
        plane = "strain"
        grid = {{ {grid}, cell = {cell} }}
        material.steel = {{ law = "neo_hookean", young = 3e5, poisson = 0, density = 1e3 }}
        body.beam = {{ material = "steel", shape = {{ box = {{ min = [0, 0], max = [8, 1] }} }}{body} }}
        boundary.wall = {{ face = "x-", fixed = ["x", "y"] }}
        load.tip.traction = {{ body = "beam", face = "x+", value = [0, "-100/288*min(t/{ramp}, 1)"] }}
        probe.tip = {{ at = [8, 0.5] }}
        method = {{ {method} }}
        time = {{ {time} }}
        "#
    )
}

pub(super) fn jobs(effort: Effort) -> Vec<Job> {
    let down = |sim: &mut crate::Simulation| Ok(-sim.get("probe/tip/displacement")?[1]);
    let solve = |&mesh: &(usize, usize)| {
        let method = format!(r#"formulation = "total", degree = {}, integrator = "quasi_static""#, mesh.0);
        let text = scene(1.0 / mesh.1 as f64, TOTAL.grid, "", &method, 1.0, "end = 1.0, step = 1.0");
        Job::new(solve_name(mesh), text).alone().keep(1.0, "tip", move |sim| Ok(vec![down(sim)?]))
    };
    let ramp = |method: &Explicit, ramp: f64| {
        let time = format!("end = {}, cfl = {}", ramp + HELD, method.cfl);
        let text = scene(0.5, method.grid, method.body, method.method, ramp, &time);
        Job::new(ramp_name(method, ramp), text).alone().every(1.0).watch("tip", down)
    };
    let ramps = EXPLICIT.iter().flat_map(|method| ramps(effort).iter().map(move |&seconds| ramp(method, seconds)));
    meshes(effort).iter().map(solve).chain(ramps).collect()
}

/// Deflection of the tip at rest on the finest mesh \[m\].
fn exact(effort: Effort, runs: &Runs) -> Option<f64> {
    kept(runs.done(&solve_name(*meshes(effort).last()?)), 1.0, "tip")
}

/// Error of a solve over the exact deflection.
fn solve_error(effort: Effort, runs: &Runs, mesh: (usize, usize)) -> Option<f64> {
    Some((kept(runs.done(&solve_name(mesh)), 1.0, "tip")? / exact(effort, runs)? - 1.0).abs())
}

/// Largest error while the full load is held, over the exact deflection.
fn ramp_error(effort: Effort, runs: &Runs, method: &Explicit, ramp: f64) -> Option<f64> {
    let exact = exact(effort, runs)?;
    let held = runs.done(&ramp_name(method, ramp))?.curve("tip").into_iter().filter(|p| p[0] >= ramp - 1e-6);
    Some(largest(held.map(|p| p[1] / exact - 1.0)))
}

pub(super) fn section(effort: Effort, runs: &Runs) -> Section {
    let get = |name: String| runs.done(&name);
    let cost = |run: Option<&Run>, error: Option<f64>| vec![run.map(|r| r.substeps as f64), run.map(|r| r.wall), error];
    let solves = meshes(effort).iter().map(|&mesh| {
        let title = format!("quasi-static, degree {}, {} cells over the height", mesh.0, mesh.1);
        (title, cost(get(solve_name(mesh)), solve_error(effort, runs, mesh)))
    });
    let slow = EXPLICIT
        .iter()
        .flat_map(|m| ramps(effort).iter().map(move |&ramp| (m, ramp)))
        .map(|(m, ramp)| (format!("{}, {ramp} s", m.name), cost(get(ramp_name(m, ramp)), ramp_error(effort, runs, m, ramp))));
    let table = tabulate(
        "The tip at rest: cost and largest error over the deflection",
        &["method, time in which the load grows", "steps", "wall time [s]", "error"],
        solves.chain(slow),
        |row| row,
    );
    let at = |run: Option<&Run>, error: Option<f64>| Some([run?.wall, error?]);
    let coarser = &meshes(effort)[..meshes(effort).len() - 1];
    let solves = coarser.iter().filter_map(|&mesh| at(get(solve_name(mesh)), solve_error(effort, runs, mesh)));
    let solves = Series::new("quasi-static, one step", Style::Markers, solves).color(2);
    let ramped = EXPLICIT.iter().map(|m| {
        let points = ramps(effort).iter().filter_map(|&ramp| at(get(ramp_name(m, ramp)), ramp_error(effort, runs, m, ramp)));
        Series::new(m.name, Style::Joined, points).color(m.color)
    });
    let work = Chart::new(
        "The tip at rest: error over wall time",
        Axis::new("wall time [s]", "").log(),
        Axis::new("largest error / deflection", "").log(),
        ramped.chain([solves]),
    );
    let exact_line =
        |end: f64| Series::new("at rest", Style::Reference, exact(effort, runs).into_iter().flat_map(|u| [[0.0, u], [end, u]]));
    let shown = ramps(effort).iter().filter(|&&ramp| ramp <= 400.0);
    let panels = shown.map(|&ramp| {
        let curves =
            EXPLICIT.iter().filter_map(|m| Some(Series::new(m.name, Style::Line, get(ramp_name(m, ramp))?.curve("tip")).color(m.color)));
        Panel { y: Axis::new(format!("deflection, {ramp} s"), "m"), series: curves.chain([exact_line(ramp + HELD)]).collect() }
    });
    let motion =
        Chart::stacked("Deflection of the tip under loads that grow in so many seconds, and are then held", Axis::new("time", "s"), panels);
    let finding = Finding::judge(
        "wall time",
        "One quasi-static solve is closer than every explicit ramp, and at least ten times as fast as the closest.",
        true,
        || {
            let (wall, error) = (get(solve_name(SAME))?.wall, solve_error(effort, runs, SAME)?);
            let slow = EXPLICIT.iter().flat_map(|m| ramps(effort).iter().map(move |&ramp| (m, ramp)));
            let slow = slow.map(|(m, ramp)| Some((m, ramp, get(ramp_name(m, ramp))?.wall, ramp_error(effort, runs, m, ramp)?)));
            let slow = slow.collect::<Option<Vec<_>>>()?;
            let best = slow.iter().min_by(|a, b| a.3.total_cmp(&b.3))?;
            let seen = format!(
                "Degree 3, 2 cells over the height: {:.1} ms, error {}. The closest ramp ({}, {} s) takes {:.2} s, {} as long, with an error of {}.",
                1e3 * wall,
                small(error),
                best.0.name,
                best.1,
                best.2,
                times(best.2 / wall),
                percent(best.3)
            );
            Some((seen, best.3 > error && best.2 > 10.0 * wall))
        },
    );
    Section {
        title: "A static answer by one solve, and by explicit steps".into(),
        text: format!(
            "The cantilever of A2 at rest under its last force, 100 / 288 N, as a dead traction on the whole end, which all meshes have in the \
             same place; deflection at x = 8 m, y = 0.5 m. Strains are below 1e-4: the law does not matter, and is neo-Hookean. Quasi-static in one step; or explicit with cells of \
             0.5 m, the load growing in a straight line and then held for {HELD} s, a little more than the period of 23.1 s: nothing damps, \
             so what swings goes on swinging, by about the period over pi times the time of growth. Errors are against the quasi-static \
             answer on the finest mesh, degree {} with {} cells over the height; those of explicit runs are the largest while the load is held.",
            meshes(effort)[meshes(effort).len() - 1].0,
            meshes(effort)[meshes(effort).len() - 1].1
        ),
        tables: vec![table],
        figures: vec![
            chart("saved", "The tip at rest: error over wall time", work),
            chart("saved-motion", "Deflection of the tip under loads that grow in a straight line and are then held", motion),
        ],
        findings: vec![finding],
        ..Section::default()
    }
}
