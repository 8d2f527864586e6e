//! Contacts alone: where flights are not understood, as of a video before an unknown camera, the speed that a contact takes
//! along the surface still shows, right before it and right after it.

use crate::Result;
use crate::diagnose::answer::{Diagnosis, GapOf, NextExperiment, Verdict};
use crate::diagnose::evidence::recording::Set;
use crate::diagnose::hypothesis::catalogue::Entry;
use crate::diagnose::pipeline::{Preparations, Problem};
use crate::diagnose::strategy::detrended_flights::straighten;
use crate::diagnose::{Settings, Subject};
use crate::findings;
use crate::observation::{Kind, Note};
use crate::simulator::{Phase, Preparation, Simulator, measurement_effects};

/// Near enough for flights whose every other force was taken out; another world's are not straightened.
const GRAVITY_M_S2: f64 = 9.81;
/// What turns speed across the surface into speed along it.
const CAMERA_TILT: &str = "camera_tilt";
/// Straightening is not exact: what a flight loses changes how the next contact slips. Where what is left does not look like
/// noise, velocities are taken for so many times less certain, and evidence is so much weaker.
const WIDER: [f64; 3] = [1.0, 2.0, 3.0];
/// Fewer recordings leave a choice at most.
const FEWEST_RECORDINGS: usize = 3;

/// The answer of the contacts of `sets`, their flights straightened and their spin at the start unknown, where `whole`,
/// that of the recordings as they are, stays in doubt. `None` where no contact surely takes speed along the surface, or
/// where what explains that could be the camera's doing as well.
pub(in crate::diagnose) fn contacts_alone(
    problem: &Problem,
    sets: &[Set],
    known: &Preparations,
    whole: &Diagnosis,
) -> Result<Option<Diagnosis>> {
    if sets.iter().any(|set| set.prepared.seen.kind() != Kind::Positions) {
        return Ok(None);
    }
    let spinning: Option<Vec<Box<dyn Simulator>>> =
        problem.subjects.iter().map(|s| s.simulator.with_release_spin()).collect();
    let Some(spinning) = spinning else { return Ok(None) };
    let named = problem.subjects.iter().zip(&spinning);
    let subjects: Vec<Subject> =
        named.map(|(s, simulator)| Subject { name: s.name.clone(), simulator: simulator.as_ref() }).collect();
    let settings = Settings { most_effects: 1, ..problem.settings.clone() };
    let segmented = Problem { subjects: &subjects, settings: &settings, ..*problem };
    let mut found = None;
    for wider in WIDER {
        found = of_contacts(&segmented, sets, known, wider)?;
        if found.is_some() {
            break;
        }
    }
    let Some((mut answer, used)) = found else { return Ok(None) };
    keep_kin(&mut answer, problem.settings.margin);
    if used < FEWEST_RECORDINGS {
        leave_open(&mut answer);
    }
    answer.rollouts += whole.rollouts;
    answer.gap.iter_mut().for_each(|gap| gap.of = GapOf::Contacts);
    answer.notes.push(Note::new(
        findings::CONTACTS_ALONE,
        "the recordings as a whole are not explained, but their contacts surely take speed along the surface. They were \
         judged alone: each flight has a smooth acceleration of its own, and what that is stays open",
        "record several throws in varied directions to learn more of the flights",
    ));
    Ok(Some(answer))
}

