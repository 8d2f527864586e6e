//! From what was found and how it was tested to the verdict.

use super::answer::{Test, Verdict};
use super::search::{Found, Place};
use super::study::Study;

/// Of a single throw, explanations are left up to this many times the usual margin. It earns no lone name, since what
/// is in no catalogue looks like one of its entries in one throw, by any margin; unless the effect has to be there, as drag
/// of a ball of known mass and size.
const SINGLE: f64 = 10.0;
/// How many alternatives of an effect are offered at most.
const MOST_ALTERNATIVES: usize = 5;
/// How many names stand for the nearest where nothing fits and nothing was added.
const NEAREST: usize = 2;

/// The verdict, and what it rests on.
pub(super) struct Decision {
    pub verdict: Verdict,
    /// For each effect of the best structure: what could be in its place. Empty where it has none.
    pub alternatives: Vec<Vec<usize>>,
    /// All names that are left, or the nearest.
    pub names: Vec<&'static str>,
    /// How far behind the best an explanation is still left.
    pub margin: f64,
    /// Why what is told from everything else by far earns no lone name.
    pub doubt: Option<&'static str>,
}

/// How far behind the best an explanation is still left; more where no object shows a second throw, against which the
/// coefficients of its own could be held.
pub(super) fn margin(study: &Study) -> f64 {
    study.settings.margin * if study.thin() { SINGLE } else { 1.0 }
}

/// The same in the place of one effect. Of one that has to be there anyhow it is no question whether it is, only whether
/// something else does its work: there the usual margin does.
fn margin_of(study: &Study, place: &Place, margin: f64) -> f64 {
    if study.certain(place.entry) { margin.min(study.settings.margin) } else { margin }
}

/// What stands within `margin` of an effect of the best structure, or does as well on recordings that were not fitted, less
/// what is not to be expected where that is.
pub(super) fn in_place_of(study: &Study, place: &Place, margin: f64) -> Vec<usize> {
    let margin = margin_of(study, place, margin);
    let near = place.others.iter().filter(|(other, gap)| *gap < margin || place.equals.contains(other));
    near.map(|(entry, _)| *entry).filter(|&other| !study.stands_back(other, place.entry)).collect()
}

/// The verdict of what was found. `confirmed` is whether recordings that were not fitted bear it out, or nothing is left
/// that they would have to.
pub(super) fn decide(study: &Study, found: &Found, tests: &[Test], confirmed: bool) -> Decision {
    let adequate = tests.iter().all(|t| t.passed);
    let names = |entries: &mut dyn Iterator<Item = usize>| unique(entries.map(|e| study.catalogue[e].name).collect());
    let widest = margin(study);
    let ended = |verdict, names| Decision { verdict, alternatives: Vec::new(), names, margin: widest, doubt: None };
    if found.best.is_none() {
        if adequate {
            return ended(Verdict::None, Vec::new());
        }
        let near = found.alone.iter().filter(|t| t.excluded.is_none() && t.gain > 0.0);
        return ended(Verdict::Unknown, names(&mut near.take(NEAREST).map(|t| t.entry)));
    }
    if !adequate || found.places.iter().any(|p| p.gain < study.settings.margin && !study.unasked(p.entry)) {
        return ended(Verdict::Unknown, names(&mut found.places.iter().map(|p| p.entry)));
    }
    let mut alternatives = Vec::with_capacity(found.places.len());
    let mut near_any = false;
    for place in &found.places {
        let mut near = in_place_of(study, place, widest);
        // One throw cannot tell what is in the catalogue from what is not, so the next best is left beside the best; where
        // nothing else explains anything, the best is left alone, and what is in no catalogue beside it.
        let doubtful = doubtful(study, place, confirmed);
        near_any |= !near.is_empty();
        if near.is_empty() && doubtful {
            near.extend(runner_up(study, found, place));
        }
        near.truncate(MOST_ALTERNATIVES);
        alternatives.push(near);
    }
    let doubt = found.places.iter().any(|place| doubtful(study, place, confirmed));
    let open = doubt || alternatives.iter().any(|near| !near.is_empty());
    let all = found.places.iter().zip(&alternatives);
    let names = names(&mut all.flat_map(|(place, near)| std::iter::once(place.entry).chain(near.iter().copied())));
    let margin = found.places.iter().map(|p| margin_of(study, p, widest)).fold(study.settings.margin, f64::max);
    let doubt = (doubt && !near_any)
        .then(|| if study.single() { study.words().single } else { "no recording that was not fitted bears it out" });
    Decision { verdict: if open { Verdict::OneOf } else { Verdict::Named }, alternatives, names, margin, doubt }
}

/// Whether an effect earns no lone name although nothing comes near it: a single throw shows it, or no recording that was not
/// fitted bears it out. One that has to be there anyhow does where it is told from everything else by far, several throws or
/// objects showing it; of a single throw, where what it leaves is noise.
fn doubtful(study: &Study, place: &Place, confirmed: bool) -> bool {
    if !study.certain(place.entry) {
        return !confirmed || study.single();
    }
    let offered = |other: usize| !study.stands_back(other, place.entry);
    let near = |(other, gap): &(usize, f64)| offered(*other) && *gap < SINGLE * study.settings.margin;
    !confirmed && (study.single() || place.others.iter().any(near))
}

/// The next best in the place of an effect, whatever its distance, that explains anything at all.
fn runner_up(study: &Study, found: &Found, place: &Place) -> Option<usize> {
    // What falls behind by all that the effect is worth gains nothing.
    let beside = place.others.iter().filter(|(_, gap)| *gap < place.gain).map(|(entry, _)| *entry);
    let alone = found.alone.iter().filter(|t| t.excluded.is_none() && t.gain > 0.0).map(|t| t.entry);
    let named = |entry: usize| found.places.iter().any(|p| p.entry == entry);
    beside.chain(alone).find(|&entry| !named(entry) && !study.stands_back(entry, place.entry))
}

/// Each name once, in the order in which they come.
pub(super) fn unique<'a>(names: Vec<&'a str>) -> Vec<&'a str> {
    let mut once: Vec<&'a str> = Vec::with_capacity(names.len());
    for name in names {
        if !once.contains(&name) {
            once.push(name);
        }
    }
    once
}
