//! Gauss-Legendre rules.

/// Gauss-Legendre points and weights on \[0, 1\]: zeros of the Legendre polynomial by Newton from the Chebyshev guess.
pub(crate) fn gauss_legendre(n: usize) -> Vec<(f64, f64)> {
    (0..n)
        .map(|i| {
            let mut x = -(std::f64::consts::PI * (i as f64 + 0.75) / (n as f64 + 0.5)).cos();
            let mut slope = 1.0;
            for _ in 0..100 {
                let (mut p0, mut p1) = (1.0, x);
                for k in 2..=n {
                    (p0, p1) = (p1, ((2 * k - 1) as f64 * x * p1 - (k - 1) as f64 * p0) / k as f64);
                }
                slope = n as f64 * (x * p1 - p0) / (x * x - 1.0);
                let correction = p1 / slope;
                x -= correction;
                if correction.abs() < 1e-16 {
                    break;
                }
            }
            (0.5 * (1.0 + x), 1.0 / ((1.0 - x * x) * slope * slope))
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_to_degree_2n_minus_1() {
        for n in 1..=8 {
            for degree in 0..2 * n {
                let sum: f64 = gauss_legendre(n).iter().map(|(x, w)| w * x.powi(degree as i32)).sum();
                // round-off of sums of at most 8 terms below 1
                assert!((sum - 1.0 / (degree + 1) as f64).abs() < 4e-15, "{n} points, degree {degree}: {sum}");
            }
        }
    }
}
