//! Copies of one motion: however often it is repeated, it distinguishes no more than once.

use crate::diagnose::evidence::recording::PreparedRecording;

/// Two motions that differ by less than this share of themselves (root mean squares, noise taken off) are one motion: a person
/// who repeats one stays below, and one who starts half as high again goes far beyond.
const ALIKE: f64 = 0.25;
/// Recordings that share less than this part of the longer one are not compared.
const COMMON: f64 = 0.5;

/// Marks recordings of one object that show the same motion as an earlier one with its `motion`.
pub(in crate::diagnose) fn label(recordings: &mut [PreparedRecording]) {
    let mut first: Vec<usize> = Vec::new();
    for i in 0..recordings.len() {
        match first.iter().find(|&&known| alike(&recordings[known], &recordings[i])) {
            Some(&known) => recordings[i].motion = recordings[known].motion,
            None => first.push(i),
        }
    }
}

fn alike(a: &PreparedRecording, b: &PreparedRecording) -> bool {
    a.object == b.object && a.width() == b.width() && difference(a, b).is_some_and(|share| share < ALIKE)
}

/// The distance of two motions over their common time, each about its own mean, as a share of the first.
fn difference(a: &PreparedRecording, b: &PreparedRecording) -> Option<f64> {
    let (ours, theirs, width) = (a.clock(), b.clock(), a.width());
    let length = |clock: &[f64]| clock[clock.len() - 1] - clock[0];
    let common = ours.partition_point(|t| t - ours[0] <= length(theirs));
    if ours[common - 1] - ours[0] < COMMON * length(ours).max(length(theirs)) {
        return None;
    }
    let (mut distance, mut motion) = (0.0, 0.0);
    for channel in 0..width {
        let counted: Vec<usize> = (0..common).filter(|k| a.keep[k * width + channel]).collect();
        let moved: Vec<f64> = counted.iter().map(|&k| a.prepared.seen.row(k)[channel]).collect();
        let differ: Vec<f64> =
            counted.iter().zip(&moved).map(|(&k, v)| v - at(b, channel, theirs[0] + ours[k] - ours[0])).collect();
        let noise = a.noise[channel].powi(2) + b.noise[channel].powi(2);
        distance += squares(&differ) - noise * differ.len() as f64;
        motion += squares(&moved);
    }
    (motion > 0.0).then(|| (distance.max(0.0) / motion).sqrt())
}

/// A channel at an instant, between its samples.
fn at(recording: &PreparedRecording, channel: usize, time: f64) -> f64 {
    let (clock, seen) = (recording.clock(), &recording.prepared.seen);
    let next = clock.partition_point(|t| *t < time).clamp(1, clock.len() - 1);
    let share = ((time - clock[next - 1]) / (clock[next] - clock[next - 1])).clamp(0.0, 1.0);
    let (before, after) = (seen.row(next - 1)[channel], seen.row(next)[channel]);
    before + share * (after - before)
}

/// The sum of squares about the mean.
fn squares(values: &[f64]) -> f64 {
    let mean = values.iter().sum::<f64>() / (values.len() as f64).max(1.0);
    values.iter().map(|v| (v - mean).powi(2)).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::observation::Observation;
    use crate::simulator::Prepared;

    /// A fall from `height` with these speeds along x and z.
    fn falling(index: usize, object: usize, height: f64, along: f64, up: f64) -> PreparedRecording {
        let clock: Vec<f64> = (0..60).map(|k| f64::from(k) * 0.01).collect();
        let row = |t: &f64| [along * t, 0.0, height + up * t - 4.905 * t * t];
        let rows: Vec<[f64; 3]> = clock.iter().map(row).collect();
        PreparedRecording::new(index, object, false, Prepared::whole(Observation::positions(clock, &rows).unwrap(), 1))
    }

    #[test]
    fn a_repeated_motion_counts_once_and_a_turned_one_again() {
        let mut recordings = vec![
            falling(0, 0, 1.0, 1.0, 0.5),
            falling(1, 0, 1.02, 1.02, 0.48),
            falling(2, 0, 1.0, -1.0, 0.5),
            falling(3, 0, 1.0, 1.0, 2.5),
            falling(4, 1, 1.0, 1.0, 0.5),
        ];
        label(&mut recordings);
        let motions: Vec<usize> = recordings.iter().map(|r| r.motion).collect();
        assert_eq!(motions, [0, 0, 2, 3, 4], "another direction, another speed, another object");
    }
}
