//! Hold-out validation (data splitting, Snee 1977): of held-out recordings only nuisance parameters are fitted, and their later
//! part is forecast.

use crate::Result;
use crate::diagnose::evidence::recording::PreparedRecording;
use crate::diagnose::evidence::rmse;
use crate::diagnose::hypothesis::context::{Context, FULL, Hypothesis};
use crate::diagnose::hypothesis::joint::{Effort, Joint, Point};

const EARLY: Effort = Effort { steps: 20, derivatives: 6, ends_measured: false, tolerance: 0.5, horizon: 0.45 };
/// The share of a recording from which the rest is forecast.
const KNOWN: f64 = 0.4;

/// How far a model lies from recordings that it never saw, in the channels' unit.
#[derive(Debug, Clone)]
pub(in crate::diagnose) struct HeldOut {
    /// Root mean square with their start states fitted.
    pub rmse: f64,
    /// Root mean square of the later part, forecast from the first [`KNOWN`].
    pub forecast: f64,
    /// Weighted residuals, shape `[recording][sample · channel]`.
    pub residuals: Vec<Vec<f64>>,
    /// Their nuisance parameters.
    pub nuisances: Vec<Vec<f64>>,
}

/// Judges `model` by the recordings that are held out; `None` where there are none.
pub(in crate::diagnose) fn validate(context: &Context, model: &Hypothesis) -> Result<Option<HeldOut>> {
    let recordings = &context.evidence.validation[..];
    if recordings.is_empty() {
        return Ok(None);
    }
    let structure = context.structure(&model.structure.effects)?.frozen(&model.fit.point.parameters);
    let joint = Joint { structure: &structure, recordings, separable: false, rollouts: &context.rollouts };
    let start =
        Point { parameters: Vec::new(), nuisances: recordings.iter().map(|r| r.prepared.nuisance_values()).collect() };
    let early = joint.fit(start, EARLY)?.point;
    let whole = joint.fit(early, FULL)?.point;
    let plain = joint.plain_residuals(&whole)?;
    let each = recordings.iter().zip(&whole.nuisances);
    let centred: Vec<PreparedRecording> = each.map(|(recording, found)| centred(recording, found)).collect();
    let ahead = Joint { recordings: &centred, ..joint };
    let known = ahead.fit(whole.clone(), Effort { horizon: KNOWN, ..FULL })?.point;
    let ahead = ahead.plain_residuals(&known)?;
    let mut residuals = plain.clone();
    for (recording, values) in recordings.iter().zip(&mut residuals) {
        let width = recording.width();
        for (i, value) in values.iter_mut().enumerate() {
            *value = if recording.keep[i] { *value / recording.noise[i % width] } else { 0.0 };
        }
    }
    let (rmse, forecast) = (rmse(recordings, &plain, 0.0), rmse(recordings, &ahead, KNOWN));
    Ok(Some(HeldOut { rmse, forecast, residuals, nuisances: whole.nuisances }))
}

/// A recording whose priors are centred on what was `found`: what its first part does not show, as the height of a surface before
/// the first event, is no forecast of the model. Draws of random effects are, and keep their own priors.
fn centred(recording: &PreparedRecording, found: &[f64]) -> PreparedRecording {
    let mut centred = recording.clone();
    let random = recording.random_draws + usize::from(recording.random_parameter.is_some());
    let stated = centred.prepared.nuisances.len().saturating_sub(random);
    for (nuisance, found) in centred.prepared.nuisances[..stated].iter_mut().zip(found) {
        nuisance.value = *found;
    }
    centred
}

#[cfg(test)]
mod tests {
    use super::{PreparedRecording, centred, validate};
    use crate::diagnose::tests::zoo::{FRICTION, NOISE_RAD, entry, in_swings};

    use crate::diagnose::hypothesis::multistart::fit_without_effects;

    #[test]
    fn the_true_effect_predicts_what_was_not_fitted_down_to_noise() {
        in_swings(&[(FRICTION, 0.15)], 4, 1, |context| {
            let base = fit_without_effects(context).unwrap();
            let with = context.fit_near(&[entry(context, "viscous_friction")], &base).unwrap();
            let reach = |model| validate(context, model).unwrap().unwrap();
            let (before, after) = (reach(&base), reach(&with));
            assert!(after.rmse < 1.2 * NOISE_RAD && before.rmse > 2.0 * after.rmse, "{before:?} {after:?}");
            assert!(after.forecast < before.forecast);
        });
        in_swings(&[], 2, 0, |context| {
            let base = fit_without_effects(context).unwrap();
            assert!(validate(context, &base).unwrap().is_none());
        });
    }
    #[test]
    fn priors_are_centred_on_what_was_found_but_those_of_random_effects() {
        in_swings(&[], 2, 1, |context| {
            let recording = &context.evidence.validation[0];
            let found: Vec<f64> = recording.prepared.nuisance_values().iter().map(|value| value + 0.25).collect();
            assert_eq!(centred(recording, &found).prepared.nuisance_values(), found);
            let drawn =
                centred(&PreparedRecording { random_draws: 1, ..recording.clone() }, &found).prepared.nuisance_values();
            assert_eq!(drawn.last(), recording.prepared.nuisance_values().last());
            assert_eq!(drawn[..drawn.len() - 1], found[..found.len() - 1]);
        });
    }
}
