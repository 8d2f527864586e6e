//! ROS message definitions (`ros2msg` schemas): whether they define what is decoded as the name of the message says.

/// The fields of the messages that are decoded, in order; a header before them is left out.
const KNOWN: [(&str, &[(&str, &str)]); 2] = [
    ("geometry_msgs/Point", &[("float64", "x"), ("float64", "y"), ("float64", "z")]),
    (
        "sensor_msgs/JointState",
        &[("string[]", "name"), ("float64[]", "position"), ("float64[]", "velocity"), ("float64[]", "effort")],
    ),
];

/// What a definition says of a known message that contradicts its name, to be read after the topic's name; `None` where it says the
/// same, or nothing.
pub(crate) fn contradiction(schema_name: &str, encoding: &str, definition: &[u8]) -> Option<String> {
    if !matches!(encoding, "ros2msg" | "ros1msg") {
        return None;
    }
    let definition = String::from_utf8_lossy(definition);
    let mut lines = definition.lines().peekable();
    let mut name = schema_name.replace("/msg/", "/");
    while lines.peek().is_some() {
        let section = lines.by_ref().take_while(|line| !line.starts_with("====")).collect::<Vec<_>>();
        let (names, fields): (Vec<&str>, Vec<&str>) = section.iter().partition(|line| line.starts_with("MSG:"));
        if let Some(named) = names.first() {
            named["MSG:".len()..].trim().replace("/msg/", "/").clone_into(&mut name);
        }
        let fields: Vec<(&str, &str)> = fields.into_iter().filter_map(field).collect();
        let known = KNOWN.iter().find(|(known, _)| *known == name).map(|(_, fields)| *fields);
        if let Some(known) = known.filter(|known| !fields.is_empty() && *known != fields) {
            let listed =
                |all: &[(&str, &str)]| all.iter().map(|(t, n)| format!("{t} {n}")).collect::<Vec<_>>().join(", ");
            return Some(format!("defines {name} as `{}`: expected `{}`", listed(&fields), listed(known)));
        }
    }
    None
}

/// The type and the name of a field that is no header; `None` for comments, constants and empty lines.
fn field(line: &str) -> Option<(&str, &str)> {
    let line = line.split('#').next()?;
    let mut words = line.split_whitespace();
    let (kind, name) = (words.next()?, words.next()?);
    let header = kind.rsplit('/').next() == Some("Header");
    (!header && !line.contains('=')).then_some((kind, name))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ros::definitions::{JOINT_STATE, POINT_STAMPED};

    const POINT: &str = "geometry_msgs/msg/PointStamped";

    #[test]
    fn own_definitions_agree_with_their_names() {
        assert_eq!(contradiction(POINT, "ros2msg", POINT_STAMPED.as_bytes()), None);
        assert_eq!(contradiction("sensor_msgs/msg/JointState", "ros2msg", JOINT_STATE.as_bytes()), None);
        assert_eq!(contradiction(POINT, "ros2msg", b""), None);
        assert_eq!(contradiction(POINT, "ros2msg", b"\xff\xfe"), None);
    }

    #[test]
    fn other_types_under_a_known_name_are_refused() {
        let other = POINT_STAMPED.replace("float64 x", "float32 x  # m");
        assert_eq!(
            contradiction(POINT, "ros2msg", other.as_bytes()).unwrap(),
            "defines geometry_msgs/Point as `float32 x, float64 y, float64 z`: expected `float64 x, float64 y, float64 z`"
        );
        let other = JOINT_STATE.replace("float64[] velocity\n", "");
        assert!(contradiction("sensor_msgs/JointState", "ros1msg", other.as_bytes()).is_some());
        // A definition in another language is not read.
        assert_eq!(contradiction(POINT, "ros2idl", other.as_bytes()), None);
    }
}
