//! What stands between `--ros-args` and `--`: remaps, parameters, parameter files, log level. The rest is for the command line.

use crate::names::{Names, Remap};
use crate::parameters::Value;
use std::path::PathBuf;
use yaml_rust2::{Yaml, YamlLoader};

/// A ROS argument, or a parameter file, that cannot be understood.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ArgsError {
    /// A flag that needs a value stands at the end.
    #[error("`{0}` needs a value after it")]
    Lacking(String),
    /// An unknown flag.
    #[error("`{0}` is no ROS argument; known are -r, -p, --params-file, --log-level, --remap, --param, -e, --enclave")]
    Unknown(String),
    /// No `:=` in a remap or parameter.
    #[error("`{0}`: expected FROM:=TO")]
    Assignment(String),
    /// A name that is none.
    #[error("`{name}` is no ROS name: {reason}")]
    Name {
        /// As given.
        name: String,
        /// What is wrong with it.
        reason: &'static str,
    },
    /// A value that is no YAML, or of no type that a parameter can have.
    #[error("parameter `{name}`: {reason}")]
    Value {
        /// The parameter.
        name: String,
        /// What is wrong with its value.
        reason: String,
    },
    /// A parameter file that cannot be read.
    #[error("parameter file `{}`: {reason}", path.display())]
    File {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        reason: String,
    },
}

/// How much is said on stderr and `/rosout`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Default)]
#[expect(missing_docs, reason = "the names say it")]
pub enum Level {
    Debug = 10,
    #[default]
    Info = 20,
    Warn = 30,
    Error = 40,
}

/// The ROS arguments of a command line.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct RosArgs {
    /// In the order given; the first rule that fits wins.
    pub remaps: Vec<Remap>,
    /// `-p [node:]name:=value`, the value as YAML text.
    pub parameters: Vec<(Option<String>, String, String)>,
    /// `--params-file`.
    pub files: Vec<PathBuf>,
    /// `--log-level`.
    pub level: Level,
}

/// A parameter from outside: its name, its value, and whether it was meant for this node and no other.
#[derive(Debug, Clone, PartialEq)]
pub struct Override {
    /// Name, with dots.
    pub name: String,
    /// Value.
    pub value: Value,
    /// False where a wildcard gave it to all nodes.
    pub exact: bool,
}

/// Parts a command line into what is ours and what is for ROS.
///
/// # Errors
/// A ROS argument that is not understood.
pub fn split(args: impl IntoIterator<Item = String>) -> Result<(Vec<String>, RosArgs), ArgsError> {
    let (mut ours, mut ros) = (Vec::new(), RosArgs::default());
    let mut args = args.into_iter();
    let mut inside = false;
    while let Some(arg) = args.next() {
        if !inside {
            inside = arg == "--ros-args";
            if !inside {
                ours.push(arg);
            }
            continue;
        }
        let mut value = || args.next().ok_or_else(|| ArgsError::Lacking(arg.clone()));
        match arg.as_str() {
            "--" => inside = false,
            "--ros-args" => {}
            "-r" | "--remap" => ros.remaps.push(Remap::parse(&value()?)?),
            "-p" | "--param" => {
                let text = value()?;
                let (left, right) = text.split_once(":=").ok_or_else(|| ArgsError::Assignment(text.clone()))?;
                let (node, name) = left.split_once(':').map_or((None, left), |(node, name)| (Some(node.to_owned()), name));
                ros.parameters.push((node, name.to_owned(), right.to_owned()));
            }
            "--params-file" => ros.files.push(value()?.into()),
            "--log-level" => ros.level = level(&value()?)?,
            "-e" | "--enclave" | "--log-config-file" | "--log-file-name" => drop(value()?),
            flag if flag.starts_with("--enable-") || flag.starts_with("--disable-") => {}
            // Launch files of older distributions write the value into the flag.
            other => match other.split_once(":=") {
                Some(_) => ros.remaps.push(Remap::parse(other)?),
                None => return Err(ArgsError::Unknown(other.to_owned())),
            },
        }
    }
    Ok((ours, ros))
}

/// `info`, or `logger:=info` for one logger, which is taken for all.
fn level(text: &str) -> Result<Level, ArgsError> {
    match text.rsplit(":=").next().unwrap_or_default().to_ascii_lowercase().as_str() {
        "debug" => Ok(Level::Debug),
        "info" => Ok(Level::Info),
        "warn" => Ok(Level::Warn),
        "error" | "fatal" => Ok(Level::Error),
        _ => Err(ArgsError::Value { name: "--log-level".into(), reason: format!("is `{text}`; one of debug, info, warn, error, fatal") }),
    }
}

