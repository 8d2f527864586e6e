//! Verdict: none, named, one of a confusable set, or unknown.

use crate::diagnose::Test;
use crate::diagnose::answer::{Conclusion, Diagnosis, Verdict};
use crate::diagnose::hypothesis::context::{Context, SINGLE_MOTION_MARGIN};
use crate::diagnose::hypothesis::forward_selection::{SelectedEffect, Selection};
use crate::diagnose::hypothesis::plausibility::needs_no_evidence;
use crate::diagnose::hypothesis::plausibility::{is_less_plausible, is_required};
use crate::diagnose::hypothesis::wording::words;
use crate::diagnose::judge::validation_doubt::Doubt;
use crate::simulator::Text;

/// How many alternatives of an effect are offered at most.
const MOST_ALTERNATIVES: usize = 5;
/// How many names are given as the nearest where nothing fits and nothing was added.
const NEAREST: usize = 2;

/// The verdict, and what it rests on.
pub(in crate::diagnose) struct Decision {
    pub verdict: Verdict,
    /// For each effect of the best structure: what could be in its place. Empty where it has none.
    pub alternatives: Vec<Vec<usize>>,
    /// For each effect of the best structure: whether nothing else in the catalogue is as likely.
    pub distinct: Vec<bool>,
    /// All names that are left, or the nearest.
    pub names: Vec<Text>,
    /// How far behind the best an explanation is still left.
    pub margin: f64,
    /// Why what is distinguished from everything else by far is not named alone.
    pub doubt: Option<Doubt>,
}

/// The margin for what could replace one effect. A required effect exists in any case; the question is only whether something else
/// explains the same, and the usual margin answers it.
fn margin_of(context: &Context, selected: &SelectedEffect, margin: f64) -> f64 {
    if is_required(context, selected.entry) { margin.min(context.settings.margin) } else { margin }
}

/// What falls behind an effect of the best hypothesis by less than `margin`, or does as well on held-out recordings, less what is
/// implausible where that effect is plausible.
pub(in crate::diagnose) fn in_place_of(context: &Context, selected: &SelectedEffect, margin: f64) -> Vec<usize> {
    let margin = margin_of(context, selected, margin);
    let near = selected.others.iter().filter(|(other, gap)| *gap < margin || selected.equals.contains(other));
    near.filter(|(other, gap)| !is_less_plausible(context, *other, selected.entry, *gap))
        .map(|(entry, _)| *entry)
        .collect()
}

