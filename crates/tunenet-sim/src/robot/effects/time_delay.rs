//! Readings that are late.

use tunenet_core::simulator::{Coefficient, Phase, Side};

use super::{Act, RobotEffect, RobotTwin};

pub(super) const EFFECT: RobotEffect = RobotEffect {
    name: "time_delay",
    phase: Phase::Measurement,
    per_joint: false,
    coefficients: &[Coefficient::new("delay_s", "s", 0.0, (0.0, 0.5), 0.01)],
    plausible: &[(0.0, 0.2)],
    sentence: "joints are read as they were some time ago",
    mistaken_for: &["command_delay", "command_lag", "position_latch"],
    restates: None,
    repeated_by: &[],
    twins: &[RobotTwin {
        name: "command_delay",
        side: Side::Any,
        tuned: None,
        separated_by: "record an instant at which the motor is released with a delay that is known, or stamp commands and readings by \
                       two clocks",
    }],
    act: Act::Robot(|robot, c| robot.reading_delay_s += c[0]),
};
