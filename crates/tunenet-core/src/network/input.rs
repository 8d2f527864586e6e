//! What the network sees of an observation.

use std::ops::Range;

use serde::{Deserialize, Serialize};

use crate::simulator::Scale;
use crate::{Error, Result};

/// How an observation becomes the numbers that enter a branch. Fitted on the training set and stored with the weights.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
pub enum Input {
    /// One channel as recorded, `low` and `high` of the training set brought to 0 and 1 (the paper's appendix).
    Raw {
        /// Which channel, from 0.
        channel: usize,
        /// How many samples; the width of the input.
        samples: usize,
        /// The least value of the training set, in the channel's unit.
        low: f64,
        /// The greatest.
        high: f64,
    },
    /// One channel in units of the recording's own [`Scale`], resampled linearly at `bins` instants evenly over
    /// `τ = (t − start) / time` in `[0, tau_max]`. Needs a scale.
    Dimensionless {
        /// Which channel, from 0.
        channel: usize,
        /// How many instants; the width of the input. At least 2.
        bins: usize,
        /// The last instant, in units of the recording's time.
        tau_max: f64,
    },
    /// Every channel less its mean, divided by its standard deviation over the training set, resampled linearly at
    /// `bins` instants evenly over the record; channel after channel.
    Standardised {
        /// How many instants of each channel. At least 2.
        bins: usize,
        /// The mean of each channel over the training set.
        mean: Vec<f64>,
        /// The standard deviation of each channel, above 0.
        sd: Vec<f64>,
    },
}

/// One recording as a branch sees it, before it is paired with another.
#[derive(Debug, Clone, PartialEq)]
pub struct Encoded {
    /// Shape `[width]`.
    pub values: Vec<f64>,
    /// Where the recording has something to say: outside, a dimensionless record had not begun or had ended.
    pub covered: Range<usize>,
}

impl Encoded {
    /// Blanks, in both, what either lacks: 0 (at rest, in dimensionless terms) and equal on both sides. A record that
    /// ends early then says nothing about what came later, rather than that nothing happened.
    pub fn pair(&mut self, other: &mut Self) {
        let both = self.covered.start.max(other.covered.start)..self.covered.end.min(other.covered.end);
        for side in [self, other] {
            for (i, value) in side.values.iter_mut().enumerate() {
                if !both.contains(&i) {
                    *value = 0.0;
                }
            }
        }
    }
}

impl Input {
    /// How many numbers enter each branch.
    #[must_use]
    pub fn width(&self) -> usize {
        match self {
            Self::Raw { samples, .. } => *samples,
            Self::Dimensionless { bins, .. } => *bins,
            Self::Standardised { bins, mean, .. } => bins * mean.len(),
        }
    }

    /// Whether each recording must bring its [`Scale`].
    #[must_use]
    pub fn needs_scale(&self) -> bool {
        matches!(self, Self::Dimensionless { .. })
    }

    /// One recording as a branch sees it. `values` is row-major `[sample, channel]`, `clock` its strictly rising clock.
    ///
    /// # Errors
    /// [`Error::Model`] where a channel, the number of samples or the scale does not fit, or where a dimensionless
    /// record and its scale do not overlap.
    pub fn encode(&self, clock: &[f64], values: &[f64], channels: usize, scale: Option<&Scale>) -> Result<Encoded> {
        let refuse = |what: &str, expected: String, found: String| {
            Err(Error::Model { what: format!("input, {what}"), expected, found })
        };
        if clock.is_empty() || channels == 0 || clock.len() * channels != values.len() {
            return refuse(
                "values",
                format!("{} samples x {channels} channels", clock.len()),
                values.len().to_string(),
            );
        }
        let column = |channel: usize| Column { clock, values: &values[channel..], channels };
        match self {
            Self::Raw { channel, samples, low, high } => {
                if clock.len() != *samples {
                    return refuse("samples", samples.to_string(), clock.len().to_string());
                }
                if *channel >= channels {
                    return refuse("channels", format!("more than {channel}"), channels.to_string());
                }
                let span = high - low;
                let factor = if span > 0.0 { 1.0 / span } else { 0.0 };
                let values = values[*channel..].iter().step_by(channels).map(|v| (v - low) * factor).collect();
                Ok(Encoded { values, covered: 0..*samples })
            }
            Self::Dimensionless { channel, bins, tau_max } => {
                let Some(scale) = scale else {
                    return refuse("scale", "the recording's own zero, length and time".into(), "none".into());
                };
                if *channel >= channels {
                    return refuse("channels", format!("more than {channel}"), channels.to_string());
                }
                let step = tau_max / (bins - 1) as f64;
                let instants = (0..*bins).map(|i| scale.start_s + scale.time_s * step * i as f64);
                let (values, covered) = column(*channel).at(instants, 1e-9 * scale.time_s);
                if covered.is_empty() {
                    let expected = format!("samples after {} s", scale.start_s);
                    return refuse("clock", expected, format!("{} to {} s", clock[0], clock[clock.len() - 1]));
                }
                let inside = |i: usize| covered.contains(&i);
                let scaled = |(i, v): (usize, f64)| if inside(i) { (v - scale.origin) / scale.length } else { 0.0 };
                Ok(Encoded { values: values.into_iter().enumerate().map(scaled).collect(), covered })
            }
            Self::Standardised { bins, mean, sd } => {
                if mean.len() != channels {
                    return refuse("channels", mean.len().to_string(), channels.to_string());
                }
                let (first, last) = (clock[0], clock[clock.len() - 1]);
                let step = (last - first) / (bins - 1) as f64;
                let mut encoded = Vec::with_capacity(self.width());
                for (channel, (mean, sd)) in mean.iter().zip(sd).enumerate() {
                    let instants = (0..*bins).map(|i| first + step * i as f64);
                    let (values, _) = column(channel).at(instants, f64::INFINITY);
                    encoded.extend(values.iter().map(|v| (v - mean) / sd));
                }
                Ok(Encoded { covered: 0..encoded.len(), values: encoded })
            }
        }
    }
}

