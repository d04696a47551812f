//! Other bases, other transfers, the plane, other instructions: how fast they are, and how fast the common work says that they could be.

use super::machine::Instructions;
use super::scenes::{self, APIC, Size};
use super::{Bench, Count, Entry, million, three};
use crate::study::Section;
use crate::study::tools::tabulate;

struct Row {
    name: &'static str,
    scene: String,
    count: Count,
    instructions: Option<Instructions>,
}

const COMMON: &str = "APIC, quadratic B-splines (the common work)";

fn rows(bench: &Bench) -> Vec<Row> {
    let size = bench.effort.pick(Size::QUICK, Size::COMMON);
    let space = |name, method: &str, width, affine| Row {
        name,
        scene: scenes::block(size, method, 1),
        count: Count { width, affine, ..Count::COMMON },
        instructions: None,
    };
    let plane = |name, method: &str, width| Row {
        name,
        scene: scenes::cantilever(bench.effort.pick(16, 128), method),
        count: Count { dimension: 2, width, in_cell: 4, ..Count::COMMON },
        instructions: None,
    };
    let mut rows = vec![
        space(COMMON, APIC, 3, true),
        space("FLIP, quadratic B-splines", r#"transfer = "flip", integrator = "usl""#, 3, false),
        space("APIC, linear", &format!(r#"{APIC}, basis = "linear""#), 2, true),
        space("APIC, cubic B-splines", &format!("{APIC}, degree = 3"), 4, true),
        space("APIC, GIMP, domains that keep their size", &format!(r#"{APIC}, basis = "gimp", domain = "uniform""#), 3, true),
        space("APIC, GIMP, domains that follow", &format!(r#"{APIC}, basis = "gimp""#), 4, true),
        plane("2D, APIC, quadratic B-splines", APIC, 3),
        plane("2D, APIC, linear", &format!(r#"{APIC}, basis = "linear""#), 2),
    ];
    // what the processor has beside the best, by hand
    let named = |name, set| Row { instructions: Some(set), ..space(name, APIC, 3, true) };
    let sets = Instructions::all().into_iter().skip(1);
    rows.extend(sets.map(|set| match set {
        Instructions::Portable => named("APIC, quadratic B-splines, portable", set),
        _ => named("APIC, quadratic B-splines, AVX2", set),
    }));
    rows
}

/// How many times slower than predicted a row may be.
const SLACK: f64 = 1.5;

pub(super) fn section(bench: &mut Bench) -> Result<Section, String> {
    let machine = bench.machine()?.clone();
    let rows = rows(bench);
    let entry = |row: &Row| {
        let entry = Entry::scene(row.name, row.scene.clone(), 20);
        match row.instructions {
            Some(set) => entry.instructions(set.name()),
            None => entry,
        }
    };
    let race = bench.race("bases", &rows.iter().map(entry).chain([Entry::peak()]).collect::<Vec<_>>(), bench.rounds())?;
    // times as slow as the common work, were all at the same share of what bounds them: operations, or bytes
    let work = |row: &Row| {
        let peak = row.instructions.map_or(machine.peak(), |set| machine.peak_of(set));
        let common = Count::COMMON;
        f64::max(row.count.flops() / common.flops() * machine.peak() / peak, row.count.bytes() / common.bytes())
    };
    // measured over predicted time
    let slower = |row: &Row| Some(1.0 / work(row) / race.ratio(row.name, COMMON)?);
    let header = ["", "M/s", "flop", "B", "predicted M/s", "predicted / measured"];
    let table = tabulate("Rates, and those predicted from the first row", &header, &rows, |row| {
        let rate = race.median(row.name);
        let slower = slower(row);
        let predicted = rate.zip(slower).map(|(rate, slower)| million(rate * slower));
        let cells = vec![rate.map(million), Some(row.count.flops()), Some(row.count.bytes()), predicted, slower.map(three)];
        (row.name.to_owned(), cells)
    });
    for row in rows.iter().skip(1) {
        if let Some(rate) = race.at_peak(row.name, machine.peak()) {
            bench.points.push((row.name.to_owned(), row.count, rate));
        }
    }
    let findings =
        bench.judge("every row", &format!("Within {SLACK} times of what its flops and bytes predict from the common work."), || {
            let worst = rows.iter().map(|row| Some((row.name, slower(row)?))).collect::<Option<Vec<_>>>()?;
            let (name, most) = worst.into_iter().max_by(|a, b| a.1.total_cmp(&b.1))?;
            Some((format!("The furthest is {most:.2} times slower: {name}."), most <= SLACK))
        });
    Ok(Section {
        title: "Other bases, transfers, dimensions and instructions".into(),
        text: "Predicted: as many times the time of the common work as there are more operations, or more bytes, whichever is more; other \
               instructions do as many operations in a second as their multiply-adds. One thread, double precision. Domains \
               of GIMP that keep their size meet three nodes an axis, those that follow the deformation may grow to two cells and meet four."
            .into(),
        tables: vec![table],
        findings,
        failures: race.faults,
        ..Section::default()
    })
}
