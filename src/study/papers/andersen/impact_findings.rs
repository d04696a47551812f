//! What A3 says of figures 13 to 17, and of contact.

use super::impact::{
    BAR_CELLS, Case, END, FIELDS, RUNNING, Reading, SMALL, SPEED, STEP, WIDE, apart, bars_name, energy_range, fall, momentum_error,
    refined, refined_case, shared,
};
use super::{BSPLINE, CUBIC, Element, LAGRANGE, LINEAR, SERENDIPITY, each, negative_mass, percent};
use crate::study::{Effort, Finding, Run, Runs};

/// How far the box falls back after its lowest place \[m\].
fn fallen_back(run: &Run) -> Option<f64> {
    let curve = fall(run);
    let lowest = (0..curve.len()).min_by(|&a, &b| curve[a][1].total_cmp(&curve[b][1]))?;
    let (mut top, mut most) = (f64::NEG_INFINITY, 0.0f64);
    for [_, y] in &curve[lowest..] {
        top = top.max(*y);
        most = most.max(top - y);
    }
    Some(most)
}

/// Speed of the box upwards over the last half second \[m/s\].
fn rebound(run: &Run) -> Option<f64> {
    let curve = fall(run);
    let last = curve.last()?;
    let before = curve.iter().rev().find(|p| p[0] < last[0] - 0.5)?;
    Some((last[1] - before[1]) / (last[0] - before[0]))
}

/// Mean displacement of the box less that of the beam at the end \[m\].
fn lift(run: &Run) -> Option<f64> {
    Some(fall(run).last()?[1] - run.samples("sag").last()?)
}

fn deepest(run: &Run) -> f64 {
    fall(run).iter().map(|p| -p[1]).fold(0.0, f64::max)
}

