//! The natural scales of one recording.

use serde::{Deserialize, Serialize};

use crate::{Error, Result};

/// What makes one recording dimensionless: its own zero, length and time.
///
/// For a body that falls from rest: the height at rest, the height of fall `h`, the instant at which the fall begins and `√(h/g)`.
/// Two recordings that differ only in these then look the same, so that what was learned from one height serves every other.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Scale {
    /// The value that becomes 0, in the channel's unit.
    pub origin: f64,
    /// The difference that becomes 1, in the channel's unit; above 0.
    pub length: f64,
    /// The instant that becomes 0, in the clock's unit.
    pub start_s: f64,
    /// The time that becomes 1, in the clock's unit; above 0.
    pub time_s: f64,
}

impl Scale {
    /// A checked scale.
    ///
    /// # Errors
    /// [`Error::Observation`] where a number is not finite, or `length` or `time_s` is not above 0.
    pub fn new(origin: f64, length: f64, start_s: f64, time_s: f64) -> Result<Self> {
        let usable = [origin, length, start_s, time_s].iter().all(|v| v.is_finite()) && length > 0.0 && time_s > 0.0;
        if usable {
            return Ok(Self { origin, length, start_s, time_s });
        }
        Err(Error::Observation {
            what: "the scale of a recording".into(),
            expected: "finite numbers, with length and time above 0".into(),
            found: format!("origin {origin}, length {length}, start {start_s} s, time {time_s} s"),
        })
    }
}
