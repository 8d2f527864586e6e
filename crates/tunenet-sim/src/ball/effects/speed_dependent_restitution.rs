//! Restitution that falls with speed, e(v) = e (v / 3 m/s)^(−exponent).

use tunenet_core::simulator::{Coefficient, Phase};

use super::BallEffect;

pub(super) const EFFECT: BallEffect = BallEffect {
    name: "speed_dependent_restitution",
    phase: &Phase::Event,
    coefficients: &[Coefficient::new("exponent", "1", 0.0, (-1.0, 1.0), 0.02)],
    // Solids return less of a faster impact, by yielding (v^(-1/4)) or by inner friction (1 - k v^(1/5)): Johnson, Contact
    // Mechanics (1985), section 11.5. What seems to return more has another cause, such as a force near the floor.
    plausible: |_| vec![(0.0, 0.5)],
    sentence: "restitution depends on the impact speed: e(v) = e (v / 3 m/s)^(-exponent)",
    mistaken_for: &["quadratic_drag", "linear_drag", "contact_time"],
    forecast_share: 1.0,
    implausible: |_| None,
    shows_in_bounce_times: true,
    apply: |scene, c| scene.contact.restitution_exponent += c[0],
};
