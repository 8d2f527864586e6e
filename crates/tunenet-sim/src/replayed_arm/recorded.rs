//! A log of joints as it is replayed: on an even clock, smoothed, differentiated.

use tunenet_core::observation::{Channel, Observation, noise_sd};
use tunenet_core::statistics::median;

use super::filter::{edge, slope, smooth, whole};

/// A clock is even where no interval strays farther than this from the median.
const EVEN: f64 = 1e-3;
/// An interval longer than this many usual ones is a gap, and what lies next to it is not used.
const GAP: f64 = 4.0;
/// The cut-off is at most this share of the rate, so that differences are exact below it.
const GREATEST_CUTOFF: f64 = 0.2;

/// A log on an even clock: shape `[sample, joint]`, row-major.
#[derive(Debug, Clone)]
pub(super) struct Recorded {
    pub start_s: f64,
    pub step_s: f64,
    pub joints: usize,
    /// Smoothed positions (rad), and their first and second slopes.
    pub q: Vec<f64>,
    pub dq: Vec<f64>,
    pub ddq: Vec<f64>,
    /// Torques as measured, N·m.
    pub torque: Vec<f64>,
    /// Whether a sample is far enough from the ends and from gaps.
    pub trusted: Vec<bool>,
    /// Cut-off of the smoothing, Hz.
    pub cutoff_hz: f64,
    /// Noise of the torques, N·m, for each joint.
    pub noise_nm: Vec<f64>,
}

/// The columns of a quantity (`q`, `dq`, `tau`, `i`), in the order of the joints.
pub(super) fn columns(seen: &Observation, quantity: &str) -> Vec<usize> {
    let number = |c: &Channel| c.name.strip_prefix(quantity).and_then(|rest| rest.parse::<usize>().ok());
    let mut found: Vec<(usize, usize)> =
        seen.channels().iter().enumerate().filter_map(|(i, c)| Some((number(c)?, i))).collect();
    found.sort_unstable();
    found.into_iter().map(|(_, i)| i).collect()
}

impl Recorded {
    /// The log `seen`, whose torques are `torque` (row-major, on the clock of `seen`). It has to have positions.
    ///
    /// `prefix` is "r" for the channels of a reference.
    pub fn new(seen: &Observation, prefix: &str, torque: &[f64], cutoff_hz: f64) -> Self {
        let clock = seen.clock();
        let step_s = even_step(clock);
        let even = clock.windows(2).all(|w| ((w[1] - w[0]) / step_s - 1.0).abs() < EVEN);
        let span = clock[clock.len() - 1] - clock[0];
        let count = if even { clock.len() } else { whole(span / step_s) + 1 };
        let step_s = if even { span / (count - 1) as f64 } else { step_s };
        let rate_hz = 1.0 / step_s;
        let cutoff_hz = cutoff_hz.min(GREATEST_CUTOFF * rate_hz);
        let positions = columns(seen, &format!("{prefix}q"));
        let joints = positions.len();
        let time = |i: usize| clock[0] + i as f64 * step_s;
        let mut new = Self {
            start_s: clock[0],
            step_s,
            joints,
            q: vec![0.0; count * joints],
            dq: vec![0.0; count * joints],
            ddq: vec![0.0; count * joints],
            torque: vec![0.0; count * joints],
            trusted: trusted(clock, step_s, count, edge(cutoff_hz, rate_hz)),
            cutoff_hz,
            noise_nm: Vec::new(),
        };
        for (joint, &column) in positions.iter().enumerate() {
            let q: Vec<f64> = seen.column(column).collect();
            let measured: Vec<f64> = torque.iter().skip(joint).step_by(joints).copied().collect();
            let (q, measured) = if even {
                (q, measured)
            } else {
                let times: Vec<f64> = (0..count).map(time).collect();
                (cubic(clock, &q, &times), linear(clock, &measured, &times))
            };
            let q = smooth(&q, cutoff_hz, rate_hz);
            let dq = slope(&q, step_s);
            let ddq = slope(&dq, step_s);
            new.noise_nm.push(noise_sd(&measured));
            for (values, into) in [(q, &mut new.q), (dq, &mut new.dq), (ddq, &mut new.ddq), (measured, &mut new.torque)]
            {
                into.iter_mut().skip(joint).step_by(joints).zip(values).for_each(|(into, value)| *into = value);
            }
        }
        new
    }

