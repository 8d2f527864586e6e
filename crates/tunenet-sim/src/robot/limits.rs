//! Positions and commands of a joint against the limits that its model states: another unit, stops, and commands that are clipped.

use tunenet_core::observation::{Note, with_decimals};

use crate::findings;

/// Positions that span more than so many times what the model lets the joint move are in another unit.
const BEYOND_LIMITS: f64 = 3.0;
/// A turning joint that is read farther than this beyond its limits, rad, has another zero than its model: that of encoder counts, say.
const BEYOND_ZERO_RAD: f64 = std::f64::consts::FRAC_PI_2;
/// Turns that a joint makes about a position that it is commanded to: more are rather degrees.
const MOST_TURNS: f64 = 3.0;
/// A joint that is within this share of its travel from a limit, while its command is as far beyond it, for this share of the samples, stands
/// at a stop.
const AT_STOP: f64 = 0.01;
const LONG_AT_STOP: f64 = 0.01;
/// Commands that go beyond their range by this share of it, for this share of the samples, are clipped.
const BEYOND_RANGE: f64 = 0.01;
const LONG_BEYOND_RANGE: f64 = 0.01;

/// That positions span far more than the limits of the model allow.
pub(super) fn beyond_limits(name: &str, moved: f64, (travel, unit): (f64, &str)) -> Option<Note> {
    if moved <= BEYOND_LIMITS * travel {
        return None;
    }
    let text = format!(
        "`{name}` spans {}, and the limits of the model let it move by {}: expected {unit}, found another unit (degrees?)",
        with_decimals(moved, 2),
        with_decimals(travel, 2),
    );
    let remedy = "state the units as they were recorded, or correct the limits in the model";
    Some(Note::new(findings::ROBOT_UNITS, text, remedy))
}

/// That a turning joint, whose zero is `zero` (true less measured position, rad), is read far beyond the limits of the model.
pub(super) fn another_zero(name: &str, values: &[f64], [lower, upper]: [f64; 2], zero: f64) -> Option<Note> {
    let (low, high) =
        values.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (low.min(*v), high.max(*v)));
    let beyond = (lower - low - zero).max(high + zero - upper);
    if !beyond.is_finite() || beyond <= BEYOND_ZERO_RAD {
        return None;
    }
    let [low, high, lower, upper, middle] =
        [low, high, lower, upper, (lower + upper - low - high) / 2.0].map(|number| with_decimals(number, 2));
    let text = format!(
        "`{name}` reads {low} to {high}, and the limits of the model are {lower} to {upper}: expected the zero of the model, found another"
    );
    let remedy = format!(
        "write the joint's `zero` (true less measured position; {middle} puts it amid its limits) into its parameter, with `min` and `max` near it"
    );
    Some(Note::new(findings::ROBOT_ZERO, text, remedy))
}

/// That a joint whose model has no limits, and which follows positions, makes many turns.
pub(super) fn many_turns(name: &str, moved_rad: f64) -> Option<Note> {
    let turns = moved_rad / std::f64::consts::TAU;
    if turns <= MOST_TURNS {
        return None;
    }
    let text = format!(
        "`{name}` spans {} rad, which are {} turns: degrees?",
        with_decimals(moved_rad, 1),
        with_decimals(turns, 1)
    );
    Some(Note::new(findings::ROBOT_UNITS, text, "if they are, state the units as they were recorded"))
}

/// That a joint stands at a limit of the model while its commands go beyond it.
pub(super) fn at_a_stop(
    name: &str,
    (clock, values, goals): (&[f64], &[f64], &[f64]),
    [lower, upper]: [f64; 2],
) -> Option<Note> {
    let near = AT_STOP * (upper - lower);
    let stands = |i: &usize| {
        let at = |limit: f64, sign: f64| (values[*i] - limit).abs() <= near && sign * (goals[*i] - limit) > near;
        at(lower, -1.0) || at(upper, 1.0)
    };
    let stopped = (0..values.len()).filter(stands).count();
    let share = stopped as f64 / values.len().max(1) as f64;
    if share < LONG_AT_STOP {
        return None;
    }
    let lasting = share * (clock.last()? - clock.first()?);
    let text = format!(
        "`{name}` stands at a limit of the model for {} s while its commands go beyond it: stops are not simulated",
        with_decimals(lasting, 2)
    );
    Some(Note::new(findings::ROBOT_STOP, text, "leave these parts out, or keep the commands within the limits"))
}

