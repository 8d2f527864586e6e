//! Residuals: always measured − predicted, in units of the noise.

use crate::Result;
use crate::observation::{Kind, Observation, event_time_sd, noise_sd};
use crate::simulator::{Prepared, Simulator, predict};

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

/// What residuals of each channel are measured in: the noise, or the spread of what is left where that is known.
pub(super) fn weights(recording: &Prepared) -> Vec<f64> {
    recording.spread.clone().unwrap_or_else(|| floor(recording))
}

/// (measured − predicted) / noise for one recording, row-major `[sample, channel]`, over its first `samples` samples.
///
/// # Errors
/// Where the simulator refuses these values.
pub fn weighted(
    simulator: &dyn Simulator,
    recording: &Prepared,
    noise: &[f64],
    parameters: &[f64],
    nuisances: &[f64],
    samples: usize,
) -> Result<Vec<f64>> {
    let mut predicted = predict(simulator, recording, parameters, nuisances, &recording.seen.clock()[..samples])?;
    for (i, (value, seen)) in predicted.iter_mut().zip(recording.seen.values()).enumerate() {
        *value = (seen - *value) / noise[i % noise.len()];
    }
    Ok(predicted)
}
