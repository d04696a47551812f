//! The command line: what it prints, what it writes, how it ends.

#![expect(clippy::unwrap_used, reason = "a test may")]

use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

fn matpoint(args: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_matpoint")).args(args).output().unwrap()
}

fn stdout(output: &Output) -> String {
    String::from_utf8(output.stdout.clone()).unwrap()
}

fn stderr(output: &Output) -> String {
    String::from_utf8(output.stderr.clone()).unwrap()
}

/// Runs it, expects it to end well, gives what it printed.
fn good(args: &[&str]) -> String {
    let output = matpoint(args);
    assert_eq!(output.status.code(), Some(0), "{args:?}: {}", stderr(&output));
    assert_eq!(stderr(&output), "", "{args:?}");
    stdout(&output)
}

/// Runs it, expects it to end with `code`, gives what it complained about.
fn bad(code: i32, args: &[&str]) -> String {
    let output = matpoint(args);
    assert_eq!(output.status.code(), Some(code), "{args:?}: {}{}", stdout(&output), stderr(&output));
    assert!(!stderr(&output).contains("panicked"), "{}", stderr(&output));
    stderr(&output)
}

fn scene(name: &str) -> String {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("launch_scripts/scenes").join(name);
    path.to_str().unwrap().to_owned()
}

fn scenes() -> Vec<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("launch_scripts/scenes");
    let mut all: Vec<_> = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    all.retain(|path| path.extension().is_some_and(|ending| ending == "toml"));
    all.sort();
    assert!(all.len() >= 5);
    all
}

/// A block that flies out of its grid.
const LOST: &str = r#"
title = "fails: flies away"
dimension = 2
grid = { origin = [0, 0], size = [4, 2], cell = 0.25 }
material.soft = { law = "neo_hookean", young = 1e4, density = 1000 }
body.block = { material = "soft", shape = { box = { min = [0.25, 0.5], max = [1, 1.5] } }, velocity = [10, 0] }
time = { end = 1 }
record = { every = 0.05 }
"#;

#[test]
fn every_command_helps_with_examples() {
    for args in [
        &["--help"][..],
        &["run", "--help"],
        &["check", "--help"],
        &["inspect", "--help"],
        &["replay", "--help"],
        &["describe", "--help"],
        &["schema", "--help"],
        &["study", "throughput", "--help"],
    ] {
        let help = good(args);
        assert!(help.contains("Examples:\n  matpoint "), "{args:?}: {help}");
    }
    assert!(good(&["--version"]).starts_with("matpoint "));
    assert!(bad(2, &[]).contains("Usage:"));
}

#[test]
fn run_records_and_sums_up() {
    let folder = tempfile::tempdir().unwrap();
    let file = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let (csv, svg) = (file("tables"), file("last.svg"));
    let text = good(&["run", &scene("cantilever.toml"), "--until", "0.1", "--csv", &csv, "--picture", &svg]);
    assert!(text.starts_with("Rubber cantilever under a tip load\n"), "{text}");
    for line in ["time ", "particles ", "steps ", "wall time ", "energy ", "energy drift ", "momentum ", "wrote "] {
        assert!(text.lines().any(|found| found.trim_start().starts_with(line)), "no {line} in {text}");
    }
    assert!(text.contains("0.1 s") && text.contains("1 152") && text.contains("particle-steps/s"), "{text}");
    let history = std::fs::read_to_string(folder.path().join("tables/history.csv")).unwrap();
    assert!(history.starts_with("time_s,energy_kinetic_") && history.lines().last().unwrap().starts_with("0.1,"));
    assert!(std::fs::read_to_string(svg).unwrap().contains("von Mises stress"));
}

#[test]
fn run_tells_errors_where_the_solution_is_known() {
    let text = good(&["run", &scene("bar_1d_vibration.toml"), "--until", "0.1", "--quiet"]);
    assert!(text.contains("displacement error") && text.contains("RMS"), "{text}");
    assert!(text.contains("nothing recorded"), "{text}");
}

#[test]
fn result_does_not_depend_on_the_number_of_threads() {
    let folder = tempfile::tempdir().unwrap();
    let table = |threads: &str| {
        let csv = folder.path().join(threads);
        good(&["run", &scene("cantilever.toml"), "--until", "0.05", "--threads", threads, "--csv", csv.to_str().unwrap()]);
        std::fs::read(csv.join("particles.csv")).unwrap()
    };
    assert!(table("1") == table("2"));
}

