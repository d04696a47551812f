//! Cubic splines through values at sites that never move, as B-splines: twice continuously differentiable, with ends "not a knot" (the third
//! derivative does not jump at the sites next to the ends), or periodic.

/// The functions that are not zero at a place, their values and slopes.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Place {
    /// Number of the first; of a periodic spline they go on at 0.
    pub(crate) first: u32,
    pub(crate) weight: [f64; 4],
    pub(crate) slope: [f64; 4],
}

/// Sites along an axis, on \[0, 1\].
#[derive(Debug, Clone)]
pub(crate) enum Interpolation {
    /// Between two ends.
    Open {
        degree: usize,
        /// With `degree + 1` at either end.
        knots: Vec<f64>,
        /// Rows of the matrix of the functions at the sites after elimination, each from the first function that is not zero there.
        rows: Vec<(usize, [f64; 7])>,
        /// Multiples of a row that were taken from those below.
        factors: Vec<[f64; 3]>,
    },
    /// Evenly spaced, site `i` of `n` at (i + 1/2) / n, around a circle.
    Periodic(usize),
}

/// Root of the filter that inverts (1/6, 4/6, 1/6) (Unser 1999, IEEE Signal Process. Mag. 16(6), 22-38).
const POLE: f64 = -0.267_949_192_431_122_7;
/// Terms after which its powers are round-off.
const TERMS: usize = 29;

impl Interpolation {
    /// Through sites that increase strictly within \[0, 1\]: cubic, or of the highest degree that so few sites allow.
    pub(crate) fn open(sites: &[f64]) -> Self {
        let n = sites.len();
        let degree = (n - 1).min(3);
        let mut knots = vec![0.0; degree + 1];
        if degree == 3 {
            knots.extend(&sites[2..n - 2]);
        }
        knots.extend(std::iter::repeat_n(1.0, degree + 1));
        let mut line = Self::Open { degree, knots, rows: Vec::new(), factors: vec![[0.0; 3]; n] };
        // a banded matrix, totally positive: elimination needs no pivots (de Boor and Pinkus 1977)
        let mut full: Vec<(usize, [f64; 7])> = sites
            .iter()
            .enumerate()
            .map(|(i, s)| {
                let place = line.at(*s);
                let mut row = [0.0; 7];
                // columns i - 3 to i + 3
                for k in 0..=degree {
                    row[place.first as usize + k + 3 - i] = place.weight[k];
                }
                (i, row)
            })
            .collect();
        let Self::Open { factors, rows, .. } = &mut line else { return line };
        for i in 0..n {
            for below in 1..=3.min(n - 1 - i) {
                // column i of row i + below
                let factor = full[i + below].1[3 - below] / full[i].1[3];
                factors[i][below - 1] = factor;
                for column in 0..=3 {
                    let value = full[i].1[3 + column];
                    full[i + below].1[3 - below + column] -= factor * value;
                }
            }
        }
        *rows = full;
        line
    }

    /// Number of sites, and of functions.
    pub(crate) fn len(&self) -> usize {
        match self {
            Self::Open { rows, .. } => rows.len(),
            Self::Periodic(n) => *n,
        }
    }

    pub(crate) fn is_periodic(&self) -> bool {
        matches!(self, Self::Periodic(_))
    }

    /// Functions that are not zero at a place.
    pub(crate) fn width(&self) -> usize {
        match self {
            Self::Open { degree, .. } => degree + 1,
            Self::Periodic(_) => 4,
        }
    }

    /// Ends of the pieces between which all derivatives are continuous.
    pub(crate) fn breaks(&self) -> Vec<f64> {
        match self {
            Self::Open { degree, knots, .. } => knots[*degree..knots.len() - degree].to_vec(),
            Self::Periodic(n) => (0..=*n).map(|i| (i as f64 + 0.5) / *n as f64).collect(),
        }
    }

    /// Turns values at the sites, `stride` numbers from one site to the next, into coefficients in place.
    pub(crate) fn solve(&self, values: &mut [f64], stride: usize) {
        let n = self.len();
        match self {
            Self::Open { rows, factors, .. } => {
                for i in 0..n {
                    for below in 1..=3.min(n - 1 - i) {
                        let factor = factors[i][below - 1];
                        for k in 0..stride {
                            values[(i + below) * stride + k] -= factor * values[i * stride + k];
                        }
                    }
                }
                for i in (0..n).rev() {
                    let row = &rows[i].1;
                    for k in 0..stride {
                        let known: f64 = (1..=3.min(n - 1 - i)).map(|right| row[3 + right] * values[(i + right) * stride + k]).sum();
                        values[i * stride + k] = (values[i * stride + k] - known) / row[3];
                    }
                }
            }
            Self::Periodic(_) => {
                // forward and backward filter, each started by its geometric series around the circle
                for k in 0..stride {
                    let at = |i: usize| i % n * stride + k;
                    let (mut sum, mut power) = (0.0, 1.0);
                    for i in 0..TERMS {
                        sum += power * values[at(n * TERMS - i)];
                        power *= POLE;
                    }
                    let mut before = sum;
                    values[at(0)] = before;
                    for i in 1..n {
                        before = values[at(i)] + POLE * before;
                        values[at(i)] = before;
                    }
                    let (mut sum, mut power) = (0.0, POLE);
                    for i in 0..TERMS {
                        sum -= power * values[at(n - 1 + i)];
                        power *= POLE;
                    }
                    let mut after = sum;
                    values[at(n - 1)] = 6.0 * after;
                    for i in (0..n - 1).rev() {
                        after = POLE * (after - values[at(i)]);
                        values[at(i)] = 6.0 * after;
                    }
                }
            }
        }
    }

