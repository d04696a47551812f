//! The common work, which other codes were measured with too.

use super::machine::{Instructions, Limit, Precision};
use super::scenes::{self, APIC, Size};
use super::{Bench, Count, Entry, million as m, three};
use crate::study::Section;
use crate::study::tools::{percent, tabulate};

/// A row of the table.
struct Row {
    name: &'static str,
    precision: Precision,
    threads: usize,
    shuffled: bool,
}

const ALONE: Row = Row { name: "double, 1 thread", precision: Precision::Double, threads: 1, shuffled: false };
const PAIR: Row = Row { name: "double, 2 threads", threads: 2, ..ALONE };
const SHUFFLED: Row = Row { name: "double, 1 thread, shuffled at the start", shuffled: true, ..ALONE };
const SINGLE: Row = Row { name: "single, 1 thread", precision: Precision::Single, ..ALONE };
const SINGLE_PAIR: Row = Row { name: "single, 2 threads", threads: 2, ..SINGLE };
const ROWS: [Row; 5] = [ALONE, SHUFFLED, PAIR, SINGLE, SINGLE_PAIR];

/// What a scene says for single precision.
pub(super) const SINGLE_PRECISION: &str = r#", precision = "single""#;

pub(super) fn small(bench: &mut Bench) -> Result<Section, String> {
    section(bench, "common", bench.effort.pick(Size::QUICK, Size::COMMON), 20)
}

pub(super) fn million(bench: &mut Bench) -> Result<Section, String> {
    section(bench, "million", bench.effort.pick(Size::COMMON, Size::MILLION), 10)
}

fn section(bench: &mut Bench, part: &str, size: Size, substeps: u64) -> Result<Section, String> {
    let peak = bench.machine()?.peak();
    let best = Instructions::all()[0];
    let memory = Limit::memory(bench.effort);
    let scene = |row: &Row| {
        let precision = if row.precision == Precision::Single { SINGLE_PRECISION } else { "" };
        scenes::block(size, &format!("{APIC}{precision}"), 1)
    };
    let limit = |row: &Row| Limit::Peak(best, row.precision);
    let mut entries: Vec<Entry> = ROWS
        .iter()
        .map(|row| Entry::scene(row.name, scene(row), substeps).threads(row.threads).with(|task| task.shuffled = row.shuffled))
        .collect();
    entries.extend([ALONE, PAIR, SINGLE, SINGLE_PAIR].iter().map(|row| Entry::limit(limit(row), row.threads)));
    entries.extend([1, 2].map(|threads| Entry::limit(memory, threads)));
    let race = bench.race_anew(part, &entries, bench.effort.pick(1, 3), bench.rounds())?;

    let count = Count::COMMON;
    let share = |row: &Row| {
        let of_peak = race.ratio(row.name, &limit(row).name(row.threads))? * count.flops();
        let of_memory = race.ratio(row.name, &memory.name(row.threads))? * count.bytes();
        Some([of_peak, of_memory])
    };
    let header = ["", "M/s", "Gflop/s", "of multiply-adds [%]", "GB/s", "of triad in memory [%]"];
    let table = tabulate("Particle-steps a second (medians)", &header, &ROWS, |row| {
        let (rate, shares) = (race.median(row.name), share(row));
        let giga = |each: f64| rate.map(|rate| three(1e-9 * rate * each));
        let cells = vec![
            rate.map(m),
            giga(count.flops()),
            shares.map(|s| three(100.0 * s[0])),
            giga(count.bytes()),
            shares.map(|s| three(100.0 * s[1])),
        ];
        (row.name.to_owned(), cells)
    });
    for row in ROWS.iter().filter(|row| row.threads == 1 && !row.shuffled) {
        if let Some(rate) = race.at_peak(row.name, peak) {
            let precision = row.name.split(',').next().unwrap_or_default();
            bench.points.push((format!("common work, {} particles, {precision}", size.particles()), count, rate));
        }
    }
    let factor = |first: &Row, second: &Row| race.ratio(first.name, second.name);
    let mut findings = bench.judge("two threads, double", "At least 1.85 times one thread.", || {
        let ratio = factor(&PAIR, &ALONE)?;
        Some((format!("{ratio:.2} times."), ratio >= 1.85))
    });
    findings.extend(bench.judge("shuffled at the start", "Within 5 % of sorted after 20 steps.", || {
        let ratio = factor(&SHUFFLED, &ALONE)?;
        Some((format!("{:+.1} %.", 100.0 * (ratio - 1.0)), ratio >= 0.95))
    }));
    findings.extend(bench.judge("share of the machine's limit, double, one thread", "Stated; the goal is 50 %.", || {
        let [of_peak, of_memory] = share(&ALONE)?;
        let seen = format!("{} of the multiply-adds, {} of the triad in memory.", percent(of_peak), percent(of_memory));
        Some((seen, of_peak.max(of_memory) >= 0.5))
    }));
    Ok(Section {
        title: format!("Common work, {} particles", size.particles()),
        text: format!(
            "A neo-Hookean block of {0} x {0} x {0} cells falls in a cube: quadratic B-splines, APIC, stress last, 8 particles a cell, jittered. \
             {substeps} steps a timing, in one call; the first timing does not count. A particle takes {1} operations (separable form: sums over \
             nodes axis by axis) and {2} bytes (each number that is kept between steps in once and out once, and its share of the nodes; in single \
             precision too, as that is for what is worked out, not for what is kept): formulas in `src/study/throughput/count.rs`. Shares are of \
             the {3} multiply-adds of the precision and of the triad, measured in the same rounds.",
            size.block,
            count.flops(),
            count.bytes(),
            best.name()
        ),
        tables: vec![table],
        findings,
        failures: race.faults,
        ..Section::default()
    })
}
