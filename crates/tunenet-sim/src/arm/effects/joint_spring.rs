//! A spring across the joint: a cable, a counterbalance.

use tunenet_core::simulator::{Coefficient, Follows, Phase};

use super::{ArmEffect, add};

pub(super) const EFFECT: ArmEffect = ArmEffect {
    name: "joint_spring",
    phase: &Phase::Joint,
    per_joint: true,
    coefficients: &[Coefficient::new("nm_rad", "N·m/rad", 0.0, (-1000.0, 1000.0), 0.1)],
    plausible: &[(-500.0, 500.0)],
    sentence: "something pulls the joint towards its zero: the motor adds k · q (below 0: pushes it away)",
    mistaken_for: &["torque_bias", "joint_offset", "joint_elasticity", "armature"],
    excited_by: (Follows::Pose, "grows from its rest in a straight line"),
    apply: |arm, c| add(&mut arm.spring_nm_rad, c),
};
