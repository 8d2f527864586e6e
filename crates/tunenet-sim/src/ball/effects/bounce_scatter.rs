//! A ball that is not round, or a rough floor: every bounce meets a normal of its own.

use tunenet_core::simulator::{Coefficient, Phase};

use super::BallEffect;

/// A per-contact random effect has no rollout of its own: a simulator rolls out the bounce without it, and a recording brings the tilt of the normal at
/// each of its bounces as nuisance parameters. Their root mean square is the coefficient.
pub(super) const EFFECT: BallEffect = BallEffect {
    name: "bounce_scatter",
    phase: &Phase::Event,
    coefficients: &[Coefficient::new("sd_rad", "rad", 0.0, (0.0, 0.5), 0.02)],
    plausible: |_| vec![(0.0, 0.3)],
    sentence: "each bounce deflects the ball at random, as if the surface were tilted anew (a ball that is not round)",
    mistaken_for: &["surface_tilt", "bounce_friction"],
    // Anything that happens once in a while.
    forecast_share: 0.7,
    implausible: |_| None,
    shows_in_bounce_times: false,
    apply: |_, _| {},
};
