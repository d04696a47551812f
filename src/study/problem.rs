//! A study: problems whose runs are made together and written up in one report.

use super::report::{Report, Section};
use super::runner::{self, End, Job, Progress, Runs};
use indexmap::IndexMap;

/// Problems and what stands above them.
pub struct Study {
    /// Its name as a command, and that of its report: `papers` writes `papers.md` and a folder `papers`.
    pub name: &'static str,
    /// Title of the report.
    pub title: &'static str,
    /// What is said before the first problem.
    pub text: &'static str,
    /// Columns of a table of findings: what a claim is about, the claim, what we see.
    pub heads: [&'static str; 3],
    /// Its problems, in the order of the report.
    pub problems: fn() -> Vec<Problem>,
}

/// A problem of a study.
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
    /// Coarse and short cases, in at most about a minute.
    Quick,
    /// All that a study has.
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

impl Study {
    /// Its problems, in the order of the report.
    pub fn problems(&self) -> Vec<Problem> {
        (self.problems)()
    }

    /// Runs the problems whose short names are in `only` (all where it is empty) and writes of them.
    pub fn report(&self, effort: Effort, only: &[String], progress: impl Fn(Progress) + Sync) -> Report {
        let wanted = |p: &Problem| only.is_empty() || only.iter().any(|id| id.eq_ignore_ascii_case(p.id));
        let problems: Vec<Problem> = self.problems().into_iter().filter(wanted).collect();
        let runs = runner::run(problems.iter().flat_map(|p| (p.jobs)(effort)).collect(), progress);
        let sections = problems.iter().map(|p| Section { failures: failures(p, &runs), ..(p.section)(effort, &runs) }).collect();
        Report {
            name: self.name,
            title: self.title.into(),
            text: self.introduction(effort, &runs),
            heads: self.heads,
            sections,
            data: Vec::new(),
        }
    }

    fn introduction(&self, effort: Effort, runs: &Runs) -> String {
        let steps: u64 = runs.iter().map(|run| run.substeps).sum();
        let (option, extent) = effort.pick((" --quick", "the quick subset"), ("", "everything"));
        format!(
            "Written by `matpoint study {}{option}` ({extent}: {} runs, {:.1} million steps). {}",
            self.name,
            runs.iter().count(),
            1e-6 * steps as f64,
            self.text
        )
    }
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
