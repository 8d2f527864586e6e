//! Loads that are farther out than stated.

use tunenet_core::simulator::{Coefficient, Phase, Side};

use super::{Act, RobotEffect, RobotTwin};

pub(super) const EFFECT: RobotEffect = RobotEffect {
    name: "load_offset",
    phase: Phase::Joint,
    per_joint: false,
    coefficients: &[Coefficient::new("m", "m", 0.0, (-1.0, 1.0), 0.005)],
    plausible: &[(-0.05, 0.05)],
    sentence: "loads are this much farther from the origin of their link than the file says",
    mistaken_for: &["firmware_gain", "joint_spring", "payload_com_offset"],
    restates: None,
    repeated_by: &[],
    twins: &[RobotTwin {
        name: "payload_com_offset",
        side: Side::Any,
        tuned: None,
        separated_by: "measure where the load is fastened to its link, and balance the load to find its centre of mass",
    }],
    act: Act::Robot(|robot, c| robot.load_offset_m += c[0]),
};
