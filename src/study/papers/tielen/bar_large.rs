//! T2: the bar with 7 % strain, in which particles cross cells.

use super::{BAR, BSPLINE, LINEAR, Method, PROFILE, Profile, SPLINE_BAR, SPLINE_COLUMN};
use super::{chart, curves, known, largest, middle, percent, rms, stresses, times};
use crate::study::reference::Table as Known;
use crate::study::{Axis, Cell, Chart, Effort, Figure, Finding, Job, Panel, Run, Runs, Section, Series, Style, Table};

/// Time of the tables and the stress \[s\].
const END: f64 = 0.5;
/// Cells of the curves.
const CELLS: usize = 32;
/// Amplitude of the velocity \[m/s\].
const SPEED: f64 = 0.1;

/// Step of the tables \[s\]. That of the thesis, for the curves, is 1e-5 s.
const STEP: f64 = 1e-4;

const SPLINE_FORCE: Method = Method { key: "spline force", name: "splines for the force alone, lumped mass", ..SPLINE_COLUMN };
const LEAST_SQUARES: Method = Method {
    key: "least squares",
    name: "least squares, consistent mass (Wobbes et al. 2019)",
    toml: r#"
        basis = "bspline"
        mass = "consistent"
        quadrature = "least_squares"
        quadrature_of = "force_and_velocity""#,
    color: 3,
};
const RAW: Method = Method {
    key: "raw",
    name: "B-splines, consistent mass of the particles",
    toml: "basis = \"bspline\"\nmass = \"consistent\"",
    color: 4,
};
const GIMP: Method = Method { key: "gimp", name: "GIMP, uniform domains", toml: "basis = \"gimp\"\ndomain = \"uniform\"", color: 5 };
const CONTIGUOUS: Method =
    Method { key: "contiguous gimp", name: "GIMP, contiguous domains", toml: "basis = \"gimp\"\ndomain = \"contiguous\"", color: 5 };
const CUBIC: Method = Method { key: "cubic", name: "cubic splines (Andersen 2007)", toml: "basis = \"cubic\"", color: 6 };
const FMPM: Method = Method {
    key: "fmpm",
    name: "B-splines, FMPM(4) with PIC",
    toml: "basis = \"bspline\"\nmass = \"fmpm\"\nfmpm_order = 4\ntransfer = \"pic\"",
    color: 6,
};

