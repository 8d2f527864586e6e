//! Friction that is greatest near rest and falls with speed.

use tunenet_core::simulator::{Coefficient, Phase};

use super::{Act, RobotEffect};

/// As that of arms; its speed shapes it, and fits begin at several.
pub(super) const EFFECT: RobotEffect = RobotEffect {
    name: "stribeck_friction",
    phase: Phase::Joint,
    per_joint: true,
    coefficients: &[
        Coefficient::new("nm", "N·m", 0.0, (0.0, 1000.0), 0.1),
        Coefficient::new("rad_s", "rad/s", 0.1, (0.001, 10.0), 0.05).shaping(),
    ],
    plausible: &[(0.0, 200.0), (0.001, 10.0)],
    sentence: "joint friction is larger near rest: s · sign(w) · exp(-(w / v)²) is added at the speed w, v being `rad_s`",
    mistaken_for: &["coulomb_friction", "viscous_friction"],
    restates: None,
    repeated_by: &[],
    twins: &[],
    act: Act::Arm(|arm, c| {
        let (size, speed) = c.split_at(c.len() / 2);
        arm.stribeck_nm.iter_mut().zip(size).for_each(|(own, more)| *own += more);
        arm.stribeck_rad_s.copy_from_slice(speed);
    }),
};
