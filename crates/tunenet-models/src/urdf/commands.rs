//! What a URDF says of the commands to its joints.
//!
//! Source: the hardware interfaces of `<transmission>` (wiki.ros.org/urdf/XML/Transmission), at the joint or, in older files, at the
//! actuator; and the command interfaces of `<ros2_control>` (control.ros.org), which count where a joint has no transmission that
//! states one.

use super::{number_within, within};
use crate::Result;
use crate::robot::Robot;
use crate::xml::{Document, Element};

/// What a command to a joint is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Interface {
    /// A position, rad or m.
    Position,
    /// A speed, rad/s or m/s.
    Velocity,
    /// A torque or a force, N·m or N.
    Effort,
}

impl Interface {
    /// As `<ros2_control>` has it.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Position => "position",
            Self::Velocity => "velocity",
            Self::Effort => "effort",
        }
    }

    const ALL: [Self; 3] = [Self::Position, Self::Velocity, Self::Effort];
}

/// A joint for which the file states a transmission or command interfaces.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Commanded {
    /// Its name.
    pub joint: String,
    /// What its commands can be, each once: a position first, then a speed. Empty where the file states none of these.
    pub interfaces: Vec<Interface>,
}

/// What a URDF says of the commands to its joints.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Commands {
    /// The joints, in the order of the file.
    pub joints: Vec<Commanded>,
    /// How many transmissions have a reduction other than 1.
    pub reductions: usize,
}

/// Reads them.
pub(super) fn read(document: &Document, robot: &Robot) -> Result<Commands> {
    let mut commands = Commands::default();
    let mut of_transmissions: Vec<Option<Vec<Interface>>> = vec![None; robot.joints.len()];
    for transmission in transmissions(document) {
        let motors: Vec<Interface> =
            transmission.named("actuator").flat_map(|motor| hardware(document, motor)).collect();
        for joint in transmission.named("joint") {
            let Some(place) = joint.value("name").and_then(|name| robot.joint(name)) else { continue };
            let own = hardware(document, joint);
            of_transmissions[place].get_or_insert_default().extend(if own.is_empty() { motors.clone() } else { own });
        }
        let mut reduced = false;
        for element in transmission.named("joint").chain(transmission.named("actuator")) {
            for reduction in element.children.iter().filter(|child| is_reduction(child)) {
                reduced |= number_within(document, reduction)? != 1.0;
            }
        }
        commands.reductions += usize::from(reduced);
    }
    let mut of_control: Vec<Option<Vec<Interface>>> = vec![None; robot.joints.len()];
    for joint in document.root.named("ros2_control").flat_map(|control| control.named("joint")) {
        let Some(place) = joint.value("name").and_then(|name| robot.joint(name)) else { continue };
        for command in joint.named("command_interface") {
            let known = Interface::ALL.into_iter().find(|one| command.value("name") == Some(one.name()));
            of_control[place].get_or_insert_default().extend(known);
        }
    }
    for ((joint, first), second) in robot.joints.iter().zip(of_transmissions).zip(of_control) {
        let stated = first.is_some() || second.is_some();
        let mut interfaces = first.filter(|all| !all.is_empty()).or(second).unwrap_or_default();
        interfaces.sort_unstable();
        interfaces.dedup();
        if stated {
            commands.joints.push(Commanded { joint: joint.name.clone(), interfaces });
        }
    }
    Ok(commands)
}

/// All `<transmission>` of a document.
pub(super) fn transmissions(document: &Document) -> impl Iterator<Item = &Element> {
    let root = &document.root;
    let nested = root.named("ros2_control").flat_map(|control| control.named("transmission"));
    root.named("transmission").chain(nested)
}

pub(super) fn is_reduction(element: &Element) -> bool {
    matches!(element.tag.as_str(), "mechanicalReduction" | "mechanical_reduction")
}

/// The hardware interfaces of a joint or an actuator of a transmission, with or without the name of their package.
fn hardware(document: &Document, element: &Element) -> Vec<Interface> {
    let mut all = Vec::new();
    for interface in element.named("hardwareInterface") {
        let text = within(document, interface);
        all.extend_from_slice(match text.rsplit('/').next().unwrap_or_default() {
            "PositionJointInterface" => &[Interface::Position],
            "VelocityJointInterface" => &[Interface::Velocity],
            "EffortJointInterface" => &[Interface::Effort],
            "PosVelJointInterface" | "PosVelAccJointInterface" => &[Interface::Position, Interface::Velocity],
            _ => &[],
        });
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Model;

    /// The commands to `a` and `b` of a URDF with these elements.
    fn commands(elements: &str) -> Commands {
        let link = |name: &str| format!("<link name='{name}'/>");
        let joint = |name: &str, [parent, child]: [&str; 2]| {
            format!("<joint name='{name}' type='continuous'><parent link='{parent}'/><child link='{child}'/></joint>")
        };
        let (links, joints) =
            (["base", "one", "two"].map(link).concat(), joint("a", ["base", "one"]) + &joint("b", ["one", "two"]));
        let text = format!("<robot name='r'>{links}{joints}{elements}</robot>");
        let Model::Urdf(urdf) = Model::parse("r.urdf".as_ref(), &text).unwrap() else { panic!("{text}") };
        urdf.commands().clone()
    }

    fn of(commands: &Commands, joint: &str) -> Option<Vec<&'static str>> {
        let found = commands.joints.iter().find(|one| one.joint == joint)?;
        Some(found.interfaces.iter().map(|one| one.name()).collect())
    }

    #[test]
    fn a_transmission_states_the_interface_at_its_joint_or_its_actuator() {
        let found = commands(
            "<transmission name='x'><joint name='a'><hardwareInterface> hardware_interface/VelocityJointInterface </hardwareInterface></joint>\
             <actuator name='m'><mechanicalReduction>50</mechanicalReduction></actuator></transmission>\
             <transmission name='y'><joint name='b'/><actuator name='n'><hardwareInterface>EffortJointInterface</hardwareInterface>\
             <mechanicalReduction>1</mechanicalReduction></actuator></transmission>",
        );
        assert_eq!((of(&found, "a"), of(&found, "b")), (Some(vec!["velocity"]), Some(vec!["effort"])));
        assert_eq!(found.reductions, 1);
    }

    #[test]
    fn ros2_control_counts_where_no_transmission_states_an_interface() {
        let found = commands(
            "<transmission name='x'><joint name='a'><hardwareInterface>EffortJointInterface</hardwareInterface></joint></transmission>\
             <ros2_control name='c' type='system'><joint name='a'><command_interface name='position'/></joint>\
             <joint name='b'><command_interface name='velocity'/><command_interface name='position'/><state_interface name='effort'/></joint>\
             <transmission name='y'><joint name='b'><mechanical_reduction>2</mechanical_reduction></joint></transmission></ros2_control>",
        );
        assert_eq!((of(&found, "a"), of(&found, "b")), (Some(vec!["effort"]), Some(vec!["position", "velocity"])));
        assert_eq!(found.reductions, 1);
    }

    #[test]
    fn what_is_none_of_the_three_is_listed_without_interface() {
        let found = commands(
            "<transmission name='x'><joint name='a'><hardwareInterface>my/OwnInterface</hardwareInterface></joint></transmission>",
        );
        assert_eq!((of(&found, "a"), of(&found, "b")), (Some(vec![]), None));
        assert_eq!(commands(""), Commands::default());
    }
}
