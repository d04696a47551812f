//! Recordings hold what was computed, can be read back, compared and gone on from, and are never written over unasked.

#![cfg(all(feature = "mcap", feature = "rerun"))]
#![allow(clippy::unwrap_used, reason = "a test may panic")]

use matpoint::Simulation;
use matpoint::record::{
    self, Event, Frame, Item, Level, Options, Precision, RecordError, Recorder, Recording, Repair, WhenFull, compare, sink_for,
};
use matpoint::scene::Scene;
use std::path::Path;

fn simulation(name: &str, overrides: &[(&str, &str)]) -> Simulation {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("launch_scripts/scenes").join(name);
    let overrides: Vec<(String, String)> = overrides.iter().map(|&(key, value)| (key.to_owned(), value.to_owned())).collect();
    Scene::load_with(path, &overrides).unwrap().build().unwrap()
}

/// Runs to `until` in steps of `dt`, recording each; gives what the frames should hold.
fn record(sim: &mut Simulation, path: &Path, dt: f64, until: f64, options: &Options) -> Vec<(f64, Vec<f64>, Vec<f64>)> {
    let mut recorder = Recorder::begin(sim, vec![sink_for(path, options).unwrap()], Some(dt), Some(dt)).unwrap();
    let mut seen = Vec::new();
    loop {
        let position = sim.get("particle/position").unwrap().to_vec();
        let stress = sim.get("particle/stress").unwrap().to_vec();
        seen.push((sim.time(), position, stress));
        if sim.time() >= until - 1e-12 {
            break;
        }
        sim.step(dt).unwrap();
        recorder.offer(sim).unwrap();
    }
    assert_eq!(recorder.finish(sim).unwrap(), [path]);
    seen
}

fn items(path: &Path) -> Vec<Item> {
    Recording::open(path).unwrap().collect::<Result<_, _>>().unwrap()
}

fn frames(path: &Path) -> Vec<Frame> {
    items(path).into_iter().filter_map(|item| if let Item::Frame(frame) = item { Some(frame) } else { None }).collect()
}

#[test]
fn what_is_read_back_is_what_was_recorded() {
    let folder = tempfile::tempdir().unwrap();
    for scene in ["bar_1d_vibration.toml", "cantilever.toml", "falling_block_3d.toml"] {
        for ending in ["mcap", "rrd"] {
            for precision in [Precision::Single, Precision::Double] {
                let path = folder.path().join(format!("{scene}-{precision:?}.{ending}"));
                let variables = Some(vec!["stress".to_owned(), "body".to_owned(), "deformation_gradient".to_owned()]);
                let options = Options { precision, variables, ..Options::default() };
                let mut sim = simulation(scene, &[]);
                let seen = record(&mut sim, &path, 0.01, 0.05, &options);
                let round = |v: &f64| if precision == Precision::Double { *v } else { f64::from(*v as f32) };
                let found = frames(&path);
                assert_eq!(found.len(), seen.len(), "{}", path.display());
                for (frame, (time, position, stress)) in found.iter().zip(&seen) {
                    assert!((frame.time - time).abs() < 1e-9, "{} {time}", frame.time);
                    assert!(*frame.values[0] == position.iter().map(round).collect::<Vec<_>>(), "{}: position", path.display());
                    // Stored once, read back as the whole tensor.
                    let close = |a: f64, b: f64| (a - b).abs() <= 1e-12 * b.abs().max(1.0);
                    let whole = frame.values[1].iter().zip(stress.iter().map(round)).all(|(a, b)| close(*a, b));
                    assert!(whole, "{}: stress at {time}", path.display());
                }
                let rows = items(&path).into_iter().filter(|item| matches!(item, Item::Row(_))).count();
                assert_eq!(rows, seen.len(), "{}", path.display());
            }
        }
    }
}

