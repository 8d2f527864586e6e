//! Contacts only: the change of velocity along the surface, fitted from the samples right before and after each contact. Strategy for
//! recordings whose flights no effect explains, such as a video of an unknown camera.

use crate::findings;
use tunenet_core::Result;
use tunenet_core::diagnose::{
    Candidate, Conclusion, Explanation, GapOf, NamedEffect, NextExperiment, PreparedRecording, Problem, Settings,
    Strategy, Verdict,
};
use tunenet_core::observation::{Kind, Note};
use tunenet_core::simulator::{Effect, Phase, Preparation, Simulator, Text, measurement_effects};

use super::detrended_flights::detrend;
use super::flights_only::crowded;
use super::variants;
use crate::wording::WORDING;

/// What turns speed across the surface into speed along it.
const CAMERA_TILT: &str = "camera_tilt";
/// Straightening is not exact: what a flight loses changes how the next contact slips. Where what is left does not look like
/// noise, velocities are taken for so many times less certain, and evidence is so much weaker.
const WIDER: [f64; 3] = [1.0, 2.0, 3.0];
/// Fewer recordings leave a choice at most.
const FEWEST_RECORDINGS: usize = 3;

/// Contacts only, the flights de-trended and the spin at the start unknown. Explains nothing where no contact surely takes
/// speed along the surface, or where the camera could explain that as well.
pub struct ContactsOnly;

impl Strategy for ContactsOnly {
    /// Where the recordings as they are stay in doubt and their flights named nothing.
    fn applies(&self, problem: &Problem, so_far: &Explanation) -> bool {
        let whole = &so_far.diagnosis;
        let as_recorded = whole.gap.as_ref().is_none_or(|gap| gap.of == GapOf::Recordings);
        let adequate = whole.adequacy.iter().all(|test| test.passed);
        as_recorded && (crowded(problem, whole) || whole.verdict() == Verdict::Unknown || !adequate)
    }

    fn attempt(&self, problem: &Problem, _: &Explanation) -> Result<Option<Explanation>> {
        if problem.recordings().iter().any(|recording| recording.prepared().seen.kind() != Kind::Positions) {
            return Ok(None);
        }
        let Some(spinning) = variants(problem, |ball| ball.with_hidden_state_at_events()) else { return Ok(None) };
        let mut found = None;
        for wider in WIDER {
            found = of_contacts(problem, &spinning, wider)?;
            if found.is_some() {
                break;
            }
        }
        let Some((mut explained, used)) = found else { return Ok(None) };
        let answer = &mut explained.diagnosis;
        let kin = only_kin(answer.conclusion.clone(), &answer.candidates, problem.settings().margin);
        answer.conclusion = if used < FEWEST_RECORDINGS { left_open(kin, &answer.candidates) } else { kin };
        if used < FEWEST_RECORDINGS && answer.next_experiment.is_none() {
            answer.next_experiment = Some(NextExperiment { text: WORDING.add.into(), settings: Vec::new() });
        }
        answer.gap.iter_mut().for_each(|gap| gap.of = GapOf::Events);
        answer.notes.push(Note::new(
            findings::CONTACTS_ALONE,
            "the recordings as a whole are not explained, but their contacts surely take speed along the surface. They \
             were judged alone: each flight has a smooth acceleration of its own, and what that is stays open",
            "record several throws in varied directions to learn more of the flights",
        ));
        Ok(Some(explained))
    }
}

/// The explanation where flights are de-trended with velocities so many times less certain, and how many recordings it
/// rests on.
fn of_contacts(problem: &Problem, spinning: &[Box<dyn Simulator>], wider: f64) -> Result<Option<(Explanation, usize)>> {
    let (mut detrended, mut beyond_tilt) = (Vec::new(), 0.0);
    for recording in problem.recordings() {
        if let Some((made, beyond)) = detrended_recording(spinning, recording, problem.settings().seed, wider)? {
            detrended.push(made);
            beyond_tilt += beyond;
        }
    }
    let used = detrended.iter().filter(|recording| !recording.held_out()).count();
    // One of two recordings may not be chosen because it shows what the other does not.
    if used == 0 || detrended.len() < problem.recordings().len() {
        return Ok(None);
    }
    // A tilt does not explain changes to either side.
    let no_tilt = beyond_tilt > problem.settings().margin;
    let at_contact = |effect: &Effect| {
        let tilts = effect.mistaken_for.iter().any(|name| name == CAMERA_TILT);
        effect.phase == Phase::Event && !effect.random && !(no_tilt && tilts)
    };
    let settings = Settings { most_effects: 1, ..problem.settings().clone() };
    let Ok(explained) = problem.explain(spinning, detrended, &settings, &at_contact) else { return Ok(None) };
    let answer = &explained.diagnosis;
    let effects = answer.effects();
    let seen_so: Vec<Text> = measurement_effects(Kind::Positions).into_iter().map(|e| e.name).collect();
    let by_camera = effects.iter().any(|n| n.effect.mistaken_for.iter().any(|o| seen_so.contains(o)));
    Ok((!effects.is_empty() && !by_camera).then_some((explained, used)))
}

