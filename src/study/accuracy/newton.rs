//! Newton's method: how fast it converges, and what a large system takes.

use super::tabulate;
use crate::study::tools::chart;
use crate::study::{Axis, Chart, Effort, Finding, Job, Runs, Section, Series, Style};

/// A static problem, solved in one step of 1 s.
struct Case {
    name: &'static str,
    scene: &'static str,
}

const CASES: [Case; 4] = [
    Case {
        name: "beam under a dead load",
        scene: r#"
            title = "bent by a dead load"
            dimension = 2
            grid = { origin = [0, 0], size = [10, 1], cell = 0.25 }
            material.m = { law = "neo_hookean", young = 12e6, poisson = 0.0, density = 1000.0 }
            body.beam = { material = "m", shape = { box = { min = [0, 0], max = [10, 1] } } }
            boundary.root = { face = "x-", fixed = ["x", "y"] }
            load.tip.traction = { body = "beam", face = "x+", value = [0, "1e4*t"] }
            method = { formulation = "total", degree = 3, integrator = "quasi_static", newton_residual = 1e-12 }
            time = { end = 1.0, step = 1.0 }"#,
    },
    Case {
        name: "beam under a follower pressure",
        scene: r#"
            title = "bent by pressure"
            dimension = 2
            grid = { origin = [0, -2], size = [6, 4], cell = 0.5 }
            material.m = { law = "neo_hookean", young = 1e4, poisson = 0.3, density = 1000.0 }
            body.beam = { material = "m", shape = { box = { min = [0, -0.5], max = [5, 0.5] } } }
            boundary.root = { face = "x-", fixed = ["x", "y"] }
            load.top.pressure = { body = "beam", face = "y+", value = ["5*t"] }
            method = { formulation = "total", integrator = "quasi_static", newton_residual = 1e-12 }
            time = { end = 1.0, step = 1.0 }"#,
    },
    Case {
        name: "the same, updated Lagrangian",
        scene: r#"
            title = "bent by pressure"
            dimension = 2
            grid = { origin = [0, -2], size = [6, 4], cell = 0.5 }
            material.m = { law = "neo_hookean", young = 1e4, poisson = 0.3, density = 1000.0 }
            body.beam = { material = "m", shape = { box = { min = [0, -0.5], max = [5, 0.5] } } }
            boundary.root = { face = "x-", fixed = ["x", "y"] }
            load.top.pressure = { body = "beam", face = "y+", value = ["5*t"] }
            method = { integrator = "quasi_static", newton_residual = 1e-12 }
            time = { end = 1.0, step = 1.0 }"#,
    },
    Case {
        name: "Cook's membrane, nu = 0.4999, mean dilatation",
        scene: r#"
            title = "Cook's membrane"
            dimension = 2
            grid = { origin = [0, 0], size = [57.6, 60], cell = [3.6, 1.875] }
            material.m = { law = "neo_hookean", young = 1.0, poisson = 0.4999, density = 1.0 }
            body.membrane = { material = "m", shape = { polygon = { points = [[0, 0], [48, 44], [48, 60], [0, 44]] } } }
            boundary.root = { region = { box = { min = [-1, -1], max = [0, 45] } }, fixed = ["x", "y"] }
            load.shear.traction = { body = "membrane", face = "edge2", value = [0, "0.1*t/16"] }
            method = { formulation = "total", integrator = "quasi_static", mean_dilatation = true, newton_residual = 1e-12 }
            time = { end = 1.0, step = 1.0 }"#,
    },
];

/// A beam of many degrees of freedom: ten times as long as high (and wide).
struct Large {
    dimension: usize,
    /// Cells over the height.
    cells: usize,
    degree: usize,
    solver: &'static str,
}

const PLANE: Large = Large { dimension: 2, cells: 70, degree: 3, solver: "direct" };
const SOLID: Large = Large { dimension: 3, cells: 14, degree: 2, solver: "iterative" };
const LARGE: [Large; 3] = [PLANE, Large { solver: "iterative", ..PLANE }, SOLID];
const SMALL: [Large; 2] = [Large { cells: 10, ..PLANE }, Large { cells: 3, ..SOLID }];

