//! An encoder offset: its zero differs from the URDF's.

use tunenet_core::simulator::{Coefficient, Follows, Phase};

use super::{ArmEffect, add};

pub(super) const EFFECT: ArmEffect = ArmEffect {
    name: "joint_offset",
    phase: &Phase::Measurement,
    per_joint: true,
    coefficients: &[Coefficient::new("rad", "rad", 0.0, (-1.0, 1.0), 0.005)],
    plausible: &[(-0.5, 0.5)],
    sentence: "the joint stands this much farther than its encoder says",
    mistaken_for: &["base_tilt", "payload_com_offset", "joint_elasticity", "torque_bias", "joint_spring"],
    excited_by: (Follows::Pose, "follows gravity as the joint alone turns"),
    apply: |arm, c| add(&mut arm.offset_rad, c),
};
