//! Root mean square of the residuals, recording by recording and channel by channel, each in the unit of its channel.

use serde::Serialize;

use crate::estimate::floor;
use crate::simulator::Prepared;

/// How far simulation and measurement lie apart in one channel of one recording, as a root mean square.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ChannelGap {
    /// The recording's position among those that were used.
    pub recording: usize,
    /// The channel's name.
    pub channel: String,
    /// The unit of all three.
    pub unit: String,
    /// How many samples it has.
    pub samples: usize,
    /// With the parameters as they were, the recording's nuisance parameters fitted.
    pub before: f64,
    /// With the answer.
    pub after: f64,
    /// What noise alone leaves.
    pub noise_floor: f64,
}

/// The gaps before and after, from residuals over the noise of their channels.
pub(super) fn channel_gaps(
    recordings: &[Prepared],
    noise: &[Vec<f64>],
    before: &[Vec<f64>],
    after: &[Vec<f64>],
) -> Vec<ChannelGap> {
    let mut all = Vec::new();
    for (d, recording) in recordings.iter().enumerate() {
        let (channels, floors) = (recording.seen.channels(), floor(recording));
        for (c, channel) in channels.iter().enumerate() {
            let rms = |residuals: &[f64]| {
                let own = residuals.iter().skip(c).step_by(channels.len()).map(|r| (r * noise[d][c]).powi(2));
                (own.sum::<f64>() / recording.seen.len() as f64).sqrt()
            };
            all.push(ChannelGap {
                recording: d,
                channel: channel.name.clone(),
                unit: channel.unit.clone(),
                samples: recording.seen.len(),
                before: rms(&before[d]),
                after: rms(&after[d]),
                noise_floor: floors[c],
            });
        }
    }
    all
}

/// The same over all recordings, channel by channel in the order of their first recording.
#[must_use]
pub fn over_recordings(gaps: &[ChannelGap]) -> Vec<ChannelGap> {
    let mut all: Vec<ChannelGap> = Vec::new();
    for gap in gaps {
        let Some(sum) = all.iter_mut().find(|one| one.channel == gap.channel) else {
            all.push(gap.clone());
            continue;
        };
        let (n, m) = (sum.samples as f64, gap.samples as f64);
        let mean = |a: f64, b: f64| ((a * a * n + b * b * m) / (n + m)).sqrt();
        (sum.before, sum.after) = (mean(sum.before, gap.before), mean(sum.after, gap.after));
        sum.noise_floor = mean(sum.noise_floor, gap.noise_floor);
        sum.samples += gap.samples;
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::observation::{Channel, Kind, Observation};

    #[test]
    fn every_channel_has_its_own_unit_and_recordings_add_up() {
        let channels = vec![Channel::new("x", "m"), Channel::new("q", "rad")];
        let seen = Observation::new(Kind::Other, channels, vec![0.0, 1.0, 2.0], vec![0.0; 6]).unwrap();
        let mut recording = Prepared::whole(seen, 0);
        recording.noise = Some(vec![0.5, 0.1]);
        let recordings = [recording.clone(), recording];
        let noise = vec![vec![0.5, 0.1]; 2];
        let before = [[2.0, 10.0].repeat(3), [6.0, 0.0].repeat(3)];
        let gaps = channel_gaps(&recordings, &noise, &before, &before);
        let shown: Vec<_> = gaps.iter().map(|g| (g.recording, g.unit.as_str(), g.before)).collect();
        assert_eq!(shown, [(0, "m", 1.0), (0, "rad", 1.0), (1, "m", 3.0), (1, "rad", 0.0)]);
        let whole = over_recordings(&gaps);
        assert_eq!(whole.len(), 2);
        assert!((whole[0].after - 5.0_f64.sqrt()).abs() < 1e-12 && whole[0].samples == 6, "{whole:?}");
    }
}
