//! Residual diagnostics: portmanteau test (Ljung and Box 1978), band power (F test), agreement (score test).

use nalgebra::{DMatrix, DVector};

use crate::diagnose::Test;
use crate::diagnose::evidence::Evidence;
use crate::diagnose::evidence::ar1_correlation::LONGEST_OF_DISCREPANCY;
use crate::diagnose::evidence::recording::PreparedRecording;
use crate::diagnose::hypothesis::context::{Context, Hypothesis};
use crate::diagnose::judge::recording_scores::scores_and_nuisances;
use crate::estimate::cluster_robust::Score;
use crate::estimate::{Adequacy, is_below_step};
use crate::observation::Kind;
use crate::statistics::{chi_squared_quantile, dot, fisher_quantile, root_mean_square, upper_chi_squared, upper_f};

/// A test fails only below this probability ...
const PROBABLE: f64 = 1e-3;
/// ... and beyond these practical bounds, since enough real data fail every test.
const PORTMANTEAU: f64 = 1.15;
const BAND_RATIO: f64 = 1.25;
const SCATTER: f64 = 1.3;
/// Lags of the portmanteau test, at most this share of a recording.
const LAGS: usize = 15;
const LAG_SHARE: usize = 5;
/// Bodies move below the first of these, Hz; between them lies what should be noise.
const LOW_HZ: f64 = 4.0;
const HIGH_HZ: f64 = 14.0;
/// With fewer degrees of freedom in the slow band than the first of these, one bend of the measurement decides the test of the bands; and with
/// fewer in the fast band than the second, chance does.
const LEAST_SLOW: f64 = 8.0;
const LEAST_FAST: f64 = 4.0;

/// A lag-1 correlation above this is more than sensors and trackers are known for at the rates that people record at.
const LONG_LAG1: f64 = 0.7;
/// Below a step of the sensor, an effect has to leave at most this share of the residual (root mean square) of held-out recordings: errors
/// of the integration that made them have a shape too.
pub(in crate::diagnose) const RESOLVED: f64 = 0.5;
/// What rounding leaves of a number, as a share of the largest: of clocks in whole nanoseconds, with room for speeds.
const ROUNDING: f64 = 1e-8;

/// Residual diagnostics of a hypothesis: what it leaves is noise where all tests pass.
#[derive(Default)]
pub(in crate::diagnose) struct ResidualDiagnostics {
    pub tests: Vec<Test>,
    /// Whether the recordings differ among themselves by more than their noise.
    pub heterogeneous: bool,
}

impl ResidualDiagnostics {
    pub fn passed(&self) -> bool {
        self.tests.iter().all(|test| test.passed)
    }
}

/// Whether what `model` leaves passes every test.
pub(in crate::diagnose) fn is_adequate(context: &Context, model: &Hypothesis) -> bool {
    residual_diagnostics(context, model).passed()
}

/// Tests what `model` leaves.
pub(in crate::diagnose) fn residual_diagnostics(context: &Context, model: &Hypothesis) -> ResidualDiagnostics {
    let residuals = &model.fit.residuals;
    let unknowns = model.structure.shared.len() as f64;
    let (scores, nuisances) = scores_and_nuisances(context, model);
    let slow_against_fast = band_power(context.recordings(), residuals, (&nuisances, unknowns));
    let mut tests: Vec<Test> =
        [portmanteau(context.recordings(), residuals), slow_against_fast].into_iter().flatten().collect();
    let agreement = heterogeneity(context, model, scores);
    let mut heterogeneous = agreement.as_ref().is_some_and(|test| !test.passed);
    tests.extend(agreement);
    tests.extend(residual_size(context, model));
    if is_rounding(context, model) || is_unresolved(context, model) {
        for test in &mut tests {
            test.passed = true;
        }
        heterogeneous = false;
    }
    ResidualDiagnostics { tests, heterogeneous }
}

