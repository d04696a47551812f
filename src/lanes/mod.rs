//! Eight numbers at once, or sixteen in single precision: one source of each kernel, compiled for AVX-512, for AVX2 with FMA, and for any CPU.
//!
//! Which of them runs is asked of the CPU once, in [`Instructions::of_this_cpu`]. A kernel is generic over [`Real`] and its [`Wide`] and called through a
//! function that is compiled for the instructions: everything below it must be inlined there, so it is `#[inline(always)]` and made of
//! plain loops. Closures, and `map` and `from_fn` of arrays of lanes, are functions of their own, which do not inherit the instructions of
//! their caller: kernels do without.
//!
//! Operations on lanes are the same IEEE operations whatever the width of the registers, so AVX-512 and AVX2 give the same bits, and so do
//! CPUs for which this build knows a fused multiply-add.

mod plain;
#[cfg(target_arch = "x86_64")]
#[macro_use]
mod register;
#[cfg(target_arch = "x86_64")]
mod x86;
#[cfg(target_arch = "x86_64")]
mod x86_single;

pub(crate) use plain::{Plain, PlainSingle};
#[cfg(target_arch = "x86_64")]
pub(crate) use x86::{Avx2, Avx512};
#[cfg(target_arch = "x86_64")]
pub(crate) use x86_single::{Avx2Single, Avx512Single};

use std::ops::{Add, Div, Mul, Neg, Sub};

/// Numbers worked on at once in double precision.
pub(crate) const LANES: usize = 8;

/// The most that are worked on at once.
pub(crate) const MOST_LANES: usize = 16;

/// One number a lane, in memory.
pub(crate) type Batch<N = f64> = [N; LANES];

/// Four numbers of a node: mass (or nothing), then one an axis.
pub(crate) type Quad<N = f64> = [N; 4];

/// Lanes of which something is true, a bit each, the first lane the lowest.
pub(crate) type Mask = u8;

/// Single or double precision.
pub(crate) trait Number: Copy + Default + Into<f64> {
    fn of(x: f64) -> Self;
}

impl Number for f64 {
    #[inline(always)]
    fn of(x: f64) -> Self {
        x
    }
}

impl Number for f32 {
    #[inline(always)]
    fn of(x: f64) -> Self {
        x as f32
    }
}

/// Instruction sets that kernels are compiled for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Instructions {
    #[cfg(target_arch = "x86_64")]
    Avx512,
    #[cfg(target_arch = "x86_64")]
    Avx2,
    /// What every CPU of the target has; on aarch64 that is NEON.
    Plain,
}

/// Name of the environment variable that chooses less than the CPU has, for comparisons.
pub(crate) const CHOICE: &str = "MATPOINT_INSTRUCTIONS";

impl Instructions {
    /// The widest that this CPU has, unless the environment asks for less.
    pub(crate) fn of_this_cpu() -> Self {
        let choice = std::env::var(CHOICE).unwrap_or_default();
        #[cfg(target_arch = "x86_64")]
        {
            use std::arch::is_x86_feature_detected as has;
            let avx2 = has!("avx2") && has!("fma");
            if choice.is_empty() && avx2 && has!("avx512f") && has!("avx512dq") && has!("avx512vl") {
                return Self::Avx512;
            }
            if choice != "portable" && avx2 {
                return Self::Avx2;
            }
        }
        let _ = choice;
        Self::Plain
    }
}

