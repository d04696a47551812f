//! What every CPU of the target can do.

use super::{Batch, LANES, Mask, Quad, Real};
use std::ops::{Add, Div, Mul, Neg, Sub};

/// Eight numbers, as wide at a time as the target of the build allows.
#[derive(Clone, Copy)]
#[repr(align(64))]
pub(crate) struct Plain(Batch);

/// Whether code for the plain target of this build has a fused multiply-add; without one it would be a slow library call.
const FUSED: bool = cfg!(any(target_arch = "aarch64", target_feature = "fma"));

/// Lane by lane.
macro_rules! lanes {
    ($l:ident => $value:expr) => {{
        let mut to = [0.0; LANES];
        let mut $l = 0;
        while $l < LANES {
            to[$l] = $value;
            $l += 1;
        }
        Plain(to)
    }};
}

macro_rules! operator {
    ($($trait:ident $name:ident $op:tt)*) => {$(
        impl $trait for Plain {
            type Output = Self;
            #[inline(always)]
            fn $name(self, other: Self) -> Self {
                lanes!(l => self.0[l] $op other.0[l])
            }
        }
    )*};
}
operator!(Add add + Sub sub - Mul mul * Div div /);

impl Neg for Plain {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        lanes!(l => -self.0[l])
    }
}

impl Real for Plain {
    #[inline(always)]
    fn splat(x: f64) -> Self {
        Self([x; LANES])
    }
    #[inline(always)]
    fn load(from: &Batch) -> Self {
        Self(*from)
    }
    #[inline(always)]
    fn store(self, to: &mut Batch) {
        *to = self.0;
    }
    #[inline(always)]
    fn first(self) -> f64 {
        self.0[0]
    }
    #[inline(always)]
    unsafe fn load_some(from: *const f64, count: usize) -> Self {
        let mut to = [0.0; LANES];
        for l in 0..count.min(LANES) {
            // SAFETY: the caller's promise.
            to[l] = unsafe { *from.add(l) };
        }
        Self(to)
    }
    #[inline(always)]
    unsafe fn store_some(self, to: *mut f64, count: usize) {
        for l in 0..count.min(LANES) {
            // SAFETY: the caller's promise.
            unsafe { *to.add(l) = self.0[l] };
        }
    }
    #[inline(always)]
    fn fma(self, b: Self, c: Self) -> Self {
        lanes!(l => if FUSED { self.0[l].mul_add(b.0[l], c.0[l]) } else { self.0[l] * b.0[l] + c.0[l] })
    }
    #[inline(always)]
    fn fnma(self, b: Self, c: Self) -> Self {
        (-self).fma(b, c)
    }
    #[inline(always)]
    fn floor(self) -> Self {
        lanes!(l => self.0[l].floor())
    }
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        lanes!(l => if self.0[l] > other.0[l] { self.0[l] } else { other.0[l] })
    }
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        lanes!(l => if self.0[l] < other.0[l] { self.0[l] } else { other.0[l] })
    }
    #[inline(always)]
    fn abs(self) -> Self {
        lanes!(l => self.0[l].abs())
    }
    #[inline(always)]
    fn at_most(self, other: Self) -> Mask {
        let mut mask = 0;
        for l in 0..LANES {
            mask |= u8::from(self.0[l] <= other.0[l]) << l;
        }
        mask
    }
    #[inline(always)]
    fn below(self, other: Self) -> Mask {
        let mut mask = 0;
        for l in 0..LANES {
            mask |= u8::from(self.0[l] < other.0[l]) << l;
        }
        mask
    }
    #[inline(always)]
    fn select(self, mask: Mask, other: Self) -> Self {
        lanes!(l => if mask >> l & 1 == 1 { self.0[l] } else { other.0[l] })
    }
    #[inline(always)]
    fn store_indices(self, to: &mut [u32; LANES]) {
        for l in 0..LANES {
            to[l] = self.0[l] as u32;
        }
    }
    #[inline(always)]
    fn split(self) -> (Self, Self) {
        const FRACTION: u64 = (1 << 52) - 1;
        const ONE: u64 = 1023 << 52;
        let m = lanes!(l => {
            let m = f64::from_bits(self.0[l].to_bits() & FRACTION | ONE);
            if m >= 1.5 { 0.5 * m } else { m }
        });
        let e = lanes!(l => {
            let bits = self.0[l].to_bits();
            // the exponent, one more where the mantissa was halved
            ((bits + (1 << 51)) >> 52) as f64 - 1023.0
        });
        (m, e)
    }
    #[inline(always)]
    fn both(quad: &Quad) -> Self {
        lanes!(l => quad[l % 4])
    }
    #[inline(always)]
    fn halves(a: &Quad, b: &Quad) -> Self {
        Self([a[0], a[1], a[2], a[3], b[0], b[1], b[2], b[3]])
    }
    #[inline(always)]
    fn pair(a: f64, b: f64) -> Self {
        Self([a, a, a, a, b, b, b, b])
    }
    #[inline(always)]
    unsafe fn add_lower_to(self, to: *mut f64) {
        for l in 0..4 {
            // SAFETY: the caller's promise.
            unsafe { *to.add(l) += self.0[l] };
        }
    }
    #[inline(always)]
    unsafe fn add_to(self, to: *mut f64) {
        for l in 0..LANES {
            // SAFETY: the caller's promise.
            unsafe { *to.add(l) += self.0[l] };
        }
    }
    #[inline(always)]
    fn turn(fields: [Self; 4], to: &mut [Quad; LANES]) {
        for l in 0..LANES {
            to[l] = [fields[0].0[l], fields[1].0[l], fields[2].0[l], fields[3].0[l]];
        }
    }
    #[inline(always)]
    fn slot(lane: usize) -> usize {
        lane
    }
}
