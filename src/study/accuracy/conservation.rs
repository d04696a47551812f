//! A free block tumbles and swings with large strain a thousand times: what it must keep.

use super::tabulate;
use crate::study::tools::{chart, largest, small};
use crate::study::{Axis, Chart, Effort, Finding, Job, Panel, Run, Runs, Section, Series, Style, value};

/// Time between samples \[s\].
const EVERY: f64 = 0.02;

/// A scheme with what it must keep of the energy.
struct Scheme {
    name: &'static str,
    integrator: &'static str,
    /// Step \[s\].
    step: f64,
    more: &'static str,
    /// Largest change of the energy over what it was.
    most: f64,
    claim: &'static str,
}

const SCHEMES: [Scheme; 2] = [
    Scheme {
        name: "energy-momentum, steps of 20 ms",
        integrator: "energy_momentum",
        step: 0.02,
        more: ", newton_residual = 1e-11",
        most: 1e-8,
        claim: "the energy drifts by less than 1e-8",
    },
    Scheme {
        name: "Verlet, steps of 0.5 ms",
        integrator: "verlet",
        step: 5e-4,
        more: "",
        most: 1e-4,
        claim: "the energy stays within 1e-4, and the second half no further off than the first by a tenth",
    },
];

fn end(effort: Effort) -> f64 {
    effort.pick(20.0, 420.0)
}

fn name(scheme: &Scheme) -> String {
    format!("conservation/{}", scheme.name)
}

pub(super) fn jobs(effort: Effort) -> Vec<Job> {
    let job = |scheme: &Scheme| {
        let scene = format!(
            r#"
            title = "a block that tumbles and swings"
            dimension = 2
            grid = {{ origin = [-1, -0.5], size = [2, 1], cell = 0.5 }}
            material.rubber = {{ law = "neo_hookean", young = 100.0, poisson = 0.3, density = 1.0 }}
            body.block = {{ material = "rubber", shape = {{ box = {{ min = [-1, -0.5], max = [1, 0.5] }} }}, velocity = ["2*x - 1.5*y + 0.3", "1.5*x - 2*y"] }}
            probe.left = {{ at = [-1, 0] }}
            probe.right = {{ at = [1, 0] }}
            method = {{ formulation = "total", degree = 2, integrator = "{}"{} }}
            time = {{ end = {}, step = {} }}
            "#,
            scheme.integrator,
            scheme.more,
            end(effort),
            scheme.step
        );
        let length = |sim: &mut crate::Simulation| {
            let left = sim.get("probe/left/position")?.to_vec();
            let right = sim.get("probe/right/position")?;
            Ok(f64::hypot(right[0] - left[0], right[1] - left[1]))
        };
        let job = Job::new(name(scheme), scene).every(EVERY).watch("length", length);
        let kinds =
            [("energy", "energy/total"), ("strain", "energy/strain"), ("angular", "momentum/angular"), ("linear", "momentum/linear")];
        kinds.into_iter().fold(job, |job, (name, variable)| job.watch(name, value(variable, 0)))
    };
    SCHEMES.iter().map(job).collect()
}

/// What is kept, less what it was, over what it was.
fn change(run: &Run, name: &str) -> Option<Vec<[f64; 2]>> {
    let first = *run.samples(name).first()?;
    Some(run.curve(name).into_iter().map(|[t, v]| [t, v / first - 1.0]).collect())
}

fn most(points: &[[f64; 2]]) -> f64 {
    largest(points.iter().map(|p| p[1]))
}

/// How often the length of the block grows past its mean.
fn periods(run: &Run) -> usize {
    let length = run.samples("length");
    let mean = length.iter().sum::<f64>() / length.len() as f64;
    length.windows(2).filter(|two| two[0] < mean && two[1] >= mean).count()
}

