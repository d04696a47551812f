//! What is known of bar and column: analytic solutions, and tables made by other programs (`tests/reference`).

use crate::study::Run;
use std::f64::consts::PI;

/// Displacement \[m\], velocity \[m/s\] and stress \[Pa\].
pub(super) type Exact = [f64; 3];

/// T1: equation (4.1), a bar of 25 m, 100 Pa, 1 kg/m3.
pub(super) fn small_bar(x: f64, t: f64) -> Exact {
    let (length, wave, speed) = (25.0, 10.0, 0.1);
    let (k, omega) = (PI / length, PI * wave / length);
    let amplitude = speed / omega;
    [
        amplitude * (omega * t).sin() * (k * x).sin(),
        speed * (omega * t).cos() * (k * x).sin(),
        100.0 * amplitude * k * (omega * t).sin() * (k * x).cos(),
    ]
}

/// T3: equation (4.2) for a column of 25 m, 5e4 Pa, 1 kg/m3 under its weight, its series summed: the deflection at rest less two waves
/// of its shape (d'Alembert), which are odd about the foot and even about the top.
pub(super) fn small_column(y: f64, t: f64) -> Exact {
    let (height, young, density, gravity) = (25.0, 5e4, 1.0, 9.81);
    let wave = f64::sqrt(young / density);
    let strain = density * gravity / young;
    // deflection at rest and its slope, continued over a period of 4 heights
    let rest = |y: f64| {
        let y = (y + 2.0 * height).rem_euclid(4.0 * height) - 2.0 * height;
        let sign = if y < 0.0 { -1.0 } else { 1.0 };
        let y = y.abs();
        (sign * strain * (0.5 * y * y - height * y), strain * (y - height))
    };
    let (still, up, down) = (rest(y), rest(y - wave * t), rest(y + wave * t));
    [still.0 - 0.5 * (up.0 + down.0), 0.5 * wave * (up.1 - down.1), young * (still.1 - 0.5 * (up.1 + down.1))]
}

/// Displacement, velocity and stress in a table over time and position at time 0.
pub(super) struct Table {
    /// Rows `time, X, displacement, velocity, stress`, ordered by time, then X.
    rows: Vec<[f64; 5]>,
}

macro_rules! table {
    ($file:literal) => {
        Table::read(include_str!(concat!("../../tests/reference/", $file)))
    };
}

impl Table {
    /// T2 at five times, 65 points.
    pub(super) fn bar() -> Self {
        table!("tielen_bar_large.csv")
    }
    /// T2 left of the middle over time.
    pub(super) fn bar_middle() -> Self {
        table!("tielen_bar_middle.csv")
    }
    /// T4 at five times, 33 points.
    pub(super) fn column() -> Self {
        table!("tielen_column_large.csv")
    }
    /// T4 below the middle over time.
    pub(super) fn column_middle() -> Self {
        table!("tielen_column_middle.csv")
    }
    /// T5 just below the middle over time, at two places.
    pub(super) fn column_top() -> Self {
        table!("tielen_column_top.csv")
    }

    fn read(text: &str) -> Self {
        let row = |line: &str| <[f64; 5]>::try_from(line.split(',').map_while(|v| v.trim().parse().ok()).collect::<Vec<_>>()).ok();
        Self { rows: text.lines().filter_map(row).collect() }
    }

    /// The position at time 0 \[m\] of the first row: of all rows, in a table over time.
    pub(super) fn place(&self) -> f64 {
        self.rows.first().map_or(f64::NAN, |row| row[1])
    }

    /// The rows of one position alone, that nearest to `x`.
    pub(super) fn near(mut self, x: f64) -> Self {
        let nearest = self.rows.iter().map(|row| row[1]).min_by(|a, b| (a - x).abs().total_cmp(&(b - x).abs()));
        self.rows.retain(|row| Some(row[1]) == nearest);
        self
    }

    /// Displacement \[m\], velocity \[m/s\] and stress \[Pa\] (column 0 to 2) sampled in a run under `name`, less what is known, at the times of
    /// the table that were sampled: nothing is read between its rows.
    pub(super) fn errors(&self, run: &Run, name: &str, column: usize, offset: f64) -> Vec<[f64; 2]> {
        let samples = run.curve(name);
        let error = |[time, known]: [f64; 2]| {
            let sample = samples.get(samples.partition_point(|s| s[0] < time - 1e-9)).filter(|s| (s[0] - time).abs() < 1e-9)?;
            Some([time, sample[1] - offset - known])
        };
        self.curve(column, f64::INFINITY).into_iter().filter_map(error).collect()
    }

