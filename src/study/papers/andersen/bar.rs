//! A1: a free bar swings along its axis. Where does the energy go?

use super::{ALL, BSPLINE, CONSISTENT, CUBIC, Element, GIMP, LAGRANGE, LINEAR, LUMPED, PAPER, SERENDIPITY};
use super::{chart, drift, each, energies, largest, negative_mass, percent, small, table};
use crate::study::{Axis, Cell, Chart, Effort, Figure, Finding, Job, Panel, Run, Runs, Section, Series, Style, Table};
use std::f64::consts::PI;

/// First period of the free plane-strain rectangle \[s\], by a Ritz expansion in Legendre polynomials.
const PERIOD: f64 = 3.026_077;
/// Speed at the ends at time 0 \[m/s\].
const AMPLITUDE: f64 = 0.01;
/// Amplitudes that the interpolation error of the consistent mass is followed over \[m/s\].
const AMPLITUDES: [f64; 4] = [1e-2, 1e-3, 1e-4, 1e-5];
/// An amplitude with which the sign of nodal masses changes for 9-node elements \[m/s\].
const LARGE: f64 = 1.0;
/// Elements that have a consistent mass matrix.
const MATRIX: [&Element; 5] = [&LINEAR, &SERENDIPITY, &LAGRANGE, &CUBIC, &BSPLINE];

fn end(effort: Effort) -> f64 {
    effort.pick(5.5, 8.0)
}

fn name(element: &Element, mass: &str) -> String {
    format!("A1/{}/{mass}", element.key)
}

fn amplitude_name(element: &Element, amplitude: f64) -> String {
    format!("A1/{}/consistent, {amplitude} m per s", element.key)
}

fn large_name(element: &Element) -> String {
    format!("A1/{}/large amplitude", element.key)
}

fn scene(element: &Element, mass: &str, amplitude: f64, end: f64) -> String {
    // room above and below for a bar that gets thick
    let (bottom, height) = if amplitude < LARGE { (0, 1) } else { (-1, 3) };
    format!(
        r#"
        title = "Andersen 2007, free vibration of a bar"
        dimension = 2
        plane = "strain"
        grid = {{ origin = [-1, {bottom}], size = [7, {height}], cell = 0.5 }}
        material.steel = {{ law = "hypo_elastic", young = 1e4, poisson = 0.3, density = 1e3 }}
        time = {{ end = {end}, step = 0.003 }}
        [body.bar]
        material = "steel"
        shape = {{ box = {{ min = [0, 0], max = [5, 1] }} }}
        particles_per_cell = 3
        velocity = ["{amplitude}*cos(PI*x/5)", 0]
        [method]
        basis = "{basis}"
        mass = "{mass}"
        integrator = "usf"
        "#,
        basis = element.basis,
    )
}

pub(super) fn jobs(effort: Effort) -> Vec<Job> {
    let every = effort.pick(0.024, 0.003);
    let long = |name: String, scene: String| energies(Job::new(name, scene)).every(every);
    // momentum in the first mode; higher modes hold less than 1 %
    let mode = |job: Job| {
        job.watch("mode", |sim| {
            let moved = sim.get("particle/displacement")?.to_vec();
            let start: Vec<f64> = sim.get("particle/position")?.iter().zip(moved).map(|(x, u)| x - u).collect();
            let velocity = sim.get("particle/velocity")?;
            Ok(velocity.chunks_exact(2).zip(start.chunks_exact(2)).map(|(v, x)| v[0] * (PI * x[0] / 5.0).cos()).sum())
        })
    };
    let mut jobs = Vec::new();
    for element in ALL {
        jobs.push(mode(long(name(element, LUMPED), scene(element, LUMPED, AMPLITUDE, end(effort)))));
    }
    if effort == Effort::Full {
        for element in MATRIX {
            jobs.push(mode(long(name(element, CONSISTENT), scene(element, CONSISTENT, AMPLITUDE, end(effort)))));
        }
    }
    for element in [&LINEAR, &LAGRANGE] {
        for amplitude in AMPLITUDES {
            // the residual must not hide what is looked for
            let scene = format!("{}mass_residual = 1e-14\n", scene(element, CONSISTENT, amplitude, effort.pick(1.5, end(effort))));
            jobs.push(energies(Job::new(amplitude_name(element, amplitude), scene)).every(0.024));
        }
    }
    for element in PAPER {
        jobs.push(energies(Job::new(large_name(element), scene(element, LUMPED, LARGE, end(effort)))).every(0.024));
    }
    jobs
}

