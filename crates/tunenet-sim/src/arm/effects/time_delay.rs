//! Torque and motion stamped by different clocks.

use tunenet_core::simulator::{Coefficient, Follows, Phase};

use super::ArmEffect;

pub(super) const EFFECT: ArmEffect = ArmEffect {
    name: "time_delay",
    phase: &Phase::Measurement,
    per_joint: false,
    coefficients: &[Coefficient::new("delay_s", "s", 0.0, (-0.5, 0.5), 0.002)],
    plausible: &[(-0.2, 0.2)],
    sentence: "the measured torque is late by a constant against the measured motion",
    mistaken_for: &["viscous_friction"],
    excited_by: (Follows::Rate, "doubles where the torque changes twice as fast"),
    apply: |arm, c| arm.delay_s += c[0],
};
