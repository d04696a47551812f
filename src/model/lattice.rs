//! Bodies whose particles stand in full rows and columns.

use super::sample::Sample;

/// The particles of a body row by row.
#[derive(Debug, Clone)]
pub(crate) struct Lattice {
    /// Particles along each axis; 1 beyond the dimension.
    pub(crate) counts: [usize; 3],
    /// Ids of the particles, the last axis fastest.
    pub(crate) ids: Vec<u32>,
}

/// The lattice that samples form, the ids of which begin at `first_id`; `None` where rows or columns are not full or not straight.
pub(super) fn lattice(samples: &[Sample], first_id: usize, dimension: usize, cell: f64) -> Option<Lattice> {
    // round-off of positions, far below the distance of particles
    let tolerance = 1e-9 * cell;
    let mut counts = [1; 3];
    let mut ranks = vec![[0usize; 3]; samples.len()];
    for axis in 0..dimension {
        let mut order: Vec<usize> = (0..samples.len()).collect();
        order.sort_by(|&a, &b| samples[a].position[axis].total_cmp(&samples[b].position[axis]));
        let mut rank = 0;
        for pair in order.windows(2) {
            let [a, b] = [pair[0], pair[1]].map(|p| samples[p].position[axis]);
            rank += usize::from(b - a > tolerance);
            ranks[pair[1]][axis] = rank;
        }
        counts[axis] = rank + 1;
    }
    if counts.iter().product::<usize>() != samples.len() {
        return None;
    }
    let mut ids = vec![u32::MAX; samples.len()];
    for (p, [i, j, k]) in ranks.into_iter().enumerate() {
        let place = &mut ids[(i * counts[1] + j) * counts[2] + k];
        if *place != u32::MAX {
            return None;
        }
        *place = (first_id + p) as u32;
    }
    Some(Lattice { counts, ids })
}
