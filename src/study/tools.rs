//! What the problems of all studies share: norms, figures, numbers in sentences.

use super::{Cell, Chart, Cloud, Drawing, Figure, Job, Run, Table, View, value};

/// Watches the kinetic, the stored and the total energy.
pub(super) fn energies(job: Job) -> Job {
    job.watch("kinetic", value("energy/kinetic", 0)).watch("strain", value("energy/strain", 0)).watch("energy", value("energy/total", 0))
}

/// Energy lost over a run, over the largest kinetic energy in it.
pub(super) fn lost(run: &Run) -> Option<f64> {
    let energy = run.samples("energy");
    Some((energy.first()? - energy.last()?) / largest(run.samples("kinetic").iter().copied()))
}

/// A figure that is a chart.
pub(super) fn chart(name: &str, caption: &str, chart: Chart) -> Figure {
    Figure { name: name.into(), caption: caption.into(), drawing: Drawing::Chart(chart) }
}

/// A figure of particles.
pub(super) fn cloud(name: &str, caption: &str, cloud: Cloud) -> Figure {
    Figure { name: name.into(), caption: caption.into(), drawing: Drawing::Cloud(cloud) }
}

/// A table of our numbers alone: `of` gives the numbers of a row.
pub(super) fn tabulate<R>(
    title: &str,
    header: &[&str],
    rows: impl IntoIterator<Item = R>,
    of: impl Fn(R) -> (String, Vec<Option<f64>>),
) -> Table {
    let cells = |(name, values): (String, Vec<Option<f64>>)| (name, values.into_iter().map(|ours| Cell { paper: None, ours }).collect());
    Table {
        title: title.into(),
        header: header.iter().map(|&h| h.to_owned()).collect(),
        rows: rows.into_iter().map(|row| cells(of(row))).collect(),
        beside: "",
        band: None,
    }
}

/// Particles at a time \[s\] with a value each.
pub(super) fn view(title: impl Into<String>, run: &Run, time: f64, values: impl FnOnce(&Run) -> Option<Vec<f64>>) -> Option<View> {
    Some(View { title: title.into(), points: places(run.at(time, "particle/position")?), values: values(run)? })
}

/// Positions of particles in the plane.
pub(super) fn places(values: &[f64]) -> Vec<[f64; 2]> {
    values.chunks_exact(2).map(|v| [v[0], v[1]]).collect()
}

/// Component xx of each stress.
pub(super) fn stress_xx(values: &[f64]) -> Vec<f64> {
    values.iter().step_by(9).copied().collect()
}

/// Rows of a CSV of `N` columns; its header is no row.
pub(super) fn table<const N: usize>(text: &str) -> Vec<[f64; N]> {
    text.lines().filter_map(|line| line.split(',').map_while(|v| v.trim().parse().ok()).collect::<Vec<f64>>().try_into().ok()).collect()
}

/// Root of the mean square.
pub(super) fn rms(values: impl IntoIterator<Item = f64>) -> f64 {
    let (sum, count) = values.into_iter().fold((0.0, 0usize), |(sum, count), v| (sum + v * v, count + 1));
    (sum / count as f64).sqrt()
}

/// Largest magnitude.
pub(super) fn largest(values: impl IntoIterator<Item = f64>) -> f64 {
    values.into_iter().fold(0.0, |most, v| most.max(v.abs()))
}

/// RMS of a sampled curve less a known one, over the times in a range \[s\].
pub(super) fn curve_error(run: &Run, name: &str, times: std::ops::RangeInclusive<f64>, exact: impl Fn(f64) -> f64) -> f64 {
    rms(run.curve(name).into_iter().filter(|[t, _]| times.contains(t)).map(|[t, v]| v - exact(t)))
}

/// A known curve at `count + 1` points from `low` to `high`.
pub(super) fn known(low: f64, high: f64, count: usize, exact: impl Fn(f64) -> f64) -> Vec<[f64; 2]> {
    (0..=count).map(|k| low + (high - low) * k as f64 / count as f64).map(|x| [x, exact(x)]).collect()
}

/// `0.42 %`: three digits.
pub(super) fn percent(share: f64) -> String {
    let value = 100.0 * share;
    let decimals = if value == 0.0 { 0 } else { (2 - value.abs().log10().floor() as i32).clamp(0, 6) as usize };
    format!("{value:.decimals$} %")
}

/// Factor between two numbers, two digits.
pub(super) fn times(factor: f64) -> String {
    let decimals = if factor >= 10.0 { 0 } else { 1 };
    format!("{factor:.decimals$} times")
}

/// Two digits in powers of ten.
pub(super) fn small(value: f64) -> String {
    format!("{value:.1e}")
}
