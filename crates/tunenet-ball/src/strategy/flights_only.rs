//! Segment-wise fit of free flights: each flight has its own initial state and spin, so that what happens at contacts (an unknown
//! spin, a racket) does not matter. Strategy for recordings whose contacts no effect explains.

use crate::findings;
use tunenet_core::Result;
use tunenet_core::diagnose::{
    Conclusion, Diagnosis, Explanation, GapOf, NextExperiment, PreparedRecording, Problem, Settings, Strategy, Tuned,
    Verdict,
};
use tunenet_core::observation::{LocalEstimate, Note, Observation};
use tunenet_core::simulator::{Effect, Preparation, Simulator, Text};
use tunenet_core::statistics::NORMAL_95;

use super::variants;
use crate::wording::WORDING;

/// What has to be free for a flight to begin anywhere.
const START: [&str; 6] =
    ["release.x", "release.y", "release.z", "release.velocity_x", "release.velocity_y", "release.velocity_z"];
/// The height of what no flight touches, which its lowest sample is not to pin.
const SURFACE: &str = "surface.height";

/// Fewer recordings leave a choice at most.
const FEWEST_RECORDINGS: usize = 3;

/// Flights only. What is missing is named only where it has to be there in any case, as drag of a ball of known mass and size: with
/// so much of every flight's own, too many things look alike.
pub struct FlightsOnly;

impl Strategy for FlightsOnly {
    /// Where the recordings as they are name nothing, or several effects together that are but a guess, as of one throw with a
    /// contact: fewer of the flights are better.
    fn applies(&self, problem: &Problem, so_far: &Explanation) -> bool {
        let whole = &so_far.diagnosis;
        whole.verdict() == Verdict::Unknown || so_far.events_open || crowded(problem, whole)
    }

    fn attempt(&self, problem: &Problem, so_far: &Explanation) -> Result<Option<Explanation>> {
        let Some(spinning) = variants(problem, |ball| ball.with_hidden_state()) else { return Ok(None) };
        if !spinning.iter().any(|ball| ball.effects().iter().any(Effect::required)) {
            return Ok(None);
        }
        let mut flights = Vec::new();
        for recording in problem.recordings() {
            for range in recording.free_segments().into_iter().flatten() {
                let Ok(seen) = recording.prepared().seen.slice(range) else { continue };
                flights.extend(flight(&spinning, recording, &seen)?);
            }
        }
        let mut used: Vec<usize> = flights.iter().filter(|f| !f.held_out()).map(PreparedRecording::recording).collect();
        used.dedup();
        if used.is_empty() {
            return Ok(None);
        }
        let settings = Settings { most_effects: 1, ..problem.settings().clone() };
        let Ok(explained) = problem.explain(&spinning, flights, &settings, &|_| true) else { return Ok(None) };
        Ok(stated(problem, &so_far.diagnosis, explained, used.len()))
    }
}

/// Whether an answer leaves several effects together, of recordings with contacts.
pub(super) fn crowded(problem: &Problem, whole: &Diagnosis) -> bool {
    let several = whole.verdict() == Verdict::OneOf && whole.effects().len() > 1;
    several && problem.recordings().iter().any(|recording| !recording.events().is_empty())
}

/// What the flights of so many recordings say of the recordings as they are; `None` where they name nothing that has to be there.
fn stated(problem: &Problem, whole: &Diagnosis, explained: Explanation, used: usize) -> Option<Explanation> {
    let mut answer = explained.diagnosis;
    let named = matches!(answer.verdict(), Verdict::Named | Verdict::OneOf);
    if !named || !answer.effects().iter().all(|one| one.effect.required()) {
        return None;
    }
    if used < FEWEST_RECORDINGS && answer.verdict() == Verdict::Named {
        answer.conclusion = left_open(&problem.subjects()[0].simulator.effects(), &answer);
        answer.next_experiment = Some(NextExperiment { text: WORDING.add.into(), settings: Vec::new() });
    }
    answer.gap.iter_mut().for_each(|gap| gap.of = GapOf::Segments);
    for i in 0..answer.explained.len() {
        let recording = answer.explained[i].recording;
        let before = answer.explained[..i].iter().filter(|other| other.recording == recording).count();
        answer.explained[i].segment = Some(before + 1);
    }
    answer.parameters = whole.parameters.iter().map(|tuned| next_to_contacts(tuned, problem)).collect();
    answer.notes.push(Note::new(
        findings::FLIGHTS_ALONE,
        "the recordings as a whole are not explained: they differ from throw to throw, as by spin, or at contacts. \
         Their flights were judged alone, each with a spin of its own, and parameters of contacts are read off the \
         samples next to them",
        "record throws without spin to learn more of the contacts",
    ));
    Some(Explanation { diagnosis: answer, ..explained })
}

