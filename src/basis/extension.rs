//! Extended B-splines (Hollig, Reif, Wipper 2001, SIAM J. Numer. Anal. 39, 442-462): a function with next to nothing of the body in its support
//! follows the polynomial that those of a nearby block of well supported functions stand for. All polynomials of the degree stay in the space,
//! and its condition does not depend on how the edge of the body cuts the cells.

use super::Axis;

/// Blocks of functions, one of which a function may follow: first functions relative to it, nearest first.
#[derive(Debug, Clone)]
pub(crate) struct Extension {
    axes: Vec<Axis>,
    offsets: Vec<[i32; 3]>,
}

impl Extension {
    /// For B-splines on these axes.
    pub(crate) fn new(axes: &[Axis]) -> Self {
        let width = axes[0].width() as i32;
        // an edge leaves a function without support at most a support away from a full cell, with as much again for corners
        let range = |a: usize| if a < axes.len() { -3 * width..=2 * width } else { 0..=0 };
        let mut offsets: Vec<[i32; 3]> = range(0).flat_map(|i| range(1).flat_map(move |j| range(2).map(move |k| [i, j, k]))).collect();
        // twice the distance of the middle of the block
        let distance = |offset: &[i32; 3]| (0..axes.len()).map(|a| (2 * offset[a] + width - 1).pow(2)).sum::<i32>();
        offsets.sort_by_key(|offset| (distance(offset), *offset));
        Self { axes: axes.to_vec(), offsets }
    }

    /// The functions that function `node` (by axis) follows, with their weights; `None` where there is no block of stable ones near.
    pub(crate) fn of(&self, node: [i32; 3], is_stable: impl Fn([i32; 3]) -> bool) -> Option<Vec<([i32; 3], f64)>> {
        let width = |a: usize| self.axes.get(a).map_or(1, |axis| axis.width() as i32);
        let block = |first: [i32; 3]| {
            (0..width(0))
                .flat_map(move |i| (0..width(1)).flat_map(move |j| (0..width(2)).map(move |k| [first[0] + i, first[1] + j, first[2] + k])))
        };
        let first = self.offsets.iter().map(|offset| [0, 1, 2].map(|a| node[a] + offset[a])).find(|first| block(*first).all(&is_stable))?;
        let factors: Vec<Vec<f64>> =
            (0..3).map(|a| self.axes.get(a).map_or_else(|| vec![1.0], |axis| axis.extension(node[a], first[a]))).collect();
        let weight = |of: [i32; 3]| (0..3).map(|a| factors[a][(of[a] - first[a]) as usize]).product::<f64>();
        Some(block(first).map(|master| (master, weight(master))).filter(|(_, weight)| *weight != 0.0).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::super::{BATCH, Batch, Family, Places, Stencils, Third};
    use super::*;

    /// With the functions near an end tied to those further in, polynomials are still what they were, at open knots and elsewhere.
    #[test]
    fn polynomials_survive_the_extension() {
        let axis = Axis::new(-0.5, 0.1, 12, Family::OpenSpline(3));
        let n = axis.functions();
        // coefficients of a cubic: interpolated at the Greville points
        let row = |x: f64| {
            let s = Stencils::<4>::at::<1>(
                std::slice::from_ref(&axis),
                &Places { position: [[x; BATCH]], half: [Batch::default()] },
                Third::Nothing,
            );
            (s.first(0)[2], s.weight[2].map(|w| w[0]))
        };
        let cubic = |x: f64| 1.0 + x - 3.0 * x * x + 2.0 * x * x * x;
        let mut matrix = nalgebra::DMatrix::zeros(n as usize, n as usize);
        let right = nalgebra::DVector::from_fn(n as usize, |i, _| cubic(axis.node_position(i as i32)));
        for i in 0..n {
            let (first, weights) = row(axis.node_position(i));
            (0..4).for_each(|k| matrix[(i as usize, first as usize + k)] = weights[k]);
        }
        let coefficients = matrix.lu().solve(&right).unwrap();
        let extension = Extension::new(std::slice::from_ref(&axis));
        for stable in [4..11, 0..4, 9..15] {
            for node in 0..n {
                let Some(masters) = extension.of([node, 0, 0], |m| stable.contains(&m[0])) else { continue };
                let follows: f64 = masters.iter().map(|(master, weight)| weight * coefficients[master[0] as usize]).sum();
                let size: f64 = masters.iter().map(|(_, weight)| weight.abs()).sum();
                // round-off, by the size of the weights
                assert!((follows - coefficients[node as usize]).abs() < 1e-13 * size, "{stable:?} {node}");
                if stable.contains(&node) {
                    continue;
                }
                assert!(masters.len() == 4);
            }
        }
    }

    #[test]
    fn in_the_middle_weights_are_those_of_lagrange() {
        let axis = Axis::new(0.0, 1.0, 30, Family::OpenSpline(2));
        let found = axis.extension(18, 13);
        // Lagrange polynomials through 13, 14, 15 at 18
        for (found, exact) in found.iter().zip([6.0, -15.0, 10.0]) {
            assert!((found - exact).abs() < 1e-11);
        }
    }

    #[test]
    fn a_corner_takes_the_nearest_block() {
        let axes = vec![Axis::new(0.0, 1.0, 12, Family::OpenSpline(1)); 2];
        let extension = Extension::new(&axes);
        let masters = extension.of([5, 5, 0], |m| m[0] >= 6 && m[1] >= 6 && m[2] == 0).unwrap();
        assert_eq!(masters.len(), 4);
        assert!(masters.iter().any(|(m, w)| *m == [6, 6, 0] && (w - 4.0).abs() < 1e-12));
        assert!(extension.of([5, 5, 0], |m| m[0] == 6).is_none());
    }
}
