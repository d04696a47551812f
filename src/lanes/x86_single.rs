//! Single precision: sixteen numbers in one AVX-512 register, or eight in one AVX register.
//!
//! As in `x86`, only kernels compiled for these instructions use the types below.

use super::{Apart, Avx2, Avx512, Batch, LANES, MOST_LANES, Quad, Real};
use std::arch::x86_64::*;
use std::ops::{Add, Div, Mul, Neg, Sub};

/// Sixteen numbers in one register; for AVX-512 F, DQ and VL.
#[derive(Clone, Copy)]
pub(crate) struct Avx512Single(__m512);

/// Eight numbers in one register; for AVX2 and FMA.
#[derive(Clone, Copy)]
pub(crate) struct Avx2Single(__m256);

operators!(Avx512Single (0): Neg _mm512_xor_ps _mm512_set1_ps;
    Add add _mm512_add_ps Sub sub _mm512_sub_ps Mul mul _mm512_mul_ps Div div _mm512_div_ps);
operators!(Avx2Single (0): Neg _mm256_xor_ps _mm256_set1_ps;
    Add add _mm256_add_ps Sub sub _mm256_sub_ps Mul mul _mm256_mul_ps Div div _mm256_div_ps);

// SAFETY of every block below: see the top of the file; pointers are good by the promise of the caller or come from references.
impl Real for Avx512Single {
    type Number = f32;
    type Wide = Avx512;
    type Lanes = [f32; MOST_LANES];
    type Quads = [Quad<f32>; MOST_LANES];
    type Cells = u16;
    const EIGHTS: usize = 2;
    #[inline(always)]
    fn cells(count: usize) -> u16 {
        ((1u32 << count) - 1) as u16
    }
    #[inline(always)]
    fn of_cells([a, b]: [f32; 2], cells: u16) -> Self {
        // SAFETY: as above.
        Self(unsafe { _mm512_mask_blend_ps(cells, _mm512_set1_ps(b), _mm512_set1_ps(a)) })
    }
    one_register!(f32: _mm512_set1_ps _mm512_loadu_ps _mm512_storeu_ps _mm512_fmadd_ps _mm512_fnmadd_ps
        _mm512_max_ps _mm512_min_ps);
    lanes_of!("avx512f,avx512dq,avx512vl,avx2,fma");
    #[inline(always)]
    fn join([a, b]: [Avx512; 2]) -> Self {
        // SAFETY: as above.
        Self(unsafe { _mm512_insertf32x8::<1>(_mm512_castps256_ps512(_mm512_cvtpd_ps(a.0)), _mm512_cvtpd_ps(b.0)) })
    }
    #[inline(always)]
    fn load_eight(from: &Batch<f32>) -> Avx512 {
        // SAFETY: as above.
        Avx512(unsafe { _mm512_cvtps_pd(_mm256_loadu_ps(from.as_ptr())) })
    }
    #[inline(always)]
    fn store_eight(eight: Avx512, to: &mut Batch<f32>) {
        // SAFETY: as above.
        unsafe { _mm256_storeu_ps(to.as_mut_ptr(), _mm512_cvtpd_ps(eight.0)) }
    }
    #[inline(always)]
    fn at_all(quad: &Quad<f32>) -> Self {
        // SAFETY: as above.
        Self(unsafe { _mm512_broadcast_f32x4(_mm_loadu_ps(quad.as_ptr())) })
    }
    #[inline(always)]
    fn at_each<const N: usize>(quads: [&Quad<f32>; N]) -> Self {
        // SAFETY: as above.
        unsafe {
            let mut row = _mm512_castps128_ps512(_mm_loadu_ps(quads[0].as_ptr()));
            if N > 1 {
                row = _mm512_insertf32x4::<1>(row, _mm_loadu_ps(quads[1].as_ptr()));
            }
            if N > 2 {
                row = _mm512_insertf32x4::<2>(row, _mm_loadu_ps(quads[2].as_ptr()));
            }
            if N > 3 {
                row = _mm512_insertf32x4::<3>(row, _mm_loadu_ps(quads[3].as_ptr()));
            }
            Self(row)
        }
    }
    #[inline(always)]
    fn spread<const N: usize>(numbers: [f32; N]) -> Self {
        // SAFETY: as above.
        unsafe {
            let mut row = _mm512_set1_ps(numbers[0]);
            if N > 1 {
                row = _mm512_mask_blend_ps(0x00f0, row, _mm512_set1_ps(numbers[1]));
            }
            if N > 2 {
                row = _mm512_mask_blend_ps(0x0f00, row, _mm512_set1_ps(numbers[2]));
            }
            if N > 3 {
                row = _mm512_mask_blend_ps(0xf000, row, _mm512_set1_ps(numbers[3]));
            }
            Self(row)
        }
    }
    #[inline(always)]
    unsafe fn add_to(self, to: *mut f64, count: usize) {
        // SAFETY: as above.
        unsafe {
            let low = _mm512_cvtps_pd(_mm512_castps512_ps256(self.0));
            Avx512(low).add_to(to, count.min(2));
            if count > 2 {
                let high = _mm512_cvtps_pd(_mm512_extractf32x8_ps::<1>(self.0));
                Avx512(high).add_to(to.add(8), count - 2);
            }
        }
    }
    #[inline(always)]
    fn turn([a, b, c, d]: [Self; 4], to: &mut Self::Quads) {
        // SAFETY: as above.
        unsafe {
            let (low_ab, high_ab) = (_mm512_unpacklo_ps(a.0, b.0), _mm512_unpackhi_ps(a.0, b.0));
            let (low_cd, high_cd) = (_mm512_unpacklo_ps(c.0, d.0), _mm512_unpackhi_ps(c.0, d.0));
            let (low_ab, high_ab) = (_mm512_castps_pd(low_ab), _mm512_castps_pd(high_ab));
            let (low_cd, high_cd) = (_mm512_castps_pd(low_cd), _mm512_castps_pd(high_cd));
            let to = to.as_mut_ptr().cast::<f64>();
            // lanes 0, 4, 8, 12, then 1, 5, 9, 13, and so on
            _mm512_storeu_pd(to, _mm512_unpacklo_pd(low_ab, low_cd));
            _mm512_storeu_pd(to.add(8), _mm512_unpackhi_pd(low_ab, low_cd));
            _mm512_storeu_pd(to.add(16), _mm512_unpacklo_pd(high_ab, high_cd));
            _mm512_storeu_pd(to.add(24), _mm512_unpackhi_pd(high_ab, high_cd));
        }
    }
    #[inline(always)]
    fn slot(lane: usize) -> usize {
        (lane & 3) * 4 + (lane >> 2)
    }
}

