//! The study of throughput: what it writes. Figures are not judged here; a machine that is used for something else has others.

#![expect(clippy::unwrap_used, reason = "a test may")]

use std::io::{BufRead, BufReader, Write};
use std::path::Path;
use std::process::{Command, Output, Stdio};

fn study(args: &[&str], out: &Path) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_matpoint"));
    // away from what a race with other codes may have left
    command.args(["study", "throughput", "--quick", "--quiet", "--out", out.to_str().unwrap()]).args(args).current_dir(out);
    command.output().unwrap()
}

#[test]
fn writes_a_page_tables_and_a_picture() {
    let folder = tempfile::tempdir().unwrap();
    let output = study(&["--only", "machine,small,roofline"], folder.path());
    let said = String::from_utf8_lossy(&output.stdout);
    assert!(output.status.success(), "{said}{}", String::from_utf8_lossy(&output.stderr));
    assert!(said.contains("wrote 4 files") && !said.contains("did not end"), "{said}");
    let read = |name: &str| std::fs::read_to_string(folder.path().join(name)).unwrap();

    let page = read("performance.md");
    assert!(page.contains("matpoint study throughput --quick") && page.contains("performance/roofline.svg"), "{page}");
    // limits: a name and two positive numbers
    let limits: Vec<&str> = page.lines().filter(|line| line.starts_with("| multiply-add") || line.starts_with("| triad")).collect();
    assert!(limits.len() >= 4, "{page}");
    for limit in limits {
        let numbers: Vec<f64> = limit.split('|').filter_map(|cell| cell.trim().parse().ok()).collect();
        assert!(numbers.len() == 2 && numbers.iter().all(|n| *n > 0.0), "{limit}");
    }
    for row in ["| set, step, get |", "| after 1000 calls |", "| at the end |"] {
        let line = page.lines().find(|line| line.starts_with(row)).unwrap();
        assert!(line.split('|').nth(2).unwrap().trim().parse::<f64>().unwrap() > 0.0, "{line}");
    }
    assert!(!page.contains("At most 15 microseconds"), "a quick run judges nothing");

    let svg = read("performance/roofline.svg");
    assert!(svg.contains("triad in memory") && svg.contains("common work") && !svg.contains("NaN"), "{svg}");
    // three rounds of each entry
    let figures = read("performance/measurements.csv");
    assert!(figures.starts_with("part,name,round,value\n"));
    assert_eq!(figures.lines().filter(|line| line.starts_with("small,\"set, step, get\",")).count(), 3);
    assert_eq!(read("performance/roofline.csv").lines().filter(|line| line.starts_with("point,")).count(), 1);
}

#[test]
fn other_codes_are_shown_where_they_were_raced() {
    let folder = tempfile::tempdir().unwrap();
    let page = || std::fs::read_to_string(folder.path().join("performance.md")).unwrap();
    assert!(study(&["--only", "peers"], folder.path()).status.success());
    assert!(page().contains("`benches/peers/run` writes `target/peers/peers.csv`"), "{}", page());

    std::fs::create_dir_all(folder.path().join("target/peers")).unwrap();
    let rows = "particles,precision,order,threads,code,rate,ratio,rounds\n\
                97336,\"double\",\"cells\",1,\"matpoint\",2e7,1.0,9\n\
                97336,\"double\",\"cells\",1,\"taichi, hand-tuned\",5e6,4.0,9\n";
    std::fs::write(folder.path().join("target/peers/peers.csv"), rows).unwrap();
    assert!(study(&["--only", "peers"], folder.path()).status.success());
    assert!(page().contains("| 97336, double, cells, 1 | 20 | 5 | 4 |"), "{}", page());
}

#[test]
fn unknown_parts_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let output = study(&["--only", "machines"], folder.path());
    assert_eq!(output.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&output.stderr).contains("machine"));
}

/// What `benches/peers/race.py` relies on.
#[test]
fn a_stopwatch_answers_in_lines_of_json() {
    let mut command = Command::new(env!("CARGO_BIN_EXE_matpoint"));
    let mut child = command.args(["study", "stopwatch"]).stdin(Stdio::piped()).stdout(Stdio::piped()).spawn().unwrap();
    let mut orders = child.stdin.take().unwrap();
    let mut answers = BufReader::new(child.stdout.take().unwrap()).lines();
    let scene = r#"title = "t"
        dimension = 1
        grid = { origin = [0], size = [4], cell = 0.5 }
        material.soft = { law = "neo_hookean", young = 1e3, density = 1e3 }
        body.block = { material = "soft", shape = { box = { min = [1], max = [2] } }, velocity = [0.5] }
        time = { end = 1, step = 0.01 }"#;
    let task = serde_json::json!({ "scene": scene, "shuffled": true, "set": null, "get": [], "record": null });
    let mut ask = |order: &str| -> serde_json::Value {
        writeln!(orders, "{order}").unwrap();
        serde_json::from_str(&answers.next().unwrap().unwrap()).unwrap()
    };
    assert_eq!(ask(&task.to_string())["Ready"]["particles"], 4);
    assert!(ask(r#"{"Step":{"calls":2,"substeps":3}}"#)["Took"].as_f64().unwrap() > 0.0);
    // 1000 kg at 0.5 m/s
    assert!((ask("\"Energy\"")["Energy"].as_f64().unwrap() - 125.0).abs() < 1e-9);
    assert!(ask("nonsense")["Fault"].is_string());
    drop(orders);
    assert!(child.wait().unwrap().success());
}
