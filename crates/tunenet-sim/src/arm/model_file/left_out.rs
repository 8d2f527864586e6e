//! What an MJCF holds and the model of an arm leaves out, as notes.

use tunenet_core::observation::Note;
use tunenet_core::text::visible;
use tunenet_models::{Changes, Joint, Robot};

use crate::findings;

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
    let named: Vec<String> =
        robot.unused.iter().filter(|left| matters(left.changes)).map(ToString::to_string).collect();
    if !named.is_empty() {
        let text = format!("the model file states what the simulation leaves out: {}", listed(&named));
        notes.push(Note::new(findings::MODEL_LEFT_OUT, text, "check that it does not matter, or remove it"));
    }
    let effects = [
        ("armature (`effects.armature`)", (|joint| joint.armature) as fn(&Joint) -> f64, driven == Driven::Torques),
        ("springs (`effects.joint_spring`)", |joint| joint.stiffness, true),
    ];
    for (what, number, _) in effects.into_iter().filter(|(.., named)| *named) {
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
        let text = format!("joints that follow another one by a curve move freely here: {}", listed(&bent));
        notes.push(Note::new(findings::MODEL_LEFT_OUT, text, ""));
    }
    if let Some([x, y, z]) = robot.gravity_m_s2
        && (x != 0.0 || y != 0.0 || (z + 9.81).abs() > 0.01)
    {
        let text = format!("the model file's gravity is {x} {y} {z} m/s²; that of the simulation file counts");
        notes.push(Note::new(findings::MODEL_LEFT_OUT, text, "set `world.gravity_m_s2`, or tilt the base"));
    }
    let mut kinds: Vec<String> =
        robot.unused.iter().filter(|left| !matters(left.changes)).map(|left| format!("<{}>", left.element)).collect();
    kinds.sort();
    kinds.dedup();
    let drives = robot.actuators.len();
    if drives > 0 {
        let instead = match driven {
            Driven::Torques => "the recorded torques drive the joints",
            Driven::Commands => "the simulation file describes the motors",
        };
        kinds.push(format!("{drives} actuators ({instead})"));
    }
    if !kinds.is_empty() {
        let text = format!("left out of the model file, without effect on torques: {}", listed(&kinds));
        notes.push(Note::new(findings::URDF_IGNORED, text, ""));
    }
    notes
}

fn listed(all: &[String]) -> String {
    let text = all.iter().take(MOST_NAMED).cloned().collect::<Vec<_>>().join(", ");
    if all.len() > MOST_NAMED { format!("{text} and {} more", all.len() - MOST_NAMED) } else { text }
}
