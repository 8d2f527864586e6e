//! Friction in proportion to speed, as of grease.

use tunenet_core::simulator::{Coefficient, Follows, Phase};

use super::{ArmEffect, add};

pub(super) const EFFECT: ArmEffect = ArmEffect {
    name: "viscous_friction",
    phase: &Phase::Joint,
    per_joint: true,
    coefficients: &[Coefficient::new("nms_rad", "N·m·s/rad", 0.0, (0.0, 1000.0), 0.1)],
    plausible: &[(0.0, 200.0)],
    sentence: "a joint brakes in proportion to its speed: the motor adds b · dq",
    mistaken_for: &["coulomb_friction", "stribeck_friction", "time_delay"],
    excited_by: (Follows::Speed, "grows in proportion to speed"),
    apply: |arm, c| add(&mut arm.viscous_nms_rad, c),
};
