//! Which of the effects each object's own recordings show.
//!
//! Objects share which effects there are, so that one that shows an effect clearly speaks for those that hardly do. What is
//! true of all together need not be needed by each: air brakes foam, and rubber falls as it would without.

use crate::diagnose::answer::intervals::Intervals;
use crate::diagnose::answer::judgement::Judgement;
use crate::diagnose::answer::{OfObject, OwnEffect, Verdict};
use crate::diagnose::evidence::recording::Set;
use crate::diagnose::hypothesis::forward_selection::SelectedEffect;

/// The verdict of each object that has recordings to fit, in order; of a single one that of the whole.
pub(in crate::diagnose) fn by_object(judged: &Judgement, intervals: &Intervals) -> Vec<OfObject> {
    let context = &judged.context;
    let seen = |object: &usize| context.sets().iter().any(|set| set.object == *object);
    let objects: Vec<usize> = (0..context.subjects.len()).filter(seen).collect();
    let (whole, alternatives) = (judged.decision.verdict, &judged.decision.alternatives);
    let several = objects.len() > 1;
    let of = |object: usize| {
        let each = judged.found.places.iter().filter(|_| judged.reports_effects());
        let effects: Vec<OwnEffect> = each.map(|place| own(judged, intervals, place, object)).collect();
        let shown = || effects.iter().zip(alternatives).filter(|(effect, _)| effect.shown);
        // Doubt about the whole that names no other is doubt about each.
        let doubt = whole == Verdict::OneOf && alternatives.iter().all(Vec::is_empty);
        let verdict = if !judged.reports_effects() || !several {
            whole
        } else if shown().next().is_none() {
            Verdict::None
        } else if doubt || shown().any(|(_, near)| !near.is_empty()) {
            Verdict::OneOf
        } else {
            Verdict::Named
        };
        OfObject { object, verdict, effects }
    };
    objects.into_iter().map(of).collect()
}

/// One effect in the recordings of one object.
fn own(judged: &Judgement, intervals: &Intervals, place: &SelectedEffect, object: usize) -> OwnEffect {
    let (context, last) = (&judged.context, judged.last());
    let position = last.structure.effects.iter().position(|&entry| entry == place.entry);
    let all: Vec<usize> = position.map_or_else(Vec::new, |p| last.structure.of_effect(p));
    let mine: Vec<usize> = all.into_iter().filter(|&g| last.structure.globals[g].object == Some(object)).collect();
    let count: usize = context.sets().iter().filter(|set| set.object == object).map(Set::count).sum();
    let price = mine.len() as f64 * (context.effective_fraction() * count as f64).max(1.0).ln();
    // What all objects share all of them show; and where contacts are not understood, no whole recording can be weighed.
    let weighed = !mine.is_empty() && !judged.events_open();
    let bic_gain = weighed.then(|| intervals.squared_distance_from_absence(&mine) - price);
    let shown = bic_gain.is_none_or(|gain| gain > context.settings.margin);
    OwnEffect { name: context.catalogue[place.entry].name.clone(), bic_gain, shown }
}
