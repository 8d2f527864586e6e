//! A floor that is not level.

use tunenet_core::simulator::{Coefficient, Phase};

use super::BallEffect;

pub(super) const EFFECT: BallEffect = BallEffect {
    name: "surface_tilt",
    phase: &Phase::Event,
    coefficients: &[
        Coefficient::new("about_x_rad", "rad", 0.0, (-0.7, 0.7), 0.01),
        Coefficient::new("about_y_rad", "rad", 0.0, (-0.7, 0.7), 0.01),
    ],
    plausible: |_| vec![(-0.3, 0.3); 2],
    sentence: "the surface is not level: every bounce turns the ball downhill",
    mistaken_for: &["camera_tilt", "wind", "bounce_scatter", "rolling_resistance"],
    forecast_share: 1.0,
    implausible: |_| None,
    shows_in_bounce_times: false,
    apply: |scene, c| {
        scene.surface_tilt_about_x_rad += c[0];
        scene.surface_tilt_about_y_rad += c[1];
    },
};
