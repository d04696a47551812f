//! Four numbers worked on at once: the lanes of a node.

use crate::grid::Lanes;

/// Arithmetic on the lanes of a node, one implementation an instruction set.
pub(super) trait Vector: Copy {
    fn zero() -> Self;
    fn load(lanes: &Lanes) -> Self;
    fn store(self, to: &mut Lanes);
    /// `a * x`.
    fn scale(a: f64, x: Self) -> Self;
    /// `a * x + y`.
    fn fma(a: f64, x: Self, y: Self) -> Self;
    fn lanes(self) -> Lanes {
        let mut lanes = Lanes::default();
        self.store(&mut lanes);
        lanes
    }
}

/// What every CPU can do; two or four at a time where the target allows.
#[derive(Clone, Copy)]
pub(super) struct Portable(Lanes);

/// Whether code for the plain target of this build has a fused multiply-add; without one it would be a slow library call.
const FUSED: bool = cfg!(any(target_arch = "aarch64", target_feature = "fma"));

impl Vector for Portable {
    #[inline(always)]
    fn zero() -> Self {
        Self(Lanes::default())
    }
    #[inline(always)]
    fn load(lanes: &Lanes) -> Self {
        Self(*lanes)
    }
    #[inline(always)]
    fn store(self, to: &mut Lanes) {
        *to = self.0;
    }
    #[inline(always)]
    fn scale(a: f64, x: Self) -> Self {
        Self(x.0.map(|v| a * v))
    }
    #[inline(always)]
    fn fma(a: f64, x: Self, y: Self) -> Self {
        Self(std::array::from_fn(|l| if FUSED { a.mul_add(x.0[l], y.0[l]) } else { a * x.0[l] + y.0[l] }))
    }
}

#[cfg(target_arch = "x86_64")]
pub(super) use x86::Avx2;

#[cfg(target_arch = "x86_64")]
mod x86 {
    use super::{Lanes, Vector};
    use std::arch::x86_64::*;

    /// Four lanes in one AVX register. Written with intrinsics, for the optimiser drops lanes that nobody reads and then falls back to
    /// one number at a time.
    ///
    /// Only kernels compiled for AVX2 and FMA use it, which run only on CPUs that have both: that makes every call below safe.
    #[derive(Clone, Copy)]
    pub(in crate::transfer) struct Avx2(__m256d);

    impl Vector for Avx2 {
        #[inline(always)]
        fn zero() -> Self {
            // SAFETY: the CPU has AVX2, see the type.
            Self(unsafe { _mm256_setzero_pd() })
        }
        #[inline(always)]
        fn load(lanes: &Lanes) -> Self {
            // SAFETY: the CPU has AVX2, see the type; four numbers are there to be read.
            Self(unsafe { _mm256_loadu_pd(lanes.as_ptr()) })
        }
        #[inline(always)]
        fn store(self, to: &mut Lanes) {
            // SAFETY: the CPU has AVX2, see the type; four numbers are there to be written.
            unsafe { _mm256_storeu_pd(to.as_mut_ptr(), self.0) }
        }
        #[inline(always)]
        fn scale(a: f64, x: Self) -> Self {
            // SAFETY: the CPU has AVX2, see the type.
            Self(unsafe { _mm256_mul_pd(_mm256_set1_pd(a), x.0) })
        }
        #[inline(always)]
        fn fma(a: f64, x: Self, y: Self) -> Self {
            // SAFETY: the CPU has FMA, see the type.
            Self(unsafe { _mm256_fmadd_pd(_mm256_set1_pd(a), x.0, y.0) })
        }
    }
}
