//! A steady horizontal push, as of a draught.

use tunenet_core::simulator::{Coefficient, Phase};

use super::BallEffect;

pub(super) const EFFECT: BallEffect = BallEffect {
    name: "wind",
    phase: &Phase::Segment,
    coefficients: &[
        Coefficient::new("ax_m_s2", "m/s²", 0.0, (-20.0, 20.0), 0.05),
        Coefficient::new("ay_m_s2", "m/s²", 0.0, (-20.0, 20.0), 0.05),
    ],
    plausible: |_| vec![(-5.0, 5.0); 2],
    sentence: "a steady push drives the ball sideways in flight",
    mistaken_for: &["magnus", "camera_tilt", "surface_tilt"],
    // A surface that moves, or a draught that changes with height.
    forecast_share: 0.3,
    implausible: |_| None,
    shows_in_bounce_times: false,
    apply: |scene, c| (0..2).for_each(|axis| scene.flight.wind_m_s2[axis] += c[axis]),
};
