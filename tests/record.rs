//! Recordings stop where the scene says, do not change the result, and stay valid when a run fails.

#![expect(clippy::unwrap_used, reason = "a test may")]

use matpoint::Simulation;
use matpoint::record::{CsvSink, EnergyWatch, PictureSink, RecordError, Recorder, RunError, Sink, run};
use matpoint::scene::Scene;
use std::path::{Path, PathBuf};

fn scene_file(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("launch_scripts/scenes").join(name)
}

fn simulation(name: &str, overrides: &[(&str, &str)]) -> Simulation {
    let overrides: Vec<(String, String)> = overrides.iter().map(|&(key, value)| (key.to_owned(), value.to_owned())).collect();
    Scene::load_with(scene_file(name), &overrides).unwrap().build().unwrap()
}

/// A block that flies out of its grid after about 0.3 s.
const LOST: &str = r#"
title = "fails: flies away"
dimension = 2
grid = { origin = [0, 0], size = [4, 2], cell = 0.25 }
material.soft = { law = "neo_hookean", young = 1e4, density = 1000 }
body.block = { material = "soft", shape = { box = { min = [0.25, 0.5], max = [1, 1.5] } }, velocity = [10, 0] }
time = { end = 1 }
record = { every = 0.05 }
"#;

fn lost(folder: &Path) -> Simulation {
    let path = folder.join("lost.toml");
    std::fs::write(&path, LOST).unwrap();
    Scene::load_with(path, &[]).unwrap().build().unwrap()
}

/// Notes when it was called.
#[derive(Default)]
struct Times {
    frames: Vec<f64>,
    rows: Vec<f64>,
    finished: bool,
}

impl Sink for Times {
    fn begin(&mut self, _: &mut Simulation) -> Result<(), RecordError> {
        Ok(())
    }
    fn frame(&mut self, sim: &mut Simulation, _: u64) -> Result<(), RecordError> {
        self.frames.push(sim.time());
        Ok(())
    }
    fn history(&mut self, sim: &mut Simulation, _: u64) -> Result<(), RecordError> {
        self.rows.push(sim.time());
        Ok(())
    }
    fn finish(&mut self, _: &mut Simulation) -> Result<(), RecordError> {
        self.finished = true;
        Ok(())
    }
}

/// A CSV table: the header and the rows, every row as long as the header.
fn table(path: &Path) -> (Vec<String>, Vec<Vec<String>>) {
    let text = std::fs::read_to_string(path).unwrap();
    let mut lines = text.lines().map(|line| line.split(',').map(str::to_owned).collect::<Vec<_>>());
    let header = lines.next().unwrap();
    let rows: Vec<_> = lines.collect();
    assert!(rows.iter().all(|row| row.len() == header.len()), "{}", path.display());
    (header, rows)
}

fn names(folder: &Path) -> Vec<String> {
    let mut names: Vec<_> = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    names
}

#[test]
fn record_times_do_not_drift() {
    let mut sim = simulation("bar_1d_vibration.toml", &[("record.every", "0.03"), ("record.history", "0.01")]);
    let (mut times, mut calls) = (Times::default(), 0);
    let summary = run(&mut sim, 0.5, &mut [&mut times], &mut |_| calls += 1).unwrap();
    assert_eq!((times.rows.len(), times.frames.len(), calls), (51, 18, 51));
    for (k, time) in times.rows.iter().enumerate() {
        // one round-off of `time + (stop - time)`
        assert!((time - 0.01 * k as f64).abs() <= f64::EPSILON, "row {k} at {time}");
    }
    assert_eq!((sim.time(), summary.end, times.frames.last()), (0.5, 0.5, Some(&0.5)));
    assert!(times.finished);
}

#[test]
fn a_loop_of_somebody_else_is_recorded_when_due() {
    let mut sim = simulation("bar_1d_vibration.toml", &[]);
    let mut times = Times::default();
    let mut recorder = Recorder::begin(&mut sim, vec![Box::new(&mut times)], Some(0.1), Some(0.02)).unwrap();
    for _ in 0..33 {
        sim.step(0.03).unwrap();
        recorder.offer(&mut sim).unwrap();
    }
    recorder.finish(&mut sim).unwrap();
    let close = |times: &[f64], wanted: &[f64]| times.len() == wanted.len() && times.iter().zip(wanted).all(|(a, b)| (a - b).abs() < 1e-12);
    // the first step at or after each multiple of 0.1, and the end
    assert!(close(&times.frames, &[0.0, 0.12, 0.21, 0.3, 0.42, 0.51, 0.6, 0.72, 0.81, 0.9, 0.99]), "{:?}", times.frames);
    // every step leaps over a multiple of 0.02
    assert_eq!(times.rows.len(), 34);
    assert!(times.finished);
}

#[test]
fn result_does_not_depend_on_who_listens() {
    let folder = tempfile::tempdir().unwrap();
    let end = |sinks: &mut [&mut dyn Sink]| {
        let mut sim = simulation("cantilever.toml", &[]);
        run(&mut sim, 0.1, sinks, &mut |_| {}).unwrap();
        sim.get("particle/position").unwrap().iter().map(|v| v.to_bits()).collect::<Vec<_>>()
    };
    let mut csv = CsvSink::new(folder.path());
    let mut watch = EnergyWatch::default();
    assert!(end(&mut []) == end(&mut [&mut csv, &mut watch]));
}