/// The rows of the tables, with the numbers of a prototype in another language at [`TABLE_CELLS`] cells: displacement \[m\], stress
/// \[Pa\].
type Row = (&'static Method, Option<[[f64; 2]; 3]>);
const ROWS: [Row; 10] = [
    (&LINEAR, Some([[9.1e-4, 0.49], [4.5e-4, 0.47], [4.8e-4, 0.48]])),
    (&BSPLINE, Some([[6.1e-4, 0.29], [2.0e-4, 0.10], [5.2e-5, 0.03]])),
    (&SPLINE_BAR, Some([[5.3e-6, 1.1e-2], [7.0e-7, 2.7e-3], [1.9e-7, 6.4e-4]])),
    (&SPLINE_FORCE, None),
    (&LEAST_SQUARES, None),
    (&RAW, None),
    (&GIMP, None),
    (&CONTIGUOUS, None),
    (&CUBIC, None),
    (&FMPM, None),
];
const TABLE_CELLS: [usize; 3] = [8, 16, CELLS];

fn name(method: &Method, cells: usize) -> String {
    format!("T2/{}/{cells} cells", method.key)
}

fn curve_name(method: &Method) -> String {
    format!("T2/{}/curve", method.key)
}

/// End of the curves \[s\]: a period takes about 1.4 s.
fn curve_end(effort: Effort) -> f64 {
    effort.pick(END, 1.5)
}

fn scene(method: &Method, cells: usize, end: f64, step: f64) -> String {
    format!(
        r#"
        title = "Tielen 2016, vibrating bar, large deformations"
        dimension = 1
        grid = {{ origin = [0], size = [1], cell = {cell} }}
        material.rubber = {{ law = "hypo_elastic", young = 50, density = 25 }}
        boundary.left = {{ face = "x-", fixed = ["x"] }}
        boundary.right = {{ face = "x+", fixed = ["x"] }}
        probe.middle = {{ at = [{place}] }}
        time = {{ end = {end}, step = {step} }}
        [body.bar]
        material = "rubber"
        shape = {{ box = {{ min = [0], max = [1] }} }}
        particles_per_cell = 4
        velocity = ["{SPEED}*sin(PI*x)"]
        [method]
        integrator = "musl"
        {method}
        "#,
        cell = 1.0 / cells as f64,
        place = Known::bar_middle().place(),
        method = method.toml,
    )
}

/// The degree of freedom whose force is watched: that of the node in the middle, or the B-spline left of it.
const NODE: usize = CELLS / 2;

/// Where the function of that degree of freedom has knots \[m\]: -1 to 1 cells around its node, or -2 to 1 for the B-spline.
fn knots(method: &Method) -> impl Iterator<Item = f64> + use<> {
    let before = if method.key == LINEAR.key { 1 } else { 2 };
    (NODE - before..=NODE + 1).map(|knot| knot as f64 / CELLS as f64)
}

/// Step of the curves \[s\].
fn curve_step(effort: Effort) -> f64 {
    effort.pick(STEP, 1e-5)
}

pub(super) fn jobs(effort: Effort) -> Vec<Job> {
    let cases = ROWS.iter().flat_map(|(method, _)| TABLE_CELLS.map(|cells| (*method, cells)));
    let is_curve = |method: &Method, cells| cells == CELLS && curve_step(effort) == STEP && BAR.iter().any(|m| m.key == method.key);
    // the quick subset has what is not in the thesis on coarse grids, but for the warning that needs a fine one
    let is_extra = |method: &Method| !["linear", "bspline", "spline", "spline force", "raw"].contains(&method.key);
    let cases =
        cases.filter(|(method, cells)| !is_curve(method, *cells) && (effort == Effort::Full || *cells < CELLS || !is_extra(method)));
    let table = cases.map(|(method, cells)| Job::new(name(method, cells), scene(method, cells, END, STEP)).snapshot(END, PROFILE));
    let curve = |method| {
        let job = Job::new(curve_name(method), scene(method, CELLS, curve_end(effort), curve_step(effort)));
        watched(job.snapshot(END, PROFILE), method)
    };
    table.chain(BAR.map(curve)).collect()
}

/// Watches the middle particle, the force on a degree of freedom, and the particles left of each of its knots: where their number
/// changes, one has crossed.
fn watched(job: Job, method: &Method) -> Job {
    let job = middle(job.every(1e-3)).watch("force", |sim| sim.internal_force(NODE));
    knots(method).enumerate().fold(job, |job, (i, knot)| {
        job.watch(format!("left of knot {i}"), move |sim| Ok(sim.get("particle/position")?.iter().filter(|x| **x < knot).count() as f64))
    })
}

/// For each sample after the first: whether a particle crossed a knot since the one before.
fn crossed(run: &Run, method: &Method) -> Vec<bool> {
    let counts: Vec<&[f64]> = knots(method).enumerate().map(|(i, _)| run.samples(&format!("left of knot {i}"))).collect();
    (1..run.times.len()).map(|k| counts.iter().any(|c| c.get(k) != c.get(k - 1))).collect()
}

/// Mean change of the force from sample to sample, where a particle crossed a knot and where none did \[N\].
fn jumps(runs: &Runs, method: &Method) -> Option<[f64; 2]> {
    let run = runs.done(&curve_name(method))?;
    let crossed = crossed(run, method);
    let changes: Vec<f64> = run.samples("force").windows(2).map(|w| (w[1] - w[0]).abs()).collect();
    Some([true, false].map(|with| {
        let some: Vec<f64> = changes.iter().zip(&crossed).filter(|(_, c)| **c == with).map(|(d, _)| *d).collect();
        some.iter().sum::<f64>() / some.len() as f64
    }))
}

/// RMS error of the displacement \[m\] and the stress \[Pa\] at the end.
fn errors(runs: &Runs, method: &Method, cells: usize) -> Option<[f64; 2]> {
    // the quick curves have the step of the tables, and are not run twice
    let run = runs.done(&name(method, cells)).or_else(|| runs.done(&curve_name(method)).filter(|_| cells == CELLS))?;
    let profile = Profile::of(run, END)?;
    let exact = Known::bar();
    let at: Vec<_> = profile.start.iter().map(|&x| exact.over_place(END, x, 6)).collect();
    let displacement = rms(profile.displacement.iter().zip(&at).map(|(u, e)| u - e[0]));
    Some([displacement, rms(profile.stress.iter().zip(&at).map(|(s, e)| s - e[2]))])
}

pub(super) fn section(effort: Effort, runs: &Runs) -> Section {
    Section {
        title: "T2 Vibrating bar, large deformations (Tielen 2016, sections 5.1.2, 6.2.2, 7.2.2)".into(),
        text: format!(
            "Length 1 m, E = 50 Pa, density 25 kg/m3, v0 = {SPEED} sin(pi x/L) m/s, 4 particles a cell, step {STEP:e} s in the tables and \
             {:e} s in the curves. The strain reaches 7 %: particles cross cells. The reference is a spectral solution of the same equations, \
             not the finite elements of the thesis. The thesis has no table of this problem; the numbers beside ours are those of a prototype \
             of its algorithm, which was written for comparison and has two digits.",
            curve_step(effort)
        ),
        tables: [(0, "displacement [m]"), (1, "stress [Pa]")].map(|(kind, what)| table(runs, kind, what)).to_vec(),
        figures: figures(effort, runs),
        findings: findings(effort, runs),
        ..Section::default()
    }
}

fn table(runs: &Runs, kind: usize, what: &str) -> Table {
    let row = |(method, prototype): &Row| {
        let cell = |(i, &cells): (usize, &usize)| Cell {
            paper: prototype.map(|p| p[i][kind]),
            ours: errors(runs, method, cells).map(|e| e[kind]),
        };
        (method.name.to_owned(), TABLE_CELLS.iter().enumerate().map(cell).collect())
    };
    Table {
        title: format!("RMS error of the {what} at {END} s"),
        header: ["method".to_owned()].into_iter().chain(TABLE_CELLS.map(|cells| format!("{cells} cells"))).collect(),
        rows: ROWS.iter().map(row).collect(),
        beside: "prototype",
        band: None,
    }
}

fn figures(effort: Effort, runs: &Runs) -> Vec<Figure> {
    let (middle, bar) = (Known::bar_middle(), Known::bar());
    let place = middle.place();
    let motion = |name: &'static str, column: usize, offset: f64| {
        let exact = middle.curve(column, curve_end(effort)).into_iter().map(|[t, v]| [t, offset + v]);
        curves(runs, &BAR, curve_name, name).chain([Series::new("spectral reference", Style::Reference, exact)]).collect::<Vec<_>>()
    };
    let exact = known(0.0, 1.0, 200, |x| bar.over_place(END, x, 6)[2]);
    let stress = stresses(runs, &BAR, curve_name, END).chain([Series::new("spectral reference", Style::Reference, exact)]);
    let force = |method: &&Method| {
        let run = runs.get(&curve_name(method));
        let pulses = |run: &Run| run.times.iter().skip(1).zip(crossed(run, method)).filter(|(_, c)| *c).map(|(t, _)| [*t, 0.0]).collect();
        let pulses: Vec<[f64; 2]> = run.map(pulses).unwrap_or_default();
        let series = vec![
            Series::new("a particle crosses a knot of the function", Style::Pulses, pulses).color(4),
            Series::new(method.name, Style::Line, run.map_or_else(Vec::new, |run| run.curve("force"))).color(method.color),
        ];
        Panel { y: Axis::new("internal force", "N"), series }
    };
    let shown = BAR.iter().filter(|m| runs.get(&curve_name(m)).is_some());
    vec![
        chart(
            "t2-motion",
            "Figures 5.8, 6.7, 7.9 (position) and 5.9, 6.8, 7.10 (velocity) of the particle left of the middle, 32 cells",
            Chart::stacked(
                "T2: particle left of the middle, 32 cells",
                Axis::new("time", "s"),
                [
                    Panel { y: Axis::new("position", "m"), series: motion("position", 0, place) },
                    Panel { y: Axis::new("velocity", "m/s"), series: motion("velocity", 1, 0.0) },
                ],
            ),
        ),
        chart(
            "t2-stress",
            "Figures 5.10, 6.9, 7.11: stress over the bar at 0.5 s, 32 cells",
            Chart::new("T2: stress at t = 0.5 s, 32 cells", Axis::new("position at time 0", "m"), Axis::new("stress", "Pa"), stress),
        ),
        chart(
            "t2-force",
            "Figures 5.11, 6.10, 7.12: internal force at the degree of freedom in the middle, with a mark where a particle crosses a knot",
            Chart::stacked("T2: internal force at one degree of freedom, 32 cells", Axis::new("time", "s"), shown.map(force)),
        ),
    ]
}