/// Numbers, one a lane: eight, or sixteen in single precision where a register holds them. Nodes in a row with a [`Quad`] each are numbers too.
pub(crate) trait Real:
    Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Div<Output = Self> + Neg<Output = Self>
{
    type Number: Number;
    /// Eight lanes in double precision.
    type Wide: Wide;
    /// A number a lane, in memory.
    type Lanes: Copy + AsRef<[Self::Number]>;
    /// A quad a lane, in memory.
    type Quads: Copy + AsRef<[Quad<Self::Number>]>;
    /// Which lanes are of the first of two cells, and which of the second.
    type Cells: Copy;
    /// Lanes in eights.
    const EIGHTS: usize;
    /// Nodes in a row: four lanes each.
    const NODES: usize = 2 * Self::EIGHTS;
    const LANES: usize = LANES * Self::EIGHTS;
    /// Whether [`Real::of_cells`] is worth its time.
    const MIXES: bool = true;

    /// The same number in all lanes.
    fn splat(x: f64) -> Self;
    /// The same number in all lanes, from memory.
    fn all(x: Self::Number) -> Self;
    /// # Safety
    /// As many numbers as there are lanes may be read.
    unsafe fn load(from: *const Self::Number) -> Self;
    /// # Safety
    /// As many numbers as there are lanes may be written.
    unsafe fn store(self, to: *mut Self::Number);
    fn store_lanes(self, to: &mut Self::Lanes);

    /// The first `count` lanes are of the first of two cells.
    fn cells(count: usize) -> Self::Cells;
    /// A number a cell in its lanes.
    fn of_cells(numbers: [Self::Number; 2], cells: Self::Cells) -> Self;

    /// Lanes of one eight after the other; those of one that is not there are not looked at.
    fn join(eights: [Self::Wide; 2]) -> Self;
    fn load_eight(from: &Batch<Self::Number>) -> Self::Wide;
    fn store_eight(eight: Self::Wide, to: &mut Batch<Self::Number>);

    /// `self * b + c`, rounded once where the CPU can.
    fn fma(self, b: Self, c: Self) -> Self;
    /// `c - self * b`, rounded once where the CPU can.
    fn fnma(self, b: Self, c: Self) -> Self;
    fn max(self, other: Self) -> Self;
    fn min(self, other: Self) -> Self;

    /// The same quad at all nodes of a row.
    fn at_all(quad: &Quad<Self::Number>) -> Self;
    /// A quad a node of a row, of which there may be fewer than there is room for.
    fn at_each<const N: usize>(quads: [&Quad<Self::Number>; N]) -> Self;
    /// The same number in all lanes of a node, for each node of a row, of which there may be fewer than there is room for.
    fn spread<const N: usize>(numbers: [Self::Number; N]) -> Self;
    /// Adds the first `count` nodes of a row to nodes in double precision.
    ///
    /// # Safety
    /// Four numbers a node may be read and written.
    unsafe fn add_to(self, to: *mut f64, count: usize);
    /// Turns four fields with a lane a particle into a quad a particle, that of lane l at [`Real::slot`] of l.
    fn turn(fields: [Self; 4], to: &mut Self::Quads);
    /// Where [`Real::turn`] puts a lane.
    fn slot(lane: usize) -> usize;

    /// Carries out a task out of line, compiled for the same instructions: what is seldom needed, and would be compiled in many places.
    ///
    /// # Safety
    /// The CPU has the instructions, and the task is safe to carry out.
    unsafe fn apart<T: Apart<Self>>(task: T) -> T::Result;
}

/// What is carried out [`Real::apart`].
pub(crate) trait Apart<V> {
    type Result;
    /// # Safety
    /// As the task says. Implementations are inlined always.
    unsafe fn carry_out(self) -> Self::Result;
}

/// Eight numbers in double precision, with what only particles need.
pub(crate) trait Wide: Real<Number = f64, Wide = Self, Lanes = Batch, Quads = [Quad; LANES]> {
    /// The first lane.
    fn first(self) -> f64;

    /// The first `count` lanes from memory, zeros in the others.
    ///
    /// # Safety
    /// `count` numbers at `from` may be read; `count` is at most [`LANES`].
    unsafe fn load_some(from: *const f64, count: usize) -> Self;

    /// Writes the first `count` lanes.
    ///
    /// # Safety
    /// `count` numbers at `to` may be written; `count` is at most [`LANES`].
    unsafe fn store_some(self, to: *mut f64, count: usize);

    fn floor(self) -> Self;
    fn abs(self) -> Self;
    /// Where `self <= other`; false for NaN.
    fn at_most(self, other: Self) -> Mask;
    /// Where `self < other`; false for NaN.
    fn below(self, other: Self) -> Mask;
    /// `self` where the mask is set, else `other`.
    fn select(self, mask: Mask, other: Self) -> Self;

    /// Whole numbers from 0 to below 2^31.
    fn store_indices(self, to: &mut [u32; LANES]);

    /// Mantissa in \[0.75, 1.5) and exponent to base 2 of positive numbers.
    fn split(self) -> (Self, Self);

    /// Natural logarithm of positive numbers: ln x = e ln 2 + 2 artanh((m - 1) / (m + 1)), the series to its 12th term, whose remainder is
    /// below the round-off as |(m - 1) / (m + 1)| <= 1/5. Terms are summed in pairs and pairs of pairs, so that few wait for others.
    #[inline(always)]
    fn ln(self) -> Self {
        let (mantissa, exponent) = self.split();
        let one = Self::splat(1.0);
        let s = (mantissa - one) / (mantissa + one);
        let s2 = s * s;
        let s4 = s2 * s2;
        let s8 = s4 * s4;
        let mut thirds = [one; 3];
        for third in 0..3 {
            // 2 / (2 n + 1) from n = 4 third on
            let n = (8 * third + 1) as f64;
            let low = s2.fma(Self::splat(2.0 / (n + 2.0)), Self::splat(2.0 / n));
            let high = s2.fma(Self::splat(2.0 / (n + 6.0)), Self::splat(2.0 / (n + 4.0)));
            thirds[third] = s4.fma(high, low);
        }
        let sum = s8.fma(s8.fma(thirds[2], thirds[1]), thirds[0]);
        exponent.fma(Self::splat(std::f64::consts::LN_2), sum * s)
    }
}

#[cfg(test)]
mod tests;
