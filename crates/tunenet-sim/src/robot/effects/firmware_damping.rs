//! Damping in the firmware.

use tunenet_core::simulator::{Coefficient, Phase};

use super::{Act, RobotEffect};

pub(super) const EFFECT: RobotEffect = RobotEffect {
    name: "firmware_damping",
    phase: Phase::Actuator,
    per_joint: true,
    coefficients: &[Coefficient::new("kd", "s/rad", 0.0, (-10.0, 10.0), 0.02)],
    plausible: &[(-2.0, 2.0)],
    sentence: "the firmware takes duty away in proportion to the speed",
    mistaken_for: &["firmware_gain", "command_delay", "load_friction", "extra_load"],
    restates: Some("kd"),
    repeated_by: &[],
    twins: &[],
    act: Act::Drives(|drive, c| drive.kd += c[0]),
};
