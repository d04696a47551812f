//! Eight numbers at once: one kernel source, compiled for AVX-512, for AVX2 with FMA, and for any processor.
//!
//! A kernel is generic over [`Wide`] and always inlined into a function with the right `target_feature`. Closures and `array::map` do not
//! inherit these features, so kernels have plain loops only. AVX-512 and AVX2 give the same bytes: the same fused operations in the same order.

/// Numbers in a vector.
pub(super) const LANES: usize = 8;

/// Eight numbers in memory, aligned to a line of the cache.
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(C, align(64))]
pub(super) struct Lane(pub(super) [f64; LANES]);

impl Lane {
    pub(super) const ZERO: Self = Self([0.0; LANES]);
}

/// Instructions that the processor has.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Instructions {
    #[cfg(target_arch = "x86_64")]
    Avx512,
    #[cfg(target_arch = "x86_64")]
    Avx2,
    Portable,
}

impl Instructions {
    /// All that this processor has, the widest first.
    pub(super) fn known() -> Vec<Self> {
        let mut all = Vec::new();
        #[cfg(target_arch = "x86_64")]
        {
            if std::arch::is_x86_feature_detected!("avx512f") {
                all.push(Self::Avx512);
            }
            if std::arch::is_x86_feature_detected!("avx2") && std::arch::is_x86_feature_detected!("fma") {
                all.push(Self::Avx2);
            }
        }
        all.push(Self::Portable);
        all
    }
}

/// Eight numbers in registers. Only for functions that are inlined where the processor is known to have the instructions.
pub(super) trait Wide: Copy {
    fn splat(value: f64) -> Self;
    fn load(from: &Lane) -> Self;
    /// Numbers `at..at + 8`.
    fn load_at(from: &[f64], at: usize) -> Self;
    fn store(self, to: &mut Lane);
    fn store_at(self, to: &mut [f64], at: usize);
    fn add(self, other: Self) -> Self;
    fn sub(self, other: Self) -> Self;
    fn mul(self, other: Self) -> Self;
    fn div(self, other: Self) -> Self;
    fn max(self, other: Self) -> Self;
    fn min(self, other: Self) -> Self;
    /// self * b + c; fused where the processor can.
    fn fma(self, b: Self, c: Self) -> Self;
    /// Whether all are above 0; not so for NaN.
    fn above_zero(self) -> bool;
    /// m and k with self = m 2^k and m between sqrt(1/2) and sqrt(2), for normal numbers above 0.
    fn split(self) -> (Self, Self);

    #[inline(always)]
    fn zero() -> Self {
        Self::splat(0.0)
    }

    /// -self * b + c.
    #[inline(always)]
    fn fnma(self, b: Self, c: Self) -> Self {
        Self::zero().sub(self).fma(b, c)
    }

    #[inline(always)]
    fn abs(self) -> Self {
        self.max(Self::zero().sub(self))
    }

    /// The natural logarithm and the reciprocal of normal numbers above 0, with one division: ln m = 2 artanh s with
    /// s = (m - 1) / (m + 1), at most 0.172, so that 11 terms of the series are exact to round-off.
    #[inline(always)]
    fn ln_and_inverse(self) -> (Self, Self) {
        let one = Self::splat(1.0);
        let (m, k) = self.split();
        let above = m.add(one);
        let both = one.div(self.mul(above));
        let s = m.sub(one).mul(self.mul(both));
        let z = s.mul(s);
        let mut series = Self::splat(2.0 / 21.0);
        for n in [19.0, 17.0, 15.0, 13.0, 11.0, 9.0, 7.0, 5.0, 3.0] {
            series = series.fma(z, Self::splat(2.0 / n));
        }
        // ln 2 in two parts: the first has few enough digits for k times it to be exact
        const HIGH: f64 = f64::from_bits(0x3fe6_2e42_fee0_0000);
        const LOW: f64 = 1.908_214_929_270_587_7e-10;
        let small = s.mul(z).fma(series, k.mul(Self::splat(LOW)));
        (k.fma(Self::splat(HIGH), s.add(s).add(small)), above.mul(both))
    }
}

/// Bits of sqrt(1/2).
const ROOT: i64 = 0x3fe6_a09e_667f_3bcd;
/// Bits of the exponent.
const EXPONENT: i64 = 0xfff0_0000_0000_0000_u64 as i64;
/// Makes exponents positive: 1024, in the place of the exponent.
const SHIFT: i64 = 1 << 62;
/// Bits of 2^52: a number below 2^52 in the last digits.
const MAGIC: i64 = 0x4330_0000_0000_0000;
const MAGIC_AND_SHIFT: f64 = 4_503_599_627_370_496.0 + 1024.0;

