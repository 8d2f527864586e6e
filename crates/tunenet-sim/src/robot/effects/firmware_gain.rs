//! A gain of the firmware that differs from the stated one.

use tunenet_core::simulator::{Coefficient, Phase, Side};

use super::super::numbers::Number;
use super::{Act, RobotEffect, RobotTwin};

pub(super) const EFFECT: RobotEffect = RobotEffect {
    name: "firmware_gain",
    phase: Phase::Actuator,
    per_joint: true,
    coefficients: &[Coefficient::new("factor", "1", 1.0, (0.001, 20.0), 0.3)],
    plausible: &[(0.2, 5.0)],
    sentence: "the gain of the firmware is this many times what the file says",
    mistaken_for: &["duty_limit", "firmware_damping", "load_friction", "extra_load"],
    restates: Some("gain_1_rad"),
    repeated_by: &[],
    // A · clip(g c kp e, 1) is clip(c kp e, d) times A/d with d = 1/g.
    twins: &[RobotTwin {
        name: "duty_limit",
        side: Side::Above,
        tuned: Some(Number::StallTorque),
        separated_by: "measure the torque or the current of the stalled motor at full duty, or look them up in its data sheet",
    }],
    act: Act::Drives(|drive, c| drive.gain_factor *= c[0]),
};
