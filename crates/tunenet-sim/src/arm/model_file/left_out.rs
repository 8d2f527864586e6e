//! What an MJCF holds and the model of an arm leaves out, as notes.

use tunenet_core::observation::Note;
use tunenet_models::{Changes, Joint, Robot};

use crate::findings;

/// Most things that one note names.
const MOST_NAMED: usize = 12;

/// All that is left out: what may matter first.
pub(super) fn notes(robot: &Robot) -> Vec<Note> {
    let mut notes = Vec::new();
    let matters = |changes| matches!(changes, Changes::Structure | Changes::Dynamics | Changes::Unknown);
    let named: Vec<String> =
        robot.unused.iter().filter(|left| matters(left.changes)).map(ToString::to_string).collect();
    if !named.is_empty() {
        let text = format!("the model file states what the arm leaves out: {}", listed(&named));
        notes.push(Note::new(findings::MODEL_LEFT_OUT, text, "check that it does not matter, or remove it"));
    }
    let effects = [
        ("armature (`effects.armature`)", (|joint| joint.armature) as fn(&Joint) -> f64),
        ("springs (`effects.joint_spring`)", |joint| joint.stiffness),
    ];
    for (what, number) in effects {
        let stated = robot.joints.iter().filter(|joint| number(joint) != 0.0);
        let stated: Vec<String> = stated.map(|joint| format!("`{}` {}", joint.name, number(joint))).collect();
        if !stated.is_empty() {
            let text = format!(
                "the model file states {what}, which the arm takes from the simulation file: {}",
                listed(&stated)
            );
            notes.push(Note::new(findings::MODEL_EFFECTS, text, "write them under [effects] if they are to count"));
        }
    }
    let bent: Vec<String> = robot
        .couplings
        .iter()
        .filter(|coupling| coupling.coefficients[2..].iter().any(|c| *c != 0.0))
        .map(|coupling| format!("`{}`", robot.joints[coupling.joint].name))
        .collect();
    if !bent.is_empty() {
        let text = format!("joints that follow another one by a curve move freely here: {}", listed(&bent));
        notes.push(Note::new(findings::MODEL_LEFT_OUT, text, ""));
    }
    if let Some([x, y, z]) = robot.gravity_m_s2
        && (x != 0.0 || y != 0.0 || (z + 9.81).abs() > 0.01)
    {
        let text = format!("the model file's gravity is {x} {y} {z} m/s²; the arm takes that of the simulation file");
        notes.push(Note::new(findings::MODEL_LEFT_OUT, text, "set `world.gravity_m_s2`, or tilt the base"));
    }
    let mut kinds: Vec<String> =
        robot.unused.iter().filter(|left| !matters(left.changes)).map(|left| format!("<{}>", left.element)).collect();
    kinds.sort();
    kinds.dedup();
    let drives = robot.actuators.len();
    if drives > 0 {
        kinds.push(format!("{drives} actuators (the recorded torques drive the arm)"));
    }
    if !kinds.is_empty() {
        let text = format!("of the model file are left out, without effect on torques: {}", listed(&kinds));
        notes.push(Note::new(findings::URDF_IGNORED, text, ""));
    }
    notes
}

fn listed(all: &[String]) -> String {
    let text = all.iter().take(MOST_NAMED).cloned().collect::<Vec<_>>().join(", ");
    if all.len() > MOST_NAMED { format!("{text} and {} more", all.len() - MOST_NAMED) } else { text }
}