#[cfg(feature = "rerun")]
#[test]
fn recording_for_rerun() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("beam.rrd");
    let text = good(&["run", &scene("cantilever.toml"), "--until", "0.1", "--record", path.to_str().unwrap()]);
    assert!(text.contains(&format!("open with: rerun {}", path.display())), "{text}");
    assert!(std::fs::read(&path).unwrap().starts_with(b"RRF"));
    let run = path.to_str().unwrap();
    let text = bad(2, &["run", &scene("cantilever.toml"), "--until", "0.1", "--record", run]);
    assert!(text.contains("exists") && text.contains("--force"), "{text}");
    let text = good(&["inspect", run]);
    for part in ["Rubber cantilever", "1 152", "frames, rows  6, 6", "energy drift", "B-splines", "probe/tip/stress", "0 to 0.1 s"] {
        assert!(text.contains(part), "no {part} in {text}");
    }
    let table = good(&["inspect", run, "--csv", "probe/tip/displacement"]);
    assert!(
        table.starts_with("time_s,probe_tip_displacement_x_m,probe_tip_displacement_y_m\n0.0,") && table.lines().count() == 7,
        "{table}"
    );
    assert!(good(&["inspect", run, "--csv", "von_mises"]).lines().count() == 6 * 1152 + 1);
    assert!(bad(2, &["inspect", run, "--csv", "von_mise"]).contains("did you mean `von_mises`"));
    assert!(bad(2, &["inspect", "Cargo.toml"]).contains("cannot be read back"));
}

/// A limit on the size of files stands for a disk that fills up in the middle of a run.
#[cfg(all(target_os = "linux", feature = "mcap"))]
#[test]
fn a_disk_that_fills_up_stops_the_run_or_not_as_asked() {
    let folder = tempfile::tempdir().unwrap();
    for more in ["", "--keep-going"] {
        let (run, tables) = (folder.path().join(format!("run{more}.mcap")), folder.path().join(format!("tables{more}")));
        let command = format!(
            "trap '' XFSZ; ulimit -f 300; exec {} run {} --until 4 --quiet --record {} --csv {} {more}",
            env!("CARGO_BIN_EXE_matpoint"),
            scene("cantilever.toml"),
            run.display(),
            tables.display(),
        );
        let output = Command::new("bash").args(["-c", &command]).output().unwrap();
        assert_eq!(output.status.code(), Some(1), "{}{}", stdout(&output), stderr(&output));
        let said = stderr(&output);
        assert!(said.contains("File too large") && said.contains(".mcap") && !said.contains("panicked"), "{said}");
        let history = std::fs::read_to_string(tables.join("history.csv")).unwrap();
        let reached: f64 = history.lines().last().unwrap().split(',').next().unwrap().parse().unwrap();
        assert_eq!(reached == 4.0, more == "--keep-going", "{more}: {reached}");
        let text = good(&["inspect", run.to_str().unwrap()]);
        assert!(text.contains("was cut off; all that could be read has its index again"), "{text}");
    }
}

#[cfg(all(feature = "mcap", feature = "rerun", feature = "png"))]
#[test]
fn recordings_are_drawn_compared_replayed_and_gone_on_from() {
    let folder = tempfile::tempdir().unwrap();
    let file = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let beam = scene("cantilever.toml");
    good(&["run", &beam, "--until", "0.2", "--record", &file("a.mcap"), "--snapshots", "0.1", "--csv", &file("whole")]);
    assert!(good(&["inspect", &file("a.mcap")]).contains("at 0.1, 0.2 s"));

    good(&["inspect", &file("a.mcap"), "--png", &file("a.png"), "--frames", "4"]);
    assert!(std::fs::read(file("a.png")).unwrap().starts_with(b"\x89PNG"));
    let said = good(&["inspect", &file("a.mcap"), "--compare", &file("a.mcap")]);
    assert!(said.contains("displacement [m]") && said.contains("0.2       0               0"), "{said}");

    good(&["replay", &file("a.mcap"), "--to", "rrd"]);
    assert!(good(&["inspect", &file("a.rrd")]).contains("frames, rows  11, 11"));
    assert!(bad(2, &["replay", &file("a.mcap"), "--to", "rrd"]).contains("--force"));
    assert!(bad(2, &["replay", &file("a.mcap"), "--to", "rrd", "--", "--loop"]).contains("--to ros2 only"));
    assert!(bad(2, &["replay", &file("a.mcap"), "--to", "mcap"]).contains("itself"));

    // The rest of the run gives the same bytes as the run that was not cut.
    good(&["run", "--from", &format!("{}@0.1", file("a.mcap")), "--until", "0.2", "--csv", &file("rest")]);
    assert!(std::fs::read(file("rest/particles.csv")).unwrap() == std::fs::read(file("whole/particles.csv")).unwrap());
    assert!(bad(2, &["run", "--from", &format!("{}@0.15", file("a.mcap"))]).contains("no snapshot at 0.15 s"));
    assert!(bad(2, &["run", "--from", "a.mcap"]).contains("RUN@TIME"));
}

