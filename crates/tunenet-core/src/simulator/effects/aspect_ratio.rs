//! Pixels that are not square: heights are scaled otherwise than widths.

use super::{Act, MeasurementEffect};
use crate::observation::Kind;
use crate::simulator::Coefficient;

pub(super) const EFFECT: MeasurementEffect = MeasurementEffect {
    name: "aspect_ratio",
    coefficients: &[Coefficient::new("factor", "1", 1.0, (0.1, 10.0), 0.01)],
    plausible: &[(0.5, 2.0)],
    sentence: "the picture is stretched: observed heights are factor times the true ones, widths are true",
    mistaken_for: &["length_scale", "effective_gravity", "time_scale", "perspective", "lens_distortion"],
    kinds: &[Kind::Positions],
    act: Act::Point(|[x, y, z], c| Some([x, y, z * c[0]])),
};
