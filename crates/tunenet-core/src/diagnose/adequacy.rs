//! Whether what a model leaves is noise.

use nalgebra::{DMatrix, DVector};

use super::Test;
use super::evidence::{upper_chi_squared, upper_f};
use super::joint::dot;
use super::scores::Score;
use super::sets::Set;
use super::study::{Model, Study};
use crate::observation::Kind;
use crate::tune::Adequacy;

/// A test fails only below this probability ...
const PROBABLE: f64 = 1e-3;
/// ... and beyond these practical bounds, since enough real data fail every test.
const PORTMANTEAU: f64 = 1.15;
const BAND_RATIO: f64 = 1.25;
const SCATTER: f64 = 1.3;
/// The test of whether recordings agree on the free numbers.
pub(super) const AGREEMENT: &str = "agreement between recordings";
/// Lags of the portmanteau test, at most this share of a recording.
const LAGS: usize = 15;
const LAG_SHARE: usize = 5;
/// Bodies move below the first of these, Hz; between them lies what should be noise.
const LOW_HZ: f64 = 4.0;
const HIGH_HZ: f64 = 14.0;

/// What rounding leaves of a number, as a share of the largest, with room for the sums that led to it.
const ROUNDING: f64 = 1e-12;

impl Study<'_> {
    /// Tests what `model` leaves; all have to pass.
    pub fn adequacy(&self, model: &Model) -> Vec<Test> {
        let residuals = &model.fit.residuals;
        let unknowns = model.structure.globals.len() as f64;
        let mut tests: Vec<Test> = [portmanteau(&self.sets, residuals), band_power(&self.sets, residuals, unknowns)]
            .into_iter()
            .flatten()
            .collect();
        tests.extend(self.heterogeneity(model));
        tests.extend(self.size_of_rest(model));
        if self.is_rounding(model) {
            for test in &mut tests {
                test.passed = true;
            }
        }
        tests
    }

    /// Whether nothing is left but what counting in binary leaves: that has a shape of its own, and nothing is missing in it.
    fn is_rounding(&self, model: &Model) -> bool {
        let Ok(residuals) = self.joint(&model.structure).plain_residuals(&model.fit.point) else { return false };
        self.sets.iter().zip(&residuals).all(|(set, residual)| {
            let largest = set.prepared.seen.values().iter().fold(0.0, |most: f64, value| most.max(value.abs()));
            residual.iter().all(|r| r.abs() <= ROUNDING * largest)
        })
    }

    /// Of lists of bounces, too short for any test of shape: whether the residual is no larger than the noise of single
    /// intervals, by the same limit as in tuning.
    fn size_of_rest(&self, model: &Model) -> Option<Test> {
        let heard =
            self.sets.iter().zip(&model.fit.residuals).filter(|(s, _)| s.prepared.seen.kind() == Kind::BounceTimes);
        let share = model.structure.globals.len().div_ceil(self.sets.len().max(1));
        let each = heard.map(|(set, residual)| {
            Adequacy::of(&set.prepared.seen, &set.noise, residual, set.prepared.own.len() + share)
        });
        let worst = each.filter(|a| a.tested).max_by(|a, b| (a.ratio / a.limit).total_cmp(&(b.ratio / b.limit)))?;
        Some(Test { name: "residual over noise", value: worst.ratio, threshold: worst.limit, passed: !worst.poor() })
    }

    /// Whether the recordings agree on the free numbers: how far each alone would move them, weighed by how well it knows
    /// them, after its own unknowns (a score test; χ² over the recordings).
    fn heterogeneity(&self, model: &Model) -> Option<Test> {
        let scores = self.scores(model);
        let size = model.structure.globals.len();
        let mut whole = vec![0.0; size];
        for score in &scores {
            score.places.iter().enumerate().for_each(|(i, &place)| whole[place] += score.normal[(i, i)]);
        }
        let (mut chi, mut freedom) = (0.0, 0.0);
        for Score { places, normal, pull, .. } in scores {
            // In units in which all recordings together know each number to 1.
            let unit: Vec<f64> = places.iter().map(|&p| f64::max(whole[p], f64::MIN_POSITIVE).sqrt()).collect();
            let scaled = DMatrix::from_fn(places.len(), places.len(), |i, j| normal[(i, j)] / (unit[i] * unit[j]));
            if places.is_empty() || scaled.iter().any(|v| !v.is_finite()) {
                continue;
            }
            let pull = DVector::from_fn(places.len(), |i, _| pull[i] / unit[i]);
            let eigen = scaled.symmetric_eigen();
            for (k, value) in eigen.eigenvalues.iter().enumerate().filter(|(_, value)| **value > 1e-6) {
                chi += eigen.eigenvectors.column(k).dot(&pull).powi(2) / value;
                freedom += 1.0;
            }
        }
        freedom -= size as f64;
        let count = self.count() as f64;
        let variance = model.deviance(model.scale()) / (count - size as f64).max(1.0);
        if freedom < 1.0 || variance <= 0.0 {
            return None;
        }
        let chi = chi / variance;
        let passed = upper_chi_squared(chi, freedom) > PROBABLE || chi / freedom < SCATTER;
        Some(Test { name: AGREEMENT, value: chi / freedom, threshold: limit(freedom, SCATTER), passed })
    }
}

