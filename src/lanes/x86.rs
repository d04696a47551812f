//! Eight numbers in one AVX-512 register, or in two AVX registers.
//!
//! Only kernels compiled for these instructions use the types below, and those run only on CPUs that have them: that makes every intrinsic
//! here safe to call.

use super::{Apart, Batch, LANES, Mask, Quad, Real, Wide};
use std::arch::x86_64::*;
use std::ops::{Add, Div, Mul, Neg, Sub};

/// Eight numbers in one register; for AVX-512 F, DQ and VL.
#[derive(Clone, Copy)]
pub(crate) struct Avx512(pub(super) __m512d);

/// Eight numbers in two registers; for AVX2 and FMA.
#[derive(Clone, Copy)]
pub(crate) struct Avx2(pub(super) __m256d, pub(super) __m256d);

operators!(Avx512 (0): Neg _mm512_xor_pd _mm512_set1_pd;
    Add add _mm512_add_pd Sub sub _mm512_sub_pd Mul mul _mm512_mul_pd Div div _mm512_div_pd);
operators!(Avx2 (0 1): Neg _mm256_xor_pd _mm256_set1_pd;
    Add add _mm256_add_pd Sub sub _mm256_sub_pd Mul mul _mm256_mul_pd Div div _mm256_div_pd);

/// The mask of the first `count` lanes.
#[inline(always)]
fn first(count: usize) -> Mask {
    ((1u32 << count) - 1) as Mask
}

// SAFETY of every block below: see the top of the file; pointers are good by the promise of the caller or come from references.
impl Real for Avx512 {
    type Number = f64;
    type Wide = Self;
    type Lanes = Batch;
    type Quads = [Quad; LANES];
    type Cells = Mask;
    const EIGHTS: usize = 1;
    #[inline(always)]
    fn cells(count: usize) -> Mask {
        first(count)
    }
    #[inline(always)]
    fn of_cells([a, b]: [f64; 2], cells: Mask) -> Self {
        // SAFETY: as above.
        Self(unsafe { _mm512_mask_blend_pd(cells, _mm512_set1_pd(b), _mm512_set1_pd(a)) })
    }
    one_register!(f64: _mm512_set1_pd _mm512_loadu_pd _mm512_storeu_pd _mm512_fmadd_pd _mm512_fnmadd_pd
        _mm512_max_pd _mm512_min_pd);
    one_eight!();
    lanes_of!("avx512f,avx512dq,avx512vl,avx2,fma");
    #[inline(always)]
    fn at_all(quad: &Quad) -> Self {
        // SAFETY: as above.
        Self(unsafe { _mm512_broadcast_f64x4(_mm256_loadu_pd(quad.as_ptr())) })
    }
    #[inline(always)]
    fn at_each<const N: usize>(quads: [&Quad; N]) -> Self {
        if N == 1 {
            return Self::at_all(quads[0]);
        }
        // SAFETY: as above.
        unsafe {
            let low = _mm512_castpd256_pd512(_mm256_loadu_pd(quads[0].as_ptr()));
            Self(_mm512_insertf64x4::<1>(low, _mm256_loadu_pd(quads[1].as_ptr())))
        }
    }
    #[inline(always)]
    fn spread<const N: usize>(numbers: [f64; N]) -> Self {
        if N == 1 {
            return Self::splat(numbers[0]);
        }
        // SAFETY: as above.
        Self(unsafe { _mm512_mask_blend_pd(0xf0, _mm512_set1_pd(numbers[0]), _mm512_set1_pd(numbers[1])) })
    }
    #[inline(always)]
    unsafe fn add_to(self, to: *mut f64, count: usize) {
        // SAFETY: as above.
        unsafe {
            if count == 1 {
                _mm256_storeu_pd(to, _mm256_add_pd(_mm256_loadu_pd(to), _mm512_castpd512_pd256(self.0)));
            } else {
                _mm512_storeu_pd(to, _mm512_add_pd(_mm512_loadu_pd(to), self.0));
            }
        }
    }
    #[inline(always)]
    fn turn([a, b, c, d]: [Self; 4], to: &mut [Quad; LANES]) {
        // SAFETY: as above.
        unsafe {
            let (even_ab, odd_ab) = (_mm512_unpacklo_pd(a.0, b.0), _mm512_unpackhi_pd(a.0, b.0));
            let (even_cd, odd_cd) = (_mm512_unpacklo_pd(c.0, d.0), _mm512_unpackhi_pd(c.0, d.0));
            // lanes 0 and 2, lanes 4 and 6 of the even ones; of the odd ones lanes 1 and 3, 5 and 7
            let low = _mm512_setr_epi64(0, 1, 8, 9, 2, 3, 10, 11);
            let high = _mm512_setr_epi64(4, 5, 12, 13, 6, 7, 14, 15);
            let to = to.as_mut_ptr().cast::<f64>();
            _mm512_storeu_pd(to, _mm512_permutex2var_pd(even_ab, low, even_cd));
            _mm512_storeu_pd(to.add(8), _mm512_permutex2var_pd(even_ab, high, even_cd));
            _mm512_storeu_pd(to.add(16), _mm512_permutex2var_pd(odd_ab, low, odd_cd));
            _mm512_storeu_pd(to.add(24), _mm512_permutex2var_pd(odd_ab, high, odd_cd));
        }
    }
    #[inline(always)]
    fn slot(lane: usize) -> usize {
        (lane & 1) * 4 + (lane >> 1)
    }
}

