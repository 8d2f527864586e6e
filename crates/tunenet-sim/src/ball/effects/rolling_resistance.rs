//! What slows a ball that rolls.

use tunenet_core::simulator::{Coefficient, Phase};

use super::BallEffect;

pub(super) const EFFECT: BallEffect = BallEffect {
    name: "rolling_resistance",
    phase: &Phase::Event,
    coefficients: &[Coefficient::new("c_rr", "1", 0.0, (0.0, 1.0), 0.01)],
    plausible: |_| vec![(0.0, 0.3)],
    sentence: "a rolling ball slows down, by c_rr times the acceleration that presses it onto the surface",
    mistaken_for: &["linear_drag", "quadratic_drag", "surface_tilt"],
    forecast_share: 1.0,
    implausible: |_| None,
    shows_in_bounce_times: false,
    apply: |scene, c| scene.contact.rolling_resistance += c[0],
};
