//! What recording costs: a block of 1e5 particles, a frame every 10 steps, with nobody listening and with each format. Prints the share of the
//! step loop and bytes a particle and frame; run with `cargo bench --bench record`.

#![expect(clippy::unwrap_used, reason = "a benchmark may")]

use matpoint::record::{Options, Recorder, sink_for};
use matpoint::scene::Scene;
use std::time::Instant;

/// Frames of a round.
const FRAMES: usize = 12;
const ROUNDS: usize = 5;

fn scene() -> Scene {
    // 46^3 = 97 336 particles that fall freely at first: every step is alike.
    let text = r#"
        title = "block"
        dimension = 3
        grid = { origin = [0, 0, 0], size = [4, 4, 4], cell = 0.1 }
        material.soft = { law = "neo_hookean", young = 1e5, poisson = 0.3, density = 1000 }
        body.block = { material = "soft", shape = { box = { min = [0.8, 0.8, 0.8], max = [3.1, 3.1, 3.1] } }, velocity = ["0.2*y", "-0.2*x", 0] }
        method = { transfer = "apic" }
        time = { end = 10, step = 0.001 }
        "#;
    Scene::from_toml(text).unwrap()
}

fn main() {
    let folder = tempfile::tempdir().unwrap();
    let threads: usize = std::env::var("THREADS").ok().and_then(|n| n.parse().ok()).unwrap_or(1);
    rayon::ThreadPoolBuilder::new().num_threads(threads).build_global().unwrap();
    let mut sim = scene().build().unwrap();
    let particles = sim.describe().particles;
    sim.step(0.01).unwrap();
    let state = sim.save();
    let formats = [None, Some("mcap"), Some("rrd"), Some("pvd")];
    let mut walls = vec![Vec::new(); formats.len()];
    let mut works = walls.clone();
    let mut offers = walls.clone();
    let mut finishes = vec![0.0; formats.len()];
    let mut bytes = vec![0; formats.len()];
    // In turns, so that what else the machine does falls on all alike; the best of each is compared.
    for _ in 0..ROUNDS {
        for (k, format) in formats.iter().enumerate() {
            sim.restore(&state).unwrap();
            sim.step(0.01).unwrap();
            let path = format.map(|ending| folder.path().join(ending).with_added_extension(ending));
            let sinks = path.iter().map(|path| sink_for(path, &Options { force: true, ..Options::default() }).unwrap()).collect();
            let mut recorder = Recorder::begin(&mut sim, sinks, Some(0.01), Some(0.01)).unwrap();
            let (begun, worked, mut offered) = (Instant::now(), work(), 0.0);
            for _ in 0..FRAMES {
                sim.step(0.01).unwrap();
                let stepped = Instant::now();
                recorder.offer(&mut sim).unwrap();
                offered += stepped.elapsed().as_secs_f64();
            }
            walls[k].push(begun.elapsed().as_secs_f64());
            works[k].push(work() - worked);
            offers[k].push(offered);
            let ended = Instant::now();
            recorder.finish(&mut sim).unwrap();
            finishes[k] = ended.elapsed().as_secs_f64();
            // ParaView's frames are in a folder beside the list.
            bytes[k] = path.map_or(0, |path| size(&path) + size(&path.with_extension("")));
        }
    }
    let least = |times: &[Vec<f64>], k: usize| times[k].iter().copied().fold(f64::INFINITY, f64::min);
    let best = |k: usize| least(&walls, k);
    println!("{particles} particles, {threads} threads, {FRAMES} frames of 10 steps, best of {ROUNDS}");
    let a_frame = 1e3 / FRAMES as f64;
    println!("no listener: {:.1} ms for 10 steps, {:.1} ms of work", a_frame * best(0), a_frame * least(&works, 0));
    for (k, format) in formats.iter().enumerate().skip(1) {
        let frames = (FRAMES + 1) as f64;
        println!(
            "{:5}: step loop {:+.1} %, work of its threads {:+.1} % ({:.1} ms a frame to hand over), {:.2} bytes a particle and frame, {:.0} MB/s over the run, {:.0} ms to finish",
            format.unwrap_or_default(),
            100.0 * (best(k) / best(0) - 1.0),
            100.0 * (least(&works, k) / least(&works, 0) - 1.0),
            a_frame * least(&offers, k),
            bytes[k] as f64 / (frames * particles as f64),
            1e-6 * bytes[k] as f64 / (best(k) + finishes[k]),
            1e3 * finishes[k],
        );
    }
}

fn size(path: &std::path::Path) -> u64 {
    match std::fs::read_dir(path) {
        Ok(entries) => entries.flatten().map(|entry| entry.metadata().map_or(0, |m| m.len())).sum(),
        Err(_) => std::fs::metadata(path).map_or(0, |m| m.len()),
    }
}

/// Time on the processor of all threads but those that record \[s\]: what else the machine does falls out of it.
fn work() -> f64 {
    let mut nanos = 0;
    let name = |task: &std::path::Path| std::fs::read_to_string(task.join("comm")).unwrap_or_default();
    let ours = name(std::path::Path::new("/proc/thread-self"));
    for task in std::fs::read_dir("/proc/self/task").unwrap().flatten() {
        // Threads of the solver have the name of the process.
        if name(&task.path()) == ours {
            let times = std::fs::read_to_string(task.path().join("schedstat")).unwrap_or_default();
            nanos += times.split(' ').next().and_then(|n| n.parse::<u64>().ok()).unwrap_or(0);
        }
    }
    1e-9 * nanos as f64
}
