//! Which column of a foreign table could be which joint's: what a message proposes, never what is read.

use super::guess;
use crate::quantity::{Family, Meaning, Quantity, meaning, plain};
use crate::shown::shell_word;

/// The words that say what a column of a joint holds, and the unit that is meant where none is named.
const WORDS: [(Family, &str, &[&str]); 4] = [
    (Quantity::Speed, "rad_s", &["dq", "qd", "vel", "velocity", "velocities", "speed", "qdot"]),
    (Quantity::Torque, "nm", &["tau", "torque", "torques", "effort", "efforts", "eff", "moment", "tq", "nm"]),
    (Quantity::Current, "a", &["i", "cur", "current", "currents", "amp", "amps"]),
    (Quantity::Angle, "rad", &["q", "pos", "position", "positions", "angle", "angles", "theta", "actual"]),
];

/// The option that would make a table with these columns a log of joints; `None` where the names do not say enough. `joints` are
/// those of the URDF, in order, where it is known. What stands in the columns `flags` is 0 or 1, and no measurement.
pub(crate) fn guess_joints(names: &[&str], joints: &[String], flags: &[usize]) -> Option<String> {
    let time = guess::time(names)?;
    let mut found: Vec<(usize, u16, usize)> = Vec::new();
    // A single joint needs no number.
    let single = joints.len() <= 1 && !names.iter().any(|name| name.contains(|c: char| c.is_ascii_digit()));
    for (column, name) in names.iter().enumerate().filter(|(i, _)| *i != time && !flags.contains(i)) {
        let words = words(name);
        let family = WORDS.iter().position(|(_, _, known)| words.iter().any(|w| known.contains(&w.as_str())));
        let number = by_name(name, joints).or_else(|| words.iter().rev().find_map(|w| w.parse().ok()));
        let number = number.or_else(|| single.then_some(1));
        if let (Some(family), Some(number)) = (family, number) {
            found.push((family, number, column));
        }
    }
    // Some count from 0.
    let shift = u16::from(joints.is_empty() || found.iter().all(|f| by_name(names[f.2], joints).is_none()))
        * u16::from(found.iter().any(|f| f.1 == 0));
    let (speed, angle) = (0, 3);
    let useful = |family: usize| found.iter().any(|f| f.0 == family);
    // Positions alone may be a ball's.
    if !useful(1) && !useful(2) && (joints.is_empty() || !useful(angle)) {
        return None;
    }
    found.sort_unstable();
    found.dedup_by_key(|f| (f.0, f.1));
    let mut pairs = Vec::new();
    if plain(names[time]) != "t_s" {
        pairs.push(format!("t_s={}", names[time]));
    }
    let order = [angle, speed, 1, 2];
    for family in order {
        let (of, unit, _) = WORDS[family];
        // What is read already needs no pair.
        let foreign = |column: usize| !matches!(meaning(names[column]), Meaning::Known(..));
        for &(_, number, column) in found.iter().filter(|f| f.0 == family && foreign(f.2)) {
            let degrees = ["deg", "degree", "degrees"].iter().any(|d| words(names[column]).iter().any(|w| w == d));
            let unit = if degrees { unit.replace("rad", "deg") } else { unit.to_owned() };
            let channel = of(number + shift).channel().name;
            // Names that the option could not carry go by their number.
            let plain = names[column].chars().all(|c| c != ',' && c != '=' && !c.is_control());
            let theirs = if plain { names[column].to_owned() } else { (column + 1).to_string() };
            pairs.push(format!("{channel}_{unit}={theirs}"));
        }
    }
    (!pairs.is_empty()).then(|| format!("--columns {}", shell_word(&pairs.join(","))))
}

/// The words of a name, digits apart: `actual_q0` is `actual`, `q`, `0`.
fn words(name: &str) -> Vec<String> {
    let mut all = Vec::new();
    for word in plain(name).split('_') {
        let at = word.find(|c: char| c.is_ascii_digit()).unwrap_or(word.len());
        let (letters, digits) = word.split_at(at);
        all.extend([letters, digits].into_iter().filter(|part| !part.is_empty()).map(str::to_owned));
    }
    all
}

/// The number of the joint whose name stands in a column's, the longest that does.
fn by_name(column: &str, joints: &[String]) -> Option<u16> {
    let column = plain(column);
    let stem = |joint: &String| plain(joint).trim_end_matches("_joint").to_owned();
    let there = joints.iter().enumerate().filter(|(_, joint)| column.contains(&stem(joint)));
    let (at, _) = there.max_by_key(|(_, joint)| stem(joint).len())?;
    u16::try_from(at + 1).ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_are_matched_to_joints() {
        let names = ["time", "actual_q_0", "actual_q_1", "actual_current_0", "actual_current_1"];
        assert_eq!(
            guess_joints(&names, &[], &[]).unwrap(),
            "--columns t_s=time,q1_rad=actual_q_0,q2_rad=actual_q_1,i1_a=actual_current_0,i2_a=actual_current_1"
        );
        let joints = ["shoulder_joint".to_owned(), "elbow_joint".to_owned()];
        let names = ["stamp", "elbow_joint_position", "shoulder_joint_position", "elbow_effort", "shoulder_effort"];
        assert_eq!(
            guess_joints(&names, &joints, &[]).unwrap(),
            "--columns t_s=stamp,q1_rad=shoulder_joint_position,q2_rad=elbow_joint_position,tau1_nm=shoulder_effort,tau2_nm=elbow_effort"
        );
        let names = ["time", "position", "velocity", "torque"];
        let one = "--columns t_s=time,q1_rad=position,dq1_rad_s=velocity,tau1_nm=torque";
        assert_eq!(guess_joints(&names, &[], &[]).unwrap(), one);
        let flagged = ["t_s", "torque_on", "position_rad"];
        assert!(guess_joints(&flagged, &[], &[]).is_some_and(|option| option.contains("tau1_nm=torque_on")));
        assert_eq!(guess_joints(&flagged, &[], &[1]), None);
        assert_eq!(guess_joints(&["time", "height"], &[], &[]), None);
        assert_eq!(guess_joints(&["a", "b"], &joints, &[]), None);
        assert_eq!(guess_joints(&["t_s", "q1_rad", "tau2_nm"], &[], &[]), None, "they are read as they are");
        assert_eq!(guess_joints(&["t_s", "q1_rad", "effort_1"], &[], &[]).unwrap(), "--columns tau1_nm=effort_1");
        assert_eq!(guess_joints(&["t", "q1 [deg]"], &joints, &[]).unwrap(), "--columns t_s=t");
        assert_eq!(guess_joints(&["time", "vel_z"], &[], &[]), None, "a ball's speed is no joint's log");
    }
}
