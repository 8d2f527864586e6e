//! Flights alone: where recordings differ by what no effect explains (the ball spins, a racket hits it), each flight between
//! contacts still says what acts in flight, from a start and with a spin of its own.

use crate::Result;
use crate::diagnose::answer::{Diagnosis, GapOf, NextExperiment, Tuned, Verdict};
use crate::diagnose::evidence::recording::Set;
use crate::diagnose::evidence::segment_noise::raise_noise;
use crate::diagnose::evidence::segments::free_segments;
use crate::diagnose::pipeline::{Preparations, Problem};
use crate::diagnose::{Settings, Subject};
use crate::findings;
use crate::observation::{Note, Observation};
use crate::simulator::{Preparation, Simulator};
use crate::statistics::NORMAL_95;

/// What has to be free for a flight to begin anywhere.
const START: [&str; 6] =
    ["release.x", "release.y", "release.z", "release.velocity_x", "release.velocity_y", "release.velocity_z"];
/// The height of what no flight touches, which its lowest sample is not to pin.
const SURFACE: &str = "surface.height";

/// Fewer recordings leave a choice at most.
const FEWEST_RECORDINGS: usize = 3;

/// The answer of the flights of `sets`, each with an unknown spin, where `whole`, that of the recordings as they are,
/// names nothing.
///
/// What is missing is named only where it has to be there anyhow, as drag of a ball of known mass and size: with so
/// much of every flight's own, too many things look alike.
pub(in crate::diagnose) fn flights_alone(
    problem: &Problem,
    sets: &[Set],
    known: &Preparations,
    whole: &Diagnosis,
) -> Result<Option<Diagnosis>> {
    let spinning: Option<Vec<Box<dyn Simulator>>> =
        problem.subjects.iter().map(|s| s.simulator.with_unknown_spin()).collect();
    let Some(spinning) = spinning else { return Ok(None) };
    let mut subjects: Vec<Subject> = Vec::with_capacity(spinning.len());
    for (subject, simulator) in problem.subjects.iter().zip(&spinning) {
        subjects.push(Subject { name: subject.name.clone(), simulator: simulator.as_ref() });
    }
    let mut flights = Vec::new();
    for set in sets {
        for range in free_segments(set.clock(), &set.contacts).into_iter().flatten() {
            let Ok(flight) = set.prepared.seen.slice(range) else { continue };
            flights.extend(piece(&subjects, set, &flight)?);
        }
    }
    let mut used: Vec<usize> = flights.iter().filter(|p: &&Set| !p.held_out).map(|p| p.recording).collect();
    used.dedup();
    if used.is_empty() {
        return Ok(None);
    }
    let settings = Settings { most_effects: 1, ..problem.settings.clone() };
    let segmented = Problem { subjects: &subjects, settings: &settings, ..*problem };
    let Ok(outcome) = segmented.run(flights, known.clone()) else { return Ok(None) };
    let mut answer = outcome.diagnosis;
    let told = matches!(answer.verdict, Verdict::Named | Verdict::OneOf);
    if !told || !answer.effects.iter().all(|named| named.effect.certain()) {
        return Ok(None);
    }
    if used.len() < FEWEST_RECORDINGS && answer.verdict == Verdict::Named {
        leave_open(problem, &mut answer);
    }
    answer.rollouts += whole.rollouts;
    answer.gap.iter_mut().for_each(|gap| gap.of = GapOf::Flights);
    for i in 0..answer.explained.len() {
        let recording = answer.explained[i].recording;
        let before = answer.explained[..i].iter().filter(|other| other.recording == recording).count();
        answer.explained[i].flight = Some(before + 1);
    }
    answer.parameters = whole.parameters.iter().map(|tuned| beside_contacts(tuned, sets, problem)).collect();
    answer.notes.push(Note::new(
        findings::FLIGHTS_ALONE,
        "the recordings as a whole are not explained: they differ from throw to throw, as by spin, or at contacts. \
         Their flights were judged alone, each with a spin of its own, and parameters of contacts are read off the \
         samples beside them",
        "record throws without spin to learn more of the contacts",
    ));
    Ok(Some(answer))
}

/// Makes a lone name one of two, with the candidate that comes next.
fn leave_open(problem: &Problem, answer: &mut Diagnosis) {
    let effects = problem.subjects[0].simulator.effects();
    let unlikely = |name: &str| effects.iter().any(|e| e.name == name && e.unlikely.is_some());
    let next = answer.candidates.iter().filter(|c| c.excluded.is_none() && !unlikely(c.name)).map(|c| c.name);
    let next = next.filter(|name| !answer.names.contains(name)).take(1).collect::<Vec<_>>();
    // A lone name is one effect's.
    if let Some(named) = answer.effects.first_mut() {
        named.alternatives.extend(&next);
    }
    answer.names.extend(next);
    answer.verdict = Verdict::OneOf;
    let text = "add recordings of the same ball from other heights and in other directions".into();
    answer.next_experiment = Some(NextExperiment { text, settings: Vec::new() });
}

/// One flight as a recording of its own, where it can be used as one.
fn piece(subjects: &[Subject], set: &Set, flight: &Observation) -> Result<Option<Set>> {
    let Preparation::Usable(mut prepared) = subjects[set.object].simulator.prepare(flight)? else {
        return Ok(None);
    };
    let free = |name: &str| prepared.nuisances.iter().any(|nuisances| nuisances.name == name);
    if !prepared.events.is_empty() || !START.iter().all(|name| free(name)) {
        return Ok(None);
    }
    for nuisances in prepared.nuisances.iter_mut().filter(|nuisances| nuisances.name == SURFACE) {
        nuisances.value = 0.5 * (nuisances.min + nuisances.value);
    }
    let mut piece = Set { throw: set.throw, ..Set::new(set.recording, set.object, set.held_out, *prepared) };
    raise_noise(&mut piece);
    Ok(Some(piece))
}

/// A parameter as the samples beside the contacts alone have it, where they do.
fn beside_contacts(tuned: &Tuned, sets: &[Set], problem: &Problem) -> Tuned {
    let parameters = problem.subjects[tuned.object].simulator.parameters();
    let Some(i) = parameters.iter().position(|p| p.name == tuned.name) else { return tuned.clone() };
    let mine = || sets.iter().filter(|s| s.object == tuned.object && !s.held_out);
    let each: Vec<_> = mine().filter_map(|s| s.prepared.local[i]).collect();
    let weight: f64 = each.iter().map(|l| l.sd.powi(-2)).sum();
    let value = each.iter().map(|l| l.value * l.sd.powi(-2)).sum::<f64>() / weight;
    if !value.is_finite() {
        return tuned.clone();
    }
    let squares: f64 = each.iter().map(|l| ((l.value - value) / l.sd).powi(2)).sum();
    // Where recordings differ by more than they should, the mean is known less well.
    let spread = (squares / (each.len() as f64 - 1.0).max(1.0)).max(1.0);
    let reach = NORMAL_95 * (spread / weight).sqrt();
    let p = &parameters[i];
    let interval95 = ((value - reach).max(p.min), (value + reach).min(p.max));
    Tuned { value: value.clamp(p.min, p.max), interval95, ..tuned.clone() }
}
