//! Friction that is greatest near rest and falls with speed.

use tunenet_core::simulator::{Coefficient, Follows, Phase};

use super::{ArmEffect, add};

pub(super) const EFFECT: ArmEffect = ArmEffect {
    name: "stribeck_friction",
    phase: &Phase::Joint,
    per_joint: true,
    coefficients: &[
        Coefficient::new("nm", "N·m", 0.0, (0.0, 1000.0), 0.1),
        Coefficient::new("rad_s", "rad/s", 0.1, (0.001, 10.0), 0.05),
    ],
    plausible: &[(0.0, 200.0), (0.001, 10.0)],
    sentence: "joint friction is larger near rest: the motor adds s · sign(dq) · exp(-(dq / v)²), v being `rad_s`",
    mistaken_for: &["coulomb_friction", "viscous_friction"],
    excited_by: (Follows::Speed, "is there at the slowest speed alone"),
    apply: |arm, c| {
        let (size, speed) = c.split_at(c.len() / 2);
        add(&mut arm.stribeck_nm, size);
        arm.stribeck_rad_s.copy_from_slice(speed);
    },
};