/// A recording whose flights are de-trended under the gravity of its scene, where that shows something, and what no tilt
/// explains of it.
fn detrended_recording(
    spinning: &[Box<dyn Simulator>],
    recording: &PreparedRecording,
    seed: u64,
    wider: f64,
) -> Result<Option<(PreparedRecording, f64)>> {
    let measured = recording.prepared();
    let segmentation = measured.segmentation.as_ref();
    let Some(gravity) = segmentation.and_then(|known| known.free_acceleration()).map(|a| -a) else { return Ok(None) };
    let Some(detrended) = detrend(&measured.seen, recording.events(), gravity, (seed, wider)) else {
        return Ok(None);
    };
    let Preparation::Usable(mut prepared) = spinning[recording.object()].prepare(&detrended.ideal)? else {
        return Ok(None);
    };
    // Contacts are known; they are not to be looked for again in what strays.
    let contacts = prepared.events.clone();
    let (Some(first), count) = (prepared.seen.clock().first().copied(), prepared.seen.len()) else { return Ok(None) };
    let begin = detrended.seen.clock().partition_point(|t| *t < first - 1e-9);
    let Ok(seen) = detrended.seen.slice(begin..(begin + count).min(detrended.seen.len())) else { return Ok(None) };
    prepared.seen = seen;
    let made = recording.remade(*prepared).with_events(contacts).with_noise(&detrended.noise);
    Ok(Some((made, detrended.beyond_tilt)))
}

/// One throw leaves what lies within ten times the usual margin. Here the alternatives are what acts at contacts only, so
/// beyond the usual margin only those are left that the catalogue says can be mistaken for the one named.
fn only_kin(conclusion: Conclusion, candidates: &[Candidate], margin: f64) -> Conclusion {
    let Conclusion::OneOf { mut effects, doubt, .. } = conclusion else { return conclusion };
    let near = |name: &str| candidates.iter().any(|c| c.name == name && c.delta < margin);
    for NamedEffect { effect, alternatives, .. } in &mut effects {
        alternatives.retain(|name| near(name) || effect.mistaken_for.contains(name));
    }
    Conclusion::OneOf { names: with_alternatives(&effects), effects, doubt }
}

/// Leaves another effect of contact that can be mistaken for the only one named.
fn left_open(conclusion: Conclusion, candidates: &[Candidate]) -> Conclusion {
    let (mut effects, doubt) = match conclusion {
        Conclusion::Named { effects } => (effects, None),
        Conclusion::OneOf { effects, doubt, .. } => (effects, doubt),
        nothing => return nothing,
    };
    for NamedEffect { effect, alternatives, .. } in effects.iter_mut().filter(|one| one.alternatives.is_empty()) {
        let kin = candidates.iter().find(|c| effect.mistaken_for.contains(&c.name));
        alternatives.extend(kin.map(|c| c.name.clone()));
    }
    Conclusion::OneOf { names: with_alternatives(&effects), effects, doubt }
}

/// Every effect, each with what could be in its place.
fn with_alternatives(effects: &[NamedEffect]) -> Vec<Text> {
    effects.iter().flat_map(|one| std::iter::once(&one.effect.name).chain(&one.alternatives)).cloned().collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::strategy::tests::{FRICTION, swings};
    use tunenet_core::diagnose::Doubt;

    /// A named effect with these alternatives, and the candidates at these distances from the best.
    fn with(alternatives: &[&'static str], deltas: &[(&'static str, f64)]) -> (NamedEffect, Vec<Candidate>) {
        let answer = swings(&[(FRICTION, 0.2)], 3);
        let mut named = answer.effects()[0].clone();
        named.effect.mistaken_for = vec!["rest_angle".into()];
        named.alternatives = alternatives.iter().copied().map(Text::from).collect();
        let candidate = |&(name, delta): &(&'static str, f64)| Candidate {
            name: name.into(),
            delta,
            ..answer.candidates[0].clone()
        };
        (named, deltas.iter().map(candidate).collect())
    }

    #[test]
    fn beyond_the_usual_margin_only_kin_is_left() {
        let (named, candidates) = with(&["rest_angle", "near", "far"], &[("near", 5.0), ("far", 50.0)]);
        let doubt = Some(Doubt::Unconfirmed);
        let before = Conclusion::OneOf { effects: vec![named.clone()], names: Vec::new(), doubt: doubt.clone() };
        let after = only_kin(before, &candidates, 6.0);
        assert_eq!(after.names(), ["viscous_friction", "rest_angle", "near"]);
        assert_eq!((after.doubt(), after.effects()[0].alternatives.len()), (doubt.as_ref(), 2));
        let lone = Conclusion::Named { effects: vec![named] };
        assert_eq!(only_kin(lone.clone(), &candidates, 6.0), lone, "a lone name has nothing in its place");
    }

    #[test]
    fn few_recordings_leave_kin_in_the_place_of_a_lone_name() {
        let (named, candidates) = with(&[], &[("other", 1.0), ("rest_angle", 90.0)]);
        let open = left_open(Conclusion::Named { effects: vec![named] }, &candidates);
        assert_eq!((open.verdict(), open.names()), (Verdict::OneOf, vec!["viscous_friction", "rest_angle"]));
        assert_eq!(left_open(Conclusion::None, &candidates), Conclusion::None);
    }
}
