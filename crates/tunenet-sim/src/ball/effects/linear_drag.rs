//! Viscous drag, as of a slow ball or of a damping that an engine adds.

use tunenet_core::simulator::{Coefficient, Phase};

use super::BallEffect;

pub(super) const EFFECT: BallEffect = BallEffect {
    name: "linear_drag",
    phase: Phase::Flight,
    coefficients: &[Coefficient::new("b_1_s", "1/s", 0.0, (0.0, 20.0), 0.05)],
    plausible: |_| vec![(0.0, 5.0)],
    sentence: "something brakes the ball in proportion to its speed: a = -b v",
    mistaken_for: &[
        "quadratic_drag",
        "perspective",
        "rolling_shutter",
        "effective_gravity",
        "speed_dependent_restitution",
        "rolling_resistance",
        "tangential_restitution",
        "bounce_friction",
    ],
    heard: true,
    apply: |scene, c| scene.flight.linear_drag_1_s += c[0],
};
