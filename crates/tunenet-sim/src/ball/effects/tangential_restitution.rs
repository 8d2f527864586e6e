//! A contact that takes a share of the slip, however hard the impact.

use tunenet_core::simulator::{Coefficient, Phase};

use super::BallEffect;

/// 1 is full grip; above it the slip is reversed, as by a bouncing rubber ball, and 2 does so without a loss.
pub(super) const EFFECT: BallEffect = BallEffect {
    name: "tangential_restitution",
    phase: &Phase::Event,
    coefficients: &[Coefficient::new("loss", "1", 0.0, (0.0, 2.0), 0.05)],
    plausible: |_| vec![(0.0, 2.0)],
    sentence: "each bounce takes this share of the speed with which the ball's skin slips along the surface",
    mistaken_for: &["bounce_friction", "quadratic_drag", "linear_drag"],
    forecast_share: 1.0,
    implausible: |_| None,
    shows_in_bounce_times: false,
    apply: |scene, c| scene.contact.tangential_loss += c[0],
};
