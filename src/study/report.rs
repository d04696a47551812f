//! What a study found: tables, figures and findings, as Markdown with pictures and the numbers behind them.

use super::chart::Chart;
use super::cloud::Cloud;
use super::throughput::Roofline;
use crate::draft::Draft;
use crate::record::RecordError;
use std::fmt::Write;
use std::path::{Path, PathBuf};

/// A whole report.
#[derive(Debug, Clone, PartialEq)]
pub struct Report {
    /// Of the Markdown file, without ending, and of the folder of its pictures.
    pub name: &'static str,
    /// Title.
    pub title: String,
    /// What is said before the first section.
    pub text: String,
    /// Columns of a table of findings: what a claim is about, the claim, what we see.
    pub heads: [&'static str; 3],
    /// The problems.
    pub sections: Vec<Section>,
    /// Further files beside the pictures: name and text.
    pub data: Vec<(&'static str, String)>,
}

/// One problem.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Section {
    /// Title.
    pub title: String,
    /// The problem in a few sentences (Markdown).
    pub text: String,
    /// Numbers beside those of the paper.
    pub tables: Vec<Table>,
    /// Curves.
    pub figures: Vec<Figure>,
    /// What the paper found, and whether it is found here too.
    pub findings: Vec<Finding>,
    /// Runs that did not reach their end: name and reason.
    pub failures: Vec<(String, String)>,
}

/// Numbers of the paper beside ours.
#[derive(Debug, Clone, PartialEq)]
pub struct Table {
    /// What it shows, with its number in the paper.
    pub title: String,
    /// Titles of the columns; the first is that of the row names.
    pub header: Vec<String>,
    /// Name and cells of each row.
    pub rows: Vec<(String, Vec<Cell>)>,
    /// Whose numbers stand beside ours: `paper`, or `exact`.
    pub beside: &'static str,
    /// Between which ratios (ours over the paper's) our numbers are to lie.
    pub band: Option<[f64; 2]>,
}

/// A number of the paper and ours; either may be missing.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Cell {
    /// The paper's number.
    pub paper: Option<f64>,
    /// Our number.
    pub ours: Option<f64>,
}

impl Cell {
    /// Ours over the paper's.
    pub fn ratio(&self) -> Option<f64> {
        Some(self.ours? / self.paper?)
    }
}

/// A picture, and the numbers in it.
#[derive(Debug, Clone, PartialEq)]
pub struct Figure {
    /// Name of its files, without ending.
    pub name: String,
    /// What it shows, with the numbers of the figures of the paper.
    pub caption: String,
    /// The picture.
    pub drawing: Drawing,
}

/// Kinds of pictures.
#[derive(Debug, Clone, PartialEq)]
pub enum Drawing {
    /// Curves.
    Chart(Chart),
    /// Particles in the plane.
    Cloud(Cloud),
    /// Rates below the limits of a machine.
    Roofline(Roofline),
}

impl Drawing {
    /// The picture.
    pub fn svg(&self) -> String {
        match self {
            Self::Chart(chart) => chart.svg(),
            Self::Cloud(cloud) => cloud.svg(),
            Self::Roofline(roofline) => roofline.svg(),
        }
    }

    /// The numbers behind it.
    pub fn csv(&self) -> String {
        match self {
            Self::Chart(chart) => chart.csv(),
            Self::Cloud(cloud) => cloud.csv(),
            Self::Roofline(roofline) => roofline.csv(),
        }
    }
}

/// A claim, such as one of a paper, judged by our numbers.
#[derive(Debug, Clone, PartialEq)]
pub struct Finding {
    /// What it is about: figures or tables of a paper.
    pub figure: String,
    /// What is said or required.
    pub claim: String,
    /// What we see, with our numbers in it.
    pub seen: String,
    /// Whether the claim holds by these numbers; `None` where a run that is needed for it was refused.
    pub holds: Option<bool>,
    /// What we know to be the outcome.
    pub expected: bool,
}

/// How a finding came out.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Verdict {
    /// The claim holds, as known.
    Holds,
    /// The claim does not hold, as known.
    DoesNotHold,
    /// The outcome is not the known one.
    Unexpected,
    /// Nothing to judge by.
    NotJudged,
}

