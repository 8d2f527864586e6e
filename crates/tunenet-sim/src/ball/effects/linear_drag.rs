//! Viscous drag, as of a slow ball or of a damping that an engine adds.

use tunenet_core::simulator::{Coefficient, Phase};

use super::BallEffect;

/// A sphere of water this small falls in air at a Reynolds number of 1, m; whatever is larger or thrown is far above it.
const SMALLEST_M: f64 = 1e-4;

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
    // Stokes' law holds below a Reynolds number 2 v r / ν of 1; with ν = 1.5e-5 m²/s of air, a ball of 1 cm moves at less
    // than a millimetre a second then.
    unlikely: |body| {
        (body.in_air && body.radius_m > SMALLEST_M)
            .then_some("no ball of this size is slow enough in air for drag in proportion to speed")
    },
    heard: true,
    apply: |scene, c| scene.flight.linear_drag_1_s += c[0],
};