/// The largest change in each of 200 spans of time.
fn envelope(points: &[[f64; 2]]) -> Vec<[f64; 2]> {
    points.chunks(points.len().div_ceil(200).max(1)).filter_map(|span| Some([span.last()?[0], most(span)])).collect()
}

pub(super) fn section(effort: Effort, runs: &Runs) -> Section {
    let get = |scheme: &Scheme| runs.done(&name(scheme));
    let table = tabulate(
        "What is kept: largest change over what it was, at all samples",
        &["scheme", "step [s]", "periods", "period [s]", "energy", "angular momentum", "linear momentum", "wall time [s]"],
        &SCHEMES,
        |scheme| {
            let run = get(scheme);
            let count = run.map(|r| periods(r) as f64);
            let kept = |what: &str| Some(most(&change(run?, what)?));
            let values = vec![
                Some(scheme.step),
                count,
                count.map(|n| end(effort) / n),
                kept("energy"),
                kept("angular"),
                kept("linear"),
                run.map(|r| r.wall),
            ];
            (scheme.name.into(), values)
        },
    );
    let envelopes = |what: &'static str| {
        SCHEMES.iter().filter_map(move |s| Some(Series::new(s.name, Style::Line, envelope(&change(get(s)?, what)?)))).collect::<Vec<_>>()
    };
    let drift = Chart::stacked(
        "Change of what must be kept, largest in each 1/200 of the time",
        Axis::new("time", "s"),
        [
            Panel { y: Axis::new("energy", "").log(), series: envelopes("energy") },
            Panel { y: Axis::new("angular momentum", "").log(), series: envelopes("angular") },
        ],
    );
    let first = |what: &'static str| {
        let part = move |s: &Scheme| Some(get(s)?.curve(what).into_iter().filter(|p| p[0] <= 5.0).collect::<Vec<_>>());
        SCHEMES.iter().filter_map(move |s| Some(Series::new(s.name, Style::Line, part(s)?))).collect::<Vec<_>>()
    };
    let motion = Chart::stacked(
        "The first five seconds",
        Axis::new("time", "s"),
        [
            Panel { y: Axis::new("length", "m"), series: first("length") },
            Panel { y: Axis::new("strain energy", "J"), series: first("strain") },
        ],
    );
    let findings = SCHEMES.iter().map(|scheme| {
        let claim = format!("Over 1,000 periods {}; the angular momentum changes by less than 1e-10.", scheme.claim);
        let claim = effort.pick(claim.replace("1,000", "40"), claim);
        Finding::judge(scheme.name, claim, true, || {
            let run = get(scheme)?;
            let (energy, angular) = (change(run, "energy")?, most(&change(run, "angular")?));
            let halves = energy.split_at(energy.len() / 2);
            let [first, second] = [most(halves.0), most(halves.1)];
            let count = periods(run);
            let seen = format!(
                "{count} periods: energy {} in the first half and {} in the second, angular momentum {}.",
                small(first),
                small(second),
                small(angular)
            );
            let bounded = scheme.integrator != "verlet" || second <= 1.1 * first;
            let long = count >= effort.pick(40, 1000);
            Some((seen, long && bounded && f64::max(first, second) < scheme.most && angular < 1e-10))
        })
    });
    Section {
        title: "Energy and momenta of a free body that swings and tumbles".into(),
        text: format!(
            "A block of 2 m x 1 m, E = 100 Pa, nu = 0.3, 1 kg/m3, neo-Hookean, with nothing to hold it; the velocity at time 0 stretches and \
             turns it. Total Lagrangian, degree 2, 4 x 2 cells, {} s, sampled every {EVERY} s. A period is from one time that the distance of \
             the middles of the ends grows past its mean to the next.",
            end(effort)
        ),
        tables: vec![table],
        figures: vec![
            chart("conservation", "Change of energy and angular momentum over time", drift),
            chart("conservation-motion", "Length of the block and energy stored in it, at first", motion),
        ],
        findings: findings.collect(),
        ..Section::default()
    }
}
