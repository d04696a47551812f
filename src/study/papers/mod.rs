//! The problems of three papers, run and compared number by number and figure by figure.
//!
//! A paper is a module; a problem is a [`Problem`]: the jobs that it needs and the section that is written from their runs. All jobs of
//! all problems are run together.

mod andersen;
mod buzzi;
mod tielen;
mod tools;

use super::report::{Report, Section};
use super::runner::{self, End, Job, Progress, Runs};
use indexmap::IndexMap;

/// A problem of a paper.
pub struct Problem {
    /// Short name, such as `T1`; the names of its jobs begin with it and a slash.
    pub id: &'static str,
    /// What it is, in one line.
    pub title: &'static str,
    /// The runs it needs.
    pub jobs: fn(Effort) -> Vec<Job>,
    /// What is written of them.
    pub section: fn(Effort, &Runs) -> Section,
}

/// How much is run.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Effort {
    /// Coarse and short cases, in about ten seconds.
    Quick,
    /// All that the papers have.
    Full,
}

impl Effort {
    /// One value or the other.
    pub fn pick<T>(self, quick: T, full: T) -> T {
        match self {
            Self::Quick => quick,
            Self::Full => full,
        }
    }
}

/// All problems, in the order of the report.
pub fn problems() -> Vec<Problem> {
    tielen::problems().into_iter().chain(andersen::problems()).chain(buzzi::problems()).collect()
}

/// Runs the problems whose short names are in `only` (all where it is empty) and writes of them.
pub fn report(effort: Effort, only: &[String], progress: impl Fn(Progress) + Sync) -> Report {
    let wanted = |p: &Problem| only.is_empty() || only.iter().any(|id| id.eq_ignore_ascii_case(p.id));
    let problems: Vec<Problem> = problems().into_iter().filter(wanted).collect();
    let runs = runner::run(problems.iter().flat_map(|p| (p.jobs)(effort)).collect(), progress);
    let sections = problems.iter().map(|p| Section { failures: failures(p, &runs), ..(p.section)(effort, &runs) }).collect();
    Report { title: "The papers, number by number".into(), text: introduction(effort, &runs), sections }
}

fn introduction(effort: Effort, runs: &Runs) -> String {
    let steps: u64 = runs.iter().map(|run| run.substeps).sum();
    let (command, extent) = effort.pick(("matpoint study papers --quick", "the quick subset"), ("matpoint study papers", "everything"));
    format!(
        "Written by `{command}` ({extent}: {} runs, {:.1} million steps). Every number that is not marked as the paper's was computed by \
         that command. Figures of the papers are known to us by their captions and by what the text says of them; a finding is that \
         sentence, judged by our numbers.",
        runs.iter().count(),
        1e-6 * steps as f64
    )
}

/// Runs of a problem that did not reach their end; those with the same reason together.
fn failures(problem: &Problem, runs: &Runs) -> Vec<(String, String)> {
    let own = runs.iter().filter(|run| run.name.split('/').next() == Some(problem.id));
    let mut by_reason: IndexMap<String, Vec<&str>> = IndexMap::new();
    for run in own {
        let reason = match &run.end {
            End::Done => continue,
            End::Failed(reason) => reason.clone(),
            End::Refused(reason) => format!("refused: {reason}"),
        };
        by_reason.entry(reason).or_default().push(&run.name);
    }
    let names = |names: Vec<&str>| match names[..] {
        [first, _, ..] => format!("{first} and {} more", names.len() - 1),
        _ => names.concat(),
    };
    by_reason.into_iter().map(|(reason, list)| (names(list), reason)).collect()
}
