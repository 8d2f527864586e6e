//! Noise of each channel by differences of a series (von Neumann 1941; third differences), or as it is known.

use crate::observation::{Kind, Observation, event_time_sd, noise_sd};
use crate::simulator::Prepared;

/// Noise below this share of a channel's range cannot be distinguished from rounding; it keeps weights finite.
const LEAST_RELATIVE_NOISE: f64 = 1e-9;

/// The standard deviation of the noise of each channel, shape `[channel]`, in the channel's unit.
///
/// For a time series from third differences of the series itself. Event times have no smooth neighbour to compare with,
/// so theirs is what a share of speed returned that may change evenly from impact to impact leaves over.
#[must_use]
pub fn channel_noise(seen: &Observation) -> Vec<f64> {
    let columns = (0..seen.channels().len()).map(|channel| seen.column(channel).collect::<Vec<f64>>());
    let columns: Vec<Vec<f64>> = columns.collect();
    let ranges = columns.iter().map(|c| {
        let (low, high) = c.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(*v), h.max(*v)));
        high - low
    });
    // A channel that never moves (a body that falls straight down in exact data) must not weigh infinitely.
    let widest = ranges.fold(0.0, f64::max).max(f64::MIN_POSITIVE);
    let noise = |column: &Vec<f64>| match seen.kind() {
        Kind::EventTimes => event_time_sd(seen.clock(), column),
        _ => noise_sd(column),
    };
    columns.iter().map(|column| noise(column).max(LEAST_RELATIVE_NOISE * widest)).collect()
}

/// The noise of a recording's channels: what is known of it, or else [`channel_noise`].
pub(crate) fn floor(recording: &Prepared) -> Vec<f64> {
    recording.noise.clone().unwrap_or_else(|| channel_noise(&recording.seen))
}

/// What residuals of each channel are measured in: the noise, or the scale estimate of the residual where that is known.
pub(crate) fn weights(recording: &Prepared) -> Vec<f64> {
    recording.residual_scale.clone().unwrap_or_else(|| floor(recording))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{Exact, Line};

    #[test]
    fn third_differences_see_the_noise_and_not_the_line() {
        let seen = Exact::new(Line).observe(&[("slope", 2.0)], &[0.5], 0.01, 7).unwrap();
        let noise = channel_noise(&seen);
        assert!((noise[0] / 0.01 - 1.0).abs() < 0.3, "{noise:?}");
        let exact = Exact::new(Line).observe(&[("slope", 2.0)], &[0.5], 0.0, 7).unwrap();
        assert!(channel_noise(&exact)[0] > 0.0);
    }
}
