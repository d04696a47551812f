//! Pictures of recordings, and several pictures on one sheet.

use super::super::data::{About, Frame, Item};
use super::super::lattice::Lattice;
use super::super::particles::von_mises;
use super::super::{RecordError, Recording, RunError};
use super::{Deformed, Snapshot};
use crate::Simulation;
use crate::svg::WIDTH;
use std::path::Path;
use std::sync::Arc;

/// Draws frames of a simulation on a sheet: steps it to each of `times` \[s\], which grow, and gives the sheet as SVG.
///
/// # Errors
/// A step that cannot be done.
pub fn sheet(sim: &mut Simulation, times: &[f64]) -> Result<String, RunError> {
    let mut snapshots = Vec::new();
    for &time in times {
        if time > sim.time() {
            sim.step(time - sim.time())?;
        }
        snapshots.push(Snapshot::take(sim).map_err(|error| RunError::Record(error.into()))?);
    }
    Ok(arrange(snapshots))
}

/// Draws `count` frames of a recording, spread evenly over its time and the last one among them, as SVG.
///
/// # Errors
/// A recording that cannot be read or has no frames.
pub fn picture_of(path: &Path, count: usize) -> Result<String, RecordError> {
    let times: Vec<f64> = Recording::open(path)?
        .filter_map(|item| match item {
            Ok(Item::Frame(frame)) => Some(frame.time),
            _ => None,
        })
        .collect();
    if times.is_empty() {
        return Err(RecordError::content(path, "has no frames"));
    }
    let count = count.clamp(1, times.len());
    let chosen: Vec<usize> =
        (0..count).map(|i| (i + usize::from(count == 1)) * (times.len() - 1) / count.saturating_sub(1).max(1)).collect();
    let recording = Recording::open(path)?;
    let about = recording.about().clone();
    let lattice = Arc::new(Lattice::new(&about));
    let frames = recording.filter_map(|item| match item {
        Ok(Item::Frame(frame)) => Some(frame),
        _ => None,
    });
    let chosen = frames.enumerate().filter(|(i, _)| chosen.contains(i)).map(|(_, frame)| snapshot(&about, &lattice, &frame));
    Ok(arrange(chosen.collect()))
}

/// What is known of a frame of a recording; a stress that was not recorded is zero.
fn snapshot(about: &About, lattice: &Arc<Lattice>, frame: &Frame) -> Snapshot {
    let (dimension, particles) = (about.dimension(), about.body.len());
    let stress = about.column("stress").map_or_else(|| vec![0.0; 9 * particles], |i| frame.values[i].to_vec());
    let of_stress = || stress.chunks_exact(9).map(von_mises).collect();
    let position = frame.values[0].to_vec();
    let probe = |at: &[f64]| {
        let distance = |p: usize| (0..dimension).map(|a| (about.initial[dimension * p + a] - at[a]).powi(2)).sum::<f64>();
        let nearest = (0..particles).min_by(|&a, &b| distance(a).total_cmp(&distance(b))).unwrap_or(0);
        (0..dimension).map(|a| at[a] + position[dimension * nearest + a] - about.initial[dimension * nearest + a]).collect()
    };
    Snapshot {
        probes: about.scene.probe.iter().map(|(name, p)| (name.clone(), probe(&p.at))).collect(),
        scene: about.scene.clone(),
        time: frame.time,
        initial: about.initial.clone(),
        shape: Deformed::Lattice(lattice.clone()),
        von_mises: about.column("von_mises").map_or_else(of_stress, |i| frame.values[i].to_vec()),
        body: about.body.iter().map(|&b| b as usize).collect(),
        spacing: about.spacing.clone(),
        largest: 0.0,
        stress,
        position,
    }
}

/// Pictures in rows of two, coloured alike; one picture stands alone.
fn arrange(mut snapshots: Vec<Snapshot>) -> String {
    let largest = snapshots.iter().flat_map(|s| &s.von_mises).copied().fold(0.0, f64::max);
    snapshots.iter_mut().for_each(|s| s.largest = largest);
    let pictures: Vec<String> = snapshots.iter().map(Snapshot::draw).collect();
    let [single] = pictures.as_slice() else { return rows(&pictures) };
    single.clone()
}

fn rows(pictures: &[String]) -> String {
    let height = |picture: &str| {
        let text = picture.split("height=\"").nth(1).and_then(|rest| rest.split('"').next());
        text.and_then(|text| text.parse::<f64>().ok()).unwrap_or(0.0)
    };
    let (mut body, mut top) = (String::new(), 0.0);
    for row in pictures.chunks(2) {
        for (i, picture) in row.iter().enumerate() {
            body += &picture.replacen("<svg ", &format!("<svg x=\"{}\" y=\"{top}\" ", i as f64 * WIDTH), 1);
        }
        top += row.iter().map(|picture| height(picture)).fold(0.0, f64::max);
    }
    let width = 2.0 * WIDTH;
    format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{top}\" viewBox=\"0 0 {width} {top}\">\n\
         <rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n{body}</svg>\n"
    )
}