/// Any processor: the compiler makes of it what it can.
#[derive(Clone, Copy)]
pub(super) struct Portable([f64; LANES]);

/// Whether a fused operation is one instruction; else it is a slow call.
const FUSED: bool = cfg!(any(target_arch = "aarch64", target_feature = "fma"));

macro_rules! each_lane {
    ($i:ident => $value:expr) => {{
        let mut out = [0.0; LANES];
        for $i in 0..LANES {
            out[$i] = $value;
        }
        Portable(out)
    }};
}

impl Wide for Portable {
    #[inline(always)]
    fn splat(value: f64) -> Self {
        Self([value; LANES])
    }
    #[inline(always)]
    fn load(from: &Lane) -> Self {
        Self(from.0)
    }
    #[inline(always)]
    fn load_at(from: &[f64], at: usize) -> Self {
        let from = &from[at..at + LANES];
        each_lane!(i => from[i])
    }
    #[inline(always)]
    fn store(self, to: &mut Lane) {
        to.0 = self.0;
    }
    #[inline(always)]
    fn store_at(self, to: &mut [f64], at: usize) {
        to[at..at + LANES].copy_from_slice(&self.0);
    }
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        each_lane!(i => self.0[i] + other.0[i])
    }
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        each_lane!(i => self.0[i] - other.0[i])
    }
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        each_lane!(i => self.0[i] * other.0[i])
    }
    #[inline(always)]
    fn div(self, other: Self) -> Self {
        each_lane!(i => self.0[i] / other.0[i])
    }
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        each_lane!(i => if self.0[i] > other.0[i] { self.0[i] } else { other.0[i] })
    }
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        each_lane!(i => if self.0[i] < other.0[i] { self.0[i] } else { other.0[i] })
    }
    #[inline(always)]
    fn fma(self, b: Self, c: Self) -> Self {
        each_lane!(i => if FUSED { self.0[i].mul_add(b.0[i], c.0[i]) } else { self.0[i] * b.0[i] + c.0[i] })
    }
    #[inline(always)]
    fn above_zero(self) -> bool {
        let mut all = true;
        for i in 0..LANES {
            all &= self.0[i] > 0.0;
        }
        all
    }
    #[inline(always)]
    fn split(self) -> (Self, Self) {
        let (mut m, mut k) = ([0.0; LANES], [0.0; LANES]);
        for i in 0..LANES {
            let bits = self.0[i].to_bits() as i64;
            let above = bits.wrapping_sub(ROOT);
            m[i] = f64::from_bits(bits.wrapping_sub(above & EXPONENT) as u64);
            k[i] = f64::from_bits((above.wrapping_add(SHIFT) as u64 >> 52) | MAGIC as u64) - MAGIC_AND_SHIFT;
        }
        (Self(m), Self(k))
    }
}

#[cfg(target_arch = "x86_64")]
pub(super) use x86::{Avx2, Avx512};

#[cfg(target_arch = "x86_64")]
mod x86 {
    use super::{EXPONENT, LANES, Lane, MAGIC, MAGIC_AND_SHIFT, ROOT, SHIFT, Wide};
    use std::arch::x86_64::*;

    /// Eight numbers in one register.
    #[derive(Clone, Copy)]
    pub(in crate::total) struct Avx512(__m512d);

    /// Eight numbers in two registers.
    #[derive(Clone, Copy)]
    pub(in crate::total) struct Avx2([__m256d; 2]);

    // SAFETY of all blocks below: a kernel for these types only runs where the processor was found to have the instructions, and slices are
    // checked before pointers are taken of them.

    macro_rules! avx512 {
        ($($name:ident($($arg:ident),*) = $call:ident;)*) => {$(
            #[inline(always)]
            fn $name(self $(, $arg: Self)*) -> Self {
                // SAFETY: see above
                Self(unsafe { $call(self.0 $(, $arg.0)*) })
            }
        )*};
    }

