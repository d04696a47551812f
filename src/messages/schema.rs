//! The definitions as text, as MCAP files carry them.

/// Definitions by name: the package's own are the files that ROS builds it from.
const DEFINITIONS: [(&str, &str); 17] = [
    ("builtin_interfaces/Time", "int32 sec\nuint32 nanosec\n"),
    ("std_msgs/Header", "builtin_interfaces/Time stamp\nstring frame_id\n"),
    ("rosgraph_msgs/Clock", "builtin_interfaces/Time clock\n"),
    ("geometry_msgs/Vector3", "float64 x\nfloat64 y\nfloat64 z\n"),
    ("geometry_msgs/Point", "float64 x\nfloat64 y\nfloat64 z\n"),
    (
        "sensor_msgs/PointField",
        "uint8 INT8=1\nuint8 UINT8=2\nuint8 INT16=3\nuint8 UINT16=4\nuint8 INT32=5\nuint8 UINT32=6\nuint8 FLOAT32=7\nuint8 FLOAT64=8\n\
         string name\nuint32 offset\nuint8 datatype\nuint32 count\n",
    ),
    (
        "sensor_msgs/PointCloud2",
        "std_msgs/Header header\nuint32 height\nuint32 width\nsensor_msgs/PointField[] fields\nbool is_bigendian\nuint32 point_step\n\
         uint32 row_step\nuint8[] data\nbool is_dense\n",
    ),
    ("diagnostic_msgs/KeyValue", "string key\nstring value\n"),
    (
        "diagnostic_msgs/DiagnosticStatus",
        "byte OK=0\nbyte WARN=1\nbyte ERROR=2\nbyte STALE=3\nbyte level\nstring name\nstring message\nstring hardware_id\n\
         diagnostic_msgs/KeyValue[] values\n",
    ),
    ("diagnostic_msgs/DiagnosticArray", "std_msgs/Header header\ndiagnostic_msgs/DiagnosticStatus[] status\n"),
    (
        "rcl_interfaces/Log",
        "byte DEBUG=10\nbyte INFO=20\nbyte WARN=30\nbyte ERROR=40\nbyte FATAL=50\nbuiltin_interfaces/Time stamp\nuint8 level\nstring name\n\
         string msg\nstring file\nstring function\nuint32 line\n",
    ),
    ("matpoint_msgs/ComponentState", include_str!("../../msgs/msg/ComponentState.msg")),
    ("matpoint_msgs/Probe", include_str!("../../msgs/msg/Probe.msg")),
    ("matpoint_msgs/Reaction", include_str!("../../msgs/msg/Reaction.msg")),
    ("matpoint_msgs/LoadState", include_str!("../../msgs/msg/LoadState.msg")),
    ("matpoint_msgs/SceneDescription", include_str!("../../msgs/msg/SceneDescription.msg")),
    ("matpoint_msgs/VariableDescription", include_str!("../../msgs/msg/VariableDescription.msg")),
];

fn definition(name: &str) -> Option<(&'static str, &'static str)> {
    DEFINITIONS.into_iter().find(|(known, _)| *known == name)
}

/// The definition of a message followed by those of all that it is made of, as MCAP wants it; names are `package/Name`.
pub(crate) fn schema(name: &str) -> String {
    let mut parts: Vec<(&str, &str)> = definition(name).into_iter().collect();
    let mut next = 0;
    while let Some(&(of, text)) = parts.get(next) {
        let package = of.split_once('/').map_or("", |(package, _)| package);
        for line in text.lines() {
            let line = line.split('#').next().unwrap_or_default();
            let Some(kind) = line.split_whitespace().next() else { continue };
            let kind = kind.split('[').next().unwrap_or_default();
            let full = if kind.contains('/') { kind.to_owned() } else { format!("{package}/{kind}") };
            if let Some(part) = definition(&full)
                && !parts.contains(&part)
            {
                parts.push(part);
            }
        }
        next += 1;
    }
    let separator = "=".repeat(80);
    let mut whole = String::new();
    for (i, (name, text)) in parts.iter().enumerate() {
        if i > 0 {
            whole += &format!("{separator}\nMSG: {name}\n");
        }
        whole += text;
    }
    whole
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Types and names of the fields of a definition, constants left out.
    fn fields(name: &str) -> Vec<(String, String)> {
        let package = name.split_once('/').unwrap().0;
        let lines = definition(name).unwrap().1.lines().map(|line| line.split('#').next().unwrap());
        let words = lines.filter(|line| !line.contains('=')).map(|line| line.split_whitespace().collect::<Vec<_>>());
        let field = |words: Vec<&str>| {
            let own = words[0].starts_with(|c: char| c.is_ascii_uppercase());
            let kind = if own { format!("{package}/{}", words[0]) } else { words[0].replace("byte", "uint8") };
            (words[1].to_owned(), kind)
        };
        words.filter(|words| words.len() == 2).map(field).collect()
    }

    #[test]
    fn messages_have_the_fields_of_their_definitions_in_order() {
        let ours = crate::messages::definitions();
        assert_eq!(ours.len(), DEFINITIONS.len());
        for definition in ours {
            let written: Vec<_> = definition.fields.iter().map(|(name, kind)| ((*name).to_owned(), kind.clone())).collect();
            assert_eq!(written, fields(definition.name), "{}", definition.name);
        }
    }

    #[test]
    fn a_schema_has_all_its_parts_once() {
        let text = schema("matpoint_msgs/ComponentState");
        for part in ["std_msgs/Header", "builtin_interfaces/Time", "geometry_msgs/Point", "matpoint_msgs/Probe", "matpoint_msgs/LoadState"]
        {
            assert_eq!(text.matches(&format!("MSG: {part}\n")).count(), 1, "{part}");
        }
    }
}
