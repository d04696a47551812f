//! Guards the number of instructions of a step: that of small scenes, counted by valgrind, against `instructions.toml`. Times on a shared
//! machine tell a loss of a few per cent from noise only after many runs; instructions are the same in each.
//!
//! `cargo bench --bench instructions` compares, with `-- --accept` it writes the numbers of now. Two runs with different numbers of steps are
//! counted, and their difference is taken: what happens before the first step cancels. Valgrind has no AVX-512, so that the kernels run with
//! AVX2.
//!
//! Counts are those of a build with the default features, as `tests/run` makes it: with others the compiler puts the same code together otherwise
//! (measured: up to 6 %).
//!
//! It also holds that what a scene declares and does not use costs nothing, and room where nothing is: the block with it against the block.

#![expect(clippy::unwrap_used, reason = "a benchmark may")]

use matpoint::record::{Options, Recorder, sink_for};
use matpoint::scene::Scene;
use std::collections::BTreeMap;
use std::path::Path;
use std::process::{Command, ExitCode};

const SCENES: [(&str, &str); 3] = [
    ("cantilever", include_str!("scenes/cantilever.toml")),
    ("block", include_str!("scenes/block.toml")),
    ("total", include_str!("scenes/total.toml")),
];

/// The scene to which something idle is added.
const PLAIN: (&str, &str) = ("block", include_str!("scenes/block.toml"));

/// What is added to it, and has nothing to do: a line of the scene before that which begins so, room around the body, or a recording whose
/// next frame is far.
const IDLE: [(&str, &str, &str); 5] = [
    ("idle probe", "material", "probe.corner = { at = [0.7, 0.7, 0.7] }\nmaterial"),
    ("idle traction", "boundary", "load.end.traction = { body = \"block\", face = \"x+\", value = \"external\" }\nboundary"),
    ("idle boundary", "boundary", "boundary.far = { face = \"x+\", fixed = [\"x\"] }\nboundary"),
    ("domain 1,000 times larger", "size = [1, 1, 1]", "size = [10, 10, 10]"),
    (RECORDING, "", ""),
];
const RECORDING: &str = "idle recording";

/// How many times the instructions of the block what is idle may take.
const MOST: f64 = 1.01;

/// Steps of the two runs.
const STEPS: [u64; 2] = [10, 60];

/// How far a count may be from the known one. Counts of one program are the same to a few in a million; another patch release of the compiler, or
/// of a library that is linked, moves them by up to a per cent. What is gained beyond it is to be accepted too, so that it is not lost again.
const TOLERANCE: f64 = 0.02;

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    if let [option, scene, steps] = &arguments[..]
        && option == "--run"
    {
        run(scene, steps.parse().unwrap());
        return ExitCode::SUCCESS;
    }
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("benches/instructions.toml");
    let counts: BTreeMap<&str, u64> = SCENES.iter().map(|(name, _)| (*name, each(name))).collect();
    if arguments.iter().any(|argument| argument == "--accept") {
        let lines: String = counts.iter().map(|(name, count)| format!("{name} = {count}\n")).collect();
        let text = format!("# Instructions of a step, written by `cargo bench --bench instructions -- --accept`.\n{lines}");
        std::fs::write(&file, text).unwrap();
        println!("wrote {}", file.display());
        return ExitCode::SUCCESS;
    }
    let known: BTreeMap<String, u64> = toml::from_str(&std::fs::read_to_string(&file).unwrap()).unwrap();
    let mut far = 0;
    for (name, count) in counts {
        let change = known.get(name).map(|known| count as f64 / *known as f64 - 1.0);
        let verdict = match change {
            Some(change) if change.abs() <= TOLERANCE => "as known",
            Some(_) => "TOO FAR",
            None => "NOT KNOWN",
        };
        far += usize::from(verdict != "as known");
        println!("{name:12} {count:>9} instructions a step, {:+.2} %: {verdict}", 100.0 * change.unwrap_or(f64::NAN));
    }
    if far > 0 {
        println!(
            "{far} of {} are more than {} % off; if that is right: cargo bench --bench instructions -- --accept",
            SCENES.len(),
            100.0 * TOLERANCE
        );
    }
    let plain = each(PLAIN.0) as f64;
    for (name, ..) in IDLE {
        let times = each(name) as f64 / plain;
        println!("{:12} {times:.5} times the {}: {name}{}", "", PLAIN.0, if times <= MOST { "" } else { ": TOO MUCH" });
        far += usize::from(times > MOST);
    }
    if far == 0 { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}

/// Instructions of a step of a scene.
fn each(scene: &str) -> u64 {
    let [few, many] = STEPS.map(|steps| count(scene, steps));
    (many - few) / (STEPS[1] - STEPS[0])
}

/// Instructions of a process that takes so many steps.
fn count(scene: &str, steps: u64) -> u64 {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("callgrind");
    let output = Command::new("valgrind")
        .args(["--tool=callgrind", "--quiet", &format!("--callgrind-out-file={}", out.display())])
        .arg(std::env::current_exe().unwrap())
        .args(["--run", scene, &steps.to_string()])
        .env("RAYON_NUM_THREADS", "1")
        .output()
        .expect("valgrind, which counts, is a package of that name");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let text = std::fs::read_to_string(out).unwrap();
    let summary = text.lines().find_map(|line| line.strip_prefix("totals:").or_else(|| line.strip_prefix("summary:")));
    summary.and_then(|number| number.trim().parse().ok()).expect("the total of callgrind")
}

/// What is counted: a call of `step` for each substep, offered to a recording where one is idle.
fn run(name: &str, steps: u64) {
    let idle = IDLE.iter().find(|idle| idle.0 == name).map(|(_, from, to)| PLAIN.1.replacen(from, to, 1));
    let text = idle.unwrap_or_else(|| SCENES.iter().find(|scene| scene.0 == name).unwrap().1.to_owned());
    let mut sim = Scene::from_toml(&text).and_then(Scene::build).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let mut recorder = (name == RECORDING).then(|| {
        let sink = sink_for(&folder.path().join("idle.pvd"), &Options::default()).unwrap();
        Recorder::begin(&mut sim, vec![sink], Some(1e6), None).unwrap()
    });
    let dt = sim.usual_step();
    for _ in 0..steps {
        sim.step(dt).unwrap();
        if let Some(recorder) = &mut recorder {
            recorder.offer(&mut sim).unwrap();
        }
    }
}
