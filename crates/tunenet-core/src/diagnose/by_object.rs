//! Which of the effects each object's own recordings show.
//!
//! Objects share which effects there are, so that one that shows an effect clearly speaks for those that hardly do. What is
//! true of all together need not be needed by each: air brakes foam, and rubber falls as it would without.

use super::answer::{OfObject, OwnEffect, Verdict};
use super::assemble::Judged;
use super::intervals::Intervals;
use super::search::Place;
use super::sets::Set;
use super::study::{Model, Study};

/// The verdict of each object that has recordings to fit, in order; of a single one that of the whole.
pub(super) fn by_object(study: &Study, judged: &Judged, last: &Model, intervals: &Intervals) -> Vec<OfObject> {
    let seen = |object: &usize| study.sets.iter().any(|set| set.object == *object);
    let objects: Vec<usize> = (0..study.subjects.len()).filter(seen).collect();
    let (whole, alternatives) = (judged.decision.verdict, &judged.decision.alternatives);
    let told = matches!(whole, Verdict::Named | Verdict::OneOf);
    let several = objects.len() > 1;
    let of = |object: usize| {
        let each = judged.found.places.iter().filter(|_| told);
        let effects: Vec<OwnEffect> = each.map(|place| own(study, judged, last, intervals, place, object)).collect();
        let shown = || effects.iter().zip(alternatives).filter(|(effect, _)| effect.shown);
        // Doubt about the whole that names no other is doubt about each.
        let doubt = whole == Verdict::OneOf && alternatives.iter().all(Vec::is_empty);
        let verdict = if !told || !several {
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
fn own(study: &Study, judged: &Judged, last: &Model, intervals: &Intervals, place: &Place, object: usize) -> OwnEffect {
    let position = last.structure.effects.iter().position(|&entry| entry == place.entry);
    let all: Vec<usize> = position.map_or_else(Vec::new, |p| last.structure.of_effect(p));
    let mine: Vec<usize> = all.into_iter().filter(|&g| last.structure.globals[g].object == Some(object)).collect();
    let count: usize = study.sets.iter().filter(|set| set.object == object).map(Set::count).sum();
    let price = mine.len() as f64 * (study.independent * count as f64).max(1.0).ln();
    // What all objects share all of them show; and where contacts are not understood, no whole recording can be weighed.
    let weighed = !mine.is_empty() && !judged.open;
    let bic_gain = weighed.then(|| intervals.squared_distance_from_absence(&mine) - price);
    let shown = bic_gain.is_none_or(|gain| gain > study.settings.margin);
    OwnEffect { name: study.catalogue[place.entry].name, bic_gain, shown }
}
