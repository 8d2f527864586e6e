//! Whether the name of a column, or of the topic that it stands in, speaks of a joint, and of what: its position, or its command.

use tunenet_core::observation::plain;

/// What a column holds of a joint.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct OfJoint {
    /// The quantity that its name or its unit states; `None` where it is the joint's name alone.
    pub quantity: Option<JointQuantity>,
    /// Whether it is what the joint was commanded, not what was measured.
    pub command: bool,
}

/// A quantity of a joint.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum JointQuantity {
    /// An angle, or the way of a slide.
    Position,
    /// Its rate.
    Velocity,
    /// A torque, or the force of a slide.
    Effort,
}

const COMMANDS: [&str; 19] = [
    "action",
    "actions",
    "cmd",
    "cmds",
    "command",
    "commands",
    "commanded",
    "goal",
    "goals",
    "target",
    "targets",
    "des",
    "desired",
    "ref",
    "reference",
    "references",
    "setpoint",
    "setpoints",
    "leader",
];
const POSITIONS: [&str; 8] = ["pos", "position", "positions", "q", "qpos", "angle", "angles", "theta"];
const VELOCITIES: [&str; 8] = ["vel", "velocity", "velocities", "speed", "dq", "qd", "qvel", "rate"];
const EFFORTS: [&str; 7] = ["effort", "efforts", "torque", "torques", "tau", "force", "forces"];
/// Words that say nothing of this.
const OTHERS: [&str; 19] = [
    "joint",
    "joints",
    "state",
    "states",
    "observation",
    "obs",
    "measured",
    "meas",
    "actual",
    "act",
    "feedback",
    "present",
    "follower",
    "servo",
    "motor",
    "encoder",
    "controller",
    "data",
    "points",
];
/// Units at the end of a name, and what is in them.
const UNITS: [(&str, JointQuantity); 16] = [
    ("rad_s", JointQuantity::Velocity),
    ("deg_s", JointQuantity::Velocity),
    ("m_s", JointQuantity::Velocity),
    ("mm_s", JointQuantity::Velocity),
    ("rpm", JointQuantity::Velocity),
    ("rad", JointQuantity::Position),
    ("mrad", JointQuantity::Position),
    ("deg", JointQuantity::Position),
    ("degrees", JointQuantity::Position),
    ("radians", JointQuantity::Position),
    ("mm", JointQuantity::Position),
    ("cm", JointQuantity::Position),
    ("m", JointQuantity::Position),
    ("nm", JointQuantity::Effort),
    ("mnm", JointQuantity::Effort),
    ("n", JointQuantity::Effort),
];
/// Those of them that only what turns has.
const OF_TURNING: [&str; 10] = ["rad_s", "deg_s", "rpm", "rad", "mrad", "deg", "degrees", "radians", "nm", "mnm"];

/// What the column called `column` holds of the joint called `joint`; `None` where its name has words of something else. Of a message with
/// one number, `topic` is what names it.
#[must_use]
pub fn of_joint(column: &str, topic: Option<&str>, joint: &str) -> Option<OfJoint> {
    let joint = words(joint);
    // A namespace before the joint is the robot's.
    let of_topic = topic.map(|topic| {
        let parts: Vec<Vec<String>> = topic.split('/').map(words).filter(|words| !words.is_empty()).collect();
        let first = parts.iter().position(|part| without(part, &joint).is_some()).unwrap_or(0);
        parts[first..].concat()
    });
    let name = [of_topic.unwrap_or_default(), words(column)].concat();
    let (name, unit) = without_unit(&name);
    let mut found = OfJoint { quantity: unit, command: false };
    let mut said = None;
    for word in &without(name, &joint)? {
        match word_of(word)? {
            Word::Command => found.command = true,
            Word::Of(quantity) if said.replace(quantity).is_some_and(|before| before != quantity) => return None,
            Word::Of(_) | Word::Nothing => {}
        }
    }
    found.quantity = said.or(unit);
    Some(found)
}

/// What the column called `column` holds of some joint whose name is not known; `None` where none of its words speaks of joints. A unit
/// of length alone does not: a ball's height has one too.
#[must_use]
pub fn of_some_joint(column: &str) -> Option<OfJoint> {
    // The number of a row's part stands behind the unit: `j_rad.0`.
    let column = column.trim_end_matches(|c: char| c.is_ascii_digit()).trim_end_matches(['.', '_']);
    let name = words(column);
    let (name, unit) = without_unit(&name);
    let unit = unit.filter(|_| unit_of_name(column).is_some_and(|unit| OF_TURNING.contains(&unit)));
    let (mut found, mut said, mut speaks) = (OfJoint { quantity: unit, command: false }, None, unit.is_some());
    for word in name {
        // `position0` is the position of the first joint.
        match word_of(word.trim_end_matches(|c: char| c.is_ascii_digit())) {
            Some(Word::Command) => found.command = true,
            Some(Word::Of(quantity)) if said.replace(quantity).is_some_and(|before| before != quantity) => return None,
            Some(Word::Of(_) | Word::Nothing) => {}
            None => continue,
        }
        speaks = true;
    }
    found.quantity = said.or(unit);
    speaks.then_some(found)
}

/// Whether the name of a topic says that it holds commands: `/arm/commands`.
#[must_use]
pub fn is_of_commands(topic: &str) -> bool {
    words(topic).iter().any(|word| COMMANDS.contains(&word.as_str()))
}