/// First period \[s\]: from a quarter to five quarters of it the momentum in the mode crosses zero three times.
fn period(run: &Run) -> Option<f64> {
    let curve = run.curve("mode");
    let crossing = |w: &[[f64; 2]]| {
        let [[t0, a], [t1, b]] = [w[0], w[1]];
        (a * b < 0.0).then(|| t0 + (t1 - t0) * a / (a - b))
    };
    let crossings: Vec<f64> = curve.windows(2).filter_map(crossing).collect();
    Some(crossings.get(2)? - crossings.first()?)
}

/// Largest interpolation error, over the energy.
fn interpolation(run: &Run) -> Option<f64> {
    Some(largest(run.samples("interpolation_error").iter().copied()) / run.samples("total").first()?)
}

/// How often the kinetic energy turns around by more than 2 % of the energy: twice in half a period, where the motion is smooth.
fn turns(run: &Run) -> Option<usize> {
    let least = 0.02 * run.samples("total").first()?;
    let (mut count, mut up, mut extreme) = (0, false, f64::INFINITY);
    for &energy in run.samples("kinetic") {
        let further = if up { energy > extreme } else { energy < extreme };
        if further || extreme.is_infinite() {
            extreme = energy;
        } else if (energy - extreme).abs() > least {
            (up, extreme, count) = (!up, energy, count + 1);
        }
    }
    Some(count)
}

/// Energies of the mode that is known: time, kinetic, strain.
fn known() -> Vec<[f64; 3]> {
    table(include_str!("../../../../tests/reference/andersen_bar.csv"))
}

pub(super) fn section(effort: Effort, runs: &Runs) -> Section {
    Section {
        title: "A1 Free vibration of a bar (Andersen 2007, section 4)".into(),
        text: format!(
            "A bar of 5 m x 1 m in plane strain, E = 1e4 Pa, nu = 0.3, density 1e3 kg/m3, 180 particles in cells of 0.5 m (15 x 3 nodes), \
             v_x = A cos(pi x/5) with A = {AMPLITUDE} m/s, step 0.003 s, stress first, lumped mass where nothing else is said. The first \
             period of the bar is {PERIOD} s by a Ritz expansion; the dashed energies are those of that expansion."
        ),
        tables: tables(effort, runs),
        figures: figures(effort, runs),
        findings: findings(effort, runs),
        ..Section::default()
    }
}

fn tables(effort: Effort, runs: &Runs) -> Vec<Table> {
    let ours = |value: Option<f64>| Cell { paper: None, ours: value };
    let row = |element: &Element, mass: &str| {
        let run = runs.done(&name(element, mass));
        let of = |f: fn(&Run) -> Option<f64>| ours(run.and_then(f));
        let period = Cell { paper: Some(PERIOD), ours: run.and_then(period) };
        (format!("{}, {mass}", element.name), vec![period, of(drift), of(interpolation)])
    };
    let masses = effort.pick(Vec::new(), MATRIX.map(|e| row(e, CONSISTENT)).to_vec());
    let rows = ALL.map(|e| row(e, LUMPED)).into_iter().chain(masses).collect();
    let header = ["", "period [s]", "change of energy / energy", "interpolation error / energy"].map(str::to_owned).to_vec();
    let first = Table { title: format!("Largest values over {} s", end(effort)), header, rows, beside: "exact", band: None };
    let error = |element: &Element, amplitude: f64| ours(runs.done(&amplitude_name(element, amplitude)).and_then(interpolation));
    let rows = AMPLITUDES.map(|a| (format!("{a}"), [&LINEAR, &LAGRANGE].map(|e| error(e, a)).to_vec())).to_vec();
    let header = ["A [m/s]", "4-node", "9-node"].map(str::to_owned).to_vec();
    let title = "Largest interpolation error / energy with consistent mass, over the amplitude".into();
    vec![first, Table { title, header, rows, beside: "paper", band: None }]
}

