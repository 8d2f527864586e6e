//! A supply whose voltage sags under load.

use tunenet_core::simulator::{Coefficient, Phase};

use super::{Act, RobotEffect};

pub(super) const EFFECT: RobotEffect = RobotEffect {
    name: "voltage_sag",
    phase: Phase::Actuator,
    per_joint: true,
    coefficients: &[Coefficient::new("ohm", "Ohm", 0.0, (0.0, 50.0), 0.2)],
    plausible: &[(0.0, 10.0)],
    sentence: "the supply voltage falls with the current: a resistance in the supply",
    mistaken_for: &["duty_limit", "speed_limit"],
    restates: None,
    repeated_by: &[],
    twins: &[],
    act: Act::Drives(|drive, c| drive.sag_ohm += c[0]),
};
