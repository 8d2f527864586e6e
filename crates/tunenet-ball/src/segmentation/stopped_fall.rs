//! Change-point regression of a drop that few noisy samples show: held still, falling from rest under gravity, lying still.
//!
//! z = a − g/2 · clamp(t − t₀, 0, T)², least squares in the level a, the release t₀ and the time of fall T. Gravity is known, so
//! these three numbers do where separate parabolas would need ten.

use super::polynomial::Polynomial;
use super::span;
use tunenet_core::observation::noise_sd;

/// More samples show the drop to the other detectors; the time grows with the third power of their number.
const MOST_SAMPLES: usize = 90;
/// Releases and landings are tried at these parts of the way from one sample to the next.
const PARTS: [f64; 4] = [0.0, 0.25, 0.5, 0.75];
/// Fewest samples of the hold, the fall and the rest.
const FEWEST: usize = 4;
/// The drop is taken where it raises the log-likelihood by half of this over one parabola (a Bayes factor beyond e^10) ...
const EVIDENCE: f64 = 20.0;
/// ... leaves at most this many times the noise, which thirty samples show to a fifth ...
const MOST_LEFT: f64 = 1.6;
/// ... is this many times the noise high ...
const LEAST_HEIGHT: f64 = 8.0;
/// ... and where another acceleration, with its own times, explains the heights no better than by this much of the same measure.
const OTHER_GRAVITY: f64 = 9.0;

/// The last sample of the fall; `None` where the record does not show a drop like this.
pub(crate) fn stopped_fall(clock: &[f64], heights: &[f64], gravity: f64) -> Option<usize> {
    let n = heights.len();
    if !(3 * FEWEST..=MOST_SAMPLES).contains(&n) {
        return None;
    }
    let instants: Vec<f64> =
        clock.windows(2).flat_map(|two| PARTS.map(|part| two[0] + part * (two[1] - two[0]))).collect();
    let (mut best, mut left, mut left_by_any) = ((0.0, 0.0), f64::INFINITY, f64::INFINITY);
    let parts = PARTS.len();
    for begin in parts * (FEWEST - 1)..parts * (n - 2 * FEWEST) {
        for end in begin + parts * FEWEST..parts * (n - FEWEST) {
            let (from, to) = (instants[begin], instants[end]);
            let sums = Sums::of(clock, heights, from, to - from);
            left_by_any = left_by_any.min(sums.left(sums.acceleration()));
            if sums.left(gravity) < left {
                (best, left) = ((from, to), sums.left(gravity));
            }
        }
    }
    let whole = Polynomial::fit(clock, heights, clock[0], None)?;
    let squares: f64 = clock.iter().zip(heights).map(|(&t, &z)| (z - whole.at(t)).powi(2)).sum();
    let noise = noise_sd(heights).max(1e-9 * span(heights));
    let height = gravity / 2.0 * (best.1 - best.0).powi(2);
    let gain = |from: f64, to: f64| n as f64 * (from / to.max(f64::MIN_POSITIVE)).ln();
    let explained = left < (MOST_LEFT * noise).powi(2) * (n as f64 - 3.0);
    let by_gravity = gain(squares, left) > EVIDENCE && gain(left, left_by_any) < OTHER_GRAVITY;
    (by_gravity && explained && height > LEAST_HEIGHT * noise)
        .then(|| clock.partition_point(|t| *t <= best.1).saturating_sub(1))
}

/// Sums of squares and products of the heights z and of what a fall from an instant on takes off, f = clamp(t − t₀, 0, T)²/2,
/// both less their means.
struct Sums {
    zz: f64,
    zf: f64,
    ff: f64,
}

impl Sums {
    fn of(clock: &[f64], heights: &[f64], from: f64, lasts: f64) -> Self {
        let (mut z, mut f, mut zz, mut zf, mut ff) = (0.0, 0.0, 0.0, 0.0, 0.0);
        for (t, height) in clock.iter().zip(heights) {
            // From the first height, so that the sums of squares stay small.
            let (height, fallen) = (height - heights[0], (t - from).clamp(0.0, lasts).powi(2) / 2.0);
            z += height;
            f += fallen;
            zz += height * height;
            zf += height * fallen;
            ff += fallen * fallen;
        }
        let n = heights.len() as f64;
        Self { zz: zz - z * z / n, zf: zf - z * f / n, ff: ff - f * f / n }
    }

    /// The acceleration downwards that leaves least; none of an upward one.
    fn acceleration(&self) -> f64 {
        (-self.zf / self.ff.max(f64::MIN_POSITIVE)).max(0.0)
    }

    /// The sum of squares that a fall with this acceleration leaves.
    fn left(&self, acceleration: f64) -> f64 {
        (self.zz + 2.0 * acceleration * self.zf + acceleration * acceleration * self.ff).max(0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;
    use rand_distr::{Distribution, Normal};

    const NOISE_M: f64 = 0.022;

    /// 36 samples at 27 Hz with 22 mm of noise on `height`.
    fn record(seed: u64, height: impl Fn(f64) -> f64) -> (Vec<f64>, Vec<f64>) {
        let draws = Normal::new(0.0, NOISE_M).unwrap().sample_iter(rand_chacha::ChaCha8Rng::seed_from_u64(seed));
        let clock: Vec<f64> = (0..36).map(|i| f64::from(i) / 27.0).collect();
        let heights = clock.iter().zip(draws).map(|(t, noise)| height(*t) + noise).collect();
        (clock, heights)
    }

    fn found(height: impl Fn(f64) -> f64 + Copy) -> Vec<Option<usize>> {
        let one = |seed| {
            let (clock, heights) = record(seed, height);
            stopped_fall(&clock, &heights, 9.81)
        };
        (0..40).map(one).collect()
    }

    #[test]
    fn a_drop_under_noise_ends_where_it_lands() {
        // It falls from 0.45 s to 0.763 s: 12.2 to 20.6 samples; a rebound at 0.15 of the speed rises by 1 cm.
        for restitution in [0.0, 0.15] {
            let drop = |t: f64| {
                let after = (t - 0.763).clamp(0.0, 2.0 * restitution * 3.07 / 9.81);
                0.1 - 4.905 * (t - 0.45).clamp(0.0, 0.313).powi(2) + restitution * 3.07 * after - 4.905 * after * after
            };
            let all = found(drop);
            let right = all.iter().filter(|end| end.is_some_and(|end| (19..=22).contains(&end))).count();
            assert!(right >= 36, "{right} of 40: {all:?}");
        }
    }

    #[test]
    fn other_motions_are_no_drop() {
        type Motion = fn(f64) -> f64;
        let others: [(&str, Motion); 7] = [
            ("rest", |_| 0.3),
            ("a throw", |t| 6.5 * t - 4.905 * t * t),
            ("a fall that nothing stops", |t| 2.0 - 4.905 * (t - 0.5).max(0.0).powi(2)),
            ("a swing", |t| 0.3 * (4.0 * t).cos()),
            ("lowered by hand", |t| 0.1 - 0.8 * (t - 0.4).clamp(0.0, 0.6)),
            ("a third of gravity", |t| 0.1 - 1.6 * (t - 0.4).clamp(0.0, 0.55).powi(2)),
            ("lifted", |t| 4.905 * (t - 0.45).clamp(0.0, 0.313).powi(2)),
        ];
        for (name, motion) in others {
            let wrong = found(motion).iter().flatten().count();
            assert_eq!(wrong, 0, "{name}: {wrong} of 40");
        }
    }
}
