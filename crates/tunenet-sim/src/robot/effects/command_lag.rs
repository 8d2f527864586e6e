//! Commands that act with a lag of first order: τ · dg/dt = command − g.

use tunenet_core::simulator::{Coefficient, Phase};

use super::{Act, RobotEffect};

pub(super) const EFFECT: RobotEffect = RobotEffect {
    name: "command_lag",
    phase: Phase::Actuator,
    per_joint: true,
    coefficients: &[Coefficient::new("s", "s", 0.0, (0.0, 0.5), 0.01)],
    plausible: &[(0.0, 0.2)],
    sentence: "the motor follows its commands with a lag of first order, `s` being its time constant",
    mistaken_for: &["command_delay", "time_delay", "position_latch", "speed_limit", "firmware_damping"],
    restates: None,
    repeated_by: &[],
    twins: &[],
    act: Act::Drives(|drive, c| drive.command_lag_s += c[0]),
};
