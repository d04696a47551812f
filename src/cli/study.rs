//! `matpoint study`.

use super::Failure;
use crate::{GalleryArgs, StudyArgs};
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use matpoint::study::{Effort, Progress, Report, Study, Verdict, throughput};
use matpoint::text::duration;
use std::io::Write;
use std::path::Path;
use std::time::Instant;

/// Runs the problems of a study (all where `only` is empty), writes the report, prints a line for each finding.
pub(crate) fn study(study: &Study, args: &StudyArgs, only: &[String]) -> Result<(), Failure> {
    let effort = if args.quick { Effort::Quick } else { Effort::Full };
    let start = Instant::now();
    let bar = progress_bar(args.quiet, "runs");
    let report = study.report(effort, only, |at| show(&bar, &at));
    bar.finish_and_clear();
    finish(&report, args, start)
}

/// Measures parts of the study of throughput (all where `only` is empty), writes the report, prints a line for each finding.
pub(crate) fn throughput(args: &StudyArgs, only: &[String]) -> Result<(), Failure> {
    let effort = if args.quick { Effort::Quick } else { Effort::Full };
    let start = Instant::now();
    let program = std::env::current_exe()?;
    let bar = progress_bar(args.quiet, "parts");
    let report = throughput::report(effort, only, &program, Path::new("target/peers/peers.csv"), &|at| show(&bar, &at));
    bar.finish_and_clear();
    finish(&report, args, start)
}

fn finish(report: &Report, args: &StudyArgs, start: Instant) -> Result<(), Failure> {
    let files = report.write(&args.out).map_err(Failure::Report)?;

    let mut out = std::io::stdout().lock();
    let mut unexpected = 0;
    for section in &report.sections {
        writeln!(out, "{}", section.title)?;
        for finding in &section.findings {
            let verdict = finding.verdict();
            unexpected += usize::from(verdict == Verdict::Unexpected);
            writeln!(out, "  {verdict:24} {}: {}", finding.figure, finding.claim)?;
            if verdict == Verdict::Unexpected {
                writeln!(out, "  {:24} {}", "", finding.seen)?;
            }
        }
        for table in &section.tables {
            for (row, column, ratio) in table.outside() {
                unexpected += 1;
                writeln!(out, "  {:24} {}: row {row}, {column}: ratio {ratio:.4}", Verdict::Unexpected, table.title)?;
            }
        }
        for (name, reason) in &section.failures {
            writeln!(out, "  {:24} {name}: {}", "did not end", reason.replace('\n', "; "))?;
        }
    }
    writeln!(out, "wrote {} files in {}", files.len(), duration(start.elapsed().as_secs_f64()))?;
    if let Some(text) = files.last() {
        writeln!(out, "read: {}", text.display())?;
    }
    if unexpected > 0 { Err(Failure::Unexpected { count: unexpected }) } else { Ok(()) }
}

/// Draws the scenes of the gallery.
pub(crate) fn gallery(args: &GalleryArgs) -> Result<(), Failure> {
    let start = Instant::now();
    let bar = ProgressBar::new_spinner();
    let files = matpoint::study::gallery(&args.out, &mut |name| {
        bar.set_message(name.to_owned());
        bar.tick();
    });
    bar.finish_and_clear();
    let files = files?;
    let mut out = std::io::stdout().lock();
    files.iter().try_for_each(|file| writeln!(out, "wrote {}", file.display()))?;
    writeln!(out, "{} files in {}", files.len(), duration(start.elapsed().as_secs_f64()))?;
    Ok(())
}

/// A bar on stderr; indicatif draws nothing where that is no terminal.
fn progress_bar(quiet: bool, what: &str) -> ProgressBar {
    let target = if quiet { ProgressDrawTarget::hidden() } else { ProgressDrawTarget::stderr() };
    let template = format!("{{bar:30}} {{pos}}/{{len}} {what}, {{elapsed}}  {{msg}}");
    let style = ProgressStyle::with_template(&template).unwrap_or_else(|_| ProgressStyle::default_bar());
    ProgressBar::with_draw_target(None, target).with_style(style)
}

fn show(bar: &ProgressBar, at: &Progress) {
    bar.set_length(at.total as u64);
    bar.set_position(at.done as u64);
    bar.set_message(at.name.clone());
}
