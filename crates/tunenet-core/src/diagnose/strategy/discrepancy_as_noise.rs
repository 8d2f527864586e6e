//! Model discrepancy as noise (variance inflation): with enough real data every statistical test fails, so what is left is
//! taken for autocorrelated noise, and what then still stands out has to take most of the gap away.

use super::{Attempt, Refinement};
use crate::Result;
use crate::diagnose::evidence::recording::PreparedRecording;
use crate::diagnose::evidence::{Evidence, NoiseModel};
use crate::diagnose::hypothesis::context::{COMPARED, Context, Hypothesis};
use crate::diagnose::hypothesis::forward_selection::{Selection, known_base, search, search_near};
use crate::diagnose::hypothesis::plausibility::is_required;
use crate::diagnose::judge::adequacy::is_adequate;
use crate::diagnose::judge::held_out_proof::{HeldOut, validate, validate_near};
use crate::diagnose::judge::negative_control::negative_control;
use crate::diagnose::judge::practical_significance::{
    CONFIRMED, CONTROL, largest_left_share, leaves_too_much, left_over_taken_away, noise_floor, practical_tests,
};
use crate::diagnose::{Progress, Test};

/// Correlations above this would leave next to no independent value.
const GREATEST: f64 = 0.97;
/// If effects miss a limit by more than this factor, fewer effects do not meet it either.
const NEARLY: f64 = 1.25;

pub(super) struct DiscrepancyAsNoise;

impl Refinement for DiscrepancyAsNoise {
    fn applies(&self, attempt: &Attempt) -> bool {
        attempt.may_inflate_noise()
    }

    fn attempt<'a>(&self, attempt: Attempt<'a>, progress: &dyn Fn(Progress)) -> Result<Attempt<'a>> {
        if leaves_too_much(&attempt.context, &attempt.found, attempt.floor)? {
            return Ok(attempt);
        }
        let second = with_inflated_noise(&attempt.context, &attempt.found, attempt.floor, progress)?;
        Ok(if second.passes() { attempt.replaced(second) } else { attempt })
    }
}

impl<'a> Attempt<'a> {
    /// The same recordings explained with inflated noise.
    pub(super) fn replaced(self, second: Second<'a>) -> Self {
        let Second { context, found, before, tests } = second;
        Self { context, found, before, practical: Some(tests), ..self }
    }
}

/// A search with what an earlier one leaves taken for noise.
pub(in crate::diagnose) struct Second<'a> {
    /// Under which it was made.
    pub context: Context<'a>,
    pub found: Selection<'a>,
    pub before: Option<HeldOut>,
    pub tests: Vec<Test>,
}

impl Second<'_> {
    /// Whether it finds effects that pass every test.
    pub fn passes(&self) -> bool {
        self.found.best.is_some() && self.tests.iter().all(|t| t.passed)
    }
}

/// Searches again with what `first` leaves taken for noise, and tests what that finds; `floor` is the noise of the recordings
/// as a mean square.
pub(in crate::diagnose) fn with_inflated_noise<'a>(
    context: &Context<'a>,
    first: &Selection<'a>,
    floor: f64,
    progress: &dyn Fn(Progress),
) -> Result<Second<'a>> {
    let held_out_floor = noise_floor(&context.evidence.validation);
    let context =
        context.with_evidence(with_discrepancy_as_noise(context, first.best.as_ref().unwrap_or(&first.base))?);
    let base = context.fit_near_with(&[], &first.base, COMPARED)?;
    let searched = first;
    let refitted = |best: &Hypothesis| context.fit_near_with(&best.structure.effects, best, COMPARED);
    let first = first.best.as_ref().map(refitted).transpose()?;
    if let Some(best) = &first
        && context.shows_free_motions()
        && left_over_taken_away(&context, (&base, best), floor)? > NEARLY * largest_left_share(&context)
    {
        return Ok(Second { context, found: Selection::tuned(base), before: None, tests: Vec::new() });
    }
    let before = validate(&context, &base)?;
    if let (Some(best), Some(before)) = (&first, &before)
        && context.shows_free_motions()
        && is_refuted(&context, best, before)?
    {
        return Ok(Second { context, found: Selection::tuned(base), before: None, tests: Vec::new() });
    }
    let near = match &first {
        Some(best) => known_base(&context, &base, &searched.base, best)?,
        None => base.again(&context)?,
    };
    let fitted = if context.shows_free_motions() { searched.alone.as_slice() } else { &[] };
    let mut found = search_near(&context, near, fitted, is_adequate, progress)?.over(&context, base);
    let after = reached(&context, &found, before.as_ref())?;
    if let (Some(before), Some(after)) = (&before, &after) {
        admit_equals(&context, &mut found, before, after.rmse)?;
    }
    tested(context, found, (before, after), (floor, held_out_floor))
}

