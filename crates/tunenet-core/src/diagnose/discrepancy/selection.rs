//! Forward selection by the information criterion with few independent values (Schwarz 1978), every effect confirmed by held-out
//! recordings before the next is looked for, and backward elimination at the end.

use super::elimination::eliminated;
use super::scale::{BRIEF, FINISH, LOSS, rescaled};
use super::selection_step::{DiscrepancyStep, brief_step, selection_step};
use super::wide_search::{is_affordable, widened};
use crate::Result;
use crate::diagnose::evidence::Evidence;
use crate::diagnose::hypothesis::candidate_scores::{CandidateFit, gain};
use crate::diagnose::hypothesis::context::{Context, Hypothesis};
use crate::diagnose::hypothesis::forward_selection::{SelectedEffect, Selection, scoring};
use crate::diagnose::judge::adequacy::{RESOLVED, is_below_steps};
use crate::diagnose::judge::held_out_proof::{HeldOut, validate};
use crate::diagnose::{Progress, Test};
use crate::estimate::huber::huber_cost;
use crate::estimate::information_criterion::p_value;
use crate::statistics::root_mean_square;

/// Every effect has to gain this many times the margin: the search looks at all candidates, with several starts.
const FIRM: f64 = 2.0;
/// What an effect leaves of held-out recordings, over what is left without it, as a robust sum of squares.
const ADMITTED: f64 = 0.96;
/// An effect that leaves more than so many times the noise may be fitted in a local minimum. A wide search leads out of it where it
/// leaves less than this share of the same.
const OPEN: f64 = 5.0;
const BETTER: f64 = 0.9;
/// Candidates that are fitted in the place of an effect that others follow.
const RIVALS: usize = 3;
/// Those farther behind than so many margins are not.
const NEAR: f64 = 5.0;

/// What a search finds.
pub(in crate::diagnose) struct Gated<'a> {
    /// Under which it was made.
    pub context: Context<'a>,
    pub found: Selection<'a>,
    /// What held-out recordings say; empty where there are none, or nothing was found.
    pub tests: Vec<Test>,
}

/// Searches from the tuned simulation `base`: candidates from where they are absent. Where these explain nothing, or one of them leaves far
/// more than noise, or several do and end at a bound, the first candidate is searched from starts across its bounds as well, of a few joints.
///
/// # Errors
/// Where the simulator refuses.
pub(in crate::diagnose) fn search_gated<'a>(
    context: &Context<'a>,
    base: &Hypothesis<'a>,
    progress: &dyn Fn(Progress),
) -> Result<Gated<'a>> {
    let near = search_from(context, base, selection_step, progress)?;
    let left = near.left_over(context)?;
    let settled = near.found.best.as_ref().is_some_and(|best| best.structure.effects.len() > 1 && !at_bound(best));
    if settled || left.is_some_and(|left| left < OPEN) || !is_affordable(context, base) {
        return Ok(near);
    }
    let wide = search_from(context, base, |context, model| widened(context, selection_step(context, model)), progress)?;
    let better = match (left, wide.left_over(context)?) {
        (Some(left), Some(wide)) => wide < BETTER * left,
        (left, _) => left.is_none(),
    };
    Ok(if better { wide } else { near })
}

/// Whether a shared parameter ends at a bound other than 0, as in many a local minimum.
fn at_bound(best: &Hypothesis) -> bool {
    let mut pairs = best.structure.shared.iter().zip(&best.fit.point.parameters);
    pairs.any(|(shared, value)| shared.parameter.bound_reached(*value).is_some())
}

impl Gated<'_> {
    /// The root mean square of what its effects leave of the recordings that were fitted, in units of the noise that these have in
    /// `context`; `None` without effects. A local minimum may fit most samples and leave only the swings.
    fn left_over(&self, context: &Context) -> Result<Option<f64>> {
        let Some(best) = &self.found.best else { return Ok(None) };
        let measured = context.with_evidence(Evidence::clone(&context.evidence).prewhitened(0.0));
        let residuals = measured.joint(&best.structure).residuals(&best.fit.point, 1.0)?;
        Ok(Some(root_mean_square(residuals.into_iter().flatten())))
    }
}

/// Searches from the tuned simulation `base`, the first effect by the step that `first` makes.
fn search_from<'a>(
    context: &Context<'a>,
    base: &Hypothesis<'a>,
    first: impl Fn(&Context<'a>, Hypothesis<'a>) -> DiscrepancyStep<'a>,
    progress: &dyn Fn(Progress),
) -> Result<Gated<'a>> {
    let (mut context, mut model) = rescaled(context, base)?;
    let mut steps: Vec<DiscrepancyStep> = Vec::new();
    let mut tests = Vec::new();
    let most = context.settings.most_effects;
    let mut best = None;
    loop {
        let effects = model.structure.effects.len();
        progress(scoring(&context, &model));
        let found = if effects == 0 { first(&context, model) } else { selection_step(&context, model) };
        let admitted = if effects < most { admitted(&context, &found)? } else { None };
        let Some((next, test)) = admitted else {
            steps.push(found);
            break;
        };
        tests.extend(test);
        let rescaled = rescaled(&context, &next)?;
        steps.push(found);
        (context, model) = rescaled;
        best = Some(model.again(&context)?);
        if effects + 1 == most {
            break;
        }
    }
    let Some(best) = best else {
        let DiscrepancyStep { model, candidates } = steps.remove(0);
        let found = Selection { alone: candidates, ..Selection::tuned(model) };
        return Ok(Gated { context, found, tests });
    };
    let best = eliminated(&context, best)?;
    let (best, selected) = judge_selected(&context, best, &mut steps)?;
    let DiscrepancyStep { model, candidates } = steps.remove(0);
    let base = context.fit_near_with(&[], &model, FINISH)?;
    let found = Selection { base, alone: candidates, best: Some(best), selected };
    Ok(Gated { context, found, tests })
}

