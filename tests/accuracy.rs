//! The problems with known answers, coarse and short: what is known of them comes out.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

use matpoint::study::accuracy::STUDY;
use matpoint::study::{Effort, Report, Verdict};
use std::collections::BTreeSet;
use std::sync::OnceLock;

/// The quick subset, run once for all tests.
fn quick() -> &'static Report {
    static REPORT: OnceLock<Report> = OnceLock::new();
    REPORT.get_or_init(|| STUDY.report(Effort::Quick, &[], |_| {}))
}

#[test]
fn every_finding_is_judged_and_comes_out_as_known() {
    for (section, finding) in quick().findings() {
        println!("{section}: {}: {} [{}]", finding.figure, finding.seen, finding.verdict());
        assert_ne!(finding.verdict(), Verdict::NotJudged, "{section}, {}: {}", finding.figure, finding.claim);
        assert_ne!(finding.verdict(), Verdict::Unexpected, "{section}, {}: {} {}", finding.figure, finding.claim, finding.seen);
    }
}

#[test]
fn every_run_reaches_its_end() {
    for section in &quick().sections {
        assert_eq!(section.failures, [], "{}", section.title);
    }
}

#[test]
fn every_problem_has_a_finding_a_table_and_a_picture() {
    assert_eq!(quick().sections.len(), STUDY.problems().len());
    for section in &quick().sections {
        assert!(!section.findings.is_empty() && !section.tables.is_empty() && !section.figures.is_empty(), "{}", section.title);
    }
}

#[test]
fn pictures_are_sound() {
    let text = quick().markdown();
    let mut seen = BTreeSet::new();
    for figure in quick().sections.iter().flat_map(|section| &section.figures) {
        let (svg, csv) = (figure.drawing.svg(), figure.drawing.csv());
        assert!(svg.starts_with("<svg") && !svg.contains("NaN") && !svg.contains("inf "), "{}", figure.name);
        assert!(csv.lines().count() > 1 && text.contains(&format!("accuracy/{}.svg", figure.name)), "{}", figure.name);
        assert!(seen.insert(&figure.name), "{} twice", figure.name);
    }
}

#[test]
fn names_of_jobs_are_unique_and_begin_with_their_problem() {
    for effort in [Effort::Quick, Effort::Full] {
        let mut seen = BTreeSet::new();
        for problem in STUDY.problems() {
            for job in (problem.jobs)(effort) {
                assert!(job.name().starts_with(&format!("{}/", problem.id)), "{}", job.name());
                assert!(seen.insert(job.name().to_owned()), "{} twice", job.name());
            }
        }
    }
}