/// The verdict of what was found. `confirmed` is whether recordings that were not fitted bear it out, or nothing is left
/// that they would have to; `validation` is what keeps the effects in doubt all the same.
pub(in crate::diagnose) fn decide(
    context: &Context,
    found: &Selection,
    tests: &[Test],
    confirmed: bool,
    validation: Option<Doubt>,
) -> Decision {
    let adequate = tests.iter().all(|t| t.passed);
    let names =
        |entries: &mut dyn Iterator<Item = usize>| unique(entries.map(|e| context.catalogue[e].name.clone()).collect());
    let widest = context.margin();
    let ended = |verdict, names| Decision {
        verdict,
        alternatives: Vec::new(),
        distinct: Vec::new(),
        names,
        margin: widest,
        doubt: None,
    };
    if found.best.is_none() {
        if adequate {
            return ended(Verdict::None, Vec::new());
        }
        let near = found.alone.iter().filter(|c| c.excluded.is_none() && c.gain > 0.0);
        return ended(Verdict::Unknown, names(&mut near.take(NEAREST).map(|c| c.entry)));
    }
    if !adequate
        || found.selected.iter().any(|p| p.gain < context.settings.margin && !needs_no_evidence(context, p.entry))
    {
        return ended(Verdict::Unknown, names(&mut found.selected.iter().map(|p| p.entry)));
    }
    // A random effect of events can imitate what nothing in the catalogue explains: alone and in doubt, it is no answer.
    let imitates = matches!(validation, Some(Doubt::RandomAndWeak | Doubt::DrawsNotRandom));
    if let ([selected], true) = (&found.selected[..], imitates)
        && context.catalogue[selected.entry].is_random_effect()
        && in_place_of(context, selected, widest).is_empty()
    {
        return ended(Verdict::Unknown, names(&mut std::iter::once(selected.entry)));
    }
    let mut alternatives = Vec::with_capacity(found.selected.len());
    let (mut distinct, mut near_any) = (Vec::with_capacity(found.selected.len()), false);
    for selected in &found.selected {
        let mut near = in_place_of(context, selected, widest);
        // One motion does not distinguish what is in the catalogue from what is not, so the next best is kept with the best; where
        // nothing else explains anything, the best is left alone, and what is in no catalogue with it.
        let doubtful = match &validation {
            Some(Doubt::Feigned(..) | Doubt::Imitated(..)) => {
                context.catalogue[selected.entry].of[0].feigned_by.is_some()
            }
            Some(_) => true,
            None => doubtful(context, selected, confirmed),
        };
        near_any |= !near.is_empty();
        distinct.push(near.is_empty() && !self::doubtful(context, selected, confirmed));
        if near.is_empty() && doubtful && !leaves_unknown(context, found, validation.as_ref()) {
            near.extend(runner_up(context, found, selected));
        }
        near.truncate(MOST_ALTERNATIVES);
        let excluded = selected.excluded.iter().map(|rival| &rival.effect);
        let is_random = context.catalogue[selected.entry].is_random_effect();
        let differing = match &validation {
            Some(Doubt::DiffersBetweenRecordings(effects)) if is_random => &effects[..],
            _ => &[],
        };
        let rivals = excluded.chain(differing);
        for rival in rivals.filter_map(|name| context.catalogue.iter().position(|entry| entry.name == *name)) {
            if !near.contains(&rival) && found.selected.iter().all(|p| p.entry != rival) {
                near.insert(0, rival);
            }
        }
        alternatives.push(near);
    }
    let doubt = validation.is_some() || found.selected.iter().any(|selected| doubtful(context, selected, confirmed));
    let open = doubt || alternatives.iter().any(|near| !near.is_empty());
    let all = found.selected.iter().zip(&alternatives);
    let names =
        names(&mut all.flat_map(|(selected, near)| std::iter::once(selected.entry).chain(near.iter().copied())));
    let margin = found.selected.iter().map(|p| margin_of(context, p, widest)).fold(context.settings.margin, f64::max);
    let doubt = (doubt && (!near_any || validation.is_some())).then(|| {
        validation.unwrap_or_else(|| {
            if context.evidence.shows_one_motion() {
                Doubt::SingleMotion(words(context).single)
            } else {
                Doubt::Unconfirmed
            }
        })
    });
    Decision {
        verdict: if open { Verdict::OneOf } else { Verdict::Named },
        alternatives,
        distinct,
        names,
        margin,
        doubt,
    }
}

/// Whether an effect is not named alone although nothing comes near it: a single motion shows it, or no recording that was not
/// fitted bears it out. One that has to be there in any case does where it is distinguished from everything else by far, several motions or
/// objects showing it; of a single motion, where what it leaves is noise.
fn doubtful(context: &Context, selected: &SelectedEffect, confirmed: bool) -> bool {
    if !is_required(context, selected.entry) {
        return !confirmed || context.evidence.shows_one_motion();
    }
    let near = |(other, gap): &(usize, f64)| {
        *gap < SINGLE_MOTION_MARGIN * context.settings.margin
            && !is_less_plausible(context, *other, selected.entry, *gap)
    };
    !confirmed && (context.evidence.shows_one_motion() || selected.others.iter().any(near))
}

/// Whether what is open is the remainder that several effects leave of model discrepancy: that what explains far less could be in the place
/// of one of them says nothing of it.
fn leaves_unknown(context: &Context, found: &Selection, validation: Option<&Doubt>) -> bool {
    context.evidence.discrepancy() && found.selected.len() > 1 && validation == Some(&Doubt::DiscrepancyRemains)
}