impl Real for Avx2Single {
    type Number = f32;
    type Wide = Avx2;
    type Lanes = Batch<f32>;
    type Quads = [Quad<f32>; LANES];
    type Cells = __m256;
    const EIGHTS: usize = 1;
    #[inline(always)]
    fn cells(count: usize) -> __m256 {
        // SAFETY: as above.
        unsafe {
            let lanes = _mm256_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7);
            _mm256_castsi256_ps(_mm256_cmpgt_epi32(_mm256_set1_epi32(count as i32), lanes))
        }
    }
    #[inline(always)]
    fn of_cells([a, b]: [f32; 2], cells: __m256) -> Self {
        // SAFETY: as above.
        Self(unsafe { _mm256_blendv_ps(_mm256_set1_ps(b), _mm256_set1_ps(a), cells) })
    }
    one_register!(f32: _mm256_set1_ps _mm256_loadu_ps _mm256_storeu_ps _mm256_fmadd_ps _mm256_fnmadd_ps
        _mm256_max_ps _mm256_min_ps);
    lanes_of!("avx2,fma");
    #[inline(always)]
    fn join([eight, _]: [Avx2; 2]) -> Self {
        // SAFETY: as above.
        Self(unsafe { _mm256_set_m128(_mm256_cvtpd_ps(eight.1), _mm256_cvtpd_ps(eight.0)) })
    }
    #[inline(always)]
    fn load_eight(from: &Batch<f32>) -> Avx2 {
        // SAFETY: as above.
        unsafe { Avx2(_mm256_cvtps_pd(_mm_loadu_ps(from.as_ptr())), _mm256_cvtps_pd(_mm_loadu_ps(from.as_ptr().add(4)))) }
    }
    #[inline(always)]
    fn store_eight(eight: Avx2, to: &mut Batch<f32>) {
        Self::join([eight, eight]).store_lanes(to);
    }
    #[inline(always)]
    fn at_all(quad: &Quad<f32>) -> Self {
        // SAFETY: as above.
        unsafe {
            let quad = _mm_loadu_ps(quad.as_ptr());
            Self(_mm256_set_m128(quad, quad))
        }
    }
    #[inline(always)]
    fn at_each<const N: usize>(quads: [&Quad<f32>; N]) -> Self {
        // SAFETY: as above.
        unsafe { Self(_mm256_set_m128(_mm_loadu_ps(quads[N - 1].as_ptr()), _mm_loadu_ps(quads[0].as_ptr()))) }
    }
    #[inline(always)]
    fn spread<const N: usize>(numbers: [f32; N]) -> Self {
        // SAFETY: as above.
        unsafe { Self(_mm256_blend_ps::<0xf0>(_mm256_set1_ps(numbers[0]), _mm256_set1_ps(numbers[N - 1]))) }
    }
    #[inline(always)]
    unsafe fn add_to(self, to: *mut f64, count: usize) {
        // SAFETY: as above.
        unsafe {
            let low = _mm256_cvtps_pd(_mm256_castps256_ps128(self.0));
            _mm256_storeu_pd(to, _mm256_add_pd(_mm256_loadu_pd(to), low));
            if count > 1 {
                let (to, high) = (to.add(4), _mm256_cvtps_pd(_mm256_extractf128_ps::<1>(self.0)));
                _mm256_storeu_pd(to, _mm256_add_pd(_mm256_loadu_pd(to), high));
            }
        }
    }
    #[inline(always)]
    fn turn([a, b, c, d]: [Self; 4], to: &mut Self::Quads) {
        // SAFETY: as above.
        unsafe {
            let (low_ab, high_ab) = (_mm256_unpacklo_ps(a.0, b.0), _mm256_unpackhi_ps(a.0, b.0));
            let (low_cd, high_cd) = (_mm256_unpacklo_ps(c.0, d.0), _mm256_unpackhi_ps(c.0, d.0));
            let (low_ab, high_ab) = (_mm256_castps_pd(low_ab), _mm256_castps_pd(high_ab));
            let (low_cd, high_cd) = (_mm256_castps_pd(low_cd), _mm256_castps_pd(high_cd));
            let to = to.as_mut_ptr().cast::<f64>();
            // lanes 0 and 4, then 1 and 5, and so on
            _mm256_storeu_pd(to, _mm256_unpacklo_pd(low_ab, low_cd));
            _mm256_storeu_pd(to.add(4), _mm256_unpackhi_pd(low_ab, low_cd));
            _mm256_storeu_pd(to.add(8), _mm256_unpacklo_pd(high_ab, high_cd));
            _mm256_storeu_pd(to.add(12), _mm256_unpackhi_pd(high_ab, high_cd));
        }
    }
    #[inline(always)]
    fn slot(lane: usize) -> usize {
        (lane & 3) * 2 + (lane >> 2)
    }
}
