//! Drifts of a measurement to first order in time: a scale, an orientation and a clock rate that change while recordings last, as
//! rivals of a force.

use crate::simulator::Prepared;

/// What each drift changes of the predictions of each recording, in units of the noise: shape `[drift][recording][value]`, per 1/s of the
/// scale, per rad/s about the normal of each two channels, and per 1/s of the clock's rate.
pub(super) fn drifts(recordings: &[Prepared], noise: &[Vec<f64>], residuals: &[Vec<f64>]) -> Vec<Vec<Vec<f64>>> {
    let each: Vec<Vec<Vec<f64>>> = recordings
        .iter()
        .zip(noise)
        .zip(residuals)
        .map(|((recording, noise), residuals)| of_one(recording, noise, residuals))
        .collect();
    let count = each.iter().map(Vec::len).min().unwrap_or(0);
    (0..count).map(|drift| each.iter().map(|one| one[drift].clone()).collect()).collect()
}

fn of_one(recording: &Prepared, noise: &[f64], residuals: &[f64]) -> Vec<Vec<f64>> {
    let (seen, width) = (&recording.seen, noise.len());
    let clock = seen.clock();
    let predicted: Vec<f64> =
        seen.values().iter().zip(residuals).enumerate().map(|(i, (seen, r))| seen - noise[i % width] * r).collect();
    let at = |sample: usize, channel: usize| predicted[sample * width + channel];
    let passed_s = |sample: usize| clock[sample] - clock[0];
    let speed = |sample: usize, channel: usize| {
        let (before, after) = (sample.saturating_sub(1), (sample + 1).min(clock.len() - 1));
        let span_s = clock[after] - clock[before];
        if span_s > 0.0 { (at(after, channel) - at(before, channel)) / span_s } else { 0.0 }
    };
    let change = |of: &dyn Fn(usize, usize) -> f64| {
        let value = |i: usize| of(i / width, i % width) / noise[i % width];
        (0..predicted.len()).map(value).collect::<Vec<f64>>()
    };
    let scale = change(&|sample, channel| passed_s(sample) * at(sample, channel));
    let rate = change(&|sample, channel| passed_s(sample).powi(2) * speed(sample, channel));
    let pairs = (0..width).flat_map(|b| (0..b).map(move |a| (a, b)));
    let turns = pairs.map(|(a, b)| {
        change(&|sample, channel| {
            let turned = [(a, -at(sample, b)), (b, at(sample, a))];
            turned.iter().find(|(own, _)| *own == channel).map_or(0.0, |(_, by)| passed_s(sample) * by)
        })
    });
    std::iter::once(scale).chain(turns).chain([rate]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::observation::Observation;

    /// Along x = 2 + 3 t, y = 1, z = 0 and with noise 0.5, by hand.
    #[test]
    fn drifts_change_a_straight_path_as_their_derivatives_say() {
        let clock = vec![1.0, 1.5, 2.0];
        let rows: Vec<[f64; 3]> = clock.iter().map(|t| [2.0 + 3.0 * (t - 1.0) + 0.5, 1.0, 0.0]).collect();
        let recording = Prepared::whole(Observation::positions(clock, &rows).unwrap(), 0);
        let residuals: Vec<f64> = (0..9).map(|i| if i % 3 == 0 { 1.0 } else { 0.0 }).collect();
        let found = drifts(&[recording], &[vec![0.5; 3]], &[residuals]);
        assert_eq!(found.len(), 5);
        let last = |drift: usize| &found[drift][0][6..];
        assert_eq!(last(0), [10.0, 2.0, 0.0], "scale");
        assert_eq!(last(1), [-2.0, 10.0, 0.0], "turn of x towards y");
        assert_eq!(last(2), [0.0, 0.0, 10.0], "turn of x towards z");
        assert_eq!(last(3), [0.0, 0.0, 2.0], "turn of y towards z");
        assert_eq!(last(4), [6.0, 0.0, 0.0], "rate of the clock");
    }
}