/// The next best in the place of an effect, whatever its distance, that explains anything at all.
fn runner_up(context: &Context, found: &Selection, selected: &SelectedEffect) -> Option<usize> {
    // What falls behind by all that the effect is worth gains nothing.
    let scored = selected.others.iter().filter(|(_, gap)| *gap < selected.gain).map(|(entry, _)| *entry);
    let alone = found.alone.iter().filter(|c| c.excluded.is_none() && c.gain > 0.0).map(|c| c.entry);
    let named = |entry: usize| found.selected.iter().any(|p| p.entry == entry);
    scored
        .chain(alone)
        .find(|&entry| !named(entry) && !is_less_plausible(context, entry, selected.entry, f64::INFINITY))
}

/// Each name once, in the order in which they come.
pub(in crate::diagnose) fn unique<T: PartialEq>(names: Vec<T>) -> Vec<T> {
    let mut once: Vec<T> = Vec::with_capacity(names.len());
    for name in names {
        if !once.contains(&name) {
            once.push(name);
        }
    }
    once
}

impl Diagnosis {
    /// The same with something missing, as this sentence says, where nothing is.
    #[must_use]
    pub fn reopened(mut self, description: String) -> Self {
        if self.conclusion == Conclusion::None {
            self.conclusion = Conclusion::Unknown { nearest: Vec::new(), description, remains: None };
            for object in self.objects.iter_mut().filter(|object| object.verdict == Verdict::None) {
                object.verdict = Verdict::Unknown;
            }
        }
        self
    }

    /// The same with its effects named alone, where only this doubt kept others with them.
    #[must_use]
    pub fn undoubted(mut self, resolved: &Doubt) -> Self {
        let Conclusion::OneOf { effects, doubt: Some(doubt), .. } = &mut self.conclusion else { return self };
        if doubt != resolved || !effects.iter().all(|named| named.evidence.is_distinct) {
            return self;
        }
        let mut effects = std::mem::take(effects);
        for named in &mut effects {
            named.alternatives.clear();
        }
        self.conclusion = Conclusion::Named { effects };
        // It was to distinguish what was left.
        self.next_experiment = None;
        for object in self.objects.iter_mut().filter(|object| object.verdict == Verdict::OneOf) {
            object.verdict = Verdict::Named;
        }
        self
    }

    /// The same with its names in doubt, where it names effects.
    #[must_use]
    pub fn doubted(mut self, doubt: Doubt) -> Self {
        if let Conclusion::Named { effects } = self.conclusion {
            let names = effects.iter().map(|named| named.effect.name.clone()).collect();
            self.conclusion = Conclusion::OneOf { effects, names, doubt: Some(doubt) };
            for object in self.objects.iter_mut().filter(|object| object.verdict == Verdict::Named) {
                object.verdict = Verdict::OneOf;
            }
        }
        self
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::judge::adequacy::is_adequate;
    use crate::diagnose::tests::zoo::{FRICTION, in_swings};

    use crate::diagnose::hypothesis::forward_selection::search;
    use crate::diagnose::hypothesis::multistart::fit_without_effects;
    use crate::diagnose::judge::adequacy::residual_diagnostics;

    fn verdict(truth: &[(&str, f64)], count: u32) -> (Verdict, Vec<Text>) {
        let mut found = (Verdict::Insufficient, Vec::new());
        in_swings(truth, count, 0, |context| {
            let searched = search(context, fit_without_effects(context).unwrap(), is_adequate, &|_| {}).unwrap();
            let tests = residual_diagnostics(context, searched.best.as_ref().unwrap_or(&searched.base)).tests;
            let decision = decide(context, &searched, &tests, true, None);
            found = (decision.verdict, decision.names);
        });
        found
    }

    #[test]
    fn several_motions_name_an_effect_and_a_single_one_leaves_a_choice() {
        assert_eq!(verdict(&[], 3), (Verdict::None, Vec::new()));
        assert_eq!(verdict(&[(FRICTION, 0.15)], 3), (Verdict::Named, vec!["viscous_friction".into()]));
        let (one, names) = verdict(&[(FRICTION, 0.15)], 1);
        assert!(one == Verdict::OneOf && names.iter().any(|name| name == "viscous_friction"), "{one:?} {names:?}");
    }
}
