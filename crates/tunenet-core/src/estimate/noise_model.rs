//! Noise of each channel by differences of a series (von Neumann 1941; third differences), or as it is known.

use crate::observation::{Kind, Observation, event_time_sd, lattice_step, noise_sd};
use crate::simulator::Prepared;

/// Noise below this share of a channel's range cannot be distinguished from rounding; it keeps weights finite.
const LEAST_RELATIVE_NOISE: f64 = 1e-9;
/// Readings of which more than this share equal the one before them come from a sensor with a step.
const REPEATED: f64 = 0.02;

/// The standard deviation of the noise of each channel, shape `[channel]`, in the channel's unit.
///
/// For a time series from third differences of the series itself. The readings of an encoder that stands for most of a recording
/// have none, so those of a user's own simulator are never known better than their step q allows, q/√12. Event times have no smooth
/// neighbour to compare with, so theirs is what a share of speed returned that may change evenly from impact to impact leaves over.
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
        _ => noise_sd(column).max(resolution(seen.kind(), column)),
    };
    columns.iter().map(|column| noise(column).max(LEAST_RELATIVE_NOISE * widest)).collect()
}

/// The standard deviation of rounding to the step q of a sensor, q/√12, in the unit of the readings; 0 where they show no step. Exact
/// numbers may lie on a lattice as well, such as those of a line; they do not repeat.
pub(crate) fn resolution(kind: Kind, readings: &[f64]) -> f64 {
    let repeated = readings.windows(2).filter(|two| two[0] == two[1]).count();
    let many = repeated as f64 > REPEATED * readings.len() as f64;
    let step = (kind == Kind::Other && many).then(|| lattice_step(readings)).flatten();
    step.unwrap_or(0.0) / 12f64.sqrt()
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
    use crate::observation::Channel;
    use crate::testing::{Exact, Line};

    #[test]
    fn third_differences_see_the_noise_and_not_the_line() {
        let seen = Exact::new(Line).observe(&[("slope", 2.0)], &[0.5], 0.01, 7).unwrap();
        let noise = channel_noise(&seen);
        assert!((noise[0] / 0.01 - 1.0).abs() < 0.3, "{noise:?}");
        let exact = Exact::new(Line).observe(&[("slope", 2.0)], &[0.5], 0.0, 7).unwrap();
        assert!(channel_noise(&exact)[0] > 0.0);
    }

    #[test]
    fn an_encoder_that_mostly_stands_is_known_to_its_step() {
        let step = std::f64::consts::TAU / 4096.0;
        let swing = |i: u32| 0.3 * (f64::from(i.saturating_sub(300)) * 0.02).sin();
        let counts: Vec<f64> = (0..400).map(|i| (swing(i) / step).round() * step).collect();
        let clock = (0..400).map(|i| f64::from(i) * 0.01).collect();
        let seen = Observation::new(Kind::Other, vec![Channel::new("q", "rad")], clock, counts).unwrap();
        assert!((channel_noise(&seen)[0] * 12f64.sqrt() / step - 1.0).abs() < 1e-6, "{:?}", channel_noise(&seen));
        // A line lies on a lattice, and no sensor has rounded it.
        let line: Vec<f64> = (0..400).map(|i| f64::from(i) * 0.007).collect();
        let seen = Observation::new(Kind::Other, vec![Channel::new("q", "rad")], line.clone(), line).unwrap();
        assert!(channel_noise(&seen)[0] < 1e-6, "{:?}", channel_noise(&seen));
    }
}