/// One channel of a recording.
struct Column<'a> {
    clock: &'a [f64],
    values: &'a [f64],
    channels: usize,
}

impl Column<'_> {
    /// Linear interpolation at rising `instants`, and which of them lie within the record, give or take `slack`.
    fn at(&self, instants: impl Iterator<Item = f64>, slack: f64) -> (Vec<f64>, Range<usize>) {
        let last = self.clock.len() - 1;
        let value = |i: usize| self.values[i * self.channels];
        let (mut before, mut after) = (0, 0);
        let mut covered = 0;
        let mut values = Vec::new();
        for t in instants {
            if t < self.clock[0] - slack {
                before += 1;
            } else if t <= self.clock[last] + slack {
                covered += 1;
            }
            while after <= last && self.clock[after] < t {
                after += 1;
            }
            values.push(match after {
                0 => value(0),
                i if i > last => value(last),
                i => {
                    let share = (t - self.clock[i - 1]) / (self.clock[i] - self.clock[i - 1]);
                    value(i - 1) + share * (value(i) - value(i - 1))
                }
            });
        }
        (values, before..before + covered)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const CLOCK: [f64; 5] = [0.0, 1.0, 2.0, 3.0, 4.0];

    #[test]
    fn raw_brings_the_training_range_to_one() {
        let input = Input::Raw { channel: 1, samples: 5, low: 1.0, high: 5.0 };
        let values = [9.0, 1.0, 9.0, 2.0, 9.0, 3.0, 9.0, 4.0, 9.0, 5.0];
        assert_eq!(input.encode(&CLOCK, &values, 2, None).unwrap().values, [0.0, 0.25, 0.5, 0.75, 1.0]);
        assert!(input.encode(&CLOCK[..4], &values[..8], 2, None).is_err());
    }

    #[test]
    fn dimensionless_forgets_height_and_time() {
        let input = Input::Dimensionless { channel: 0, bins: 3, tau_max: 2.0 };
        let low = Scale::new(1.0, 2.0, 1.0, 1.0).unwrap();
        let seen = input.encode(&CLOCK, &[3.0, 3.0, 2.0, 1.0, 1.0], 1, Some(&low)).unwrap();
        assert_eq!(seen, Encoded { values: vec![1.0, 0.5, 0.0], covered: 0..3 });
        let high = Scale::new(10.0, 4.0, 0.0, 2.0).unwrap();
        let same = input.encode(&CLOCK, &[14.0, 13.0, 12.0, 11.0, 10.0], 1, Some(&high)).unwrap();
        assert_eq!(same, seen);
        assert!(input.encode(&CLOCK, &[0.0; 5], 1, None).is_err());
    }

    #[test]
    fn what_one_side_lacks_is_blank_in_both() {
        let input = Input::Dimensionless { channel: 0, bins: 5, tau_max: 4.0 };
        let scale = Scale::new(0.0, 1.0, 0.0, 1.0).unwrap();
        let mut long = input.encode(&CLOCK, &[1.0; 5], 1, Some(&scale)).unwrap();
        let mut short = input.encode(&CLOCK[1..4], &[2.0; 3], 1, Some(&scale)).unwrap();
        assert_eq!(short.covered, 1..4);
        long.pair(&mut short);
        assert_eq!(long.values, [0.0, 1.0, 1.0, 1.0, 0.0]);
        assert_eq!(short.values, [0.0, 2.0, 2.0, 2.0, 0.0]);
    }

    #[test]
    fn standardised_takes_every_channel() {
        let input = Input::Standardised { bins: 2, mean: vec![1.0, 0.0], sd: vec![2.0, 1.0] };
        let seen = input.encode(&CLOCK, &[1.0, 5.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 3.0, 7.0], 2, None).unwrap();
        assert_eq!(seen.values, [0.0, 1.0, 5.0, 7.0]);
    }

    #[test]
    fn a_scale_without_length_is_refused() {
        assert!(Scale::new(0.0, 0.0, 0.0, 1.0).is_err());
        assert!(Scale::new(0.0, 1.0, f64::NAN, 1.0).is_err());
    }
}