/// The effects that were found in a sample, fitted to all recordings with what they leave taken for noise, and tested.
pub(super) fn kept_with_inflated_noise<'a>(
    context: &Context<'a>,
    found: Selection<'a>,
    floor: f64,
) -> Result<Second<'a>> {
    let held_out_floor = noise_floor(&context.evidence.validation);
    let last = found.best.as_ref().unwrap_or(&found.base);
    let context = context.with_evidence(with_discrepancy_as_noise(context, last)?);
    let refitted = |model: &Hypothesis| context.fit_near(&model.structure.effects, model);
    let (base, best) = (refitted(&found.base)?, found.best.as_ref().map(refitted).transpose()?);
    let found = Selection { base, best, ..found };
    let before = validate(&context, &found.base)?;
    let after = reached(&context, &found, before.as_ref())?;
    tested(context, found, (before, after), (floor, held_out_floor))
}

/// What the effects found reach on held-out recordings.
fn reached(context: &Context, found: &Selection, before: Option<&HeldOut>) -> Result<Option<HeldOut>> {
    match (&found.best, before) {
        (Some(best), Some(before)) => validate_near(context, best, before),
        _ => Ok(None),
    }
}

/// The tests of what was found; `before` and `after` are held-out recordings without the effects and with them.
fn tested<'a>(
    context: Context<'a>,
    found: Selection<'a>,
    (before, after): (Option<HeldOut>, Option<HeldOut>),
    (floor, held_out_floor): (f64, f64),
) -> Result<Second<'a>> {
    let control = negative_control(&context, &found, before.as_ref())?.map(|c| c.1);
    let tests =
        practical_tests(&context, &found, (floor, held_out_floor), before.as_ref().zip(after.as_ref()), control)?;
    Ok(Second { context, found, before, tests })
}

/// Whether held-out recordings refute effects that were found with less noise by so much that fewer of them do not pass either.
fn is_refuted(context: &Context, best: &Hypothesis, before: &HeldOut) -> Result<bool> {
    let certain = best.structure.effects.iter().any(|&entry| is_required(context, entry));
    let after = if certain { None } else { validate_near(context, best, before)? };
    Ok(after.is_some_and(|after| after.rmse > NEARLY * CONFIRMED * before.rmse))
}

/// The evidence with what `model` leaves treated as noise.
fn with_discrepancy_as_noise(context: &Context, model: &Hypothesis) -> Result<Evidence> {
    let plain = context.joint(&model.structure).plain_residuals(&model.fit.point)?;
    let mut evidence = Evidence::clone(&context.evidence);
    let (mut product, mut square) = (0.0, 0.0);
    let channels = evidence.training.first().map_or(0, PreparedRecording::width);
    let mut pooled = vec![(0.0, 0.0); channels];
    for (recording, values) in evidence.training.iter_mut().zip(&plain) {
        let width = recording.width();
        for (channel, pooled) in pooled.iter_mut().enumerate().take(width) {
            let kept: Vec<f64> =
                (channel..values.len()).step_by(width).filter(|&i| recording.keep[i]).map(|i| values[i]).collect();
            let sum: f64 = kept.iter().map(|v| v * v).sum();
            if kept.is_empty() || sum <= 0.0 {
                continue;
            }
            let spread = (sum / kept.len() as f64).sqrt();
            pooled.0 += sum;
            pooled.1 += kept.len() as f64;
            square += sum / (spread * spread);
            product += kept.windows(2).map(|w| w[0] * w[1]).sum::<f64>() / (spread * spread);
            recording.noise[channel] = recording.noise[channel].max(spread);
        }
    }
    for recording in &mut evidence.validation {
        for (noise, (sum, count)) in recording.noise.iter_mut().zip(&pooled) {
            if *count > 0.0 {
                *noise = noise.max((sum / count).sqrt());
            }
        }
    }
    let rho = if square > 0.0 { (product / square).clamp(0.0, GREATEST) } else { 0.0 };
    // What a mean of correlated values is worth in independent ones.
    let effective_fraction = (1.0 - rho) / (1.0 + rho);
    Ok(Evidence { noise: NoiseModel::Inflated { effective_fraction }, ..evidence.prewhitened(0.0) })
}

