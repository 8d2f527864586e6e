//! Readings that a clock of the device latches.

use tunenet_core::simulator::{Coefficient, Phase};

use super::{Act, RobotEffect};

/// The phase of that clock is not known, so that the mean over all phases is predicted.
pub(super) const EFFECT: RobotEffect = RobotEffect {
    name: "position_latch",
    phase: Phase::Measurement,
    per_joint: false,
    coefficients: &[Coefficient::new("s", "s", 0.0, (0.0, 0.2), 0.005)],
    plausible: &[(0.0, 0.05)],
    sentence: "the device renews the position that is read with this period, at an unknown phase",
    mistaken_for: &["time_delay", "command_delay", "command_lag"],
    restates: None,
    repeated_by: &[],
    twins: &[],
    act: Act::Robot(|robot, c| robot.latch_s += c[0]),
};