impl Wide for Avx512 {
    #[inline(always)]
    fn first(self) -> f64 {
        // SAFETY: as above.
        unsafe { _mm512_cvtsd_f64(self.0) }
    }
    #[inline(always)]
    unsafe fn load_some(from: *const f64, count: usize) -> Self {
        // SAFETY: as above; lanes that are masked out are not touched.
        Self(unsafe { _mm512_maskz_loadu_pd(first(count), from) })
    }
    #[inline(always)]
    unsafe fn store_some(self, to: *mut f64, count: usize) {
        // SAFETY: as above; lanes that are masked out are not touched.
        unsafe { _mm512_mask_storeu_pd(to, first(count), self.0) }
    }
    #[inline(always)]
    fn floor(self) -> Self {
        // SAFETY: as above.
        Self(unsafe { _mm512_roundscale_pd::<{ _MM_FROUND_TO_NEG_INF | _MM_FROUND_NO_EXC }>(self.0) })
    }
    #[inline(always)]
    fn abs(self) -> Self {
        // SAFETY: as above.
        Self(unsafe { _mm512_abs_pd(self.0) })
    }
    #[inline(always)]
    fn at_most(self, other: Self) -> Mask {
        // SAFETY: as above.
        unsafe { _mm512_cmp_pd_mask::<_CMP_LE_OQ>(self.0, other.0) }
    }
    #[inline(always)]
    fn below(self, other: Self) -> Mask {
        // SAFETY: as above.
        unsafe { _mm512_cmp_pd_mask::<_CMP_LT_OQ>(self.0, other.0) }
    }
    #[inline(always)]
    fn select(self, mask: Mask, other: Self) -> Self {
        // SAFETY: as above.
        Self(unsafe { _mm512_mask_blend_pd(mask, other.0, self.0) })
    }
    #[inline(always)]
    fn store_indices(self, to: &mut [u32; LANES]) {
        // SAFETY: as above.
        unsafe { _mm256_storeu_si256(to.as_mut_ptr().cast(), _mm512_cvttpd_epi32(self.0)) }
    }
    #[inline(always)]
    fn split(self) -> (Self, Self) {
        // SAFETY: as above.
        unsafe {
            let one = _mm512_set1_pd(1.0);
            let mantissa = _mm512_getmant_pd::<_MM_MANT_NORM_P75_1P5, _MM_MANT_SIGN_SRC>(self.0);
            let halved = _mm512_cmp_pd_mask::<_CMP_LT_OQ>(mantissa, one);
            let exponent = _mm512_getexp_pd(self.0);
            (Self(mantissa), Self(_mm512_mask_add_pd(exponent, halved, exponent, one)))
        }
    }
}

/// The lanes of a mask, as AVX knows them.
#[inline(always)]
fn spread(mask: Mask) -> [__m256d; 2] {
    // SAFETY: see the top of the file.
    unsafe {
        let bits = _mm256_set1_epi64x(i64::from(mask));
        let low = _mm256_setr_epi64x(1, 2, 4, 8);
        let high = _mm256_setr_epi64x(16, 32, 64, 128);
        [
            _mm256_castsi256_pd(_mm256_cmpeq_epi64(_mm256_and_si256(bits, low), low)),
            _mm256_castsi256_pd(_mm256_cmpeq_epi64(_mm256_and_si256(bits, high), high)),
        ]
    }
}

