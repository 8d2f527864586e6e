//! From the search to the answer.

use super::adequacy::AGREEMENT;
use super::answer::{Diagnosis, Test, Verdict};
use super::assemble::{Judged, assemble};
use super::chance::{by_chance, with_chance};
use super::control::{control, ratios, unseen};
use super::decide::decide;
use super::held_out::HeldOut;
use super::insufficient::too_little;
use super::memory::believable;
use super::practical::{Second, practically};
use super::search::Found;
use super::sets::Set;
use super::study::{Model, Study};
use super::{Answered, Progress, Recording};
use crate::Result;
use crate::observation::Note;

/// A model may not raise the held-out residual by more than this factor.
const HELD_OUT_WORSE: f64 = 1.05;

/// The code of what is said where flights are explained and contacts are not.
pub(super) const CONTACT_OPEN: &str = "contact.unexplained";

/// Searches, judges and answers.
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
    say_what_is_alike(&study, &mut notes);
    let Look { mut found, mut rho, apart } = first_look(&mut study, &mut held_out, progress)?;
    let judged_apart = apart.is_some();
    let (mut practical, open) = apart.unwrap_or((None, false));
    for set in &mut held_out {
        set.colour(rho);
    }
    let mut before = unseen(&study, &found.base, &held_out)?;
    let mut tests = study.adequacy(found.best.as_ref().unwrap_or(&found.base));
    let floor = study.floor();
    if !judged_apart && let Some(second) = second_look(&mut study, &found, &tests, &mut held_out, floor, progress)? {
        (found, before, practical) = (second.found, second.before, Some(second.tests));
        notes.push(Note::new(
            "adequacy.practical",
            "something small is left beyond noise; the effects are named for the large part that they take away",
            "",
        ));
    }
    let control = control(&study, &found, &held_out)?;
    let ratios = ratios(&study, &found, &held_out, before.as_ref())?;
    let by_chance = if judged_apart || practical.is_some() { None } else { by_chance(&study, &mut found, &tests)? };
    if let Some(scatter) = by_chance {
        study.admit(&scatter, &mut held_out)?;
        found = with_chance(&study, found, &scatter, progress)?;
        tests = study.adequacy(found.best.as_ref().unwrap_or(&found.base));
        // Tilts that nothing stood for had passed for noise that remembers.
        if let Some(best) = &found.best
            && tests.iter().any(|t| !t.passed)
            && study.learn_noise(best, &mut rho)?
        {
            for set in &mut held_out {
                set.colour(rho);
            }
            found = with_chance(&study, found, &scatter, progress)?;
            tests = study.adequacy(found.best.as_ref().unwrap_or(&found.base));
        }
    }
    if found.best.is_none() {
        tests.extend(believable(rho));
    }
    progress(Progress::Judging);
    let after = match &found.best {
        Some(best) => unseen(&study, best, &held_out)?,
        None => before.clone(),
    };
    tests.extend(worse_on_unseen(before.as_ref(), after.as_ref()));
    // Copies of the throw that was fitted confirm nothing.
    let another = |set: &Set| !study.single() || set.throw != study.sets[0].throw;
    let confirmed = practical.is_none() || held_out.iter().any(another);
    let decision = decide(&study, &found, practical.as_ref().unwrap_or(&tests), confirmed);
    let differ = !judged_apart && (practical.is_some() || tests.iter().any(|t| t.name == AGREEMENT && !t.passed));
    tests.extend(practical.into_iter().flatten());
    if open {
        notes.push(Note::new(
            CONTACT_OPEN,
            "what flies is explained; at the contacts something is left that no effect takes away",
            "vary height and surface, to see with which of them it changes",
        ));
    }
    if rho != 0.0 {
        let text = format!("the noise remembers from sample to sample (correlation {rho:.2}) and is whitened");
        notes.push(Note::new("noise.coloured", text, ""));
    }
    study.say_what_has_no_say(found.best.as_ref().unwrap_or(&found.base), &mut notes);
    if matches!(decision.verdict, Verdict::Named | Verdict::OneOf) {
        study.say_what_stands_back(&found, decision.margin, &mut notes);
    }
    let judged =
        Judged { ratios, decision, floor, found, tests, before, after, control, held_out, uses, notes, open, differ };
    assemble(&study, judged, recordings)
}

