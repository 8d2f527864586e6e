//! Dry friction, the same at every speed.

use tunenet_core::simulator::{Coefficient, Follows, Phase};

use super::{ArmEffect, add};

pub(super) const EFFECT: ArmEffect = ArmEffect {
    name: "coulomb_friction",
    phase: &Phase::Joint,
    per_joint: true,
    coefficients: &[Coefficient::new("nm", "N·m", 0.0, (0.0, 1000.0), 0.1)],
    plausible: &[(0.0, 200.0)],
    sentence: "Coulomb friction in a joint opposes its motion: the motor adds c · sign(dq)",
    mistaken_for: &["viscous_friction", "stribeck_friction"],
    excited_by: (Follows::Speed, "is the same at every speed and turns with the direction"),
    apply: |arm, c| add(&mut arm.coulomb_nm, c),
};
