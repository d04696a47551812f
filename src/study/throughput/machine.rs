//! The limits of the machine: how many multiplications and additions a core does in a second, how many bytes it moves.

use super::{Bench, Entry, three};
use crate::study::tools::tabulate;
use crate::study::{Effort, Section};
use std::hint::black_box;
use std::sync::Barrier;
use std::time::Instant;

/// Instructions that a program may choose at run time.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Instructions {
    Avx512,
    Avx2,
    /// What every processor of its kind has.
    Portable,
}

impl Instructions {
    /// Those that this processor has, the fastest first.
    pub(super) fn all() -> Vec<Self> {
        [Self::Avx512, Self::Avx2, Self::Portable].into_iter().filter(|set| set.is_there()).collect()
    }

    fn is_there(self) -> bool {
        match self {
            #[cfg(target_arch = "x86_64")]
            Self::Avx512 => is_x86_feature_detected!("avx512f"),
            #[cfg(target_arch = "x86_64")]
            Self::Avx2 => is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma"),
            #[cfg(not(target_arch = "x86_64"))]
            Self::Avx512 | Self::Avx2 => false,
            Self::Portable => true,
        }
    }

    /// The name, also for `MATPOINT_INSTRUCTIONS`.
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Avx512 => "avx512",
            Self::Avx2 => "avx2",
            Self::Portable => "portable",
        }
    }
}

/// What is measured of the machine.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Limit {
    /// Multiply-adds in registers \[flop/s\], two operations each.
    Peak(Instructions, Precision),
    /// The triad a = b + s c in arrays of 0.5 MiB, which three of the L2 caches of now hold \[B/s\]: 24 bytes a number.
    Cache,
    /// The same in arrays of so many numbers, which caches do not hold.
    Memory(usize),
}

/// Of numbers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Precision {
    Single,
    Double,
}

impl Limit {
    /// The fastest multiply-adds in double precision.
    pub(super) fn fastest() -> Self {
        Self::Peak(Instructions::all()[0], Precision::Double)
    }

    /// The triad in arrays as large as `effort` allows: 256 MiB, or 64 MiB, which a large cache may hold in part.
    pub(super) fn memory(effort: Effort) -> Self {
        Self::Memory(effort.pick(1 << 23, 1 << 25))
    }

    pub(super) fn name(self, threads: usize) -> String {
        let what = match self {
            Self::Peak(set, Precision::Double) => format!("multiply-add, {}, double", set.name()),
            Self::Peak(set, Precision::Single) => format!("multiply-add, {}, single", set.name()),
            Self::Cache => "triad in L2".into(),
            Self::Memory(_) => "triad in memory".into(),
        };
        format!("{what}, {threads} thread{}", if threads == 1 { "" } else { "s" })
    }

    /// A measurement of it with so many threads, to be repeated; operations or bytes a second.
    pub(super) fn gauge(self, threads: usize) -> Box<dyn FnMut() -> f64> {
        match self {
            Self::Peak(set, precision) => Box::new(move || peak(set, precision, threads)),
            Self::Cache => triad(1 << 16, 400, threads),
            Self::Memory(numbers) => triad(numbers, 1, threads),
        }
    }
}

/// Chains of multiply-adds beside each other: more than their latency (4) times the instructions that begin in a cycle (2).
const CHAINS: usize = 12;
/// Links of a chain: about ten milliseconds.
const LINKS: u64 = 4_000_000;

macro_rules! chains {
    ($name:ident, $features:literal, $splat:ident, $fmadd:ident, $sum:ident, $number:ty) => {
        #[cfg(target_arch = "x86_64")]
        #[target_feature(enable = $features)]
        #[inline]
        pub(super) fn $name(links: u64, factor: $number) -> f64 {
            use std::arch::x86_64::*;
            let (a, b) = ($splat(factor), $splat(1.0 - factor));
            let mut x = [a; CHAINS];
            for _ in 0..links {
                for i in 0..CHAINS {
                    x[i] = $fmadd(x[i], a, b);
                }
            }
            let mut sum = x[0];
            for i in 1..CHAINS {
                sum = $fmadd(x[i], a, sum);
            }
            f64::from($sum(sum))
        }
    };
}
chains!(avx512_double, "avx512f", _mm512_set1_pd, _mm512_fmadd_pd, _mm512_reduce_add_pd, f64);
chains!(avx512_single, "avx512f", _mm512_set1_ps, _mm512_fmadd_ps, _mm512_reduce_add_ps, f32);
chains!(avx2_double, "avx2,fma", _mm256_set1_pd, _mm256_fmadd_pd, _mm256_cvtsd_f64, f64);
chains!(avx2_single, "avx2,fma", _mm256_set1_ps, _mm256_fmadd_ps, _mm256_cvtss_f32, f32);

