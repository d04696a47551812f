//! Appendix: are negative nodal masses consistent in a rigid motion?

use super::{ALL, Element, LINEAR, PAPER, SERENDIPITY, chart, each, largest, places, small};
use crate::study::{Axis, Chart, Effort, Figure, Finding, Job, Panel, Run, Runs, Section, Series, Style};

const END: f64 = 1.0;
const STEP: f64 = 0.01;
const VELOCITY: [f64; 2] = [0.8, 0.6];
const DENSITY: f64 = 10.0;
const CELL: f64 = 0.5;
const PER_CELL: usize = 3;

/// Young's moduli \[Pa\]: forces that do nothing in the time of the run, and forces that do.
const SOFT: f64 = 1.0;
const STIFF: f64 = 1e3;

fn name(element: &Element, young: f64) -> String {
    format!("AX/{}/drift, E = {young} Pa", element.key)
}

/// A block without stress that drifts through several elements. 9-node elements stop where a nodal mass turns negative.
fn scene(element: &Element, young: f64) -> String {
    format!(
        r#"
        title = "Andersen 2007, appendix: a block that drifts"
        dimension = 2
        grid = {{ origin = [-1, -1], size = [5, 5], cell = {CELL} }}
        material.m = {{ law = "hypo_elastic", young = {young}, poisson = 0.3, density = {DENSITY} }}
        time = {{ end = {END}, step = {STEP} }}
        method = {{ basis = "{}", integrator = "usf" }}
        [body.block]
        material = "m"
        shape = {{ box = {{ min = [0, 0], max = [1, 1] }} }}
        particles_per_cell = {PER_CELL}
        velocity = [{}, {}]
        "#,
        element.basis, VELOCITY[0], VELOCITY[1],
    )
}

pub(super) fn jobs(_: Effort) -> Vec<Job> {
    let job = |element: &Element, young: f64| {
        // how far particles are from where they would be in a rigid motion
        Job::new(name(element, young), scene(element, young)).every(STEP).watch("off", |sim| {
            let time = sim.time();
            Ok(largest(places(sim.get("particle/displacement")?).into_iter().flat_map(|u| [0, 1].map(|a| u[a] - VELOCITY[a] * time))))
        })
    };
    ALL.iter().flat_map(|e| [SOFT, STIFF].map(|young| job(e, young))).collect()
}

fn off(run: &Run) -> Option<f64> {
    run.is_done().then(|| largest(run.samples("off").iter().copied()))
}

/// Values of the 8 serendipity functions of an element at local coordinates from -1 to 1: corners, then middles of sides.
fn serendipity(x: f64, y: f64) -> [f64; 8] {
    let corner = |a: f64, b: f64| 0.25 * (1.0 + a * x) * (1.0 + b * y) * (a * x + b * y - 1.0);
    let side = |a: f64| 0.5 * (1.0 - x * x) * (1.0 + a * y);
    let post = |a: f64| 0.5 * (1.0 + a * x) * (1.0 - y * y);
    [corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0), side(-1.0), side(1.0), post(-1.0), post(1.0)]
}

/// Values of the 4 bilinear functions.
fn bilinear(x: f64, y: f64) -> [f64; 4] {
    [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)].map(|(a, b)| 0.25 * (1.0 + a * x) * (1.0 + b * y))
}

/// What the updates of the paper move a particle by, over the velocity times the step, in a rigid motion of an element filled with
/// `per_axis` x `per_axis` equal particles: least and most over the particles.
struct Moves {
    /// Lightest and heaviest node over the mass of a particle.
    masses: [f64; 2],
    /// Eq. 20, `sum_ij (m^-1)_ij p_j N_i` with lumped mass.
    algorithm: [f64; 2],
    /// Eq. 40 as printed, `1/m_p sum_i p_i N_i`.
    printed: [f64; 2],
}

fn moves<const N: usize>(functions: fn(f64, f64) -> [f64; N], per_axis: usize) -> Moves {
    let local = |k: usize| (2 * k + 1) as f64 / per_axis as f64 - 1.0;
    let particles: Vec<[f64; N]> = (0..per_axis * per_axis).map(|k| functions(local(k % per_axis), local(k / per_axis))).collect();
    // particles of mass 1 with one speed
    let speed = 0.7;
    let sum_of = |value: f64| -> [f64; N] { std::array::from_fn(|i| particles.iter().map(|n| value * n[i]).sum()) };
    let (mass, momentum) = (sum_of(1.0), sum_of(speed));
    let range =
        |values: Vec<f64>| [values.iter().copied().fold(f64::INFINITY, f64::min), values.iter().copied().fold(f64::NEG_INFINITY, f64::max)];
    let sum = |n: &[f64; N], of: &dyn Fn(usize) -> f64| (0..N).map(|i| of(i) * n[i]).sum::<f64>();
    Moves {
        masses: range(mass.to_vec()),
        algorithm: range(particles.iter().map(|n| sum(n, &|i| momentum[i] / mass[i]) / speed).collect()),
        printed: range(particles.iter().map(|n| sum(n, &|i| momentum[i]) / speed).collect()),
    }
}