/// The search again with what `found` leaves taken for noise, and the context of it.
pub(in crate::diagnose) fn search_inflated<'a>(
    context: &Context<'a>,
    found: &Selection<'a>,
    progress: &dyn Fn(Progress),
) -> Result<(Context<'a>, Selection<'a>)> {
    let best = found.best.as_ref().unwrap_or(&found.base);
    let context = context.with_evidence(with_discrepancy_as_noise(context, best)?);
    let base = context.fit_near(&[], &found.base)?;
    let found = search(&context, base, is_adequate, progress)?;
    Ok((context, found))
}

/// Where a single effect was found: counts every other that does as well on recordings that were not fitted among what
/// could be in its place.
fn admit_equals(context: &Context, found: &mut Selection, before: &HeldOut, after: f64) -> Result<()> {
    let [selected] = found.selected.as_mut_slice() else { return Ok(()) };
    for candidate in found.alone.iter().filter(|c| c.entry != selected.entry && c.excluded.is_none()) {
        let Some(model) = &candidate.model else { continue };
        let Some(reached) = validate_near(context, model, before)? else { continue };
        if reached.rmse <= CONFIRMED * before.rmse && reached.rmse < CONTROL * after {
            selected.equals.push(candidate.entry);
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::tests::zoo::{FRICTION, in_swings, names};

    use crate::diagnose::hypothesis::multistart::fit_without_effects;

    /// What the fit leaves has three times the noise and hardly an independent value.
    #[test]
    fn noise_is_inflated_to_the_residual_of_the_hypothesis() {
        in_swings(&[(FRICTION, 0.05)], 3, 1, |context| {
            let base = fit_without_effects(context).unwrap();
            let inflated = with_discrepancy_as_noise(context, &base).unwrap();
            let NoiseModel::Inflated { effective_fraction } = inflated.noise else { panic!("{:?}", inflated.noise) };
            assert!(effective_fraction < 0.5, "{effective_fraction}");
            let wider = |a: &[PreparedRecording], b: &[PreparedRecording]| {
                a.iter().zip(b).all(|(a, b)| a.noise[0] > 1.2 * b.noise[0])
            };
            assert!(wider(&inflated.training, context.recordings()));
            assert!(wider(&inflated.validation, &context.evidence.validation));
        });
    }

    #[test]
    fn an_effect_that_explains_all_passes_with_inflated_noise() {
        in_swings(&[(FRICTION, 0.15)], 4, 1, |context| {
            let attempt = Attempt::tuned(context).unwrap();
            let floor = attempt.floor;
            let tested = Attempt::tested(attempt.context, attempt.found, super::super::Scope::Whole, None).unwrap();
            assert!(DiscrepancyAsNoise.applies(&tested));
            let replaced = DiscrepancyAsNoise.attempt(tested, &|_| {}).unwrap();
            assert!(replaced.practical.is_some() && replaced.floor == floor);
            assert_eq!(names(&replaced.context, &replaced.last().structure.effects), ["viscous_friction"]);
        });
    }

    /// What is known about the simulation without effects is of use again, and gains are over the tuned one.
    #[test]
    fn a_second_search_begins_where_the_first_did() {
        in_swings(&[(FRICTION, 0.15)], 4, 1, |context| {
            let found = search(context, fit_without_effects(context).unwrap(), is_adequate, &|_| {}).unwrap();
            let best = found.best.as_ref().unwrap();
            let learned = context.with_evidence(Evidence::clone(&context.evidence).prewhitened(0.1));
            let tuned = learned.fit_near(&[], &found.base).unwrap();
            let again = known_base(&learned, &tuned, &found.base, best).unwrap();
            assert_eq!(again.fit.point.parameters, found.base.fit.point.parameters);
            let gained = |base: &Hypothesis<'_>, tuned: &Hypothesis<'_>| {
                let (base, tuned) = (base.again(&learned).unwrap(), tuned.again(&learned).unwrap());
                search(&learned, base, is_adequate, &|_| {}).unwrap().over(&learned, tuned).selected[0].gain
            };
            let (near, direct) = (gained(&again, &tuned), gained(&tuned, &tuned));
            assert!((near - direct).abs() < 0.1, "{near} {direct}");
        });
    }
}
