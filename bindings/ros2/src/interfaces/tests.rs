use super::*;
use std::collections::BTreeMap;
use std::path::Path;

/// Fields of an interface file, each part of a service by itself: `(name, type)` in order.
fn fields(text: &str, package: &str) -> Vec<Vec<(String, String)>> {
    let mut parts = vec![Vec::new()];
    for line in text.lines() {
        let line = line.split('#').next().unwrap_or_default().trim();
        if line == "---" {
            parts.push(Vec::new());
        }
        let mut words = line.split_whitespace();
        let (Some(kind), Some(name), third) = (words.next(), words.next(), words.next()) else { continue };
        // `uint8 OK = 1` is a constant.
        if third == Some("=") {
            continue;
        }
        let own = kind.starts_with(|c: char| c.is_ascii_uppercase());
        let kind = if own { format!("{package}/{kind}") } else { kind.to_owned() };
        parts.last_mut().unwrap().push((name.to_owned(), kind));
    }
    parts
}

/// Adds the definitions of one file under the names that `Definition` has.
fn add(all: &mut BTreeMap<String, Vec<(String, String)>>, package: &str, path: &str, text: &str) {
    let (stem, ending) = Path::new(path).file_name().unwrap().to_str().unwrap().split_once('.').unwrap();
    let parts = fields(text, package);
    let name = format!("{package}/{stem}");
    match ending {
        "msg" => drop(all.insert(name, parts[0].clone())),
        "srv" => {
            all.insert(format!("{name}.request"), parts[0].clone());
            all.insert(format!("{name}.response"), parts[1].clone());
        }
        _ => {
            all.insert(format!("{name}.goal"), parts[0].clone());
            all.insert(format!("{name}.result"), parts[1].clone());
            all.insert(format!("{name}.feedback"), parts[2].clone());
        }
    }
}

fn check(definitions: &[Definition], files: &BTreeMap<String, Vec<(String, String)>>) {
    for definition in definitions {
        let ours: Vec<_> = definition.fields.iter().map(|(name, kind)| ((*name).to_owned(), kind.clone())).collect();
        let theirs = files.get(definition.name).unwrap_or_else(|| panic!("no file for {}", definition.name));
        assert_eq!(&ours, theirs, "{}", definition.name);
    }
}

#[test]
fn our_types_are_those_of_the_files() {
    let folder = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../msgs"));
    let mut files = BTreeMap::new();
    for kind in ["msg", "srv"] {
        for entry in std::fs::read_dir(folder.join(kind)).unwrap() {
            let path = entry.unwrap().path();
            add(&mut files, "matpoint_msgs", path.to_str().unwrap(), &std::fs::read_to_string(&path).unwrap());
        }
    }
    let shared = ::matpoint::messages::definitions().into_iter().filter(|d| d.name.starts_with("matpoint_msgs/"));
    let definitions: Vec<_> = matpoint::definitions().into_iter().chain(shared).collect();
    check(&definitions, &files);
    // Every file has a type; a request without fields needs none.
    for (name, fields) in &files {
        assert!(fields.is_empty() || definitions.iter().any(|d| d.name == name), "{name} has no type");
    }
}

#[test]
fn their_types_are_those_of_simulation_interfaces() {
    let text = include_str!("../../../../tests/ros2/interfaces/simulation_interfaces.txt");
    let mut files = BTreeMap::new();
    for file in text.split("== ").skip(1) {
        let (path, body) = file.split_once('\n').unwrap();
        add(&mut files, "simulation_interfaces", path, body);
    }
    assert!(files.len() > 50);
    check(&simulation::definitions(), &files);
}
