//! Inertia of the motor's rotor, seen through the gear.

use tunenet_core::simulator::{Coefficient, Follows, Phase};

use super::{ArmEffect, add};

pub(super) const EFFECT: ArmEffect = ArmEffect {
    name: "armature",
    phase: &Phase::Joint,
    per_joint: true,
    coefficients: &[Coefficient::new("kg_m2", "kg·m²", 0.0, (0.0, 1000.0), 0.01)],
    plausible: &[(0.0, 50.0)],
    sentence: "the rotor has to be turned as well: the motor adds J · ddq",
    mistaken_for: &["joint_elasticity", "joint_spring", "torque_gain"],
    excited_by: (Follows::Rate, "grows fourfold at twice the speed"),
    apply: |arm, c| add(&mut arm.armature_kg_m2, c),
};
