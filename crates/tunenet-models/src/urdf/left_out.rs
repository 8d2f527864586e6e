//! Goes through every element and attribute of a URDF and notes those that the reader does not take on.

use crate::unused::{Changes, Collector};
use crate::xml::{Document, Element};

/// Notes what is left out of the document.
pub(super) fn note(document: &Document, unused: &mut Collector) {
    for attribute in &document.root.attributes {
        if !matches!(attribute.name.as_str(), "name" | "version") && !attribute.name.starts_with("xmlns") {
            let what = "unknown to the specification of URDF";
            unused.add(0, attribute.whole.start, ("robot", Some(&attribute.name)), Changes::Unknown, what);
        }
    }
    document.root.children.iter().for_each(|child| one("robot", child, unused));
}

/// Elements that are left out with what they contain.
fn left_out(parent: &str, tag: &str) -> Option<(Changes, &'static str)> {
    Some(match (parent, tag) {
        ("link", "visual" | "collision") => (Changes::Contact, "shapes; meshes are not opened"),
        ("robot", "material") => (Changes::Nothing, "looks"),
        ("robot" | "link" | "joint", "gazebo") => {
            (Changes::Dynamics, "settings of Gazebo, which may hold friction and plugins")
        }
        ("joint", "safety_controller") => (Changes::Dynamics, "soft limits of a controller"),
        ("joint", "calibration") => (Changes::Nothing, "where the joint finds its zero"),
        ("robot", "sensor") => (Changes::Readings, "sensors"),
        _ => return None,
    })
}

/// What children and attributes of an element the reader takes on.
fn taken(tag: &str) -> Option<(&'static [&'static str], &'static [&'static str])> {
    Some(match tag {
        "link" => (&["inertial"], &["name"]),
        "inertial" => (&["origin", "mass", "inertia"], &[]),
        "origin" => (&[], &["xyz", "rpy"]),
        "mass" => (&[], &["value"]),
        "inertia" => (&[], &["ixx", "ixy", "ixz", "iyy", "iyz", "izz"]),
        "joint" => (&["origin", "parent", "child", "axis", "limit", "dynamics", "mimic"], &["name", "type"]),
        "parent" | "child" => (&[], &["link"]),
        "axis" => (&[], &["xyz"]),
        "limit" => (&[], &["lower", "upper", "effort", "velocity"]),
        "dynamics" => (&[], &["damping", "friction"]),
        "mimic" => (&[], &["joint", "multiplier", "offset"]),
        _ => return None,
    })
}

fn one(parent: &str, element: &Element, unused: &mut Collector) {
    let tag = element.tag.as_str();
    let at = element.open.start;
    match (parent, tag) {
        ("robot" | "ros2_control", "transmission") => return transmission(element, unused),
        ("robot", "ros2_control") => return control(element, unused),
        ("robot", "mujoco") => return mujoco(element, unused),
        _ => {}
    }
    if let Some((changes, what)) = left_out(parent, tag) {
        unused.add(0, at, (tag, None), changes, what);
        return;
    }
    let expected = match parent {
        "robot" => matches!(tag, "link" | "joint"),
        _ => taken(parent).is_some_and(|(children, _)| children.contains(&tag)),
    };
    let Some((_, attributes)) = taken(tag).filter(|_| expected) else {
        unused.add(0, at, (tag, None), Changes::Unknown, "unknown to the specification of URDF at this place");
        return;
    };
    for attribute in &element.attributes {
        if !attributes.contains(&attribute.name.as_str()) {
            let what = "unknown to the specification of URDF";
            unused.add(0, attribute.whole.start, (tag, Some(&attribute.name)), Changes::Unknown, what);
        }
    }
    element.children.iter().for_each(|child| one(tag, child, unused));
}

/// Joint, reduction and hardware interface are taken on; what else a transmission says is not.
fn transmission(element: &Element, unused: &mut Collector) {
    let what = "kind of a transmission; its joint, reduction and hardware interface are read";
    unused.add(0, element.open.start, ("transmission", None), Changes::Readings, what);
    let kind = element.named("type").next();
    if let Some(kind) = kind.or(element.named("plugin").next()) {
        let what = "how a transmission couples its joints; one joint with one motor is taken as a simple reduction";
        unused.add(0, kind.open.start, (&kind.tag, None), Changes::Dynamics, what);
    }
}

/// Command interfaces are taken on as drives; gains stand in other files.
fn control(element: &Element, unused: &mut Collector) {
    let what = "hardware, state interfaces and parameters; the gains of its controllers stand in their YAML";
    unused.add(0, element.open.start, ("ros2_control", None), Changes::Dynamics, what);
}

/// What only MuJoCo reads of a URDF.
fn mujoco(element: &Element, unused: &mut Collector) {
    for child in &element.children {
        for attribute in &child.attributes {
            let changes = match attribute.name.as_str() {
                "meshdir" | "strippath" | "discardvisual" | "fusestatic" | "texturedir" | "assetdir" => {
                    Changes::Nothing
                }
                _ => Changes::Dynamics,
            };
            let what = "a setting for MuJoCo alone";
            unused.add(0, attribute.whole.start, (&child.tag, Some(&attribute.name)), changes, what);
        }
    }
    unused.add(0, element.open.start, ("mujoco", None), Changes::Nothing, "settings for MuJoCo alone");
}
