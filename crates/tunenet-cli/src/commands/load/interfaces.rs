//! What is to be known of the commands to the joints of a URDF.

use tunenet_core::observation::Note;
use tunenet_core::text::visible;
use tunenet_models::urdf::{Commanded, Commands, Interface};
use tunenet_sim::findings;

use crate::view::text::listed;

/// Joints with commands of several kinds, of which the first counts, and those with none that is known.
pub fn notes(commands: &Commands) -> Vec<Note> {
    let several = commands.joints.iter().filter(|joint| joint.interfaces.len() > 1);
    let named = |joint: &Commanded| {
        let names = joint.interfaces.iter().copied().map(Interface::name).collect::<Vec<_>>();
        format!("`{}` ({})", visible(&joint.joint), names.join(", "))
    };
    let several: Vec<String> = several.map(named).collect();
    let others = commands.joints.iter().filter(|joint| joint.interfaces.is_empty());
    let others: Vec<&str> = others.map(|joint| joint.joint.as_str()).collect();
    let mut notes = Vec::new();
    if !several.is_empty() {
        let text = format!("joints with commands of several kinds, of which the first counts: {}", several.join(", "));
        notes.push(Note::new(findings::MODEL_LEFT_OUT, text, "set `drive` under [joints] if the log has another one"));
    }
    if !others.is_empty() {
        let text = format!("joints whose commands are no position, velocity or effort by the URDF: {}", listed(others));
        notes.push(Note::new(findings::MODEL_LEFT_OUT, text, "set `drive` under [joints]; \"position\" is written"));
    }
    notes
}
