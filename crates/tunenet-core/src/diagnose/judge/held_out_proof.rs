//! Hold-out validation (data splitting, Snee 1977): of held-out recordings only nuisance parameters are fitted, and their later
//! part is forecast.

use std::sync::Arc;

use crate::Result;
use crate::diagnose::evidence::recording::PreparedRecording;
use crate::diagnose::evidence::rmse;
use crate::diagnose::hypothesis::context::{COMPARED, Context, FULL, Hypothesis};
use crate::diagnose::hypothesis::joint::{Effort, Joint, Known, Outcome, Point, spread};
use crate::estimate::GROWING_SHARES;
use crate::estimate::jacobian::Columns;
use crate::estimate::problem::leading_samples;

const EARLY: Effort = Effort { steps: 20, derivatives: 6, ends_measured: false, tolerance: 0.5, horizon: 0.45, ..FULL };
/// The initial state of a held-out recording that leaves more than so many times what fitted ones do is fitted over growing shares of it.
const MUCH: f64 = 3.0;
/// One that was found from where another model put it, and leaves more than so many times that, is looked for again from its first guess.
const ASTRAY: f64 = 1.25;
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
    /// What is left of each in units of the noise, whitened, shape `[recording]`.
    pub left: Vec<f64>,
    /// Their nuisance parameters.
    pub nuisances: Vec<Vec<f64>>,
    /// Derivatives of the white residuals by these, of a point not far away.
    pub columns: Arc<[Columns]>,
}

/// Judges `model` by the recordings that are held out; `None` where there are none.
pub(in crate::diagnose) fn validate(context: &Context, model: &Hypothesis) -> Result<Option<HeldOut>> {
    judged(context, model, None)
}

/// The same by fewer rollouts, where another model was judged in the same context: from `near`, where that put the nuisance parameters.
pub(in crate::diagnose) fn validate_near(
    context: &Context,
    model: &Hypothesis,
    near: &HeldOut,
) -> Result<Option<HeldOut>> {
    judged(context, model, Some(near))
}

fn judged(context: &Context, model: &Hypothesis, near: Option<&HeldOut>) -> Result<Option<HeldOut>> {
    let recordings = &context.evidence.validation[..];
    if recordings.is_empty() {
        return Ok(None);
    }
    let structure = context.structure(&model.structure.effects)?.frozen(&model.fit.point.parameters);
    let joint = Joint { structure: &structure, recordings, separable: false, rollouts: &context.rollouts };
    let leaves = spread(&model.fit.residuals).max(1.0);
    let left = |outcome: &Outcome| -> Vec<f64> {
        outcome.residuals.iter().map(|one| spread(std::slice::from_ref(one))).collect()
    };
    let guess =
        Point { parameters: Vec::new(), nuisances: recordings.iter().map(|r| r.prepared.nuisance_values()).collect() };
    let close = match near {
        Some(near) if !context.evidence.driven() => from_near(&joint, near),
        _ => None,
    };
    let is_astray = |whole: &Outcome| {
        // What leaves much of the recordings that were fitted may leave as much of these as the other model does.
        let limit = |i: usize| near.filter(|_| leaves > MUCH).map_or(leaves, |near| leaves.max(near.left[i]));
        left(whole).iter().enumerate().any(|(i, left)| *left > ASTRAY * limit(i))
    };
    // The other model's were found from the first samples on, where that was necessary.
    let (whole, columns) = if let Some(close) = close.filter(|(whole, _)| !is_astray(whole)) {
        close
    } else {
        let (whole, columns) = fitted(&joint, joint.fit(guess.clone(), EARLY)?.point, None)?;
        let lost = !context.evidence.driven() && left(&whole).iter().any(|left| *left > MUCH * leaves);
        (if lost { grown(&joint, guess, whole) } else { whole }, columns)
    };
    let (left, whole) = (left(&whole), whole.point);
    let plain = joint.plain_residuals(&whole)?;
    let each = recordings.iter().zip(&whole.nuisances);
    let centred: Vec<PreparedRecording> = each.map(|(recording, found)| centred(recording, found)).collect();
    let ahead = Joint { recordings: &centred, ..joint };
    let known = known_part(&ahead, &whole, &columns)?;
    let ahead = ahead.plain_residuals(&known)?;
    let mut residuals = plain.clone();
    for (recording, values) in recordings.iter().zip(&mut residuals) {
        let width = recording.width();
        for (i, value) in values.iter_mut().enumerate() {
            *value = if recording.keep[i] { *value / recording.noise[i % width] } else { 0.0 };
        }
    }
    let (rmse, forecast) = (rmse(recordings, &plain, 0.0), rmse(recordings, &ahead, KNOWN));
    Ok(Some(HeldOut { rmse, forecast, residuals, left, nuisances: whole.nuisances, columns: columns.into() }))
}

/// The fit from `start`, with derivatives of a point not far from where it ends.
fn fitted(joint: &Joint, start: Point, known: Option<Known>) -> Result<(Outcome, Vec<Columns>)> {
    let residuals = joint.residuals(&start, 1.0)?;
    let (outcome, columns) = joint.fit_keeping(start, residuals, COMPARED, known)?;
    Ok((outcome, columns.unwrap_or_default()))
}

