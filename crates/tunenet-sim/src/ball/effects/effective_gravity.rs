//! Gravity that is weaker or stronger than the file says: buoyancy, the air that is moved along, or a wrong figure.

use tunenet_core::simulator::{Coefficient, Phase};

use super::BallEffect;

/// How far gravity itself may be off in a file: on the ground it is 9.76 to 9.83 m/s².
const WRONG_FIGURE_M_S2: f64 = 0.05;
/// What passes for it where mass and size are unknown, m/s².
const UNKNOWN_BALL_M_S2: f64 = 2.0;

pub(super) const EFFECT: BallEffect = BallEffect {
    name: "effective_gravity",
    phase: &Phase::Segment,
    coefficients: &[Coefficient::new("dg_m_s2", "m/s²", 0.0, (-9.5, 20.0), 0.05)],
    plausible: |body| {
        // Buoyancy takes β g; half the displaced air is moved along, so that g (1 − β)/(1 + β/2) is left: −3/2 β g and,
        // for a body lighter than air, never more than g itself and half of it.
        let least = |share: f64| -1.5 * share.min(1.0) * body.gravity_m_s2 - WRONG_FIGURE_M_S2;
        let known = body.buoyancy().map(|share| (least(share), WRONG_FIGURE_M_S2));
        vec![known.unwrap_or((-UNKNOWN_BALL_M_S2, UNKNOWN_BALL_M_S2))]
    },
    sentence: "the apparent gravity differs (buoyancy, added mass of the air): dg is added to it",
    mistaken_for: &[
        "length_scale",
        "time_scale",
        "quadratic_drag",
        "perspective",
        "aspect_ratio",
        "linear_drag",
        "rolling_shutter",
    ],
    forecast_share: 1.0,
    implausible: |_| None,
    shows_in_bounce_times: true,
    apply: |scene, c| scene.flight.effective_gravity_m_s2 += c[0],
};
