//! An offset of the payload's centre of mass.

use tunenet_core::simulator::{Coefficient, Follows, Phase};

use super::{ArmEffect, add};

pub(super) const EFFECT: ArmEffect = ArmEffect {
    name: "payload_com_offset",
    phase: &Phase::Joint,
    per_joint: false,
    coefficients: &[
        Coefficient::new("x_m", "m", 0.0, (-1.0, 1.0), 0.01),
        Coefficient::new("y_m", "m", 0.0, (-1.0, 1.0), 0.01),
        Coefficient::new("z_m", "m", 0.0, (-1.0, 1.0), 0.01),
    ],
    plausible: &[(-0.5, 0.5), (-0.5, 0.5), (-0.5, 0.5)],
    sentence: "the payload's centre of mass differs from the file's, in the axes of its link",
    mistaken_for: &["joint_offset", "base_tilt", "torque_gain"],
    excited_by: (Follows::Load, "is gone without the payload"),
    apply: |arm, c| add(&mut arm.com_offset_m, c),
};
