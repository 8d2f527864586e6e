//! What a model file holds and the model of an arm leaves out, as notes.

use tunenet_core::observation::Note;
use tunenet_core::text::visible;
use tunenet_models::{Actuator, Changes, Contacts, Filter, Joint, Robot, Target, Unused};

use crate::arm::{Body, Model};
use crate::findings;
use crate::robot::motor_law;

/// Most things that one note names.
const MOST_NAMED: usize = 12;

/// What moves the joints of a model in its simulation.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Driven {
    /// Recorded torques.
    Torques,
    /// Commands, by way of motors that the simulation file describes.
    Commands,
}

/// All that is left out: what may matter first.
pub(super) fn notes(robot: &Robot, driven: Driven) -> Vec<Note> {
    let mut notes = Vec::new();
    let matters = |changes| matches!(changes, Changes::Structure | Changes::Dynamics | Changes::Unknown);
    let mut named: Vec<String> =
        robot.unused.iter().filter(|left| matters(left.changes)).map(ToString::to_string).collect();
    if robot.contacts == Contacts::Stated {
        named.push("contacts between geoms: bodies pass through each other in the simulation".into());
    }
    if !named.is_empty() {
        let text = format!("the model file states what the simulation leaves out: {}", listed(&named));
        notes.push(Note::new(findings::MODEL_LEFT_OUT, text, "check that it does not matter, or remove it"));
    }
    // Joints that commands drive take both from the model.
    let effects = [
        ("armature (`effects.armature`)", (|joint| joint.armature) as fn(&Joint) -> f64),
        ("springs (`effects.joint_spring`)", |joint| joint.stiffness),
    ];
    for (what, number) in effects.into_iter().filter(|_| driven == Driven::Torques) {
        let stated = robot.joints.iter().filter(|joint| number(joint) != 0.0);
        let stated: Vec<String> = stated.map(|joint| format!("`{}` {}", visible(&joint.name), number(joint))).collect();
        if !stated.is_empty() {
            let text = format!(
                "the model file states {what}, which count only if the simulation file has them: {}",
                listed(&stated)
            );
            notes.push(Note::new(findings::MODEL_EFFECTS, text, "write them under [effects] if they are to count"));
        }
    }
    let bent: Vec<String> = robot
        .couplings
        .iter()
        .filter(|coupling| coupling.coefficients[2..].iter().any(|c| *c != 0.0))
        .map(|coupling| format!("`{}`", visible(&robot.joints[coupling.joint].name)))
        .collect();
    if !bent.is_empty() {
        let text = format!("joints that follow another one by a curve are not tied to it here: {}", listed(&bent));
        notes.push(Note::new(findings::MODEL_LEFT_OUT, text, ""));
    }
    if driven == Driven::Commands {
        notes.extend(of_motors(robot));
    }
    if driven == Driven::Torques
        && let Some([x, y, z]) = robot.gravity_m_s2
        && (x != 0.0 || y != 0.0 || (z + 9.81).abs() > 0.01)
    {
        let text = format!("the model file's gravity is {x} {y} {z} m/s²; that of the simulation file counts");
        notes.push(Note::new(findings::MODEL_LEFT_OUT, text, "set `world.gravity_m_s2`, or tilt the base"));
    }
    let tag = |left: &Unused| match &left.attribute {
        Some(attribute) => format!("<{} {attribute}>", left.element),
        None => format!("<{}>", left.element),
    };
    // They are named above as what they do.
    let of_contacts = |left: &Unused| {
        robot.contacts == Contacts::Stated
            && (left.element == "contact" || matches!(left.attribute.as_deref(), Some("contype" | "conaffinity")))
    };
    let others = robot.unused.iter().filter(|left| !matters(left.changes) && !of_contacts(left));
    let mut kinds: Vec<String> = others.map(tag).collect();
    kinds.sort();
    kinds.dedup();
    if robot.contacts == Contacts::ByDefault {
        kinds.push("contacts between geoms (while none touch)".into());
    }
    let drives = robot.actuators.len();
    if drives > 0 && driven == Driven::Torques {
        kinds.push(format!("{drives} actuators (the recorded torques drive the joints)"));
    }
    if !kinds.is_empty() {
        let text = format!("left out of the model file, without effect on torques: {}", listed(&kinds));
        notes.push(Note::new(findings::URDF_IGNORED, text, ""));
    }
    notes
}

