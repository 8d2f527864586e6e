//! A gain of the firmware that differs from the stated one.

use tunenet_core::simulator::{Coefficient, Phase};

use super::{Act, RobotEffect};

pub(super) const EFFECT: RobotEffect = RobotEffect {
    name: "firmware_gain",
    phase: Phase::Actuator,
    per_joint: true,
    coefficients: &[Coefficient::new("factor", "1", 1.0, (0.05, 20.0), 0.3)],
    plausible: &[(0.2, 5.0)],
    sentence: "the gain of the firmware is this many times what the file says",
    mistaken_for: &["duty_limit", "firmware_damping", "load_friction"],
    act: Act::Drives(|drive, c| drive.gain_factor *= c[0]),
};
