//! The Jaumann rate, eight particles at a time (see `material::hypo`).

use super::chunk::{Column, load_eight};
use super::task::Sweep;
use super::update::lame;
use crate::lanes::{Real, Wide};
use crate::material::MAX_HISTORY;

/// Place of a stress component in a history.
pub(super) const COMPONENT: [[usize; 3]; 3] = [[0, 5, 4], [5, 1, 3], [4, 3, 2]];

/// Stress and energy of `count` particles from `first` on, the first of which is number `at` of the chunk, after a step of `dt` \[s\].
///
/// # Safety
/// The rows are the caller's, with a history of this law; there are at most [`crate::lanes::LANES`].
#[inline(always)]
pub(super) unsafe fn update<const D: usize, V: Real<Wide = E>, E: Wide>(
    sweep: &Sweep,
    dt: f64,
    velocity_gradient: &[[Column<V::Number>; 3]; 3],
    jacobian: E,
    first: usize,
    at: usize,
    count: usize,
) {
    let rows = &sweep.rows;
    let mut gradient = [[E::splat(0.0); D]; D];
    for r in 0..D {
        for c in 0..D {
            gradient[r][c] = E::splat(dt) * load_eight::<V>(&velocity_gradient[r][c], at);
        }
    }
    let mut history = [E::splat(0.0); MAX_HISTORY];
    for h in 0..MAX_HISTORY {
        // SAFETY: the rows are ours.
        history[h] = unsafe { E::load_some(rows.history.at(h, first), count) };
    }
    let (lambda, mu) = lame::<E>(sweep, first, count);
    turn(lambda, mu, &gradient, jacobian, &mut history);
    for h in 0..MAX_HISTORY {
        // SAFETY: the rows are ours.
        unsafe { history[h].store_some(rows.history.at(h, first), count) };
    }
}

/// `hypo::update` for a gradient of the displacement of a step: across what is not there nothing turns.
#[inline(always)]
fn turn<const D: usize, E: Wide>(lambda: E, mu: E, gradient: &[[E; D]; D], jacobian: E, history: &mut [E; MAX_HISTORY]) {
    let zero = E::splat(0.0);
    let (mut spin, mut strain, mut square, mut spread) = ([[zero; D]; D], [[zero; D]; D], zero, zero);
    for i in 0..D {
        for j in 0..D {
            spin[i][j] = (gradient[i][j] - gradient[j][i]) * E::splat(0.25);
            strain[i][j] = (gradient[i][j] + gradient[j][i]) * E::splat(0.5);
            if i < j {
                square = spin[i][j].fma(spin[i][j], square);
            }
        }
        spread = spread + gradient[i][i];
    }
    let share = E::splat(2.0) / (E::splat(1.0) + square);
    let (mut rotation, mut half) = ([[zero; D]; D], [[zero; D]; D]);
    for i in 0..D {
        for j in 0..D {
            let mut sum = spin[i][j];
            for k in 0..D {
                sum = spin[i][k].fma(spin[k][j], sum);
            }
            rotation[i][j] = share.fma(sum, E::splat(if i == j { 1.0 } else { 0.0 }));
        }
    }
    for i in 0..D {
        for j in 0..D {
            for k in 0..D {
                half[i][j] = rotation[i][k].fma(history[COMPONENT[k][j]], half[i][j]);
            }
        }
    }
    let (pressure, twice) = (lambda * spread * jacobian, E::splat(2.0) * mu * jacobian);
    let mut work = zero;
    for i in 0..3 {
        if i >= D {
            history[COMPONENT[i][i]] = history[COMPONENT[i][i]] + pressure;
            continue;
        }
        for j in i..D {
            let mut old = zero;
            for k in 0..D {
                old = half[i][k].fma(rotation[j][k], old);
            }
            let new = twice.fma(strain[i][j], if i == j { old + pressure } else { old });
            let of = (old + new) * strain[i][j];
            work = if i == j { E::splat(0.5).fma(of, work) } else { work + of };
            history[COMPONENT[i][j]] = new;
        }
    }
    history[6] = history[6] + work;
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lanes::{LANES, Plain};
    use crate::material::{Increment, Lame, Material};
    use nalgebra::Matrix3;

    /// Eight particles against the law for one, at gradients that turn and stretch by tenths.
    fn check<const D: usize>() {
        let lame = Lame { lambda: 3.0, mu: 2.0 };
        let of = |n: usize, lane: usize| ((12.9898 * (n + 1) as f64 + 78.233 * lane as f64).sin() * 43.0).sin();
        let mut gradient = [[Plain::splat(0.0); D]; D];
        for r in 0..D {
            for c in 0..D {
                gradient[r][c] = Plain::load_eight(&std::array::from_fn(|lane| 0.2 * of(3 * r + c, lane)));
            }
        }
        // the stress across a plane has no shear
        let exists = |h: usize| D == 3 || h < 3 || h == 6 || D == 2 && h == 5;
        let start = |h: usize, lane: usize| if exists(h) { of(20 + h, lane) } else { 0.0 };
        let mut history = [Plain::splat(0.0); MAX_HISTORY];
        for (h, numbers) in history.iter_mut().enumerate() {
            *numbers = Plain::load_eight(&std::array::from_fn(|lane| start(h, lane)));
        }
        let jacobian: [f64; LANES] = std::array::from_fn(|lane| 1.0 + 0.3 * of(40, lane));
        turn(Plain::splat(lame.lambda), Plain::splat(lame.mu), &gradient, Plain::load_eight(&jacobian), &mut history);
        for lane in 0..LANES {
            let mut one = std::array::from_fn(|h| start(h, lane));
            let gradient = Matrix3::from_fn(|r, c| if r < D && c < D { 0.2 * of(3 * r + c, lane) } else { 0.0 });
            Material::Hypo(lame).update(&mut one, &Increment { gradient, jacobian: jacobian[lane] });
            for h in 0..MAX_HISTORY {
                let mut numbers = [0.0; LANES];
                history[h].store_lanes(&mut numbers);
                // sums of a dozen numbers below 2
                assert!((numbers[lane] - one[h]).abs() < 1e-14, "D = {D}, lane {lane}, {h}: {} {}", numbers[lane], one[h]);
            }
        }
    }

    #[test]
    fn eight_particles_follow_the_law_of_one() {
        check::<1>();
        check::<2>();
        check::<3>();
    }
}
