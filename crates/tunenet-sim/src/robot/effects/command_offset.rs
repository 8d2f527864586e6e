//! Commands whose zero is not that of the readings: the leader of a teleoperated arm has a calibration of its own.

use tunenet_core::simulator::{Coefficient, Phase};

use super::{Act, RobotEffect};

pub(super) const EFFECT: RobotEffect = RobotEffect {
    name: "command_offset",
    phase: Phase::Actuator,
    per_joint: true,
    coefficients: &[Coefficient::new("rad", "rad", 0.0, (-0.5, 0.5), 0.005)],
    plausible: &[(-0.3, 0.3)],
    sentence: "the motor goes to a position that lies this much above its command",
    mistaken_for: &["directional_friction", "joint_offset", "base_tilt"],
    restates: None,
    repeated_by: &[],
    twins: &[],
    act: Act::Drives(|drive, c| drive.command_offset_rad += c[0]),
};