fn energy_chart(title: &str, run: Option<&Run>, end: f64) -> Chart {
    let curve = |name: &str, color: usize, of: &str| Some(Series::new(name, Style::Line, run?.curve(of)).color(color));
    let exact = |name: &str, column: usize| {
        let points = known().into_iter().filter(|row| row[0] <= end).map(|row| [row[0], row[column]]);
        Series::new(name, Style::Reference, points.collect::<Vec<_>>())
    };
    let energies =
        [("particles, kinetic", 0, "kinetic"), ("strain", 1, "strain"), ("total", 2, "total"), ("nodes, kinetic", 3, "nodal_kinetic")];
    let errors = [("interpolation error", 4, "interpolation_error"), ("algorithmic error", 5, "algorithmic_error")];
    let lines = |list: &[(&str, usize, &str)]| list.iter().filter_map(|&(n, c, of)| curve(n, c, of)).collect::<Vec<_>>();
    let mut first = lines(&energies);
    first.extend([exact("kinetic, known", 1), exact("strain, known", 2)]);
    let panels = [Panel { y: Axis::new("energy", "J"), series: first }, Panel { y: Axis::new("error", "J"), series: lines(&errors) }];
    Chart::stacked(title, Axis::new("time", "s"), panels)
}

fn figures(effort: Effort, runs: &Runs) -> Vec<Figure> {
    let own = |element: &Element, number: &str| {
        chart(
            &format!("a1-energies-{}", element.key),
            &format!("{number}: energies and errors with {}, lumped mass", element.name),
            energy_chart(&format!("A1: {}", element.name), runs.get(&name(element, LUMPED)), end(effort)),
        )
    };
    let errors = |mass: &str, elements: &[&Element]| {
        let curve = |e: &&Element| {
            let run = runs.get(&name(e, mass))?;
            let points = run.curve("interpolation_error").into_iter().map(|[t, v]| [t, v.abs().max(1e-16)]);
            Some(Series::new(e.name, Style::Line, points.collect::<Vec<_>>()).color(e.color))
        };
        elements.iter().filter_map(curve).collect::<Vec<_>>()
    };
    let panel = |title: &str, series: Vec<Series>| Panel { y: Axis::new(title, "").log().within(1e-10, 1.0), series };
    let plain = [&LINEAR, &LAGRANGE]
        .iter()
        .filter_map(|e| Some(Series::new(e.name, Style::Line, runs.get(&name(e, LUMPED))?.curve("interpolation_error")).color(e.color)));
    let mut panels =
        vec![Panel { y: Axis::new("error, lumped", "J"), series: plain.collect() }, panel("|error| [J], lumped", errors(LUMPED, &ALL))];
    if effort == Effort::Full {
        panels.push(panel("|error| [J], consistent", errors(CONSISTENT, &MATRIX)));
    }
    vec![
        own(&LINEAR, "Figure 4"),
        own(&SERENDIPITY, "Figure 5"),
        own(&LAGRANGE, "Figure 6"),
        own(&CUBIC, "Figure 7"),
        own(&BSPLINE, "Beside figures 4 to 7"),
        own(&GIMP, "Beside figures 4 to 7"),
        chart(
            "a1-interpolation",
            "Figure 8: interpolation errors; 4-node and 9-node elements as in the paper, then all, and those with consistent mass",
            Chart::stacked("A1: interpolation errors", Axis::new("time", "s"), panels),
        ),
    ]
}