/// What every processor has that runs this program: SSE2, where a fused multiply-add is two instructions.
#[cfg(target_arch = "x86_64")]
mod portable {
    use super::CHAINS;
    use std::arch::x86_64::*;

    #[inline]
    #[target_feature(enable = "sse2")]
    fn fmadd_pd(x: __m128d, a: __m128d, b: __m128d) -> __m128d {
        _mm_add_pd(_mm_mul_pd(x, a), b)
    }
    #[inline]
    #[target_feature(enable = "sse2")]
    fn fmadd_ps(x: __m128, a: __m128, b: __m128) -> __m128 {
        _mm_add_ps(_mm_mul_ps(x, a), b)
    }
    chains!(double, "sse2", _mm_set1_pd, fmadd_pd, _mm_cvtsd_f64, f64);
    chains!(single, "sse2", _mm_set1_ps, fmadd_ps, _mm_cvtss_f32, f32);
}

/// What the compiler makes of arrays as wide as a register.
#[cfg(not(target_arch = "x86_64"))]
mod portable {
    use super::CHAINS;

    macro_rules! arrays {
        ($name:ident, $number:ty) => {
            pub(super) fn $name(links: u64, factor: $number) -> f64 {
                const LANES: usize = 16 / size_of::<$number>();
                let mut x = [[factor; LANES]; CHAINS];
                for _ in 0..links {
                    for i in 0..CHAINS {
                        for lane in 0..LANES {
                            x[i][lane] = x[i][lane].mul_add(factor, 1.0 - factor);
                        }
                    }
                }
                f64::from(x.iter().flatten().sum::<$number>())
            }
        };
    }
    arrays!(double, f64);
    arrays!(single, f32);
}

/// Operations a second of `threads` cores.
fn peak(set: Instructions, precision: Precision, threads: usize) -> f64 {
    let register = match set {
        Instructions::Avx512 => 64,
        Instructions::Avx2 => 32,
        Instructions::Portable => 16,
    };
    let lanes = register / if precision == Precision::Double { 8 } else { 4 };
    let work = || {
        let factor = black_box(0.999_f32);
        black_box(match (set, precision) {
            // SAFETY: only sets that this processor has are asked for (`Instructions::all`)
            #[cfg(target_arch = "x86_64")]
            (Instructions::Avx512, Precision::Double) => unsafe { avx512_double(LINKS, factor.into()) },
            // SAFETY: as above
            #[cfg(target_arch = "x86_64")]
            (Instructions::Avx512, Precision::Single) => unsafe { avx512_single(LINKS, factor) },
            // SAFETY: as above
            #[cfg(target_arch = "x86_64")]
            (Instructions::Avx2, Precision::Double) => unsafe { avx2_double(LINKS, factor.into()) },
            // SAFETY: as above
            #[cfg(target_arch = "x86_64")]
            (Instructions::Avx2, Precision::Single) => unsafe { avx2_single(LINKS, factor) },
            // SAFETY: SSE2 is part of the architecture
            #[cfg(target_arch = "x86_64")]
            (Instructions::Portable, Precision::Double) => unsafe { portable::double(LINKS, factor.into()) },
            // SAFETY: as above
            #[cfg(target_arch = "x86_64")]
            (Instructions::Portable, Precision::Single) => unsafe { portable::single(LINKS, factor) },
            #[cfg(not(target_arch = "x86_64"))]
            (_, Precision::Double) => portable::double(LINKS, factor.into()),
            #[cfg(not(target_arch = "x86_64"))]
            (_, Precision::Single) => portable::single(LINKS, factor),
        });
    };
    let flops = (2 * CHAINS * lanes * threads) as f64 * LINKS as f64;
    flops / together(threads, vec![(); threads], |()| work()).0
}

/// Bytes a second of the triad in arrays of `numbers`, gone over `times` in a measurement.
fn triad(numbers: usize, times: usize, threads: usize) -> Box<dyn FnMut() -> f64> {
    let mut arrays: Vec<[Vec<f64>; 3]> = (0..threads).map(|_| [0.0, 1.0, 2.0].map(|v| vec![v; numbers])).collect();
    Box::new(move || {
        let (seconds, back) = together(threads, std::mem::take(&mut arrays), |mut own: [Vec<f64>; 3]| {
            let [a, b, c] = &mut own;
            for _ in 0..times {
                add(a, b, c, black_box(3.0));
                black_box(&mut *a);
            }
            own
        });
        arrays = back;
        (24 * numbers * times * threads) as f64 / seconds
    })
}

