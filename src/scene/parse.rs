//! Text to [`Scene`]: TOML or JSON to a tree with places, the tree against the schema, then serde, then [`check`].

pub(super) mod tree;

use super::fault::{Fault, counted};
use super::{Scene, SceneError, check, structure};
use indexmap::map::Entry;
use std::fs::File;
use std::io::Read as _;
use std::path::{Path, PathBuf};
use tree::{Faults, Node, Place, Value, join};

/// Largest scene file \[bytes\]: what is larger is no scene.
const LARGEST: u64 = 16 << 20;

#[derive(Clone, Copy)]
enum Format {
    Toml,
    Json,
}

impl Scene {
    /// Reads a `.toml` or `.json` file. A relative path in `exact.reference` is taken from the folder of the file.
    ///
    /// # Errors
    /// Where the file cannot be read, and every fault in it with its line and column.
    pub fn load(path: impl AsRef<Path>) -> Result<Self, SceneError> {
        Self::load_with(path, &[])
    }

    /// As [`load`](Self::load), with some values set differently: pairs of a dotted path such as `body.beam.velocity[0]` and a TOML
    /// value. A value that is no TOML value and looks like a word or formula is taken as text. Tables and keys that are not there
    /// are created.
    ///
    /// # Errors
    /// As [`load`](Self::load); faults of a value that was set name the setting instead of a line.
    pub fn load_with(path: impl AsRef<Path>, overrides: &[(String, String)]) -> Result<Self, SceneError> {
        let path = path.as_ref();
        let (text, format) = read_file(path)?;
        read_scene(&text, format, Some(path), overrides)
    }

    /// Reads TOML. A relative path in `exact.reference` is taken from the working directory.
    ///
    /// # Errors
    /// Every fault, with its line and column.
    pub fn from_toml(text: &str) -> Result<Self, SceneError> {
        read_scene(text, Format::Toml, None, &[])
    }

    /// Reads JSON. A relative path in `exact.reference` is taken from the working directory.
    ///
    /// # Errors
    /// Every fault, with its line and column.
    pub fn from_json(text: &str) -> Result<Self, SceneError> {
        read_scene(text, Format::Json, None, &[])
    }

    /// The scene as TOML that reads back as the same scene; every key with its value, also those that were left out.
    pub fn to_toml(&self) -> String {
        // a scene is text, numbers, lists and tables: there is nothing that TOML and JSON could not hold
        toml::to_string_pretty(self).unwrap_or_default()
    }

    /// The scene as JSON, as [`to_toml`](Self::to_toml).
    pub fn to_json(&self) -> String {
        serde_json::to_string_pretty(self).unwrap_or_default()
    }

    /// Checks a scene that was built in code.
    ///
    /// # Errors
    /// Every fault, with the path of its field.
    pub fn check(&self) -> Result<(), SceneError> {
        let found = check::check(self);
        if found.is_empty() { Ok(()) } else { Err(faults(None, found)) }
    }

    /// The JSON schema of a scene, with the meaning and unit of every field.
    pub fn schema() -> serde_json::Value {
        let mut schema = serde_json::Value::from(schemars::schema_for!(Self));
        // schemars forgets the names that a map allows where its keys are an enum with documented variants.
        schema["$defs"]["Boundary"]["properties"]["velocity"]["propertyNames"] = serde_json::json!({ "$ref": "#/$defs/Axis" });
        schema
    }
}

/// Text and format of a scene file.
fn read_file(path: &Path) -> Result<(String, Format), SceneError> {
    let refuse = |message: String| faults(Some(path), vec![Fault::new("", message)]);
    let read = |source| SceneError::Read { file: path.to_path_buf(), source };
    let format = match path.extension().and_then(|extension| extension.to_str()) {
        Some("toml") => Format::Toml,
        Some("json") => Format::Json,
        _ => return Err(refuse("the name of a scene file must end in .toml or .json".into())),
    };
    let mut bytes = Vec::new();
    // One byte more than allowed, so that even a file without an end is refused soon.
    File::open(path).and_then(|file| file.take(LARGEST + 1).read_to_end(&mut bytes)).map_err(read)?;
    if bytes.len() as u64 > LARGEST {
        return Err(refuse(format!("has more than {LARGEST} bytes; that is no scene")));
    }
    let text = String::from_utf8(bytes)
        .map_err(|error| refuse(format!("is not text: byte {} is not UTF-8", error.utf8_error().valid_up_to() + 1)))?;
    Ok((text, format))
}