impl Large {
    fn name(&self) -> String {
        format!("newton/{}D, {} cells, {}", self.dimension, self.cells, self.solver)
    }

    /// Components of the displacement at all nodes; those at the root are given.
    fn unknowns(&self) -> usize {
        let across = self.cells + self.degree;
        self.dimension * (10 * self.cells + self.degree) * across.pow(self.dimension as u32 - 1)
    }

    fn job(&self) -> Job {
        let each = |of: &dyn Fn(usize) -> String| (0..self.dimension).map(of).collect::<Vec<_>>().join(", ");
        let scene = format!(
            r#"
            title = "a large beam under a dead tip load"
            dimension = {dimension}
            grid = {{ origin = [{zeros}], size = [{size}], cell = {cell} }}
            material.rubber = {{ law = "neo_hookean", young = 12e6, poisson = 0.0, density = 1000.0 }}
            body.beam = {{ material = "rubber", shape = {{ box = {{ min = [{zeros}], max = [{size}] }} }} }}
            boundary.root = {{ face = "x-", fixed = [{axes}] }}
            load.tip.traction = {{ body = "beam", face = "x+", value = [{load}] }}
            probe.tip = {{ at = [{tip}] }}
            method = {{ formulation = "total", degree = {degree}, integrator = "quasi_static", linear_solver = "{solver}" }}
            time = {{ end = 1.0, step = 1.0 }}
            "#,
            dimension = self.dimension,
            zeros = each(&|_| "0".into()),
            size = each(&|a| if a == 0 { "10".into() } else { "1".into() }),
            axes = each(&|a| format!("\"{}\"", ["x", "y", "z"][a])),
            load = each(&|a| if a == 1 { "\"1e4*t\"".into() } else { "0".into() }),
            tip = each(&|a| if a == 0 { "10".into() } else { "0.5".into() }),
            cell = 1.0 / self.cells as f64,
            degree = self.degree,
            solver = self.solver,
        );
        Job::new(self.name(), scene).alone().snapshot(1.0, ["probe/tip/displacement"])
    }
}

fn large(effort: Effort) -> &'static [Large] {
    effort.pick(&SMALL, &LARGE)
}

fn name(case: &Case) -> String {
    format!("newton/{}", case.name)
}

pub(super) fn jobs(effort: Effort) -> Vec<Job> {
    let residuals = |sim: &mut crate::Simulation| Ok(sim.residuals().to_vec());
    let small = CASES.iter().map(|case| Job::new(name(case), case.scene).keep(1.0, "residuals", residuals));
    small.chain(large(effort).iter().map(Large::job)).collect()
}

fn residuals<'a>(runs: &'a Runs, case: &Case) -> Option<&'a [f64]> {
    runs.done(&name(case))?.at(1.0, "residuals")
}

/// Below this, round-off is as large as the residual.
const ROUND_OFF: f64 = 1e-13;

/// Residuals before and after each of the last iterations: those that begin below 1e-2 and do not end in round-off.
fn last(residuals: &[f64]) -> Vec<[f64; 2]> {
    residuals.windows(2).filter(|r| r[0] < 1e-2 && r[1] > ROUND_OFF).map(|r| [r[0], r[1]]).collect()
}

/// By how much an iteration multiplies the digits of the residual: r' = c r^2 doubles them, less those of c.
fn growth([before, after]: [f64; 2]) -> f64 {
    after.ln() / before.ln()
}

