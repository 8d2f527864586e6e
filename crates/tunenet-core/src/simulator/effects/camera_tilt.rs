//! A camera that does not stand upright: what is seen is turned about x and y, through the origin.

use super::{Act, MeasurementEffect};
use crate::observation::Kind;
use crate::simulator::Coefficient;

pub(super) const EFFECT: MeasurementEffect = MeasurementEffect {
    name: "camera_tilt",
    coefficients: &[
        Coefficient::new("about_x_rad", "rad", 0.0, (-1.0, 1.0), 0.01),
        Coefficient::new("about_y_rad", "rad", 0.0, (-1.0, 1.0), 0.01),
    ],
    plausible: &[(-0.3, 0.3), (-0.3, 0.3)],
    sentence: "the camera is tilted: the observed axes are turned against the plumb line",
    mistaken_for: &["wind", "surface_tilt", "magnus"],
    kinds: &[Kind::Positions],
    act: Act::Point(turn),
};

/// Rx(a) · Ry(b) · point, right-handed.
#[expect(clippy::unnecessary_wraps, reason = "the form of every map of a point")]
fn turn([x, y, z]: [f64; 3], c: &[f64]) -> Option<[f64; 3]> {
    let ((sin_a, cos_a), (sin_b, cos_b)) = (c[0].sin_cos(), c[1].sin_cos());
    let (x, z) = (cos_b * x + sin_b * z, cos_b * z - sin_b * x);
    Some([x, cos_a * y - sin_a * z, sin_a * y + cos_a * z])
}