impl SceneError {
    /// Gives faults that were found when the scene of a file was built the places of their fields in the file; `overrides` are those that
    /// it was loaded with.
    #[must_use]
    pub fn in_file(self, path: &Path, overrides: &[(String, String)]) -> Self {
        let Self::Faults { faults: found, .. } = self else { return self };
        place_again(path, overrides, found)
    }
}

fn place_again(path: &Path, overrides: &[(String, String)], found: Vec<Fault>) -> SceneError {
    let Ok((text, format)) = read_file(path) else { return faults(Some(path), found) };
    let text = text.strip_prefix('\u{feff}').unwrap_or(&text);
    let parsed = match format {
        Format::Toml => tree::from_toml(text),
        Format::Json => tree::from_json(text),
    };
    let Ok(mut root) = parsed else { return faults(Some(path), found) };
    for (i, (key, value)) in overrides.iter().enumerate() {
        // they were set without a fault when the scene was read
        let _ = set(&mut root, key, value, i);
    }
    let found: Faults = found.into_iter().map(|fault| (root.nearest(&fault.path).place(), fault)).collect();
    faults(Some(path), place(found, text, overrides))
}

fn read_scene(text: &str, format: Format, file: Option<&Path>, overrides: &[(String, String)]) -> Result<Scene, SceneError> {
    // Some editors begin a file with a byte order mark.
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    let placed = |found: Faults| faults(file, place(found, text, overrides));
    let parsed = match format {
        Format::Toml => tree::from_toml(text),
        Format::Json => tree::from_json(text),
    };
    let mut root = parsed.map_err(placed)?;
    let mut found: Faults =
        overrides.iter().enumerate().filter_map(|(i, (path, value))| set(&mut root, path, value, i).err()).flatten().collect();
    found.extend(structure::faults(&root, &Scene::schema()));
    if !found.is_empty() {
        return Err(placed(found));
    }
    let mut scene: Scene = serde_json::from_value(root.to_json())
        .map_err(|error| placed(vec![(root.start, Fault::new("", format!("is not a scene: {error}")))]))?;
    if let (Some(folder), Some(exact)) = (file.and_then(Path::parent), &mut scene.exact) {
        exact.reference = exact.reference.as_ref().map(|reference| folder.join(reference).to_string_lossy().into_owned());
    }
    let found: Faults = check::check(&scene).into_iter().map(|fault| (root.nearest(&fault.path).place(), fault)).collect();
    if found.is_empty() { Ok(scene) } else { Err(placed(found)) }
}

fn faults(file: Option<&Path>, faults: Vec<Fault>) -> SceneError {
    SceneError::Faults { file: file.map(PathBuf::from), faults }
}

/// Gives faults their lines, columns and settings, and the order of the file.
fn place(mut found: Faults, text: &str, overrides: &[(String, String)]) -> Vec<Fault> {
    found.sort_by_key(|(place, _)| match place {
        Place::Text(offset) => (0, *offset),
        Place::Setting(number) => (1, *number),
    });
    let placed = |(place, fault): (Place, Fault)| match place {
        Place::Text(offset) => fault.at(line_and_column(text, offset)),
        Place::Setting(number) => {
            let (key, value) = &overrides[number];
            Fault { setting: Some(format!("{key}={value}")), ..fault }
        }
    };
    found.into_iter().map(placed).collect()
}

