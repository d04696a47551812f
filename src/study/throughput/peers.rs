//! Other codes on the same work, in the same run: what `benches/peers/run` found.

use super::{Bench, three};
use crate::study::report::Section;
use crate::study::{Cell, Table};

/// A row of `peers.csv`.
#[derive(Debug, Clone, PartialEq)]
struct Row {
    /// What all codes are given: particles, precision, order in memory, threads.
    work: [String; 4],
    code: String,
    /// Median \[particle-steps/s\].
    rate: f64,
    /// Median of the ratios of each round: how many times faster matpoint is.
    ratio: f64,
}

const HEADER: &str = "particles,precision,order,threads,code,rate,ratio,rounds";
const OURS: &str = "matpoint";
const TUNED: &str = "taichi, hand-tuned";

fn read(text: &str) -> Result<Vec<Row>, String> {
    let mut lines = text.lines();
    if lines.next() != Some(HEADER) {
        return Err(format!("the first line is not `{HEADER}`"));
    }
    let row = |line: &str| {
        // names of codes have commas and are in quotes, as JSON has them
        let fields: Vec<serde_json::Value> = serde_json::from_str(&format!("[{line}]")).ok()?;
        let [particles, precision, order, threads, code, rate, ratio, _] = fields.try_into().ok()?;
        let text = |v: serde_json::Value| v.as_str().map(str::to_owned).or_else(|| Some(v.as_u64()?.to_string()));
        let work = [text(particles)?, text(precision)?, text(order)?, text(threads)?];
        Some(Row { work, code: text(code)?, rate: rate.as_f64()?, ratio: ratio.as_f64()? })
    };
    lines.map(|line| row(line).ok_or_else(|| format!("cannot be read: `{line}`"))).collect()
}

pub(super) fn section(bench: &mut Bench) -> Result<Section, String> {
    let title = "Other codes, in the same run".to_owned();
    let text = "The common work in taichi 1.7.4 (a hand-tuned program: a private grid a thread, no atomic additions, packed nodes; and the usual \
                program, as in its example mpm3d) and in warp, which has one thread; positions jittered in the order of cells, or shuffled. Each \
                round steps every code in turn. Rates in M/s; beside each how many times faster matpoint is."
        .to_owned();
    let rows = match std::fs::read_to_string(bench.peers) {
        Ok(found) => read(&found).map_err(|fault| format!("{}: {fault}", bench.peers.display()))?,
        Err(_) => {
            let absent = format!("{text}\n\nNot measured here: `benches/peers/run` writes `{}`.", bench.peers.display());
            return Ok(Section { title, text: absent, ..Section::default() });
        }
    };
    let mut works: Vec<&[String; 4]> = rows.iter().map(|row| &row.work).collect();
    works.dedup();
    let mut codes: Vec<&str> = Vec::new();
    for row in &rows {
        if !codes.contains(&row.code.as_str()) {
            codes.push(&row.code);
        }
    }
    let find = |work: &[String; 4], code: &str| rows.iter().find(|row| &row.work == work && row.code == code);
    let header = ["particles, precision, order, threads".to_owned()].into_iter();
    let header = header.chain(codes.iter().flat_map(|&code| {
        let ratio = (code != OURS).then(|| format!("{OURS} / {code}"));
        [Some(code.to_owned()), ratio].into_iter().flatten()
    }));
    let cells = |work: &[String; 4]| -> Vec<Cell> {
        let both = |code: &&str| {
            let row = find(work, code);
            let rate = Some(row.map(|row| three(1e-6 * row.rate)));
            [rate, (*code != OURS).then(|| row.map(|row| three(row.ratio)))].into_iter().flatten()
        };
        codes.iter().flat_map(both).map(|ours| Cell { paper: None, ours }).collect()
    };
    let table = Table {
        title: "Particle-steps a second".into(),
        header: header.collect(),
        rows: works.iter().map(|work| (work.join(", "), cells(work))).collect(),
        beside: "",
        band: None,
    };
    let least = |order: &str| {
        let own = rows.iter().filter(|row| row.code == TUNED && row.work[2] == order && row.work[3] == "1").map(|row| row.ratio);
        own.min_by(f64::total_cmp)
    };
    let mut findings = Vec::new();
    for (order, factor) in [("cells", 3.3), ("shuffled", 5.0)] {
        let what = format!("{TUNED}, one thread, {order}");
        findings.extend(bench.judge(&what, &format!("At least {factor} times faster, in both sizes and precisions."), || {
            let ratio = least(order)?;
            Some((format!("{ratio:.2} times at the least."), ratio >= factor))
        }));
    }
    Ok(Section { title, text, tables: vec![table], findings, ..Section::default() })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reads_what_the_race_writes() {
        let line = r#"97336,"double","cells",1,"taichi, hand-tuned",5.8e6,3.5,9"#;
        let rows = read(&format!("{HEADER}\n{line}\n")).unwrap();
        assert_eq!((rows[0].code.as_str(), rows[0].rate, rows[0].ratio), (TUNED, 5.8e6, 3.5));
        assert_eq!(rows[0].work.join(" "), "97336 double cells 1");
        assert!(read("other\n").is_err() && read(&format!("{HEADER}\n1,2\n")).is_err());
    }
}
