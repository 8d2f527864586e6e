//! A released motor that brakes.

use tunenet_core::simulator::{Coefficient, Phase};

use super::super::numbers::Number;
use super::{Act, RobotEffect};

pub(super) const EFFECT: RobotEffect = RobotEffect {
    name: "release_braking",
    phase: Phase::Joint,
    per_joint: true,
    coefficients: &[Coefficient::new("nms_rad", "N·m·s/rad", 0.0, (0.0, 100.0), 0.02)],
    plausible: &[(0.0, 50.0)],
    sentence: "a released motor still brakes the joint in proportion to its speed",
    mistaken_for: &["viscous_friction", "release_delay"],
    restates: None,
    // A motor that is on brakes by both, one that is released by the first alone.
    repeated_by: &[Number::Viscous, Number::BackEmf],
    twins: &[],
    act: Act::Drives(|drive, c| drive.release_braking_nms_rad += c[0]),
};
