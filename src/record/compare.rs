//! Two recordings of the same bodies, perhaps with different particles: how far are they apart?

use super::data::{About, Frame, Item};
use super::{RecordError, Recording};
use std::collections::HashMap;
use std::path::Path;

/// How far a column of two recordings is apart at a time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Difference {
    /// Time \[s\].
    pub time: f64,
    /// Root of the mean square over particles and components.
    pub rms: f64,
    /// Largest, of any component.
    pub largest: f64,
}

/// How far two recordings are apart: a list over time for each column that both have; positions are compared as displacements.
#[derive(Debug, Clone, PartialEq)]
pub struct Comparison {
    /// Name, unit, root mean square of the first recording over all of its time, differences.
    pub columns: Vec<(String, &'static str, f64, Vec<Difference>)>,
    /// Frames that one recording has and the other has not.
    pub unmatched: usize,
    /// Whether particles were matched one to one; fields of the second were interpolated otherwise.
    pub same_particles: bool,
}

/// For each particle of the first recording: particles of the second with weights that sum up to one.
type Matching = Vec<Vec<(usize, f64)>>;

/// Compares two recordings at the times that both have, at the particles of the first.
///
/// # Errors
/// Recordings that cannot be read, of different dimension, of bodies with different names, or without a common time.
pub fn compare(first: &Path, second: &Path) -> Result<Comparison, RecordError> {
    let (a, b) = (Recording::open(first)?, Recording::open(second)?);
    let (ours, theirs) = (a.about().clone(), b.about().clone());
    if ours.dimension() != theirs.dimension() {
        let reason = format!("has dimension {}, `{}` has {}", theirs.dimension(), first.display(), ours.dimension());
        return Err(RecordError::content(second, reason));
    }
    let same_particles = ours.initial == theirs.initial && ours.body == theirs.body;
    let matching = if same_particles { None } else { Some(matching(&ours, &theirs, second)?) };
    let pairs: Vec<(usize, usize)> = ours
        .columns
        .iter()
        .enumerate()
        .filter(|(_, column)| column.name != "body")
        .filter_map(|(i, column)| Some((i, theirs.columns.iter().position(|c| c.name == column.name && c.width == column.width)?)))
        .collect();
    let mut columns: Vec<_> = pairs
        .iter()
        .map(|&(i, _)| {
            let name = if i == 0 { "displacement".to_owned() } else { ours.columns[i].name.clone() };
            (name, ours.columns[i].unit, 0.0, Vec::new())
        })
        .collect();
    let (mut a, mut b) = (frames(a), frames(b));
    let (mut left, mut right) = (a.next().transpose()?, b.next().transpose()?);
    let (mut unmatched, mut matched) = (0, 0);
    while let (Some(x), Some(y)) = (&left, &right) {
        // Files round times to nanoseconds.
        let apart = x.time - y.time;
        if apart.abs() > 2e-9 {
            unmatched += 1;
            if apart < 0.0 {
                left = a.next().transpose()?
            } else {
                right = b.next().transpose()?
            }
            continue;
        }
        matched += 1;
        for (&(i, j), (_, _, size, list)) in pairs.iter().zip(&mut columns) {
            let (ours, theirs) = (field(&ours, x, i), field(&theirs, y, j));
            let width = ours.len() / matching.as_ref().map_or(ours.len().max(1), Vec::len).max(1);
            let (mut sum, mut largest) = (0.0, 0.0f64);
            for (k, &value) in ours.iter().enumerate() {
                let other = match &matching {
                    None => theirs[k],
                    Some(matching) => matching[k / width].iter().map(|&(p, weight)| weight * theirs[p * width + k % width]).sum(),
                };
                sum += (value - other).powi(2);
                largest = largest.max((value - other).abs());
            }
            let count = ours.len().max(1) as f64;
            *size += ours.iter().map(|v| v * v).sum::<f64>() / count;
            list.push(Difference { time: x.time, rms: (sum / count).sqrt(), largest });
        }
        (left, right) = (a.next().transpose()?, b.next().transpose()?);
    }
    unmatched += usize::from(left.is_some()) + usize::from(right.is_some()) + a.count() + b.count();
    if matched == 0 {
        return Err(RecordError::content(second, format!("has no frame at a time at which `{}` has one", first.display())));
    }
    columns.iter_mut().for_each(|(_, _, size, _)| *size = (*size / f64::from(matched)).sqrt());
    Ok(Comparison { columns, unmatched, same_particles })
}

fn frames(recording: Recording) -> impl Iterator<Item = Result<Frame, RecordError>> {
    recording.filter_map(|item| match item {
        Ok(Item::Frame(frame)) => Some(Ok(frame)),
        Ok(_) => None,
        Err(error) => Some(Err(error)),
    })
}

/// The values of a column; those of the position less what they were at time 0.
fn field(about: &About, frame: &Frame, column: usize) -> Vec<f64> {
    let values = &frame.values[column];
    if column == 0 { values.iter().zip(&about.initial).map(|(x, start)| x - start).collect() } else { values.to_vec() }
}

/// Where each particle of `ours` stands among those of `theirs` at time 0: linear between them, and beyond the outermost.
fn matching(ours: &About, theirs: &About, path: &Path) -> Result<Matching, RecordError> {
    let dimension = ours.dimension();
    let bodies = |about: &About| about.description.bodies.iter().map(|b| b.0.clone()).collect::<Vec<_>>();
    let (our_bodies, their_bodies) = (bodies(ours), bodies(theirs));
    let body: Vec<Option<usize>> = our_bodies.iter().map(|name| their_bodies.iter().position(|n| n == name)).collect();
    if let Some(missing) = body.iter().position(Option::is_none) {
        return Err(RecordError::content(path, format!("has no body `{}`; it has {}", our_bodies[missing], their_bodies.join(", "))));
    }
    let origin = &theirs.scene.grid.origin;
    // In units of the spacing, particles at whole numbers.
    let place = |x: &[f64], body: usize| -> [f64; 3] {
        std::array::from_fn(|a| if a < dimension { (x[a] - origin[a]) / theirs.spacing[body][a] - 0.5 } else { 0.0 })
    };
    let at = |about: &About, p: usize| about.initial[dimension * p..dimension * (p + 1)].to_vec();
    let mut slots: HashMap<(usize, [i64; 3]), usize> = HashMap::new();
    for p in 0..theirs.body.len() {
        let body = theirs.body[p] as usize;
        slots.insert((body, place(&at(theirs, p), body).map(|v| v.round() as i64)), p);
    }
    let one = |p: usize| {
        let x = at(ours, p);
        let body = body[ours.body[p] as usize].unwrap_or(0);
        let s = place(&x, body);
        // The block of 2^d particles around it, or the nearest one there is.
        let mut best: Option<(f64, Vec<(usize, f64)>)> = None;
        for shift in 0..3usize.pow(dimension as u32) {
            let shifts: [i64; 3] = std::array::from_fn(|a| if a < dimension { (shift / 3usize.pow(a as u32) % 3) as i64 - 1 } else { 0 });
            let base: [i64; 3] = std::array::from_fn(|a| s[a].floor() as i64 + shifts[a]);
            let corner = |bits: usize| {
                let slot = std::array::from_fn(|a| base[a] + (bits >> a & 1) as i64);
                let share = |a: usize| if bits >> a & 1 == 1 { s[a] - base[a] as f64 } else { 1.0 - (s[a] - base[a] as f64) };
                Some((*slots.get(&(body, slot))?, (0..dimension).map(share).product()))
            };
            let corners: Option<Vec<(usize, f64)>> = (0..1 << dimension).map(corner).collect();
            let away = shifts.iter().map(|v| v.abs() as f64).sum::<f64>();
            if let Some(corners) = corners
                && best.as_ref().is_none_or(|(least, _)| away < *least)
            {
                best = Some((away, corners));
            }
        }
        let distance = |q: &usize| at(theirs, *q).iter().zip(&x).map(|(a, b)| (a - b).powi(2)).sum::<f64>();
        let nearest = || {
            let all = (0..theirs.body.len()).filter(|&q| theirs.body[q] as usize == body);
            all.min_by(|a, b| distance(a).total_cmp(&distance(b))).map(|q| vec![(q, 1.0)]).unwrap_or_default()
        };
        best.map_or_else(nearest, |(_, corners)| corners)
    };
    Ok((0..ours.body.len()).map(one).collect())
}
