//! Per-event random effect (Laird and Ware 1982): every event has draws of its own from one distribution. It is tried last, since
//! it can imitate much.

use super::per_recording_fits::{How, fit_per_recording};
use super::{Attempt, Refinement, Scope, at};
use crate::Result;
use crate::diagnose::Progress;
use crate::diagnose::hypothesis::candidate_scores::CandidateFit;
use crate::diagnose::hypothesis::candidate_scores::gain;
use crate::diagnose::hypothesis::catalogue::Entry;
use crate::diagnose::hypothesis::context::{COMPARED, Context, Hypothesis};
use crate::diagnose::hypothesis::forward_selection::search;
use crate::diagnose::hypothesis::forward_selection::{SelectedEffect, Selection};
use crate::diagnose::hypothesis::joint::{Effort, spread};
use crate::diagnose::judge::adequacy::{is_adequate, residual_diagnostics};
use crate::diagnose::judge::random_effect::EventEffectFit;
use crate::diagnose::judge::random_effect::admit;
use crate::diagnose::judge::random_effect::fit_event_effects;

/// A fit that shows whether draws explain the residual, which is nearly linear in them.
const DRAWN: Effort = Effort { steps: 20, derivatives: 3, ..COMPARED };
/// A residual of more than this many times the noise, with draws fitted, is not due to a wrong autocorrelation of the noise.
const FAR: f64 = 1.3;
/// Recordings are linear in draws but for less than this share of what these explain.
const BENT: f64 = 0.2;

pub(super) struct PerEventEffect;

impl Refinement for PerEventEffect {
    fn applies(&self, attempt: &Attempt) -> bool {
        attempt.scope == Scope::Whole && attempt.practical.is_none() && attempt.random_parameter.is_none()
    }

    fn attempt<'a>(&self, mut attempt: Attempt<'a>, progress: &dyn Fn(Progress)) -> Result<Attempt<'a>> {
        attempt.control = Some(attempt.negative_control()?);
        let adequate = attempt.residuals.passed();
        let Some(leading) = leading_effects(&attempt.context, &mut attempt.found, adequate)? else {
            return Ok(attempt);
        };
        let before = attempt.context.clone();
        let Some((context, near)) = with_draws(&attempt, &leading)? else { return Ok(attempt) };
        let effects = leading.effects;
        attempt.lag1 = context.evidence.noise.lag1();
        attempt.context = context;
        attempt.found = search_with(&attempt.context, attempt.found, (&near, &effects), progress)?;
        attempt.residuals = residual_diagnostics(&attempt.context, attempt.last());
        // Without its parameters the random effect passed for autocorrelated noise.
        if !attempt.residuals.passed()
            && let Some(evidence) = attempt.context.learn_noise(attempt.last())?
        {
            attempt.lag1 = evidence.noise.lag1();
            attempt.context = attempt.context.with_evidence(evidence);
            attempt.found = search_with(&attempt.context, attempt.found, (&near, &effects), progress)?;
            attempt.residuals = residual_diagnostics(&attempt.context, attempt.last());
        }
        // What leaves more than noise is no answer, whatever else explains as much.
        if attempt.residuals.passed() {
            let rival = fit_per_recording(&before, &attempt.found.base, How::Search, progress)?;
            let near = effects.gain - before.settings.margin;
            attempt.per_recording = rival.filter(|fits| fits.adequate && fits.gain > near);
        }
        Ok(attempt)
    }
}

/// The random effect of events that may be part of the explanation.
struct Leading {
    effects: EventEffectFit,
    /// Whether it was looked at in addition to nothing else.
    is_alone: bool,
    /// What it explains in addition to nothing else, if anything.
    alone: Option<EventEffectFit>,
}

/// The context with draws of all recordings in addition to the effects of `model`, and a hypothesis with these; `None` where draws explain
/// nothing.
pub(super) fn with_draws_of_all<'a>(
    context: &Context<'a>,
    model: &Hypothesis<'a>,
) -> Result<Option<(Context<'a>, Hypothesis<'a>)>> {
    let Some(effects) = fit_event_effects(context, model)?.filter(|fit| is_significant(context, fit)) else {
        return Ok(None);
    };
    let admitted = admit(context, &effects)?;
    let near = with_values(&admitted, model, &effects)?;
    Ok(Some((admitted, near)))
}

/// The hypothesis with draws as nuisance parameters, which have their first values.
fn with_values<'a>(admitted: &Context<'a>, model: &Hypothesis<'a>, effects: &EventEffectFit) -> Result<Hypothesis<'a>> {
    let each = model.fit.point.nuisances.iter().zip(&effects.draws);
    let nuisances = each.map(|(own, draws)| own.iter().copied().chain(draws.iter().map(|draw| draw.value)).collect());
    at(admitted, (&model.structure.effects, &model.fit), nuisances.collect())
}

fn is_significant(context: &Context, fit: &EventEffectFit) -> bool {
    fit.gain > context.settings.margin && fit.p_value < context.settings.significance
}

