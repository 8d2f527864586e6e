//! Commands that act late.

use tunenet_core::simulator::{Coefficient, Phase};

use super::{Act, RobotEffect};

pub(super) const EFFECT: RobotEffect = RobotEffect {
    name: "command_delay",
    phase: Phase::Actuator,
    per_joint: true,
    coefficients: &[Coefficient::new("s", "s", 0.0, (0.0, 0.5), 0.01)],
    plausible: &[(0.0, 0.2)],
    sentence: "the motor acts on commands of some time ago",
    mistaken_for: &["time_delay", "position_latch", "firmware_damping"],
    act: Act::Drives(|drive, c| drive.command_delay_s += c[0]),
};
