//! What was seen: time series with a clock.
//!
//! [`Observation`] is the one type that every later wing reads. It cannot hold NaN, a clock that does not rise or too few
//! samples: its constructor refuses them, so no later code has to check again.

mod check;
mod circumstances;
mod event_noise;
mod header;
mod input;
mod lattice;
mod local;
mod local_parabola;
mod noise;
mod note;
mod number;
mod odd_scale;
mod outliers;
mod resample;

pub use check::{Check, State};
pub use circumstances::Circumstances;
pub use event_noise::event_time_sd;
pub use header::plain;
pub use input::{Hold, Input};
pub use lattice::lattice_step;
pub use local::{LocalEstimate, widened};
pub use noise::{noise_sd, step};
pub use note::Note;
pub use number::{after_number, three_digits, with_decimals};
pub use odd_scale::{OddScale, odd_scales};
pub use resample::resample;

use std::sync::Arc;

use serde::Serialize;

use crate::{Error, Result};

/// Fewest samples of an observation.
pub const FEWEST_SAMPLES: usize = 3;

/// Greatest size of a number, measured or predicted, in any unit: far beyond all that there is, and small enough that
/// its square, and a sum of such squares over tiny noise, is a number still.
pub const GREATEST: f64 = 1e100;

/// The unit of all these channels; `None` where they differ, or where there are none.
#[must_use]
pub fn common_unit(channels: &[Channel]) -> Option<&str> {
    let first = channels.first()?;
    channels.iter().all(|channel| channel.unit == first.unit).then_some(first.unit.as_str())
}

/// The unit of a root mean square over these channels: theirs, or σ where they have several. Each residual is then divided by the
/// standard deviation of its channel's noise, so that noise alone leaves 1 σ.
#[must_use]
pub fn gap_unit(channels: &[Channel]) -> &str {
    common_unit(channels).unwrap_or("σ")
}

/// What kind of thing was measured. Decides what the channels and the clock mean.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum Kind {
    /// A body's centre: channels `x`, `y`, `z` in m; clock in s.
    Positions,
    /// A body's centre in a picture: channels `u`, `v` in px, v downwards; clock in s.
    Pixels,
    /// Instants of events (impacts): one channel in s; the clock counts events from 0 and may skip one that was missed.
    EventTimes,
    /// Joints of a mechanism: channels `q1`, `dq1`, `tau1`, … in rad, rad/s, N·m (or `i1` in A); clock in s.
    Joints,
    /// Anything that a simulator outside this project observes; clock in s.
    Other,
}

impl Kind {
    /// A name for users: "positions", "joint series".
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Positions => "positions",
            Self::Pixels => "pixels",
            Self::EventTimes => "event times",
            Self::Joints => "joint series",
            Self::Other => "a time series",
        }
    }
}

/// Whether a number, measured or predicted, is usable.
pub(crate) fn usable(number: f64) -> bool {
    number.abs() <= GREATEST
}

/// What is expected where one cannot.
pub(crate) fn usable_number() -> String {
    format!("a finite number of at most {GREATEST:e}")
}

/// One column of an observation.
#[derive(Debug, Clone, PartialEq, Eq, Hash, Serialize)]
pub struct Channel {
    /// Short name without unit: `z`, `tau3`.
    pub name: String,
    /// Unit: `m`, `N·m`; `1` where there is none.
    pub unit: String,
}

impl Channel {
    /// A channel from its name and unit.
    pub fn new(name: impl Into<String>, unit: impl Into<String>) -> Self {
        Self { name: name.into(), unit: unit.into() }
    }

    /// The three channels of [`Kind::Positions`].
    #[must_use]
    pub fn positions() -> Vec<Self> {
        ["x", "y", "z"].map(|name| Self::new(name, "m")).to_vec()
    }
}

