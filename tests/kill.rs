//! A run killed at any moment leaves a recording that can be read up to the last flush.

#![cfg(all(unix, feature = "mcap", feature = "rerun"))]
#![allow(clippy::unwrap_used, reason = "a test may panic")]

use matpoint::record::{Item, Recording, Repair, repair};
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

#[test]
fn one_hundred_kills() {
    let folder = tempfile::tempdir().unwrap();
    let scene = Path::new(env!("CARGO_MANIFEST_DIR")).join("launch_scripts/scenes/cantilever.toml");
    let (mut frames, mut kept, mut lost, mut early) = (0, [0, 0], 0.0f64, 0);
    // Places spread evenly over the first seconds of a run, in an order without a pattern.
    for k in 0..100u64 {
        let path = folder.path().join(if k % 2 == 0 { "run.mcap" } else { "run.rrd" });
        let mut run = Command::new(env!("CARGO_BIN_EXE_matpoint"))
            .arg("run")
            .arg(&scene)
            .args(["--until", "1000", "--quiet", "--threads", "1", "--force", "--record"])
            .arg(&path)
            .stdout(Stdio::null())
            .spawn()
            .unwrap();
        let begun = Instant::now();
        std::thread::sleep(Duration::from_millis(20 + 37 * k % 900));
        run.kill().unwrap();
        run.wait().unwrap();
        let ran = begun.elapsed().as_secs_f64();
        let Ok(recording) = Recording::open(&path) else {
            // Killed before the file was there.
            early += 1;
            continue;
        };
        assert!(!recording.is_whole());
        assert_eq!(repair(&path).unwrap(), Repair::Done);
        let recording = Recording::open(&path).unwrap();
        assert!(recording.is_whole());
        let times: Vec<f64> =
            recording.filter_map(|item| if let Ok(Item::Frame(frame)) = item { Some(frame.time) } else { None }).collect();
        // Up to the last flush, at most half a second before (and as long to write): without a hole, a frame every 0.02 s from the start.
        assert!(times.iter().enumerate().all(|(i, time)| (time - 0.02 * i as f64).abs() < 1e-9), "{times:?}");
        frames += times.len();
        kept[k as usize % 2] += times.len();
        lost = lost.max(ran);
    }
    println!("100 kills after up to {lost:.2} s: {frames} frames read back, {early} killed before there was a file");
    assert!(kept.iter().all(|&frames| frames > 100) && early < 30, "{kept:?} frames of both formats");
}
