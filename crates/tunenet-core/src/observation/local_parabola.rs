//! Leave-one-out residuals of local parabolas (local quadratic regression): whether a sample lies on the curve of its neighbours.

use nalgebra::{Matrix3, Vector3};

/// Neighbours of a parabola that spans the sample, and of one that ends next to it.
pub(super) const SPANNING: usize = 7;
const ONE_SIDED: usize = 5;
/// So many of those that span it lie on either side at least: with one alone, a parabola can follow a kink.
const FEWEST_EACH_SIDE: usize = 2;
/// The neighbours lie on the parabola where none leaves it by more than so many standard deviations of the noise ...
const SMOOTH: f64 = 4.0;
/// ... and this share of the least deviation that counts.
const SMOOTH_SHARE: f64 = 0.03;
/// A sample is off where it leaves the parabola by so many standard deviations of its forecast ...
const OFF: f64 = 8.0;
/// ... and so many times as far as the worst of the neighbours.
const OFF_OTHERS: f64 = 4.0;

/// One channel of a recording.
pub(super) struct Channel<'a> {
    clock: &'a [f64],
    values: Vec<f64>,
    noise_sd: f64,
    /// Least deviation that counts, in the channel's unit.
    least: f64,
}

/// A sample as its neighbours forecast it.
struct Forecast {
    value: f64,
    /// Standard deviation of the forecast's error for noise of 1.
    relative_sd: f64,
    /// Largest residual among the neighbours.
    worst: f64,
}

impl<'a> Channel<'a> {
    pub(super) fn new(clock: &'a [f64], values: Vec<f64>, noise_sd: f64, least: f64) -> Self {
        Self { clock, values, noise_sd, least }
    }

    /// How far sample `i` is off a parabola of neighbours on both of its sides, or off both those that end and begin next to
    /// it; `None` where it is on them, or nothing fits. The first sample has one side only. Samples marked in `without` are no
    /// neighbours.
    pub(super) fn deviation(&self, i: usize, without: &[bool]) -> Option<f64> {
        let mut before: Vec<usize> = (0..i).rev().filter(|&k| !without[k]).take(SPANNING).collect();
        let after: Vec<usize> = (i + 1..self.values.len()).filter(|&k| !without[k]).take(SPANNING).collect();
        let side = |side: &[usize]| (side.len() > ONE_SIDED).then(|| self.off_all(i, &side[..=ONE_SIDED], 0)).flatten();
        // The last sample may be the first one after an impact.
        if after.is_empty() {
            return None;
        }
        let step = |a: usize, b: usize| (self.values[a] - self.values[b]).abs();
        let steps = |side: &[usize]| side.windows(2).take(2).map(|pair| step(pair[0], pair[1])).fold(0.0, f64::max);
        // The first sample may be of a body that is still held.
        if before.is_empty() {
            return side(&after).filter(|_| step(i, after[0]) > steps(&after));
        }
        if !self.is_suspicious(i, before[0], after[0]) {
            return None;
        }
        // A motion of one sample between two impacts is off both, by less than one step of the motion.
        let longest = steps(&before).max(steps(&after));
        let both = side(&before).zip(side(&after)).map(|(a, b)| a.min(b)).filter(|off| *off > longest);
        if self.continues(i, &before) || self.continues(i, &after) {
            return None;
        }
        before.reverse();
        // Next to the end of a record there is one neighbour on that side.
        let fewest = FEWEST_EACH_SIDE.min(before.len()).min(after.len());
        let spanning = (fewest..=SPANNING + 1 - fewest).filter_map(|left| {
            let right = SPANNING + 1 - left;
            if left > before.len() || right > after.len() {
                return None;
            }
            self.off_all(i, &[&before[before.len() - left..], &after[..right]].concat(), fewest)
        });
        spanning.chain(both).reduce(f64::max)
    }

    /// Off the line between the nearest neighbours: cheap, and true of few samples.
    fn is_suspicious(&self, i: usize, before: usize, after: usize) -> bool {
        let share = (self.clock[i] - self.clock[before]) / (self.clock[after] - self.clock[before]);
        let line = self.values[before] + share * (self.values[after] - self.values[before]);
        (self.values[i] - line).abs() > OFF * self.noise_sd + self.least
    }

