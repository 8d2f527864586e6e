//! A gear that twists under its load.

use tunenet_core::simulator::{Coefficient, Follows, Phase};

use super::{ArmEffect, add};

pub(super) const EFFECT: ArmEffect = ArmEffect {
    name: "joint_elasticity",
    phase: &Phase::Joint,
    per_joint: true,
    coefficients: &[Coefficient::new("rad_nm", "rad/(N·m)", 0.0, (0.0, 0.1), 0.0002)],
    plausible: &[(0.0, 0.1)],
    sentence: "the gear gives way: the link stands behind the encoder by e times the joint's torque",
    mistaken_for: &["joint_offset", "joint_spring", "armature", "torque_gain"],
    excited_by: (Follows::Rate, "follows the torque and its slopes"),
    apply: |arm, c| add(&mut arm.elasticity_rad_nm, c),
};
