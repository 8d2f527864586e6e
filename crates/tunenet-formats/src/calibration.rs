//! Calibration files of LeRobot: over how many counts of its encoder each joint's normalised numbers go.
//!
//! Source: the files that the `lerobot` package writes, `{"elbow": {"range_min": …, "range_max": …}, …}` and, before 2025,
//! `{"motor_names": […], "start_pos": […], "end_pos": […], "calib_mode": […]}`.

use std::path::Path;

use serde_json::Value;

use crate::encoding::read_text;
use crate::units::{Calibrated, UnitRule};
use crate::{Error, Result};

/// Counts a turn of the encoders of Feetech STS and Dynamixel X.
const COUNTS: f64 = 4096.0;
/// Degrees in such files go from minus this to this.
const MOST_DEGREES: f64 = 270.0;
/// More turns than this are no joint's.
const MOST_TURNS: f64 = 16.0;
/// The joint whose numbers go from 0 to 100; those of all others go from -100 to 100.
const GRIPPER: &str = "gripper";
/// A larger file is no calibration of a robot, bytes.
const LARGEST: u64 = 1 << 20;

/// The unit of each joint that the calibration file at `path` is about.
///
/// # Errors
/// [`Error::Io`] or [`Error::File`] where it cannot be read or is no calibration file.
pub fn read_calibration(path: impl AsRef<Path>) -> Result<Vec<UnitRule>> {
    let path = path.as_ref();
    let refuse = |message: String| {
        let hint = "name the file that LeRobot wrote when the robot was calibrated: by default \
                    ~/.cache/huggingface/lerobot/calibration/robots/TYPE/ID.json";
        Error::file(path, message, hint)
    };
    if std::fs::metadata(path).is_ok_and(|about| about.len() > LARGEST) {
        return Err(refuse(format!("expected a calibration file of LeRobot, found more than {LARGEST} bytes")));
    }
    let value: Value = serde_json::from_str(&read_text(path)?).map_err(|e| refuse(format!("expected JSON: {e}")))?;
    let rules = if value.get("motor_names").is_some() { by_lists(&value) } else { by_joints(&value) };
    rules.map_err(refuse)
}

/// A file with an object for each joint.
fn by_joints(value: &Value) -> std::result::Result<Vec<UnitRule>, String> {
    let expected = "expected a calibration file of LeRobot, with `range_min` and `range_max` for each joint";
    let joints = value.as_object().filter(|joints| !joints.is_empty());
    let joints = joints.ok_or_else(|| format!("{expected}, found none"))?;
    let one = |(name, about): (&String, &Value)| {
        let end = |key: &str| about.get(key).and_then(Value::as_f64);
        let (Some(low), Some(high)) = (end("range_min"), end("range_max")) else {
            return Err(format!("{expected}, found none for `{name}`"));
        };
        rule(name, low, high, if name == GRIPPER { (0.0, 100.0) } else { (-100.0, 100.0) })
    };
    joints.iter().map(one).collect()
}

/// A file with a list for each property.
fn by_lists(value: &Value) -> std::result::Result<Vec<UnitRule>, String> {
    let row = |key: &str| value.get(key).and_then(Value::as_array).map(Vec::as_slice).unwrap_or_default();
    let (names, modes, starts, ends) = (row("motor_names"), row("calib_mode"), row("start_pos"), row("end_pos"));
    if names.is_empty() || [modes, starts, ends].iter().any(|list| list.len() != names.len()) {
        let found = [names, modes, starts, ends].map(<[Value]>::len).map(|count| count.to_string());
        return Err(format!(
            "expected `motor_names`, `calib_mode`, `start_pos` and `end_pos` of one length, found {}",
            found.join(", ")
        ));
    }
    let one = |i: usize| match (names[i].as_str(), modes[i].as_str(), starts[i].as_f64(), ends[i].as_f64()) {
        (Some(name), Some("DEGREE"), ..) => {
            rule(name, 0.0, MOST_DEGREES * COUNTS / 180.0, (-MOST_DEGREES, MOST_DEGREES))
        }
        (Some(name), Some("LINEAR"), Some(start), Some(end)) => {
            rule(name, start.min(end), start.max(end), (0.0, 100.0))
        }
        _ => Err(format!("expected `calib_mode` DEGREE or LINEAR for motor {}, found {}", i + 1, modes[i])),
    };
    (0..names.len()).map(one).collect()
}

