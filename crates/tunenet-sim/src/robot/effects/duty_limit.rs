//! A limit of the duty below the stated one.

use tunenet_core::simulator::{Coefficient, Phase};

use super::{Act, RobotEffect};

pub(super) const EFFECT: RobotEffect = RobotEffect {
    name: "duty_limit",
    phase: Phase::Actuator,
    per_joint: true,
    coefficients: &[Coefficient::new("fraction", "1", 1.0, (0.02, 1.0), 0.3)],
    plausible: &[(0.1, 1.0)],
    sentence: "the firmware gives at most this fraction of the duty that the file allows",
    mistaken_for: &["firmware_gain", "speed_limit"],
    act: Act::Drives(|drive, c| drive.duty_fraction *= c[0]),
};