/// A set of the single name and the next candidate; `known` are the effects of the catalogue.
fn left_open(known: &[Effect], answer: &Diagnosis) -> Conclusion {
    let implausible = |name: &str| known.iter().any(|e| e.name == name && e.implausible.is_some());
    let mut names: Vec<Text> = answer.names().into_iter().map(|name| name.to_owned().into()).collect();
    let others = answer.candidates.iter().filter(|c| c.excluded.is_none() && !implausible(&c.name)).map(|c| &c.name);
    let next = others.into_iter().find(|name| !names.contains(name)).cloned();
    names.extend(next.clone());
    let mut effects = answer.effects().to_vec();
    // A single name belongs to one effect.
    if let Some(named) = effects.first_mut() {
        named.alternatives.extend(next);
    }
    Conclusion::OneOf { effects, names, doubt: None }
}

/// One flight as a recording of its own, where it can be used as one.
fn flight(
    simulators: &[Box<dyn Simulator>],
    recording: &PreparedRecording,
    seen: &Observation,
) -> Result<Option<PreparedRecording>> {
    let Preparation::Usable(mut prepared) = simulators[recording.object()].prepare(seen)? else {
        return Ok(None);
    };
    let free = |name: &str| prepared.nuisances.iter().any(|nuisance| nuisance.name == name);
    if !prepared.events.is_empty() || !START.iter().all(|name| free(name)) {
        return Ok(None);
    }
    for nuisance in prepared.nuisances.iter_mut().filter(|nuisance| nuisance.name == SURFACE) {
        nuisance.value = 0.5 * (nuisance.min + nuisance.value);
    }
    Ok(Some(recording.remade(*prepared).with_raised_noise()))
}

/// A parameter estimated from the samples next to the contacts only, if they determine it.
fn next_to_contacts(tuned: &Tuned, problem: &Problem) -> Tuned {
    let parameters = problem.subjects()[tuned.object].simulator.parameters();
    let Some(i) = parameters.iter().position(|p| p.name == tuned.name) else { return tuned.clone() };
    let mine = problem.recordings().iter().filter(|r| r.object() == tuned.object && !r.held_out());
    let each: Vec<_> = mine.filter_map(|r| r.prepared().local[i]).collect();
    let Some(LocalEstimate { value, sd }) = LocalEstimate::mean(&each) else { return tuned.clone() };
    let half_width = NORMAL_95 * sd;
    let p = &parameters[i];
    let interval95 = ((value - half_width).max(p.min), (value + half_width).min(p.max));
    Tuned { value: value.clamp(p.min, p.max), interval95, ..tuned.clone() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::strategy::tests::{FRICTION, swings};
    use tunenet_core::testing::{Exact, Pendulum};

    #[test]
    fn a_name_of_few_recordings_is_left_open_with_the_next_plausible_candidate() {
        let answer = swings(&[(FRICTION, 0.2)], 3);
        assert_eq!((answer.verdict(), answer.names()), (Verdict::Named, vec!["viscous_friction"]));
        let next = answer.candidates.iter().filter(|c| c.excluded.is_none() && c.name != "viscous_friction");
        let next: Vec<&str> = next.map(|c| c.name.as_ref()).collect();
        let mut known = Exact::new(Pendulum).effects();
        let open = left_open(&known, &answer);
        assert_eq!((open.verdict(), open.names()), (Verdict::OneOf, vec!["viscous_friction", next[0]]));
        assert_eq!(open.effects()[0].alternatives, [next[0]]);
        for effect in known.iter_mut().filter(|effect| effect.name == next[0]) {
            effect.implausible = Some("it swings in air".into());
        }
        assert!(!left_open(&known, &answer).names().contains(&next[0]), "an implausible effect is not offered");
    }

    #[test]
    fn names_that_may_be_absent_say_nothing_of_the_whole() {
        let pendulum = Exact::new(Pendulum);
        assert!(pendulum.effects().iter().all(|effect| !effect.required()));
        assert!(pendulum.segmented().is_none(), "and what has no segments has no flights");
    }
}