/// Line and column, in characters, both from 1.
fn line_and_column(text: &str, offset: usize) -> (usize, usize) {
    let before = text.get(..offset).unwrap_or(text);
    let line_start = before.rfind('\n').map_or(0, |end| end + 1);
    (before.matches('\n').count() + 1, before[line_start..].chars().count() + 1)
}

/// Carries out setting number `number`: `value` to `path`, as text where it is no TOML value but may be a word or formula.
fn set(root: &mut Node, path: &str, value: &str, number: usize) -> Result<(), Faults> {
    let refuse = |message: String| vec![(Place::Setting(number), Fault::new("", message))];
    let node = match tree::from_setting(value, number) {
        Ok(node) => node,
        // What begins like a list, table or quoted text was meant as one.
        Err(found) if value.trim_start().starts_with(['[', '{', '"', '\'']) => return Err(found),
        Err(_) => Node::new(Value::String(value.to_string()), Place::Setting(number)),
    };
    if path.is_empty() {
        return Err(refuse("names no key; must be key=value".into()));
    }
    if path.matches(['.', '[']).count() >= tree::DEEPEST {
        return Err(refuse(tree::too_deep()));
    }
    *slot(root, path, "", Place::Setting(number)).map_err(refuse)? = node;
    Ok(())
}

/// The node at `path` below `node`, which itself is at `above`; keys that are not there are created.
fn slot<'a>(node: &'a mut Node, path: &str, above: &str, place: Place) -> Result<&'a mut Node, String> {
    if path.is_empty() {
        return Ok(node);
    }
    match (&mut node.value, path.strip_prefix('[').and_then(|path| path.split_once(']'))) {
        (Value::Array(items), Some((index, rest))) => {
            let count = items.len();
            let item = index.parse::<usize>().ok().and_then(|index| items.get_mut(index));
            let item = item.ok_or_else(|| format!("{above} has {}, counted from 0; there is no item [{index}]", counted(count, "item")))?;
            slot(item, rest.strip_prefix('.').unwrap_or(rest), &format!("{above}[{index}]"), place)
        }
        (Value::Table(entries), None) => {
            let (key, rest) = path.split_at(path.find(['.', '[']).unwrap_or(path.len()));
            if key.is_empty() {
                return Err(format!("names an empty key{}", if above.is_empty() { String::new() } else { format!(" in {above}") }));
            }
            let path = join(above, key);
            let child = match entries.entry(key.to_string()) {
                Entry::Occupied(entry) => entry.into_mut(),
                Entry::Vacant(entry) => entry.insert(Node::new(Value::Table(Default::default()), place)),
            };
            slot(child, rest.strip_prefix('.').unwrap_or(rest), &path, place)
        }
        (Value::Array(items), None) => Err(format!("{above} is a list of {}; name an item, as in {above}[0]", items.len())),
        (_, _) => Err(format!("{} is no table that could hold `{path}`", if above.is_empty() { "the scene" } else { above })),
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Expr, OneOrEach, Transfer};
    use super::*;

    const SCENE: &str = r#"title = "bar \u00e9"
dimension = 1
grid = { origin = [0], size = [2.0], cell = 0.25 }
material.steel = { law = "hencky", young = 2.1e11, density = 7800 }
time.end = 1e-3