/// RMS error of the position over the largest displacement, and of the velocity over its amplitude.
fn motion_errors(runs: &Runs, method: &Method) -> Option<[f64; 2]> {
    let (run, exact) = (runs.done(&curve_name(method))?, Known::bar_middle());
    let reach = largest(exact.curve(0, f64::INFINITY).into_iter().map(|p| p[1]));
    let error = |name, column, offset| rms(exact.errors(run, name, column, offset).into_iter().map(|e| e[1]));
    Some([error("position", 0, exact.place()) / reach, error("velocity", 1, 0.0) / SPEED])
}

/// RMS error of the stress over the largest stress at the end.
fn stress_error(runs: &Runs, method: &Method) -> Option<f64> {
    let known = Known::bar();
    let top = largest((0..=100).map(|i| known.over_place(END, i as f64 / 100.0, 6)[2]));
    Some(errors(runs, method, CELLS)?[1] / top)
}

fn findings(effort: Effort, runs: &Runs) -> Vec<Finding> {
    let [_, before, last] = TABLE_CELLS;
    let force = |method: &Method, disturbed: bool| {
        let [with, without] = jumps(runs, method)?;
        let seen = format!(
            "From one sample to the next (1 ms) the force changes by {with:.2e} N where a particle crosses and by {without:.2e} N where none does: {}.",
            times(with / without)
        );
        Some((seen, (with > 3.0 * without) == disturbed))
    };
    let motion = |method: &Method, good: bool| {
        let [position, velocity] = motion_errors(runs, method)?;
        let seen = format!(
            "RMS errors over {} s: position {} of the way, velocity {} of its amplitude.",
            curve_end(effort),
            percent(position),
            percent(velocity)
        );
        Some((seen, (velocity < 0.02) == good))
    };
    vec![
        Finding::judge(
            "5.8, 5.9",
            "Linear functions: position and velocity are as the reference at first, then crossing spoils them.",
            true,
            || motion(&LINEAR, false),
        ),
        Finding::judge("5.8, 5.9", "Linear functions: more degrees of freedom do not improve the solution.", true, || {
            let (coarse, fine) = (errors(runs, &LINEAR, before)?, errors(runs, &LINEAR, last)?);
            let seen = format!(
                "From {before} to {last} cells the error of the displacement goes from {:.2e} to {:.2e} m, that of the stress from {:.2} to {:.2} Pa.",
                coarse[0], fine[0], coarse[1], fine[1]
            );
            // twice the cells would give a quarter of the error at order 2
            Some((seen, fine[0] > 0.7 * coarse[0] && fine[1] > 0.7 * coarse[1]))
        }),
        Finding::judge("5.10", "Linear functions: the stress oscillates severely.", true, || {
            let error = stress_error(runs, &LINEAR)?;
            Some((format!("Its RMS error is {} of the largest stress.", percent(error)), error > 0.1))
        }),
        Finding::judge("5.11", "Linear functions: the internal force jumps whenever a particle crosses.", true, || force(&LINEAR, true)),
        Finding::judge("6.7, 6.8", "B-splines: position and velocity correspond well to the reference.", true, || motion(&BSPLINE, true)),
        Finding::judge("6.9", "B-splines: the stress is much better than with linear functions, but still oscillates.", true, || {
            let (linear, spline) = (stress_error(runs, &LINEAR)?, stress_error(runs, &BSPLINE)?);
            let seen = format!("Its RMS error is {} of the largest stress, with linear functions {}.", percent(spline), percent(linear));
            Some((seen, spline < 0.3 * linear && spline > 0.002))
        }),
        Finding::judge("6.10", "B-splines: crossing does not show in the internal force.", true, || force(&BSPLINE, false)),
        Finding::judge("7.9, 7.10", "The spline-based method: position and velocity as good as with B-splines.", true, || {
            motion(&SPLINE_BAR, true)
        }),
        Finding::judge("7.11", "The spline-based method: the stress hardly oscillates.", true, || {
            let (bspline, spline) = (stress_error(runs, &BSPLINE)?, stress_error(runs, &SPLINE_BAR)?);
            let seen = format!("Its RMS error is {} of the largest stress, with B-splines {}.", percent(spline), percent(bspline));
            Some((seen, spline < 0.2 * bspline))
        }),
        Finding::judge("7.12", "The spline-based method: crossing does not show in the internal force.", true, || {
            force(&SPLINE_BAR, false)
        }),
        Finding::judge(
            "none",
            "The spline-based method at 32 cells and a step of 1e-4 s: displacement within 2e-7 m, stress within 7e-4 Pa.",
            true,
            || {
                let [displacement, stress] = errors(runs, &SPLINE_BAR, CELLS)?;
                Some((format!("RMS errors {displacement:.2e} m and {stress:.2e} Pa."), displacement <= 2e-7 && stress <= 7e-4))
            },
        ),
        Finding::judge("text of section 7.2.2", "Consistent mass and splines are both needed for a good stress.", true, || {
            let (both, force, mass) =
                (errors(runs, &SPLINE_BAR, CELLS)?[1], errors(runs, &SPLINE_FORCE, CELLS)?[1], errors(runs, &RAW, CELLS)?[1]);
            let seen = format!(
                "RMS error of the stress at {CELLS} cells: both {both:.2e} Pa, splines for the force alone with lumped mass {force:.2e} Pa, consistent mass of the particles {mass:.2e} Pa."
            );
            Some((seen, both < 0.2 * force && both < 0.2 * mass))
        }),
        Finding::judge("none", "The consistent mass of the particles alone makes the stress stall.", true, || {
            let [coarse, .., fine] = TABLE_CELLS.map(|cells| errors(runs, &RAW, cells));
            let (coarse, fine) = (coarse?, fine?);
            let seen = format!(
                "From {} to {CELLS} cells its error falls from {:.2e} to {:.2e} Pa, that of the displacement from {:.2e} to {:.2e} m.",
                TABLE_CELLS[0], coarse[1], fine[1], coarse[0], fine[0]
            );
            Some((seen, fine[1] > 0.5 * coarse[1]))
        }),
        Finding::judge("none", "Methods that the thesis does not have converge too.", true, || {
            let rest = ROWS.iter().map(|(method, _)| *method).skip(4).filter(|method| method.key != RAW.key);
            let pairs = rest.map(|method| {
                let [coarse, fine] = [TABLE_CELLS[0], before].map(|cells| errors(runs, method, cells));
                Some((method.name, (coarse?[0] / fine?[0]).log2(), (coarse?[1] / fine?[1]).log2()))
            });
            let list: Vec<(&str, f64, f64)> = pairs.collect::<Option<_>>()?;
            let text: Vec<String> = list.iter().map(|(name, u, s)| format!("{name}: {u:.1} and {s:.1}")).collect();
            let seen = format!("Orders of displacement and stress from {} to {before} cells: {}.", TABLE_CELLS[0], text.join("; "));
            Some((seen, list.iter().all(|(_, u, s)| *u > 0.7 && *s > 0.4)))
        }),
    ]
}
