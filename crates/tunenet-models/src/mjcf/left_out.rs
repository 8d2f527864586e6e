//! Goes through every element and attribute and notes those that the reader does not take on.

use super::known;
use crate::unused::{Changes, Collector};
use crate::xml::{Document, Element};

/// Notes what is left out of the document.
pub(super) fn note(document: &Document, unused: &mut Collector) {
    for attribute in &document.root.attributes {
        if attribute.name != "model" {
            let what = "unknown here and to MuJoCo 4.0.0";
            unused.add(
                attribute.file,
                attribute.whole.start,
                ("mujoco", Some(&attribute.name)),
                Changes::Unknown,
                what,
            );
        }
    }
    children(&document.root, "mujoco", unused);
}

fn children(element: &Element, parent: &str, unused: &mut Collector) {
    for child in &element.children {
        one(child, parent, unused);
    }
}

fn one(element: &Element, parent: &str, unused: &mut Collector) {
    let tag = element.tag.as_str();
    if let Some((changes, what)) = known::left_out(parent, tag) {
        if !(element.children.is_empty() && element.attributes.is_empty()) {
            unused.add(element.file, element.open.start, (tag, None), changes, what);
        }
        return;
    }
    if !known_element(parent, tag) {
        let what = "unknown here and to MuJoCo 4.0.0 at this place";
        unused.add(element.file, element.open.start, (tag, None), Changes::Unknown, what);
        return;
    }
    // An actuator whose force is not taken on is named as a whole where it is read.
    if parent == "actuator" && known::OTHER_ACTUATORS.contains(&tag) {
        return;
    }
    // Ties have tags of their own kind: <joint> within <equality> is no joint.
    let kind = match (parent, tag) {
        ("equality", _) => "equality",
        ("fixed", "joint") => "term",
        _ => tag,
    };
    for attribute in &element.attributes {
        let name = attribute.name.as_str();
        let tie = kind == "equality" && matches!(name, "joint1" | "joint2" | "polycoef" | "name" | "class");
        let term = kind == "term" && matches!(name, "joint" | "coef");
        if tie || term || known::taken(kind).contains(&name) || known::places(kind, name) {
            continue;
        }
        let unknown = (Changes::Unknown, "unknown here and to MuJoCo 4.0.0");
        let (changes, what) = known::effect(kind, name).unwrap_or(unknown);
        unused.add(attribute.file, attribute.whole.start, (tag, Some(name)), changes, what);
    }
    children(element, if tag == "worldbody" { "body" } else { tag }, unused);
}

/// Whether this element may stand there and is read, itself or its children.
fn known_element(parent: &str, tag: &str) -> bool {
    let actuator = known::ACTUATORS.contains(&tag) || known::OTHER_ACTUATORS.contains(&tag);
    match parent {
        "mujoco" => {
            matches!(tag, "compiler" | "option" | "default" | "worldbody" | "tendon" | "equality" | "actuator")
        }
        "default" => actuator || matches!(tag, "default" | "joint" | "geom" | "equality" | "tendon"),
        "body" => matches!(tag, "body" | "frame" | "inertial" | "joint" | "freejoint" | "geom"),
        "frame" => matches!(tag, "body" | "frame" | "geom" | "joint" | "freejoint"),
        "tendon" => tag == "fixed",
        "fixed" | "equality" => tag == "joint",
        "actuator" => actuator,
        _ => false,
    }
}