impl RosArgs {
    /// The parameters that this node is given, files first, later ones on top.
    ///
    /// # Errors
    /// A file that cannot be read; a value that is of no type that parameters have.
    pub fn overrides(&self, names: &Names) -> Result<Vec<Override>, ArgsError> {
        let mut found = Vec::new();
        for path in &self.files {
            let fault = |reason: String| ArgsError::File { path: path.clone(), reason };
            let text = std::fs::read_to_string(path).map_err(|error| fault(error.to_string()))?;
            let documents = YamlLoader::load_from_str(&text).map_err(|error| fault(error.to_string()))?;
            for document in &documents {
                nodes(document, "", names, &mut found).map_err(|error| fault(error.to_string()))?;
            }
        }
        for (node, name, text) in &self.parameters {
            if node.as_ref().is_some_and(|node| !names.is_node(node)) {
                continue;
            }
            let fault = |reason: String| ArgsError::Value { name: name.clone(), reason };
            let documents = YamlLoader::load_from_str(text).map_err(|error| fault(error.to_string()))?;
            let value = documents.first().map_or_else(|| Ok(Value::Text(String::new())), |yaml| value(name, yaml))?;
            found.push(Override { name: name.clone(), value, exact: true });
        }
        Ok(found)
    }
}

/// Walks a parameter file: node names, nested or with slashes, above `ros__parameters`.
fn nodes(yaml: &Yaml, path: &str, names: &Names, found: &mut Vec<Override>) -> Result<(), ArgsError> {
    let Yaml::Hash(table) = yaml else { return Ok(()) };
    for (key, below) in table {
        let key = key.as_str().unwrap_or_default();
        if key != "ros__parameters" {
            nodes(below, &format!("{path}/{}", key.trim_start_matches('/')), names, found)?;
        } else if names.fits(path) {
            leaves(below, "", path.contains('*'), found)?;
        }
    }
    Ok(())
}

fn leaves(yaml: &Yaml, path: &str, wildcard: bool, found: &mut Vec<Override>) -> Result<(), ArgsError> {
    let Yaml::Hash(table) = yaml else { return Ok(()) };
    for (key, below) in table {
        let key = key.as_str().unwrap_or_default();
        let name = if path.is_empty() { key.to_owned() } else { format!("{path}.{key}") };
        match below {
            Yaml::Hash(_) => leaves(below, &name, wildcard, found)?,
            _ => found.push(Override { value: value(&name, below)?, name, exact: !wildcard }),
        }
    }
    Ok(())
}

fn value(name: &str, yaml: &Yaml) -> Result<Value, ArgsError> {
    let fault = |reason: &str| ArgsError::Value { name: name.into(), reason: reason.into() };
    Ok(match yaml {
        Yaml::Boolean(v) => Value::Bool(*v),
        Yaml::Integer(v) => Value::Integer(*v),
        Yaml::Real(_) => Value::Double(yaml.as_f64().ok_or_else(|| fault("is no number"))?),
        Yaml::String(v) => Value::Text(v.clone()),
        Yaml::Null => Value::Text(String::new()),
        Yaml::Array(list) => {
            let texts = list.iter().map(|v| v.as_str().map(str::to_owned)).collect::<Option<Vec<_>>>();
            Value::Texts(texts.ok_or_else(|| fault("is a list of something else than words; no parameter of this node is"))?)
        }
        _ => return Err(fault("is of no type that a parameter can have")),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn words(text: &str) -> Vec<String> {
        text.split_whitespace().map(str::to_owned).collect()
    }

    #[test]
    fn ours_and_theirs() {
        let (ours, ros) = split(words("a.toml --ros-args -r __ns:=/lab -p step:=0.1 --log-level warn -- --set x=1")).unwrap();
        assert_eq!(ours, words("a.toml --set x=1"));
        assert_eq!(ros.remaps.len(), 1);
        assert_eq!(ros.parameters, [(None, "step".to_owned(), "0.1".to_owned())]);
        assert_eq!(ros.level, Level::Warn);
        assert_eq!(split(words("--ros-args -p")), Err(ArgsError::Lacking("-p".into())));
        assert_eq!(split(words("--ros-args --wrong")), Err(ArgsError::Unknown("--wrong".into())));
        assert_eq!(split(words("--ros-args -r a=b")), Err(ArgsError::Assignment("a=b".into())));
        assert!(split(words("--ros-args --log-level loud")).is_err());
    }

    #[test]
    fn parameters_from_files_and_the_command_line() {
        let file = std::env::temp_dir().join(format!("matpoint-{}.yaml", std::process::id()));
        let text = "
/**:
  ros__parameters: {use_sim_time: true, step: 0.5}
lab:
  beam:
    ros__parameters: {step: 0.25, particles: {stride: 3, fields: [velocity]}}
/lab/other: {ros__parameters: {step: 0.75}}
beam: {ros__parameters: {step: 0.125}}
";
        std::fs::write(&file, text).unwrap();
        let names = Names::new("/lab", "beam", Vec::new()).unwrap();
        let (_, ros) = split(words(&format!("--ros-args --params-file {} -p other:step:=9 -p beam:paused:=true", file.display()))).unwrap();
        let found = ros.overrides(&names).unwrap();
        std::fs::remove_file(&file).unwrap();
        let all: Vec<_> = found.iter().map(|o| (o.name.as_str(), o.value.clone(), o.exact)).collect();
        assert_eq!(
            all,
            [
                ("use_sim_time", Value::Bool(true), false),
                ("step", Value::Double(0.5), false),
                ("step", Value::Double(0.25), true),
                ("particles.stride", Value::Integer(3), true),
                ("particles.fields", Value::Texts(vec!["velocity".into()]), true),
                ("paused", Value::Bool(true), true),
            ]
        );
    }
}