    /// At one of the times of the table, by polynomials through `width` neighbours: 2 where there are fronts, 6 where all is smooth.
    pub(super) fn over_place(&self, time: f64, x: f64, width: usize) -> Exact {
        let rows = self.rows.iter().filter(|r| (r[0] - time).abs() < 1e-9).map(|r| (r[1], [r[2], r[3], r[4]]));
        interpolate(&rows.collect::<Vec<_>>(), x, width)
    }

    /// Points (time, value) of column 0 to 2 up to `end` \[s\].
    pub(super) fn curve(&self, column: usize, end: f64) -> Vec<[f64; 2]> {
        self.rows.iter().filter(|r| r[0] <= end * (1.0 + 1e-9)).map(|r| [r[0], r[2 + column]]).collect()
    }
}

/// Lagrange's polynomial through the `width` rows around `x`.
fn interpolate(rows: &[(f64, Exact)], x: f64, width: usize) -> Exact {
    let width = width.min(rows.len());
    let first = rows.partition_point(|r| r.0 <= x).saturating_sub(width / 2).min(rows.len() - width);
    let near = &rows[first..first + width];
    let weight = |i: usize| (0..width).filter(|&j| j != i).map(|j| (x - near[j].0) / (near[i].0 - near[j].0)).product::<f64>();
    std::array::from_fn(|column| (0..width).map(|i| near[i].1[column] * weight(i)).sum())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The wave form of (4.2) against its series as the thesis prints it, with p0 = 0.
    #[test]
    fn column_is_the_sum_of_its_series() {
        let (height, young, gravity) = (25.0f64, 5e4f64, 9.81);
        for (y, t) in [(12.4, 0.1), (12.4, 0.37), (20.0, 0.5), (3.0, 0.46), (25.0, 0.2)] {
            let series: f64 = (1..20_000)
                .map(|n| {
                    let m = (2 * n - 1) as f64;
                    let u = 16.0 * height * height * gravity / (m.powi(3) * PI.powi(3) * young);
                    u * (young.sqrt() * m * PI * t / (2.0 * height)).cos() * (m * PI * y / (2.0 * height)).sin()
                })
                .sum();
            let exact = 0.5 * gravity * y * y / young - gravity * height * y / young + series;
            assert!((small_column(y, t)[0] - exact).abs() < 1e-9, "{y} {t}: {} {exact}", small_column(y, t)[0]);
            let slope = |f: &dyn Fn(f64) -> f64| (f(1e-6) - f(-1e-6)) / 2e-6;
            assert!((slope(&|d| small_column(y, t + d)[0]) - small_column(y, t)[1]).abs() < 1e-6);
            if y < height {
                assert!((young * slope(&|d| small_column(y + d, t)[0]) - small_column(y, t)[2]).abs() < 1e-3);
            }
        }
    }

    #[test]
    fn tables_are_whole_and_agree() {
        let (bar, middle) = (Table::bar(), Table::bar_middle());
        assert_eq!(bar.rows.len(), 325);
        let at = |table: &Table, time: f64| {
            let row = table.rows.iter().find(|r| (r[0] - time).abs() < 1e-9).unwrap();
            [row[2], row[3], row[4]]
        };
        for (a, b) in bar.over_place(0.4, middle.place(), 6).iter().zip(at(&middle, 0.4)) {
            assert!((a - b).abs() < 1e-6 * b.abs().max(1.0), "{a} {b}");
        }
        let (column, middle) = (Table::column(), Table::column_middle());
        let (a, b) = (column.over_place(0.5, middle.place(), 2), at(&middle, 0.5));
        assert!((a[0] - b[0]).abs() < 1e-4, "{a:?} {b:?}");
        // behind the shock: Rankine and Hugoniot
        let shock = at(&Table::column_top().near(0.5), 0.1);
        assert!((shock[2] + 1e4).abs() < 10.0 && (shock[1] + 0.953_462_6).abs() < 1e-4, "{shock:?}");
    }
}
