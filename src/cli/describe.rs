//! `matpoint check`, `describe` and `schema`.

use super::text::{bytes, grouped, pairs, si, table};
use super::{Failure, load, warn};
use crate::SceneArgs;
use matpoint::component::{Causality, Description, Variable};
use matpoint::scene::Scene;
use std::io::Write;

/// Says that a scene is sound; what is not sound is an error.
pub(crate) fn check(args: &SceneArgs) -> Result<(), Failure> {
    let sim = load(args)?;
    warn(sim.scene());
    let description = sim.describe();
    let mut out = std::io::stdout().lock();
    writeln!(out, "{}: sound", args.scene.display())?;
    let size =
        format!("{} particles, {} in dimension {}", grouped(description.particles as u64), bodies(&description), description.dimension);
    writeln!(out, "  {}: {size}", description.title)?;
    writeln!(out, "next: matpoint run {}", args.scene.display())?;
    Ok(())
}

fn bodies(description: &Description) -> String {
    match description.bodies.len() {
        1 => "1 body".to_owned(),
        n => format!("{n} bodies"),
    }
}

/// Prints what a scene becomes.
pub(crate) fn describe(args: &SceneArgs) -> Result<(), Failure> {
    let sim = load(args)?;
    let description = sim.describe();
    let mut out = std::io::stdout().lock();
    writeln!(out, "{}", description.title)?;
    let list = |(name, count): &(String, usize)| format!("{name} ({})", grouped(*count as u64));
    let sizes = [
        ("dimension", description.dimension.to_string()),
        ("particles", grouped(description.particles as u64)),
        ("bodies", description.bodies.iter().map(list).collect::<Vec<_>>().join(", ")),
        ("memory", bytes(description.memory)),
        ("stable step", si(description.stable_step, "s")),
        ("end", si(sim.scene().time.end, "s")),
    ];
    pairs(&mut out, sizes)?;
    writeln!(out, "\nmethod")?;
    pairs(&mut out, description.method.iter().map(|(name, choice)| (*name, choice.clone())))?;
    for (title, lines) in [("needs", &description.needs), ("skips, and so does not cost", &description.skips)] {
        if !lines.is_empty() {
            writeln!(out, "\n{title}")?;
            lines.iter().try_for_each(|line| writeln!(out, "  {line}"))?;
        }
    }
    writeln!(out, "\nvariables")?;
    let rows: Vec<[String; 5]> = description.variables.iter().map(row).collect();
    table(&mut out, ["name", "", "unit", "shape", "meaning"], &rows)?;
    Ok(())
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

/// Prints the JSON schema of scene files.
pub(crate) fn schema() -> Result<(), Failure> {
    let mut out = std::io::stdout().lock();
    // `{:#}` is the indented form.
    writeln!(out, "{:#}", Scene::schema())?;
    Ok(())
}
