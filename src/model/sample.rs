//! Fills a body with particles.

use crate::basis::Axis;
use crate::quadrature::gauss_legendre;
use crate::scene::{Body, OneOrEach, Positions};

/// One particle at time 0.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Sample {
    /// Position \[m\]; axes beyond the dimension are 0.
    pub(crate) position: [f64; 3],
    /// Share of the volume \[m3\].
    pub(crate) volume: f64,
}

/// How far outside its shape, in cells, a particle still counts as in it: round-off of the corners of shapes and cells.
const SLACK: f64 = 1e-9;
/// Largest move of a jittered particle, as a share of the spacing.
const JITTER: f64 = 0.4;

/// The particles of a body, cell by cell with the last axis fastest. The scene must have passed its check.
pub(crate) fn sample(body: &Body, per_cell: &OneOrEach<usize>, positions: Positions, axes: &[Axis]) -> Vec<Sample> {
    let dimension = axes.len();
    let (lower, upper) = body.shape.bounds(dimension);
    let slack = SLACK * Axis::smallest_cell(axes);
    // Per axis: first cell, number of cells, local coordinates and weights of the particles of a cell.
    let columns: Vec<Column> = (0..dimension)
        .map(|a| {
            let first = axes[a].cell(lower[a] + slack).0;
            let last = axes[a].cell(upper[a] - slack).0;
            Column::new(first, last, per_cell.axis(a).unwrap_or(1), positions)
        })
        .collect();
    let cell_volume: f64 = axes.iter().map(Axis::cell_size).product();
    let mut random = SplitMix(body.seed);
    let mut samples = Vec::new();
    let counts: Vec<usize> = columns.iter().map(Column::len).collect();
    for cell in Odometer::new(columns.iter().map(|c| c.cells).collect()) {
        for point in Odometer::new(counts.clone()) {
            let place = |a: usize| {
                axes[a].origin() + axes[a].cell_size() * ((columns[a].first + cell[a] as i32) as f64 + columns[a].points[point[a]].0)
            };
            let mut position = [0.0; 3];
            let mut volume = cell_volume;
            for a in 0..dimension {
                position[a] = place(a);
                volume *= columns[a].points[point[a]].1;
            }
            if !body.shape.contains(&position[..dimension], slack) {
                continue;
            }
            if positions == Positions::Jittered {
                let mut moved = position;
                for a in 0..dimension {
                    moved[a] += (2.0 * random.next() - 1.0) * JITTER * axes[a].cell_size() / counts[a] as f64;
                }
                // a particle that would leave its body stays where it was
                if body.shape.contains(&moved[..dimension], 0.0) {
                    position = moved;
                }
            }
            samples.push(Sample { position, volume });
        }
    }
    samples
}

/// Places on a unit length and their shares: evenly from end to end, with half a share at the ends.
pub(super) fn up_to_the_ends(count: f64) -> Vec<(f64, f64)> {
    let n = count as usize;
    (0..=n).map(|i| (i as f64 / count, if i == 0 || i == n { 0.5 } else { 1.0 } / count)).collect()
}

/// The particles of a box, on its faces too, the last axis fastest.
pub(super) fn with_faces([min, max]: [&[f64]; 2], per_cell: &OneOrEach<usize>, axes: &[Axis]) -> Vec<Sample> {
    let mut samples = vec![Sample { position: [0.0; 3], volume: 1.0 }];
    for (a, axis) in axes.iter().enumerate() {
        let length = max[a] - min[a];
        let line = up_to_the_ends((length / axis.cell_size() * per_cell.axis(a).unwrap_or(1) as f64).round().max(1.0));
        let at = |sample: Sample, (place, share): (f64, f64)| {
            let mut position = sample.position;
            position[a] = min[a] + place * length;
            Sample { position, volume: sample.volume * share * length }
        };
        samples = samples.iter().flat_map(|sample| line.iter().map(move |site| at(*sample, *site))).collect();
    }
    samples
}

/// The particles of a body along one axis.
struct Column {
    first: i32,
    cells: usize,
    /// Local coordinate and weight of each particle of a cell.
    points: Vec<(f64, f64)>,
}

impl Column {
    fn new(first: i32, last: i32, per_cell: usize, positions: Positions) -> Self {
        let points = match positions {
            Positions::Gauss => gauss_legendre(per_cell),
            Positions::Uniform | Positions::Jittered => {
                (0..per_cell).map(|i| ((i as f64 + 0.5) / per_cell as f64, 1.0 / per_cell as f64)).collect()
            }
        };
        Self { first, cells: (last - first + 1).max(0) as usize, points }
    }
    fn len(&self) -> usize {
        self.points.len()
    }
}

/// Counts through a box of indices, the last one fastest.
struct Odometer {
    counts: Vec<usize>,
    next: Option<Vec<usize>>,
}

impl Odometer {
    fn new(counts: Vec<usize>) -> Self {
        let next = counts.iter().all(|&c| c > 0).then(|| vec![0; counts.len()]);
        Self { counts, next }
    }
}

impl Iterator for Odometer {
    type Item = Vec<usize>;
    fn next(&mut self) -> Option<Vec<usize>> {
        let current = self.next.take()?;
        let mut after = current.clone();
        for axis in (0..after.len()).rev() {
            after[axis] += 1;
            if after[axis] < self.counts[axis] {
                self.next = Some(after);
                break;
            }
            after[axis] = 0;
        }
        Some(current)
    }
}

/// SplitMix64 (Steele, Lea, Flood 2014): small, and the same on every machine.
struct SplitMix(u64);

impl SplitMix {
    /// Uniform in \[0, 1).
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::basis::Family;
    use crate::scene::Shape;

    fn body(shape: Shape) -> Body {
        Body { material: String::new(), shape, particles_per_cell: None, positions: None, seed: 7, velocity: Vec::new() }
    }

    #[test]
    fn a_fitted_box_is_filled_exactly() {
        let axes: Vec<Axis> = (0..2).map(|_| Axis::new(0.0, 0.1, 10, Family::OpenSpline(2))).collect();
        for positions in [Positions::Uniform, Positions::Gauss, Positions::Jittered] {
            let shape = Shape::Box { min: vec![0.1, 0.2], max: vec![0.7, 1.0] };
            let samples = sample(&body(shape.clone()), &OneOrEach::One(3), positions, &axes);
            assert_eq!(samples.len(), 6 * 8 * 9);
            let volume: f64 = samples.iter().map(|s| s.volume).sum();
            assert!((volume - 0.48).abs() < 1e-13);
            assert!(samples.iter().all(|s| shape.contains(&s.position[..2], 1e-12)));
        }
    }

    #[test]
    fn jitter_depends_on_the_seed_alone() {
        let axes = [Axis::new(0.0, 0.1, 10, Family::OpenSpline(2))];
        let mut jittered = body(Shape::Box { min: vec![0.0], max: vec![1.0] });
        let sample = |body: &Body| sample(body, &OneOrEach::One(2), Positions::Jittered, &axes);
        let first = sample(&jittered);
        assert_eq!(first, sample(&jittered));
        jittered.seed = 8;
        assert_ne!(first, sample(&jittered));
    }
}
