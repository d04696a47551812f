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
    let inverse = 0.5 / half;
    ((integral(r + half) - integral(r - half)) * inverse, (linear(r + half) - linear(r - half)) * inverse)
}

/// First of the nodes that a domain around `s` touches, in cells from the origin.
#[inline(always)]
pub(super) fn first(s: f64, half: f64) -> i32 {
    (s - half).floor() as i32
}