/// What a robot's motors and coupled joints have that no joint of the simulation file gets.
fn of_motors(robot: &Robot) -> Vec<Note> {
    let name = |joint: usize| format!("`{}`", visible(&robot.joints[joint].name));
    let count = |joint: usize| robot.actuators.iter().filter(|one| one.target == Target::Joint(joint)).count();
    let several: Vec<String> = (0..robot.joints.len()).filter(|joint| count(*joint) > 1).map(name).collect();
    let on_no_joint = |one: &&Actuator| !matches!(one.target, Target::Joint(_));
    let apart: Vec<String> =
        robot.actuators.iter().filter(on_no_joint).map(|one| format!("`{}`", visible(&one.name))).collect();
    let of = |has: fn(&Actuator) -> bool| -> Vec<String> {
        robot.actuators.iter().filter(|one| has(one)).map(|one| format!("`{}`", visible(&one.name))).collect()
    };
    let filtered = of(|one| matches!(one.filter, Filter::LowPass { .. }));
    let integrating = of(|one| one.filter == Filter::Integrator);
    let delayed = of(|one| one.delay_s > 0.0);
    let uneven = of(|one| one.force_range.is_some_and(|[lower, upper]| lower + upper != 0.0));
    let said = [
        (
            several,
            "joints with several actuators, none of which gives the numbers of the motor",
            "set them under [joints]",
        ),
        (
            of(|one| matches!(one.target, Target::Joint(_)) && motor_law(one).is_none()),
            "actuators that are no servo, drive of a speed or of a torque, none of which gives the numbers of the motor",
            "set `drive` and the gains under [joints]",
        ),
        (
            integrating,
            "actuators that integrate their command (`dyntype`), which the simulation leaves out",
            "remove that from the model if the robot does not: the written model keeps it",
        ),
        (
            filtered,
            "actuators with a filter (`timeconst`), which the simulation has as an effect of its file",
            "write it under [effects.command_lag] where `init` has not",
        ),
        (
            delayed,
            "actuators with a delay, which the simulation has as an effect of its file",
            "write it under [effects.command_delay] where `init` has not",
        ),
        (
            uneven,
            "actuators whose `forcerange` differs by direction; the larger limit holds in both",
            "lower `duty_max` of the joint if the smaller one is reached",
        ),
        (apart, "actuators of tendons, sites and bodies, which the simulation leaves out", ""),
    ];
    said.into_iter()
        .filter(|(all, ..)| !all.is_empty())
        .map(|(all, what, remedy)| Note::new(findings::MODEL_LEFT_OUT, format!("{what}: {}", listed(&all)), remedy))
        .collect()
}

/// Said of joints of a URDF that follow others.
const FOLLOW: &str = "joints that follow others, whose own friction and damping the simulation leaves out";

/// What coupled joints of a URDF have that no joint of the simulation file gets.
pub(super) fn of_mimics(model: &Model) -> Option<Note> {
    let own = |body: &&Body| !body.coordinate.own && (body.joint.damping != 0.0 || body.joint.friction != 0.0);
    let all: Vec<String> =
        model.bodies.iter().filter(own).map(|body| format!("`{}`", visible(&body.joint.name))).collect();
    let text = || format!("{FOLLOW}: {}", listed(&all));
    (!all.is_empty()).then(|| Note::new(findings::MODEL_LEFT_OUT, text(), ""))
}

fn listed(all: &[String]) -> String {
    let text = all.iter().take(MOST_NAMED).cloned().collect::<Vec<_>>().join(", ");
    if all.len() > MOST_NAMED { format!("{text} and {} more", all.len() - MOST_NAMED) } else { text }
}
