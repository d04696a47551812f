//! What a kick and a drift do to nodes, in one pass over memory each.

use crate::total::wide::LANES;
use rayon::prelude::*;

/// Numbers of a share of the work: sums are made share by share, whatever the number of threads.
const SHARE: usize = 12_288;

/// What accelerates nodes; all lists are by node and component.
#[derive(Clone, Copy)]
pub(in crate::total) enum Push<'a> {
    /// Internal forces \[N\], to which external ones are added, times one over the mass \[1/kg\].
    Forces(&'a [f64], &'a [f64]),
    /// Accelerations \[m/s2\].
    Accelerations(&'a [f64]),
}

/// Accelerates nodes over a time of `h` \[s\]; returns the work of the external forces, which act along the mean of the velocities before and
/// after \[J\]. Without external forces their list is empty.
pub(in crate::total) fn kick(h: f64, push: Push<'_>, external: &[f64], velocity: &mut [f64]) -> f64 {
    let share = |(i, velocity): (usize, &mut [f64])| -> f64 {
        let range = i * SHARE..i * SHARE + velocity.len();
        let external = if external.is_empty() { external } else { &external[range.clone()] };
        let push = match push {
            Push::Forces(internal, inverse) => Push::Forces(&internal[range.clone()], &inverse[range]),
            Push::Accelerations(all) => Push::Accelerations(&all[range]),
        };
        #[cfg(target_arch = "x86_64")]
        if std::arch::is_x86_feature_detected!("avx2") {
            // SAFETY: the processor has these instructions
            return unsafe { kick_avx2(h, push, external, velocity) };
        }
        kick_share(h, push, external, velocity)
    };
    if velocity.len() <= 2 * SHARE || rayon::current_num_threads() == 1 {
        return velocity.chunks_mut(SHARE).enumerate().map(share).sum();
    }
    let works: Vec<f64> = velocity.par_chunks_mut(SHARE).enumerate().map(share).collect();
    works.iter().sum()
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2")]
fn kick_avx2(h: f64, push: Push<'_>, external: &[f64], velocity: &mut [f64]) -> f64 {
    kick_share(h, push, external, velocity)
}

/// No fused operations: the same bytes on all processors.
#[inline(always)]
fn kick_share(h: f64, push: Push<'_>, external: &[f64], velocity: &mut [f64]) -> f64 {
    match (push, external.is_empty()) {
        (Push::Forces(internal, inverse), true) => {
            for ((v, f), m) in velocity.iter_mut().zip(internal).zip(inverse) {
                *v += h * (f * m);
            }
            0.0
        }
        (Push::Accelerations(all), true) => {
            for (v, a) in velocity.iter_mut().zip(all) {
                *v += h * a;
            }
            0.0
        }
        (Push::Forces(internal, inverse), false) => {
            let mut work = [0.0; LANES];
            let eights = velocity.chunks_mut(LANES).zip(external.chunks(LANES)).zip(internal.chunks(LANES)).zip(inverse.chunks(LANES));
            for (((v, e), f), m) in eights {
                for k in 0..v.len() {
                    let gained = h * ((f[k] + e[k]) * m[k]);
                    work[k] += e[k] * (v[k] + 0.5 * gained);
                    v[k] += gained;
                }
            }
            h * total(&work)
        }
        (Push::Accelerations(all), false) => {
            let mut work = [0.0; LANES];
            let eights = velocity.chunks_mut(LANES).zip(external.chunks(LANES)).zip(all.chunks(LANES));
            for ((v, e), a) in eights {
                for k in 0..v.len() {
                    let gained = h * a[k];
                    work[k] += e[k] * (v[k] + 0.5 * gained);
                    v[k] += gained;
                }
            }
            h * total(&work)
        }
    }
}

#[inline(always)]
fn total(work: &[f64; LANES]) -> f64 {
    let mut sum = 0.0;
    for k in 0..LANES {
        sum += work[k];
    }
    sum
}

/// Adds `h` times velocities to displacements.
pub(in crate::total) fn drift(h: f64, velocity: &[f64], displacement: &mut [f64]) {
    let share = |(i, displacement): (usize, &mut [f64])| {
        let velocity = &velocity[i * SHARE..i * SHARE + displacement.len()];
        #[cfg(target_arch = "x86_64")]
        if std::arch::is_x86_feature_detected!("avx2") {
            // SAFETY: the processor has these instructions
            return unsafe { drift_avx2(h, velocity, displacement) };
        }
        drift_share(h, velocity, displacement);
    };
    if displacement.len() <= 2 * SHARE || rayon::current_num_threads() == 1 {
        displacement.chunks_mut(SHARE).enumerate().for_each(share);
    } else {
        displacement.par_chunks_mut(SHARE).enumerate().for_each(share);
    }
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2")]
fn drift_avx2(h: f64, velocity: &[f64], displacement: &mut [f64]) {
    drift_share(h, velocity, displacement);
}

#[inline(always)]
fn drift_share(h: f64, velocity: &[f64], displacement: &mut [f64]) {
    for (u, v) in displacement.iter_mut().zip(velocity) {
        *u += h * v;
    }
}