/// What held-out recordings leave of a hypothesis, as a robust sum of squares in units of the noise.
fn held_out_cost(held_out: &HeldOut) -> f64 {
    huber_cost(&held_out.residuals, LOSS)
}

/// The best candidate of a step that the criterion and held-out recordings admit, with the test that these make.
fn admitted<'a>(context: &Context<'a>, step: &DiscrepancyStep<'a>) -> Result<Option<(Hypothesis<'a>, Option<Test>)>> {
    let least = FIRM * context.settings.margin;
    let threshold = if is_below_steps(context, &step.model) { RESOLVED * RESOLVED } else { ADMITTED };
    let fitted = step.candidates.iter().filter(|candidate| candidate.excluded.is_none() && candidate.gain > least);
    let mut before = None;
    for candidate in fitted {
        let Some(model) = &candidate.model else { continue };
        if before.is_none() {
            before = validate(context, &step.model)?;
        }
        let after = validate(context, model)?;
        let (Some(before), Some(after)) = (&before, &after) else { return Ok(Some((model.again(context)?, None))) };
        let value = held_out_cost(after) / held_out_cost(before).max(f64::MIN_POSITIVE);
        if value <= threshold {
            let test = Test { name: "held-out misfit with the effect over without", value, threshold, passed: true };
            return Ok(Some((model.again(context)?, Some(test))));
        }
    }
    Ok(None)
}

/// The gain of each effect of `best`, and what else could be in its place.
fn judge_selected<'a>(
    context: &Context<'a>,
    best: Hypothesis<'a>,
    steps: &mut [DiscrepancyStep<'a>],
) -> Result<(Hypothesis<'a>, Vec<SelectedEffect>)> {
    let effects = best.structure.effects.clone();
    let mut selected = Vec::with_capacity(effects.len());
    for (position, &entry) in effects.iter().enumerate() {
        let others: Vec<usize> = effects.iter().copied().filter(|&e| e != entry).collect();
        let last = position + 1 == effects.len();
        let known = steps.iter().position(|step| last && step.model.structure.effects == others);
        let made;
        let step = if let Some(known) = known {
            &steps[known]
        } else {
            let without = context.fit_near_with(&others, &best, BRIEF)?;
            made = brief_step(context, without, RIVALS);
            &made
        };
        let scale = best.scale();
        // Steps before the last are in units of their own; what counts is the distance within each.
        let without = context.fit_near_with(&others, &step.model, BRIEF)?;
        let worth = gain(context, &without, &best, scale);
        let coefficients = best.structure.shared.len() - without.structure.shared.len();
        let likelihood = context.likelihood(without.deviance(scale), best.deviance(scale));
        let p = p_value(likelihood, coefficients) * context.catalogue.len() as f64;
        let mut near = in_place(context, &without, (&best, worth), entry, &step.candidates)?;
        near.sort_by(|a, b| a.1.total_cmp(&b.1).then(a.0.cmp(&b.0)));
        selected.push(SelectedEffect {
            entry,
            gain: worth,
            p_value: p.min(1.0),
            others: near,
            equals: Vec::new(),
            excluded: None,
        });
    }
    Ok((best, selected))
}

/// Candidates in the place of `entry` with how far they fall behind; only those that were fitted come near.
fn in_place<'a>(
    context: &Context<'a>,
    without: &Hypothesis<'a>,
    (best, worth): (&Hypothesis<'a>, f64),
    entry: usize,
    candidates: &[CandidateFit<'a>],
) -> Result<Vec<(usize, f64)>> {
    let scale = best.scale();
    let mut near = Vec::new();
    let own = candidates.iter().find(|candidate| candidate.entry == entry);
    let open = candidates.iter().filter(|candidate| candidate.entry != entry && candidate.excluded.is_none());
    let behind = |one: &&CandidateFit| own.is_none_or(|own| own.gain - one.gain < context.settings.margin * NEAR);
    for candidate in open.filter(behind).take(RIVALS) {
        let Some(model) = &candidate.model else { continue };
        let rival = context.fit_near_with(&model.structure.effects, model, BRIEF)?;
        near.push((candidate.entry, worth - gain(context, without, &rival, scale)));
    }
    Ok(near)
}

#[cfg(test)]
mod tests {
    use super::super::null::fit_null;
    use super::*;
    use crate::diagnose::tests::zoo::{FRICTION, in_swings, names};

    #[test]
    fn what_held_out_recordings_bear_out_is_found_and_leaves_noise() {
        in_swings(&[(FRICTION, 0.15)], 6, 3, |context| {
            let base = fit_null(context).unwrap();
            let gated = search_gated(context, &base, &|_| {}).unwrap();
            let best = gated.found.best.as_ref().unwrap();
            assert_eq!(names(&gated.context, &best.structure.effects), ["viscous_friction"]);
            assert!(gated.tests.iter().all(|test| test.passed) && !gated.tests.is_empty());
            assert!(gated.left_over(context).unwrap().unwrap() < 1.3);
        });
    }

    #[test]
    fn nothing_is_found_where_nothing_is_missing() {
        in_swings(&[], 6, 3, |context| {
            let gated = search_gated(context, &fit_null(context).unwrap(), &|_| {}).unwrap();
            assert!(gated.found.best.is_none() && gated.left_over(context).unwrap().is_none());
        });
    }
}