impl Finding {
    /// Judges a claim: `look` gives the sentence of what is seen and whether the claim holds, or `None` where runs are missing.
    pub fn judge(
        figure: impl Into<String>,
        claim: impl Into<String>,
        expected: bool,
        look: impl FnOnce() -> Option<(String, bool)>,
    ) -> Self {
        let (seen, holds) = match look() {
            Some((seen, holds)) => (seen, Some(holds)),
            None => ("A run that this needs did not take place or ended too early.".to_owned(), None),
        };
        Self { figure: figure.into(), claim: claim.into(), seen, holds, expected }
    }

    /// How it came out.
    pub fn verdict(&self) -> Verdict {
        match self.holds {
            None => Verdict::NotJudged,
            Some(holds) if holds != self.expected => Verdict::Unexpected,
            Some(true) => Verdict::Holds,
            Some(false) => Verdict::DoesNotHold,
        }
    }
}

impl std::fmt::Display for Verdict {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.pad(match self {
            Self::Holds => "holds",
            Self::DoesNotHold => "does not hold, as known",
            Self::Unexpected => "UNEXPECTED",
            Self::NotJudged => "not judged",
        })
    }
}

impl Table {
    /// Cells with a ratio outside the band: row, column and ratio.
    pub fn outside(&self) -> Vec<(&str, &str, f64)> {
        let Some([low, high]) = self.band else { return Vec::new() };
        let cells =
            self.rows.iter().flat_map(|(row, cells)| cells.iter().zip(&self.header[1..]).map(move |(cell, column)| (row, column, cell)));
        cells
            .filter_map(|(row, column, cell)| Some((row.as_str(), column.as_str(), cell.ratio()?)))
            .filter(|(_, _, ratio)| !(low..=high).contains(ratio))
            .collect()
    }

    fn markdown(&self, out: &mut String) {
        let _ = writeln!(out, "**{}**\n", self.title);
        // three columns where the paper has numbers, one where it has none
        let known = |column: usize| self.rows.iter().any(|(_, cells)| cells.get(column).is_some_and(|cell| cell.paper.is_some()));
        let mut titles = String::new();
        let mut columns = 0;
        for (i, name) in self.header[1..].iter().enumerate() {
            let _ = if known(i) { write!(titles, " {name}: {} | ours | ratio |", self.beside) } else { write!(titles, " {name} |") };
            columns += if known(i) { 3 } else { 1 };
        }
        let _ = writeln!(out, "| {} |{titles}\n|---|{}", self.header[0], "---:|".repeat(columns));
        let text = |value: Option<f64>| value.map_or("-".to_owned(), number);
        for (name, cells) in &self.rows {
            let _ = write!(out, "| {name} |");
            for (i, cell) in cells.iter().enumerate() {
                if known(i) {
                    let ratio = cell.ratio().map_or("-".to_owned(), |ratio| format!("{ratio:.4}"));
                    let _ = write!(out, " {} | {} | {ratio} |", text(cell.paper), text(cell.ours));
                } else {
                    let _ = write!(out, " {} |", text(cell.ours));
                }
            }
            out.push('\n');
        }
        if let Some([low, high]) = self.band {
            let outside = self.outside().len();
            let _ = writeln!(out, "\nThe ratio is to lie between {low} and {high}; it is outside in {outside} cells.");
        }
        out.push('\n');
    }
}

/// Five digits, as in tables of papers.
pub fn number(value: f64) -> String {
    if value == 0.0 || (1e-3..1e5).contains(&value.abs()) {
        let decimals = (4 - value.abs().max(1e-3).log10().floor() as i32).clamp(0, 7) as usize;
        let text = format!("{value:.decimals$}");
        if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
    } else {
        format!("{value:.4e}")
    }
}

impl Section {
    /// Its Markdown; pictures lie in the folder `pictures`.
    fn markdown(&self, out: &mut String, heads: &[&str; 3], pictures: &str) {
        let _ = writeln!(out, "## {}\n\n{}\n", self.title, self.text.trim());
        if !self.findings.is_empty() {
            let _ = writeln!(out, "| {} | |\n|---|---|---|---|", heads.join(" | "));
            for f in &self.findings {
                let _ = writeln!(out, "| {} | {} | {} | {} |", f.figure, f.claim, f.seen, f.verdict());
            }
            out.push('\n');
        }
        self.tables.iter().for_each(|table| table.markdown(out));
        for figure in &self.figures {
            let Figure { name, caption, .. } = figure;
            let _ = writeln!(out, "![{caption}]({pictures}/{name}.svg)\n\n*{caption}* (numbers: `{pictures}/{name}.csv`)\n");
        }
        if !self.failures.is_empty() {
            out.push_str("Runs that did not reach their end:\n\n");
            for (name, reason) in &self.failures {
                let _ = writeln!(out, "- `{name}`: {}", reason.replace('\n', "; "));
            }
            out.push('\n');
        }
    }
}

