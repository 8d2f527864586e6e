//! Errors that the firmware passes over.

use tunenet_core::simulator::{Coefficient, Phase};

use super::{Act, RobotEffect};

pub(super) const EFFECT: RobotEffect = RobotEffect {
    name: "dead_band",
    phase: Phase::Actuator,
    per_joint: true,
    coefficients: &[Coefficient::new("rad", "rad", 0.0, (0.0, 0.5), 0.005)],
    plausible: &[(0.0, 0.1)],
    sentence: "the firmware asks for nothing while the error is smaller than this, and for the rest of it beyond",
    mistaken_for: &["coulomb_friction", "command_offset", "joint_offset", "backlash"],
    restates: None,
    repeated_by: &[],
    twins: &[],
    act: Act::Drives(|drive, c| drive.dead_band_rad += c[0]),
};
