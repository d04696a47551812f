//! A plan for 64 cores, on paper: where arithmetic ends and memory begins.

use super::machine::Limit;
use super::scenes::{self, APIC, Size};
use super::{Bench, Count, Entry, three};
use crate::study::Section;
use crate::study::tools::tabulate;

const CORES: [usize; 7] = [1, 2, 4, 8, 16, 32, 64];
/// A socket of 64 cores of now: 12 channels of DDR5-4800, of 8 bytes each \[B/s\]; of that the share that a triad gets.
const CHANNELS: f64 = 12.0 * 4.8e9 * 8.0;
const SHARE: f64 = 0.8;
const ONE: &str = "1 thread";
const TWO: &str = "2 threads";

/// Bytes that private halos add to a particle-step: of a cube of so many particles, 8 a cell, each of `cores` ranges has W - 1 = 2 planes of its own
/// at its end, of nodes of 32 bytes that are written and read once more.
fn halo(particles: f64, cores: usize) -> f64 {
    let side = (particles / 8.0).cbrt();
    if cores == 1 { 0.0 } else { cores as f64 * 2.0 * (side + 2.0).powi(2) * 32.0 * 2.0 / particles }
}

pub(super) fn section(bench: &mut Bench) -> Result<Section, String> {
    let memory = Limit::memory(bench.effort);
    let size = bench.effort.pick(Size::COMMON, Size::MILLION);
    let entry = |name: &str, threads: usize| Entry::scene(name, scenes::block(size, APIC, 1), 5).threads(threads);
    let entries = vec![entry(ONE, 1), entry(TWO, 2), Entry::limit(memory, 1), Entry::limit(memory, 2)];
    let race = bench.race("cores", entries, bench.effort.pick(3, 5))?;
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
    let limit = |cores: usize, particles: f64| SHARE * CHANNELS / (bytes + halo(particles, cores));
    let plan = tabulate(
        "The common work on a socket of 64 cores",
        &[
            "cores",
            "by arithmetic [M/s]",
            "traffic [GB/s]",
            "halos, 1e6 particles [%]",
            "halos, 1e8 particles [%]",
            "by memory, 1e8 particles [M/s]",
            "expected, 1e8 particles [M/s]",
        ],
        CORES,
        |cores| {
            let arithmetic = cores as f64 * one;
            let most = limit(cores, 1e8);
            let cells = [
                1e-6 * arithmetic,
                1e-9 * arithmetic * (bytes + halo(1e8, cores)),
                100.0 * halo(1e6, cores) / bytes,
                100.0 * halo(1e8, cores) / bytes,
                1e-6 * most,
                1e-6 * arithmetic.min(most),
            ];
            (cores.to_string(), cells.map(|v| Some(three(v))).to_vec())
        },
    );
    let full = SHARE * CHANNELS / (one * bytes);
    // position and deformation gradient in and out, mass, volume, share of the nodes
    let fused = 8.0 * (2.0 * 12.0 + 2.0 + 3.0);
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
             - Ranges of particles in the order of blocks, one a core, with a private copy of the planes of nodes that two ranges share, summed in \
             the order of the ranges: the same bytes for any number of cores. What that adds is in the columns of halos; for small bodies it, and \
             two barriers a step, are what ends the gain, so that a range is not made smaller than some thousand particles.\n\
             - Memory is placed where it is used: each core is the first to write to its own range.\n\
             - Where memory is the limit, the passes over the particles are fused, so that velocity and affine matrix stay in registers between \
             steps of one call: {fused} bytes a particle-step. Single precision halves both.",
            1e-9 * CHANNELS,
            100.0 * SHARE
        ),
        tables: vec![traffic, plan],
        failures: race.faults,
        ..Section::default()
    })
}

#[cfg(test)]
mod tests {
    #[test]
    fn halos_shrink_with_the_body() {
        assert_eq!(super::halo(1e6, 1), 0.0);
        // 64 ranges, 2 planes of 52^2 nodes, 64 bytes
        assert!((super::halo(1e6, 64) - 64.0 * 2.0 * 2704.0 * 64.0 / 1e6).abs() < 1e-9);
    }
}