/// The rule of a joint whose numbers go over `within` from one count to another.
fn rule(name: &str, low: f64, high: f64, within: (f64, f64)) -> std::result::Result<UnitRule, String> {
    let counts = high - low;
    if !(1.0..=MOST_TURNS * COUNTS).contains(&counts) {
        return Err(format!("`{name}`: expected counts from a lower to a higher one, found {low} to {high}"));
    }
    let step = (within.1 - within.0) / counts;
    let calibrated = Some(Calibrated { counts, within, step });
    Ok(UnitRule { name: name.to_owned(), factor: 360.0 / COUNTS / step, unit: "deg".into(), calibrated })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Result<Vec<UnitRule>> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("follower.json");
        std::fs::write(&path, text).unwrap();
        read_calibration(&path)
    }

    #[test]
    fn counts_of_a_range_are_degrees_for_each_unit() {
        let joint = |min: u32, max: u32| {
            format!(r#"{{"id": 1, "drive_mode": 0, "homing_offset": -12, "range_min": {min}, "range_max": {max}}}"#)
        };
        let text = format!(r#"{{"elbow": {}, "gripper": {}}}"#, joint(1000, 3048), joint(2000, 3024));
        let rules = read(&text).unwrap();
        // 2048 counts are 180°, over 200 units; 1024 counts are 90°, over 100.
        let of = |name: &str| rules.iter().find(|rule| rule.name == name).unwrap();
        assert!((of("elbow").factor - 0.9).abs() < 1e-12 && (of("gripper").factor - 0.9).abs() < 1e-12, "{rules:?}");
        assert_eq!(of("elbow").calibrated.as_ref().unwrap().within, (-100.0, 100.0));
        assert_eq!(
            (of("gripper").unit.as_str(), of("gripper").calibrated.as_ref().unwrap().within),
            ("deg", (0.0, 100.0))
        );
    }

    #[test]
    fn files_of_before_state_degrees_and_percent() {
        let rules = read(
            r#"{"homing_offset": [-2048, 0], "drive_mode": [1, 0], "start_pos": [2000, 3024], "end_pos": [3000, 2000],
                "calib_mode": ["DEGREE", "LINEAR"], "motor_names": ["elbow", "gripper"]}"#,
        )
        .unwrap();
        assert_eq!((rules[0].factor, rules[0].unit.as_str()), (1.0, "deg"));
        assert_eq!(rules[0].calibrated.as_ref().unwrap().within, (-270.0, 270.0));
        assert!((rules[1].factor - 0.9).abs() < 1e-12, "{rules:?}");
    }

    #[test]
    fn what_is_no_calibration_is_refused_in_one_sentence() {
        for (text, wanted) in [
            ("{", "expected JSON"),
            ("[1]", "expected a calibration file of LeRobot"),
            ("{}", "found none"),
            (r#"{"elbow": {"id": 1}}"#, "found none for `elbow`"),
            (
                r#"{"elbow": {"range_min": 3000, "range_max": 1000}}"#,
                "`elbow`: expected counts from a lower to a higher one",
            ),
            (r#"{"elbow": {"range_min": 0, "range_max": 1e9}}"#, "found 0 to 1000000000"),
            (r#"{"motor_names": ["a"], "calib_mode": []}"#, "of one length, found 1, 0, 0, 0"),
            (
                r#"{"motor_names": ["a"], "calib_mode": ["?"], "start_pos": [0], "end_pos": [1]}"#,
                "expected `calib_mode` DEGREE or LINEAR for motor 1",
            ),
        ] {
            let message = read(text).unwrap_err().to_string();
            assert!(message.contains(wanted) && !message.contains('\n'), "{text}: {message}");
        }
    }
}