    pub fn len(&self) -> usize {
        self.trusted.len()
    }

    /// One row of a series.
    pub fn row<'a>(&self, series: &'a [f64], i: usize) -> &'a [f64] {
        &series[i * self.joints..(i + 1) * self.joints]
    }
}

/// Which samples of the even clock lie farther than `edge` from the ends and from gaps of the clock measured.
fn trusted(clock: &[f64], step_s: f64, count: usize, edge: usize) -> Vec<bool> {
    let mut trusted = vec![true; count];
    let mut distrust = |from_s: f64, to_s: f64| {
        let index = |t: f64| whole(((t - clock[0]) / step_s).clamp(0.0, count as f64));
        let (from, to) = (index(from_s).saturating_sub(edge), (index(to_s) + edge + 1).min(count));
        trusted[from..to].fill(false);
    };
    distrust(clock[0], clock[0]);
    distrust(clock[clock.len() - 1], clock[clock.len() - 1]);
    clock.windows(2).filter(|w| w[1] - w[0] > GAP * step_s).for_each(|w| distrust(w[0], w[1]));
    trusted
}

/// The usual interval of a clock.
pub(super) fn even_step(clock: &[f64]) -> f64 {
    median(clock.windows(2).map(|w| w[1] - w[0])).unwrap_or(f64::NAN)
}

/// Where each of the rising `times` falls into `clock`: the index of the sample before it.
fn places<'a>(clock: &'a [f64], times: &'a [f64]) -> impl Iterator<Item = (f64, usize)> + 'a {
    let mut at = 0;
    times.iter().map(move |t| {
        while at + 2 < clock.len() && clock[at + 1] <= *t {
            at += 1;
        }
        (*t, at)
    })
}

/// Straight from sample to sample, constant beyond the ends; `times` rise.
pub(super) fn linear(clock: &[f64], values: &[f64], times: &[f64]) -> Vec<f64> {
    let at = |(t, i): (f64, usize)| {
        let share = (t - clock[i]) / (clock[i + 1] - clock[i]);
        values[i] + share.clamp(0.0, 1.0) * (values[i + 1] - values[i])
    };
    places(clock, times).map(at).collect()
}

/// Through the two samples on either side (Lagrange); linear next to a gap and at the ends.
pub(super) fn cubic(clock: &[f64], values: &[f64], times: &[f64]) -> Vec<f64> {
    let straight = linear(clock, values, times);
    let at = |((t, i), straight): ((f64, usize), f64)| {
        if i == 0 || i + 2 >= clock.len() {
            return straight;
        }
        let near = i - 1..i + 3;
        let usual = clock[i + 1] - clock[i];
        if clock[i + 2] - clock[i - 1] > 3.0 * GAP * usual || clock[i + 2] - clock[i + 1] < 0.1 * usual {
            return straight;
        }
        let weight = |k: usize| {
            near.clone().filter(|&j| j != k).map(|j| (t - clock[j]) / (clock[k] - clock[j])).product::<f64>()
        };
        near.clone().map(|k| weight(k) * values[k]).sum()
    };
    places(clock, times).zip(straight).map(at).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn uneven_clocks_are_interpolated() {
        let clock: Vec<f64> = (0..40).map(|i| f64::from(i) + 0.2 * f64::from(i % 3)).collect();
        let values: Vec<f64> = clock.iter().map(|t| t * t * t - 5.0 * t).collect();
        let times = [3.5, 4.0, 17.3];
        for (t, found) in times.iter().zip(cubic(&clock, &values, &times)) {
            assert!((found - (t * t * t - 5.0 * t)).abs() < 1e-9, "{t}");
        }
        assert_eq!(linear(&[0.0, 1.0, 3.0], &[0.0, 2.0, 4.0], &[0.5, 2.0, 3.0]), [1.0, 3.0, 4.0]);
    }

    #[test]
    fn ends_and_gaps_are_not_trusted() {
        let mut clock: Vec<f64> = (0..100).map(|i| 0.1 * f64::from(i)).collect();
        clock.drain(40..50);
        let found = trusted(&clock, 0.1, 100, 5);
        assert!(
            !found[0] && !found[5] && found[6] && !found[36] && !found[45] && !found[55] && found[57] && !found[99]
        );
    }
}