/// A time series: shape `[sample, channel]`, one clock for all channels.
///
/// ```
/// use tunenet_core::observation::{Channel, Kind, Observation};
/// let swing = Observation::new(Kind::Other, vec![Channel::new("angle", "rad")], vec![0.0, 0.1, 0.2], vec![0.3, 0.2, 0.0])?;
/// assert_eq!(swing.len(), 3);
/// assert_eq!(swing.row(1), [0.2]);
/// assert!(Observation::new(Kind::Other, vec![Channel::new("angle", "rad")], vec![0.0, 0.1, 0.1], vec![0.3, 0.2, 0.0]).is_err());
/// # Ok::<(), tunenet_core::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Observation {
    kind: Kind,
    channels: Vec<Channel>,
    clock: Vec<f64>,
    values: Vec<f64>,
    #[serde(skip)]
    circumstances: Option<Arc<Circumstances>>,
}

impl Observation {
    /// An observation from its clock and its values in row-major order `[sample, channel]`.
    ///
    /// # Errors
    /// [`Error::Observation`] where there is no channel, the lengths disagree, fewer than [`FEWEST_SAMPLES`] samples are
    /// there, a number is not finite or beyond [`GREATEST`], or the clock (for event times: the times too) does not rise strictly.
    pub fn new(kind: Kind, channels: Vec<Channel>, clock: Vec<f64>, values: Vec<f64>) -> Result<Self> {
        let refuse = |what: String, expected: String, found: String| Err(Error::Observation { what, expected, found });
        if channels.is_empty() {
            return refuse("the channels".into(), "at least one".into(), "none".into());
        }
        if clock.len() * channels.len() != values.len() {
            let expected = format!(
                "{} values for {} samples of {} channels",
                clock.len() * channels.len(),
                clock.len(),
                channels.len()
            );
            return refuse("the values".into(), expected, format!("{}", values.len()));
        }
        if clock.len() < FEWEST_SAMPLES {
            return refuse("the samples".into(), format!("at least {FEWEST_SAMPLES}"), format!("{}", clock.len()));
        }
        if let Some(i) = clock.iter().position(|&t| !usable(t)) {
            let at = format!("the clock at sample {}", i + 1);
            return refuse(at, usable_number(), format!("{:?}", clock[i]));
        }
        if let Some(i) = values.iter().position(|&v| !usable(v)) {
            let (sample, channel) = (i / channels.len(), &channels[i % channels.len()]);
            let at = format!("`{}` at sample {}", channel.name, sample + 1);
            return refuse(at, usable_number(), format!("{:?}", values[i]));
        }
        if let Some(i) = falling(&clock) {
            return refuse(
                format!("the clock at sample {}", i + 2),
                format!("more than {}", clock[i]),
                format!("{}", clock[i + 1]),
            );
        }
        if kind == Kind::EventTimes
            && let Some(i) = falling(&values)
        {
            return refuse(
                format!("{} {}", channels[0].name.replace('_', " "), i + 2),
                format!("more than {}", values[i]),
                format!("{}", values[i + 1]),
            );
        }
        Ok(Self { kind, channels, clock, values, circumstances: None })
    }

    /// A body's centre over time, shape `[sample, 3]`.
    ///
    /// # Errors
    /// As [`Observation::new`].
    pub fn positions(time_s: Vec<f64>, position_m: &[[f64; 3]]) -> Result<Self> {
        Self::new(Kind::Positions, Channel::positions(), time_s, position_m.concat())
    }

    /// Instants of events, s, numbered from 0, on a channel of this name.
    ///
    /// # Errors
    /// As [`Observation::new`].
    pub fn event_times(name: &str, time_s: Vec<f64>) -> Result<Self> {
        let index = (0..time_s.len()).map(|i| i as f64).collect();
        Self::new(Kind::EventTimes, vec![Channel::new(name, "s")], index, time_s)
    }

    /// The same, recorded in these circumstances. They stay with every part of it.
    #[must_use]
    pub fn under(self, circumstances: impl Into<Arc<Circumstances>>) -> Self {
        Self { circumstances: Some(circumstances.into()), ..self }
    }

    /// What is known of it besides what was observed, where anything is.
    #[must_use]
    pub fn circumstances(&self) -> Option<&Arc<Circumstances>> {
        self.circumstances.as_ref()
    }

    /// What kind of thing was measured.
    #[must_use]
    pub fn kind(&self) -> Kind {
        self.kind
    }

    /// The columns.
    #[must_use]
    pub fn channels(&self) -> &[Channel] {
        &self.channels
    }