pub(super) fn section(_: Effort, runs: &Runs) -> Section {
    let panel = |young: f64| {
        let curve = |e: &&Element| {
            let points = runs.get(&name(e, young))?.curve("off").into_iter().map(|[t, v]| [t, v.max(1e-17)]);
            Some(Series::new(e.name, Style::Line, points.collect::<Vec<_>>()).color(e.color))
        };
        let axis = Axis::new(format!("distance [m], E = {young} Pa"), "").log().within(1e-18, 1.0);
        Panel { y: axis, series: ALL.iter().filter_map(curve).collect() }
    };
    let title = "Appendix: a block that drifts";
    let figure: Figure = chart(
        "ax-drift",
        "Appendix: largest distance of a particle from its place in a rigid motion; 9-node elements until they stop",
        Chart::stacked(title, Axis::new("time", "s"), [panel(SOFT), panel(STIFF)]),
    );
    Section {
        title: "AX Appendix: negative mass (Andersen 2007)".into(),
        text: format!(
            "A block of 1 m x 1 m without stress drifts with ({}, {}) m/s through cells of {CELL} m, {PER_CELL} x {PER_CELL} particles a cell, lumped mass. \
             With 8-node elements the corners always have negative masses.",
            VELOCITY[0], VELOCITY[1]
        ),
        figures: vec![figure],
        findings: findings(runs),
        ..Section::default()
    }
}

fn findings(runs: &Runs) -> Vec<Finding> {
    let range = |[low, high]: [f64; 2]| format!("{low:.4} to {high:.4}");
    vec![
        Finding::judge("appendix, eqs 36 to 39", "Negative nodal masses give the right velocities, for the signs cancel.", true, || {
            let eight = off(runs.get(&name(&SERENDIPITY, SOFT))?)?;
            let seen = format!(
                "A drifting block is at most {} m from its place (a corner of a full element weighs {:.2} particles).",
                each(&PAPER, |e| off(runs.get(&name(e, SOFT))?), small),
                moves(serendipity, 2 * PER_CELL).masses[0]
            );
            Some((seen, eight < 1e-12))
        }),
        Finding::judge("appendix, eq. 40", "The update of positions is inconsistent when negative masses are met.", false, || {
            let (eight, four) = (moves(serendipity, 2 * PER_CELL), moves(bilinear, PER_CELL));
            let seen = format!(
                "Eq. 40 as printed moves particles by {} times the right way with 8-node elements, but also by {} times with 4-node ones, \
                     whose masses are positive ({} of a particle): it is not what eq. 20 does, which moves them by {} and {} times. \
                     In a rigid motion negative masses do no harm; the run above moves by eq. 20 and is right to {} m ({} m with 4 nodes).",
                range(eight.printed),
                range(four.printed),
                range(four.masses),
                range(eight.algorithm),
                range(four.algorithm),
                small(off(runs.get(&name(&SERENDIPITY, SOFT))?)?),
                small(off(runs.get(&name(&LINEAR, SOFT))?)?),
            );
            // inconsistent because of the negative mass: where masses are positive, or by eq. 20, it would not be
            let right = |moves: [f64; 2]| moves.iter().all(|m| (m - 1.0).abs() < 1e-12);
            Some((seen, !right(eight.algorithm) && right(four.printed)))
        }),
        Finding::judge("appendix, stability", "The 8-node element is inaccurate, but it does not get unstable.", false, || {
            let run = runs.get(&name(&SERENDIPITY, STIFF))?;
            let four = off(runs.get(&name(&LINEAR, STIFF))?)?;
            let soft = off(runs.get(&name(&SERENDIPITY, SOFT))?)?;
            let seen = format!(
                "With E = {STIFF} Pa in place of {SOFT} Pa round-off grows while the block moves from element to element, up to {} m{}; without \
                 forces it is {} m, with 4-node elements {} m. Likely because forces on negative masses push the wrong way.",
                small(largest(run.samples("off").iter().copied())),
                run.times.last().filter(|_| !run.is_done()).map_or(String::new(), |t| format!(" when a particle is inverted at {t:.2} s")),
                small(soft),
                small(four)
            );
            Some((seen, off(run).is_some_and(|v| v < 1e-9)))
        }),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_printed_update_is_wrong_for_all_masses_and_that_of_the_algorithm_for_none() {
        let (eight, four) = (moves(serendipity, 6), moves(bilinear, 3));
        assert!(eight.masses[0] < 0.0 && four.masses[0] > 0.0);
        for moves in [eight, four] {
            assert!(moves.algorithm.iter().all(|m| (m - 1.0).abs() < 1e-12), "{:?}", moves.algorithm);
            assert!(moves.printed.iter().all(|m| (m - 1.0).abs() > 0.1), "{:?}", moves.printed);
        }
    }

    #[test]
    fn functions_sum_to_one() {
        for (x, y) in [(0.0, 0.0), (0.3, -0.7), (1.0, 0.2)] {
            assert!(
                (serendipity(x, y).iter().sum::<f64>() - 1.0).abs() < 1e-15 && (bilinear(x, y).iter().sum::<f64>() - 1.0).abs() < 1e-15
            );
        }
    }
}
