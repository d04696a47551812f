//! Natural cubic splines (Tielen 2016, section 7.1): twice continuously differentiable, second derivative 0 at both ends.
//!
//! In terms of the second derivatives M at the knots, with steps h and values f, continuity of the first derivative is
//! h\[i-1\] M\[i-1\] + 2 (h\[i-1\] + h\[i\]) M\[i\] + h\[i\] M\[i+1\] = 6 ((f\[i+1\] - f\[i\]) / h\[i\] - (f\[i\] - f\[i-1\]) / h\[i-1\]).
//! The matrix depends on the abscissae alone, so it is factored once for all fields; it is diagonally dominant, so without pivoting.

#[cfg(test)]
mod tests;

/// Abscissae that do not increase strictly (or are not finite).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct NotIncreasing {
    /// The first knot that does not lie above the one before it.
    pub(crate) knot: usize,
    /// The line it is on.
    pub(crate) line: usize,
}

/// Splines along lines side by side, all with the same number of knots. Whatever belongs to the knots is stored knot by knot, at
/// `knot * lines + line`, so that loops over the lines run through contiguous memory. Fields are `K` numbers a knot.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Bundle<'a> {
    lines: usize,
    abscissae: &'a [f64],
    /// 1 / pivot of the row of each knot \[1/m\]; 0 at the ends, which makes their second derivative 0 without a special case.
    inverse_pivots: &'a [f64],
}

/// Where a point lies on its line, and what the value there is made of.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Place {
    /// Knot at the lower end of the interval, counted as stored.
    pub(crate) lower: u32,
    /// Weights of the values at the lower and upper knot \[-\] and of the second derivatives there \[m2\].
    weights: [f64; 4],
}

/// Factors the systems of `lines` lines into `inverse_pivots`, which is as long as `abscissae`.
pub(crate) fn factor(lines: usize, abscissae: &[f64], inverse_pivots: &mut [f64]) -> Result<(), NotIncreasing> {
    let x = abscissae;
    let step = |i: usize| x[i] - x[i - lines];
    if let Some(i) = (lines..x.len()).find(|&i| !(step(i) > 0.0 && step(i).is_finite())) {
        return Err(NotIncreasing { knot: i / lines, line: i % lines });
    }
    let end = x.len() - lines;
    inverse_pivots[..lines].fill(0.0);
    for i in lines..end {
        let (below, above) = (step(i), step(i + lines));
        inverse_pivots[i] = 1.0 / (2.0 * (below + above) - below * below * inverse_pivots[i - lines]);
    }
    inverse_pivots[end..].fill(0.0);
    Ok(())
}

impl<'a> Bundle<'a> {
    /// Lines factored by [`factor`].
    pub(crate) fn new(lines: usize, abscissae: &'a [f64], inverse_pivots: &'a [f64]) -> Self {
        debug_assert!(lines > 0 && abscissae.len() >= lines && abscissae.len() == inverse_pivots.len());
        Self { lines, abscissae, inverse_pivots }
    }

    /// Second derivatives of the splines through `values`, by knot: elimination from the first knot to the last and back.
    pub(crate) fn bend<const K: usize>(&self, values: &[[f64; K]], bends: &mut [[f64; K]]) {
        let (x, w, end) = (self.abscissae, self.lines, self.abscissae.len() - self.lines);
        bends[..w].fill([0.0; K]);
        for i in w..end {
            let below = x[i] - x[i - w];
            let (inverse_below, inverse_above) = (1.0 / below, 1.0 / (x[i + w] - x[i]));
            for k in 0..K {
                let kink = (values[i + w][k] - values[i][k]) * inverse_above - (values[i][k] - values[i - w][k]) * inverse_below;
                bends[i][k] = (6.0 * kink - below * bends[i - w][k]) * self.inverse_pivots[i];
            }
        }
        bends[end..].fill([0.0; K]);
        for i in (w..end).rev() {
            let factor = (x[i + w] - x[i]) * self.inverse_pivots[i];
            for k in 0..K {
                bends[i][k] -= factor * bends[i + w][k];
            }
        }
    }

    /// Where `x` lies on a line; beyond its ends the end polynomials go on. The search walks from knot `near`: for sorted points start at
    /// the knot of the last.
    pub(crate) fn place(&self, line: usize, x: f64, near: usize) -> Place {
        let (w, knots) = (self.lines, self.abscissae.len() / self.lines);
        if knots == 1 {
            return Place { lower: line as u32, weights: [1.0, 0.0, 0.0, 0.0] };
        }
        let at = |knot: usize| self.abscissae[knot * w + line];
        let mut knot = near.min(knots - 2);
        while knot > 0 && x < at(knot) {
            knot -= 1;
        }
        while knot + 2 < knots && x >= at(knot + 1) {
            knot += 1;
        }
        let h = at(knot + 1) - at(knot);
        let b = (x - at(knot)) / h;
        let a = 1.0 - b;
        let cubic = |s: f64| (s * s - 1.0) * s * h * h / 6.0;
        Place { lower: (knot * w + line) as u32, weights: [a, b, cubic(a), cubic(b)] }
    }

    /// The fields with these values and second derivatives at the knots.
    #[inline]
    pub(crate) fn value<const K: usize>(&self, place: &Place, values: &[[f64; K]], bends: &[[f64; K]]) -> [f64; K] {
        let lower = place.lower as usize;
        // on a line of one knot the weights of the upper are 0
        let upper = if self.abscissae.len() == self.lines { lower } else { lower + self.lines };
        let [a, b, c, d] = place.weights;
        let (v0, v1, m0, m1) = (&values[lower], &values[upper], &bends[lower], &bends[upper]);
        std::array::from_fn(|k| a * v0[k] + b * v1[k] + c * m0[k] + d * m1[k])
    }
}
