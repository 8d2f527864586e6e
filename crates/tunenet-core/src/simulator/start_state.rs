//! The initial state of a recording: known, or estimated with the recording.

use nalgebra::{Matrix3, Vector3};

use super::Parameter;
use crate::Result;
use crate::observation::Observation;

/// Without bounds, a state that has a prior is sought within this many of its standard deviations.
const REACH_SDS: f64 = 10.0;

/// A slope is that of one sample in so many, and of at least so many.
const SLOPE_SHARE: usize = 10;
const LEAST_SLOPE_SAMPLES: usize = 6;

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
    /// The channel whose rate of change it is, where there is one: its estimate begins at the slope of that.
    pub rate_of: Option<usize>,
}

impl StartState {
    /// A state that is known.
    pub fn new(name: impl Into<String>, unit: impl Into<String>, value: StartValue) -> Self {
        Self { name: name.into(), unit: unit.into(), value, sd: None, bounds: None, rate_of: None }
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

    /// The same, as the rate of change of what this channel shows.
    #[must_use]
    pub fn rate_of(self, channel: usize) -> Self {
        Self { rate_of: Some(channel), ..self }
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

    /// Where its estimate begins in a recording, as a nuisance parameter: at the slope of the channel whose rate it is.
    pub(super) fn begin(&self, seen: &Observation, nuisance: &Parameter) -> Option<f64> {
        let slope = slope(seen, self.rate_of?)?;
        Some(slope.clamp(nuisance.min, nuisance.max))
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

/// The slope of a channel at its first sample: of a parabola through the first samples by least squares (Savitzky and Golay 1964).
fn slope(seen: &Observation, channel: usize) -> Option<f64> {
    let count = (seen.len() / SLOPE_SHARE).max(LEAST_SLOPE_SAMPLES).min(seen.len());
    let clock = &seen.clock()[..count];
    let (first, last) = (*clock.first()?, *clock.last()?);
    let (mut normal, mut right) = (Matrix3::zeros(), Vector3::zeros());
    for (i, time) in clock.iter().enumerate() {
        let t = (time - first) / (last - first);
        let powers = Vector3::new(1.0, t, t * t);
        normal += powers * powers.transpose();
        right += powers * seen.row(i)[channel];
    }
    let slope = normal.cholesky()?.solve(&right)[1] / (last - first);
    slope.is_finite().then_some(slope)
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

    /// x = 1 + 2 t − 3 t² has the slope 2 at the first instant, on any clock, and the bounds cut it.
    #[test]
    fn a_rate_begins_at_the_slope_of_its_channel() {
        let clock: Vec<f64> = (0..80).map(|i| 5.0 + 0.01 * f64::from(i)).collect();
        let path = |t: &f64| 1.0 + 2.0 * (t - 5.0) - 3.0 * (t - 5.0) * (t - 5.0);
        let values = clock.iter().map(path).collect();
        let seen = Observation::new(Kind::Other, vec![Channel::new("x", "m")], clock, values).unwrap();
        let begin = |min: f64, max: f64| {
            let state = state().within(min, max).rate_of(0);
            let (nuisance, _) = state.nuisance(0.5).unwrap().unwrap();
            state.begin(&seen, &nuisance).unwrap()
        };
        assert!((begin(-9.0, 9.0) - 2.0).abs() < 1e-9 && begin(0.0, 1.5) == 1.5);
        assert_eq!(
            StartState { rate_of: None, ..state() }.begin(&seen, &Parameter::new("a", "1", 0.0, 0.0, 1.0).unwrap()),
            None
        );
    }
}