    /// How far sample `i` is at least off the parabolas through all but one of these neighbours, of which one may be an
    /// outlier itself, with at least `fewest` left on either side; `None` where it is on one of them, or no parabola fits.
    fn off_all(&self, i: usize, neighbours: &[usize], fewest: usize) -> Option<f64> {
        let mut least = None;
        for left_out in 0..neighbours.len() {
            let kept: Vec<usize> =
                neighbours.iter().enumerate().filter(|(k, _)| *k != left_out).map(|(_, &k)| k).collect();
            let before = kept.iter().filter(|k| **k < i).count();
            if before.min(kept.len() - before) < fewest {
                continue;
            }
            let Some(forecast) = self.forecast(i, &kept) else { continue };
            if forecast.worst > SMOOTH * self.noise_sd + SMOOTH_SHARE * self.least {
                continue;
            }
            let off = (self.values[i] - forecast.value).abs();
            let noise = OFF * self.noise_sd * forecast.relative_sd;
            if off <= noise.max(OFF_OTHERS * forecast.worst) + self.least {
                return None;
            }
            least = Some(least.map_or(off, |before: f64| before.min(off)));
        }
        least
    }

    /// Whether sample `i` continues the motion on one side, as the last sample before an impact does.
    fn continues(&self, i: usize, side: &[usize]) -> bool {
        let near = |forecast: Forecast| {
            forecast.worst <= SMOOTH * self.noise_sd + SMOOTH_SHARE * self.least
                && (self.values[i] - forecast.value).abs() <= SMOOTH * self.noise_sd * forecast.relative_sd + self.least
        };
        side.len() >= ONE_SIDED && self.forecast(i, &side[..ONE_SIDED]).is_some_and(near)
    }

    /// By least squares; `None` where the instants do not determine a parabola.
    fn forecast(&self, i: usize, neighbours: &[usize]) -> Option<Forecast> {
        let scale = neighbours.iter().map(|&k| (self.clock[k] - self.clock[i]).abs()).fold(0.0, f64::max);
        let row = |k: usize| {
            let t = (self.clock[k] - self.clock[i]) / scale;
            Vector3::new(1.0, t, t * t)
        };
        let (mut normal, mut right) = (Matrix3::zeros(), Vector3::zeros());
        for &k in neighbours {
            normal += row(k) * row(k).transpose();
            right += row(k) * self.values[k];
        }
        let cholesky = normal.cholesky()?;
        let coefficients = cholesky.solve(&right);
        let worst = neighbours.iter().map(|&k| (self.values[k] - row(k).dot(&coefficients)).abs()).fold(0.0, f64::max);
        let relative_sd = (1.0 + cholesky.inverse()[(0, 0)]).sqrt();
        Some(Forecast { value: coefficients[0], relative_sd, worst })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A fall from 1 m onto a surface that returns 0.7 of the speed, at 30 Hz, without noise.
    fn impacts() -> (Vec<f64>, Vec<f64>) {
        let g = 9.81;
        let clock: Vec<f64> = (0..60).map(|i| f64::from(i) / 30.0).collect();
        let height = |t: f64| {
            let mut speed = (2.0 * g * 1.0f64).sqrt();
            let mut start = speed / g;
            if t < start {
                return 1.0 - 0.5 * g * t * t;
            }
            loop {
                speed *= 0.7;
                let duration = 2.0 * speed / g;
                if t < start + duration {
                    return (t - start) * (speed - 0.5 * g * (t - start));
                }
                start += duration;
            }
        };
        let values = clock.iter().map(|t| height(*t)).collect();
        (clock, values)
    }

    #[test]
    fn motion_with_impacts_is_never_off() {
        let (clock, values) = impacts();
        for noise_sd in [0.0, 0.002, 0.01] {
            let channel = Channel::new(&clock, values.clone(), noise_sd, 0.01);
            assert!((0..values.len()).all(|i| channel.deviation(i, &[false; 60]).is_none()));
        }
    }

    #[test]
    fn a_tenth_of_the_height_is_off_but_next_to_an_impact() {
        let (clock, values) = impacts();
        // The first impact is at 0.45 s, between samples 13 and 14.
        for i in [0, 1, 5, 9, 11, 16, 19, 22] {
            let mut damaged = values.clone();
            damaged[i] += 0.1;
            let channel = Channel::new(&clock, damaged, 0.002, 0.01);
            let deviation = |i: usize| channel.deviation(i, &[false; 60]).unwrap_or(0.0);
            let most = (0..values.len()).max_by(|a, b| deviation(*a).total_cmp(&deviation(*b)));
            assert_eq!(most, Some(i));
            assert!((deviation(i) - 0.1).abs() < 0.02, "sample {i}: {}", deviation(i));
        }
    }

    /// Held for one sample more, then let go upwards at 6 m/s.
    #[test]
    fn a_body_that_is_still_held_is_not_off() {
        let clock: Vec<f64> = (0..20).map(|i| f64::from(i) / 60.0).collect();
        let height = |t: f64| 3.0 + 6.0 * t - 0.5 * 9.81 * t * t;
        let values = clock.iter().map(|t| height((t - clock[1]).max(0.0))).collect();
        let channel = Channel::new(&clock, values, 0.0003, 0.01);
        assert_eq!(channel.deviation(0, &[false; 20]), None);
    }
}
