//! A lens that bends straight lines, radially about the origin of the picture.

use super::{Act, MeasurementEffect};
use crate::observation::Kind;
use crate::simulator::Coefficient;

pub(super) const EFFECT: MeasurementEffect = MeasurementEffect {
    name: "lens_distortion",
    coefficients: &[Coefficient::new("k1", "1/m²", 0.0, (-0.5, 0.5), 0.002)],
    plausible: &[(-0.2, 0.2)],
    sentence: "the lens distorts: x and z are multiplied by 1 + k1 (x² + z²), outward where k1 is above 0",
    mistaken_for: &["perspective", "aspect_ratio", "length_scale"],
    kinds: &[Kind::Positions],
    act: Act::Point(bend),
};

/// The first term of radial distortion (Brown 1966).
#[expect(clippy::unnecessary_wraps, reason = "the form of every map of a point")]
fn bend([x, y, z]: [f64; 3], c: &[f64]) -> Option<[f64; 3]> {
    let stretch = 1.0 + c[0] * (x * x + z * z);
    Some([x * stretch, y, z * stretch])
}