#[test]
fn the_history_reads_back_the_same_from_both_formats() {
    let folder = tempfile::tempdir().unwrap();
    let (mcap, rrd) = (folder.path().join("a.mcap"), folder.path().join("a.rrd"));
    let mut sim = simulation("cantilever.toml", &[]);
    let sinks = [&mcap, &rrd].map(|path| sink_for(path, &Options::default()).unwrap());
    let mut recorder = Recorder::begin(&mut sim, sinks.into(), Some(0.05), Some(0.01)).unwrap();
    for _ in 0..10 {
        sim.step(0.01).unwrap();
        recorder.offer(&mut sim).unwrap();
    }
    recorder.finish(&mut sim).unwrap();
    let about = Recording::open(&mcap).unwrap().about().clone();
    let tip = about.choose("probe/tip/stress").unwrap();
    let energy = about.choose("energy/nodal_kinetic").unwrap();
    for chosen in [tip, energy] {
        let text = |path: &Path| {
            let mut text = String::new();
            for item in items(path) {
                chosen
                    .lines(&item, &mut |line| {
                        text += line;
                        Ok(())
                    })
                    .unwrap();
            }
            text
        };
        assert_eq!(text(&mcap).lines().count(), 11);
        assert_eq!(text(&mcap), text(&rrd));
    }
    let error = about.choose("probe/tip/displacment").err().unwrap().to_string();
    assert!(error.contains("did you mean `probe/tip/displacement`"), "{error}");
}

#[test]
fn nothing_is_written_over_unasked() {
    let folder = tempfile::tempdir().unwrap();
    for name in ["a.mcap", "a.rrd", "a.pvd", "a.svg", "tables"] {
        let path = folder.path().join(name);
        let begin = |options: &Options| {
            let mut sim = simulation("bar_1d_vibration.toml", &[]);
            let recorder = Recorder::begin(&mut sim, vec![sink_for(&path, options).unwrap()], None, None)?;
            recorder.finish(&mut sim)
        };
        assert!(!begin(&Options::default()).unwrap().is_empty(), "{name}");
        let before = path.is_file().then(|| std::fs::read(&path).unwrap());
        let error = begin(&Options::default()).unwrap_err();
        assert!(matches!(error, RecordError::Exists { .. }) && error.to_string().contains("--force"), "{name}: {error}");
        assert!(before == path.is_file().then(|| std::fs::read(&path).unwrap()), "{name} is as it was");
        begin(&Options { force: true, ..Options::default() }).unwrap();
    }
}

#[test]
fn a_path_that_cannot_be_written_is_found_before_the_first_step() {
    let folder = tempfile::tempdir().unwrap();
    // Nobody, not even root, may make a file in /sys.
    let forbidden: &[&str] = if cfg!(target_os = "linux") { &["/sys/a.mcap", "/sys/a.rrd"] } else { &[] };
    for name in ["missing/a.mcap", "missing/a.rrd", "a.mcap/b.pvd"].iter().chain(forbidden) {
        std::fs::write(folder.path().join("a.mcap"), "").unwrap();
        let path = folder.path().join(name);
        let mut sim = simulation("bar_1d_vibration.toml", &[]);
        let error = Recorder::begin(&mut sim, vec![sink_for(&path, &Options::default()).unwrap()], None, None).err().unwrap();
        assert!(error.to_string().contains("cannot write") && error.to_string().contains(name.split('/').next().unwrap()), "{error}");
    }
    let wrong = Options { variables: Some(vec!["velocty".into()]), ..Options::default() };
    let mut sim = simulation("bar_1d_vibration.toml", &[]);
    let path = folder.path().join("b.mcap");
    let error = Recorder::begin(&mut sim, vec![sink_for(&path, &wrong).unwrap()], None, None).err().unwrap();
    assert!(error.to_string().contains("did you mean `velocity`") && !path.exists(), "{error}");
}