/// The greatest χ²/ν that passes.
fn limit(freedom: f64, practical: f64) -> f64 {
    use statrs::distribution::{ChiSquared, ContinuousCDF};
    ChiSquared::new(freedom).map_or(practical, |d| (d.inverse_cdf(1.0 - PROBABLE) / freedom).max(practical))
}

/// The kept values of each channel of each recording, with their instants.
fn series<'a>(sets: &'a [Set], residuals: &'a [Vec<f64>]) -> impl Iterator<Item = (usize, Vec<f64>, Vec<f64>)> + 'a {
    sets.iter().zip(residuals).enumerate().flat_map(|(d, (set, residual))| {
        let width = set.width();
        (0..width).filter_map(move |channel| {
            let places = || (channel..residual.len()).step_by(width).filter(|&i| set.keep[i]);
            let values: Vec<f64> = places().map(|i| residual[i]).collect();
            let clock = places().map(|i| set.clock()[i / width]).collect();
            (values.len() >= 12).then_some((d, clock, values))
        })
    })
}

/// Ljung and Box (1978) over all channels and recordings: `Q = n (n + 2) Σ r_k²/(n − k)`, summed.
fn portmanteau(sets: &[Set], residuals: &[Vec<f64>]) -> Option<Test> {
    let (mut total, mut freedom) = (0.0, 0.0);
    for (_, _, values) in series(sets, residuals) {
        let n = values.len();
        let lags = LAGS.min(n / LAG_SHARE);
        // Single heavy samples would drown every correlation.
        let values: Vec<f64> = values.iter().map(|v| v.clamp(-4.0, 4.0)).collect();
        let square = dot(&values, &values);
        if square <= 0.0 {
            continue;
        }
        let each = (1..=lags).map(|k| (dot(&values[k..], &values[..n - k]) / square).powi(2) / (n - k) as f64);
        total += each.sum::<f64>() * (n * (n + 2)) as f64;
        freedom += lags as f64;
    }
    if freedom < 1.0 {
        return None;
    }
    let passed = upper_chi_squared(total, freedom) > PROBABLE || total / freedom < PORTMANTEAU;
    Some(Test {
        name: "correlation of neighbours",
        value: total / freedom,
        threshold: limit(freedom, PORTMANTEAU),
        passed,
    })
}

/// Mean power below [`LOW_HZ`] over that between it and [`HIGH_HZ`]; `unknowns` numbers were fitted to all recordings, and
/// each had its own.
fn band_power(sets: &[Set], residuals: &[Vec<f64>], unknowns: f64) -> Option<Test> {
    let (mut low, mut high, mut low_count, mut high_count) = (0.0, 0.0, 0.0, 0.0);
    for (_, clock, values) in series(sets, residuals) {
        let n = values.len();
        let duration = (clock[n - 1] - clock[0]) * n as f64 / (n - 1) as f64;
        let nyquist = 0.5 * n as f64 / duration;
        let edge = LOW_HZ.min(nyquist / 3.0);
        let values: Vec<f64> = values.iter().map(|v| v.clamp(-4.0, 4.0)).collect();
        let mut bin = 1.0;
        while bin / duration < HIGH_HZ.min(0.9 * nyquist) {
            let hertz = bin / duration;
            let omega = std::f64::consts::TAU * hertz;
            let (mut cosine, mut sine) = (0.0, 0.0);
            for (t, v) in clock.iter().zip(&values) {
                let (s, c) = (omega * (t - clock[0])).sin_cos();
                cosine += v * c;
                sine += v * s;
            }
            let power = 2.0 * (cosine * cosine + sine * sine) / n as f64;
            if hertz < edge {
                (low, low_count) = (low + power, low_count + 2.0);
            } else {
                (high, high_count) = (high + power, high_count + 2.0);
            }
            bin += 1.0;
        }
    }
    // The fit has taken its unknowns out of the low band, nearly all.
    let own: usize = sets.iter().map(|s| s.prepared.own.len()).sum();
    let fitted = (0.8 * own as f64 + unknowns).min(0.6 * low_count);
    let (low_freedom, high_freedom) = (low_count - fitted, high_count);
    if low_freedom < 4.0 || high_freedom < 4.0 || high <= 0.0 {
        return None;
    }
    let ratio = (low / low_freedom) / (high / high_freedom);
    let passed = upper_f(ratio, low_freedom, high_freedom) > PROBABLE || ratio < BAND_RATIO;
    Some(Test {
        name: "slow against fast residual",
        value: ratio,
        threshold: f_limit(low_freedom, high_freedom),
        passed,
    })
}

fn f_limit(above: f64, below: f64) -> f64 {
    use statrs::distribution::{ContinuousCDF, FisherSnedecor};
    FisherSnedecor::new(above, below).map_or(BAND_RATIO, |d| d.inverse_cdf(1.0 - PROBABLE).max(BAND_RATIO))
}
