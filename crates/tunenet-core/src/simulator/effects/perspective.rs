//! A camera that looks up or down: what is higher is farther away and seen smaller.

use super::{Act, MeasurementEffect};
use crate::observation::Kind;
use crate::simulator::Coefficient;

pub(super) const EFFECT: MeasurementEffect = MeasurementEffect {
    name: "perspective",
    coefficients: &[Coefficient::new("k_1_m", "1/m", 0.0, (-0.5, 0.5), 0.005)],
    plausible: &[(-0.3, 0.3)],
    sentence: "the scale changes with height: every coordinate is divided by 1 + k z",
    mistaken_for: &["effective_gravity", "linear_drag", "lens_distortion", "aspect_ratio", "rolling_shutter"],
    kinds: &[Kind::Positions],
    act: Act::Point(project),
};

fn project(point: [f64; 3], c: &[f64]) -> Option<[f64; 3]> {
    let depth = 1.0 + c[0] * point[2];
    (depth > 0.0).then(|| point.map(|v| v / depth))
}
