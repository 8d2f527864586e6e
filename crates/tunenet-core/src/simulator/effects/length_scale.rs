//! A wrong length in the calibration: every coordinate is seen larger or smaller.

use super::{Act, MeasurementEffect};
use crate::observation::Kind;
use crate::simulator::Coefficient;

pub(super) const EFFECT: MeasurementEffect = MeasurementEffect {
    name: "length_scale",
    coefficients: &[Coefficient::new("factor", "1", 1.0, (0.1, 10.0), 0.01)],
    plausible: &[(0.5, 2.0)],
    sentence: "lengths are scaled wrongly: every coordinate is observed as factor times what it is",
    mistaken_for: &["effective_gravity", "time_scale", "aspect_ratio", "lens_distortion"],
    kinds: &[Kind::Positions, Kind::Other],
    act: Act::Length(|length, c| length * c[0]),
};
