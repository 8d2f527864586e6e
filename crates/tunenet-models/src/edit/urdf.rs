//! Numbers in a URDF: `<dynamics>` and the effort of `<limit>`.

use super::patch::{Patches, listed, number};
use super::{Done, Edited, Left, NO_OFFSET_OF_READINGS};
use crate::urdf::Urdf;
use crate::xml::Element;
use crate::{Change, Quantity};

pub(super) fn edit(urdf: &Urdf, changes: &[(usize, &Change)]) -> Edited {
    let source = &urdf.document.files[0];
    let mut patches = Patches::default();
    let (mut done, mut left) = (Vec::new(), Vec::new());
    // New <dynamics> elements, by joint.
    let mut fresh: Vec<(usize, Vec<(&str, String)>)> = Vec::new();
    for &(joint, change) in changes {
        let leave = |why: &str| Left { change: change.clone(), why: why.into() };
        let (tag, name) = match change.quantity {
            Quantity::ViscousFriction => ("dynamics", "damping"),
            Quantity::CoulombFriction => ("dynamics", "friction"),
            Quantity::TorqueLimit => ("limit", "effort"),
            other => {
                left.push(leave(why_not(other)));
                continue;
            }
        };
        let element = &urdf.joints[joint];
        let value = number(change.value);
        match element.named(tag).next() {
            Some(own) => patches.set(own, source, name, &value),
            None if tag == "limit" => {
                left.push(leave("the joint has no <limit>: add one with its effort and velocity"));
                continue;
            }
            None => match fresh.iter_mut().find(|(other, _)| *other == joint) {
                Some((_, list)) => list.push((name, value.clone())),
                None => fresh.push((joint, vec![(name, value.clone())])),
            },
        }
        let (path, line) = (source.path.clone(), source.line(element.open.start));
        done.push(Done { change: change.clone(), path, line, written: format!("<{tag} {name}=\"{value}\">") });
    }
    for (joint, list) in fresh {
        let attributes = listed(&list);
        let (at, space) = behind_last_child(&urdf.joints[joint], &source.text);
        patches.replace(0, at..at, format!("{space}<dynamics{attributes}/>"));
    }
    Edited { files: patches.apply(&urdf.document.files), done, left, notes: Vec::new() }
}

/// Where another child goes, and what stands before each child.
fn behind_last_child<'a>(element: &Element, text: &'a str) -> (usize, &'a str) {
    let (Some(first), Some(last)) = (element.children.first(), element.children.last()) else {
        return (element.close, "");
    };
    let space = &text[element.open.end..first.open.start];
    let space = if space.trim().is_empty() { space } else { "" };
    let end = if last.empty {
        last.open.end
    } else {
        text[last.close..].find('>').map_or(element.close, |i| last.close + i + 1)
    };
    (end, space)
}

/// Why a URDF cannot express it.
fn why_not(quantity: Quantity) -> &'static str {
    match quantity {
        Quantity::Armature => "a URDF has no inertia of a rotor: an MJCF has `armature`",
        Quantity::PositionGain | Quantity::VelocityGain => {
            "a URDF has no gains: they belong to the controller's configuration"
        }
        Quantity::Gear => "a URDF has it only in <transmission>, which simulators ignore: change it by hand",
        Quantity::Stiffness | Quantity::SpringReference => {
            "a URDF has no springs: an MJCF has `stiffness` and `springref`"
        }
        Quantity::ZeroOffset => NO_OFFSET_OF_READINGS,
        Quantity::ExtraLoad => {
            "the copy has other numbers of joints alone: add a link of this mass, fixed at the centre of mass of the last link"
        }
        Quantity::BackEmf => "a URDF has one number for what brakes with the speed: add it to viscous_friction",
        _ => "a URDF has no attribute for it",
    }
}
