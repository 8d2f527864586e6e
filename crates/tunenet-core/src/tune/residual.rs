//! Residuals: always measured − predicted, in units of the noise.

use super::fit::Problem;
use super::unknowns::Point;
use crate::Result;
use crate::observation::{Kind, Observation, bounce_time_sd, noise_sd};
use crate::simulator::{Prepared, Simulator, predict};

/// Noise below this share of a channel's range cannot be told from rounding; it keeps weights finite.
const LEAST_RELATIVE_NOISE: f64 = 1e-9;
/// Fits by which the spreads of the channels settle.
const WEIGHINGS: usize = 3;

/// The standard deviation of the noise of each channel, shape `[channel]`, in the channel's unit.
///
/// For a time series from third differences of the series itself. Bounce times have no smooth neighbour to compare with,
/// so theirs is what a restitution that may change evenly from bounce to bounce leaves over.
#[must_use]
pub fn channel_noise(seen: &Observation) -> Vec<f64> {
    let columns = (0..seen.channels().len()).map(|channel| seen.column(channel).collect::<Vec<f64>>());
    let columns: Vec<Vec<f64>> = columns.collect();
    let ranges = columns.iter().map(|c| {
        let (low, high) = c.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(*v), h.max(*v)));
        high - low
    });
    // A channel that never moves (a ball dropped straight down in exact data) must not weigh infinitely.
    let widest = ranges.fold(0.0, f64::max).max(f64::MIN_POSITIVE);
    let noise = |column: &Vec<f64>| match seen.kind() {
        Kind::BounceTimes => bounce_time_sd(seen.clock(), column),
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

/// Of driven recordings: finds the [`spread`](Prepared::spread) of each channel's residuals by fitting, so that a joint whose
/// torques the model explains badly does not outvote those that it explains well.
///
/// # Errors
/// Where the simulator refuses.
pub(super) fn weigh(simulator: &dyn Simulator, recordings: &mut [Prepared], free: &[usize]) -> Result<()> {
    if recordings.iter().any(|r| r.input.is_none() || r.noise.is_none()) {
        return Ok(());
    }
    let mut point = Point::start(simulator, recordings);
    for _ in 0..WEIGHINGS {
        let noise: Vec<Vec<f64>> = recordings.iter().map(weights).collect();
        let fit = Problem { simulator, recordings, noise: &noise, free }.fit(point, 1.0)?;
        let width = simulator.channels().len();
        let spread = |channel: usize| {
            let of = |(r, n): (&Vec<f64>, &Vec<f64>)| {
                let squares = r.iter().skip(channel).step_by(width).map(|r| (r * n[channel]).powi(2));
                (squares.sum::<f64>(), r.len() / width)
            };
            let (sum, count) = fit.residuals.iter().zip(&noise).map(of).fold((0.0, 0), |a, b| (a.0 + b.0, a.1 + b.1));
            (sum / count.max(1) as f64).sqrt()
        };
        let spreads: Vec<f64> = (0..width).map(spread).collect();
        for recording in recordings.iter_mut() {
            let floor = floor(recording);
            recording.spread = Some(floor.iter().zip(&spreads).map(|(f, s)| f.max(*s)).collect());
        }
        point = fit.point;
    }
    Ok(())
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
    own: &[f64],
    samples: usize,
) -> Result<Vec<f64>> {
    let mut predicted = predict(simulator, recording, parameters, own, &recording.seen.clock()[..samples])?;
    for (i, (value, seen)) in predicted.iter_mut().zip(recording.seen.values()).enumerate() {
        *value = (seen - *value) / noise[i % noise.len()];
    }
    Ok(predicted)
}
