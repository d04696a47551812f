//! `matpoint check`, `describe` and `schema`.

use super::{Failure, load, warn};
use crate::SceneArgs;
use matpoint::component::Description;
use matpoint::scene::Scene;
use matpoint::text::grouped;
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
    write!(std::io::stdout().lock(), "{}", load(args)?.describe())?;
    Ok(())
}

/// Prints the JSON schema of scene files.
pub(crate) fn schema() -> Result<(), Failure> {
    let mut out = std::io::stdout().lock();
    // `{:#}` is the indented form.
    writeln!(out, "{:#}", Scene::schema())?;
    Ok(())
}
