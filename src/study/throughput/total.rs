//! The total-Lagrangian path against the updated one, on the same body.

use super::scenes::{self, APIC, Size};
use super::{Bench, Entry, million, three};
use crate::study::Section;
use crate::study::tools::tabulate;

const UPDATED: &str = "updated, APIC, quadratic B-splines";
const LUMPED: &str = r#"mass = "lumped""#;
const CONSISTENT: &str = r#"mass = "consistent""#;
const ROWS: [(&str, &str, &str, usize); 4] = [
    ("total, quadratic, lumped mass", "neo_hookean", LUMPED, 2),
    ("total, quadratic, consistent mass", "neo_hookean", CONSISTENT, 2),
    ("total, quadratic, consistent mass, 27 particles a cell", "neo_hookean", CONSISTENT, 3),
    ("total, quadratic, lumped mass, small strain (assembled)", "linear_elastic", LUMPED, 2),
];
/// How many times faster it must be.
const LEAST: f64 = 3.0;

pub(super) fn section(bench: &mut Bench) -> Result<Section, String> {
    let size = bench.effort.pick(Size::QUICK, Size::COMMON);
    let mut entries = vec![Entry::scene(UPDATED, scenes::block(size, APIC, 1), 20)];
    entries.extend(ROWS.iter().map(|(name, law, method, each)| Entry::scene(*name, scenes::block_alone(size, law, method, *each), 20)));
    let race = bench.race("total", &entries, bench.rounds())?;
    let names = std::iter::once(UPDATED).chain(ROWS.iter().map(|row| row.0));
    let table = tabulate("Rates (medians)", &["", "M/s", "times the updated path"], names, |name| {
        (name.to_owned(), vec![race.median(name).map(million), race.ratio(name, UPDATED).map(three)])
    });
    let findings = ROWS[..2].iter().flat_map(|(name, ..)| {
        bench.judge(name, &format!("At least {LEAST} times the updated path in double precision."), || {
            let ratio = race.ratio(name, UPDATED)?;
            Some((format!("{ratio:.2} times."), ratio >= LEAST))
        })
    });
    Ok(Section {
        title: "Total-Lagrangian formulation".into(),
        text: format!(
            "The block of {0} x {0} x {0} cells, one thread, double precision, 8 particles a cell in both formulations (Gauss points in the total \
             one) but for the row with 27, as many as the total formulation takes if nothing is said. A law of small strain has its stiffness \
             assembled, axis by axis.",
            size.block
        ),
        tables: vec![table],
        findings: findings.collect(),
        failures: race.faults,
        ..Section::default()
    })
}
