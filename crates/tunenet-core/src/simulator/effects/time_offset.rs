//! Stamps that come late or early by a constant.

use super::{Act, MeasurementEffect};
use crate::observation::Kind;
use crate::simulator::Coefficient;

pub(super) const EFFECT: MeasurementEffect = MeasurementEffect {
    name: "time_offset",
    coefficients: &[Coefficient::new("offset_s", "s", 0.0, (-1.0, 1.0), 0.005)],
    plausible: &[(-0.5, 0.5)],
    sentence: "stamps are late by a constant; only a known instant at which the motion starts shows it",
    mistaken_for: &["rolling_shutter"],
    kinds: &[Kind::Positions, Kind::Pixels, Kind::EventTimes, Kind::Other],
    act: Act::Clock { to_true: |stamp, c| stamp - c[0], to_seen: |instant, c| instant + c[0] },
};
