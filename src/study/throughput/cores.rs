//! A plan for 64 cores, on paper: where arithmetic ends and memory begins.

use super::machine::Limit;
use super::scenes::{self, APIC, Size};
use super::{Bench, Count, Entry, three};
use crate::grid::Turns;
use crate::study::Section;
use crate::study::tools::tabulate;

const CORES: [usize; 7] = [1, 2, 4, 8, 16, 32, 64];
/// A socket of 64 cores of now: 12 channels of DDR5-4800, of 8 bytes each \[B/s\]; of that the share that a triad gets.
const CHANNELS: f64 = 12.0 * 4.8e9 * 8.0;
const SHARE: f64 = 0.8;
const ONE: &str = "1 thread";
const TWO: &str = "2 threads";

/// Particles of a block of 8 x 8 x 8 cells, which bodies of half a million particles and more are cut into.
const BLOCK: f64 = 8.0 * 512.0;

/// Share of the time in which `cores` have a block of a cube of particles, if all blocks take as long: dealt out as a step does.
fn busy(particles: f64, cores: usize) -> f64 {
    let along = (particles / BLOCK).cbrt().round() as i32;
    let blocks = (0..along.pow(3)).map(|b| [b / (along * along), b / along % along, b % along]).collect::<Vec<_>>();
    let turns = Turns::new(&blocks.iter().map(|&block| (0, block)).collect::<Vec<_>>(), |_| 0);
    blocks.len() as f64 / (cores * turns.rounds(cores)) as f64
}

pub(super) fn section(bench: &mut Bench) -> Result<Section, String> {
    let memory = Limit::memory(bench.effort);
    let size = bench.effort.pick(Size::COMMON, Size::MILLION);
    let entry = |name: &str, threads: usize| Entry::scene(name, scenes::block(size, APIC, 1), 5).threads(threads);
    let entries = vec![entry(ONE, 1), entry(TWO, 2), Entry::limit(memory, 1), Entry::limit(memory, 2)];
    let race = bench.race("cores", &entries, bench.effort.pick(3, 5))?;
    let (Some(one), Some(two)) = (race.median(ONE), race.median(TWO)) else {
        return Err(race.faults.into_iter().map(|fault| fault.1).collect::<Vec<_>>().join("; "));
    };
    let bytes = Count::COMMON.bytes();
    let traffic = tabulate(
        "Memory traffic here: counted bytes times the rate",
        &["", "M/s", "GB/s", "triad in memory [GB/s]", "share [%]"],
        [(ONE, one, 1), (TWO, two, 2)],
        |(name, rate, threads)| {
            let triad = memory.name(threads);
            let cells = [
                Some(1e-6 * rate),
                Some(1e-9 * rate * bytes),
                race.median(&triad).map(|triad| 1e-9 * triad),
                race.ratio(name, &triad).map(|share| 100.0 * share * bytes),
            ];
            (name.to_owned(), cells.map(|v| v.map(three)).to_vec())
        },
    );
    let most = SHARE * CHANNELS / bytes;
    let plan = tabulate(
        "The common work on a socket of 64 cores",
        &[
            "cores",
            "by arithmetic [M/s]",
            "traffic [GB/s]",
            "cores with work, 1e6 particles [%]",
            "the same, 1e8 [%]",
            "by memory [M/s]",
            "expected, 1e6 particles [M/s]",
            "the same, 1e8 [M/s]",
        ],
        CORES,
        |cores| {
            let arithmetic = cores as f64 * one;
            let expected = |particles: f64| 1e-6 * most.min(arithmetic * busy(particles, cores));
            let cells = [
                1e-6 * arithmetic,
                1e-9 * arithmetic * bytes,
                100.0 * busy(1e6, cores),
                100.0 * busy(1e8, cores),
                1e-6 * most,
                expected(1e6),
                expected(1e8),
            ];
            (cores.to_string(), cells.map(|v| Some(three(v))).to_vec())
        },
    );
    let full = SHARE * CHANNELS / (one * bytes);
    let ends = if full < 64.0 {
        format!("With {full:.0} cores at the rate of one of here the memory is full.")
    } else {
        format!("The memory would be full with {full:.0} cores at the rate of one of here: 64 stay below it.")
    };
    Ok(Section {
        title: "64 cores, on paper".into(),
        text: format!(
            "A particle-step of the common work moves at least {bytes} bytes (double precision). A socket with 12 channels of DDR5-4800 has \
             {:.0} GB/s, of which a triad gets about {:.0} %. {ends}\n\n\
             - Now: particles in blocks of cells, one at a time to a core. A block waits for those of its 26 neighbours that come before it in a \
             fixed order, so that they add to the grid without locks and alike for any number of cores: the same bytes. With {:.0} blocks of \
             a million particles, of which at most one in 8 is open at a time, that is what ends the gain, long before the memory does.\n\
             - Then: each block keeps the sums of its tile, and nodes add those of their blocks in a fixed order: one barrier, and all \
             blocks are open at once. That costs the tile once more to memory and back, 32 bytes a node: {:.0} bytes a particle.\n\
             - Memory is placed where it is used: each core is the first to write to its own blocks, and keeps them.",
            1e-9 * CHANNELS,
            100.0 * SHARE,
            1e6 / BLOCK,
            2.0 * 32.0 * 1000.0 / BLOCK
        ),
        tables: vec![traffic, plan],
        failures: race.faults,
        ..Section::default()
    })
}

#[cfg(test)]
mod tests {
    #[test]
    fn cores_wait_where_blocks_are_few() {
        // 6 x 6 x 6 blocks, 27 of a colour
        assert_eq!([1, 27].map(|cores| super::busy(1e6, cores)), [1.0, 1.0]);
        assert!(super::busy(1e6, 16) > 0.9 && super::busy(1e6, 64) <= 27.0 / 64.0);
        assert!(super::busy(1e8, 64) > 0.98);
    }
}
