//! The same body in a larger domain: what is empty costs nothing.

use super::scenes::{self, APIC, Size};
use super::stopwatch::{Stopwatch, Task};
use super::{Bench, Entry, million, thousandths, three};
use crate::study::Section;
use crate::study::tools::tabulate;

const TIGHT: &str = "tight";
const WIDE: &str = "1,000 times larger";
/// Most of the time that a step may take.
const MOST: f64 = 1.02;

pub(super) fn section(bench: &mut Bench) -> Result<Section, String> {
    let size = bench.effort.pick(Size::QUICK, Size::COMMON);
    let scene = |name: &str| scenes::block(size, APIC, if name == WIDE { 10 } else { 1 });
    let entries = [TIGHT, WIDE].map(|name| Entry::scene(name, scene(name), 20));
    // it is about hundredths
    let race = bench.race_anew("domain", &entries, bench.effort.pick(1, 15), bench.effort.pick(3, 5))?;
    let ratio = race.ratio(TIGHT, WIDE);
    let memory = |name: &str| Some(Stopwatch::start(bench.program, &Task::new(scene(name)), 1, None).ok()?.memory as f64);
    let rows = [(TIGHT, Some(1.0)), (WIDE, ratio)];
    let table = tabulate("Time and memory", &["domain", "M/s", "time", "memory [MB]"], rows, |(name, time)| {
        (name.to_owned(), vec![race.median(name).map(million), time.map(thousandths), memory(name).map(|bytes| three(1e-6 * bytes))])
    });
    let findings = bench.judge("domain 1,000 times larger", "At most 1.02 times the time.", || {
        let ratio = ratio?;
        Some((format!("{ratio:.3} times."), ratio <= MOST))
    });
    Ok(Section {
        title: "A larger domain".into(),
        text: format!(
            "The block of {} particles; the cube in which it falls is ten times as wide, high and deep. Where the memory of a process lies moves \
             a time by hundredths: both are started anew again and again, and each time a few rounds are timed. `cargo bench --bench instructions` counts the instructions of such a pair.",
            size.particles()
        ),
        tables: vec![table],
        findings,
        failures: race.faults,
        ..Section::default()
    })
}
