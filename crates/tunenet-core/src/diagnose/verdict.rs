//! From the search to the verdict.

use super::answer::{Diagnosis, Test, Use, Verdict};
use super::assemble::{Judged, assemble};
use super::catalogue::Entry;
use super::held_out::HeldOut;
use super::joint::{Outcome, Point};
use super::scatter::Scatter;
use super::search::{Found, Place};
use super::sets::Set;
use super::study::{Model, Study};
use super::{Answered, Progress, Recording};
use crate::Result;
use crate::observation::Note;

/// Of a single recording, explanations are left up to this many times the usual margin. It earns no lone name, since what
/// is in no catalogue looks like one of its entries in one throw, by any margin; unless the effect has to be there, as drag
/// of a ball of known mass and size.
const SINGLE: f64 = 10.0;
/// Fewer values than this beyond the unknowns say nothing of what is missing.
const LEAST_FREEDOM: usize = 12;
/// A model may not raise the held-out residual by more than this factor.
const HELD_OUT_WORSE: f64 = 1.05;
/// Candidates that are tried on held-out recordings.
const MOST_RATIOS: usize = 3;
/// How many names an ambiguous or unknown verdict gives at most.
const MOST_NAMES: usize = 6;

/// The code of what is said where flights are explained and contacts are not.
pub(super) const CONTACT_OPEN: &str = "contact.unexplained";

/// Searches, judges and answers.
#[expect(clippy::too_many_lines, reason = "the steps of a diagnosis, one after the other")]
pub(super) fn judge(
    mut study: Study,
    mut held_out: Vec<Set>,
    recordings: &[Recording],
    known: Answered,
    progress: &dyn Fn(Progress),
) -> Result<Diagnosis> {
    let Answered { uses, mut notes } = known;
    if let Some(answer) = too_little(&study, &uses, &notes) {
        return Ok(answer);
    }
    progress(Progress::Tuning);
    let mut base = study.base()?;
    study.leave_out_unmeasured(&base, &mut held_out)?;
    let mut rho = 0.0;
    let apart = if study.hopeless(&base) { study.apart(progress)? } else { None };
    let open = apart.as_ref().is_some_and(|apart| apart.open);
    let judged_apart = apart.is_some();
    let mut practical = None;
    let mut found = if let Some(apart) = apart {
        practical = apart.best.is_some().then_some(apart.tests);
        Found { base, alone: apart.alone, best: apart.best, places: apart.places }
    } else {
        if study.learn_noise(&base, &mut rho)? {
            base = study.fit_near(&[], &base)?;
        }
        study.search(base, progress)?
    };
    if open {
        notes.push(Note::new(
            CONTACT_OPEN,
            "what flies is explained; at the contacts something is left that no effect takes away",
            "vary height and surface, to see with which of them it changes",
        ));
    }
    // With the effects in, the noise shows more clearly; where it differs from what was taken for it, all is done again.
    if let (Some(best), false) = (&found.best, judged_apart) {
        let point = (best.structure.effects.clone(), best.fit.point.clone());
        let again = {
            let structure = study.structure(&point.0)?;
            let model = Model { structure, fit: best.fit.clone() };
            study.learn_noise(&model, &mut rho)?
        };
        if again {
            let base = study.fit_near(&[], &found.base)?;
            found = study.search(base, progress)?;
        }
    }
    for set in &mut held_out {
        set.colour(rho);
    }
    let mut before = unseen(&study, &found.base, &held_out)?;
    let mut tests = study.adequacy(found.best.as_ref().unwrap_or(&found.base));
    let floor = study.floor();
    // Without a recording that could confirm it, a large part taken away proves no name; of a single one it leaves a choice.
    let judgeable = !held_out.is_empty() || study.single();
    if !judged_apart && judgeable && !tests.iter().all(|t| t.passed) {
        let (sets, unseen_sets) = (study.sets.clone(), held_out.clone());
        let second = practically(&mut study, &found, &mut held_out, floor, progress)?;
        if second.tests.iter().all(|t| t.passed) && second.found.best.is_some() {
            found = second.found;
            before = second.before;
            notes.push(Note::new(
                "adequacy.practical",
                "something small is left beyond noise; the effects are named for the large part that they take away",
                "",
            ));
            practical = Some(second.tests);
        } else {
            (study.sets, held_out, study.independent) = (sets, unseen_sets, 1.0);
        }
    }
    let control = control(&study, &found, &held_out)?;
    let ratios = ratios(&study, &found, &held_out, before.as_ref())?;
    let by_chance = if judged_apart || practical.is_some() { None } else { by_chance(&study, &found, &tests)? };
    if let Some(scatter) = by_chance {
        study.admit(&scatter, &mut held_out)?;
        found = with_chance(&study, found, &scatter, progress)?;
        tests = study.adequacy(found.best.as_ref().unwrap_or(&found.base));
    }
    if rho != 0.0 {
        let text = format!("the noise remembers from sample to sample (correlation {rho:.2}) and is whitened");
        notes.push(Note::new("noise.coloured", text, ""));
    }
    for (g, global) in found.base.structure.globals.iter().enumerate() {
        if !found.base.fit.covariance[(g, g)].is_finite() {
            let text = format!("`{}` changes nothing in these recordings", global.parameter.name);
            notes.push(Note::new("parameter.no_effect", text, "bring a recording in which it matters"));
        }
    }
    progress(Progress::Judging);
    let after = match &found.best {
        Some(best) => unseen(&study, best, &held_out)?,
        None => before.clone(),
    };
    if let (Some(before), Some(after)) = (&before, &after) {
        let value = after.rmse / before.rmse.max(f64::MIN_POSITIVE);
        let passed = value <= HELD_OUT_WORSE;
        tests.push(Test { name: "held-out residual after over before", value, threshold: HELD_OUT_WORSE, passed });
    }
    let judged_by = practical.as_ref().unwrap_or(&tests);
    let confirmed = practical.is_none() || !held_out.is_empty();
    let (verdict, names) = decide(&study, &found, judged_by, confirmed);
    tests.extend(practical.into_iter().flatten());
    let margin = margin(&study);
    if matches!(verdict, Verdict::Named | Verdict::OneOf) {
        study.say_what_stands_back(&found, margin, &mut notes);
    }
    let judged = Judged {
        ratios,
        verdict,
        names,
        margin,
        floor,
        found,
        tests,
        before,
        after,
        control,
        held_out,
        uses,
        notes,
        open,
    };
    assemble(&study, judged, recordings)
}

