//! Switching that acts late.

use tunenet_core::simulator::{Coefficient, Phase};

use super::{Act, RobotEffect};

pub(super) const EFFECT: RobotEffect = RobotEffect {
    name: "release_delay",
    phase: Phase::Actuator,
    per_joint: true,
    coefficients: &[Coefficient::new("s", "s", 0.0, (0.0, 0.5), 0.01)],
    plausible: &[(0.0, 0.2)],
    sentence: "the motor is switched off or on some time after its command",
    mistaken_for: &["release_braking"],
    restates: None,
    repeated_by: &[],
    twins: &[],
    act: Act::Drives(|drive, c| drive.release_delay_s += c[0]),
};