#[cfg(unix)]
#[test]
fn publishing_is_done_by_the_node_if_there_is_one() {
    // A name of its own for the program, so that nothing is beside it; a link, as a file that was just written may be busy.
    let folder = tempfile::tempdir_in(env!("CARGO_TARGET_TMPDIR")).unwrap();
    let program = folder.path().join("matpoint");
    std::fs::hard_link(env!("CARGO_BIN_EXE_matpoint"), &program).unwrap();
    let replay = |variable: &str, value: &Path| {
        let mut command = Command::new(&program);
        command.env_remove("MATPOINT_NODE").env("PATH", "").env(variable, value);
        command.args(["replay", "beam.mcap", "--to", "ros2", "--", "--loop", "--ros-args"]).output().unwrap()
    };
    let none = replay("PATH", Path::new(""));
    assert_eq!(none.status.code(), Some(2), "{}", stderr(&none));
    for part in ["matpoint-node", "MATPOINT_NODE", "cargo build --release -p matpoint-ros2", "ros2 bag play RUN.mcap"] {
        assert!(stderr(&none).contains(part), "no {part} in {}", stderr(&none));
    }
    let wrong = replay("MATPOINT_NODE", &folder.path().join("nowhere"));
    assert_eq!(wrong.status.code(), Some(2));
    assert!(stderr(&wrong).contains("nowhere`: No such file"), "{}", stderr(&wrong));

    // Who stands for the node says what it was given.
    let handed = "--replay beam.mcap --loop --ros-args\n";
    assert_eq!(stdout(&replay("MATPOINT_NODE", Path::new("/bin/echo"))), handed);
    let bin = folder.path().join("bin");
    std::fs::create_dir(&bin).unwrap();
    std::os::unix::fs::symlink("/bin/echo", bin.join("matpoint-node")).unwrap();
    assert_eq!(stdout(&replay("PATH", &bin)), handed);
    std::os::unix::fs::symlink("/bin/false", folder.path().join("matpoint-node")).unwrap();
    assert_eq!(replay("PATH", &bin).status.code(), Some(1), "the one beside the program comes first, and its exit code is the program's");
}

#[cfg(not(feature = "rerun"))]
#[test]
fn recording_needs_the_feature() {
    assert!(bad(2, &["run", &scene("cantilever.toml"), "--record", "beam.rrd"]).contains("--features rerun"));
    assert!(bad(2, &["run", &scene("cantilever.toml"), "--record", "beam.bag"]).contains("recordings end in"));
}

#[test]
fn set_overrides_the_scene() {
    let coarse = good(&["describe", &scene("cantilever.toml"), "--set", "grid.cell=0.5", "--set", "title=\"coarse\""]);
    assert!(coarse.starts_with("coarse\n"), "{coarse}");
    // 16 x 2 cells with 3 x 3 particles each
    assert!(coarse.contains("particles    288\n"), "{coarse}");
}

#[test]
fn describe_lists_variables_and_method() {
    let text = good(&["describe", &scene("cantilever.toml"), "--set", "load.tip.traction.value=\"external\""]);
    for part in ["stable step", "memory", "\nmethod\n", "\nvariables\n"] {
        assert!(text.contains(part), "no {part} in {text}");
    }
    let line = |name: &str| text.lines().find(|line| line.trim_start().starts_with(name)).map(str::to_owned).unwrap_or_default();
    assert!(line("load/tip/traction").contains(" in "), "{text}");
    assert!(line("particle/stress").contains("1152 x 3 x 3"), "{text}");
}

#[test]
fn schema_is_json() {
    let schema: serde_json::Value = serde_json::from_str(&good(&["schema"])).unwrap();
    assert!(schema["properties"]["grid"].is_object());
}

