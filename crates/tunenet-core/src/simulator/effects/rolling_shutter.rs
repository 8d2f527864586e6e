//! A shutter that reads the picture row by row: what is higher is read later, or earlier.

use super::{Act, MeasurementEffect};
use crate::observation::Kind;
use crate::simulator::Coefficient;

pub(super) const EFFECT: MeasurementEffect = MeasurementEffect {
    name: "rolling_shutter",
    coefficients: &[Coefficient::new("delay_s_m", "s/m", 0.0, (-0.05, 0.05), 0.001)],
    plausible: &[(-0.03, 0.03)],
    sentence: "rows are read one after the other: a point at height z is seen delay · z after its stamp",
    mistaken_for: &["quadratic_drag", "linear_drag", "perspective", "effective_gravity", "time_offset"],
    kinds: &[Kind::Positions],
    act: Act::Readout(|height, c| c[0] * height),
};