/// The answer where flights are straightened with velocities so many times less certain, and how many recordings it rests on.
fn of_contacts(
    problem: &Problem,
    sets: &[Set],
    known: &Preparations,
    wider: f64,
) -> Result<Option<(Diagnosis, usize)>> {
    let (mut straight, mut beyond_tilt) = (Vec::new(), 0.0);
    for set in sets {
        if let Some((set, beyond)) = straightened(problem.subjects, set, problem.settings.seed, wider)? {
            straight.push(set);
            beyond_tilt += beyond;
        }
    }
    let used = straight.iter().filter(|set| !set.held_out).count();
    // One of two recordings may not be chosen because it shows what the other does not.
    if used == 0 || straight.len() < sets.len() {
        return Ok(None);
    }
    // What contacts change to either side is no tilt's doing.
    let no_tilt = beyond_tilt > problem.settings.margin;
    let at_contact = |entry: &Entry| {
        let tilts = entry.of[0].mistaken_for.contains(&CAMERA_TILT);
        entry.of[0].phase == Phase::Contact && !entry.chance() && !(no_tilt && tilts)
    };
    let Ok(outcome) = problem.run_among(straight, known.clone(), &at_contact) else { return Ok(None) };
    let answer = outcome.diagnosis;
    let told = matches!(answer.verdict, Verdict::Named | Verdict::OneOf) && !answer.effects.is_empty();
    let seen_so: Vec<&str> = measurement_effects(Kind::Positions).iter().map(|e| e.name).collect();
    let by_camera = answer.effects.iter().any(|n| n.effect.mistaken_for.iter().any(|o| seen_so.contains(o)));
    Ok((told && !by_camera).then_some((answer, used)))
}

/// A recording whose flights are straightened, where that shows something, and what no tilt explains of it.
fn straightened(subjects: &[Subject], set: &Set, seed: u64, wider: f64) -> Result<Option<(Set, f64)>> {
    let Some(straight) = straighten(&set.prepared.seen, &set.contacts, GRAVITY_M_S2, (seed, wider)) else {
        return Ok(None);
    };
    let Preparation::Usable(mut prepared) = subjects[set.object].simulator.prepare(&straight.ideal)? else {
        return Ok(None);
    };
    // Contacts are known; they are not to be looked for again in what strays.
    let contacts = prepared.events.clone();
    let (Some(first), count) = (prepared.seen.clock().first().copied(), prepared.seen.len()) else { return Ok(None) };
    let begin = straight.seen.clock().partition_point(|t| *t < first - 1e-9);
    let Ok(seen) = straight.seen.slice(begin..(begin + count).min(straight.seen.len())) else { return Ok(None) };
    prepared.seen = seen;
    let mut made = Set { throw: set.throw, ..Set::new(set.recording, set.object, set.held_out, *prepared) };
    made.contacts = contacts;
    for (sd, found) in made.noise.iter_mut().zip(&straight.noise) {
        *sd = if *found > 0.0 { *found } else { *sd };
    }
    made.colour(0.0);
    Ok(Some((made, straight.beyond_tilt)))
}

/// One throw leaves whatever lies within ten times the usual margin. Here the alternatives are what acts at contacts alone, so
/// beyond the usual margin only those are left that the catalogue says can be mistaken for the one named.
fn keep_kin(answer: &mut Diagnosis, margin: f64) {
    for place in &mut answer.effects {
        let near = |name: &str| answer.candidates.iter().any(|c| c.name == name && c.delta < margin);
        place.alternatives.retain(|name| near(name) || place.effect.mistaken_for.contains(name));
    }
    answer.names =
        answer.effects.iter().flat_map(|p| [p.effect.name].into_iter().chain(p.alternatives.clone())).collect();
}

/// Leaves another effect of contact that can be mistaken for the only one named.
fn leave_open(answer: &mut Diagnosis) {
    for place in answer.effects.iter_mut().filter(|place| place.alternatives.is_empty()) {
        let kin = |c: &&crate::diagnose::Candidate| place.effect.mistaken_for.contains(&c.name);
        place.alternatives.extend(answer.candidates.iter().find(kin).map(|c| c.name));
    }
    answer.names =
        answer.effects.iter().flat_map(|p| [p.effect.name].into_iter().chain(p.alternatives.clone())).collect();
    answer.verdict = Verdict::OneOf;
    if answer.next_experiment.is_none() {
        let text = "add recordings of the same ball from other heights and in other directions".into();
        answer.next_experiment = Some(NextExperiment { text, settings: Vec::new() });
    }
}
