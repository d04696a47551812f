//! Nodes with lumped masses: what a kick and a drift do to them, in one pass over memory each.

use crate::total::wide::{Instructions, LANES};
use rayon::prelude::*;

/// Numbers of a share of the work: sums are made share by share, whatever the number of threads.
const SHARE: usize = 12_288;

/// Adds `h` times force over mass to velocities; returns the work of the external forces, which act along the mean of the velocities before and
/// after \[J\]. All are by node and component; without external forces their list is empty.
pub(in crate::total) fn kick(
    instructions: Instructions,
    h: f64,
    inverse: &[f64],
    internal: &[f64],
    external: &[f64],
    velocity: &mut [f64],
) -> f64 {
    let share = |(i, velocity): (usize, &mut [f64])| -> f64 {
        let (start, end) = (i * SHARE, i * SHARE + velocity.len());
        let (inverse, internal) = (&inverse[start..end], &internal[start..end]);
        let external = if external.is_empty() { external } else { &external[start..end] };
        match instructions {
            #[cfg(target_arch = "x86_64")]
            // SAFETY: the processor has these instructions
            Instructions::Avx512 | Instructions::Avx2 => unsafe { kick_avx2(h, inverse, internal, external, velocity) },
            Instructions::Portable => kick_share(h, inverse, internal, external, velocity),
        }
    };
    if velocity.len() <= 2 * SHARE || rayon::current_num_threads() == 1 {
        return velocity.chunks_mut(SHARE).enumerate().map(share).sum();
    }
    let works: Vec<f64> = velocity.par_chunks_mut(SHARE).enumerate().map(share).collect();
    works.iter().sum()
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2")]
fn kick_avx2(h: f64, inverse: &[f64], internal: &[f64], external: &[f64], velocity: &mut [f64]) -> f64 {
    kick_share(h, inverse, internal, external, velocity)
}

/// No fused operations: the same bytes on all processors.
#[inline(always)]
fn kick_share(h: f64, inverse: &[f64], internal: &[f64], external: &[f64], velocity: &mut [f64]) -> f64 {
    if external.is_empty() {
        for i in 0..velocity.len() {
            velocity[i] += h * (internal[i] * inverse[i]);
        }
        return 0.0;
    }
    let mut work = [0.0; LANES];
    let (velocities, velocity_rest) = velocity.as_chunks_mut::<LANES>();
    let (inverses, inverse_rest) = inverse.as_chunks::<LANES>();
    let (internals, internal_rest) = internal.as_chunks::<LANES>();
    let (externals, external_rest) = external.as_chunks::<LANES>();
    for i in 0..velocities.len() {
        let (v, m, f, e) = (&mut velocities[i], &inverses[i], &internals[i], &externals[i]);
        for k in 0..LANES {
            let gained = h * ((f[k] + e[k]) * m[k]);
            work[k] += e[k] * (v[k] + 0.5 * gained);
            v[k] += gained;
        }
    }
    for k in 0..velocity_rest.len() {
        let gained = h * ((internal_rest[k] + external_rest[k]) * inverse_rest[k]);
        work[k] += external_rest[k] * (velocity_rest[k] + 0.5 * gained);
        velocity_rest[k] += gained;
    }
    let mut sum = 0.0;
    for k in 0..LANES {
        sum += work[k];
    }
    h * sum
}

/// Adds `h` times velocities to displacements.
pub(in crate::total) fn drift(instructions: Instructions, h: f64, velocity: &[f64], displacement: &mut [f64]) {
    let share = |(i, displacement): (usize, &mut [f64])| {
        let velocity = &velocity[i * SHARE..i * SHARE + displacement.len()];
        match instructions {
            #[cfg(target_arch = "x86_64")]
            // SAFETY: the processor has these instructions
            Instructions::Avx512 | Instructions::Avx2 => unsafe { drift_avx2(h, velocity, displacement) },
            Instructions::Portable => drift_share(h, velocity, displacement),
        }
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
