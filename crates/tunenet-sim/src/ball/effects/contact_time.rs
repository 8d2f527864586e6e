//! A contact that lasts: the ball is compressed and expands before it leaves.

use tunenet_core::simulator::{Coefficient, Phase};

use super::BallEffect;

pub(super) const EFFECT: BallEffect = BallEffect {
    name: "contact_time",
    phase: &Phase::Event,
    coefficients: &[Coefficient::new("duration_s", "s", 0.0, (0.0, 0.1), 0.005)],
    plausible: |_| vec![(0.0, 0.05)],
    sentence: "the contact lasts: the ball dips into the surface and leaves it this much later",
    mistaken_for: &["observation_blur", "speed_dependent_restitution"],
    forecast_share: 1.0,
    implausible: |_| None,
    shows_in_bounce_times: true,
    apply: |scene, c| scene.contact.duration_s += c[0],
};
