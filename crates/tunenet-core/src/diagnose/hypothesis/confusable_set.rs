//! Confusable set: the effects that the recordings cannot distinguish from a selected one, and those that no recording does.

use crate::diagnose::hypothesis::candidate_scores::CandidateFit;
use crate::diagnose::hypothesis::candidate_scores::gain;
use crate::diagnose::hypothesis::context::{Context, Hypothesis};
use crate::diagnose::hypothesis::plausibility::{Exclusion, OutOfRange, strains_an_object};
use crate::estimate::canonical_correlation::canonical_correlation;
use crate::simulator::Text;

/// Two effects whose projected columns share this much (squared canonical correlation) are the same to these recordings,
/// whatever small difference a fit finds.
pub(in crate::diagnose) const TWINS: f64 = 0.9999;

/// The effects that could replace `entry` in `model`, each with how far it falls behind, nearest first. `without` is the model
/// without `entry`, and `candidates` are those in addition to it.
pub(in crate::diagnose) fn others(
    context: &Context,
    without: &Hypothesis,
    model: &Hypothesis,
    entry: usize,
    candidates: &[CandidateFit],
) -> Vec<(usize, f64)> {
    let scale = model.scale();
    let best = gain(context, without, model, scale);
    let own = candidates.iter().find(|c| c.entry == entry).map_or(&[][..], |c| c.span.as_slice());
    let sound = !strains_an_object(context, model);
    let strained = |c: &CandidateFit| sound && c.model.as_ref().is_some_and(|other| strains_an_object(context, other));
    let each = candidates.iter().filter(|c| c.entry != entry && c.excluded.is_none() && !strained(c));
    let gap = |c: &CandidateFit| {
        let twin = c.span.len() == own.len() && canonical_correlation(own, &c.span) > TWINS;
        let gap = c.model.as_ref().map(|other| best - gain(context, without, other, scale));
        match gap {
            Some(gap) => Some((c.entry, gap)),
            None if twin => Some((c.entry, 0.0)),
            None => None,
        }
    };
    let mut all: Vec<(usize, f64)> = each.filter_map(gap).collect();
    all.sort_by(|a, b| a.1.total_cmp(&b.1).then(a.0.cmp(&b.0)));
    all
}

/// What would explain more than `model` does, by more than distinguishes two explanations, if its coefficient were physical: a
/// value on which its bounds rest may be wrong. `without` and `candidates` are as for [`others`].
pub(in crate::diagnose) fn excluded_rival(
    context: &Context,
    without: &Hypothesis,
    model: &Hypothesis,
    candidates: &[CandidateFit],
) -> Option<OutOfRange> {
    let scale = model.scale();
    let best = gain(context, without, model, scale);
    let rivals = candidates.iter().filter_map(|candidate| match (&candidate.excluded, &candidate.model) {
        (Some(Exclusion::Implausible(coefficient)), Some(rival)) => {
            Some((gain(context, without, rival, scale) - best, coefficient))
        }
        _ => None,
    });
    let ahead = rivals.filter(|(lead, _)| *lead > context.settings.margin);
    ahead.max_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, coefficient)| coefficient.clone())
}

/// The twins of an effect as `model` has it, by their positions in the catalogue, each with what distinguishes both.
pub(in crate::diagnose) fn exact_twins<'c>(
    context: &'c Context,
    model: &Hypothesis,
    entry: usize,
) -> Vec<(usize, &'c Text)> {
    let structure = &model.structure;
    let Some(position) = structure.effects.iter().position(|&e| e == entry) else { return Vec::new() };
    let own = structure.of_effect(position);
    let value = |&column: &usize| {
        (model.fit.point.parameters[column], structure.shared[column].absent.map_or(0.0, |(absent, _)| absent))
    };
    let alike = context.catalogue[entry].of[0].exact_twins.iter().filter(|twin| twin.side.holds(own.iter().map(value)));
    let known = |name: &Text| context.catalogue.iter().position(|other| other.name == *name);
    let found = alike.filter_map(|twin| Some((known(&twin.name)?, &twin.separated_by)));
    found.filter(|(other, _)| !model.has(*other)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::tests::zoo::{FRICTION, in_swings};

    use crate::diagnose::hypothesis::candidate_scores::score_candidates;
    use crate::diagnose::hypothesis::multistart::fit_without_effects;

    #[test]
    fn others_come_nearest_first_and_without_the_effect_itself() {
        in_swings(&[(FRICTION, 0.15)], 3, 0, |context| {
            let base = fit_without_effects(context).unwrap();
            let candidates = score_candidates(context, &base, &[]);
            let best = candidates[0].model.as_ref().unwrap();
            let others = others(context, &base, best, candidates[0].entry, &candidates);
            assert!(others.iter().all(|(other, gap)| *other != candidates[0].entry && *gap > 6.0), "{others:?}");
            assert!(others.is_sorted_by(|a, b| a.1 <= b.1));
        });
    }
}
