//! Readings that are late.

use tunenet_core::simulator::{Coefficient, Phase};

use super::{Act, RobotEffect};

pub(super) const EFFECT: RobotEffect = RobotEffect {
    name: "time_delay",
    phase: Phase::Measurement,
    per_joint: false,
    coefficients: &[Coefficient::new("delay_s", "s", 0.0, (0.0, 0.5), 0.01)],
    plausible: &[(0.0, 0.2)],
    sentence: "joints are read as they were some time ago",
    mistaken_for: &["command_delay", "position_latch"],
    act: Act::Robot(|robot, c| robot.reading_delay_s += c[0]),
};
