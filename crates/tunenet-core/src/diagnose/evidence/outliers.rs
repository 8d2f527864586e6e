//! Outliers: single samples far from their neighbours (median filter, Hampel 1974).

use super::recording::PreparedRecording;
use crate::statistics::{mad_sd, median};

/// A sample is an outlier where it leaves the median of its neighbours' residuals by this many robust standard deviations.
const OUTLYING: f64 = 6.0;
/// More than this share of outlying samples is no accident, and they stay.
const MOST_OUTLYING: f64 = 0.05;
/// So near to an event, s and samples, an event that is not as simulated leaves its mark.
const NEAR_S: f64 = 0.03;
const NEAR: usize = 2;
/// Accidents are independent of events: samples that are so many times as frequent near events, and so many at least, stay.
const GATHERED: f64 = 3.0;
const FEWEST_GATHERED: usize = 4;

/// Sets samples aside that leave their neighbours, by `residuals` in units of the noise; returns how many.
///
/// A misfit between events is smooth, so it moves neighbours together. One at events (an event lasts, or the shutter is open) does
/// not; but it is there at every event, and an accident is not.
pub(in crate::diagnose) fn set_aside(recordings: &mut [PreparedRecording], residuals: &[Vec<f64>]) -> usize {
    let (mut chosen, mut near, mut far) = (Vec::new(), Share::default(), Share::default());
    for (index, (recording, values)) in recordings.iter().zip(residuals).enumerate() {
        let close = near_events(recording);
        let width = recording.width();
        for i in (0..values.len()).filter(|&i| recording.keep[i]) {
            (if close[i / width] { &mut near } else { &mut far }).all += 1;
        }
        for i in outlying(recording, values) {
            (if close[i / width] { &mut near } else { &mut far }).outlying += 1;
            chosen.push((index, i, close[i / width]));
        }
    }
    let gathered = near.outlying >= FEWEST_GATHERED && near.of() > GATHERED * far.of();
    chosen.retain(|(_, _, close)| !(gathered && *close));
    for &(index, i, _) in &chosen {
        recordings[index].keep[i] = false;
    }
    chosen.len()
}

#[derive(Default)]
struct Share {
    outlying: usize,
    all: usize,
}

impl Share {
    fn of(&self) -> f64 {
        self.outlying as f64 / (self.all as f64).max(1.0)
    }
}

/// Which samples lie near an event.
fn near_events(recording: &PreparedRecording) -> Vec<bool> {
    let clock = recording.clock();
    let mut close = vec![false; clock.len()];
    for event in &recording.events {
        let at = clock.partition_point(|t| t < event);
        let first = clock.partition_point(|t| *t < event - NEAR_S).min(at.saturating_sub(NEAR));
        let last = clock.partition_point(|t| *t <= event + NEAR_S).max(at + NEAR).min(clock.len());
        close[first..last].fill(true);
    }
    close
}

/// The values of a recording that leave their neighbours.
fn outlying(recording: &PreparedRecording, residuals: &[f64]) -> Vec<usize> {
    let width = recording.width();
    let mut all = Vec::new();
    for channel in 0..width {
        let kept: Vec<usize> = (channel..residuals.len()).step_by(width).filter(|&i| recording.keep[i]).collect();
        if kept.len() < 12 {
            continue;
        }
        let off: Vec<f64> = (0..kept.len())
            .map(|k| {
                let (low, high) = (k.saturating_sub(3), (k + 4).min(kept.len()));
                let near = (low..high).filter(|&j| j != k).map(|j| residuals[kept[j]]);
                residuals[kept[k]] - median(near).unwrap_or(0.0)
            })
            .collect();
        let spread = mad_sd(off.iter().copied()).max(0.5);
        let outlying: Vec<usize> = (0..off.len()).filter(|&k| off[k].abs() > OUTLYING * spread).collect();
        if (outlying.len() as f64) < MOST_OUTLYING * kept.len() as f64 {
            all.extend(outlying.into_iter().map(|k| kept[k]));
        }
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::observation::Observation;
    use crate::simulator::Prepared;

    /// Two seconds at 100 Hz with events every 0.4 s, residuals of alternating sign, and these samples far off.
    fn with(outlying: &[usize]) -> (Vec<PreparedRecording>, Vec<Vec<f64>>) {
        let clock: Vec<f64> = (0..200).map(|k| f64::from(k) * 0.01).collect();
        let rows: Vec<[f64; 3]> = clock.iter().map(|t| [*t, 0.5 * t, (t * 5.0).sin()]).collect();
        let mut recording =
            PreparedRecording::new(0, 0, false, Prepared::whole(Observation::positions(clock, &rows).unwrap(), 1));
        recording.events = vec![0.4, 0.8, 1.2, 1.6];
        let mut residuals: Vec<f64> = (0..600).map(|i| if i % 2 == 0 { 1.0 } else { -1.0 }).collect();
        for k in outlying {
            residuals[3 * k + 2] = 20.0;
        }
        (vec![recording], vec![residuals])
    }

    #[test]
    fn accidents_go_and_what_every_event_shows_stays() {
        let (mut recordings, residuals) = with(&[15, 62, 101, 40]);
        assert_eq!(set_aside(&mut recordings, &residuals), 4);
        assert!(!recordings[0].keep[3 * 62 + 2] && recordings[0].keep[3 * 62 + 1]);
        let (mut recordings, residuals) = with(&[40, 80, 120, 160]);
        assert_eq!(set_aside(&mut recordings, &residuals), 0, "one at every event");
        let (mut recordings, residuals) = with(&[40, 80, 120, 160, 62]);
        assert_eq!(set_aside(&mut recordings, &residuals), 1, "the accident goes all the same");
    }
}
