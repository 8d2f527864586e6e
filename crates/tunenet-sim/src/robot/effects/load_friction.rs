//! Friction by the load of the gear.

use tunenet_core::simulator::{Coefficient, Phase};

use super::{Act, RobotEffect};

pub(super) const EFFECT: RobotEffect = RobotEffect {
    name: "load_friction",
    phase: Phase::Joint,
    per_joint: true,
    coefficients: &[Coefficient::new("mu", "1", 0.0, (0.0, 2.0), 0.05)],
    plausible: &[(0.0, 1.0)],
    sentence: "the friction of the gear grows with the torque that it carries, by the factor mu",
    mistaken_for: &["coulomb_friction", "firmware_gain", "firmware_damping"],
    restates: None,
    repeated_by: &[],
    twins: &[],
    act: Act::Drives(|drive, c| drive.load_friction += c[0]),
};
