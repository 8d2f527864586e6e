//! What the network sees of an observation.

use std::ops::Range;

use serde::{Deserialize, Serialize};

use crate::camera::LineCamera;
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
    /// Every channel as recorded, sample after sample, `low` and `high` of all channels of the training set brought to 0
    /// and 1.
    Recorded {
        /// How many channels.
        channels: usize,
        /// How many samples of each.
        samples: usize,
        /// The least value of the training set.
        low: f64,
        /// The greatest.
        high: f64,
    },
    /// One channel in units of the recording's own [`Scale`], its mean over each of `bins` equal intervals of
    /// `τ = (t − start) / time` in `[0, tau_max]`. Needs a scale.
    Dimensionless {
        /// Which channel, from 0.
        channel: usize,
        /// How many intervals; the width of the input.
        bins: usize,
        /// The end of the last interval, in units of the recording's time.
        tau_max: f64,
    },
    /// As `Dimensionless`, of heights read back from a picture: the channel is `v` in px, and the first fall of a body with
    /// this [`Scale`] says what camera saw it ([`LineCamera::of_fall`]).
    #[serde(rename = "filmed")]
    Pixels {
        /// Which channel, from 0.
        channel: usize,
        /// How many intervals; the width of the input.
        bins: usize,
        /// The end of the last interval, in units of the recording's time.
        tau_max: f64,
    },
    /// Every channel in units of the recording's own [`Scale`], over the same intervals as `Dimensionless`: of the last
    /// channel its distance from the scale's zero, of the others their change since the first interval; each divided by
    /// its unit. Interval after interval. Needs a scale.
    Scaled {
        /// How many intervals of each channel.
        bins: usize,
        /// The end of the last interval, in units of the recording's time.
        tau_max: f64,
        /// What each channel is divided by, above 0.
        unit: Vec<f64>,
    },
    /// Every channel less its mean, divided by its standard deviation over the training set, its mean over each of `bins`
    /// equal intervals of the record; channel after channel.
    Standardised {
        /// How many intervals of each channel.
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
            Self::Recorded { channels, samples, .. } => channels * samples,
            Self::Dimensionless { bins, .. } | Self::Pixels { bins, .. } => *bins,
            Self::Scaled { bins, unit, .. } => bins * unit.len(),
            Self::Standardised { bins, mean, .. } => bins * mean.len(),
        }
    }

    /// Whether each recording must bring its [`Scale`].
    #[must_use]
    pub fn needs_scale(&self) -> bool {
        matches!(self, Self::Dimensionless { .. } | Self::Pixels { .. } | Self::Scaled { .. })
    }

    /// One recording as a branch sees it. `values` is row-major `[sample, channel]`, `clock` its strictly rising clock.
    ///
    /// # Errors
    /// [`Error::Model`] where a channel, the number of samples or the scale does not fit, or where a dimensionless
    /// record and its scale do not overlap.
    pub fn encode(&self, clock: &[f64], values: &[f64], channels: usize, scale: Option<&Scale>) -> Result<Encoded> {
        fn refuse<T>(what: &str, expected: String, found: String) -> Result<T> {
            Err(Error::Model { what: format!("does not fit the recording ({what})"), expected, found })
        }
        if clock.len() < 2 || channels == 0 || clock.len() * channels != values.len() {
            return refuse(
                "values",
                format!("{} samples x {channels} channels", clock.len()),
                values.len().to_string(),
            );
        }
        let column = |channel: usize| Column { clock, values: &values[channel..], channels };
        let there = |channel: usize| {
            if channel < channels {
                return Ok(channel);
            }
            refuse("channels", format!("more than {channel}"), channels.to_string())
        };
        let scale = || {
            scale.map_or_else(|| refuse("scale", "the recording's own zero, length and time".into(), "none".into()), Ok)
        };
        // The means of one channel over intervals of dimensionless time; at least one lies within the record.
        let means = |channel: usize, scale: &Scale, bins: usize, tau_max: f64| {
            let step = scale.time_s * tau_max / bins as f64;
            let (means, covered) = column(channel).means(scale.start_s, step, bins, 1e-9 * scale.time_s);
            if covered.is_empty() {
                let expected = format!("samples after {} s", scale.start_s);
                return refuse("clock", expected, format!("{} to {} s", clock[0], clock[clock.len() - 1]));
            }
            Ok((means, covered))
        };
        match self {
            Self::Raw { channel, samples, low, high } => {
                if clock.len() != *samples {
                    return refuse("samples", samples.to_string(), clock.len().to_string());
                }
                let channel = there(*channel)?;
                let span = high - low;
                let factor = if span > 0.0 { 1.0 / span } else { 0.0 };
                let values = values[channel..].iter().step_by(channels).map(|v| (v - low) * factor).collect();
                Ok(Encoded { values, covered: 0..*samples })
            }
            Self::Recorded { channels: known, samples, low, high } => {
                if channels != *known {
                    return refuse("channels", known.to_string(), channels.to_string());
                }
                if clock.len() != *samples {
                    return refuse("samples", samples.to_string(), clock.len().to_string());
                }
                let span = high - low;
                let factor = if span > 0.0 { 1.0 / span } else { 0.0 };
                let values: Vec<f64> = values.iter().map(|v| (v - low) * factor).collect();
                Ok(Encoded { covered: 0..values.len(), values })
            }
            Self::Dimensionless { channel, bins, tau_max } => {
                let scale = scale()?;
                let (mut values, covered) = means(there(*channel)?, scale, *bins, *tau_max)?;
                for value in &mut values[covered.clone()] {
                    *value = (*value - scale.origin) / scale.length;
                }
                Ok(Encoded { values, covered })
            }
            Self::Pixels { channel, bins, tau_max } => {
                let (scale, channel) = (scale()?, there(*channel)?);
                let v_px: Vec<f64> = values[channel..].iter().step_by(channels).copied().collect();
                let Some(camera) = LineCamera::of_fall(clock, &v_px, scale) else {
                    return refuse("picture", "the first fall of a body".into(), "none that a camera could see".into());
                };
                let z_m: Vec<f64> = v_px.iter().map(|v| camera.height(*v)).collect();
                Self::Dimensionless { channel: 0, bins: *bins, tau_max: *tau_max }.encode(clock, &z_m, 1, Some(scale))
            }
            Self::Scaled { bins, tau_max, unit } => {
                let scale = scale()?;
                if unit.len() != channels {
                    return refuse("channels", unit.len().to_string(), channels.to_string());
                }
                let mut all = Encoded { values: vec![0.0; bins * channels], covered: 0..0 };
                for (c, unit) in unit.iter().enumerate() {
                    let (means, covered) = means(c, scale, *bins, *tau_max)?;
                    let zero = if c + 1 == channels { scale.origin } else { means[covered.start] };
                    for i in covered.clone() {
                        all.values[i * channels + c] = (means[i] - zero) / (scale.length * unit);
                    }
                    all.covered = covered.start * channels..covered.end * channels;
                }
                Ok(all)
            }
            Self::Standardised { bins, mean, sd } => {
                if mean.len() != channels {
                    return refuse("channels", mean.len().to_string(), channels.to_string());
                }
                let (first, last) = (clock[0], clock[clock.len() - 1]);
                let step = (last - first) / *bins as f64;
                let mut encoded = Vec::with_capacity(self.width());
                for (channel, (mean, sd)) in mean.iter().zip(sd).enumerate() {
                    // The last edge may miss the last sample by a rounding error.
                    let (values, _) = column(channel).means(first, step, *bins, step);
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
    /// The mean of each of `bins` intervals of width `step` from `first` on, and which of them lie within the record, give
    /// or take `slack`. The others are 0.
    ///
    /// Means rather than single instants, because every sample then counts: with three samples to a bin, single instants
    /// would leave half of what a noisy recording says unused. Between two samples the channel is taken as straight.
    fn means(&self, first: f64, step: f64, bins: usize, slack: f64) -> (Vec<f64>, Range<usize>) {
        let (begin, end) = (self.clock[0], self.clock[self.clock.len() - 1]);
        let area = self.areas();
        let mut covered = 0..0;
        let mut values = vec![0.0; bins];
        for (i, value) in values.iter_mut().enumerate() {
            let (from, to) = (first + step * i as f64, first + step * (i + 1) as f64);
            if from < begin - slack {
                covered = i + 1..i + 1;
            } else if to <= end + slack {
                let (from, to) = (from.max(begin), to.min(end));
                *value = (self.area(&area, to) - self.area(&area, from)) / (to - from);
                covered.end = i + 1;
            }
        }
        (values, covered)
    }

    fn value(&self, sample: usize) -> f64 {
        self.values[sample * self.channels]
    }

    /// The integral from the first sample to each.
    fn areas(&self) -> Vec<f64> {
        let mut sum = 0.0;
        let mut areas = vec![0.0];
        for i in 1..self.clock.len() {
            sum += 0.5 * (self.value(i - 1) + self.value(i)) * (self.clock[i] - self.clock[i - 1]);
            areas.push(sum);
        }
        areas
    }

    /// The integral from the first sample to `t`, which lies within the record.
    fn area(&self, areas: &[f64], t: f64) -> f64 {
        let after = self.clock.partition_point(|c| *c <= t).min(self.clock.len() - 1).max(1);
        let (low, high) = (self.value(after - 1), self.value(after));
        let past = t - self.clock[after - 1];
        areas[after - 1] + past * (low + 0.5 * past * (high - low) / (self.clock[after] - self.clock[after - 1]))
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
    fn recorded_brings_all_channels_to_one_range() {
        let input = Input::Recorded { channels: 2, samples: 2, low: -1.0, high: 3.0 };
        assert_eq!(input.encode(&CLOCK[..2], &[-1.0, 3.0, 0.0, 1.0], 2, None).unwrap().values, [0.0, 1.0, 0.25, 0.5]);
        assert!(input.encode(&CLOCK[..3], &[0.0; 6], 2, None).is_err());
        assert!(input.encode(&CLOCK[..2], &[0.0; 6], 3, None).is_err());
    }

    #[test]
    fn dimensionless_forgets_height_and_time() {
        let input = Input::Dimensionless { channel: 0, bins: 3, tau_max: 3.0 };
        let low = Scale::new(1.0, 2.0, 1.0, 1.0).unwrap();
        let seen = input.encode(&CLOCK, &[3.0, 3.0, 2.0, 1.0, 1.0], 1, Some(&low)).unwrap();
        // Means over the intervals 3 → 2, 2 → 1, 1 → 1, less 1, over 2.
        assert_eq!(seen, Encoded { values: vec![0.75, 0.25, 0.0], covered: 0..3 });
        let high = Scale::new(10.0, 4.0, 2.0, 2.0).unwrap();
        let clock = CLOCK.map(|t| 2.0 * t);
        let same = input.encode(&clock, &[14.0, 14.0, 12.0, 10.0, 10.0], 1, Some(&high)).unwrap();
        assert_eq!(same, seen);
        assert!(input.encode(&CLOCK, &[0.0; 5], 1, None).is_err());
    }

    #[test]
    fn a_mean_counts_every_sample() {
        let input = Input::Dimensionless { channel: 0, bins: 1, tau_max: 4.0 };
        let scale = Scale::new(0.0, 1.0, 0.0, 1.0).unwrap();
        let seen = input.encode(&CLOCK, &[0.0, 4.0, 0.0, 0.0, 0.0], 1, Some(&scale)).unwrap();
        assert_eq!(seen.values, [1.0]);
    }

    #[test]
    fn what_one_side_lacks_is_blank_in_both() {
        let input = Input::Dimensionless { channel: 0, bins: 4, tau_max: 4.0 };
        let scale = Scale::new(0.0, 1.0, 0.0, 1.0).unwrap();
        let mut long = input.encode(&CLOCK, &[1.0; 5], 1, Some(&scale)).unwrap();
        let mut short = input.encode(&CLOCK[1..4], &[2.0; 3], 1, Some(&scale)).unwrap();
        assert_eq!(short.covered, 1..3);
        long.pair(&mut short);
        assert_eq!(long.values, [0.0, 1.0, 1.0, 0.0]);
        assert_eq!(short.values, [0.0, 2.0, 2.0, 0.0]);
        assert!(input.encode(&[7.0, 8.0, 9.0], &[0.0; 3], 1, Some(&scale)).is_err());
    }

    #[test]
    fn standardised_takes_every_channel() {
        let input = Input::Standardised { bins: 2, mean: vec![1.0, 0.0], sd: vec![2.0, 1.0] };
        let seen = input.encode(&CLOCK, &[1.0, 4.0, 1.0, 4.0, 3.0, 4.0, 5.0, 4.0, 5.0, 4.0], 2, None).unwrap();
        assert_eq!(seen.values, [0.25, 1.75, 4.0, 4.0]);
    }

    #[test]
    fn a_scale_without_length_is_refused() {
        assert!(Scale::new(0.0, 0.0, 0.0, 1.0).is_err());
        assert!(Scale::new(0.0, 1.0, f64::NAN, 1.0).is_err());
    }
}