/// Whether nothing is left but what counting in binary leaves: that has a shape of its own, and nothing is missing in it.
fn is_rounding(context: &Context<'_>, model: &Hypothesis) -> bool {
    let Ok(residuals) = context.joint(&model.structure).plain_residuals(&model.fit.point) else { return false };
    context.recordings().iter().zip(&residuals).all(|(recording, residual)| {
        let largest = recording.prepared.seen.values().iter().fold(0.0, |most: f64, value| most.max(value.abs()));
        residual.iter().all(|r| r.abs() <= ROUNDING * largest)
    })
}

/// Whether what is left of every channel is less than a step of its sensor (root mean square), where real recordings never follow the
/// simulation down to their noise: such a rest has a shape, and is no evidence of an effect.
fn is_unresolved(context: &Context<'_>, model: &Hypothesis) -> bool {
    if !context.evidence.discrepancy() {
        return false;
    }
    let Ok(residuals) = context.joint(&model.structure).plain_residuals(&model.fit.point) else { return false };
    context.recordings().iter().zip(&residuals).all(|(recording, residual)| {
        let width = recording.width();
        (0..width).all(|channel| {
            let squares = residual.iter().skip(channel).step_by(width).map(|r| r * r);
            let rmse = (squares.sum::<f64>() / (residual.len() / width).max(1) as f64).sqrt();
            is_below_step(&recording.prepared.seen, channel, rmse)
        })
    })
}

/// Whether what is left of every channel over all recordings together is less than a step of its sensor: effects are then not named for less
/// than [`RESOLVED`].
pub(in crate::diagnose) fn is_below_steps(context: &Context, model: &Hypothesis) -> bool {
    if !context.evidence.discrepancy() {
        return false;
    }
    let Ok(residuals) = context.joint(&model.structure).plain_residuals(&model.fit.point) else { return false };
    let width = context.recordings().first().map_or(0, PreparedRecording::width);
    (0..width).all(|channel| {
        let values = residuals.iter().flat_map(|residual| residual.iter().skip(channel).step_by(width).copied());
        let rmse = root_mean_square(values);
        context.recordings().iter().all(|recording| is_below_step(&recording.prepared.seen, channel, rmse))
    })
}

/// Whether the residual is no larger than the noise, by the same limit as in tuning. Of lists of events, too short for any test
/// of shape, and of driven recordings without any effect. Not of those with one: filtered logs understate their noise, and what an effect
/// leaves white is not held against it.
fn residual_size(context: &Context<'_>, model: &Hypothesis) -> Option<Test> {
    let bare = model.structure.effects.is_empty();
    let tested = |recording: &PreparedRecording| {
        recording.driven() && bare || recording.prepared.seen.kind() == Kind::EventTimes
    };
    if !context.recordings().iter().any(tested) {
        return None;
    }
    // Prewhitened residuals of a driven recording would hide how large they are.
    let weighted = if context.evidence.driven() { Some(context.weighted(model).ok()?) } else { None };
    let residuals = weighted.as_ref().unwrap_or(&model.fit.residuals);
    let share = model.structure.shared.len().div_ceil(context.recordings().len().max(1));
    let each = context.recordings().iter().zip(residuals).filter(|(recording, _)| tested(recording)).map(
        |(recording, residual)| {
            let fitted = recording.fitted_nuisances() + share;
            Adequacy::of(&recording.prepared.seen, &recording.noise, residual, (fitted, recording.prepared.discrepancy))
        },
    );
    let worst = each.filter(|a| a.tested).max_by(|a, b| (a.ratio / a.limit).total_cmp(&(b.ratio / b.limit)))?;
    Some(Test { name: "residual over noise", value: worst.ratio, threshold: worst.limit, passed: !worst.poor() })
}

