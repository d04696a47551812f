//! All instruction sets do the same.

use super::*;

/// Calls `$body` with each type of lanes that this CPU has, compiled for it.
macro_rules! with_each {
    ($body:ident) => {{
        #[cfg(target_arch = "x86_64")]
        {
            #[target_feature(enable = "avx2,fma")]
            fn two() {
                $body::<Avx2>();
            }
            #[target_feature(enable = "avx512f,avx512dq,avx512vl,avx2,fma")]
            fn one() {
                $body::<Avx512>();
            }
            if std::arch::is_x86_feature_detected!("avx2") && std::arch::is_x86_feature_detected!("fma") {
                // SAFETY: the CPU has them.
                unsafe { two() };
            }
            if std::arch::is_x86_feature_detected!("avx512dq") && std::arch::is_x86_feature_detected!("avx512vl") {
                // SAFETY: the CPU has them.
                unsafe { one() };
            }
        }
        $body::<Plain>();
    }};
}

const A: Batch = [1.5, -2.25, 0.1, 3e5, 7.0, -0.0, 1e-3, 12.75];
const B: Batch = [0.5, -2.25, 8.0, -4.0, 7.0, 0.0, 2e-3, 1.1];

fn out<V: Real>(v: V) -> Batch {
    let mut to = [0.0; LANES];
    v.store(&mut to);
    to
}

#[inline(always)]
fn arithmetic<V: Real>() {
    let (a, b) = (V::load(&A), V::load(&B));
    for l in 0..LANES {
        assert_eq!(out(a + b)[l], A[l] + B[l]);
        assert_eq!(out(a - b)[l], A[l] - B[l]);
        assert_eq!(out(a * b)[l], A[l] * B[l]);
        assert_eq!(out(a / V::splat(3.0))[l], A[l] / 3.0);
        assert_eq!(out(-a)[l].to_bits(), (-A[l]).to_bits());
        assert_eq!(out(a.floor())[l], A[l].floor());
        assert_eq!(out(a.max(b))[l], A[l].max(B[l]));
        assert_eq!(out(a.min(b))[l], A[l].min(B[l]));
        assert_eq!(out(a.abs())[l], A[l].abs());
        // once or twice rounded
        assert!((out(a.fma(b, a))[l] - A[l].mul_add(B[l], A[l])).abs() <= 4.0 * f64::EPSILON * A[l].abs() * (1.0 + B[l].abs()));
        assert_eq!(a.at_most(b) >> l & 1 == 1, A[l] <= B[l]);
        assert_eq!(a.below(b) >> l & 1 == 1, A[l] < B[l]);
        assert_eq!(out(a.select(0b1010_0110, b))[l], if 0b1010_0110 >> l & 1 == 1 { A[l] } else { B[l] });
    }
    assert_eq!(V::splat(f64::NAN).at_most(V::splat(f64::NAN)) | V::splat(f64::NAN).below(a) | a.below(V::splat(f64::NAN)), 0);
}

#[inline(always)]
fn halves<V: Real>() {
    let quad = [1.0, 2.0, 3.0, 4.0];
    assert_eq!(out(V::both(&quad)), [1.0, 2.0, 3.0, 4.0, 1.0, 2.0, 3.0, 4.0]);
    assert_eq!(out(V::pair(1.0, 2.0)), [1.0, 1.0, 1.0, 1.0, 2.0, 2.0, 2.0, 2.0]);
    let mut node = B;
    // SAFETY: eight numbers are there.
    unsafe { V::load(&A).add_lower_to(node.as_mut_ptr()) };
    assert_eq!(node, std::array::from_fn(|l| if l < 4 { A[l] + B[l] } else { B[l] }));
    // SAFETY: eight numbers are there.
    unsafe { V::load(&A).add_to(node.as_mut_ptr()) };
    assert_eq!(node, std::array::from_fn(|l| if l < 4 { A[l] + B[l] + A[l] } else { A[l] + B[l] }));
    let mut turned = [[0.0; 4]; LANES];
    let fields = [V::load(&A), V::load(&B), V::splat(5.0), V::load(&A) + V::load(&B)];
    V::turn(fields, &mut turned);
    for l in 0..LANES {
        assert_eq!(turned[V::slot(l)], [A[l], B[l], 5.0, A[l] + B[l]]);
    }
}

#[inline(always)]
fn indices<V: Real>() {
    let mut to = [0; LANES];
    V::load(&[0.0, 1.0, 7.0, 255.0, 65536.0, 1e9, 2.0, 2147483647.0]).store_indices(&mut to);
    assert_eq!(to, [0, 1, 7, 255, 65536, 1_000_000_000, 2, 2_147_483_647]);
}

#[inline(always)]
fn some<V: Real>() {
    for count in 0..=LANES {
        // SAFETY: `count` is at most eight, and eight numbers are there.
        assert_eq!(out(unsafe { V::load_some(A.as_ptr(), count) }), std::array::from_fn(|l| if l < count { A[l] } else { 0.0 }));
        let mut to = B;
        // SAFETY: as above.
        unsafe { V::load(&A).store_some(to.as_mut_ptr(), count) };
        assert_eq!(to, std::array::from_fn(|l| if l < count { A[l] } else { B[l] }));
    }
}

#[inline(always)]
fn logarithms<V: Real>() {
    for k in -4000..4000 {
        let x = 1.01f64.powi(k) * (1.0 + 1e-9 * f64::from(k));
        let (ours, exact) = (out(V::splat(x).ln())[3], x.ln());
        // a few roundings of the result, none of 1
        assert!((ours - exact).abs() <= 4.0 * f64::EPSILON * exact.abs(), "{x}: {ours} {exact}");
    }
    assert_eq!(out(V::splat(1.0).ln())[0], 0.0);
}

#[test]
fn every_instruction_set_computes_the_same() {
    with_each!(arithmetic);
    with_each!(halves);
    with_each!(indices);
    with_each!(some);
    with_each!(logarithms);
}
