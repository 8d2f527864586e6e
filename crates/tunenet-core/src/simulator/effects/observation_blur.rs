//! An exposure that lasts: a sample is the mean over it, so events are rounded off.

use super::{Act, MeasurementEffect};
use crate::observation::Kind;
use crate::simulator::Coefficient;

pub(super) const EFFECT: MeasurementEffect = MeasurementEffect {
    name: "observation_blur",
    coefficients: &[Coefficient::new("exposure_s", "s", 0.0, (0.0, 0.2), 0.005)],
    plausible: &[(0.0, 0.1)],
    sentence: "each sample is the mean over an exposure centred on its stamp, so that what is sudden looks rounded",
    mistaken_for: &["contact_time"],
    kinds: &[Kind::Positions, Kind::Pixels, Kind::Other],
    act: Act::Exposure(|c| c[0]),
};
