//! What drove the thing while it was observed: signals on clocks of their own.

use super::{Observation, check_channel};
use crate::Result;

/// How a signal continues between its samples.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Hold {
    /// At the previous sample (zero-order hold).
    #[default]
    Previous,
    /// On the straight line from sample to sample.
    Linear,
}

/// A signal that drove the thing, of one or more channels on its own clock in s.
///
/// ```
/// use tunenet_core::observation::{Channel, Hold, Input};
/// let force = Input::sampled(Channel::new("force", "N"), Hold::Linear, vec![0.0, 1.0, 2.0], vec![3.0, 5.0, 4.0])?;
/// assert_eq!([force.at(0, 0.5), force.at(0, -1.0), force.at(0, 9.0)], [4.0, 3.0, 4.0]);
/// # Ok::<(), tunenet_core::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Input {
    series: Observation,
    hold: Hold,
}

impl Input {
    /// A signal from its samples.
    #[must_use]
    pub fn new(series: Observation, hold: Hold) -> Self {
        Self { series, hold }
    }

    /// A signal of one channel from its clock in s and its values.
    ///
    /// # Errors
    /// As [`Observation::new`].
    pub fn sampled(channel: super::Channel, hold: Hold, times_s: Vec<f64>, values: Vec<f64>) -> Result<Self> {
        Ok(Self::new(Observation::new(super::Kind::Other, vec![channel], times_s, values)?, hold))
    }

    /// Its samples.
    #[must_use]
    pub fn series(&self) -> &Observation {
        &self.series
    }

    /// How it continues between them.
    #[must_use]
    pub fn hold(&self) -> Hold {
        self.hold
    }

    /// The value of a channel at an instant. Before the first sample the first value holds, after the last one the last.
    ///
    /// # Panics
    /// Where `channel` is not below the number of channels.
    #[must_use]
    pub fn at(&self, channel: usize, time_s: f64) -> f64 {
        check_channel(&self.series, channel);
        let clock = self.series.clock();
        let after = clock.partition_point(|t| *t <= time_s);
        let value = |i: usize| self.series.row(i)[channel];
        match (self.hold, after) {
            (_, 0) => value(0),
            (Hold::Previous, _) => value(after - 1),
            (Hold::Linear, after) if after == clock.len() => value(after - 1),
            (Hold::Linear, after) => {
                let share = (time_s - clock[after - 1]) / (clock[after] - clock[after - 1]);
                value(after - 1) + share * (value(after) - value(after - 1))
            }
        }
    }

    /// The same on a clock that starts this much earlier.
    pub(super) fn earlier(&self, by_s: f64) -> Self {
        Self { series: self.series.earlier(by_s), hold: self.hold }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::observation::Channel;

    fn signal(hold: Hold) -> Input {
        Input::sampled(Channel::new("u", "V"), hold, vec![1.0, 2.0, 4.0], vec![10.0, -2.0, 6.0]).unwrap()
    }

    #[test]
    fn a_held_signal_keeps_its_previous_sample() {
        let at = |t| signal(Hold::Previous).at(0, t);
        assert_eq!([at(0.0), at(1.0), at(1.999), at(2.0), at(3.0), at(9.0)], [10.0, 10.0, 10.0, -2.0, -2.0, 6.0]);
    }

    #[test]
    fn a_linear_signal_joins_its_samples() {
        let at = |t| signal(Hold::Linear).at(0, t);
        assert_eq!([at(0.0), at(1.5), at(2.0), at(3.0), at(9.0)], [10.0, 4.0, -2.0, 2.0, 6.0]);
    }

    #[test]
    fn an_earlier_clock_moves_every_sample() {
        assert_eq!(signal(Hold::Linear).earlier(1.0).at(0, 0.5), 4.0);
    }
}