[body.bar]
material = "steel"
shape.box = { min = [0], max = [1] }
velocity = ["sin(PI*x)"]
"#;

    fn pairs(settings: &[(&str, &str)]) -> Vec<(String, String)> {
        settings.iter().map(|(key, value)| (key.to_string(), value.to_string())).collect()
    }

    fn with(settings: &[(&str, &str)]) -> Result<Scene, SceneError> {
        read_scene(SCENE, Format::Toml, None, &pairs(settings))
    }

    #[test]
    fn json_and_toml_say_the_same() {
        let scene = Scene::from_toml(SCENE).unwrap();
        assert_eq!(Scene::from_json(&scene.to_json()).unwrap(), scene);
        assert_eq!(Scene::from_toml(&scene.to_toml()).unwrap(), scene);
        assert_eq!(Scene::from_toml(&format!("\u{feff}{SCENE}")).unwrap(), scene);
        assert!(scene.check().is_ok());
    }

    #[test]
    fn faults_stand_where_the_value_or_its_nearest_ancestor_stands() {
        let place = |from: &str, to: &str| {
            let error = Scene::from_toml(&SCENE.replace(from, to)).unwrap_err();
            let [fault] = error.faults() else { panic!("one fault is expected: {error}") };
            (fault.line.unwrap(), fault.column.unwrap(), fault.path.clone())
        };
        assert_eq!(place("max = [1]", "max = [-1]"), (9, 33, "body.bar.shape.box.max[0]".into()));
        assert_eq!(place("max = [1]", "max = [1, 2]"), (9, 32, "body.bar.shape.box.max".into()));
        assert_eq!(place("max = [1]", "max = [9]"), (9, 1, "body.bar.shape".into()));
        assert_eq!(place(", density = 7800", ""), (4, 10, "material.steel.density".into()));
        assert_eq!(place("dimension = 1", "dimension = \"é\" # ü"), (2, 13, "dimension".into()));
        // columns count characters, not bytes
        assert_eq!(place("title = \"bar \\u00e9\"", "title = \"é\" =").1, 13);
    }

    #[test]
    fn settings_replace_create_and_are_checked() {
        let scene = with(&[
            ("body.bar.particles_per_cell", "3"),
            ("body.bar.velocity[0]", "2*x"),
            ("method.transfer", "apic"),
            ("record", "{ every = 1e-4 }"),
            ("title", "\"7\""),
        ])
        .unwrap();
        assert_eq!(scene.body["bar"].particles_per_cell, Some(OneOrEach::One(3)));
        assert_eq!(scene.body["bar"].velocity, [Expr::Formula("2*x".into())]);
        assert_eq!((scene.method.transfer, scene.record.every, scene.title.as_str()), (Transfer::Apic, Some(1e-4), "7"));

        let cases = [
            (("body.bar.colour", "3"), "--set body.bar.colour=3: body.bar: unknown key `colour`"),
            (("method.transfer", "apik"), "--set method.transfer=apik: method.transfer: is \"apik\"; did you mean `apic`?"),
            (("body.bar.velocity[4]", "3"), "body.bar.velocity has 1 item, counted from 0; there is no item [4]"),
            (("body.bar.velocity.x", "3"), "body.bar.velocity is a list of 1; name an item, as in body.bar.velocity[0]"),
            (("dimension.x", "3"), "dimension is no table that could hold `x`"),
            (("time.end", "nan"), "--set time.end=nan: time.end: is NaN; must be a finite number"),
            (("time.end", "-1"), "--set time.end=-1: time.end: is -1; must be above 0"),
            (("time.end", "[1"), "--set time.end=[1: is not a TOML value"),
            (("", "1"), "--set =1: names no key"),
            (("body..x", "1"), "--set body..x=1: names an empty key in body"),
            (("a.b.c", "1"), "--set a.b.c=1: unknown key `a`"),
        ];
        for ((key, value), message) in cases {
            let error = with(&[(key, value)]).unwrap_err().to_string();
            assert!(error.contains(message), "{error}");
        }
        let deep = with(&[(&["a"; 1000].join("."), "1")]).unwrap_err().to_string();
        assert!(deep.ends_with("is nested deeper than 64 tables and lists"), "{deep}");
    }

    #[test]
    fn the_schema_knows_every_name_that_serde_knows() {
        let schema = Scene::schema();
        assert_eq!(schema["properties"]["dimension"]["type"], "integer");
        assert!(schema["$defs"]["Material"]["properties"]["young"]["description"].as_str().unwrap().contains("[Pa"));
        let scene = format!("{SCENE}[boundary.end]\nface = \"x-\"\nvelocity = {{ w = 1 }}\n");
        assert!(Scene::from_toml(&scene).unwrap_err().to_string().contains("boundary.end.velocity: unknown key `w`; allowed: x, y, z"));
    }
}
