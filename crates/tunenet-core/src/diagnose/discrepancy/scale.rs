//! Discrepancy treated as noise: one scale for all recordings, and an effective sample size by the lag-1 correlation (Bartlett 1946).

use crate::Result;
use crate::diagnose::evidence::recording::PreparedRecording;
use crate::diagnose::evidence::{Evidence, NoiseModel};
use crate::diagnose::hypothesis::context::{Context, FULL, Hypothesis};
use crate::diagnose::hypothesis::joint::{Effort, spread};
use crate::statistics::{mad_sd, root_mean_square};

/// A base that leaves this many times the noise does not come near it by any one effect: blind sets whose effect is 30 times the
/// noise leave 20 once the base is tuned, and real joints more than 100.
const FAR: f64 = 25.0;
/// The same of several channels: each of them lacks something of its own, and one setup names no effect alone in any case. A real arm of five
/// joints leaves 13 times the noise, and effects by that noise take four times the rollouts of the gated search to leave 12.
const FAR_IN_SEVERAL: f64 = 5.0;
/// A fit to the end. Values count little, so that a cost of 1 is worth a tenth in the information criterion at most.
pub(super) const FINISH: Effort =
    Effort { steps: 15, derivatives: 6, ends_measured: true, tolerance: 1.0, horizon: 1.0, ..FULL };
/// A fit that shows which local minimum a start leads to.
pub(super) const BRIEF: Effort =
    Effort { steps: 8, derivatives: 3, ends_measured: false, tolerance: 4.0, horizon: 1.0, ..FULL };

/// A discrepancy is no normal noise: a few parts of a motion leave much more than the rest. Beyond 1.345 scales, where Huber's estimate keeps
/// 95 % of its efficiency for normal residuals, they count by their absolute value.
pub(super) const LOSS: f64 = 1.345 / 4.0;

/// However strongly values are correlated, a channel of a recording is worth so many independent ones ...
const FEWEST: f64 = 10.0;
/// ... and one for each such time, s: what a joint does about its commands decays faster.
const INDEPENDENT_S: f64 = 0.6;

/// Whether what `base` leaves is far above the noise of the recordings.
pub(in crate::diagnose) fn is_far_above_noise(context: &Context, base: &Hypothesis) -> bool {
    let far = if context.evidence.is_one_setup_of_several_channels() { FAR_IN_SEVERAL } else { FAR };
    spread(&base.fit.residuals) > far
}

/// The evidence with what `model` leaves treated as noise: of each channel the same in all recordings, by its median absolute deviation.
pub(super) fn with_discrepancy(context: &Context, model: &Hypothesis) -> Result<Evidence> {
    let plain = context.joint(&model.structure).plain_residuals(&model.fit.point)?;
    let mut evidence = Evidence::clone(&context.evidence);
    let channels = evidence.training.first().map_or(0, PreparedRecording::width);
    let kept = |recording: &PreparedRecording, values: &[f64], channel: usize| -> Vec<f64> {
        let counted = (channel..values.len()).step_by(recording.width()).filter(|&i| recording.keep[i]);
        counted.map(|i| values[i]).collect()
    };
    let (mut product, mut square) = (0.0, 0.0);
    for channel in 0..channels {
        let all: Vec<Vec<f64>> =
            evidence.training.iter().zip(&plain).map(|(recording, values)| kept(recording, values, channel)).collect();
        let size = mad_sd(all.iter().flatten().copied());
        for values in &all {
            let limited: Vec<f64> = values.iter().map(|v| v.clamp(-4.0 * size, 4.0 * size)).collect();
            product += limited.windows(2).map(|w| w[0] * w[1]).sum::<f64>() / (size * size).max(f64::MIN_POSITIVE);
            square += limited.iter().map(|v| v * v).sum::<f64>() / (size * size).max(f64::MIN_POSITIVE);
        }
        for recording in evidence.training.iter_mut().chain(&mut evidence.validation) {
            recording.noise[channel] = recording.measured_noise[channel].max(size);
            recording.loss_scale = LOSS;
        }
    }
    let rho = if square > 0.0 { (product / square).clamp(0.0, 1.0) } else { 0.0 };
    let worth = |recording: &PreparedRecording| {
        let clock = recording.clock();
        FEWEST.max((clock[clock.len() - 1] - clock[0]) / INDEPENDENT_S) * channels as f64
    };
    let least = evidence.training.iter().map(worth).sum::<f64>() / evidence.count().max(1) as f64;
    let effective_fraction = ((1.0 - rho) / (1.0 + rho)).max(least.min(1.0));
    Ok(Evidence { noise: NoiseModel::Inflated { effective_fraction }, ..evidence.prewhitened(0.0) })
}

/// The root mean square of what `model` leaves of the recordings that are fitted, in units of their measured noise, where `context` has the
/// discrepancy as noise.
pub(super) fn left_of_noise(context: &Context, model: &Hypothesis) -> f64 {
    let each = |(recording, residuals): (&PreparedRecording, &Vec<f64>)| -> Vec<f64> {
        let ratio = |i: usize| recording.noise[i % recording.width()] / recording.measured_noise[i % recording.width()];
        let counted = (0..residuals.len()).filter(|&i| recording.keep[i]);
        counted.map(|i| residuals[i] * ratio(i)).collect()
    };
    root_mean_square(context.recordings().iter().zip(&model.fit.residuals).flat_map(each))
}

/// The context in which what `model` leaves is the noise, and the model fitted there from its own values.
pub(super) fn rescaled<'a>(context: &Context<'a>, model: &Hypothesis<'a>) -> Result<(Context<'a>, Hypothesis<'a>)> {
    let context = context.with_evidence(with_discrepancy(context, model)?);
    let model = context.fit_near_with(&model.structure.effects, model, FINISH)?;
    Ok((context, model))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::hypothesis::multistart::fit_without_effects;
    use crate::diagnose::tests::zoo::{FRICTION, in_swings};

    #[test]
    fn all_recordings_get_the_scale_of_what_is_left_of_them_together() {
        in_swings(&[(FRICTION, 0.15)], 3, 1, |context| {
            let base = fit_without_effects(context).unwrap();
            let evidence = with_discrepancy(context, &base).unwrap();
            let NoiseModel::Inflated { effective_fraction } = evidence.noise else { panic!("{:?}", evidence.noise) };
            let sizes: Vec<f64> =
                evidence.training.iter().chain(&evidence.validation).map(|recording| recording.noise[0]).collect();
            assert!(sizes.iter().all(|size| *size == sizes[0]), "{sizes:?}");
            assert!(effective_fraction < 0.3 && effective_fraction * evidence.count() as f64 >= 20.0 - 1e-9);
            assert!(!is_far_above_noise(context, &base));
        });
    }

    /// Also where the discrepancy is what residuals are measured by.
    #[test]
    fn what_is_left_is_in_units_of_the_measured_noise() {
        in_swings(&[(FRICTION, 0.15)], 3, 1, |context| {
            let (scaled, model) = rescaled(context, &fit_without_effects(context).unwrap()).unwrap();
            let plain = scaled.joint(&model.structure).plain_residuals(&model.fit.point).unwrap();
            let each = scaled.recordings().iter().zip(&plain);
            let measured = each.flat_map(|(one, values)| values.iter().map(|v| v / one.measured_noise[0]));
            let expected = root_mean_square(measured);
            let left = left_of_noise(&scaled, &model);
            assert!(expected > 3.0 && (left / expected - 1.0).abs() < 1e-9, "{left} {expected}");
        });
    }
}
