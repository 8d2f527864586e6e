//! The initial state of a recording: known, or estimated with the recording.

use super::Parameter;
use crate::Result;
use crate::observation::Observation;

/// Without bounds, a state that has a prior is sought within this many of its standard deviations.
const REACH_SDS: f64 = 10.0;

/// What the name of an initial state begins with where it is a nuisance parameter: `start.theta`.
pub(crate) const STATE: &str = "start.";

/// Where the value of an initial state comes from.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum StartValue {
    /// The first sample of this channel.
    First(usize),
    /// A number.
    Number(f64),
}

/// One number of the initial state.
#[derive(Debug, Clone, PartialEq)]
pub struct StartState {
    /// Its name without unit: `theta`.
    pub name: String,
    /// Its unit: `rad`.
    pub unit: String,
    /// Its value, exact or as the mean of its prior.
    pub value: StartValue,
    /// The standard deviation of its prior, where it is estimated around its value.
    pub sd: Option<f64>,
    /// Its bounds. Without a prior it is estimated freely within them.
    pub bounds: Option<(f64, f64)>,
}

impl StartState {
    /// A state that is known.
    pub fn new(name: impl Into<String>, unit: impl Into<String>, value: StartValue) -> Self {
        Self { name: name.into(), unit: unit.into(), value, sd: None, bounds: None }
    }

    /// The same, estimated with a prior of this standard deviation around its value.
    #[must_use]
    pub fn with_prior(self, sd: f64) -> Self {
        Self { sd: Some(sd), ..self }
    }

    /// The same, estimated within these bounds.
    #[must_use]
    pub fn within(self, min: f64, max: f64) -> Self {
        Self { bounds: Some((min, max)), ..self }
    }

    /// Whether it is estimated.
    #[must_use]
    pub fn is_free(&self) -> bool {
        self.sd.is_some() || self.bounds.is_some()
    }

    /// Its value in a recording.
    pub(super) fn value(&self, seen: &Observation) -> f64 {
        match self.value {
            StartValue::First(channel) => seen.row(0)[channel],
            StartValue::Number(value) => value,
        }
    }

    /// As a nuisance parameter around `value` with the standard deviation of its prior, where it is estimated.
    ///
    /// # Errors
    /// [`Error::Parameter`](crate::Error::Parameter) where `value` lies outside the bounds, or these are none.
    pub(super) fn nuisance(&self, value: f64) -> Result<Option<(Parameter, f64)>> {
        let around = |sd: f64| (value - REACH_SDS * sd, value + REACH_SDS * sd);
        let Some((min, max)) = self.bounds.or_else(|| self.sd.map(around)) else { return Ok(None) };
        let nuisance = Parameter::new(format!("{STATE}{}", self.name), &self.unit, value, min, max)?;
        let sd = self.sd.unwrap_or_else(|| nuisance.span());
        Ok(Some((nuisance, sd)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::observation::{Channel, Kind};

    fn state() -> StartState {
        StartState::new("theta", "rad", StartValue::Number(0.5))
    }

    #[test]
    fn without_prior_and_bounds_it_is_known() {
        assert!(!state().is_free() && state().nuisance(0.5).unwrap().is_none());
    }

    #[test]
    fn a_prior_reaches_ten_standard_deviations_and_bounds_cut_it() {
        let (nuisance, sd) = state().with_prior(0.1).nuisance(0.5).unwrap().unwrap();
        assert_eq!((nuisance.min, nuisance.max, sd), (-0.5, 1.5, 0.1));
        let (nuisance, sd) = state().with_prior(0.1).within(0.4, 0.7).nuisance(0.5).unwrap().unwrap();
        assert_eq!((nuisance.min, nuisance.max, sd), (0.4, 0.7, 0.1));
        let (nuisance, sd) = state().within(0.0, 2.0).nuisance(0.5).unwrap().unwrap();
        assert_eq!((nuisance.name.as_str(), sd), ("start.theta", 2.0));
        assert!(state().within(1.0, 2.0).nuisance(0.5).is_err());
    }

    #[test]
    fn the_first_sample_is_that_of_its_channel() {
        let channels = ["x", "theta"].map(|name| Channel::new(name, "1")).to_vec();
        let values = vec![1.0, 2.0, 3.0, 4.0, 5.0, 6.0];
        let seen = Observation::new(Kind::Other, channels, vec![0.0, 1.0, 2.0], values).unwrap();
        assert_eq!(StartState { value: StartValue::First(1), ..state() }.value(&seen), 2.0);
    }
}
