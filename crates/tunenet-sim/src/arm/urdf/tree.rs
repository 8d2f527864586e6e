//! From links and joints to bodies: one tree with one root, fixed links merged into what carries them.

use std::collections::HashMap;

use tunenet_core::observation::Note;
use tunenet_formats::Result;

use super::File;
use crate::arm::{Body, Coordinate, Frame, JointKind, Pose};

/// The bodies, parents first, and the frames of all links.
pub(super) fn build(
    file: &File,
    coordinates: &[Option<(JointKind, Coordinate)>],
    notes: &mut Vec<Note>,
) -> Result<(Vec<Body>, Vec<Frame>)> {
    let links = names(file)?;
    let root = root(file, &links)?;
    let robot = &file.robot;
    // Where each link went: the body that carries it, and its place there.
    let mut homes: Vec<Option<(Option<usize>, Pose)>> = vec![None; robot.links.len()];
    homes[root] = Some((None, Pose::identity()));
    let mut bodies: Vec<Body> = Vec::new();
    let mut waiting: Vec<usize> = (0..robot.joints.len()).collect();
    // Parents may stand below their children: go round until nothing more hangs on what has a place.
    loop {
        let before = waiting.len();
        let mut still = Vec::new();
        for at in waiting {
            let joint = &robot.joints[at];
            let Some((carrier, base)) = homes[links[joint.parent.link.as_str()]] else {
                still.push(at);
                continue;
            };
            let child = links[joint.child.link.as_str()];
            let link = &robot.links[child];
            let place = base * file.pose(&format!("joint `{}`", joint.name), &joint.origin)?;
            let inertia = file.inertia(link)?;
            homes[child] = Some(if let Some((kind, coordinate)) = coordinates[at] {
                let (name, joint) = (link.name.clone(), file.joint(joint, kind, notes)?);
                bodies.push(Body { name, parent: carrier, placement: place, joint, coordinate, inertia });
                (Some(bodies.len() - 1), Pose::identity())
            } else {
                if let Some(body) = carrier {
                    bodies[body].inertia = bodies[body].inertia.with(&inertia.seen_from(&place));
                }
                (carrier, place)
            });
        }
        waiting = still;
        if waiting.is_empty() || waiting.len() == before {
            break;
        }
    }
    if let Some(at) = waiting.first() {
        let joint = &robot.joints[*at];
        let message =
            format!("expected a tree, found a cycle: nothing carries link `{}` but itself", joint.parent.link);
        return Err(file.error(message, "a link hangs on one joint; close loops by <mimic>"));
    }
    let frame = |(link, home): (&urdf_rs::Link, Option<(Option<usize>, Pose)>)| {
        home.map(|(body, placement)| Frame { name: link.name.clone(), body, placement })
    };
    Ok((bodies, robot.links.iter().zip(homes).filter_map(frame).collect()))
}

/// The place of every link by its name; no name twice, no joint between links that are not there.
fn names<'a>(file: &'a File) -> Result<HashMap<&'a str, usize>> {
    let mut links = HashMap::new();
    for (i, link) in file.robot.links.iter().enumerate() {
        if links.insert(link.name.as_str(), i).is_some() {
            return Err(file.error(format!("expected each link once, found `{}` twice", link.name), "rename one"));
        }
    }
    let mut joints = HashMap::new();
    for (i, joint) in file.robot.joints.iter().enumerate() {
        if joints.insert(joint.name.as_str(), i).is_some() {
            return Err(file.error(format!("expected each joint once, found `{}` twice", joint.name), "rename one"));
        }
        for (role, link) in [("parent", &joint.parent.link), ("child", &joint.child.link)] {
            if !links.contains_key(link.as_str()) {
                let message =
                    format!("joint `{}`: expected a link as its {role}, found `{link}`, which is none", joint.name);
                return Err(file.error(message, "add the link, or correct its name"));
            }
        }
    }
    Ok(links)
}

/// The link that hangs on nothing.
fn root(file: &File, links: &HashMap<&str, usize>) -> Result<usize> {
    let mut carried: Vec<Option<&str>> = vec![None; links.len()];
    for joint in &file.robot.joints {
        let child = links[joint.child.link.as_str()];
        if let Some(other) = carried[child].replace(&joint.name) {
            let link = &joint.child.link;
            let message =
                format!("link `{link}`: expected one joint to carry it, found `{other}` and `{}`", joint.name);
            return Err(file.error(message, "a link hangs on one joint; close loops by <mimic>"));
        }
    }
    let mut roots = (0..links.len()).filter(|i| carried[*i].is_none());
    let name = |i: usize| &file.robot.links[i].name;
    match (roots.next(), roots.next()) {
        (Some(root), None) => Ok(root),
        (Some(one), Some(other)) => {
            let message =
                format!("expected one link that hangs on nothing, found `{}` and `{}`", name(one), name(other));
            Err(file.error(message, "join them by a fixed joint"))
        }
        (None, _) if links.is_empty() => Err(file.error("expected links, found none", "is this the URDF of an arm?")),
        (None, _) => {
            Err(file
                .error("expected a tree, found a cycle: every link hangs on another", "let the base hang on nothing"))
        }
    }
}
