//! Cubic splines, twice continuously differentiable (Tielen 2016, section 7.1), but with ends "not a knot": the third derivative does not jump
//! at the knots next to the ends. The natural ends of the thesis, whose second derivative is 0, leave an error of second order near them
//! wherever that of the data is not 0, as for the stress at a wall; these are of fourth order up to the ends. With three knots the second
//! derivative is constant.
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
    /// 1 / pivot of the row of each knot \[1/m\]; 0 at the ends, which have none.
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
        let row = Row::new(x, lines, i);
        // what the row above has right of its diagonal; of no account in the first, whose pivot above is 0
        let over = if i >= 2 * lines { Row::new(x, lines, i - lines).above } else { 0.0 };
        inverse_pivots[i] = 1.0 / (row.diagonal - row.below * over * inverse_pivots[i - lines]);
    }
    inverse_pivots[end..].fill(0.0);
    Ok(())
}

/// Row of a knot: factors of the second derivatives at the knot below, at it and above, once those at the ends are gone.
struct Row {
    below: f64,
    diagonal: f64,
    above: f64,
}

impl Row {
    fn new(x: &[f64], lines: usize, i: usize) -> Self {
        let (below, above) = (x[i] - x[i - lines], x[i + lines] - x[i]);
        let mut row = Self { below, diagonal: 2.0 * (below + above), above };
        match (i < 2 * lines, i + 2 * lines >= x.len()) {
            // all three are the same
            (true, true) => row = Self { below: 0.0, diagonal: 3.0 * (below + above), above: 0.0 },
            // what is at the end goes on linearly from the two next to it
            (true, false) => (row.diagonal, row.above) = (row.diagonal + below * (1.0 + below / above), above - below * below / above),
            (false, true) => (row.diagonal, row.below) = (row.diagonal + above * (1.0 + above / below), below - above * above / below),
            (false, false) => {}
        }
        row
    }
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
            let row = Row::new(x, w, i);
            let (inverse_below, inverse_above) = (1.0 / (x[i] - x[i - w]), 1.0 / (x[i + w] - x[i]));
            for k in 0..K {
                let kink = (values[i + w][k] - values[i][k]) * inverse_above - (values[i][k] - values[i - w][k]) * inverse_below;
                bends[i][k] = (6.0 * kink - row.below * bends[i - w][k]) * self.inverse_pivots[i];
            }
        }
        bends[end..].fill([0.0; K]);
        for i in (w..end).rev() {
            let factor = Row::new(x, w, i).above * self.inverse_pivots[i];
            for k in 0..K {
                bends[i][k] -= factor * bends[i + w][k];
            }
        }
        self.bend_ends(bends);
    }

    /// Second derivatives at the ends, from those next to them.
    fn bend_ends<const K: usize>(&self, bends: &mut [[f64; K]]) {
        let (x, w, n) = (self.abscissae, self.lines, self.abscissae.len());
        for line in 0..if n >= 3 * w { w } else { 0 } {
            // from the end inwards
            for [i, j, l] in [[line, line + w, line + 2 * w], [n - w + line, n - 2 * w + line, n - 3 * w + line]] {
                let ratio = if n == 3 * w { 0.0 } else { (x[i] - x[j]) / (x[j] - x[l]) };
                for k in 0..K {
                    bends[i][k] = bends[j][k] + ratio * (bends[j][k] - bends[l][k]);
                }
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
