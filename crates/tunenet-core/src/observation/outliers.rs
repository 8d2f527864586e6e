//! Outliers by an order-statistic range, by local linear interpolation and by leave-one-out residuals of local parabolas: single
//! samples that cannot belong to the motion, such as a tracker that jumped for one frame, or a digit too many.

use super::local_parabola::{Channel, SPANNING};
use super::{FEWEST_SAMPLES, Observation, noise_sd};

/// Share of the samples on either side that the usual range leaves out.
const TAIL: usize = 50;

/// A lone sample stands out from this many times the noise ...
const OFF_NOISE: f64 = 15.0;
/// ... and this many steps of its neighbours off their line.
const OFF_STEPS: f64 = 1.5;
/// ... and this share of the range of the others.
const OFF_SHARE: f64 = 0.01;

/// Off a parabola by less than this share of the range may be a short motion between two impacts.
const OFF_PARABOLA: f64 = 0.005;
/// Passes with parabolas, each without the samples found before: more outliers in one neighbourhood are motion.
const PASSES: usize = 8;
/// A jump for so many samples is still an accident.
const LONGEST_RUN: usize = 2;

/// The places marked in runs of at most `longest`.
fn runs_of_at_most(longest: usize, marked: &[bool]) -> Vec<usize> {
    let mut all = Vec::new();
    let mut run = Vec::new();
    for i in 0..=marked.len() {
        if i < marked.len() && marked[i] {
            run.push(i);
        } else if run.len() <= longest {
            all.append(&mut run);
        } else {
            run.clear();
        }
    }
    all
}

impl Observation {
    /// The samples (from 0) that leap out of the range of the others by more than that whole range, or off their neighbours'
    /// line by more than noise and motion can, and are back at the next sample; and those off the parabola on which the
    /// samples before and after them lie, at most two in a row. More in a row are motion, however strange, and stay.
    #[must_use]
    pub fn outliers(&self) -> Vec<usize> {
        let mut ranges = Vec::new();
        let outside: Vec<Vec<bool>> = (0..self.channels().len())
            .map(|channel| {
                let mut sorted: Vec<f64> = self.column(channel).collect();
                sorted.sort_unstable_by(f64::total_cmp);
                let tail = sorted.len().div_ceil(TAIL);
                let (low, high) = (sorted[tail.min(sorted.len() - 1)], sorted[sorted.len().saturating_sub(tail + 1)]);
                let range = high - low;
                ranges.push(range);
                self.column(channel).map(|v| range > 0.0 && (v > high + range || v < low - range)).collect()
            })
            .collect();
        let sd: Vec<f64> = (0..self.channels().len()).map(|c| noise_sd(&self.column(c).collect::<Vec<_>>())).collect();
        let leaps = |i: usize| {
            outside.iter().any(|c| c[i])
                || (0..sd.len()).any(|c| self.stands_out(i, c, OFF_NOISE * sd[c] + OFF_SHARE * ranges[c]))
        };
        let alone = |i: usize| leaps(i) && (i == 0 || !leaps(i - 1)) && (i + 1 == self.len() || !leaps(i + 1));
        let mut outlying: Vec<bool> = (0..self.len()).map(alone).collect();
        let channels: Vec<Channel<'_>> = (0..sd.len())
            .filter(|&c| ranges[c] > 0.0)
            .map(|c| Channel::new(self.clock(), self.column(c).collect(), sd[c], OFF_PARABOLA * ranges[c]))
            .collect();
        // The worst of each neighbourhood goes first, and no longer bends the parabolas of its neighbours.
        for _ in 0..PASSES {
            let deviation = |i: usize| channels.iter().filter_map(|c| c.deviation(i, &outlying)).reduce(f64::max);
            let off: Vec<f64> =
                (0..self.len()).map(|i| if outlying[i] { 0.0 } else { deviation(i).unwrap_or(0.0) }).collect();
            let worst = |i: usize| {
                let (low, high) = (i.saturating_sub(SPANNING), (i + SPANNING + 1).min(off.len()));
                off[i] > 0.0 && off[low..high].iter().all(|other| *other <= off[i])
            };
            let found: Vec<usize> = (0..self.len()).filter(|&i| worst(i)).collect();
            if found.is_empty() {
                break;
            }
            for i in found {
                outlying[i] = true;
            }
        }
        runs_of_at_most(LONGEST_RUN, &outlying)
    }

    /// Whether sample `i` lies off the line between its neighbours by far more than the noise, and by more than the motion
    /// about it could: an impact bends the path there by one step at most.
    fn stands_out(&self, i: usize, channel: usize, least: f64) -> bool {
        if i < 2 || i + 2 >= self.len() {
            return false;
        }
        let (t, v) = (|k: usize| self.clock()[k], |k: usize| self.row(k)[channel]);
        let share = (t(i) - t(i - 1)) / (t(i + 1) - t(i - 1));
        let off = (v(i) - v(i - 1) - share * (v(i + 1) - v(i - 1))).abs();
        let steps = [v(i - 1) - v(i - 2), v(i + 1) - v(i - 1), v(i + 2) - v(i + 1)];
        let step = steps.iter().fold(0.0f64, |most, s| most.max(s.abs()));
        off > least + OFF_STEPS * step
    }

    /// The same without the samples at `places`; `None` where none is to go or too few would be left.
    #[must_use]
    pub fn without(&self, places: &[usize]) -> Option<Self> {
        if places.is_empty() || self.len() < places.len() + FEWEST_SAMPLES {
            return None;
        }
        let mut keep = vec![true; self.len()];
        for &i in places {
            keep[i] = false;
        }
        let kept: Vec<usize> = (0..self.len()).filter(|&i| keep[i]).collect();
        let clock = kept.iter().map(|&i| self.clock()[i]).collect();
        let values = kept.iter().flat_map(|&i| self.row(i).iter().copied()).collect();
        Self::new(self.kind(), self.channels().to_vec(), clock, values).ok()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn drop(outliers: &[(usize, f64)]) -> Observation {
        let clock: Vec<f64> = (0..120).map(|i| f64::from(i) / 120.0).collect();
        // A fall of 1 m in 0.45 s, then rest.
        let mut position_m: Vec<[f64; 3]> = clock.iter().map(|t| [0.0, 0.0, (1.0 - 4.905 * t * t).max(0.0)]).collect();
        for &(i, z) in outliers {
            position_m[i][2] = z;
        }
        Observation::positions(clock, &position_m).unwrap()
    }

    #[test]
    fn a_leap_of_one_sample_is_an_outlier() {
        let seen = drop(&[(40, 1e6), (80, -3.0)]);
        assert_eq!(seen.outliers(), [40, 80]);
        let kept = seen.without(&seen.outliers()).unwrap();
        assert!(kept.len() == 118 && kept.outliers().is_empty());
    }

    #[test]
    fn motion_is_not() {
        assert!(drop(&[]).outliers().is_empty());
        assert!(drop(&[(40, 5.0), (41, 5.0), (42, 5.0)]).outliers().is_empty(), "three in a row");
        assert_eq!(drop(&[(20, 0.5)]).outliers(), [20], "within the range, but off the path");
        assert_eq!(drop(&[(70, 0.01), (90, 0.004)]).outliers(), [70], "a hundredth of the range, but not a 250th");
        assert!(drop(&[]).without(&[]).is_none());
    }
}
