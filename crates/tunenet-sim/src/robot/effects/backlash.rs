//! A gap in the gear.

use tunenet_core::simulator::{Coefficient, Phase};

use super::{Act, RobotEffect};

pub(super) const EFFECT: RobotEffect = RobotEffect {
    name: "backlash",
    phase: Phase::Joint,
    per_joint: true,
    coefficients: &[Coefficient::new("gap_rad", "rad", 0.0, (0.0, 0.5), 0.01)],
    plausible: &[(0.0, 0.2)],
    sentence: "the link moves freely within a gap of this width before the gear carries it",
    mistaken_for: &["dead_band", "joint_elasticity", "joint_spring"],
    restates: None,
    repeated_by: &[],
    twins: &[],
    act: Act::Drives(|drive, c| drive.gap_rad += c[0]),
};
