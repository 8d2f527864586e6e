//! Viscous drag, as of a slow ball or of a damping that an engine adds.

use tunenet_core::simulator::{Coefficient, Phase};

use super::BallEffect;

/// A sphere of water larger than this falls in air at a Reynolds number beyond 1, m, and what is thrown is far above it.
const SMALLEST_M: f64 = 1e-4;

pub(super) const EFFECT: BallEffect = BallEffect {
    name: "linear_drag",
    phase: &Phase::Segment,
    coefficients: &[Coefficient::new("b_1_s", "1/s", 0.0, (0.0, 20.0), 0.05)],
    plausible: |_| vec![(0.0, 5.0)],
    sentence: "something brakes the ball in proportion to its speed: a = -b v",
    mistaken_for: &[
        "quadratic_drag",
        "perspective",
        "rolling_shutter",
        "effective_gravity",
        "speed_dependent_restitution",
        "rolling_resistance",
        "tangential_restitution",
        "bounce_friction",
    ],
    // Any other law of drag.
    forecast_share: 0.55,
    // Stokes' law holds below a Reynolds number 2 v r / ν of 1; with ν = 1.5e-5 m²/s of air, a ball of 1 cm moves at less
    // than a millimetre a second then.
    implausible: |body| {
        (body.in_air && body.radius_m > SMALLEST_M)
            .then_some("no ball of this size is slow enough in air for drag in proportion to speed")
    },
    shows_in_bounce_times: true,
    apply: |scene, c| scene.flight.linear_drag_1_s += c[0],
};

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ball::effects::Body;

    /// Stokes' fall in air, v = 2 ρ g r²/(9 μ) with μ = 1.8e-5 Pa s: Re = 2 v r / ν passes 1 between r of 0.03 and 0.05 mm in
    /// water, so no ball that a camera sees is below it.
    #[test]
    fn only_dust_is_slow_enough_in_air() {
        let reynolds = |r: f64| 2.0 * (2.0 * 1000.0 * 9.81 * r * r / (9.0 * 1.8e-5)) * r / 1.5e-5;
        assert!(reynolds(SMALLEST_M) > 1.0 && reynolds(3e-5) < 1.0);
        let ball = Body { radius_m: 0.02, mass_kg: None, gravity_m_s2: 9.81, in_air: true };
        assert!((EFFECT.implausible)(&ball).is_some());
        assert!((EFFECT.implausible)(&Body { in_air: false, ..ball }).is_none());
        assert!((EFFECT.implausible)(&Body { radius_m: 1e-5, ..ball }).is_none());
    }
}
