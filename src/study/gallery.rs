//! The gallery: a few scenes, each with pictures of its course.

use crate::Simulation;
use crate::draft::Draft;
use crate::record::{RecordError, RunError, encode, sheet};
use crate::scene::{Scene, SceneError};
use std::path::{Path, PathBuf};

/// A scene with the times of its pictures.
struct Entry {
    name: &'static str,
    text: &'static str,
    /// Times of the pictures \[s\].
    times: &'static [f64],
}

macro_rules! entry {
    ($name:literal, $times:expr) => {
        Entry { name: $name, text: include_str!(concat!("../../launch_scripts/scenes/", $name, ".toml")), times: &$times }
    };
}

const ENTRIES: [Entry; 6] = [
    entry!("cantilever", [0.0, 1.2, 2.4, 4.4]),
    entry!("box_on_beam", [0.0, 0.6, 1.2, 2.4]),
    entry!("disks", [0.0, 1.1, 1.35, 3.0]),
    entry!("bar_1d_vibration", [0.0, 0.6, 1.25, 3.75]),
    entry!("twist_3d", [0.0, 0.04, 0.08, 0.16]),
    entry!("follower_beam", [0.0, 1.4, 2.0, 2.5]),
];

/// A gallery that could not be made.
#[derive(Debug, thiserror::Error)]
pub enum GalleryError {
    /// A scene of the gallery is at fault.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// A scene cannot be run.
    #[error(transparent)]
    Run(#[from] RunError),
    /// A file cannot be written.
    #[error(transparent)]
    Record(#[from] RecordError),
}

/// Draws the scenes of the gallery to `gallery.md` and the folder `gallery` in `folder`; `progress` is told the name of each scene before it is
/// run. Returns the files written.
///
/// # Errors
/// A scene that cannot be run, a file that cannot be written.
pub fn gallery(folder: &Path, progress: &mut dyn FnMut(&str)) -> Result<Vec<PathBuf>, GalleryError> {
    let pictures = folder.join("gallery");
    std::fs::create_dir_all(&pictures).map_err(RecordError::write(&pictures))?;
    let ending = if cfg!(feature = "png") { "png" } else { "svg" };
    let mut text = String::from(
        "# Gallery\n\nMade by `cargo run --release -- study gallery` in one go. Every scene stands in `launch_scripts/scenes`; the command below\n\
         each picture records it. Particles are drawn as what they have become, coloured by von Mises stress, on one scale for each scene.\n",
    );
    let mut files = Vec::new();
    for entry in &ENTRIES {
        progress(entry.name);
        let mut sim: Simulation = Scene::from_toml(entry.text)?.build()?;
        let svg = sheet(&mut sim, entry.times)?;
        let path = pictures.join(format!("{}.{ending}", entry.name));
        let mut draft = Draft::create(&path)?;
        draft.write_bytes(&encode(&path, svg)?)?;
        files.push(draft.finish()?);
        let comment: Vec<&str> = entry.text.lines().map_while(|line| line.strip_prefix('#')).map(str::trim).collect();
        let command = comment.iter().find(|line| line.starts_with("matpoint run")).copied().unwrap_or_default();
        let words: Vec<&str> = comment.iter().filter(|line| !line.starts_with("matpoint run")).copied().collect();
        let title = &sim.scene().title;
        text += &format!(
            "\n## {title}\n\n{}\n\n![{title}](gallery/{}.{ending})\n\n```sh\n{command}\n```\n",
            words.join("\n").trim(),
            entry.name
        );
    }
    let page = folder.join("gallery.md");
    let mut draft = Draft::create(&page)?;
    text += VIEWER;
    draft.write(&text)?;
    files.push(draft.finish()?);
    Ok(files)
}

/// What else there is to be seen, made by another command.
const VIEWER: &str = "\n## In the Rerun viewer\n\nThe cantilever as it opens, by these two commands (the second needs what `tests/record_python/run` installs, but no display):\n\n\
```sh\nmatpoint run launch_scripts/scenes/cantilever.toml --until 2.4 --record cantilever.rrd\n\
target/record-python/bin/python tests/record_python/screenshot.py cantilever.rrd docs/gallery/rerun.png\n```\n\n\
![The cantilever in the Rerun viewer](gallery/rerun.png)\n";