/// `/dev/full` takes nothing: every write fails as on a full disk.
#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_ends_the_recording_and_the_simulation_as_configured() {
    let folder = tempfile::tempdir().unwrap();
    for ending in ["mcap", "rrd"] {
        let path = folder.path().join(format!("full.{ending}"));
        std::os::unix::fs::symlink("/dev/full", &path).unwrap();
        for keep_going in [false, true] {
            let options = Options {
                force: true,
                keep_going,
                variables: Some(vec!["stress".into()]),
                precision: Precision::Double,
                ..Options::default()
            };
            let mut sim = simulation("falling_block_3d.toml", &[]);
            let sinks = vec![sink_for(&path, &options).unwrap()];
            let mut begun = false;
            let outcome = Recorder::begin(&mut sim, sinks, Some(0.001), None).and_then(|mut recorder| {
                begun = true;
                for _ in 0..40 {
                    sim.step(0.001).unwrap();
                    recorder.offer(&mut sim)?;
                }
                recorder.finish(&mut sim)
            });
            let error = outcome.unwrap_err().to_string();
            assert!(error.contains(&format!("full.{ending}")) && error.contains("No space left"), "{error}");
            // What fails at once keeps the simulation from starting.
            assert!(!keep_going || !begun || (sim.time() - 0.04).abs() < 1e-12, "{ending}: the simulation stopped at {}", sim.time());
        }
    }
}

#[test]
fn a_file_cut_anywhere_is_read_up_to_there_and_repaired() {
    let folder = tempfile::tempdir().unwrap();
    for ending in ["mcap", "rrd"] {
        let whole = folder.path().join(format!("whole.{ending}"));
        let mut sim = simulation("cantilever.toml", &[]);
        record(&mut sim, &whole, 0.02, 2.0, &Options::default());
        let bytes = std::fs::read(&whole).unwrap();
        let all = frames(&whole);
        assert_eq!(record::repair(&whole).unwrap(), Repair::NotNeeded);
        // One hundred places, the first of them behind the head of the file.
        let mut most = 0;
        for k in 0..100 {
            let cut = folder.path().join(format!("cut.{ending}"));
            let length = bytes.len() / 10 + (bytes.len() - bytes.len() / 10 - 1) * k / 99;
            std::fs::write(&cut, &bytes[..length]).unwrap();
            assert_eq!(record::repair(&cut).unwrap(), Repair::Done, "{ending} cut at {length} of {}", bytes.len());
            assert!(Recording::open(&cut).unwrap().is_whole());
            let found = frames(&cut);
            assert!(found == all[..found.len()], "{ending} cut at {length}");
            assert!(found.len() >= most, "{ending}: a longer file has more");
            most = found.len();
        }
        assert_eq!(most, all.len());
    }
}

#[test]
fn a_recording_that_is_being_written_is_left_alone() {
    let folder = tempfile::tempdir().unwrap();
    for ending in ["mcap", "rrd"] {
        let path = folder.path().join(format!("live.{ending}"));
        let mut sim = simulation("bar_1d_vibration.toml", &[]);
        let recorder = Recorder::begin(&mut sim, vec![sink_for(&path, &Options::default()).unwrap()], None, None).unwrap();
        // The thread flushes within half a second.
        let begun = std::time::Instant::now();
        while Recording::open(&path).is_err() && begun.elapsed().as_secs() < 20 {
            std::thread::sleep(std::time::Duration::from_millis(50));
        }
        assert_eq!(record::repair(&path).unwrap(), Repair::BeingWritten);
        let busy = sink_for(&path, &Options { force: true, ..Options::default() }).unwrap();
        let mut other = simulation("bar_1d_vibration.toml", &[]);
        assert!(matches!(Recorder::begin(&mut other, vec![busy], None, None).err().unwrap(), RecordError::Busy { .. }));
        recorder.finish(&mut sim).unwrap();
        assert_eq!(record::repair(&path).unwrap(), Repair::NotNeeded);
    }
}

#[test]
fn a_restart_from_a_snapshot_gives_the_same_bytes() {
    let folder = tempfile::tempdir().unwrap();
    for ending in ["mcap", "rrd"] {
        let path = folder.path().join(format!("run.{ending}"));
        let mut whole = simulation("box_on_beam.toml", &[("grid.cell", "0.5"), ("time.step", "0.000625")]);
        let options = Options { snapshots: Some(0.1), ..Options::default() };
        let mut sink = sink_for(&path, &options).unwrap();
        record::run(&mut whole, 0.4, &mut [&mut *sink], &mut |_| {}).unwrap();
        let (scene, snapshot) = Recording::open(&path).unwrap().snapshot(0.2).unwrap();
        let mut rest = scene.build().unwrap();
        rest.restore(&snapshot.bytes).unwrap();
        assert!((rest.time() - 0.2).abs() < 1e-12);
        record::run(&mut rest, 0.4, &mut [], &mut |_| {}).unwrap();
        assert!(rest.save() == whole.save(), "{ending}");
        let error = Recording::open(&path).unwrap().snapshot(0.25).unwrap_err().to_string();
        assert!(error.contains("0.1") && error.contains("0.4"), "{error}");
    }
}

