//! Random contacts: every contact with a tilt of its own, drawn from one distribution (a random effect); tried last, since it
//! can imitate much.

use super::recordings_apart::{How, explain_apart};
use super::{Attempt, Refinement, Scope};
use crate::Result;
use crate::diagnose::Progress;
use crate::diagnose::hypothesis::candidate_scores::CandidateFit;
use crate::diagnose::hypothesis::candidate_scores::gain;
use crate::diagnose::hypothesis::catalogue::Entry;
use crate::diagnose::hypothesis::context::{Context, Hypothesis};
use crate::diagnose::hypothesis::forward_selection::search;
use crate::diagnose::hypothesis::forward_selection::{SelectedEffect, Selection};
use crate::diagnose::hypothesis::joint::{Outcome, Point};
use crate::diagnose::judge::adequacy::{is_adequate, residual_diagnostics};
use crate::diagnose::judge::random_effect::RandomTiltFit;
use crate::diagnose::judge::random_effect::admit;
use crate::diagnose::judge::random_effect::random_tilts;

pub(super) struct RandomContacts;

impl Refinement for RandomContacts {
    fn applies(&self, attempt: &Attempt) -> bool {
        attempt.scope == Scope::Whole && attempt.practical.is_none() && attempt.random_parameter.is_none()
    }

    fn attempt<'a>(&self, mut attempt: Attempt<'a>, progress: &dyn Fn(Progress)) -> Result<Attempt<'a>> {
        attempt.control = Some(attempt.negative_control()?);
        let adequate = attempt.residuals.passed();
        let Some(scatter) = by_chance(&attempt.context, &mut attempt.found, adequate)? else { return Ok(attempt) };
        let rival = explain_apart(&attempt.context, &attempt.found.base, How::Search, progress)?;
        let near = scatter.gain - attempt.context.settings.margin;
        attempt.apart = rival.filter(|apart| apart.adequate && apart.gain > near);
        attempt.context = admit(&attempt.context, &scatter)?;
        attempt.found = with_chance(&attempt.context, attempt.found, &scatter, progress)?;
        attempt.residuals = residual_diagnostics(&attempt.context, attempt.last());
        // Tilts that nothing stood for had passed for autocorrelated noise.
        if !attempt.residuals.passed()
            && let Some(evidence) = attempt.context.learn_noise(attempt.last())?
        {
            attempt.lag1 = evidence.noise.lag1();
            attempt.context = attempt.context.with_evidence(evidence);
            attempt.found = with_chance(&attempt.context, attempt.found, &scatter, progress)?;
            attempt.residuals = residual_diagnostics(&attempt.context, attempt.last());
        }
        Ok(attempt)
    }
}

/// Whether chance at contacts explains more than anything else, or what nothing else does.
fn by_chance(context: &Context, found: &mut Selection, adequate: bool) -> Result<Option<RandomTiltFit>> {
    let significant = |s: &RandomTiltFit| s.gain > context.settings.margin && s.p_value < context.settings.significance;
    let alone = random_tilts(context, &found.base)?.filter(significant);
    if let (Some(chance), Some(entry)) = (&alone, context.catalogue.iter().position(Entry::chance)) {
        found.alone.push(CandidateFit::unfitted(entry, chance.gain));
        found.alone.sort_by(CandidateFit::order);
    }
    // At the misfit's own scale, as the gain by chance is.
    let others = found.best.as_ref().map_or(0.0, |best| gain(context, &found.base, best, found.base.scale()));
    if alone.as_ref().is_some_and(|s| s.gain > others) {
        return Ok(alone);
    }
    match &found.best {
        Some(best) if !adequate => Ok(random_tilts(context, best)?.filter(significant)),
        _ => Ok(None),
    }
}

/// The search again, every event with a tilt of its own.
fn with_chance<'a>(
    context: &Context<'a>,
    plain: Selection<'a>,
    scatter: &RandomTiltFit,
    progress: &dyn Fn(Progress),
) -> Result<Selection<'a>> {
    let entry = context.catalogue.iter().position(Entry::chance).unwrap_or(0);
    let mut nuisances = plain.base.fit.point.nuisances.clone();
    nuisances
        .iter_mut()
        .zip(&scatter.unknowns)
        .for_each(|(nuisances, tilts)| nuisances.extend(tilts.iter().map(|t| t.value)));
    let near = Hypothesis {
        structure: context.structure(&[])?,
        fit: Outcome {
            point: Point { parameters: plain.base.fit.point.parameters.clone(), nuisances },
            ..plain.base.fit.clone()
        },
    };
    let base = context.fit_near(&[], &near)?;
    let again = search(context, base, is_adequate, progress)?;
    let place = SelectedEffect {
        entry,
        gain: scatter.gain,
        p_value: scatter.p_value,
        others: Vec::new(),
        equals: Vec::new(),
        excluded: None,
    };
    let places = std::iter::once(place).chain(again.places).collect();
    let best = Some(again.best.unwrap_or(again.base));
    Ok(Selection { base: plain.base, alone: plain.alone, best, places })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::tests::zoo::{FRICTION, in_swings};

    use crate::diagnose::strategy::whole_record::WholeRecord;

    #[test]
    fn without_contacts_there_is_no_chance_and_the_control_is_made() {
        in_swings(&[(FRICTION, 0.15)], 4, 1, |context| {
            let tuned = Attempt::tuned(context).unwrap();
            assert!(!RandomContacts.applies(&tuned));
            let whole = WholeRecord.attempt(tuned, &|_| {}).unwrap();
            assert!(RandomContacts.applies(&whole));
            let same = RandomContacts.attempt(whole, &|_| {}).unwrap();
            assert!(same.context.random_tilts.is_none() && same.control.unwrap().wrong.is_some());
        });
    }
}
