//! Small-strain linear elasticity: the stress follows the sum of the strain increments. Changes of volume and rotations are ignored,
//! which is the law of the small-strain problems of all three papers (sigma' = D : eps').

use super::{History, Increment, Lame, store_stress, stress_of, symmetric};

pub(super) const HISTORY: usize = 6;

pub(super) fn update(lame: &Lame, history: &mut History, increment: &Increment) {
    let stress = stress_of(history) + lame.stress(&symmetric(&increment.gradient));
    store_stress(history, &stress);
}

pub(super) fn energy(lame: &Lame, history: &History) -> f64 {
    lame.energy_of_stress(&stress_of(history))
}