    /// The functions at a place; beyond the ends the end polynomials go on.
    pub(crate) fn at(&self, s: f64) -> Place {
        match self {
            Self::Open { degree, knots, .. } => {
                let inner = &knots[*degree + 1..knots.len() - degree - 1];
                let span = inner.partition_point(|knot| *knot <= s);
                basis(*degree, &knots[span..span + 2 * degree + 2], span, s)
            }
            Self::Periodic(n) => {
                // function j is in the middle at site j
                let t = s * *n as f64 - 0.5;
                let cell = t.floor();
                let (x, y) = (t - cell, 1.0 - (t - cell));
                let scale = *n as f64;
                Place {
                    first: (cell - 1.0).rem_euclid(scale) as u32,
                    weight: [
                        y * y * y / 6.0,
                        (4.0 - 6.0 * x * x + 3.0 * x * x * x) / 6.0,
                        (4.0 - 6.0 * y * y + 3.0 * y * y * y) / 6.0,
                        x * x * x / 6.0,
                    ],
                    slope: [-0.5 * y * y, 1.5 * x * x - 2.0 * x, 2.0 * y - 1.5 * y * y, 0.5 * x * x].map(|v| v * scale),
                }
            }
        }
    }
}

/// Cox-de Boor recursion in the interval between knots `degree` and `degree + 1` of those given.
fn basis(degree: usize, knots: &[f64], first: usize, s: f64) -> Place {
    let (mut weight, mut slope) = ([0.0; 4], [0.0; 4]);
    weight[0] = 1.0;
    for p in 1..=degree {
        let lower = weight;
        if p == degree {
            slope = [0.0; 4];
            for k in 0..p {
                let length = knots[degree + 1 + k] - knots[degree + 1 + k - p];
                let rise = p as f64 * lower[k] / length;
                slope[k] -= rise;
                slope[k + 1] += rise;
            }
        }
        weight = [0.0; 4];
        for k in 0..p {
            let (low, high) = (knots[degree + 1 + k - p], knots[degree + 1 + k]);
            let share = (s - low) / (high - low);
            weight[k] += (1.0 - share) * lower[k];
            weight[k + 1] += share * lower[k];
        }
    }
    Place { first: first as u32, weight, slope }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn value(line: &Interpolation, coefficients: &[f64], s: f64) -> [f64; 2] {
        let place = line.at(s);
        let at = |k: usize| coefficients[(place.first as usize + k) % line.len()];
        let sum = |w: &[f64; 4]| (0..line.width()).map(|k| w[k] * at(k)).sum();
        [sum(&place.weight), sum(&place.slope)]
    }

    #[test]
    fn cubics_are_exact_up_to_the_ends() {
        for n in [1, 2, 3, 4, 5, 6, 9, 20] {
            let sites: Vec<f64> = (0..n).map(|i| (i as f64 + 0.5) / n as f64).map(|s| s + 0.1 * (7.0 * s).sin() * s * (1.0 - s)).collect();
            let line = Interpolation::open(&sites);
            let degree = (n - 1).min(3);
            let f = |s: f64| (0..=degree).map(|m| (1.0 - 0.4 * f64::from(m)) * s.powi(m)).sum::<f64>();
            let slope = |s: f64| (1..=degree).map(|m| (1.0 - 0.4 * f64::from(m)) * f64::from(m) * s.powi(m - 1)).sum::<f64>();
            let mut values: Vec<f64> = sites.iter().map(|s| f(*s)).collect();
            line.solve(&mut values, 1);
            for s in [0.0, 0.01, 0.3, 0.5, 0.77, 1.0, 1.02, -0.03] {
                let [v, d] = value(&line, &values, s);
                // round-off, with slopes up to some tens
                assert!((v - f(s)).abs() < 1e-13 && (d - slope(s)).abs() < 1e-11, "{n} sites at {s}: {v} {d}");
            }
        }
    }

    #[test]
    fn splines_are_of_fourth_order() {
        use std::f64::consts::PI;
        for periodic in [false, true] {
            let f = |s: f64| if periodic { (2.0 * PI * s).sin() } else { (3.0 * s).exp() };
            let error = |n: usize| {
                let sites: Vec<f64> = (0..n).map(|i| (i as f64 + 0.5) / n as f64).collect();
                let line = if periodic { Interpolation::Periodic(n) } else { Interpolation::open(&sites) };
                // two columns side by side
                let mut values: Vec<f64> = sites.iter().flat_map(|s| [1.0, f(*s)]).collect();
                line.solve(&mut values, 2);
                let ones: Vec<f64> = values.iter().step_by(2).copied().collect();
                let column: Vec<f64> = values.iter().skip(1).step_by(2).copied().collect();
                (0..=1000)
                    .map(|i| f64::from(i) / 1000.0)
                    .map(|s| {
                        assert!((value(&line, &ones, s)[0] - 1.0).abs() < 1e-14);
                        (value(&line, &column, s)[0] - f(s)).abs()
                    })
                    .fold(0.0, f64::max)
            };
            let order = (error(20) / error(40)).log2();
            assert!(order > 3.7, "{periodic} {order}");
        }
    }
}