/// A block that flies freely.
fn flying(speed: f64, cell: f64, per_cell: usize) -> Simulation {
    let text = format!(
        r#"
        title = "flying"
        dimension = 2
        grid = {{ origin = [-2, -1], size = [6, 3], cell = {cell} }}
        material.soft = {{ law = "linear_elastic", young = 1, density = 1 }}
        body.bar = {{ material = "soft", shape = {{ box = {{ min = [0, 0], max = [2, 1] }} }}, particles_per_cell = {per_cell}, velocity = [{speed}, 0] }}
        time = {{ end = 0.1, step = 0.001 }}
        "#
    );
    Scene::from_toml(&text).unwrap().build().unwrap()
}

#[test]
fn comparing_gives_zero_with_itself_and_the_right_error_with_another_resolution() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    let options = Options { precision: Precision::Double, ..Options::default() };
    record(&mut flying(0.1, 0.25, 2), &path("a.mcap"), 0.01, 0.1, &options);
    record(&mut flying(0.1, 0.125, 3), &path("same.rrd"), 0.01, 0.1, &options);
    record(&mut flying(0.3, 0.2, 2), &path("more.mcap"), 0.01, 0.1, &options);

    let itself = compare(&path("a.mcap"), &path("a.mcap")).unwrap();
    assert!(itself.same_particles && itself.unmatched == 0 && itself.columns.len() == 4);
    assert!(itself.columns.iter().all(|c| c.3.len() == 11 && c.3.iter().all(|d| d.rms == 0.0 && d.largest == 0.0)));

    // One component of two differs, by 0.2 m/s x 0.1 s.
    let displacement = |first: &str, second: &str| compare(&path(first), &path(second)).unwrap().columns[0].3[10];
    let (same, more) = (displacement("a.mcap", "same.rrd"), displacement("a.mcap", "more.mcap"));
    assert!(same.rms < 1e-12 && (more.largest - 0.02).abs() < 1e-12 && (more.rms - 0.02 / 2f64.sqrt()).abs() < 1e-12, "{same:?} {more:?}");

    // Where the solution is known: the difference of a coarse and a fine run is the error of the coarse one, give or take that of the fine one.
    let mut errors = Vec::new();
    for (name, cell) in [("coarse.mcap", "3.125"), ("fine.rrd", "0.390625")] {
        let mut sim = simulation("bar_1d_vibration.toml", &[("grid.cell", cell)]);
        record(&mut sim, &path(name), 0.25, 3.0, &options);
        errors.push(sim.get("error/displacement").unwrap()[0]);
    }
    let apart = compare(&path("coarse.mcap"), &path("fine.rrd")).unwrap().columns[0].3[12].rms;
    println!("errors of two resolutions {:.4e} and {:.4e} m, apart by {apart:.4e} m", errors[0], errors[1]);
    assert!(errors[0] > 5.0 * errors[1] && (apart - errors[0]).abs() <= 1.01 * errors[1], "{errors:?} {apart}");

    let mut other = simulation("bar_1d_vibration.toml", &[]);
    record(&mut other, &path("bar.mcap"), 0.01, 0.02, &options);
    assert!(compare(&path("a.mcap"), &path("bar.mcap")).unwrap_err().to_string().contains("dimension"));
}

