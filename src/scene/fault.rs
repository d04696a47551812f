//! What is wrong with a scene, and where.

use std::fmt;
use std::path::{Path, PathBuf};

/// One thing that is wrong with a scene.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Fault {
    /// The field, as in `body.beam.shape.box.min[1]`; empty where the scene as a whole is meant.
    pub path: String,
    /// Line in the file, from 1; `None` for scenes built in code and for values that come from `--set`.
    pub line: Option<usize>,
    /// Column in that line, in characters from 1.
    pub column: Option<usize>,
    /// The `key=value` of the `--set` that brought the value in.
    pub setting: Option<String>,
    /// What is wrong and what would be right.
    pub message: String,
}

impl Fault {
    /// A fault of the field `path`, without a place.
    pub fn new(path: impl Into<String>, message: impl Into<String>) -> Self {
        Self { path: path.into(), line: None, column: None, setting: None, message: message.into() }
    }

    /// The same fault at `line` and `column`, both from 1.
    pub fn at(self, (line, column): (usize, usize)) -> Self {
        Self { line: Some(line), column: Some(column), ..self }
    }
}

/// `12:8: body.beam.particles_per_cell: is 0; must be 1 to 16`, less what is not known.
impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match (&self.setting, self.line, self.column) {
            (Some(setting), _, _) => write!(f, "--set {setting}: ")?,
            (None, Some(line), Some(column)) => write!(f, "{line}:{column}: ")?,
            _ => {}
        }
        if !self.path.is_empty() {
            write!(f, "{}: ", self.path)?;
        }
        f.write_str(&self.message)
    }
}

/// Why there is no scene. Prints one line a fault, as compilers do: `scene.toml:12:8: body.beam.seed: ...`.
#[derive(Debug, thiserror::Error)]
pub enum SceneError {
    /// The file cannot be read.
    #[error("{}: cannot be read: {source}", file.display())]
    Read {
        /// The file asked for.
        file: PathBuf,
        /// What the operating system said.
        source: std::io::Error,
    },
    /// The scene is not well-formed or makes no sense: every fault that was found, in the order of the file.
    #[error("{}", lines(file.as_deref(), faults))]
    Faults {
        /// The file, for scenes that come from one.
        file: Option<PathBuf>,
        /// At least one.
        faults: Vec<Fault>,
    },
}

impl SceneError {
    /// Every fault that was found; none where the file could not be read.
    pub fn faults(&self) -> &[Fault] {
        match self {
            Self::Read { .. } => &[],
            Self::Faults { faults, .. } => faults,
        }
    }
}

fn lines(file: Option<&Path>, faults: &[Fault]) -> String {
    let line = |fault: &Fault| match (file, &fault.setting) {
        (Some(file), None) if fault.line.is_some() => format!("{}:{fault}", file.display()),
        (Some(file), None) => format!("{}: {fault}", file.display()),
        _ => fault.to_string(),
    };
    faults.iter().map(line).collect::<Vec<_>>().join("\n")
}

/// The candidate that `name` was most likely meant to be: the one with the fewest typing mistakes (letters wrong, missing, too
/// many or swapped), as long as these are at most a third of the letters. Case counts for nothing.
pub fn nearest<'a>(name: &str, candidates: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    // No name in a scene is this long; the comparison takes the product of the lengths.
    const LONGEST: usize = 100;
    if name.len() > LONGEST {
        return None;
    }
    let name = name.to_lowercase();
    candidates
        .into_iter()
        .filter(|candidate| candidate.len() <= LONGEST)
        .map(|candidate| (strsim::damerau_levenshtein(&name, &candidate.to_lowercase()), candidate))
        .filter(|&(mistakes, candidate)| {
            let letters = name.chars().count().max(candidate.chars().count());
            mistakes <= (letters / 3).max(1) && mistakes < letters
        })
        .min_by_key(|&(mistakes, _)| mistakes)
        .map(|(_, candidate)| candidate)
}

/// `; did you mean `density`?; allowed: young, density`, without the question where no candidate is near.
pub(super) fn hint(name: &str, candidates: &[&str]) -> String {
    let guess = nearest(name, candidates.iter().copied()).map_or(String::new(), |near| format!("; did you mean `{near}`?"));
    if candidates.is_empty() { "; none are allowed".into() } else { format!("{guess}; allowed: {}", candidates.join(", ")) }
}

/// `1 part`, `2 parts`.
pub(super) fn counted(count: usize, what: &str) -> String {
    format!("{count} {what}{}", if count == 1 { "" } else { "s" })
}

/// A number as a person would write it: `0.25`, `2.1e11`.
pub(super) fn plain(value: f64) -> String {
    let size = value.abs();
    if value == 0.0 || !value.is_finite() || (1e-4..1e7).contains(&size) { format!("{value}") } else { format!("{value:e}") }
}

/// A computed number to six digits, so that round-off does not show.
pub(super) fn short(value: f64) -> String {
    plain(format!("{value:.5e}").parse().unwrap_or(value))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_fault_says_what_it_knows() {
        let fault = Fault::new("body.beam.seed", "is -1");
        assert_eq!(fault.to_string(), "body.beam.seed: is -1");
        assert_eq!(fault.clone().at((12, 8)).to_string(), "12:8: body.beam.seed: is -1");
        let set = Fault { setting: Some("body.beam.seed=-1".into()), ..fault.clone() };
        assert_eq!(set.to_string(), "--set body.beam.seed=-1: body.beam.seed: is -1");
        let error = SceneError::Faults { file: Some("s.toml".into()), faults: vec![fault.clone().at((2, 1)), set, fault] };
        let lines: Vec<String> = error.to_string().lines().map(String::from).collect();
        assert_eq!(lines[0], "s.toml:2:1: body.beam.seed: is -1");
        assert_eq!(lines[1], "--set body.beam.seed=-1: body.beam.seed: is -1");
        assert_eq!(lines[2], "s.toml: body.beam.seed: is -1");
    }

    #[test]
    fn nearest_forgives_typing_and_does_not_guess_wildly() {
        let keys = ["young", "poisson", "density", "law"];
        assert_eq!(nearest("densty", keys), Some("density"));
        assert_eq!(nearest("Yonug", keys), Some("young"));
        assert_eq!(nearest("-x", ["x-", "x+", "y-"]), Some("x-"));
        assert_eq!(nearest("colour", keys), None);
        assert_eq!(nearest("q", ["x", "y"]), None);
        assert_eq!(nearest("", keys), None);
        assert_eq!(nearest(&"density".repeat(1000), keys), None);
    }

    #[test]
    fn numbers_read_well() {
        assert_eq!([plain(0.25), plain(2.1e11), plain(-0.0), plain(f64::NAN)], ["0.25", "2.1e11", "-0", "NaN"]);
        assert_eq!(short(0.1 + 0.2), "0.3");
    }
}