/// The random effect of events, if it explains more than every other effect, or what no other effect explains.
fn leading_effects(context: &Context, found: &mut Selection, adequate: bool) -> Result<Option<Leading>> {
    let significant = |fit: &EventEffectFit| is_significant(context, fit);
    let all = fit_event_effects(context, &found.base)?;
    let alone = all.clone().filter(significant);
    if let (Some(random), Some(entry)) = (&alone, context.catalogue.iter().position(Entry::is_random_effect)) {
        found.alone.push(CandidateFit::unfitted(entry, random.gain));
        found.alone.sort_by(CandidateFit::order);
    }
    // At the misfit's own scale, as the gain of the random effect is.
    let others = found.best.as_ref().map_or(0.0, |best| gain(context, &found.base, best, found.base.scale()));
    if let Some(effects) = alone.filter(|random| random.gain > others) {
        return Ok(Some(Leading { effects, is_alone: true, alone: all }));
    }
    let Some(best) = found.best.as_ref().filter(|_| !adequate) else { return Ok(None) };
    let next = fit_event_effects(context, best)?.filter(significant);
    Ok(next.map(|effects| Leading { effects, is_alone: false, alone: all }))
}

/// The context with the draws of the random effect as nuisance parameters, and a hypothesis with these. `None` where several motions were
/// recorded, and draws explain them neither next to the effects that were found nor alone: then they are no part of an explanation.
fn with_draws<'a>(attempt: &Attempt<'a>, leading: &Leading) -> Result<Option<(Context<'a>, Hypothesis<'a>)>> {
    let effects = &leading.effects;
    let admitted = admit(&attempt.context, effects)?;
    let drawn = |model: &Hypothesis<'a>| with_values(&admitted, model, effects);
    let base = &attempt.found.base;
    if !admitted.shows_free_motions() {
        let near = drawn(base)?;
        return Ok(Some((admitted, near)));
    }
    if let Some(best) = &attempt.found.best {
        let of_best = if leading.is_alone { fit_event_effects(&attempt.context, best)? } else { Some(effects.clone()) };
        let found = if may_explain(of_best.as_ref()) { explained(&admitted, &drawn(best)?)? } else { None };
        if found.is_some() {
            return Ok(found);
        }
    }
    if may_explain(leading.alone.as_ref()) { explained(&admitted, &drawn(base)?) } else { Ok(None) }
}

/// Whether draws may leave no more than noise: what they leave where the recordings are linear in them is little, or little of what is there.
fn may_explain(effects: Option<&EventEffectFit>) -> bool {
    effects.is_some_and(|EventEffectFit { left: (before, after), .. }| *after <= FAR.max(BENT * before))
}

/// A fit near a hypothesis with draws that leaves no more than noise, in the noise of the context or with an autocorrelation learned from it.
fn explained<'a>(admitted: &Context<'a>, near: &Hypothesis<'a>) -> Result<Option<(Context<'a>, Hypothesis<'a>)>> {
    let fitted = admitted.fit_near_with(&near.structure.effects, near, DRAWN)?;
    if residual_diagnostics(admitted, &fitted).passed() {
        return Ok(Some((admitted.clone(), fitted)));
    }
    let evidence = if spread(&fitted.fit.residuals) < FAR { admitted.learn_noise(&fitted)? } else { None };
    let Some(evidence) = evidence else { return Ok(None) };
    let learned = admitted.with_evidence(evidence);
    let fitted = learned.fit_near_with(&fitted.structure.effects, &fitted, DRAWN)?;
    Ok(residual_diagnostics(&learned, &fitted).passed().then_some((learned, fitted)))
}

/// The search again with the draws of the random effect as nuisance parameters, from the values of `near`.
fn search_with<'a>(
    context: &Context<'a>,
    plain: Selection<'a>,
    (near, effects): (&Hypothesis<'a>, &EventEffectFit),
    progress: &dyn Fn(Progress),
) -> Result<Selection<'a>> {
    let entry = context.catalogue.iter().position(Entry::is_random_effect).unwrap_or(0);
    let base = context.fit_near(&[], near)?;
    let again = search(context, base, is_adequate, progress)?;
    let random = SelectedEffect {
        entry,
        gain: effects.gain,
        p_value: effects.p_value,
        others: Vec::new(),
        equals: Vec::new(),
        excluded: None,
    };
    let selected = std::iter::once(random).chain(again.selected).collect();
    let best = Some(again.best.unwrap_or(again.base));
    Ok(Selection { base: plain.base, alone: plain.alone, best, selected })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::tests::zoo::{FRICTION, in_swings};

    use crate::diagnose::strategy::whole_record::WholeRecord;

    #[test]
    fn without_events_there_is_no_random_effect_and_the_control_is_made() {
        in_swings(&[(FRICTION, 0.15)], 4, 1, |context| {
            let tuned = Attempt::tuned(context).unwrap();
            assert!(!PerEventEffect.applies(&tuned));
            let whole = WholeRecord.attempt(tuned, &|_| {}).unwrap();
            assert!(PerEventEffect.applies(&whole));
            let same = PerEventEffect.attempt(whole, &|_| {}).unwrap();
            assert!(same.context.event_effects.is_none() && same.control.unwrap().wrong.is_some());
        });
    }

    #[test]
    fn draws_that_leave_much_by_their_derivatives_are_not_fitted() {
        let fit = |left| EventEffectFit { gain: 100.0, p_value: 0.0, sd: 0.1, left, draws: Vec::new() };
        assert!(may_explain(Some(&fit((2.0, 1.1)))) && may_explain(Some(&fit((12.0, 1.9)))));
        assert!(!may_explain(Some(&fit((3.0, 1.9)))) && !may_explain(None));
    }
}