/// Whether the recordings agree on the shared parameters: how far each alone would move them, weighed by how well it knows
/// them, after its nuisance parameters (a score test; χ² over the recordings).
fn heterogeneity(context: &Context<'_>, model: &Hypothesis, scores: Vec<Score>) -> Option<Test> {
    let size = model.structure.shared.len();
    let mut whole = vec![0.0; size];
    for score in &scores {
        score.indices.iter().enumerate().for_each(|(i, &index)| whole[index] += score.normal[(i, i)]);
    }
    let (mut chi, mut freedom) = (0.0, 0.0);
    for Score { indices, normal, gradient, .. } in scores {
        // In units in which all recordings together know each number to 1.
        let unit: Vec<f64> = indices.iter().map(|&p| f64::max(whole[p], f64::MIN_POSITIVE).sqrt()).collect();
        let scaled = DMatrix::from_fn(indices.len(), indices.len(), |i, j| normal[(i, j)] / (unit[i] * unit[j]));
        if indices.is_empty() || scaled.iter().any(|v| !v.is_finite()) {
            continue;
        }
        let gradient = DVector::from_fn(indices.len(), |i, _| gradient[i] / unit[i]);
        let eigen = scaled.symmetric_eigen();
        for (k, value) in eigen.eigenvalues.iter().enumerate().filter(|(_, value)| **value > 1e-6) {
            chi += eigen.eigenvectors.column(k).dot(&gradient).powi(2) / value;
            freedom += 1.0;
        }
    }
    freedom -= size as f64;
    let count = context.count() as f64;
    let variance = model.deviance(model.scale()) / (count - size as f64).max(1.0);
    if freedom < 1.0 || variance <= 0.0 {
        return None;
    }
    let chi = chi / variance;
    let passed = upper_chi_squared(chi, freedom) > PROBABLE || chi / freedom < SCATTER;
    Some(Test {
        name: "agreement between recordings",
        value: chi / freedom,
        threshold: limit(freedom, SCATTER),
        passed,
    })
}

/// The greatest χ²/ν that passes.
fn limit(freedom: f64, practical: f64) -> f64 {
    (chi_squared_quantile(1.0 - PROBABLE, freedom) / freedom).max(practical)
}

/// The kept values of one channel of one recording.
struct Series {
    /// The position of the recording.
    recording: usize,
    /// Positions among the values of the recording.
    at: Vec<usize>,
    /// Their instants, s.
    clock: Vec<f64>,
    values: Vec<f64>,
}

fn series<'a>(recordings: &'a [PreparedRecording], residuals: &'a [Vec<f64>]) -> impl Iterator<Item = Series> + 'a {
    recordings.iter().zip(residuals).enumerate().flat_map(|(index, (recording, residual))| {
        let width = recording.width();
        (0..width).filter_map(move |channel| {
            let at: Vec<usize> = (channel..residual.len()).step_by(width).filter(|&i| recording.keep[i]).collect();
            let values = at.iter().map(|&i| residual[i]).collect();
            let clock = at.iter().map(|&i| recording.clock()[i / width]).collect();
            (at.len() >= 12).then_some(Series { recording: index, at, clock, values })
        })
    })
}