fn findings(effort: Effort, runs: &Runs) -> Vec<Finding> {
    let lumped = |e: &Element| runs.done(&name(e, LUMPED));
    let off = |e: &Element| Some(period(lumped(e)?)? / PERIOD - 1.0);
    let error = |e: &Element| interpolation(lumped(e)?);
    let half_periods = (2.0 * end(effort) / PERIOD).floor() as usize;
    let smooth = |e: &Element| {
        let turns = turns(lumped(e)?)?;
        Some((turns, turns <= 2 * half_periods + 1))
    };
    vec![
        Finding::judge("4, 6, 7", "4-node and 9-node elements and cubic splines all vibrate smoothly.", true, || {
            let three = [&LINEAR, &LAGRANGE, &CUBIC];
            let calm = three.iter().map(|e| smooth(e)).collect::<Option<Vec<_>>>()?;
            let seen = format!(
                "In {half_periods} half periods the kinetic energy turns around {} times; the period is off by {}.",
                calm.iter().map(|c| c.0.to_string()).collect::<Vec<_>>().join(", "),
                each(&three, off, |v| format!("{:+.2} %", 100.0 * v))
            );
            Some((seen, calm.iter().all(|c| c.1)))
        }),
        Finding::judge("5", "8-node elements perform very poorly, likely for the negative masses of the corners.", true, || {
            let (off, error) = (off(&SERENDIPITY)?, error(&SERENDIPITY)?);
            let mut seen =
                format!("The period is off by {} and the interpolation error reaches {} of the energy.", percent(off), percent(error));
            let nodes = lumped(&SERENDIPITY)?.samples("nodal_kinetic").iter().copied().fold(f64::INFINITY, f64::min);
            if nodes < 0.0 {
                seen += &format!(" The kinetic energy of the nodes falls to {nodes:.1e} J, below zero.");
            }
            if let Some(run) = runs.done(&name(&SERENDIPITY, CONSISTENT)) {
                seen += &format!(" With consistent mass it is off by {}: it is the lumping.", percent(period(run)? / PERIOD - 1.0));
            }
            Some((seen, off.abs() > 0.1 && error > 0.5))
        }),
        Finding::judge("4, 5, 6, 7", "The total energy is almost conserved in all simulations: the two errors cancel.", true, || {
            let drifts = PAPER.iter().map(|e| drift(lumped(e)?)).collect::<Option<Vec<_>>>()?;
            let seen = format!("Largest change over the energy: {}.", each(&ALL, |e| drift(lumped(e)?), small));
            Some((seen, drifts.iter().all(|d| *d < 1e-3)))
        }),
        Finding::judge(
            "4, 6, 7",
            "The interpolation error is smallest with 9-node elements, then 4-node; surprisingly it is larger with cubic splines.",
            true,
            || {
                let (four, nine, cubic) = (error(&LINEAR)?, error(&LAGRANGE)?, error(&CUBIC)?);
                let seen = format!("Largest error over the energy: {}.", each(&ALL, error, percent));
                Some((seen, nine < four && four < cubic))
            },
        ),
        Finding::judge(
            "8",
            "Quadratic interpolation with 9 nodes clearly reduces the interpolation error of 4-node elements.",
            true,
            || {
                let (four, nine) = (error(&LINEAR)?, error(&LAGRANGE)?);
                Some((format!("It is {:.1} times smaller.", four / nine), four > 3.0 * nine))
            },
        ),
        Finding::judge("8", "With consistent mass the interpolation error becomes zero.", true, || {
            let at = |e: &Element| AMPLITUDES.iter().map(|&a| interpolation(runs.done(&amplitude_name(e, a))?)).collect::<Option<Vec<_>>>();
            let (four, nine) = (at(&LINEAR)?, at(&LAGRANGE)?);
            let list = |errors: &[f64]| errors.iter().map(|&e| small(e)).collect::<Vec<_>>().join(", ");
            let order = |errors: &[f64]| (errors[0] / errors[errors.len() - 1]).log10() / (errors.len() - 1) as f64;
            let seen = format!(
                "It does in the limit of small motion: over the energy it is at most {} (4-node) and {} (9-node) for A = {} m/s, and so goes \
                 with the power {:.1} and {:.1} of the amplitude.",
                list(&four),
                list(&nine),
                AMPLITUDES.map(|a| a.to_string()).join(", "),
                order(&four),
                order(&nine)
            );
            let vanishes = |errors: &[f64]| errors[0] < 1e-4 && order(errors) > 0.5;
            Some((seen, vanishes(&four) && vanishes(&nine)))
        }),
        Finding::judge(
            "4-8, amplitude",
            "A large amplitude changes the sign of nodal masses of 9-node elements, which break down; with the other elements large \
             amplitudes are no problem.",
            true,
            || {
                let Some(stop) = negative_mass(runs.get(&large_name(&LAGRANGE))?) else {
                    return Some(("9-node elements go on.".into(), false));
                };
                let others = [&LINEAR, &SERENDIPITY, &CUBIC];
                let drift = |e: &Element| drift(runs.done(&large_name(e))?);
                let drifts = others.iter().map(|e| drift(e)).collect::<Option<Vec<_>>>()?;
                let seen = format!(
                    "A = {LARGE} m/s: 9-node elements stop at {stop:.3} s for a negative nodal mass; the others reach {} s, 8-node elements too, with \
                     an energy that changes by {}.",
                    end(effort),
                    each(&others, drift, percent)
                );
                Some((seen, drifts.iter().all(|d| *d < 0.05)))
            },
        ),
    ]
}
