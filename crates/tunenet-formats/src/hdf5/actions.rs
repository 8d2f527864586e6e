//! Whether actions are what joints are sent to: those of many simulators are steps of the end effector, and as wide as the joints.

use super::tree::Columns;
use crate::findings;
use tunenet_core::observation::Note;

/// What arrays of joint angles are called.
const JOINTS: [&str; 6] = ["joint_pos", "joint_position", "joint_positions", "qpos", "joints", "q"];

/// What arrays of commands are called.
const ACTIONS: [&str; 2] = ["actions", "action"];

/// What names and controllers of simulators say where actions are steps or poses of the end effector.
const RELATIVE: [&str; 8] = ["ik-rel", "ik_rel", "ik-abs", "ik_abs", "osc", "delta", "relative", "eef"];

/// Root mean square of the distance from joints to actions over the spread of the joints, above which actions do not follow
/// them: commands that are followed stay below 1.
const FAR: f64 = 3.0;

/// That the actions are as wide as the joints and mean something else, as far as it shows.
pub(super) fn not_joints(columns: &Columns, environment: &str) -> Option<Note> {
    let of = |known: &[&str]| -> Vec<usize> {
        let array = |name: &str| {
            let (array, number) = name.rsplit_once('.')?;
            number.parse::<usize>().ok()?;
            Some(array.to_owned())
        };
        let is = |array: &String| known.contains(&array.rsplit('.').next().unwrap_or_default());
        let mut names = columns.names.iter().filter_map(|name| array(name)).filter(is).collect::<Vec<String>>();
        names.sort_by_key(String::len);
        let Some(first) = names.first() else { return Vec::new() };
        (0..columns.names.len()).filter(|i| array(&columns.names[*i]).as_ref() == Some(first)).collect()
    };
    let (actions, joints) = (of(&ACTIONS), of(&JOINTS));
    if actions.is_empty() || actions.len() != joints.len() {
        return None;
    }
    let lower = environment.to_lowercase();
    let said = RELATIVE.iter().any(|word| lower.contains(word));
    let far =
        actions.iter().zip(&joints).filter(|(action, joint)| far(columns.column(**action), columns.column(**joint)));
    let shows = 2 * far.count() > actions.len();
    if !said && !shows {
        return None;
    }
    let why = match (said, shows) {
        (true, true) => "its `env_args` name a controller of the end effector, and they do not follow the joints",
        (true, false) => "its `env_args` name a controller of the end effector",
        _ => "they do not follow the joints",
    };
    let text = format!("the actions are as wide as the joints ({}), and are no joint angles: {why}", joints.len());
    Some(Note::new(findings::ACTIONS_OTHER, text, "do not drive joints with them; record the joint targets"))
}

/// Whether an action stays far from what the joint does.
fn far(action: impl Iterator<Item = f64>, joint: impl Iterator<Item = f64> + Clone) -> bool {
    let count = joint.clone().count().max(1) as f64;
    let mean = joint.clone().sum::<f64>() / count;
    let spread = (joint.clone().map(|q| (q - mean).powi(2)).sum::<f64>() / count).sqrt();
    let distance = (action.zip(joint).map(|(a, q)| (a - q).powi(2)).sum::<f64>() / count).sqrt();
    distance > FAR * spread && distance > 0.0
}