    impl Wide for Avx512 {
        avx512! {
            add(b) = _mm512_add_pd;
            sub(b) = _mm512_sub_pd;
            mul(b) = _mm512_mul_pd;
            div(b) = _mm512_div_pd;
            max(b) = _mm512_max_pd;
            min(b) = _mm512_min_pd;
            fma(b, c) = _mm512_fmadd_pd;
            fnma(b, c) = _mm512_fnmadd_pd;
        }
        #[inline(always)]
        fn splat(value: f64) -> Self {
            // SAFETY: see above
            Self(unsafe { _mm512_set1_pd(value) })
        }
        #[inline(always)]
        fn load(from: &Lane) -> Self {
            // SAFETY: see above
            Self(unsafe { _mm512_load_pd(from.0.as_ptr()) })
        }
        #[inline(always)]
        fn load_at(from: &[f64], at: usize) -> Self {
            let from = &from[at..at + LANES];
            // SAFETY: see above
            Self(unsafe { _mm512_loadu_pd(from.as_ptr()) })
        }
        #[inline(always)]
        fn store(self, to: &mut Lane) {
            // SAFETY: see above
            unsafe { _mm512_store_pd(to.0.as_mut_ptr(), self.0) }
        }
        #[inline(always)]
        fn store_at(self, to: &mut [f64], at: usize) {
            let to = &mut to[at..at + LANES];
            // SAFETY: see above
            unsafe { _mm512_storeu_pd(to.as_mut_ptr(), self.0) }
        }
        #[inline(always)]
        fn above_zero(self) -> bool {
            // SAFETY: see above
            unsafe { _mm512_cmp_pd_mask::<_CMP_GT_OQ>(self.0, _mm512_setzero_pd()) == 0xff }
        }
        #[inline(always)]
        fn split(self) -> (Self, Self) {
            // SAFETY: see above
            unsafe {
                let bits = _mm512_castpd_si512(self.0);
                let above = _mm512_sub_epi64(bits, _mm512_set1_epi64(ROOT));
                let m = _mm512_sub_epi64(bits, _mm512_and_si512(above, _mm512_set1_epi64(EXPONENT)));
                let k = _mm512_srli_epi64::<52>(_mm512_add_epi64(above, _mm512_set1_epi64(SHIFT)));
                let k = _mm512_castsi512_pd(_mm512_or_si512(k, _mm512_set1_epi64(MAGIC)));
                (Self(_mm512_castsi512_pd(m)), Self(_mm512_sub_pd(k, _mm512_set1_pd(MAGIC_AND_SHIFT))))
            }
        }
    }

    macro_rules! avx2 {
        ($($name:ident($($arg:ident),*) = $call:ident;)*) => {$(
            #[inline(always)]
            fn $name(self $(, $arg: Self)*) -> Self {
                // SAFETY: see above
                Self(unsafe { [$call(self.0[0] $(, $arg.0[0])*), $call(self.0[1] $(, $arg.0[1])*)] })
            }
        )*};
    }

