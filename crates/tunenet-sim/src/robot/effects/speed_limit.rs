//! A firmware whose internal goal moves at a limited speed.

use tunenet_core::simulator::{Coefficient, Phase};

use super::{Act, RobotEffect};

pub(super) const EFFECT: RobotEffect = RobotEffect {
    name: "speed_limit",
    phase: Phase::Actuator,
    per_joint: true,
    coefficients: &[Coefficient::new("inverse_s_rad", "s/rad", 0.0, (0.0, 10.0), 0.15)],
    plausible: &[(0.0, 5.0)],
    sentence: "the firmware moves its own goal no faster than 1/s, `inverse_s_rad` being s; 0 is no limit",
    mistaken_for: &["command_delay", "command_lag", "duty_limit", "firmware_damping"],
    restates: None,
    repeated_by: &[],
    twins: &[],
    act: Act::Drives(|drive, c| drive.inverse_speed_s_rad += c[0]),
};
