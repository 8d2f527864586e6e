//! An arm that does not stand upright.

use tunenet_core::simulator::{Coefficient, Follows, Phase};

use super::{ArmEffect, add};

pub(super) const EFFECT: ArmEffect = ArmEffect {
    name: "base_tilt",
    phase: &Phase::Joint,
    per_joint: false,
    coefficients: &[
        Coefficient::new("about_x_rad", "rad", 0.0, (-1.5, 1.5), 0.005),
        Coefficient::new("about_y_rad", "rad", 0.0, (-1.5, 1.5), 0.005),
    ],
    plausible: &[(-0.5, 0.5), (-0.5, 0.5)],
    sentence: "the base is not level: it is turned about x, then about y of the world",
    mistaken_for: &["joint_offset", "payload_com_offset", "torque_bias"],
    excited_by: (Follows::Base, "turns with the direction in which the arm reaches"),
    apply: |arm, c| add(&mut arm.tilt_rad, c),
};
