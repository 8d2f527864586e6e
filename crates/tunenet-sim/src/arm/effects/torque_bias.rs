//! A sensor that shows something where nothing is.

use tunenet_core::simulator::{Coefficient, Follows, Phase};

use super::{ArmEffect, add};

pub(super) const EFFECT: ArmEffect = ArmEffect {
    name: "torque_bias",
    phase: &Phase::Measurement,
    per_joint: true,
    coefficients: &[Coefficient::new("nm", "N·m", 0.0, (-1000.0, 1000.0), 0.1)],
    plausible: &[(-100.0, 100.0)],
    sentence: "the measured torque has a constant offset",
    mistaken_for: &["joint_spring", "joint_offset", "base_tilt"],
    excited_by: (Follows::Pose, "is the same in every pose"),
    apply: |arm, c| add(&mut arm.bias_nm, c),
};
