//! A load that the file does not state.

use tunenet_core::simulator::{Coefficient, Phase};

use super::{Act, RobotEffect};

/// A load farther out, or nearer, has another inertia: of a single joint that is the armature, which is tuned, so that a distance would not
/// be determined.
pub(super) const EFFECT: RobotEffect = RobotEffect {
    name: "extra_load",
    phase: Phase::Joint,
    per_joint: false,
    coefficients: &[Coefficient::new("kg", "kg", 0.0, (-100.0, 100.0), 0.1)],
    plausible: &[(-20.0, 20.0)],
    sentence: "the last link is this much heavier than the file says, as with a load at its centre of mass",
    mistaken_for: &[
        "firmware_gain",
        "firmware_damping",
        "duty_limit",
        "payload_com_offset",
        "load_offset",
        "base_tilt",
    ],
    restates: None,
    repeated_by: &[],
    twins: &[],
    act: Act::Robot(|robot, c| robot.extra_load_kg += c[0]),
};
