//! What every CPU of the target can do.

use super::{Apart, Batch, LANES, Mask, Quad, Real, Wide};
use std::ops::{Add, Div, Mul, Neg, Sub};

/// Eight numbers, as wide at a time as the target of the build allows.
#[derive(Clone, Copy)]
#[repr(align(64))]
pub(crate) struct Plain(Batch);

/// The same in single precision.
#[derive(Clone, Copy)]
#[repr(align(32))]
pub(crate) struct PlainSingle(Batch<f32>);

/// Whether code for the plain target of this build has a fused multiply-add; without one it would be a slow library call.
const FUSED: bool = cfg!(any(target_arch = "aarch64", target_feature = "fma"));

/// Lane by lane.
macro_rules! lanes {
    ($of:ident: $l:ident => $value:expr) => {{
        let mut to = [0.0; LANES];
        let mut $l = 0;
        while $l < LANES {
            to[$l] = $value;
            $l += 1;
        }
        $of(to)
    }};
}

macro_rules! operator {
    ($of:ident: $($trait:ident $name:ident $op:tt)*) => {$(
        impl $trait for $of {
            type Output = Self;
            #[inline(always)]
            fn $name(self, other: Self) -> Self {
                lanes!($of: l => self.0[l] $op other.0[l])
            }
        }
    )*};
}

macro_rules! real {
    ($of:ident of $number:ident) => {
        operator!($of: Add add + Sub sub - Mul mul * Div div /);

        impl Neg for $of {
            type Output = Self;
            #[inline(always)]
            fn neg(self) -> Self {
                lanes!($of: l => -self.0[l])
            }
        }

        impl Real for $of {
            type Number = $number;
            type Wide = Plain;
            type Lanes = Batch<$number>;
            type Quads = [Quad<$number>; LANES];
            type Cells = usize;
            const EIGHTS: usize = 1;
            const MIXES: bool = false;
            #[inline(always)]
            fn cells(count: usize) -> usize {
                count
            }
            #[inline(always)]
            fn of_cells([a, b]: [$number; 2], cells: usize) -> Self {
                lanes!($of: l => if l < cells { a } else { b })
            }
            #[inline(always)]
            fn splat(x: f64) -> Self {
                Self::all(x as $number)
            }
            #[inline(always)]
            fn all(x: $number) -> Self {
                Self([x; LANES])
            }
            #[inline(always)]
            unsafe fn load(from: *const $number) -> Self {
                // SAFETY: the caller's promise.
                Self(unsafe { *from.cast::<Batch<$number>>() })
            }
            #[inline(always)]
            unsafe fn store(self, to: *mut $number) {
                // SAFETY: the caller's promise.
                unsafe { *to.cast::<Batch<$number>>() = self.0 }
            }
            #[inline(always)]
            fn store_lanes(self, to: &mut Batch<$number>) {
                *to = self.0;
            }
            #[inline(always)]
            fn join([eight, _]: [Plain; 2]) -> Self {
                lanes!($of: l => eight.0[l] as $number)
            }
            #[inline(always)]
            fn load_eight(from: &Batch<$number>) -> Plain {
                lanes!(Plain: l => f64::from(from[l]))
            }
            #[inline(always)]
            fn store_eight(eight: Plain, to: &mut Batch<$number>) {
                *to = Self::join([eight, eight]).0;
            }
            #[inline(always)]
            fn fma(self, b: Self, c: Self) -> Self {
                lanes!($of: l => if FUSED { self.0[l].mul_add(b.0[l], c.0[l]) } else { self.0[l] * b.0[l] + c.0[l] })
            }
            #[inline(always)]
            fn fnma(self, b: Self, c: Self) -> Self {
                (-self).fma(b, c)
            }
            #[inline(always)]
            fn max(self, other: Self) -> Self {
                lanes!($of: l => if self.0[l] > other.0[l] { self.0[l] } else { other.0[l] })
            }
            #[inline(always)]
            fn min(self, other: Self) -> Self {
                lanes!($of: l => if self.0[l] < other.0[l] { self.0[l] } else { other.0[l] })
            }
            #[inline(always)]
            fn at_all(quad: &Quad<$number>) -> Self {
                lanes!($of: l => quad[l % 4])
            }
            #[inline(always)]
            fn at_each<const N: usize>(quads: [&Quad<$number>; N]) -> Self {
                let (a, b) = (quads[0], quads[N - 1]);
                Self([a[0], a[1], a[2], a[3], b[0], b[1], b[2], b[3]])
            }
            #[inline(always)]
            fn spread<const N: usize>(numbers: [$number; N]) -> Self {
                let (a, b) = (numbers[0], numbers[N - 1]);
                Self([a, a, a, a, b, b, b, b])
            }
            #[inline(always)]
            unsafe fn add_to(self, to: *mut f64, count: usize) {
                for l in 0..4 * count.min(2) {
                    // SAFETY: the caller's promise.
                    unsafe { *to.add(l) += f64::from(self.0[l]) };
                }
            }
            #[inline(always)]
            fn turn(fields: [Self; 4], to: &mut Self::Quads) {
                for l in 0..LANES {
                    to[l] = [fields[0].0[l], fields[1].0[l], fields[2].0[l], fields[3].0[l]];
                }
            }
            #[inline(always)]
            fn slot(lane: usize) -> usize {
                lane
            }
            #[cold]
            #[inline(never)]
            unsafe fn apart<T: Apart<Self>>(task: T) -> T::Result {
                // SAFETY: the caller's promise.
                unsafe { task.carry_out() }
            }
        }
    };
}
real!(Plain of f64);
real!(PlainSingle of f32);

impl Wide for Plain {
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
    fn floor(self) -> Self {
        lanes!(Plain: l => self.0[l].floor())
    }
    #[inline(always)]
    fn abs(self) -> Self {
        lanes!(Plain: l => self.0[l].abs())
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
        lanes!(Plain: l => if mask >> l & 1 == 1 { self.0[l] } else { other.0[l] })
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
        let m = lanes!(Plain: l => {
            let m = f64::from_bits(self.0[l].to_bits() & FRACTION | ONE);
            if m >= 1.5 { 0.5 * m } else { m }
        });
        let e = lanes!(Plain: l => {
            let bits = self.0[l].to_bits();
            // the exponent, one more where the mantissa was halved
            ((bits + (1 << 51)) >> 52) as f64 - 1023.0
        });
        (m, e)
    }
}
