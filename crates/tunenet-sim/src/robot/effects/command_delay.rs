//! Commands that act late.

use tunenet_core::simulator::{Coefficient, Phase, Side};

use super::{Act, RobotEffect, RobotTwin};

pub(super) const EFFECT: RobotEffect = RobotEffect {
    name: "command_delay",
    phase: Phase::Actuator,
    per_joint: true,
    coefficients: &[Coefficient::new("s", "s", 0.0, (0.0, 0.5), 0.01)],
    plausible: &[(0.0, 0.2)],
    sentence: "the motor acts on commands of some time ago",
    mistaken_for: &["time_delay", "command_lag", "position_latch", "firmware_damping"],
    restates: None,
    repeated_by: &[],
    twins: &[RobotTwin {
        name: "time_delay",
        side: Side::Any,
        tuned: None,
        separated_by: "record an instant at which the motor is released with a delay that is known, or stamp commands and readings by \
                       two clocks",
    }],
    act: Act::Drives(|drive, c| drive.command_delay_s += c[0]),
};