#[test]
fn replay_keeps_every_frame() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    let mut sim = simulation("cantilever.toml", &[]);
    record(&mut sim, &path("a.mcap"), 0.02, 0.2, &Options::default());
    for (from, to) in [("a.mcap", "b.rrd"), ("b.rrd", "c.mcap"), ("a.mcap", "d.pvd")] {
        record::replay(Recording::open(&path(from)).unwrap(), &path(to), false).unwrap();
    }
    assert!(frames(&path("a.mcap")).iter().map(|f| (f.time, &f.values)).eq(frames(&path("c.mcap")).iter().map(|f| (f.time, &f.values))));
    assert_eq!(std::fs::read_dir(path("d")).unwrap().count(), 11);
    let list = std::fs::read_to_string(path("d.pvd")).unwrap();
    assert!(list.contains("timestep=\"0.2\" file=\"d/0010.vtu\""), "{list}");
}

#[test]
fn frames_are_dropped_and_counted_where_that_is_asked_for() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.mcap");
    let mut sim = simulation("falling_block_3d.toml", &[]);
    let options =
        Options { when_full: Some(WhenFull::Drop), variables: Some(vec!["stress".into(), "strain".into()]), ..Options::default() };
    let mut recorder = Recorder::begin(&mut sim, vec![sink_for(&path, &options).unwrap()], Some(1e-9), Some(1.0)).unwrap();
    for _ in 0..300 {
        sim.step(1e-6).unwrap();
        recorder.offer(&mut sim).unwrap();
    }
    let dropped = recorder.dropped();
    recorder.finish(&mut sim).unwrap();
    println!("{dropped} of 301 frames dropped");
    let kept = frames(&path).len() as u64;
    assert_eq!(kept + dropped, 301);
    let told = items(&path).into_iter().any(|item| matches!(item, Item::Event(Event { level: Level::Warning, .. })));
    assert_eq!(told, dropped > 0);
}

#[test]
fn a_step_that_fails_is_told_in_the_recording() {
    let folder = tempfile::tempdir().unwrap();
    let text = r#"
        title = "flies away"
        dimension = 2
        grid = { origin = [0, 0], size = [4, 2], cell = 0.25 }
        material.soft = { law = "neo_hookean", young = 1e4, density = 1000 }
        body.block = { material = "soft", shape = { box = { min = [0.25, 0.5], max = [1, 1.5] } }, velocity = [10, 0] }
        time = { end = 1 }
        record = { every = 0.05 }"#;
    for ending in ["mcap", "rrd"] {
        let path = folder.path().join(format!("lost.{ending}"));
        let mut sim = Scene::from_toml(text).unwrap().build().unwrap();
        let mut sink = sink_for(&path, &Options::default()).unwrap();
        record::run(&mut sim, 1.0, &mut [&mut *sink], &mut |_| {}).unwrap_err();
        let told = items(&path).into_iter().find_map(|item| if let Item::Event(event) = item { Some(event) } else { None }).unwrap();
        assert!(told.level == Level::Error && told.text.contains("left the grid"), "{told:?}");
        assert!(Recording::open(&path).unwrap().is_whole());
    }
}

#[test]
fn frames_come_every_so_many_substeps() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.mcap");
    // Fixed steps: exactly so many, and the last one.
    let mut sim = simulation("falling_block_3d.toml", &[("time.step", "0.001"), ("record", "{ every_steps = 7 }")]);
    let mut sink = sink_for(&path, &Options::default()).unwrap();
    record::run(&mut sim, 0.03, &mut [&mut *sink], &mut |_| {}).unwrap();
    assert_eq!(frames(&path).iter().map(|f| f.step).collect::<Vec<_>>(), [0, 7, 14, 21, 28, 30]);
    // Steps that adapt: the first stop after so many.
    let mut sim = simulation("cantilever.toml", &[("record", "{ every_steps = 20 }")]);
    let mut sink = sink_for(&path, &Options { force: true, ..Options::default() }).unwrap();
    record::run(&mut sim, 0.2, &mut [&mut *sink], &mut |_| {}).unwrap();
    let steps: Vec<u64> = frames(&path).iter().map(|f| f.step).collect();
    assert!(steps.len() > 4 && steps[..steps.len() - 1].windows(2).all(|pair| (20..=22).contains(&(pair[1] - pair[0]))), "{steps:?}");
}
