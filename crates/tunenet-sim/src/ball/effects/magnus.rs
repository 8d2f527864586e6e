//! The lift of a spinning ball, at right angles to its way.

use tunenet_core::simulator::{Coefficient, Phase};

use super::BallEffect;

pub(super) const EFFECT: BallEffect = BallEffect {
    name: "magnus",
    phase: &Phase::Segment,
    coefficients: &[
        Coefficient::new("sx_1_s", "1/s", 0.0, (-50.0, 50.0), 0.05),
        Coefficient::new("sy_1_s", "1/s", 0.0, (-50.0, 50.0), 0.05),
        Coefficient::new("sz_1_s", "1/s", 0.0, (-50.0, 50.0), 0.05),
    ],
    plausible: |_| vec![(-10.0, 10.0); 3],
    sentence: "the ball spins, and the air deflects it (Magnus effect): a = S x v",
    mistaken_for: &["wind", "camera_tilt", "quadratic_drag"],
    // A vortex, or spin that changes its sign between recordings.
    forecast_share: 0.55,
    implausible: |_| None,
    shows_in_bounce_times: false,
    apply: |scene, c| (0..3).for_each(|axis| scene.flight.magnus_1_s[axis] += c[axis]),
};
