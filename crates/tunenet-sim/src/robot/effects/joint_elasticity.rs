//! A gear that twists under its load.

use tunenet_core::simulator::{Coefficient, Phase};

use super::{Act, RobotEffect};

/// As that of arms, but that the encoder is on the link, and that positions show it where it is ten times as large as torques need.
pub(super) const EFFECT: RobotEffect = RobotEffect {
    name: "joint_elasticity",
    phase: Phase::Joint,
    per_joint: true,
    coefficients: &[Coefficient::new("rad_nm", "rad/(N·m)", 0.0, (0.0, 0.1), 0.002)],
    plausible: &[(0.0, 0.1)],
    sentence: "the gear gives way: the motor turns ahead of the link by e times the torque that it carries",
    mistaken_for: &["joint_offset", "joint_spring", "armature", "torque_gain"],
    restates: None,
    repeated_by: &[],
    twins: &[],
    act: Act::Arm(|arm, c| arm.elasticity_rad_nm.iter_mut().zip(c).for_each(|(own, more)| *own += more)),
};
