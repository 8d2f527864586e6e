//! Friction that differs between both directions.

use tunenet_core::simulator::{Coefficient, Phase};

use super::{Act, RobotEffect};

pub(super) const EFFECT: RobotEffect = RobotEffect {
    name: "directional_friction",
    phase: Phase::Joint,
    per_joint: true,
    coefficients: &[Coefficient::new("nm", "N·m", 0.0, (-100.0, 100.0), 0.02)],
    plausible: &[(-50.0, 50.0)],
    sentence: "friction is larger by this much in the direction of positive speed, and smaller in the other",
    mistaken_for: &["command_offset", "joint_offset", "load_friction"],
    restates: None,
    repeated_by: &[],
    twins: &[],
    act: Act::Drives(|drive, c| drive.directional_nm += c[0]),
};