/// The fit from where another model put the same nuisance parameters; `None` where it has others, or the simulator refuses.
fn from_near(joint: &Joint, near: &HeldOut) -> Option<(Outcome, Vec<Columns>)> {
    let counts = |nuisances: &[Vec<f64>]| nuisances.iter().map(Vec::len).collect::<Vec<_>>();
    let own: Vec<usize> = joint.recordings.iter().map(|recording| recording.prepared.nuisances.len()).collect();
    if near.columns.len() != own.len() || counts(&near.nuisances) != own {
        return None;
    }
    let start = Point { parameters: Vec::new(), nuisances: near.nuisances.clone() };
    fitted(joint, start, Some(Known::nearby(&near.columns))).ok()
}

/// The nuisance parameters by the first [`KNOWN`] of the recordings, from those of the `whole`, where derivatives are near to `columns`.
fn known_part(joint: &Joint, whole: &Point, columns: &[Columns]) -> Result<Point> {
    let effort = Effort { horizon: KNOWN, ..COMPARED };
    let residuals = joint.residuals(whole, KNOWN)?;
    let values = |recording: &PreparedRecording| leading_samples(recording.clock().len(), KNOWN) * recording.width();
    let leading: Vec<Columns> = joint.recordings.iter().zip(columns).map(|(r, c)| c.leading(values(r))).collect();
    let known = (leading.len() == joint.recordings.len()).then(|| Known::nearby(&leading));
    Ok(joint.fit_from(whole.clone(), residuals, effort, known)?.point)
}

/// The fit whose initial states are found from the first samples on, where that leaves less of a recording than `direct` does.
fn grown(joint: &Joint, start: Point, direct: Outcome) -> Outcome {
    let longer =
        |point: Point, horizon: &f64| Some(joint.fit(point, Effort { horizon: *horizon, ..EARLY }).ok()?.point);
    let Some(found) = GROWING_SHARES.iter().try_fold(start, longer).and_then(|point| joint.fit(point, COMPARED).ok())
    else {
        return direct;
    };
    let squares = |residuals: &[f64]| residuals.iter().map(|r| r * r).sum::<f64>();
    let mut best = direct;
    for (i, residuals) in found.residuals.iter().enumerate() {
        if squares(residuals) < squares(&best.residuals[i]) {
            best.residuals[i].clone_from(residuals);
            best.point.nuisances[i].clone_from(&found.point.nuisances[i]);
        }
    }
    best
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
    centred.prepared.begin.clear();
    centred
}

#[cfg(test)]
mod tests {
    use super::{HeldOut, Joint, Point, PreparedRecording, centred, grown, spread, validate, validate_near};
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

    /// From where another model put the initial states, the same is found by fewer rollouts; also where that is far off.
    #[test]
    fn another_models_initial_states_lead_to_the_same_answer() {
        in_swings(&[(FRICTION, 0.15)], 4, 1, |context| {
            let base = fit_without_effects(context).unwrap();
            let with = context.fit_near(&[entry(context, "viscous_friction")], &base).unwrap();
            let before = validate(context, &base).unwrap().unwrap();
            let counted = |judge: &dyn Fn() -> HeldOut| {
                let count = context.rollouts.count();
                let found = judge();
                (found, context.rollouts.count() - count)
            };
            let (direct, all) = counted(&|| validate(context, &with).unwrap().unwrap());
            let (near, fewer) = counted(&|| validate_near(context, &with, &before).unwrap().unwrap());
            let same = |found: &HeldOut| {
                (found.rmse / direct.rmse - 1.0).abs() < 1e-3 && (found.forecast / direct.forecast - 1.0).abs() < 1e-2
            };
            assert!(same(&near) && fewer < all, "{} {}: {fewer} of {all}", near.rmse, direct.rmse);
            let mut far = before.clone();
            far.nuisances[0].iter_mut().for_each(|value| *value += 0.5);
            assert!(same(&validate_near(context, &with, &far).unwrap().unwrap()));
            far.nuisances[0].pop();
            assert!(same(&validate_near(context, &with, &far).unwrap().unwrap()), "of other nuisance parameters");
        });
    }

    /// A swing fitted from a start far off, and then from its first samples on; a fit that is better already stays.
    #[test]
    fn a_start_that_leads_astray_is_found_from_the_first_samples_on() {
        in_swings(&[], 2, 1, |context| {
            let base = fit_without_effects(context).unwrap();
            let structure = context.structure(&[]).unwrap().frozen(&base.fit.point.parameters);
            let recordings = &context.evidence.validation[..];
            let joint = Joint { structure: &structure, recordings, separable: false, rollouts: &context.rollouts };
            let guess = recordings.iter().map(|r| r.prepared.nuisance_values()).collect();
            let start = Point { parameters: Vec::new(), nuisances: guess };
            let mut off = start.clone();
            off.nuisances[0].iter_mut().for_each(|value| *value += 0.5);
            let astray = joint.evaluate(off).unwrap();
            let found = grown(&joint, start.clone(), astray.clone());
            assert!(spread(&astray.residuals) > 10.0 && spread(&found.residuals) < 1.5);
            let kept = grown(&joint, start, found.clone());
            assert!(spread(&kept.residuals) <= spread(&found.residuals));
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
