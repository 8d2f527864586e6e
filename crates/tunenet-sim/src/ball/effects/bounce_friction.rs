//! Coulomb friction at contact, beyond what the file says.

use tunenet_core::simulator::{Coefficient, Phase};

use super::BallEffect;

/// Adds to the parameter `friction`; where that is tuned they are one and the same, and this effect is not offered.
pub(super) const EFFECT: BallEffect = BallEffect {
    name: "bounce_friction",
    phase: &Phase::Event,
    coefficients: &[Coefficient::new("mu", "1", 0.0, (0.0, 2.0), 0.05)],
    plausible: |_| vec![(0.0, 1.5)],
    sentence: "sliding friction at contacts slows the ball and spins it: Coulomb's mu, added to `friction`",
    mistaken_for: &["tangential_restitution", "quadratic_drag", "linear_drag", "bounce_scatter"],
    forecast_share: 1.0,
    implausible: |_| None,
    shows_in_bounce_times: false,
    apply: |scene, c| scene.friction += c[0],
};
