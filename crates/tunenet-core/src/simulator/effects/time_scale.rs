//! A wrong frame rate: the clock runs fast or slow, about its zero.

use super::{Act, MeasurementEffect};
use crate::observation::Kind;
use crate::simulator::Coefficient;

pub(super) const EFFECT: MeasurementEffect = MeasurementEffect {
    name: "time_scale",
    coefficients: &[Coefficient::new("factor", "1", 1.0, (0.1, 10.0), 0.01)],
    plausible: &[(0.2, 5.0)],
    sentence: "the clock runs wrongly (frame rate, doubled frames): observed time is factor times the true one",
    mistaken_for: &["effective_gravity", "length_scale", "aspect_ratio"],
    kinds: &[Kind::Positions, Kind::Pixels, Kind::EventTimes, Kind::Other],
    act: Act::Clock { to_true: |stamp, c| stamp / c[0], to_seen: |instant, c| instant * c[0] },
};