/// That commands go beyond the range to which the model clips them.
pub(super) fn beyond_command_range(name: &str, commands: &[f64], [lower, upper]: [f64; 2]) -> Option<Note> {
    let slack = BEYOND_RANGE * (upper - lower);
    let beyond = commands.iter().filter(|command| **command < lower - slack || **command > upper + slack).count();
    let share = beyond as f64 / commands.len().max(1) as f64;
    if share < LONG_BEYOND_RANGE {
        return None;
    }
    let [lower, upper] = [lower, upper].map(|end| with_decimals(end, 3));
    let text = format!(
        "`{name}` goes beyond the `ctrlrange` of the model ({lower} to {upper}) in {} % of the samples: the simulation does not \
         clip commands, a copy of the model does",
        with_decimals(100.0 * share, 0)
    );
    let remedy =
        "write `command_range` into the joint's table if the robot clips them too, or widen `ctrlrange` in the model";
    Some(Note::new(findings::ROBOT_COMMAND_RANGE, text, remedy))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counts_of_an_encoder_have_another_zero_than_a_model() {
        let reads = |low: f64, high: f64, zero: f64| another_zero("a_rad", &[low, high], [-2.0, 2.0], zero);
        let said = reads(1.54, 4.76, 0.0).unwrap();
        assert!(said.text.contains("reads 1.54 to 4.76") && said.remedy.contains("-3.15 puts it amid"), "{said:?}");
        assert!(reads(1.54, 4.76, -3.15).is_none() && reads(0.0, 3.5, 0.0).is_none());
        assert!(another_zero("a_rad", &[9.0], [f64::NEG_INFINITY, f64::INFINITY], 0.0).is_none());
    }

    #[test]
    fn many_turns_are_rather_degrees() {
        assert!(many_turns("q_rad", 18.0).is_none());
        let note = many_turns("q_rad", 66.0).unwrap();
        assert_eq!(note.text, "`q_rad` spans 66.0 rad, which are 10.5 turns: degrees?");
    }

    #[test]
    fn commands_beyond_the_range_of_the_model_are_counted() {
        let commands: Vec<f64> = (0..100).map(|i| 0.01 * f64::from(i)).collect();
        let text = beyond_command_range("a_goal_rad", &commands, [-0.3, 0.745]).unwrap().text;
        // 0.745 and 1 % of 1.045 are 0.75545: the last 24 are beyond it.
        let expected = "`a_goal_rad` goes beyond the `ctrlrange` of the model (-0.300 to 0.745) in 24 % of the samples: the \
                        simulation does not clip commands, a copy of the model does";
        assert_eq!(text, expected);
        assert!(beyond_command_range("a_goal_rad", &commands, [0.0, 0.99]).is_none());
    }

    #[test]
    fn positions_far_beyond_the_limits_are_in_another_unit() {
        assert!(beyond_limits("a_rad", 6.0, (5.6, "rad")).is_none());
        assert!(beyond_limits("a_rad", 600.0, (f64::INFINITY, "rad")).is_none());
        let text = beyond_limits("a_rad", 57.0, (5.6, "rad")).unwrap().text;
        let expected = "`a_rad` spans 57.00, and the limits of the model let it move by 5.60: expected rad, found another unit (degrees?)";
        assert_eq!(text, expected);
    }

    #[test]
    fn a_joint_at_its_limit_with_a_command_beyond_it_stands_at_a_stop() {
        let clock: Vec<f64> = (0..400).map(|i| 0.01 * f64::from(i)).collect();
        let goals: Vec<f64> = clock.iter().map(|t| 1.2 * t.sin()).collect();
        let stopped: Vec<f64> = goals.iter().map(|goal| goal.clamp(-1.0, 1.0)).collect();
        // 1.2 sin t exceeds 1.02 for π − 2 asin 0.85 = 1.11 s.
        let text = at_a_stop("lift_m", (&clock, &stopped, &goals), [-1.0, 1.0]).unwrap().text;
        let expected = "`lift_m` stands at a limit of the model for 1.11 s while its commands go beyond it: stops are not simulated";
        assert_eq!(text, expected);
        assert!(at_a_stop("lift_m", (&clock, &goals, &goals), [-1.0, 1.0]).is_none(), "it goes beyond the limit");
        assert!(at_a_stop("lift_m", (&clock, &stopped, &goals), [f64::NEG_INFINITY, f64::INFINITY]).is_none());
    }
}