/// The unit that a column's name ends in, with a name before it: `rad` of `elbow_rad`.
#[must_use]
pub fn unit_of_name(column: &str) -> Option<&'static str> {
    let name = plain(column);
    let ends = |unit: &&str| name.strip_suffix(unit).is_some_and(|before| before.len() > 1 && before.ends_with('_'));
    UNITS.iter().map(|(unit, _)| *unit).find(ends)
}

/// What one word of a name says.
enum Word {
    Command,
    Of(JointQuantity),
    Nothing,
}

/// `None` of a word of something else.
fn word_of(word: &str) -> Option<Word> {
    let is = |known: &[&str]| known.contains(&word);
    match () {
        () if is(&COMMANDS) => Some(Word::Command),
        () if is(&POSITIONS) => Some(Word::Of(JointQuantity::Position)),
        () if is(&VELOCITIES) => Some(Word::Of(JointQuantity::Velocity)),
        () if is(&EFFORTS) => Some(Word::Of(JointQuantity::Effort)),
        () if is(&OTHERS) => Some(Word::Nothing),
        () => None,
    }
}

fn words(name: &str) -> Vec<String> {
    plain(name).split('_').filter(|word| !word.is_empty()).map(str::to_owned).collect()
}

/// The words before a unit, and what the unit is of.
fn without_unit(name: &[String]) -> (&[String], Option<JointQuantity>) {
    for (unit, quantity) in UNITS {
        let unit: Vec<&str> = unit.split('_').collect();
        if name.len() > unit.len() && name.ends_with(&unit.iter().map(|word| (*word).to_owned()).collect::<Vec<_>>()) {
            return (&name[..name.len() - unit.len()], Some(quantity));
        }
    }
    (name, None)
}

/// The words of a name around those of a joint; `None` where it does not have these.
fn without(name: &[String], joint: &[String]) -> Option<Vec<String>> {
    if joint.is_empty() {
        return None;
    }
    let at = name.windows(joint.len()).position(|part| part == joint)?;
    Some([&name[..at], &name[at + joint.len()..]].concat())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn found(column: &str, joint: &str) -> Option<(Option<JointQuantity>, bool)> {
        of_joint(column, None, joint).map(|of| (of.quantity, of.command))
    }

    #[test]
    fn words_next_to_the_name_of_a_joint_say_what_a_column_holds() {
        use JointQuantity::{Effort, Position, Velocity};
        for (column, quantity) in [
            ("elbow", None),
            ("elbow_rad", Some(Position)),
            ("elbow.pos", Some(Position)),
            ("q_elbow_deg", Some(Position)),
            ("position.Elbow", Some(Position)),
            ("actual.positions.elbow", Some(Position)),
            ("elbow_rad_s", Some(Velocity)),
            ("velocity.elbow", Some(Velocity)),
            ("tau_elbow_nm", Some(Effort)),
        ] {
            assert_eq!(found(column, "elbow"), Some((quantity, false)), "{column}");
        }
        for (column, quantity) in [
            ("action.elbow", None),
            ("elbow_goal_rad", Some(Position)),
            ("desired.positions.elbow", Some(Position)),
            ("elbow_cmd_vel", Some(Velocity)),
        ] {
            assert_eq!(found(column, "elbow"), Some((quantity, true)), "{column}");
        }
    }

    #[test]
    fn words_of_something_else_are_of_no_joint() {
        for column in
            ["elbow_temperature", "error.positions.elbow", "left_elbow", "elbow_2", "wrist", "t_s", "elbow_pos_vel"]
        {
            assert_eq!(found(column, "elbow"), None, "{column}");
        }
        assert_eq!(found("joint_1_rad", "joint_1"), Some((Some(JointQuantity::Position), false)));
        assert_eq!(found("joint_12_rad", "joint_1"), None);
    }

    #[test]
    fn words_of_joints_count_without_the_name_of_one() {
        use JointQuantity::{Effort, Position, Velocity};
        let of = |column: &str| of_some_joint(column).map(|of| (of.quantity, of.command));
        for (column, expected) in [
            ("qpos.0", (Some(Position), false)),
            ("qvel.1", (Some(Velocity), false)),
            ("action.0", (None, true)),
            ("observation.state.1", (None, false)),
            ("/joint_states/j/position", (Some(Position), false)),
            ("/cmd/j/position", (Some(Position), true)),
            ("field.position0", (Some(Position), false)),
            ("field.cmd0", (None, true)),
            ("j_rad.0", (Some(Position), false)),
            ("elbow_goal_rad", (Some(Position), true)),
            ("tau_3", (Some(Effort), false)),
        ] {
            assert_eq!(of(column), Some(expected), "{column}");
        }
        for column in ["time", "temperature", "height_m", "z_mm", "b", "pos_vel", ""] {
            assert_eq!(of(column), None, "{column}");
        }
    }

    #[test]
    fn a_topic_of_one_number_names_it() {
        let of = |topic: &str| of_joint("data", Some(topic), "joint1").map(|of| of.command);
        assert_eq!(of("/rrbot/joint1_position_controller/command"), Some(true));
        assert_eq!(of("/joint1/position"), Some(false));
        assert_eq!(of("/joint2_position_controller/command"), None);
        assert!(is_of_commands("/arm/commands") && !is_of_commands("/joint_states"));
    }

    #[test]
    fn a_unit_at_the_end_of_a_name_is_found() {
        assert_eq!(
            ["elbow_rad", "elbow.deg", "rate_rad_s", "elbow", "rad"].map(unit_of_name),
            [Some("rad"), Some("deg"), Some("rad_s"), None, None]
        );
    }
}
