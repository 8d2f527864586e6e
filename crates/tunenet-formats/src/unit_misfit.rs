//! Whether numbers fit the unit that is stated for them, by their range and by the smallest step between them.

use crate::findings;
use crate::proposal::{encoder_step, proposal};
use crate::units::{ACTION, Calibrated, UnitRule};
use tunenet_core::observation::Note;

/// How far a number may be beyond the ends that a calibration file states, as a share of the way between them.
const BEYOND: f64 = 0.0025;

/// How far the step of numbers may be from the one that a calibration file states, as a share of it.
const NEAR: f64 = 0.01;

/// What was expected of the readings of column `name` under the calibration file of `rule`, and what was found; `None` where they fit it,
/// or where another statement decides.
pub(crate) fn calibration_misfit(name: &str, readings: &[f64], rule: &UnitRule) -> Option<String> {
    // Commands come from another arm, with a calibration of its own.
    let Calibrated { within: (low, high), step, .. } =
        *rule.calibrated.as_ref().filter(|_| !name.starts_with(ACTION))?;
    let slack = BEYOND * (high - low);
    let found = match readings.iter().find(|v| **v < low - slack || **v > high + slack) {
        Some(outside) => format!("{outside}"),
        None => format!("steps of {:.6}", encoder_step(readings).filter(|found| !is_multiple(*found, step))?),
    };
    Some(format!(
        "`{name}`: expected numbers from {low} to {high} in steps of {step:.6}, as the calibration file states, found {found}"
    ))
}

/// Says that the readings of a column do not fit the unit that `rule` states for it: those of a calibration file, or degrees where an
/// encoder counts radians, and the reverse.
pub(crate) fn note_misfit(name: &str, readings: &[f64], rule: &UnitRule) -> Option<Note> {
    if let Some(text) = calibration_misfit(name, readings, rule) {
        let remedy =
            "name the calibration of this robot at the time of the recording, or state the unit with `--units`";
        return Some(Note::new(findings::UNITS_DISAGREE, text, remedy));
    }
    let other = match rule.unit.as_str() {
        "deg" => "rad",
        "rad" => "deg",
        _ => return None,
    };
    let found = proposal(readings);
    (rule.factor == 1.0 && found.unit.as_deref() == Some(other)).then(|| {
        let text = format!("`{name}` is stated to be in {}, and {}", rule.unit, found.why);
        Note::new(findings::UNITS_DISAGREE, text, format!("check the unit: `--units {name}={other}` states the other"))
    })
}

/// Whether the smallest step seen is so many of an encoder's: few readings need not show the next count.
fn is_multiple(found: f64, step: f64) -> bool {
    let times = (found / step).round().max(1.0);
    (found / (times * step) - 1.0).abs() < NEAR
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn degrees_for_radians_are_noticed_and_the_right_unit_is_not() {
        let step = std::f64::consts::TAU / 4096.0;
        let radians: Vec<f64> = (0..400).map(|i| step * f64::from((i * i * 7 + i * 3) % 911)).collect();
        let note = |rule: &str| note_misfit("a", &radians, &UnitRule::parse(rule).unwrap());
        let found = note("a=deg").unwrap();
        assert!(
            found.text.starts_with("`a` is stated to be in deg, and its step 0.001534 is 2π/4096"),
            "{}",
            found.text
        );
        assert!(note("a=rad").is_none() && note("a=2deg").is_none() && note("a=m").is_none());
    }
}