    impl Wide for Avx2 {
        avx2! {
            add(b) = _mm256_add_pd;
            sub(b) = _mm256_sub_pd;
            mul(b) = _mm256_mul_pd;
            div(b) = _mm256_div_pd;
            max(b) = _mm256_max_pd;
            min(b) = _mm256_min_pd;
            fma(b, c) = _mm256_fmadd_pd;
            fnma(b, c) = _mm256_fnmadd_pd;
        }
        #[inline(always)]
        fn splat(value: f64) -> Self {
            // SAFETY: see above
            Self(unsafe { [_mm256_set1_pd(value); 2] })
        }
        #[inline(always)]
        fn load(from: &Lane) -> Self {
            Self::load_at(&from.0, 0)
        }
        #[inline(always)]
        fn load_at(from: &[f64], at: usize) -> Self {
            let from = &from[at..at + LANES];
            // SAFETY: see above
            Self(unsafe { [_mm256_loadu_pd(from.as_ptr()), _mm256_loadu_pd(from.as_ptr().add(4))] })
        }
        #[inline(always)]
        fn store(self, to: &mut Lane) {
            self.store_at(&mut to.0, 0);
        }
        #[inline(always)]
        fn store_at(self, to: &mut [f64], at: usize) {
            let to = &mut to[at..at + LANES];
            // SAFETY: see above
            unsafe {
                _mm256_storeu_pd(to.as_mut_ptr(), self.0[0]);
                _mm256_storeu_pd(to.as_mut_ptr().add(4), self.0[1]);
            }
        }
        #[inline(always)]
        fn above_zero(self) -> bool {
            // SAFETY: see above
            unsafe {
                let zero = _mm256_setzero_pd();
                let above = [_mm256_cmp_pd::<_CMP_GT_OQ>(self.0[0], zero), _mm256_cmp_pd::<_CMP_GT_OQ>(self.0[1], zero)];
                _mm256_movemask_pd(_mm256_and_pd(above[0], above[1])) == 0xf
            }
        }
        #[inline(always)]
        fn split(self) -> (Self, Self) {
            let (mut m, mut k) = (self, self);
            for half in 0..2 {
                // SAFETY: see above
                unsafe {
                    let bits = _mm256_castpd_si256(self.0[half]);
                    let above = _mm256_sub_epi64(bits, _mm256_set1_epi64x(ROOT));
                    m.0[half] = _mm256_castsi256_pd(_mm256_sub_epi64(bits, _mm256_and_si256(above, _mm256_set1_epi64x(EXPONENT))));
                    let high = _mm256_srli_epi64::<52>(_mm256_add_epi64(above, _mm256_set1_epi64x(SHIFT)));
                    let number = _mm256_castsi256_pd(_mm256_or_si256(high, _mm256_set1_epi64x(MAGIC)));
                    k.0[half] = _mm256_sub_pd(number, _mm256_set1_pd(MAGIC_AND_SHIFT));
                }
            }
            (m, k)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[inline(always)]
    fn both<V: Wide>(x: &[Lane], logs: &mut [Lane], inverses: &mut [Lane]) {
        for i in 0..x.len() {
            let (log, inverse) = V::load(&x[i]).ln_and_inverse();
            log.store(&mut logs[i]);
            inverse.store(&mut inverses[i]);
        }
    }

    #[cfg(target_arch = "x86_64")]
    #[target_feature(enable = "avx512f")]
    fn both_avx512(x: &[Lane], logs: &mut [Lane], inverses: &mut [Lane]) {
        both::<Avx512>(x, logs, inverses);
    }

    #[cfg(target_arch = "x86_64")]
    #[target_feature(enable = "avx2,fma")]
    fn both_avx2(x: &[Lane], logs: &mut [Lane], inverses: &mut [Lane]) {
        both::<Avx2>(x, logs, inverses);
    }

    /// Logarithms and reciprocals are right to three units in the last place, near 1 too; AVX2 gives the bytes of AVX-512.
    #[test]
    fn logarithms_are_exact_to_round_off() {
        let mut x: Vec<f64> = (-600..600).map(|i| (f64::from(i) * 0.37).exp()).collect();
        x.extend((-600..600).map(|i| 1.0 + f64::from(i) * 1e-3 / 0.7));
        x.extend((-600..600).map(|i| 1.0 + f64::from(i) * 1e-12));
        let x: Vec<f64> = x.into_iter().filter(|x| *x > 0.0).collect();
        let lanes: Vec<Lane> = x.as_chunks::<LANES>().0.iter().map(|x| Lane(*x)).collect();
        let mut first: Option<(Vec<Lane>, Vec<Lane>)> = None;
        for instructions in Instructions::known() {
            let (mut logs, mut inverses) = (vec![Lane::ZERO; lanes.len()], vec![Lane::ZERO; lanes.len()]);
            match instructions {
                // SAFETY: the processor has the instructions
                #[cfg(target_arch = "x86_64")]
                Instructions::Avx512 => unsafe { both_avx512(&lanes, &mut logs, &mut inverses) },
                // SAFETY: the processor has the instructions
                #[cfg(target_arch = "x86_64")]
                Instructions::Avx2 => unsafe { both_avx2(&lanes, &mut logs, &mut inverses) },
                Instructions::Portable => both::<Portable>(&lanes, &mut logs, &mut inverses),
            }
            for i in 0..lanes.len() {
                for k in 0..LANES {
                    let (x, log, inverse) = (lanes[i].0[k], logs[i].0[k], inverses[i].0[k]);
                    assert!((log - x.ln()).abs() <= 3.0 * f64::EPSILON * x.ln().abs(), "{instructions:?}: ln {x} = {log}");
                    assert!((inverse * x - 1.0).abs() <= 3.0 * f64::EPSILON, "{instructions:?}: 1 / {x} = {inverse}");
                }
            }
            match &first {
                Some(first) if instructions != Instructions::Portable => assert!(*first == (logs, inverses)),
                Some(_) => {}
                None => first = Some((logs, inverses)),
            }
        }
    }
}
