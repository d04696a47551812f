//! Generalised interpolation (GIMP): linear functions averaged over the domain of a particle (Bardenhagen and Kober 2004; Buzzi et al. 2008,
//! eqs 17 and 18). Domains are boxes along the axes.

/// Integral of the linear function of a node at 0 from -1 to `u`.
fn integral(u: f64) -> f64 {
    let u = u.clamp(-1.0, 1.0);
    if u < 0.0 { 0.5 * (1.0 + u) * (1.0 + u) } else { 1.0 - 0.5 * (1.0 - u) * (1.0 - u) }
}

fn linear(u: f64) -> f64 {
    (1.0 - u.abs()).max(0.0)
}

/// Weight and slope, per cell, of a node for a particle `r` cells above it whose domain reaches `half` cells to either side.
#[inline(always)]
pub(super) fn weight(r: f64, half: f64) -> (f64, f64) {
    let (inverse, distance) = (0.5 / half, r.abs());
    if distance >= half && distance > 1.0 - half {
        // The domain reaches over the end of the function but not over its node: as a difference of integrals a small weight would be noise,
        // of either sign.
        let inside = (1.0 + half - distance).max(0.0);
        return (0.5 * inside * inside * inverse, -inside * inverse * r.signum());
    }
    ((integral(r + half) - integral(r - half)) * inverse, (linear(r + half) - linear(r - half)) * inverse)
}

/// First of the nodes that a domain around `s` touches, in cells from the origin.
#[inline(always)]
pub(super) fn first(s: f64, half: f64) -> i32 {
    (s - half).floor() as i32
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn weights_are_never_negative_and_join_without_a_gap() {
        for half in [0.05, 0.25, 0.5, 0.75, 1.0] {
            let mut before = weight(-2.1, half);
            for step in 1..=42_000 {
                let r = -2.1 + 1e-4 * f64::from(step);
                let now = weight(r, half);
                assert!(now.0 >= 0.0);
                // slopes are at most 1, their own at most 1 / half
                assert!((now.0 - before.0).abs() < 1.01e-4 && (now.1 - before.1).abs() < 1.01e-4 / half, "{half} at {r}");
                before = now;
            }
        }
    }
}
