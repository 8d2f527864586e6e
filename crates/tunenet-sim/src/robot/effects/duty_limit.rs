//! A limit of the duty below the stated one.

use tunenet_core::simulator::{Coefficient, Phase, Side};

use super::super::numbers::Number;
use super::{Act, RobotEffect, RobotTwin};

pub(super) const EFFECT: RobotEffect = RobotEffect {
    name: "duty_limit",
    phase: Phase::Actuator,
    per_joint: true,
    // The least share is that of a limit which no model states: the torque of an error of 0.04 rad instead of 10 rad.
    coefficients: &[Coefficient::new("fraction", "1", 1.0, (0.004, 1.0), 0.3)],
    plausible: &[(0.1, 1.0)],
    sentence: "the firmware gives at most this fraction of the duty that the file allows",
    mistaken_for: &["firmware_gain", "speed_limit", "extra_load"],
    restates: Some("duty_max"),
    repeated_by: &[],
    // A · clip(g c kp e, 1) is clip(c kp e, d) times A/d with d = 1/g.
    twins: &[RobotTwin {
        name: "firmware_gain",
        side: Side::Any,
        tuned: Some(Number::StallTorque),
        separated_by: "measure the torque or the current of the stalled motor at full duty, or look them up in its data sheet",
    }],
    act: Act::Drives(|drive, c| drive.duty_fraction *= c[0]),
};