fn add(a: &mut [f64], b: &[f64], c: &[f64], s: f64) {
    #[inline(always)]
    fn plain(a: &mut [f64], b: &[f64], c: &[f64], s: f64) {
        for ((a, b), c) in a.iter_mut().zip(b).zip(c) {
            *a = b + s * c;
        }
    }
    #[cfg(target_arch = "x86_64")]
    {
        #[target_feature(enable = "avx2")]
        fn wide(a: &mut [f64], b: &[f64], c: &[f64], s: f64) {
            plain(a, b, c, s);
        }
        if is_x86_feature_detected!("avx2") {
            // SAFETY: the processor has AVX2
            return unsafe { wide(a, b, c, s) };
        }
    }
    plain(a, b, c, s);
}

/// Does the work in threads that begin together; the time until the last has ended \[s\], and what each gives back.
fn together<T: Send, R: Send>(threads: usize, inputs: Vec<T>, work: impl Fn(T) -> R + Sync) -> (f64, Vec<R>) {
    let barrier = Barrier::new(threads);
    let (barrier, work) = (&barrier, &work);
    let one = |input| {
        barrier.wait();
        let start = Instant::now();
        let result = work(input);
        (start.elapsed().as_secs_f64(), result)
    };
    let ended: Vec<(f64, R)> = std::thread::scope(|scope| {
        let handles: Vec<_> = inputs.into_iter().map(|input| scope.spawn(move || one(input))).collect();
        handles.into_iter().filter_map(|handle| handle.join().ok()).collect()
    });
    (ended.iter().map(|e| e.0).fold(0.0, f64::max), ended.into_iter().map(|e| e.1).collect())
}

/// Limits of this machine with one thread, in operations and bytes a second.
#[derive(Debug, Clone)]
pub(super) struct Machine {
    /// Multiply-adds in double precision, by instructions, the fastest first.
    pub(super) peaks: Vec<(Instructions, f64)>,
    /// The triad in L2.
    pub(super) cache: f64,
    /// The triad in memory.
    pub(super) memory: f64,
    /// All that was measured, with one thread and with two: name, and operations or bytes a second.
    rows: Vec<(String, [f64; 2])>,
}

impl Machine {
    /// The fastest multiply-adds in double precision.
    pub(super) fn peak(&self) -> f64 {
        self.peaks.iter().map(|p| p.1).fold(0.0, f64::max)
    }

    pub(super) fn peak_of(&self, set: Instructions) -> f64 {
        self.peaks.iter().find(|p| p.0 == set).map_or(f64::NAN, |p| p.1)
    }
}

pub(super) fn measure(bench: &mut Bench) -> Result<Machine, String> {
    let memory = Limit::memory(bench.effort);
    let limits: Vec<Limit> = Instructions::all()
        .into_iter()
        .flat_map(|set| [Limit::Peak(set, Precision::Double), Limit::Peak(set, Precision::Single)])
        .chain([Limit::Cache, memory])
        .collect();
    let entries: Vec<Entry> = limits.iter().flat_map(|&limit| [1, 2].map(|threads| Entry::limit(limit, threads))).collect();
    let race = bench.race("machine", &entries, bench.effort.pick(3, 15))?;
    let of = |limit: Limit, threads: usize| race.median(&limit.name(threads)).unwrap_or(f64::NAN);
    let peaks = Instructions::all().into_iter().map(|set| (set, of(Limit::Peak(set, Precision::Double), 1)));
    let rows = limits.iter().map(|&limit| {
        let name = limit.name(1);
        let unit = if matches!(limit, Limit::Peak(..)) { "Gflop/s" } else { "GB/s" };
        (format!("{} [{unit}]", name.trim_end_matches(", 1 thread")), [1, 2].map(|threads| of(limit, threads)))
    });
    Ok(Machine { peaks: peaks.collect(), cache: of(Limit::Cache, 1), memory: of(memory, 1), rows: rows.collect() })
}

pub(super) fn section(bench: &mut Bench) -> Result<Section, String> {
    let rows = bench.machine()?.rows.clone();
    let table = tabulate("Limits (medians)", &["what", "1 thread", "2 threads"], rows, |(name, values)| {
        (name, values.map(|v| Some(three(1e-9 * v))).to_vec())
    });
    Ok(Section {
        title: "The machine".into(),
        text: format!(
            "{}. Multiply-adds: {CHAINS} chains in registers, two operations each. Triad: a = b + s c, 24 bytes a number, in three arrays of \
             0.5 MiB (L2) and of {} MiB (memory).",
            processor(),
            bench.effort.pick(64, 256)
        ),
        tables: vec![table],
        ..Section::default()
    })
}

/// What the processor calls itself.
fn processor() -> String {
    let told = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let model = told.lines().find_map(|line| line.strip_prefix("model name")?.split_once(':')).map_or("processor", |pair| pair.1.trim());
    format!("{model}, {} threads at once", std::thread::available_parallelism().map_or(1, |n| n.get()))
}