impl Real for Avx2 {
    type Number = f64;
    type Wide = Self;
    type Lanes = Batch;
    type Quads = [Quad; LANES];
    type Cells = [__m256d; 2];
    const EIGHTS: usize = 1;
    #[inline(always)]
    fn cells(count: usize) -> [__m256d; 2] {
        spread(first(count))
    }
    #[inline(always)]
    fn of_cells([a, b]: [f64; 2], [low, high]: [__m256d; 2]) -> Self {
        // SAFETY: as above.
        unsafe {
            let (a, b) = (_mm256_set1_pd(a), _mm256_set1_pd(b));
            Self(_mm256_blendv_pd(b, a, low), _mm256_blendv_pd(b, a, high))
        }
    }
    one_eight!();
    lanes_of!("avx2,fma");
    #[inline(always)]
    fn splat(x: f64) -> Self {
        // SAFETY: as above.
        unsafe { Self(_mm256_set1_pd(x), _mm256_set1_pd(x)) }
    }
    #[inline(always)]
    fn all(x: f64) -> Self {
        Self::splat(x)
    }
    #[inline(always)]
    unsafe fn load(from: *const f64) -> Self {
        // SAFETY: as above.
        unsafe { Self(_mm256_loadu_pd(from), _mm256_loadu_pd(from.add(4))) }
    }
    #[inline(always)]
    unsafe fn store(self, to: *mut f64) {
        // SAFETY: as above.
        unsafe {
            _mm256_storeu_pd(to, self.0);
            _mm256_storeu_pd(to.add(4), self.1);
        }
    }
    #[inline(always)]
    fn fma(self, b: Self, c: Self) -> Self {
        // SAFETY: as above.
        unsafe { Self(_mm256_fmadd_pd(self.0, b.0, c.0), _mm256_fmadd_pd(self.1, b.1, c.1)) }
    }
    #[inline(always)]
    fn fnma(self, b: Self, c: Self) -> Self {
        // SAFETY: as above.
        unsafe { Self(_mm256_fnmadd_pd(self.0, b.0, c.0), _mm256_fnmadd_pd(self.1, b.1, c.1)) }
    }
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        // SAFETY: as above.
        unsafe { Self(_mm256_min_pd(self.0, other.0), _mm256_min_pd(self.1, other.1)) }
    }
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        // SAFETY: as above.
        unsafe { Self(_mm256_max_pd(self.0, other.0), _mm256_max_pd(self.1, other.1)) }
    }
    #[inline(always)]
    fn at_all(quad: &Quad) -> Self {
        // SAFETY: as above.
        let quad = unsafe { _mm256_loadu_pd(quad.as_ptr()) };
        Self(quad, quad)
    }
    #[inline(always)]
    fn at_each<const N: usize>(quads: [&Quad; N]) -> Self {
        // SAFETY: as above.
        unsafe { Self(_mm256_loadu_pd(quads[0].as_ptr()), _mm256_loadu_pd(quads[N - 1].as_ptr())) }
    }
    #[inline(always)]
    fn spread<const N: usize>(numbers: [f64; N]) -> Self {
        // SAFETY: as above.
        unsafe { Self(_mm256_set1_pd(numbers[0]), _mm256_set1_pd(numbers[N - 1])) }
    }
    #[inline(always)]
    unsafe fn add_to(self, to: *mut f64, count: usize) {
        // SAFETY: as above.
        unsafe {
            _mm256_storeu_pd(to, _mm256_add_pd(_mm256_loadu_pd(to), self.0));
            if count > 1 {
                let to = to.add(4);
                _mm256_storeu_pd(to, _mm256_add_pd(_mm256_loadu_pd(to), self.1));
            }
        }
    }
    #[inline(always)]
    fn turn([a, b, c, d]: [Self; 4], to: &mut [Quad; LANES]) {
        // SAFETY: as above.
        unsafe {
            for (start, a, b, c, d) in [(0, a.0, b.0, c.0, d.0), (4, a.1, b.1, c.1, d.1)] {
                let (even_ab, odd_ab) = (_mm256_unpacklo_pd(a, b), _mm256_unpackhi_pd(a, b));
                let (even_cd, odd_cd) = (_mm256_unpacklo_pd(c, d), _mm256_unpackhi_pd(c, d));
                _mm256_storeu_pd(to[start].as_mut_ptr(), _mm256_permute2f128_pd::<0x20>(even_ab, even_cd));
                _mm256_storeu_pd(to[start + 1].as_mut_ptr(), _mm256_permute2f128_pd::<0x20>(odd_ab, odd_cd));
                _mm256_storeu_pd(to[start + 2].as_mut_ptr(), _mm256_permute2f128_pd::<0x31>(even_ab, even_cd));
                _mm256_storeu_pd(to[start + 3].as_mut_ptr(), _mm256_permute2f128_pd::<0x31>(odd_ab, odd_cd));
            }
        }
    }
    #[inline(always)]
    fn slot(lane: usize) -> usize {
        lane
    }
}