    /// The unit of all channels; `None` where they differ.
    #[must_use]
    pub fn common_unit(&self) -> Option<&str> {
        common_unit(&self.channels)
    }

    /// The clock: seconds, or the number of the event for [`Kind::EventTimes`]. Strictly rising.
    #[must_use]
    pub fn clock(&self) -> &[f64] {
        &self.clock
    }

    /// All values, row-major `[sample, channel]`.
    #[must_use]
    pub fn values(&self) -> &[f64] {
        &self.values
    }

    /// How many samples. Never 0, so there is no `is_empty`.
    #[must_use]
    #[expect(clippy::len_without_is_empty, reason = "an observation is never empty")]
    pub fn len(&self) -> usize {
        self.clock.len()
    }

    /// One sample, shape `[channel]`.
    ///
    /// # Panics
    /// Where `sample` is not below [`Observation::len`].
    #[must_use]
    pub fn row(&self, sample: usize) -> &[f64] {
        let width = self.channels.len();
        &self.values[sample * width..(sample + 1) * width]
    }

    /// One channel over time.
    ///
    /// # Panics
    /// Where `channel` is not below the number of channels.
    #[must_use]
    pub fn column(&self, channel: usize) -> impl ExactSizeIterator<Item = f64> + '_ {
        check_channel(self, channel);
        self.values[channel..].iter().step_by(self.channels.len()).copied()
    }

    /// Evenly chosen samples, at most `most` of them; `None` where there are no more than that.
    ///
    /// # Errors
    /// [`Error::Observation`] where `most` is below [`FEWEST_SAMPLES`].
    pub fn thinned(&self, most: usize) -> Result<Option<Self>> {
        if self.len() <= most {
            return Ok(None);
        }
        let every = self.len().div_ceil(most.max(1));
        let clock = self.clock.iter().step_by(every).copied().collect();
        let values = (0..self.len()).step_by(every).flat_map(|i| self.row(i).iter().copied()).collect();
        Ok(Some(self.same_circumstances(Self::new(self.kind, self.channels.clone(), clock, values)?)))
    }

    /// The same with the clock shifted to begin at 0.
    #[must_use]
    pub fn from_zero(&self) -> Self {
        self.earlier(self.clock[0])
    }

    /// The same on a clock that starts this much earlier, its inputs as well.
    fn earlier(&self, by_s: f64) -> Self {
        let clock = self.clock.iter().map(|t| t - by_s).collect();
        let circumstances = self.circumstances.as_ref().map(|known| Arc::new(known.earlier(by_s)));
        Self { clock, circumstances, ..self.clone() }
    }

    /// Other values at the same instants, in the same circumstances.
    ///
    /// # Errors
    /// As [`Observation::new`].
    pub fn with_values(&self, values: Vec<f64>) -> Result<Self> {
        let other = Self::new(self.kind, self.channels.clone(), self.clock.clone(), values)?;
        Ok(self.same_circumstances(other))
    }

    /// `part` of this recording, in the circumstances of the whole.
    #[must_use]
    pub fn same_circumstances(&self, part: Self) -> Self {
        Self { circumstances: self.circumstances.clone(), ..part }
    }

    /// The samples of `range` alone.
    ///
    /// # Errors
    /// [`Error::Observation`] where fewer than [`FEWEST_SAMPLES`] are left.
    ///
    /// # Panics
    /// Where `range` leaves the observation.
    pub fn slice(&self, range: std::ops::Range<usize>) -> Result<Self> {
        let width = self.channels.len();
        let values = self.values[range.start * width..range.end * width].to_vec();
        Ok(self.same_circumstances(Self::new(self.kind, self.channels.clone(), self.clock[range].to_vec(), values)?))
    }
}

/// Panics, with both numbers, where there is no such channel.
fn check_channel(seen: &Observation, channel: usize) {
    assert!(channel < seen.channels.len(), "channel {channel} of {}", seen.channels.len());
}

/// The first place where `clock[i + 1] <= clock[i]`.
fn falling(clock: &[f64]) -> Option<usize> {
    clock.windows(2).position(|pair| pair[1] <= pair[0])
}
