//! Newton's method with a line search.

/// A balance of forces to be met by displacing nodes.
pub(crate) trait Balance {
    /// Why forces cannot be had.
    type Trouble;

    /// Forces out of balance where the nodes are displaced by `u` \[m\].
    fn residual(&mut self, u: &[[f64; 3]]) -> Result<Residual, Self::Trouble>;

    /// The displacement on top of `u` that would balance `forces` if they were linear in it; `None` where there is none.
    fn correction(&mut self, u: &[[f64; 3]], forces: &[[f64; 3]]) -> Result<Option<Vec<[f64; 3]>>, Self::Trouble>;
}

/// Forces out of balance.
pub(crate) struct Residual {
    /// By node \[N\]; 0 at held components.
    pub(crate) forces: Vec<[f64; 3]>,
    /// Forces of the supports that hold components, by node \[N\]; 0 at free ones.
    pub(crate) supports: Vec<[f64; 3]>,
    /// Loads, by node \[N\].
    pub(crate) loads: Vec<[f64; 3]>,
    /// Norm of the largest of the forces that should be in balance \[N\].
    pub(crate) size: f64,
}

/// When to stop.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Rules {
    /// Norm of the residual over that of the forces in balance.
    ///
    /// Round-off of a stiff body may leave more: then a correction this small, over the displacement, will do.
    pub(crate) residual: f64,
    pub(crate) iterations: usize,
}

/// Why no balance was found.
pub(crate) enum Failure<T> {
    /// Forces cannot be had however short the correction.
    Trouble(T),
    /// The system is singular, or the residual does not fall; relative residuals of all iterations.
    NoConvergence(Vec<f64>),
}

/// Residual up to which a small correction counts.
const NEARLY: f64 = 1e-4;
/// Lengths that the line search tries.
const SEARCHES: usize = 6;
/// Halvings before a correction that inverts particles is given up.
const HALVINGS: usize = 12;
/// Share of the work of the forces along a correction at which it is long enough.
const LEFT: f64 = 0.8;

/// Finds the displacement in balance from a start, in place. Returns the residual there, and the relative residuals of the iterations.
pub(crate) fn newton<B: Balance>(
    balance: &mut B,
    rules: Rules,
    u: &mut Vec<[f64; 3]>,
) -> Result<(Residual, Vec<f64>), Failure<B::Trouble>> {
    let start = u.clone();
    let mut residual = balance.residual(u).map_err(Failure::Trouble)?;
    let mut history = Vec::new();
    loop {
        let relative = dot(&residual.forces, &residual.forces).sqrt() / if residual.size > 0.0 { residual.size } else { 1.0 };
        history.push(relative);
        if relative <= rules.residual {
            return Ok((residual, history));
        }
        if history.len() > rules.iterations || !relative.is_finite() {
            return Err(Failure::NoConvergence(history));
        }
        let Some(correction) = balance.correction(u, &residual.forces).map_err(Failure::Trouble)? else {
            return Err(Failure::NoConvergence(history));
        };
        if relative <= NEARLY && largest(&correction, None) <= rules.residual * largest(u, Some(start.as_slice())) {
            return Ok((residual, history));
        }
        let first = dot(&residual.forces, &correction);
        (*u, residual) = search(balance, u, &correction, first).map_err(Failure::Trouble)?;
    }
}

/// A displacement along the correction, with its residual: the whole of it, unless that inverts particles or overshoots.
fn search<B: Balance>(
    balance: &mut B,
    u: &[[f64; 3]],
    correction: &[[f64; 3]],
    first: f64,
) -> Result<(Vec<[f64; 3]>, Residual), B::Trouble> {
    let moved =
        |share: f64| -> Vec<[f64; 3]> { u.iter().zip(correction).map(|(u, c)| std::array::from_fn(|a| u[a] + share * c[a])).collect() };
    let mut share = 1.0;
    let mut left = HALVINGS;
    let mut found = loop {
        match balance.residual(&moved(share)) {
            Ok(found) => break found,
            Err(trouble) if left == 0 => return Err(trouble),
            Err(_) => (share, left) = (0.5 * share, left - 1),
        }
    };
    // The work of the forces out of balance along the correction vanishes where it is long enough. If it has turned its sign, that is
    // between 0 and `share` (Matthies and Strang 1979).
    let mut low = (0.0, first);
    let mut high = (share, dot(&found.forces, correction));
    for _ in 0..SEARCHES {
        if high.1.abs() <= LEFT * first.abs() || high.1 * first > 0.0 {
            break;
        }
        let secant = low.0 + (high.0 - low.0) * low.1 / (low.1 - high.1);
        let middle = secant.clamp(low.0 + 0.1 * (high.0 - low.0), high.0);
        let Ok(there) = balance.residual(&moved(middle)) else { break };
        let work = dot(&there.forces, correction);
        (share, found) = (middle, there);
        if work * first > 0.0 {
            low = (middle, work);
        } else {
            high = (middle, work);
        }
        if work.abs() <= LEFT * first.abs() {
            break;
        }
    }
    Ok((moved(share), found))
}

pub(super) fn dot(a: &[[f64; 3]], b: &[[f64; 3]]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a[0] * b[0] + a[1] * b[1] + a[2] * b[2]).sum()
}

/// Largest component of `a`, or of its difference from `b`.
fn largest(a: &[[f64; 3]], b: Option<&[[f64; 3]]>) -> f64 {
    let of = |(i, a): (usize, &[f64; 3])| (0..3).map(|k| (a[k] - b.map_or(0.0, |b| b[i][k])).abs()).fold(0.0, f64::max);
    a.iter().enumerate().map(of).fold(0.0, f64::max)
}
