//! All instruction sets do the same.

use super::*;

/// Calls `$body` with each of three types of lanes that this CPU has, compiled for it.
macro_rules! with_each {
    ($body:ident) => {
        with_each!($body: Avx2, Avx512, Plain)
    };
    ($body:ident: $two:ident, $one:ident, $plain:ident) => {{
        #[cfg(target_arch = "x86_64")]
        {
            #[target_feature(enable = "avx2,fma")]
            fn two() {
                $body::<$two>();
            }
            #[target_feature(enable = "avx512f,avx512dq,avx512vl,avx2,fma")]
            fn one() {
                $body::<$one>();
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
        $body::<$plain>();
    }};
}

const A: Batch = [1.5, -2.25, 0.1, 3e5, 7.0, -0.0, 1e-3, 12.75];
const B: Batch = [0.5, -2.25, 8.0, -4.0, 7.0, 0.0, 2e-3, 1.1];

fn out<V: Wide>(v: V) -> Batch {
    let mut to = [0.0; LANES];
    v.store_lanes(&mut to);
    to
}

#[inline(always)]
fn arithmetic<V: Wide>() {
    let (a, b) = (V::load_eight(&A), V::load_eight(&B));
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

/// Numbers that 32 bits hold, as those of `V`.
fn numbers<V: Real>(seed: usize) -> Vec<V::Number> {
    (0..V::LANES).map(|l| V::Number::of(((7 * l + 3 * seed) % 23) as f64 - 8.0)).collect()
}

/// All lanes of `V`, in double precision.
fn lanes<V: Real>(v: V) -> Vec<f64> {
    let mut to = vec![V::Number::default(); V::LANES];
    // SAFETY: there is room for all lanes.
    unsafe { v.store(to.as_mut_ptr()) };
    to.into_iter().map(Into::into).collect()
}

#[inline(always)]
fn transfers<V: Real>() {
    let wide = |numbers: &[V::Number]| numbers.iter().map(|&x| x.into()).collect::<Vec<f64>>();
    let (a, b) = (numbers::<V>(1), numbers::<V>(2));
    // SAFETY: there are as many numbers as lanes.
    let (va, vb) = unsafe { (V::load(a.as_ptr()), V::load(b.as_ptr())) };
    let (a, b) = (wide(&a), wide(&b));
    let each = |of: &dyn Fn(usize) -> f64| (0..V::LANES).map(of).collect::<Vec<f64>>();
    // small whole numbers: nothing is rounded
    assert_eq!(lanes(va + vb), each(&|l| a[l] + b[l]));
    assert_eq!(lanes(va - vb), each(&|l| a[l] - b[l]));
    assert_eq!(lanes(va * vb), each(&|l| a[l] * b[l]));
    assert_eq!(lanes(-va), each(&|l| -a[l]));
    assert_eq!(lanes(va.fma(vb, va)), each(&|l| a[l] * b[l] + a[l]));
    assert_eq!(lanes(va.fnma(vb, va)), each(&|l| a[l] - a[l] * b[l]));
    assert_eq!(lanes(V::splat(3.5)), vec![3.5; V::LANES]);
    assert_eq!(lanes(V::all(V::Number::of(-2.0))), vec![-2.0; V::LANES]);
    for count in 0..=V::LANES {
        let two = V::of_cells([2.0, -3.0].map(V::Number::of), V::cells(count));
        assert_eq!(lanes(two), each(&|l| if l < count { 2.0 } else { -3.0 }));
    }
    // eights there and back
    let of_eight = |eight: usize| -> Batch { std::array::from_fn(|l| (10 * eight + l) as f64) };
    let joined = V::join([V::Wide::load_eight(&of_eight(0)), V::Wide::load_eight(&of_eight(1))]);
    assert_eq!(lanes(joined), each(&|l| (10 * (l / LANES) + l % LANES) as f64));
    let mut eight = [V::Number::default(); LANES];
    V::store_eight(V::Wide::load_eight(&A.map(f64::round)), &mut eight);
    assert_eq!(out(V::load_eight(&eight)), A.map(f64::round));
    // nodes
    let quad = |k: usize| -> Quad<V::Number> { std::array::from_fn(|c| V::Number::of((4 * k + c) as f64)) };
    let quads = [quad(0), quad(1), quad(2), quad(3)];
    assert_eq!(lanes(V::at_all(&quads[1])), each(&|l| (4 + l % 4) as f64));
    assert_eq!(lanes(V::at_each([&quads[0]]))[..4], [0.0, 1.0, 2.0, 3.0]);
    assert_eq!(lanes(V::at_each([&quads[1], &quads[0]]))[..8], [4.0, 5.0, 6.0, 7.0, 0.0, 1.0, 2.0, 3.0]);
    let n = [1.0, -2.0, 3.0, 4.0].map(V::Number::of);
    assert_eq!(lanes(V::spread([n[0], n[1]]))[..8], [1.0, 1.0, 1.0, 1.0, -2.0, -2.0, -2.0, -2.0]);
    if V::NODES == 4 {
        assert_eq!(lanes(V::at_each([&quads[0], &quads[1], &quads[2], &quads[3]])), each(&|l| l as f64));
        assert_eq!(lanes(V::at_each([&quads[3], &quads[1], &quads[2]]))[..12], [12, 13, 14, 15, 4, 5, 6, 7, 8, 9, 10, 11].map(f64::from));
        assert_eq!(lanes(V::spread(n)), each(&|l| [1.0, -2.0, 3.0, 4.0][l / 4]));
        assert_eq!(lanes(V::spread([n[0], n[1], n[2]]))[..12], each(&|l| [1.0, -2.0, 3.0, 4.0][l / 4])[..12]);
    }
    for count in 1..=V::NODES {
        let mut nodes = vec![0.5; 4 * V::NODES];
        // SAFETY: there are as many nodes.
        unsafe { va.add_to(nodes.as_mut_ptr(), count) };
        assert_eq!(nodes, each(&|l| if l < 4 * count { 0.5 + a[l] } else { 0.5 }));
    }
    let mut memory = vec![V::Number::default(); 4 * V::LANES];
    // SAFETY: quads of all lanes, and nothing else.
    let turned = unsafe { &mut *memory.as_mut_ptr().cast::<V::Quads>() };
    V::turn([va, vb, V::splat(5.0), va + vb], turned);
    for l in 0..V::LANES {
        assert_eq!(turned.as_ref()[V::slot(l)].map(Into::<f64>::into), [a[l], b[l], 5.0, a[l] + b[l]]);
    }
}

#[inline(always)]
fn indices<V: Wide>() {
    let mut to = [0; LANES];
    V::load_eight(&[0.0, 1.0, 7.0, 255.0, 65536.0, 1e9, 2.0, 2147483647.0]).store_indices(&mut to);
    assert_eq!(to, [0, 1, 7, 255, 65536, 1_000_000_000, 2, 2_147_483_647]);
}

#[inline(always)]
fn some<V: Wide>() {
    for count in 0..=LANES {
        // SAFETY: `count` is at most eight, and eight numbers are there.
        assert_eq!(out(unsafe { V::load_some(A.as_ptr(), count) }), std::array::from_fn(|l| if l < count { A[l] } else { 0.0 }));
        let mut to = B;
        // SAFETY: as above.
        unsafe { V::load_eight(&A).store_some(to.as_mut_ptr(), count) };
        assert_eq!(to, std::array::from_fn(|l| if l < count { A[l] } else { B[l] }));
    }
}

#[inline(always)]
fn logarithms<V: Wide>() {
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
    with_each!(transfers);
    with_each!(transfers: Avx2Single, Avx512Single, PlainSingle);
    with_each!(indices);
    with_each!(some);
    with_each!(logarithms);
}
