//! Bodies whose particles stand in full rows and columns.

use super::Chart;
use super::sample::Sample;

/// The particles of a body row by row.
#[derive(Debug, Clone)]
pub(crate) struct Lattice {
    /// Particles along each axis; 1 beyond the dimension.
    pub(crate) counts: [usize; 3],
    /// Ids of the particles, the last axis fastest.
    pub(crate) ids: Vec<u32>,
    /// Where the lower and upper end of each axis are: weights of the particles of a row next to them, from the end on.
    pub(crate) ends: [[Vec<f64>; 2]; 3],
    /// Lengths of the body at time 0 \[m\].
    pub(crate) extents: [f64; 3],
    /// Of a plane body: the map from the unit square, and where its rows and columns are there.
    pub(crate) sheet: Option<(Chart, [Vec<f64>; 2])>,
}

impl Lattice {
    /// Particles that were sampled on the square, with ids from `first_id` on.
    pub(super) fn of_chart(chart: Chart, sites: [Vec<f64>; 2], first_id: usize) -> Self {
        let counts = [sites[0].len(), sites[1].len(), 1];
        let ids = (first_id..first_id + counts[0] * counts[1]).map(|id| id as u32).collect();
        Self { counts, ids, ends: Default::default(), extents: [0.0; 3], sheet: Some((chart, sites)) }
    }
}

/// Particles that the place of an end is extrapolated from: as many as a cubic has coefficients.
const BESIDE_AN_END: usize = 4;

/// Weights of Lagrange's polynomial through `places` at `at`.
fn extrapolation(places: &[f64], at: f64) -> Vec<f64> {
    let factor = |i: usize, j: usize| if i == j { 1.0 } else { (at - places[j]) / (places[i] - places[j]) };
    (0..places.len()).map(|i| (0..places.len()).map(|j| factor(i, j)).product()).collect()
}

/// The lattice that samples form, the ids of which begin at `first_id`, in a body between `low` and `high` \[m\]; `None` where rows or columns are
/// not full or not straight.
pub(super) fn lattice(samples: &[Sample], first_id: usize, [low, high]: [&[f64]; 2], cell: f64) -> Option<Lattice> {
    let dimension = low.len();
    // round-off of positions, far below the distance of particles
    let tolerance = 1e-9 * cell;
    let mut counts = [1; 3];
    let mut ranks = vec![[0usize; 3]; samples.len()];
    let mut ends: [[Vec<f64>; 2]; 3] = Default::default();
    for axis in 0..dimension {
        let mut order: Vec<usize> = (0..samples.len()).collect();
        order.sort_by(|&a, &b| samples[a].position[axis].total_cmp(&samples[b].position[axis]));
        let mut rank = 0;
        let mut places = vec![samples[*order.first()?].position[axis]];
        for pair in order.windows(2) {
            let [a, b] = [pair[0], pair[1]].map(|p| samples[p].position[axis]);
            if b - a > tolerance {
                rank += 1;
                places.push(b);
            }
            ranks[pair[1]][axis] = rank;
        }
        counts[axis] = rank + 1;
        let beside = places.len().min(BESIDE_AN_END);
        let lower = extrapolation(&places[..beside], low[axis]);
        places.reverse();
        ends[axis] = [lower, extrapolation(&places[..beside], high[axis])];
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
    let extents = std::array::from_fn(|a| if a < dimension { high[a] - low[a] } else { 1.0 });
    Some(Lattice { counts, ids, ends, extents, sheet: None })
}
