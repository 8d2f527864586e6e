//! Braking by the square of the speed.

use tunenet_core::simulator::{Coefficient, Phase};

use super::{Act, RobotEffect};

pub(super) const EFFECT: RobotEffect = RobotEffect {
    name: "quadratic_friction",
    phase: Phase::Joint,
    per_joint: true,
    coefficients: &[Coefficient::new("nms2_rad2", "N·m·s²/rad²", 0.0, (0.0, 100.0), 0.01)],
    plausible: &[(0.0, 50.0)],
    sentence: "the joint brakes in proportion to the square of its speed",
    mistaken_for: &["viscous_friction", "speed_limit", "firmware_damping"],
    restates: None,
    repeated_by: &[],
    twins: &[],
    act: Act::Drives(|drive, c| drive.quadratic_nms2_rad2 += c[0]),
};