#[test]
fn tables_name_component_and_unit() {
    let folder = tempfile::tempdir().unwrap();
    let mut sim = simulation("cantilever.toml", &[]);
    let mut csv = CsvSink::new(folder.path().join("new/tables"));
    run(&mut sim, 0.1, &mut [&mut csv], &mut |_| {}).unwrap();
    let folder = folder.path().join("new/tables");
    assert_eq!(csv.files(), [folder.join("history.csv"), folder.join("particles.csv")]);
    assert_eq!(names(&folder), ["history.csv", "particles.csv"]);

    let (header, rows) = table(&folder.join("history.csv"));
    assert_eq!(header[0], "time_s");
    assert!(header[1].starts_with("energy_kinetic_J"), "{header:?}");
    for name in ["probe_tip_displacement_y_m", "probe_tip_velocity_x_m_per_s", "probe_tip_stress_xy_Pa"] {
        assert!(header.iter().any(|column| column == name), "no {name} in {header:?}");
    }
    assert!(header.iter().any(|column| column.starts_with("boundary_root_reaction_x_")));
    assert_eq!((rows.len(), rows[0][0].as_str(), rows[5][0].as_str()), (6, "0.0", "0.1"));
    // what is read back is what was computed, to the last bit
    let column = header.iter().position(|column| column == "probe_tip_displacement_y_m").unwrap();
    assert_eq!(rows[5][column].parse::<f64>().unwrap(), sim.get("probe/tip/displacement").unwrap()[1]);

    let (header, rows) = table(&folder.join("particles.csv"));
    assert_eq!(header[..4], ["id", "body", "position_x_m", "position_y_m"]);
    assert_eq!(header[header.len() - 2..], ["stress_xy_Pa", "von_mises_Pa"]);
    assert_eq!((rows.len(), rows[0][1].as_str()), (1152, "beam"));
}

#[test]
fn known_solutions_give_error_columns() {
    let folder = tempfile::tempdir().unwrap();
    let mut sim = simulation("bar_1d_vibration.toml", &[]);
    run(&mut sim, 0.1, &mut [&mut CsvSink::new(folder.path())], &mut |_| {}).unwrap();
    let (header, _) = table(&folder.path().join("history.csv"));
    for name in ["error_displacement_rms_m", "error_displacement_max_m"] {
        assert!(header.iter().any(|column| column == name), "no {name} in {header:?}");
    }
}

#[test]
fn failed_run_leaves_valid_recordings() {
    let folder = tempfile::tempdir().unwrap();
    let mut sim = lost(folder.path());
    let mut csv = CsvSink::new(folder.path().join("tables"));
    let mut picture = PictureSink::new(folder.path().join("last.svg"));
    let mut times = Times::default();
    let error = run(&mut sim, 1.0, &mut [&mut csv, &mut picture, &mut times], &mut |_| {}).unwrap_err();
    assert!(matches!(error, RunError::Step(_)), "{error}");
    assert!(times.finished);
    let (_, rows) = table(&folder.path().join("tables/history.csv"));
    let last: f64 = rows.last().unwrap()[0].parse().unwrap();
    assert!(rows.len() > 2 && last < 1.0 && last == sim.time(), "{} rows, the last at {last}", rows.len());
    assert_eq!(names(&folder.path().join("tables")), ["history.csv", "particles.csv"]);
    assert!(std::fs::read_to_string(folder.path().join("last.svg")).unwrap().ends_with("</svg>\n"));
}

#[test]
fn path_that_cannot_be_written_is_found_before_the_first_step() {
    let folder = tempfile::tempdir().unwrap();
    let mut sim = simulation("cantilever.toml", &[]);
    {
        let mut csv = CsvSink::new(folder.path());
        let mut picture = PictureSink::new(folder.path().join("missing/last.svg"));
        let error = run(&mut sim, 0.1, &mut [&mut csv, &mut picture], &mut |_| {}).unwrap_err();
        assert!(matches!(error, RunError::Begin(RecordError::Write { .. })), "{error}");
        assert!(error.to_string().contains("missing/last.svg"), "{error}");
    }
    assert_eq!(sim.time(), 0.0);
    assert!(names(folder.path()).is_empty());
}

#[test]
fn pictures_in_every_dimension() {
    let folder = tempfile::tempdir().unwrap();
    for (name, expected) in [
        ("bar_1d_vibration.toml", ["displacement [", "left: x fixed"]),
        ("prescribed_pull.toml", ["von Mises stress [", "grip: y fixed; x moved"]),
        ("falling_block_3d.toml", ["z [m]", "floor: z fixed"]),
    ] {
        let path = folder.path().join(name).with_extension("svg");
        let mut picture = PictureSink::new(&path);
        run(&mut simulation(name, &[]), 0.01, &mut [&mut picture], &mut |_| {}).unwrap();
        let svg = std::fs::read_to_string(&path).unwrap();
        assert!(svg.starts_with("<svg") && svg.ends_with("</svg>\n"));
        assert!(!svg.contains("NaN") && !svg.contains("inf"), "{name}");
        for text in expected {
            assert!(svg.contains(text), "{name}: no {text}");
        }
    }
}