pub(super) fn findings(effort: Effort, runs: &Runs) -> Vec<Finding> {
    let one = |e: &'static Element, reading: Reading| runs.done(&shared(e, reading).name());
    let small = |e: &'static Element| one(e, SMALL);
    let two = |e: &'static Element| runs.done(&apart(e, SMALL, 0.0, STEP).name());
    let of = |elements: &[&'static Element], f: &dyn Fn(&'static Element) -> Option<String>| {
        elements.iter().filter_map(|e| Some(format!("{} {}", e.name, f(e)?))).collect::<Vec<_>>().join(", ")
    };
    let mut all = vec![
        Finding::judge("13", "9-node elements cannot simulate the problem: the sign of nodal masses changes.", true, || {
            let Some(stop) = negative_mass(runs.get(&shared(&LAGRANGE, SMALL).name())?) else { return Some(("They can.".into(), false)) };
            Some((format!("The run stops at {stop:.3} s for a negative nodal mass, before the box arrives."), true))
        }),
        Finding::judge("14, 15, 16", "The other elements get through, with the step of 0.005 s.", false, || {
            let eight = runs.get(&Case { step: STEP, ..shared(&SERENDIPITY, SMALL) }.name())?;
            let [.., most, _] = energy_range(eight)?;
            let half = energy_range(small(&SERENDIPITY)?)?;
            let range = |e: &'static Element| energy_range(small(e)?).map(|[low, high, _]| format!("{low:.3} to {high:.3}"));
            let seen = format!(
                "4-node elements and splines do. With 8-node elements the energy grows to {most:.3} times that at the start with this step ({}); with \
                 half of it stays within {:.3} and {:.3}. Others, over that at the start: {}.",
                if eight.is_done() { "the run ends".to_owned() } else { format!("it breaks down at {:.2} s", eight.times.last()?) },
                half[0],
                half[1],
                of(&[&LINEAR, &CUBIC, &BSPLINE], &range)
            );
            Some((seen, eight.is_done() && most < 1.1))
        }),
        Finding::judge("17", "The beam ends with an upward deflection: a funny-looking configuration.", true, || {
            let sag = |e: &'static Element, reading| one(e, reading)?.samples("sag").last().copied();
            let ours = RUNNING.iter().map(|e| sag(e, SMALL)).collect::<Option<Vec<_>>>()?;
            let mut seen =
                format!("Mean displacement of the beam at {END} s: {}.", of(&RUNNING, &|e| Some(format!("{:+.3} m", sag(e, SMALL)?))));
            let wide = of(&RUNNING, &|e| Some(format!("{:+.3} m", sag(e, WIDE)?)));
            if !wide.is_empty() {
                seen += &format!(" With the beam of 20 m: {wide}, it is on its way down.");
            }
            Some((seen, ours.iter().all(|v| *v > 0.0)))
        }),
        Finding::judge("17", "Cubic splines: the box hits the beam and bounces off in one smooth movement.", true, || {
            let (fallen, lifted) = (fallen_back(small(&CUBIC)?)?, lift(small(&CUBIC)?)?);
            let seen = format!(
                "Once at its lowest it only rises (it falls back by {fallen:.3} m), and is {lifted:+.2} m off the beam at {END} s; with quadratic \
                 B-splines {:+.2} m.",
                lift(small(&BSPLINE)?)?
            );
            Some((seen, lifted > 0.3 && fallen < 0.01))
        }),
        Finding::judge("17", "4-node elements: the box oscillates on the beam before it finally bounces off.", false, || {
            let seen = of(&[&LINEAR, &SERENDIPITY], &|e| Some(format!("{:+.2} m", lift(small(e)?)?)));
            Some((format!("It is on the beam still at {END} s: off it by {seen}."), lift(small(&LINEAR)?)? > 0.1))
        }),
        Finding::judge(
            "17",
            "The upward velocity is considerably lower with cubic splines than with 4-node and 8-node elements.",
            false,
            || {
                let speed = |e: &'static Element| rebound(small(e)?);
                let (four, eight, cubic) = (speed(&LINEAR)?, speed(&SERENDIPITY)?, speed(&CUBIC)?);
                let seen = format!(
                    "Over the last half second (it came with {SPEED} m/s): {}. It is higher: 4-node and 8-node elements hold the box to the beam.",
                    of(&RUNNING, &|e| Some(format!("{:+.2} m/s", speed(e)?)))
                );
                Some((seen, cubic < 0.8 * four && cubic < 0.8 * eight))
            },
        ),
        Finding::judge("17, a field each", "Not in the paper: with separate fields the box does not stick.", true, || {
            let lifts = FIELDS.iter().map(|e| lift(two(e)?)).collect::<Option<Vec<_>>>();
            let seen = format!(
                "Its lift off the beam at the end: {}; deepest {}.",
                of(&FIELDS, &|e| Some(format!("{:+.2} m", lift(two(e)?)?))),
                of(&FIELDS, &|e| Some(format!("{:.2} m", deepest(two(e)?))))
            );
            Some((seen, lifts?.iter().all(|l| *l > 0.3)))
        }),
        Finding::judge("17, a field each", "Not in the paper: its energy is kept within 2 %.", false, || {
            let ranges = FIELDS.iter().map(|e| energy_range(two(e)?)).collect::<Option<Vec<_>>>()?;
            let text = |[low, high, end]: [f64; 3]| format!("{low:.3} to {high:.3}, {end:.3} at the end");
            let mut seen = format!("Over that at the start: {}.", of(&FIELDS, &|e| Some(text(energy_range(two(e)?)?))));
            let finer = of(&FIELDS, &|e| Some(text(energy_range(runs.done(&apart(e, SMALL, 0.0, 0.25 * STEP).name())?)?)));
            if !finer.is_empty() {
                seen += &format!(
                    " With a quarter of the step: {finer}. Contact first takes energy, with the cells, and then adds some, with the step."
                );
            }
            Some((seen, ranges.iter().all(|[low, high, _]| *low > 0.98 && *high < 1.02)))
        }),
        Finding::judge("17, a field each", "Not in the paper: two equal bars that meet head-on exchange their velocities.", true, || {
            let speed = |e: &Element, cell: f64| Some(runs.done(&bars_name(e, cell))?.samples("speed").last()? / -0.01);
            let kept = |e: &Element, cell: f64| Some(energy_range(runs.done(&bars_name(e, cell))?)?[2]);
            let pairs = FIELDS.iter().map(|e| Some(BAR_CELLS.map(|cell| speed(e, cell)))).collect::<Option<Vec<_>>>()?;
            let [coarse, fine] = BAR_CELLS;
            let seen = format!(
                "Cells of {coarse} and {fine} m, velocity over the exchanged one: {}; energy lost: {} and {}.",
                FIELDS
                    .iter()
                    .filter_map(|e| Some(format!("{} {:.3} and {:.3}", e.name, speed(e, coarse)?, speed(e, fine)?)))
                    .collect::<Vec<_>>()
                    .join(", "),
                each(&FIELDS, |e| Some(1.0 - kept(e, coarse)?), percent),
                each(&FIELDS, |e| Some(1.0 - kept(e, fine)?), percent)
            );
            Some((seen, pairs.iter().all(|[a, b]| matches!((a, b), (Some(a), Some(b)) if *b > *a && *b > 0.94 && *b < 1.001))))
        }),
    ];
    let exact = FIELDS.iter().map(|e| momentum_error(two(e)?)).collect::<Option<Vec<_>>>();
    if let Some(errors) = exact {
        all.push(Finding::judge(
            "17, a field each",
            "Not in the paper: momentum is kept: it changes by the impulse of the walls.",
            true,
            || {
                let list = FIELDS.iter().zip(&errors).map(|(e, error)| format!("{} {error:.1e}", e.name)).collect::<Vec<_>>().join(", ");
                Some((format!("Largest difference over the momentum of the box: {list}."), errors.iter().all(|e| *e < 1e-10)))
            },
        ));
    }
    if effort == Effort::Full {
        all.push(Finding::judge(
            "17, a field each",
            "Not in the paper: friction of 0.3 changes little: the box falls straight.",
            true,
            || {
                let rough = |e: &'static Element| rebound(runs.done(&apart(e, SMALL, 0.3, STEP).name())?);
                let changes = FIELDS.iter().map(|e| Some((rough(e)? - rebound(two(e)?)?).abs())).collect::<Option<Vec<_>>>()?;
                let seen = format!(
                    "Speed of the box at the end {}, without friction {}.",
                    of(&FIELDS, &|e| Some(format!("{:+.3} m/s", rough(e)?))),
                    of(&FIELDS, &|e| Some(format!("{:+.3} m/s", rebound(two(e)?)?)))
                );
                Some((seen, changes.iter().all(|c| *c < 0.1 * SPEED)))
            },
        ));
        all.push(Finding::judge("17, a field each", "Not in the paper: finer cells lose less energy in the impact.", true, || {
            let lost =
                |e: &'static Element, reading: &Reading| Some(1.0 - energy_range(runs.done(&refined_case(e, *reading, 0.25).name())?)?[0]);
            let readings: Vec<Reading> = refined(effort).into_iter().filter(|r| r.cells < 80).collect();
            let rows =
                FIELDS.iter().map(|e| readings.iter().map(|r| lost(e, r)).collect::<Option<Vec<_>>>()).collect::<Option<Vec<_>>>()?;
            let list = FIELDS
                .iter()
                .zip(&rows)
                .map(|(e, row)| format!("{} {}", e.name, row.iter().map(|v| percent(*v)).collect::<Vec<_>>().join(" and ")));
            let seen = format!(
                "Beam of 20 m, a quarter of the step; most energy lost with cells of 1 and 0.5 m: {}.",
                list.collect::<Vec<_>>().join(", ")
            );
            Some((seen, rows.iter().all(|row| row.windows(2).all(|w| w[1] < 0.7 * w[0]))))
        }));
    }
    all
}
