//! What a simulation is, as data, as text and as HTML.

use super::auto::Choice;
use super::variable::{Causality, Variable};
use crate::text::{bytes, grouped, pairs, si, table};
use std::fmt;

/// What a simulation is: returned by [`crate::Simulation::describe`].
#[derive(Debug, Clone, PartialEq)]
pub struct Description {
    /// Title of the scene.
    pub title: String,
    /// Number of space dimensions.
    pub dimension: usize,
    /// Number of particles.
    pub particles: usize,
    /// Bodies in the order of `particle/body`: name and number of particles.
    pub bodies: Vec<(String, usize)>,
    /// The point chosen in the table formulation x basis x quadrature x mass x transfer x integrator, in words.
    pub method: Vec<(&'static str, String)>,
    /// What `method = "auto"` has chosen, and why; empty where the scene names its method.
    pub choices: Vec<Choice>,
    /// What this scene needs, and so costs.
    pub needs: Vec<String>,
    /// What this scene does not need, and so does not cost.
    pub skips: Vec<String>,
    /// Memory of particles, grid and tables \[bytes\].
    pub memory: usize,
    /// Largest stable step at time 0 \[s\]; infinite where steps are implicit.
    pub stable_step: f64,
    /// End of a run, as the scene has it \[s\].
    pub end: f64,
    /// All variables.
    pub variables: Vec<Variable>,
}

/// The head of each column of the list of variables.
const COLUMNS: [&str; 5] = ["name", "", "unit", "shape", "meaning"];

impl Description {
    fn sizes(&self) -> Vec<(&'static str, String)> {
        let list = |(name, count): &(String, usize)| format!("{name} ({})", grouped(*count as u64));
        vec![
            ("dimension", self.dimension.to_string()),
            ("particles", grouped(self.particles as u64)),
            ("bodies", self.bodies.iter().map(list).collect::<Vec<_>>().join(", ")),
            ("memory", bytes(self.memory)),
            ("stable step", if self.stable_step.is_finite() { si(self.stable_step, "s") } else { "any: steps are implicit".into() }),
            ("end", si(self.end, "s")),
        ]
    }

    /// Why the method is what it is, what the scene needs and what it does not, each with a heading.
    fn lists(&self) -> impl Iterator<Item = (&'static str, Vec<String>)> {
        let choices = self.choices.iter().map(|choice| format!("{} = {}: {}", choice.part, choice.chosen, choice.why)).collect();
        let lists =
            [("chosen by method = \"auto\"", choices), ("needs", self.needs.clone()), ("skips, and so does not cost", self.skips.clone())];
        lists.into_iter().filter(|(_, lines)| !lines.is_empty())
    }

    fn rows(&self) -> Vec<[String; 5]> {
        self.variables.iter().map(row).collect()
    }

    /// The same as HTML, for notebooks.
    pub fn html(&self) -> String {
        let cell = |text: &str| format!("<td style=\"text-align:left\">{}</td>", escape(text));
        let line = |cells: &[&str]| format!("<tr>{}</tr>", cells.iter().map(|text| cell(text)).collect::<String>());
        let pairs = |rows: &[(&str, String)]| rows.iter().map(|(name, value)| line(&[name, value])).collect::<String>();
        let lists: String = self.lists().map(|(title, lines)| line(&[title, &lines.join("; ")])).collect();
        let variables: String = self.rows().iter().map(|row| line(&row.each_ref().map(String::as_str))).collect();
        format!(
            "<b>{}</b><table>{}{}{lists}</table><details><summary>{} variables</summary><table>{}{variables}</table></details>",
            escape(&self.title),
            pairs(&self.sizes()),
            pairs(&self.method),
            self.variables.len(),
            line(&COLUMNS),
        )
    }
}

impl fmt::Display for Description {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{}", self.title)?;
        f.write_str(&pairs(self.sizes()))?;
        write!(f, "\nmethod\n{}", pairs(self.method.iter().map(|(name, choice)| (*name, choice.clone()))))?;
        for (title, lines) in self.lists() {
            writeln!(f, "\n{title}")?;
            lines.iter().try_for_each(|line| writeln!(f, "  {line}"))?;
        }
        write!(f, "\nvariables\n{}", table(COLUMNS, &self.rows()))
    }
}

fn row(variable: &Variable) -> [String; 5] {
    let causality = match variable.causality {
        Causality::Input => "in",
        Causality::Output => "out",
    };
    let unit = if variable.unit.is_empty() { "-" } else { variable.unit };
    let shape: Vec<String> = variable.shape.iter().map(usize::to_string).collect();
    let shape = if shape.is_empty() { "-".to_owned() } else { shape.join(" x ") };
    [variable.name.clone(), causality.to_owned(), unit.to_owned(), shape, variable.doc.to_owned()]
}

fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}