pub(super) fn section(effort: Effort, runs: &Runs) -> Section {
    let longest = CASES.iter().filter_map(|case| Some(residuals(runs, case)?.len())).max().unwrap_or(0);
    let header: Vec<&str> = ["iteration"].into_iter().chain(CASES.iter().map(|case| case.name)).collect();
    let table = tabulate("Forces out of balance over those in balance, before each iteration and at the end", &header, 0..longest, |k| {
        (k.to_string(), CASES.iter().map(|case| residuals(runs, case)?.get(k).copied()).collect())
    });
    let series = CASES.iter().filter_map(|case| {
        let points = residuals(runs, case)?.iter().enumerate().map(|(k, r)| [k as f64, *r]);
        Some(Series::new(case.name, Style::Joined, points))
    });
    let figure = chart(
        "newton",
        "Newton's method: forces out of balance by iteration",
        Chart::new(
            "Newton's method: forces out of balance over those in balance",
            Axis::new("iteration", ""),
            Axis::new("relative residual", "").log(),
            series,
        ),
    );
    let pairs = CASES.iter().filter_map(|case| {
        let pairs = residuals(runs, case)?.windows(2).map(|r| [r[0], r[1]]).filter(|r| r[0] < 0.1 && r[1] > ROUND_OFF);
        Some(Series::new(case.name, Style::Joined, pairs))
    });
    let square = |name, factor: f64| Series::new(name, Style::Reference, [1e-7, 0.1].map(|r: f64| [r, factor * r * r]));
    let pairs = chart(
        "newton-order",
        "Newton's method: the residual after an iteration over that before it",
        Chart::new(
            "Newton's method: the residual after an iteration over that before it",
            Axis::new("relative residual before", "").log(),
            Axis::new("relative residual after", "").log(),
            pairs.chain([square("its square", 1.0), square("a hundred times its square", 100.0)]),
        ),
    );
    let beams = tabulate(
        "Large beams under P L^2 / E I = 1, one step (in 3D of a square section)",
        &["beam", "degrees of freedom", "iterations", "wall time [s]", "tip across / L"],
        large(effort),
        |beam| {
            let run = runs.done(&beam.name());
            let title = format!("{}D, degree {}, {} cells over the height, {}", beam.dimension, beam.degree, beam.cells, beam.solver);
            let tip = run.and_then(|r| Some(r.at(1.0, "probe/tip/displacement")?[1] / 10.0));
            (title, vec![Some(beam.unknowns() as f64), run.map(|r| r.iterations as f64), run.map(|r| r.wall), tip])
        },
    );
    Section {
        title: "Newton's method".into(),
        text: "Each problem is solved in one step from the body at rest, to a residual of 1e-12, or until a correction \
               is round-off. Where the stiffness is the true derivative of \
               the forces, loads that follow the body included, the digits of the residual double. Below, beams ten times as long as high."
            .into(),
        tables: vec![table, beams],
        figures: vec![figure, pairs],
        findings: findings(effort, runs),
        ..Section::default()
    }
}

fn findings(effort: Effort, runs: &Runs) -> Vec<Finding> {
    let quadratic = CASES.iter().map(|case| {
        let claim = "Quadratic in the last iterations: each multiplies the digits of the residual by more than 1.6, until round-off.";
        Finding::judge(case.name, claim, true, || {
            let last = last(residuals(runs, case)?);
            let digits = |r: f64| format!("{:.1}", -r.log10());
            let list: Vec<String> = last.iter().take(1).map(|r| digits(r[0])).chain(last.iter().map(|r| digits(r[1]))).collect();
            Some((format!("Digits: {}.", list.join(", ")), !last.is_empty() && last.iter().all(|r| growth(*r) > 1.6)))
        })
    });
    let time = (effort == Effort::Full).then(|| {
        let claim = "A static plane beam of 1e5 degrees of freedom takes less than 60 s on this machine.";
        Finding::judge("large beam", claim, true, || {
            let run = runs.done(&PLANE.name())?;
            let seen = format!("{} degrees of freedom: {:.1} s, {} iterations.", PLANE.unknowns(), run.wall, run.iterations);
            Some((seen, PLANE.unknowns() >= 100_000 && run.wall < 60.0))
        })
    });
    quadratic.chain(time).collect()
}