/// What the search of whole recordings ends with, or of their flights and contacts apart.
struct Look<'a> {
    found: Found<'a>,
    /// The correlation of neighbouring samples of the noise.
    rho: f64,
    /// Where flights and contacts were judged apart: the tests that the effects had to pass, where there are any, and
    /// whether contacts leave something.
    apart: Option<(Option<Vec<Test>>, bool)>,
}

fn first_look<'a>(study: &mut Study<'a>, held_out: &mut [Set], progress: &dyn Fn(Progress)) -> Result<Look<'a>> {
    progress(Progress::Tuning);
    study.hold_mirrored(held_out)?;
    let mut base = study.base()?;
    study.leave_out_unmeasured(&base, held_out)?;
    if study.hopeless(&base)
        && let Some(apart) = study.apart(progress)?
    {
        let told = (apart.best.is_some().then_some(apart.tests), apart.open);
        let found = Found { base, alone: apart.alone, best: apart.best, places: apart.places };
        return Ok(Look { found, rho: 0.0, apart: Some(told) });
    }
    let mut rho = 0.0;
    if study.learn_noise(&base, &mut rho)? {
        base = study.fit_near(&[], &base)?;
    }
    let found = study.search(base, progress)?;
    let mut found = study.search_again(found, &mut rho, progress)?;
    if let Some(white) = study.search_without_memory(&found, &mut rho, progress)? {
        found = white;
    }
    Ok(Look { found, rho, apart: None })
}

/// What the search finds where the rest is taken for noise, if that passes its tests; else nothing has changed.
fn second_look<'a>(
    study: &mut Study<'a>,
    found: &Found<'a>,
    tests: &[Test],
    held_out: &mut Vec<Set>,
    floor: f64,
    progress: &dyn Fn(Progress),
) -> Result<Option<Second<'a>>> {
    // Without a recording that could confirm it, a large part taken away proves no name; of a single one it leaves a choice.
    let judgeable = !held_out.is_empty() || study.thin();
    if !judgeable || tests.iter().all(|t| t.passed) {
        return Ok(None);
    }
    let known = (study.sets.clone(), held_out.clone());
    let second = practically(study, found, held_out, floor, progress)?;
    if second.found.best.is_some() && second.tests.iter().all(|t| t.passed) {
        return Ok(Some(second));
    }
    (study.sets, *held_out) = known.clone();
    study.independent = 1.0;
    if let Some(beside) = study.search_expecting(found, progress)? {
        let second = practically(study, &beside, held_out, floor, progress)?;
        let believed = |model: &Model| !study.only_expected(model) && study.unbelievable(model).is_none();
        if second.found.best.as_ref().is_some_and(believed) && second.tests.iter().all(|t| t.passed) {
            return Ok(Some(second));
        }
        study.independent = 1.0;
    }
    study.expecting = false;
    (study.sets, *held_out) = known;
    Ok(None)
}

/// Whether the effects raise the residual of recordings that were not fitted.
fn worse_on_unseen(before: Option<&HeldOut>, after: Option<&HeldOut>) -> Option<Test> {
    let value = after?.rmse / before?.rmse.max(f64::MIN_POSITIVE);
    let passed = value <= HELD_OUT_WORSE;
    Some(Test { name: "held-out residual after over before", value, threshold: HELD_OUT_WORSE, passed })
}

/// Recordings that repeat one throw.
fn say_what_is_alike(study: &Study, notes: &mut Vec<Note>) {
    let mut recordings: Vec<usize> = study.sets.iter().map(|set| set.recording).collect();
    recordings.dedup();
    if recordings.len() > 1 && study.single() {
        let words = study.words();
        let text = format!(
            "all {} recordings show one and the same {motion}, so they count as one: what one {motion} cannot tell apart \
             stays together, however often it is repeated",
            recordings.len(),
            motion = words.motion
        );
        notes.push(Note::new("recordings.alike", text, words.otherwise));
    }
}
