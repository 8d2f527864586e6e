//! A sensor whose scale is wrong, or a motor's torque constant.

use tunenet_core::simulator::{Coefficient, Follows, Phase};

use super::ArmEffect;

pub(super) const EFFECT: ArmEffect = ArmEffect {
    name: "torque_gain",
    phase: &Phase::Measurement,
    per_joint: true,
    coefficients: &[Coefficient::new("factor", "1", 1.0, (0.05, 20.0), 0.02)],
    plausible: &[(0.3, 3.0)],
    sentence: "the measured torque is factor times the true one (a wrong torque constant or gear ratio)",
    mistaken_for: &["armature", "joint_elasticity", "payload_com_offset"],
    excited_by: (Follows::Load, "stays in proportion with the payload and without"),
    apply: |arm, c| arm.gain.iter_mut().zip(c).for_each(|(gain, factor)| *gain *= factor),
};
