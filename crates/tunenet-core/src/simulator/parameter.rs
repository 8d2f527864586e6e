//! A number that can be tuned.

use serde::Serialize;

use crate::{Error, Result};

/// A value within this share of the range from a bound lies at it.
const NEAR_BOUND: f64 = 1e-6;

/// A number of a simulator, with its bounds and its unit.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Parameter {
    /// Its name, as in a simulation file: `mass`.
    pub name: String,
    /// Its unit: `kg`; `1` where there is none.
    pub unit: String,
    /// Its present value, within the bounds.
    pub value: f64,
    /// The least value that makes sense.
    pub min: f64,
    /// The greatest value that makes sense.
    pub max: f64,
    /// Whether tuning may change it.
    pub tune: bool,
    /// Of a value that is not tuned and was itself measured, a calibrated torque gain say: its 95 % interval. Intervals of what
    /// is tuned with it allow for it. `None` where the value is exact.
    pub known95: Option<(f64, f64)>,
    /// Channels on which it acts directly, those of its joint say, where it reaches the others only through what moves there; `None`
    /// where it may act on any. Where others hardly move, derivatives by parameters of different channels share a rollout.
    #[serde(skip)]
    pub channels: Option<Vec<usize>>,
}

impl Parameter {
    /// A parameter that may be tuned.
    ///
    /// # Errors
    /// [`Error::Parameter`] where a number is not finite, `min` is not below `max`, or `value` lies outside them.
    pub fn new(name: impl Into<String>, unit: impl Into<String>, value: f64, min: f64, max: f64) -> Result<Self> {
        let name = name.into();
        if !(min.is_finite() && max.is_finite() && min < max) {
            return Err(Error::Parameter {
                name,
                expected: "finite bounds with min below max".into(),
                found: format!("{min} to {max}"),
            });
        }
        if !(min..=max).contains(&value) {
            return Err(Error::Parameter { name, expected: format!("{min} to {max}"), found: format!("{value}") });
        }
        Ok(Self { name, unit: unit.into(), value, min, max, tune: true, known95: None, channels: None })
    }

    /// The width of the bounds.
    #[must_use]
    pub fn span(&self) -> f64 {
        self.max - self.min
    }

    /// The bound on which a value lies, other than 0, which is an end by nature.
    pub(crate) fn bound_reached(&self, value: f64) -> Option<f64> {
        let near = |bound: &f64| *bound != 0.0 && (value - bound).abs() <= NEAR_BOUND * self.span();
        [self.min, self.max].into_iter().find(near)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_value_on_a_bound_other_than_0_is_noticed() {
        let parameter = Parameter::new("a", "1", 1.0, 0.0, 2.0).unwrap();
        assert_eq!([2.0, 0.0, 1.99].map(|value| parameter.bound_reached(value)), [Some(2.0), None, None]);
    }
}
