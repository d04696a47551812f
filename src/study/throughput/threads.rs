//! The same bytes for any number of threads.

use super::scenes::{self, APIC, Size};
use super::stopwatch::{Stopwatch, Task};
use super::{Bench, three};
use crate::study::Section;
use crate::study::tools::tabulate;

const COUNTS: [usize; 4] = [1, 2, 3, 4];

pub(super) fn section(bench: &mut Bench) -> Result<Section, String> {
    let size = bench.effort.pick(Size::QUICK, Size::COMMON);
    let mut task = Task::new(scenes::block(size, APIC, 1));
    task.shuffled = true;
    let run = |threads: usize| -> Result<(usize, u64, f64), String> {
        let mut watch = Stopwatch::start(bench.program, &task, threads, None)?;
        watch.step(2, 10)?;
        let seconds = watch.step(4, 10)?;
        Ok((threads, watch.hash()?, seconds))
    };
    let runs = COUNTS.into_iter().map(run).collect::<Result<Vec<_>, String>>()?;
    let (_, hash, alone) = runs[0];
    let table = tabulate("After 60 steps", &["threads", "same bytes as one thread", "time of one thread / time"], &runs, |run| {
        (run.0.to_string(), vec![Some(f64::from(u8::from(run.1 == hash))), Some(three(alone / run.2))])
    });
    let same = runs.iter().all(|run| run.1 == hash);
    let findings = bench.judge("1, 2, 3, 4 threads, double", "Same bytes.", || {
        Some((if same { format!("All snapshots have the hash {hash:016x}.") } else { "They differ.".into() }, same))
    });
    Ok(Section {
        title: "Threads".into(),
        text: format!(
            "The common work, {} particles, shuffled at the start; FNV-1a hashes of the snapshots of processes with 1 to 4 threads on {} cores. \
             1 stands for the same bytes, 0 for others. One run each: the parts above have the ratio of two threads to one.",
            size.particles(),
            std::thread::available_parallelism().map_or(1, |n| n.get())
        ),
        tables: vec![table],
        findings,
        ..Section::default()
    })
}