impl Report {
    /// All findings with the title of their section.
    pub fn findings(&self) -> impl Iterator<Item = (&str, &Finding)> {
        self.sections.iter().flat_map(|s| s.findings.iter().map(|f| (s.title.as_str(), f)))
    }

    /// The Markdown text.
    pub fn markdown(&self) -> String {
        let mut out = format!("# {}\n\n{}\n\n", self.title, self.text.trim());
        self.sections.iter().for_each(|section| section.markdown(&mut out, &self.heads, self.name));
        // one line break at the end
        out.truncate(out.trim_end().len());
        out.push('\n');
        out
    }

    /// Writes `NAME.md`, and `NAME/*.svg` and `NAME/*.csv`, to a folder. Every file is written whole before the first takes its name,
    /// so that a report is old or new, but not half of each.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn write(&self, folder: &Path) -> Result<Vec<PathBuf>, RecordError> {
        let pictures = folder.join(self.name);
        std::fs::create_dir_all(&pictures).map_err(RecordError::write(&pictures))?;
        let mut files = Vec::new();
        for figure in self.sections.iter().flat_map(|s| &s.figures) {
            files.push((pictures.join(format!("{}.svg", figure.name)), figure.drawing.svg()));
            files.push((pictures.join(format!("{}.csv", figure.name)), figure.drawing.csv()));
        }
        files.extend(self.data.iter().map(|(name, text)| (pictures.join(name), text.clone())));
        // the text last: it names the others
        files.push((folder.join(format!("{}.md", self.name)), self.markdown()));
        let draft = |(path, text): &(PathBuf, String)| {
            let mut draft = Draft::create(path)?;
            draft.write(text)?;
            Ok(draft)
        };
        let drafts = files.iter().map(draft).collect::<Result<Vec<_>, RecordError>>()?;
        drafts.into_iter().map(Draft::finish).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::super::chart::{Axis, Series, Style};
    use super::*;

    fn report() -> Report {
        let chart = Chart::new("c", Axis::new("x", ""), Axis::new("y", ""), [Series::new("s", Style::Line, [[0.0, 1.0]])]);
        let cell = |paper, ours| Cell { paper: Some(paper), ours };
        let table = Table {
            title: "t".into(),
            header: vec!["cells".into(), "a".into(), "b".into()],
            rows: vec![("4".into(), vec![cell(2.0, Some(2.1)), cell(1e-7, None)])],
            beside: "paper",
            band: Some([0.99, 1.01]),
        };
        let finding = |holds| Finding::judge("1", "it is so", true, || holds);
        let section = Section {
            title: "one".into(),
            tables: vec![table],
            figures: vec![Figure { name: "c".into(), caption: "curve".into(), drawing: Drawing::Chart(chart) }],
            findings: vec![finding(Some(("yes".into(), true))), finding(Some(("no".into(), false))), finding(None)],
            ..Section::default()
        };
        Report {
            name: "papers",
            title: "all".into(),
            text: String::new(),
            heads: ["figure", "claim", "seen"],
            sections: vec![section],
            data: vec![("d.csv", "1\n".into())],
        }
    }

    #[test]
    fn verdicts_and_bands() {
        let report = report();
        let verdicts: Vec<Verdict> = report.findings().map(|(_, f)| f.verdict()).collect();
        assert_eq!(verdicts, [Verdict::Holds, Verdict::Unexpected, Verdict::NotJudged]);
        assert_eq!(report.sections[0].tables[0].outside(), [("4", "a", 1.05)]);
        let text = report.markdown();
        assert!(text.contains("| 4 | 2 | 2.1 | 1.0500 | 1.0000e-7 | - | - |") && text.contains("papers/c.svg"), "{text}");
    }

    #[test]
    fn numbers_have_five_digits() {
        assert_eq!([0.0, 1.94983, 12345.67, 0.0012345, 4.8784e-6].map(number), ["0", "1.9498", "12346", "0.0012345", "4.8784e-6"]);
    }

    #[test]
    fn writes_all_files_at_once() {
        let folder = tempfile::tempdir().unwrap();
        let files = report().write(folder.path()).unwrap();
        assert_eq!(files.len(), 4);
        assert!(files.iter().all(|file| file.exists()));
        assert_eq!(std::fs::read_dir(folder.path().join("papers")).unwrap().count(), 3);
    }
}
