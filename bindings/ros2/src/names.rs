//! ROS names: namespaces, private names, remaps.

use crate::args::ArgsError;

/// `[NODE:]FROM:=TO`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Remap {
    node: Option<String>,
    from: String,
    to: String,
}

impl Remap {
    /// Reads a rule.
    ///
    /// # Errors
    /// No `:=`, or nothing on one of its sides.
    pub fn parse(text: &str) -> Result<Self, ArgsError> {
        let fault = || ArgsError::Assignment(text.to_owned());
        let (left, to) = text.split_once(":=").ok_or_else(fault)?;
        let (node, from) = left.split_once(':').map_or((None, left), |(node, from)| (Some(node.to_owned()), from));
        if from.is_empty() || to.is_empty() {
            return Err(fault());
        }
        Ok(Self { node, from: from.to_owned(), to: to.to_owned() })
    }
}

/// The names of a node and how it names its topics and services.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Names {
    namespace: String,
    node: String,
    remaps: Vec<Remap>,
}

impl Names {
    /// A node of this name and namespace, unless `remaps` say otherwise.
    ///
    /// # Errors
    /// Names that are none.
    pub fn new(namespace: &str, node: &str, remaps: Vec<Remap>) -> Result<Self, ArgsError> {
        let special = |name: &[&str]| {
            let rule = remaps.iter().find(|r| name.contains(&r.from.as_str()) && r.node.as_ref().is_none_or(|n| n == node));
            rule.map(|r| r.to.clone())
        };
        let namespace = special(&["__ns"]).unwrap_or_else(|| namespace.to_owned());
        let names = Self {
            namespace: format!("/{}", namespace.trim_matches('/')),
            node: special(&["__node", "__name"]).unwrap_or_else(|| node.to_owned()),
            remaps,
        };
        check(&names.node)?;
        if names.namespace != "/" {
            names.namespace[1..].split('/').try_for_each(check)?;
        }
        Ok(names)
    }

    /// Namespace, such as `/` or `/lab`.
    pub fn namespace(&self) -> &str {
        &self.namespace
    }

    /// Name without namespace.
    pub fn node(&self) -> &str {
        &self.node
    }

    /// Name with namespace, such as `/lab/beam`.
    pub fn full(&self) -> String {
        self.absolute(&self.node)
    }

    /// The absolute name of a topic or service given as `~/private`, `relative` or `/absolute`, remaps applied.
    ///
    /// # Errors
    /// A remap to what is no name.
    pub fn resolve(&self, name: &str) -> Result<String, ArgsError> {
        let plain = self.absolute(name);
        let rule = self.remaps.iter().find(|r| r.node.as_ref().is_none_or(|n| *n == self.node) && self.absolute(&r.from) == plain);
        let resolved = rule.map_or(plain, |r| self.absolute(&r.to));
        resolved[1..].split('/').try_for_each(check)?;
        Ok(resolved)
    }

    fn absolute(&self, name: &str) -> String {
        match name.strip_prefix("~/") {
            Some(private) => format!("{}/{private}", self.full()),
            None if name.starts_with('/') => name.to_owned(),
            None => format!("{}/{name}", self.namespace.trim_end_matches('/')),
        }
    }

    /// Whether `name` is this node, with or without its namespace.
    pub fn is_node(&self, name: &str) -> bool {
        name == self.node || name == self.full()
    }

    /// Whether the path of a parameter file, such as `/**`, `/*/beam` or `/lab/beam`, means this node. A name without a namespace
    /// means the node of that name in the root.
    pub fn fits(&self, path: &str) -> bool {
        fn fits(pattern: &[&str], name: &[&str]) -> bool {
            match (pattern, name) {
                ([], []) => true,
                (["**", rest @ ..], _) => (0..=name.len()).any(|skip| fits(rest, &name[skip..])),
                (["*", rest @ ..], [_, below @ ..]) => fits(rest, below),
                ([token, rest @ ..], [first, below @ ..]) => token == first && fits(rest, below),
                _ => false,
            }
        }
        let full = self.full();
        fits(&path.trim_start_matches('/').split('/').collect::<Vec<_>>(), &full[1..].split('/').collect::<Vec<_>>())
    }
}

/// A part of a scene's name as a part of a ROS name: other characters become underscores.
pub fn token(name: &str) -> String {
    let clean: String = name.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '_' }).collect();
    let clean = clean.split('_').filter(|part| !part.is_empty()).collect::<Vec<_>>().join("_");
    if clean.starts_with(|c: char| c.is_ascii_alphabetic()) { clean } else { format!("n{clean}") }
}

fn check(token: &str) -> Result<(), ArgsError> {
    let fault = |reason| Err(ArgsError::Name { name: token.to_owned(), reason });
    match token.chars().next() {
        None => fault("a part of it is empty"),
        Some(c) if !(c.is_ascii_alphabetic() || c == '_') => fault("its parts start with a letter"),
        _ if !token.chars().all(|c| c.is_ascii_alphanumeric() || c == '_') => fault("only letters, digits and _ may be in it"),
        _ if token.contains("__") => fault("two underscores in a row are reserved"),
        _ => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(rules: &[&str]) -> Names {
        Names::new("/", "matpoint", rules.iter().map(|r| Remap::parse(r).unwrap()).collect()).unwrap()
    }

    #[test]
    fn names_are_resolved_as_ros_does() {
        let lab = names(&["__ns:=/lab", "__node:=beam", "~/state:=/observed", "clock:=time", "other:~/load/tip:=wrong"]);
        assert_eq!(lab.full(), "/lab/beam");
        assert_eq!(lab.resolve("~/particles").unwrap(), "/lab/beam/particles");
        assert_eq!(lab.resolve("~/state").unwrap(), "/observed");
        assert_eq!(lab.resolve("/clock").unwrap(), "/clock", "`clock` means /lab/clock");
        assert_eq!(lab.resolve("~/load/tip").unwrap(), "/lab/beam/load/tip");
        assert_eq!(names(&["/clock:=/lab/clock"]).resolve("/clock").unwrap(), "/lab/clock");
        assert!(names(&["/clock:=/1st"]).resolve("/clock").is_err());
        assert!(Names::new("/", "two words", Vec::new()).is_err());
        assert!(Names::new("/a//b", "x", Vec::new()).is_err());
    }

    #[test]
    fn parameter_files_name_nodes_with_wildcards() {
        let lab = names(&["__ns:=/lab", "__node:=beam"]);
        for path in ["/**", "/lab/beam", "/*/beam", "/**/beam", "/lab/*"] {
            assert!(lab.fits(path), "{path}");
        }
        for path in ["/beam", "/*", "/lab", "/lab/beam/x", "/other/beam"] {
            assert!(!lab.fits(path), "{path}");
        }
    }

    #[test]
    fn names_of_scenes_become_names_of_topics() {
        assert_eq!(token("tip"), "tip");
        assert_eq!(token("tip load-2"), "tip_load_2");
        assert_eq!(token("2__x"), "n2_x");
    }
}
