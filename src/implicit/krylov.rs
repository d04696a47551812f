//! Conjugate gradients, for systems too large to be factorised.

use super::newton::dot;

/// A vector for each node.
type Vectors = Vec<[f64; 3]>;

/// Solves A x = b to a relative residual in the norm of the preconditioner. `None` where A shows not to be positive definite, or the residual
/// does not fall.
pub(crate) fn conjugate_gradients(
    mut apply: impl FnMut(&[[f64; 3]]) -> Vectors,
    mut precondition: impl FnMut(&[[f64; 3]]) -> Vectors,
    right: &[[f64; 3]],
    residual: f64,
    most: usize,
) -> Option<Vectors> {
    let mut x = vec![[0.0; 3]; right.len()];
    let mut r = right.to_vec();
    let mut z = precondition(&r);
    let mut p = z.clone();
    let mut rho = dot(&r, &z);
    let goal = residual * residual * rho;
    for _ in 0..most {
        // not `rho <= goal`: NaN is not solved
        if rho.is_nan() || rho < 0.0 {
            return None;
        }
        if rho <= goal {
            return Some(x);
        }
        let image = apply(&p);
        let curvature = dot(&p, &image);
        if curvature.is_nan() || curvature <= 0.0 {
            return None;
        }
        let length = rho / curvature;
        add(&mut x, length, &p);
        add(&mut r, -length, &image);
        z = precondition(&r);
        let next = dot(&r, &z);
        let share = next / rho;
        rho = next;
        for (p, z) in p.iter_mut().zip(&z) {
            *p = std::array::from_fn(|a| z[a] + share * p[a]);
        }
    }
    None
}

fn add(x: &mut [[f64; 3]], share: f64, y: &[[f64; 3]]) {
    for (x, y) in x.iter_mut().zip(y) {
        (0..3).for_each(|a| x[a] += share * y[a]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn solves_what_is_positive_and_refuses_what_is_not() {
        let n = 40;
        let laplace = |sign: f64| {
            move |x: &[[f64; 3]]| -> Vectors {
                let at = |i: isize, a: usize| usize::try_from(i).ok().and_then(|i| x.get(i)).map_or(0.0, |x| x[a]);
                (0..n as isize).map(|i| std::array::from_fn(|a| sign * (2.0 * at(i, a) - at(i - 1, a) - at(i + 1, a)))).collect()
            }
        };
        let exact: Vectors = (0..n).map(|i| std::array::from_fn(|a| ((i * 7 + a) as f64).sin())).collect();
        let right = laplace(1.0)(&exact);
        let identity = |r: &[[f64; 3]]| r.to_vec();
        let x = conjugate_gradients(laplace(1.0), identity, &right, 1e-14, 200).unwrap();
        let error = x.iter().flatten().zip(exact.iter().flatten()).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(error < 1e-10, "{error}");
        assert!(conjugate_gradients(laplace(-1.0), identity, &right, 1e-14, 200).is_none());
        assert!(conjugate_gradients(laplace(1.0), identity, &right, 1e-14, 3).is_none());
    }
}
