//! Effects that a model states, in place of their commented tables in the file that `init robot` writes.

use super::template::line;

/// The effect `firmware_gain` in place of its commented table, a factor for each joint, to be tuned. A log with one gain shows the product of
/// gain and torque limit where no motor is at its limit: the limit stays as it is stated, and the gain is tuned, which models often
/// state by orders of magnitude too large.
pub(super) fn with_tuned_gains(text: String) -> String {
    let said = "# Recordings at one gain show the product of gain and torque limit: `tune` changes the gain here, and keeps the limits below (`stall_torque`).";
    with_tuned(text, ("firmware_gain", "factor"), said)
}

/// The effect `command_offset` in place of its commented table, to be tuned: commands of a log are often positions of another arm, whose zeros
/// are not those of this one.
pub(super) fn with_tuned_offsets(text: String) -> String {
    let said = "# The device that gives the commands, such as a leader arm, may have other zeros: `tune` changes these offsets.";
    with_tuned(text, ("command_offset", "rad"), said)
}

/// An effect in place of its commented table, to be tuned. One number holds for all joints, also after the table of one is taken out.
fn with_tuned(text: String, (effect, key): (&str, &str), said: &str) -> String {
    let head = format!("# [effects.{effect}]\n");
    let Some((before, table)) = text.split_once(&head) else { return text };
    let (table, after) = table.split_once("\n\n").unwrap_or((table, ""));
    let table = table.replacen(&format!("# {key} ="), &format!("{key} ="), 1);
    let table = table.replacen("# tune = false", "tune = true", 1);
    format!("{before}[effects.{effect}]\n{}{table}\n\n{after}", line(said))
}

/// An effect that the model states, by an attribute of its actuators, in place of its commented table; as it is where all numbers are 0.
pub(super) fn with_stated(text: String, (effect, key, attribute): (&str, &str, &str), values: &[f64]) -> String {
    let head = format!("# [effects.{effect}]\n");
    let Some((before, table)) = text.split_once(&head).filter(|_| values.iter().any(|v| *v != 0.0)) else {
        return text;
    };
    let (table, after) = table.split_once("\n\n").unwrap_or((table, ""));
    let table = table.replacen(&format!("# {key} = 0.0"), &format!("{key} = {}", one_or_list(values)), 1);
    format!("{before}[effects.{effect}]\n# Of the model: `{attribute}` of its actuators.\n{table}\n\n{after}")
}

/// One number where all joints have the same.
fn one_or_list(values: &[f64]) -> String {
    match values {
        [first, rest @ ..] if rest.iter().all(|v| v == first) => format!("{first:?}"),
        _ => format!("{values:?}"),
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use crate::SimulationFile;
    use crate::robot::stated_motors;
    use crate::simulation_file::robot_template::{RobotStart, robot_template};

    const MODEL: &str = "<mujoco><compiler angle='radian'/><worldbody>\
        <body><joint name='lift' damping='0.6'/><geom size='0.1'/>\
        <body><joint name='reach' type='slide'/><geom size='0.1'/></body></body></worldbody>\
        <actuator><position joint='lift' kp='18' kv='1.5' forcerange='-3 3' timeconst='0.015' delay='0.02'/>\
        <motor joint='reach'/></actuator></mujoco>";

    #[test]
    fn filters_and_delays_of_the_model_are_effects_of_the_file() {
        let path = Path::new("m.xml");
        let robot = tunenet_models::Model::parse_alone(path, MODEL).unwrap();
        let start = RobotStart { motors: stated_motors(robot.robot()), ..RobotStart::default() };
        let text = robot_template("m.xml", &crate::arm::model_file::parse_mjcf(path, MODEL).unwrap(), &start);
        let file =
            SimulationFile::parse(Path::new("robot.toml"), &text).unwrap_or_else(|error| panic!("{error}\n{text}"));
        let found = file.robot_effects().unwrap();
        let stated: Vec<(&str, &[f64])> = found.iter().map(|e| (e.effect.name, e.values.as_slice())).collect();
        assert!(stated.contains(&("command_lag", &[0.015, 0.0])), "{stated:?}");
        assert!(stated.contains(&("command_delay", &[0.02, 0.0])), "{stated:?}");
    }

    #[test]
    fn what_all_joints_share_is_one_number() {
        assert_eq!(super::one_or_list(&[0.02, 0.02]), "0.02");
        assert_eq!(super::one_or_list(&[0.02, 0.0]), "[0.02, 0.0]");
        assert_eq!(super::one_or_list(&[1e-7]), "1e-7");
    }
}