/// A second look, with what the first leaves taken for noise.
pub(super) struct Second<'a> {
    pub found: Found<'a>,
    before: Option<HeldOut>,
    pub tests: Vec<Test>,
}

pub(super) fn practically<'a>(
    study: &mut Study<'a>,
    first: &Found<'a>,
    held_out: &mut [Set],
    floor: f64,
    progress: &dyn Fn(Progress),
) -> Result<Second<'a>> {
    let mut found = study.search_practically(first, held_out, progress)?;
    let before = unseen(study, &found.base, held_out)?;
    let after = found.best.as_ref().map_or(Ok(None), |best| unseen(study, best, held_out))?;
    if let (Some(before), Some(after)) = (&before, &after) {
        study.admit_equals(&mut found, held_out, before.rmse, after.rmse)?;
    }
    let control = control(study, &found, held_out)?.map(|c| c.1);
    let tests = study.practical_tests(&found, floor, before.as_ref().zip(after.as_ref()), control)?;
    Ok(Second { found, before, tests })
}

/// Whether chance at contacts explains more than anything else, or what nothing else does.
fn by_chance(study: &Study, found: &Found, tests: &[Test]) -> Result<Option<Scatter>> {
    let significant = |s: &Scatter| s.gain > study.settings.margin && s.p_value < study.settings.significance;
    let alone = study.scatter(&found.base)?.filter(significant);
    // At the misfit's own scale, as the gain by chance is.
    let others = found.best.as_ref().map_or(0.0, |best| study.gain(&found.base, best, found.base.scale()));
    if alone.as_ref().is_some_and(|s| s.gain > others) {
        return Ok(alone);
    }
    let adequate = tests.iter().all(|t| t.passed);
    match &found.best {
        Some(best) if !adequate => Ok(study.scatter(best)?.filter(significant)),
        _ => Ok(None),
    }
}

/// The search again, every bounce with a tilt of its own.
fn with_chance<'a>(
    study: &Study<'a>,
    plain: Found<'a>,
    scatter: &Scatter,
    progress: &dyn Fn(Progress),
) -> Result<Found<'a>> {
    let entry = study.catalogue.iter().position(Entry::chance).unwrap_or(0);
    let mut own = plain.base.fit.point.own.clone();
    own.iter_mut().zip(&scatter.unknowns).for_each(|(own, tilts)| own.extend(tilts.iter().map(|t| t.value)));
    let near = Model {
        structure: study.structure(&[])?,
        fit: Outcome { point: Point { globals: plain.base.fit.point.globals.clone(), own }, ..plain.base.fit.clone() },
    };
    let base = study.fit_near(&[], &near)?;
    let again = study.search(base, progress)?;
    let place = Place { entry, gain: scatter.gain, p_value: scatter.p_value, others: Vec::new() };
    let places = std::iter::once(place).chain(again.places).collect();
    let best = Some(again.best.unwrap_or(again.base));
    Ok(Found { base: plain.base, alone: plain.alone, best, places })
}

fn unseen(study: &Study, model: &Model, sets: &[Set]) -> Result<Option<HeldOut>> {
    if sets.is_empty() { Ok(None) } else { study.held_out(model, sets).map(Some) }
}

