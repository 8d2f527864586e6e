//! A number that can be tuned.

use serde::Serialize;

use crate::{Error, Result};

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
        Ok(Self { name, unit: unit.into(), value, min, max, tune: true, known95: None })
    }

    /// The width of the bounds.
    #[must_use]
    pub fn span(&self) -> f64 {
        self.max - self.min
    }
}