/// Ljung and Box (1978) over all channels and recordings: `Q = n (n + 2) Σ r_k²/(n − k)`, summed.
fn portmanteau(recordings: &[PreparedRecording], residuals: &[Vec<f64>]) -> Option<Test> {
    let (mut total, mut freedom) = (0.0, 0.0);
    for Series { values, .. } in series(recordings, residuals) {
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

/// Mean power below [`LOW_HZ`] over that between it and [`HIGH_HZ`]: `unknowns` numbers were fitted to all recordings, and each had its own,
/// which took what lies along these directions out of either band.
fn band_power(
    recordings: &[PreparedRecording],
    residuals: &[Vec<f64>],
    (nuisances, unknowns): (&[Vec<Vec<f64>>], f64),
) -> Option<Test> {
    let (mut low, mut high, mut low_count, mut high_count) = (0.0, 0.0, 0.0, 0.0);
    for Series { recording, at, clock, values } in series(recordings, residuals) {
        let n = values.len();
        let duration = (clock[n - 1] - clock[0]) * n as f64 / (n - 1) as f64;
        let nyquist = 0.5 * n as f64 / duration;
        let edge = LOW_HZ.min(nyquist / 3.0);
        let values: Vec<f64> = values.iter().map(|v| v.clamp(-4.0, 4.0)).collect();
        let fitted = nuisances.get(recording).map_or(&[][..], Vec::as_slice);
        let fitted: Vec<Vec<f64>> = fitted.iter().map(|one| at.iter().map(|&i| one[i]).collect()).collect();
        let mut bin = 1.0;
        while bin / duration < HIGH_HZ.min(0.9 * nyquist) {
            let hertz = bin / duration;
            let wave: Vec<(f64, f64)> =
                clock.iter().map(|t| (std::f64::consts::TAU * hertz * (t - clock[0])).sin_cos()).collect();
            let power = |values: &[f64]| {
                let sine: f64 = wave.iter().zip(values).map(|((sine, _), v)| sine * v).sum();
                let cosine: f64 = wave.iter().zip(values).map(|((_, cosine), v)| cosine * v).sum();
                2.0 * (cosine * cosine + sine * sine) / n as f64
            };
            // Of white values a bin of two numbers has a power of 2, less what fitted directions took out.
            let freedom = 2.0 - fitted.iter().map(|one| power(one)).sum::<f64>();
            if hertz < edge {
                (low, low_count) = (low + power(&values), low_count + freedom);
            } else {
                (high, high_count) = (high + power(&values), high_count + freedom);
            }
            bin += 1.0;
        }
    }
    // What all recordings share is slow, nearly all.
    let (low_freedom, high_freedom) = (low_count - unknowns.min(0.6 * low_count), high_count);
    if low_freedom < LEAST_SLOW || high_freedom < LEAST_FAST || high <= 0.0 {
        return None;
    }
    let ratio = (low / low_freedom) / (high / high_freedom);
    let passed = upper_f(ratio, low_freedom, high_freedom) > PROBABLE || ratio < BAND_RATIO;
    Some(Test {
        name: "slow against fast residual",
        value: ratio,
        threshold: fisher_quantile(1.0 - PROBABLE, low_freedom, high_freedom).max(BAND_RATIO),
        passed,
    })
}

/// The lag-1 correlation above which nothing distinguishes noise from a misfit.
pub(in crate::diagnose) fn long_lag1(evidence: &Evidence) -> f64 {
    if evidence.discrepancy() { LONGEST_OF_DISCREPANCY } else { LONG_LAG1 }
}

/// Fails where the noise that was prewhitened is correlated for longer than noise is known to: nothing distinguishes it from a misfit.
pub(in crate::diagnose) fn noise_correlation(evidence: &Evidence, rho: f64) -> Option<Test> {
    let threshold = long_lag1(evidence);
    (rho > threshold).then_some(Test { name: "correlation of the noise", value: rho, threshold, passed: false })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::tests::zoo::{FRICTION, entry, in_context, in_swings, swing};
    use crate::testing::{Exact, Pendulum};

    use crate::diagnose::hypothesis::multistart::fit_without_effects;

    #[test]
    fn noise_passes_and_a_missing_effect_does_not() {
        in_swings(&[(FRICTION, 0.15)], 3, 0, |context| {
            let base = fit_without_effects(context).unwrap();
            assert!(!residual_diagnostics(context, &base).passed());
            let with = context.fit_near(&[entry(context, "viscous_friction")], &base).unwrap();
            let found = residual_diagnostics(context, &with);
            assert!(found.passed() && !found.heterogeneous, "{:?}", found.tests);
        });
    }

    /// Nothing is missing: what the fit took out of the slow band is not looked for there.
    #[test]
    fn white_noise_after_a_fit_is_as_strong_slow_as_fast() {
        in_swings(&[], 12, 0, |context| {
            let base = fit_without_effects(context).unwrap();
            let tests = residual_diagnostics(context, &base).tests;
            let found = tests.iter().find(|test| test.name == "slow against fast residual").unwrap();
            assert!((0.85..1.15).contains(&found.value), "{found:?}");
        });
    }

    #[test]
    fn another_pendulum_among_the_recordings_is_heterogeneous() {
        let seen: Vec<_> = (0..4).map(|k| swing(&[("length", if k == 3 { 0.81 } else { 0.8 })], k)).collect();
        in_context(&Exact::new(Pendulum), &seen, 0, |context| {
            let base = fit_without_effects(context).unwrap();
            assert!(residual_diagnostics(context, &base).heterogeneous);
        });
    }
}
