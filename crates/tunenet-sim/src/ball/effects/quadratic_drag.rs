//! Air drag of a fast ball, a = −c |v| v with c = ρ Cd A / (2 m).

use tunenet_core::simulator::{Coefficient, Phase};

use super::BallEffect;

/// Drag coefficients of balls: 0.1 for a golf ball past its drag crisis, 0.5 for a smooth sphere, 1.5 with fins and fluff.
const DRAG_COEFFICIENT: (f64, f64) = (0.1, 1.5);

pub(super) const EFFECT: BallEffect = BallEffect {
    name: "quadratic_drag",
    phase: &Phase::Segment,
    coefficients: &[Coefficient::new("c_1_m", "1/m", 0.0, (0.0, 10.0), 0.02)],
    plausible: |body| {
        let (low, high) = DRAG_COEFFICIENT;
        vec![body.drag_1_m().map_or((0.0, 10.0), |one| (low * one, high * one))]
    },
    sentence: "the air brakes the ball with the square of its speed: a = -c |v| v",
    mistaken_for: &[
        "linear_drag",
        "speed_dependent_restitution",
        "effective_gravity",
        "rolling_shutter",
        "magnus",
        "rolling_resistance",
        "tangential_restitution",
        "bounce_friction",
    ],
    forecast_share: 1.0,
    implausible: |_| None,
    shows_in_bounce_times: true,
    apply: |scene, c| scene.flight.quadratic_drag_1_m += c[0],
};