impl Wide for Avx2 {
    #[inline(always)]
    fn first(self) -> f64 {
        // SAFETY: as above.
        unsafe { _mm256_cvtsd_f64(self.0) }
    }
    #[inline(always)]
    unsafe fn load_some(from: *const f64, count: usize) -> Self {
        let [low, high] = spread(first(count));
        // SAFETY: as above; lanes that are masked out are not touched.
        unsafe {
            Self(_mm256_maskload_pd(from, _mm256_castpd_si256(low)), _mm256_maskload_pd(from.wrapping_add(4), _mm256_castpd_si256(high)))
        }
    }
    #[inline(always)]
    unsafe fn store_some(self, to: *mut f64, count: usize) {
        let [low, high] = spread(first(count));
        // SAFETY: as above; lanes that are masked out are not touched.
        unsafe {
            _mm256_maskstore_pd(to, _mm256_castpd_si256(low), self.0);
            _mm256_maskstore_pd(to.wrapping_add(4), _mm256_castpd_si256(high), self.1);
        }
    }
    #[inline(always)]
    fn floor(self) -> Self {
        // SAFETY: as above.
        unsafe { Self(_mm256_floor_pd(self.0), _mm256_floor_pd(self.1)) }
    }
    #[inline(always)]
    fn abs(self) -> Self {
        // SAFETY: as above.
        unsafe {
            let sign = _mm256_set1_pd(-0.0);
            Self(_mm256_andnot_pd(sign, self.0), _mm256_andnot_pd(sign, self.1))
        }
    }
    #[inline(always)]
    fn at_most(self, other: Self) -> Mask {
        // SAFETY: as above.
        unsafe {
            let low = _mm256_movemask_pd(_mm256_cmp_pd::<_CMP_LE_OQ>(self.0, other.0));
            let high = _mm256_movemask_pd(_mm256_cmp_pd::<_CMP_LE_OQ>(self.1, other.1));
            (low | high << 4) as Mask
        }
    }
    #[inline(always)]
    fn below(self, other: Self) -> Mask {
        // SAFETY: as above.
        unsafe {
            let low = _mm256_movemask_pd(_mm256_cmp_pd::<_CMP_LT_OQ>(self.0, other.0));
            let high = _mm256_movemask_pd(_mm256_cmp_pd::<_CMP_LT_OQ>(self.1, other.1));
            (low | high << 4) as Mask
        }
    }
    #[inline(always)]
    fn select(self, mask: Mask, other: Self) -> Self {
        let [low, high] = spread(mask);
        // SAFETY: as above.
        unsafe { Self(_mm256_blendv_pd(other.0, self.0, low), _mm256_blendv_pd(other.1, self.1, high)) }
    }
    #[inline(always)]
    fn store_indices(self, to: &mut [u32; LANES]) {
        // SAFETY: as above.
        unsafe {
            _mm_storeu_si128(to.as_mut_ptr().cast(), _mm256_cvttpd_epi32(self.0));
            _mm_storeu_si128(to.as_mut_ptr().add(4).cast(), _mm256_cvttpd_epi32(self.1));
        }
    }
    #[inline(always)]
    fn split(self) -> (Self, Self) {
        let (low, high) = (split_four(self.0), split_four(self.1));
        (Self(low.0, high.0), Self(low.1, high.1))
    }
}

/// [`Wide::split`] of four numbers.
#[inline(always)]
fn split_four(x: __m256d) -> (__m256d, __m256d) {
    // SAFETY: see the top of the file.
    unsafe {
        let bits = _mm256_castpd_si256(x);
        let fraction = _mm256_and_si256(bits, _mm256_set1_epi64x((1 << 52) - 1));
        let m = _mm256_castsi256_pd(_mm256_or_si256(fraction, _mm256_set1_epi64x(1023 << 52)));
        let halved = _mm256_cmp_pd::<_CMP_GE_OQ>(m, _mm256_set1_pd(1.5));
        let mantissa = _mm256_blendv_pd(m, _mm256_mul_pd(m, _mm256_set1_pd(0.5)), halved);
        // the exponent, one more where the mantissa was halved, as the last bits of 2^52 + it
        let whole = _mm256_srli_epi64::<52>(_mm256_add_epi64(bits, _mm256_set1_epi64x(1 << 51)));
        let magic = _mm256_set1_pd((1u64 << 52) as f64);
        let exponent = _mm256_castsi256_pd(_mm256_or_si256(whole, _mm256_castpd_si256(magic)));
        (mantissa, _mm256_sub_pd(exponent, _mm256_set1_pd((1u64 << 52) as f64 + 1023.0)))
    }
}