#[test]
fn every_scene_is_sound_and_runs() {
    for path in scenes() {
        let path = path.to_str().unwrap();
        assert!(good(&["check", path]).contains("sound"), "{path}");
        let end = good(&["run", path, "--until", "0.02", "--set", "record.every=0.01"]);
        assert!(end.contains("0.02 s"), "{path}: {end}");
        // the first lines say what one sees and how
        let text = std::fs::read_to_string(path).unwrap();
        assert!(text.starts_with("# ") && text.contains("#   matpoint run launch_scripts/scenes/"), "{path}");
    }
}

#[test]
fn faults_end_with_2_and_write_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let csv = folder.path().join("tables");
    let (csv, beam) = (csv.to_str().unwrap(), scene("cantilever.toml"));
    let run = |more: &[&str]| bad(2, &[&["run", &beam, "--csv", csv], more].concat());
    assert!(run(&["--set", "material.rubber.poisson=0.7"]).contains("poisson"));
    assert!(run(&["--set", "nonsense"]).contains("KEY=VALUE"));
    assert!(run(&["--until", "-1"]).contains("positive"));
    assert!(run(&["--threads", "0"]).contains("threads"));
    assert!(run(&["--picture", "beam.jpg"]).contains("does not end in `.svg`"));
    assert!(run(&["--record", "beam.txt"]).contains("recordings end in"));
    assert!(bad(2, &["run", "missing.toml", "--csv", csv]).contains("missing.toml"));
    assert!(!Path::new(csv).exists());
    let nowhere = folder.path().join("missing/last.svg");
    let error = run(&["--picture", nowhere.to_str().unwrap()]);
    assert!(error.contains("cannot write") && error.contains("missing/last.svg"), "{error}");
    assert_eq!(std::fs::read_dir(csv).unwrap().count(), 0);
}

#[test]
fn failed_run_ends_with_1_and_says_where_and_what_next() {
    let folder = tempfile::tempdir().unwrap();
    let (path, csv) = (folder.path().join("lost.toml"), folder.path().join("tables"));
    std::fs::write(&path, LOST).unwrap();
    let error = bad(1, &["run", path.to_str().unwrap(), "--csv", csv.to_str().unwrap()]);
    for part in ["the run failed: at t = ", "particle ", " m; ", "recorded until then: ", "history.csv"] {
        assert!(error.contains(part), "no {part} in {error}");
    }
    let history = std::fs::read_to_string(csv.join("history.csv")).unwrap();
    assert!(history.lines().count() > 3);
}

#[test]
fn closed_pipe_is_no_failure() {
    let mut child =
        Command::new(env!("CARGO_BIN_EXE_matpoint")).arg("schema").stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    drop(child.stdout.take());
    let output = child.wait_with_output().unwrap();
    assert_eq!(stderr(&output), "");
    assert_eq!(output.status.code(), Some(0));
}

#[test]
fn faults_that_show_only_when_a_scene_is_built_have_a_place_too() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("lost.toml");
    std::fs::write(&file, LOST.replace("time = { end = 1 }", "time = { end = 1, step = 0.5 }")).unwrap();
    let said = bad(2, &["check", file.to_str().unwrap()]);
    assert!(said.contains("lost.toml:7:26: time.step: is 0.5 s, above the stable step"), "{said}");
    std::fs::write(&file, LOST.replace("velocity = [10, 0]", r#"velocity = ["sqrt(x-0.6)", 0]"#)).unwrap();
    let said = bad(2, &["check", file.to_str().unwrap()]);
    assert!(said.contains("lost.toml:6:") && said.contains("finite all over the body"), "{said}");
    std::fs::write(&file, format!("{LOST}[load.weight]\ngravity = [0, \"1/t\"]\n")).unwrap();
    let said = bad(2, &["check", file.to_str().unwrap()]);
    assert!(said.contains("lost.toml:10:") && said.contains("at t = 0"), "{said}");
}

#[test]
fn study_writes_a_report_and_knows_its_problems() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("docs");
    let text = good(&["study", "papers", "--quick", "--only", "t3,T4", "--out", out.to_str().unwrap()]);
    assert!(text.contains("T3 Column") && text.contains("T4 Column") && !text.contains("T1 ") && text.contains("papers.md"), "{text}");
    assert!(out.join("papers.md").exists() && out.join("papers/t4-motion.svg").exists() && out.join("papers/t4-motion.csv").exists());
    assert!(bad(2, &["study", "papers", "--only", "T99"]).contains("expected one of T1"));
}