/// A wrong effect on the held-out recordings: the candidate that was fitted and gained least.
fn control(study: &Study, found: &Found, sets: &[Set]) -> Result<Option<(&'static str, f64)>> {
    let named = |entry: usize| {
        found.places.iter().any(|p| {
            p.entry == entry || p.others.iter().any(|(other, gap)| *other == entry && *gap < study.settings.margin)
        })
    };
    let wrong = found.alone.iter().rev().find(|t| t.excluded.is_none() && !named(t.entry));
    let (Some(wrong), false) = (wrong, sets.is_empty()) else { return Ok(None) };
    let model = study.fit_near(&[wrong.entry], &found.base)?;
    Ok(Some((study.catalogue[wrong.entry].name, study.held_out(&model, sets)?.rmse)))
}

/// How far the best candidates, each alone, take the held-out residual down.
fn ratios(study: &Study, found: &Found, sets: &[Set], before: Option<&HeldOut>) -> Result<Vec<(usize, f64)>> {
    let (Some(before), Some(_)) = (before, &found.best) else { return Ok(Vec::new()) };
    let fitted = found.alone.iter().filter_map(|t| t.model.as_ref().map(|model| (t.entry, model)));
    fitted
        .take(MOST_RATIOS)
        .map(|(entry, model)| Ok((entry, study.held_out(model, sets)?.rmse / before.rmse)))
        .collect()
}

/// The answer of recordings that cannot give one.
fn too_little(study: &Study, uses: &[Use], notes: &[Note]) -> Option<Diagnosis> {
    let values = study.count();
    let own: usize = study.sets.iter().map(|s| s.prepared.own.len()).sum();
    let parameters: usize =
        study.subjects.iter().map(|s| s.simulator.parameters().iter().filter(|p| p.tune).count()).sum();
    let unknowns = own + parameters;
    let note = if study.sets.is_empty() {
        Note::new("recordings.none", "no recording can be used to fit", "see what was noted of each")
    } else if values < unknowns + LEAST_FREEDOM {
        let text = format!("{values} values for {unknowns} unknowns leave nothing to judge by");
        Note::new("recordings.short", text, "bring longer recordings, or more of them")
    } else {
        return None;
    };
    Some(Diagnosis {
        verdict: Verdict::Insufficient,
        effects: Vec::new(),
        names: Vec::new(),
        candidates: Vec::new(),
        gap: None,
        adequacy: Vec::new(),
        next_experiment: None,
        margin: margin(study),
        description: None,
        remains: None,
        parameters: Vec::new(),
        explained: Vec::new(),
        uses: uses.to_vec(),
        notes: notes.iter().cloned().chain([note]).collect(),
        rollouts: 0,
    })
}

/// How far behind the best an explanation is still left; more where no object has a second recording, against which the
/// coefficients of its own could be held.
pub(super) fn margin(study: &Study) -> f64 {
    let alone = |object: usize| study.sets.iter().filter(|set| set.object == object).count() < 2;
    let thin = study.sets.iter().all(|set| alone(set.object));
    study.settings.margin * if thin { SINGLE } else { 1.0 }
}

fn decide(study: &Study, found: &Found, tests: &[Test], confirmed: bool) -> (Verdict, Vec<&'static str>) {
    let adequate = tests.iter().all(|t| t.passed);
    let name = |entry: usize| study.catalogue[entry].name;
    if found.best.is_none() {
        if adequate {
            return (Verdict::None, Vec::new());
        }
        let near = found.alone.iter().filter(|t| t.excluded.is_none() && t.gain > 0.0);
        return (Verdict::Unknown, near.take(2).map(|t| name(t.entry)).collect());
    }
    if !adequate || found.places.iter().any(|p| p.gain < study.settings.margin) {
        return (Verdict::Unknown, found.places.iter().map(|p| name(p.entry)).collect());
    }
    let single = study.single();
    let margin = margin(study);
    let mut names: Vec<&'static str> = Vec::new();
    let mut open = false;
    for place in &found.places {
        names.push(name(place.entry));
        let near = in_place_of(study, place, margin);
        open |= !near.is_empty() || single && !(confirmed && study.certain(place.entry));
        names.extend(near.into_iter().map(name));
    }
    if single && open && names.len() == 1 {
        let best = found.places[0].entry;
        let mut rest = found.alone.iter().filter(|t| t.excluded.is_none() && t.entry != best);
        let next = rest.find(|t| !study.stands_back(t.entry, best));
        names.extend(next.map(|t| name(t.entry)));
    }
    let mut names = unique(names);
    names.truncate(MOST_NAMES.max(found.places.len()));
    (if open { Verdict::OneOf } else { Verdict::Named }, names)
}

/// What stands within `margin` of an effect of the best structure, less what is not to be expected where that is. Of an
/// effect that has to be there anyhow it is no question whether it is, only whether something else does its work: there the
/// usual margin does.
pub(super) fn in_place_of(study: &Study, place: &Place, margin: f64) -> Vec<usize> {
    let margin = if study.certain(place.entry) { margin.min(study.settings.margin) } else { margin };
    let near = place.others.iter().filter(|(_, gap)| *gap < margin).map(|(entry, _)| *entry);
    near.filter(|&other| !study.stands_back(other, place.entry)).collect()
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
