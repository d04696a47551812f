//! Quadratic Lagrange functions (Tielen 2016, section 5.2; Andersen 2007, section 3.4): elements of three nodes an axis, each over two
//! cells, so that nodes are one cell apart as with other families. Tensor products are the 9-node and 27-node elements; the serendipity
//! elements come from them by tying their inner nodes ([`serendipity_weight`]).

use super::axis::Pieces;

/// The lower and the upper half of an element: polynomials of the local coordinate x of a cell, with xi = x - 1 or x.
pub(super) fn pieces() -> Pieces {
    // xi (xi - 1) / 2, 1 - xi^2, xi (xi + 1) / 2
    let coefficients = vec![
        1.0, 0.0, 0.0, -1.5, 2.0, -0.5, 0.5, -1.0, 0.5, // xi = x - 1: powers 0, 1, 2
        0.0, 1.0, 0.0, -0.5, 0.0, 0.5, 0.5, -1.0, 0.5, // xi = x
    ];
    Pieces { coefficients, places: vec![0.0, 1.0, 2.0, -1.0, 0.0, 1.0] }
}

/// Whether a serendipity element lacks the node with these indices, of which the last `dimension` count.
pub(crate) fn is_tied(dimension: usize, node: [i32; 3]) -> bool {
    odd(dimension, node) > 1
}

fn odd(dimension: usize, node: [i32; 3]) -> usize {
    node[3 - dimension..].iter().filter(|i| *i & 1 == 1).count()
}

/// What a node that a serendipity element lacks takes of another node of the element: N8 = N9 + N8(centre) N9_centre, where N8 at the centre
/// of a face is -1/4 at its corners and 1/2 at its edges, at the centre of a brick -1/4 at its corners and 1/4 at its edges.
pub(crate) fn serendipity_weight(dimension: usize, tied: [i32; 3], master: [i32; 3]) -> f64 {
    let (inner, of_master) = (odd(dimension, tied), odd(dimension, master));
    let slots = 3 - dimension..3;
    // a node on the face or edge that the tied node is the centre of
    let near = slots.into_iter().all(|s| if tied[s] & 1 == 1 { (tied[s] - master[s]).abs() <= 1 } else { tied[s] == master[s] });
    match (near, inner, of_master) {
        (true, 2 | 3, 0) => -0.25,
        (true, 2, 1) => 0.5,
        (true, 3, 1) => 0.25,
        _ => 0.0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// N of the 8-node and 20-node elements (Andersen 2007, section 3.4, and its textbook extension) at xi for a node in -1, 0, 1.
    fn textbook(dimension: usize, xi: &[f64], node: &[i32]) -> f64 {
        let n: Vec<f64> = node.iter().map(|&i| f64::from(i)).collect();
        let mid = node.iter().position(|i| *i == 0);
        let linear = |skip: Option<usize>| -> f64 { (0..dimension).filter(|a| Some(*a) != skip).map(|a| 1.0 + xi[a] * n[a]).product() };
        let half = 0.5f64.powi(dimension as i32);
        match mid {
            Some(a) => 2.0 * half * (1.0 - xi[a] * xi[a]) * linear(Some(a)),
            None => half * linear(None) * ((0..dimension).map(|a| xi[a] * n[a]).sum::<f64>() - dimension as f64 + 1.0),
        }
    }

    fn quadratic(xi: f64, node: i32) -> f64 {
        match node {
            -1 => 0.5 * xi * (xi - 1.0),
            0 => 1.0 - xi * xi,
            _ => 0.5 * xi * (xi + 1.0),
        }
    }

    #[test]
    fn tied_nine_and_twenty_seven_node_elements_are_the_textbook_serendipity_ones() {
        for dimension in [2, 3] {
            let all: Vec<[i32; 3]> = (0..3i32.pow(dimension as u32))
                .map(|k| std::array::from_fn(|s| if s < 3 - dimension { 0 } else { k / 3i32.pow(2 - s as u32) % 3 }))
                .collect();
            let xi = [0.3, -0.7, 0.45];
            let lagrange = |node: &[i32; 3]| -> f64 { (3 - dimension..3).map(|s| quadratic(xi[s], node[s] - 1)).product() };
            let mut sum = 0.0;
            for node in all.iter().filter(|n| !is_tied(dimension, **n)) {
                let ours: f64 = lagrange(node)
                    + all
                        .iter()
                        .filter(|t| is_tied(dimension, **t))
                        .map(|t| serendipity_weight(dimension, *t, *node) * lagrange(t))
                        .sum::<f64>();
                let shifted: Vec<i32> = node[3 - dimension..].iter().map(|i| i - 1).collect();
                // round-off of some ten terms
                assert!((ours - textbook(dimension, &xi[3 - dimension..], &shifted)).abs() < 1e-14, "{node:?}");
                sum += ours;
            }
            assert!((sum - 1.0).abs() < 1e-14);
        }
    }
}
