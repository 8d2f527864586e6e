//! Held-out proof: of validation recordings only the start is fitted, and their later part is forecast.

use crate::Result;
use crate::diagnose::evidence::recording::Set;
use crate::diagnose::hypothesis::context::{Context, FULL, Hypothesis};
use crate::diagnose::joint::{Effort, Joint, Point};
use crate::observation::FEWEST_SAMPLES;
use crate::simulator::Prepared;

const EARLY: Effort = Effort { steps: 6, tolerance: 0.5, horizon: 0.45 };
/// The share of a recording from which the rest is forecast.
const KNOWN: f64 = 0.4;
/// The share of a driven recording that is fitted where none is held out.
const FITTED: f64 = 2.0 / 3.0;
/// Of so many recordings of one object one may be set aside.
const ONE_OF: usize = 4;

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
    let sets = &context.evidence.validation[..];
    if sets.is_empty() {
        return Ok(None);
    }
    let structure = context.structure(&model.structure.effects)?.frozen(&model.fit.point.parameters);
    let joint = Joint { structure: &structure, sets, rollouts: &context.rollouts };
    let start =
        Point { parameters: Vec::new(), nuisances: sets.iter().map(|s| s.prepared.nuisance_values()).collect() };
    let early = joint.fit(start, EARLY)?.point;
    let whole = joint.fit(early.clone(), FULL)?.point;
    let plain = joint.plain_residuals(&whole)?;
    let known = joint.fit(early, Effort { horizon: KNOWN, ..FULL })?.point;
    let ahead = joint.plain_residuals(&known)?;
    let mut residuals = plain.clone();
    for (set, values) in sets.iter().zip(&mut residuals) {
        let width = set.width();
        values.iter_mut().enumerate().for_each(|(i, v)| *v = if set.keep[i] { *v / set.noise[i % width] } else { 0.0 });
    }
    let (rmse, forecast) = (rmse(sets, &plain, 0.0), rmse(sets, &ahead, KNOWN));
    Ok(Some(HeldOut { rmse, forecast, residuals, nuisances: whole.nuisances }))
}

/// Root mean square of plain residuals from the share `from` of each recording on, a sample of several channels counted
/// once; what is set aside does not count.
pub(in crate::diagnose) fn rmse(sets: &[Set], plain: &[Vec<f64>], from: f64) -> f64 {
    let (mut squares, mut samples) = (0.0, 0.0);
    for (set, values) in sets.iter().zip(plain) {
        let begin = from * values.len() as f64;
        let kept = values.iter().enumerate().filter(|(i, _)| set.keep[*i] && *i as f64 >= begin);
        let (sum, count) = kept.fold((0.0, 0.0), |(sum, count), (_, v)| (sum + v * v, count + 1.0));
        squares += sum;
        samples += count / set.width() as f64;
    }
    if samples > 0.0 { (squares / samples).sqrt() } else { 0.0 }
}

/// Cuts the last third off a recording and returns it, held out; `None` where it is too short for that.
///
/// # Errors
/// Never where the recording is sound.
pub(in crate::diagnose) fn hold_end_out(set: &mut Set) -> Result<Option<Set>> {
    let count = set.prepared.seen.len();
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a share of a length")]
    let cut = (count as f64 * FITTED) as usize;
    if cut < FEWEST_SAMPLES || count - cut < FEWEST_SAMPLES {
        return Ok(None);
    }
    let part = |range, held_out| -> Result<Set> {
        let prepared = Prepared { seen: set.prepared.seen.slice(range)?, ..set.prepared.clone() };
        Ok(Set::new(set.recording, set.object, held_out, prepared))
    };
    let end = part(cut..count, true)?;
    *set = part(0..cut, false)?;
    Ok(Some(end))
}

/// Which recordings to set aside where none is given: of each object with enough of them every fourth, beginning where the
/// seed says. `objects` are the objects of the usable recordings.
pub(in crate::diagnose) fn set_aside(objects: &[usize], seed: u64) -> Vec<usize> {
    let mut chosen = Vec::new();
    let most = objects.iter().copied().max().map_or(0, |m| m + 1);
    for object in 0..most {
        let mine: Vec<usize> = (0..objects.len()).filter(|&i| objects[i] == object).collect();
        let count = mine.len() / ONE_OF;
        let offset = usize::try_from(seed % ONE_OF as u64).unwrap_or(0);
        chosen.extend((0..count).map(|k| mine[k * ONE_OF + offset]));
    }
    chosen
}

#[cfg(test)]
mod tests {
    use super::{set_aside, validate};
    use crate::diagnose::tests::zoo::{FRICTION, NOISE_RAD, entry, in_levers, in_swings};
    use crate::testing::Levers;

    #[test]
    fn of_a_driven_recording_the_last_third_is_held_out() {
        in_levers(&Levers::new().unwrap(), &[], |context| {
            let (fitted, held_out) = (context.sets()[0].clock(), context.evidence.validation[0].clock());
            assert_eq!((fitted.len(), held_out.len()), (400, 200));
            assert!(fitted[399] < held_out[0] && !context.evidence.shows_one_motion());
        });
    }

    #[test]
    fn one_in_four_of_each_object_is_set_aside() {
        assert!(set_aside(&[0, 0, 0], 0).is_empty());
        assert_eq!(set_aside(&[0, 0, 0, 0, 1, 1], 2), [2]);
        assert_eq!(set_aside(&[0, 1, 0, 1, 0, 1, 0, 1], 1), [2, 3]);
    }

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
}
