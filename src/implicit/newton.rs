//! Newton's method with a line search.

use super::Matrix;

/// A balance of forces to be met by displacing nodes.
pub(crate) trait Balance {
    /// Why forces cannot be had.
    type Trouble;

    /// Forces out of balance where the nodes are displaced by `u` \[m\].
    fn residual(&mut self, u: &[[f64; 3]]) -> Result<Residual, Self::Trouble>;

    /// Minus the derivative of the residual; tells whether it is symmetric.
    fn stiffness(&mut self, u: &[[f64; 3]], matrix: &mut Matrix) -> Result<bool, Self::Trouble>;
}

/// Forces out of balance.
pub(crate) struct Residual {
    /// By node \[N\]; what stands at held components is the force of the support, with its sign turned.
    pub(crate) forces: Vec<[f64; 3]>,
    /// Norm of the largest of the forces that should be in balance \[N\].
    pub(crate) size: f64,
}

/// When to stop.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Rules {
    /// Norm of the residual over that of the forces in balance.
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

/// Finds the displacement in balance from a start, in place. Returns the relative residuals of the iterations.
pub(crate) fn newton<B: Balance>(
    balance: &mut B,
    matrix: &mut Matrix,
    rules: Rules,
    u: &mut Vec<[f64; 3]>,
) -> Result<Vec<f64>, Failure<B::Trouble>> {
    let components: Vec<(usize, usize)> = matrix.components().collect();
    let gather = |forces: &[[f64; 3]]| components.iter().map(|&(node, axis)| forces[node][axis]).collect::<Vec<f64>>();
    let norm = |v: &[f64]| v.iter().map(|v| v * v).sum::<f64>().sqrt();
    let mut residual = balance.residual(u).map_err(Failure::Trouble)?;
    let start = u.clone();
    let mut history = Vec::new();
    loop {
        let mut correction = gather(&residual.forces);
        let size = if residual.size > 0.0 { residual.size } else { 1.0 };
        let relative = norm(&correction) / size;
        history.push(relative);
        if relative <= rules.residual {
            return Ok(history);
        }
        if history.len() > rules.iterations || !relative.is_finite() {
            return Err(Failure::NoConvergence(history));
        }
        matrix.clear();
        let symmetric = balance.stiffness(u, matrix).map_err(Failure::Trouble)?;
        let out_of_balance = correction.clone();
        match matrix.factor(symmetric) {
            Some(factor) => factor.solve(&mut correction),
            None => return Err(Failure::NoConvergence(history)),
        }
        let largest = |v: f64, x: f64| v.max(x.abs());
        let step = correction.iter().copied().fold(0.0, largest);
        let travelled = u.iter().flatten().zip(start.iter().flatten()).map(|(u, s)| u - s).fold(0.0, largest);
        if relative <= NEARLY && step <= rules.residual * travelled {
            return Ok(history);
        }
        let moved = |share: f64| {
            let mut moved = u.clone();
            for (&(node, axis), c) in components.iter().zip(&correction) {
                moved[node][axis] += share * c;
            }
            moved
        };
        // work of the forces out of balance along the correction: it vanishes where the correction is long enough
        let slope = |r: &[f64]| r.iter().zip(&correction).map(|(r, c)| r * c).sum::<f64>();
        let first = slope(&out_of_balance);
        let mut share = 1.0;
        let mut next = Err(None);
        for _ in 0..HALVINGS {
            match balance.residual(&moved(share)) {
                Ok(found) => {
                    next = Ok(found);
                    break;
                }
                Err(trouble) => next = Err(Some(trouble)),
            }
            share *= 0.5;
        }
        let mut found = match next {
            Ok(found) => found,
            Err(Some(trouble)) => return Err(Failure::Trouble(trouble)),
            Err(None) => return Err(Failure::NoConvergence(history)),
        };
        // a correction that overshoots: between 0 and `share` the work turns its sign (Matthies and Strang 1979)
        let (mut low, mut high) = ((0.0, first), (share, slope(&gather(&found.forces))));
        for _ in 0..SEARCHES {
            if high.1.abs() <= 0.8 * first.abs() || high.1 * first > 0.0 {
                break;
            }
            let middle = (low.0 + (high.0 - low.0) * low.1 / (low.1 - high.1)).clamp(low.0 + 0.1 * (high.0 - low.0), high.0);
            let Ok(there) = balance.residual(&moved(middle)) else { break };
            let work = slope(&gather(&there.forces));
            if work * first > 0.0 {
                low = (middle, work);
            }
            high = if work * first > 0.0 { high } else { (middle, work) };
            share = middle;
            found = there;
            if work.abs() <= 0.8 * first.abs() {
                break;
            }
        }
        *u = moved(share);
        residual = found;
    }
}
