//! What a person should know of a diagnosis beside its answer.

use crate::diagnose::answer::judgement::Judgement;
use crate::diagnose::answer::verdict::in_place_of;
use crate::diagnose::evidence::unmeasured::SILENT;
use crate::diagnose::hypothesis::context::{Context, Hypothesis};
use crate::diagnose::hypothesis::forward_selection::Selection;
use crate::diagnose::hypothesis::plausibility::implausible_reason;
use crate::diagnose::hypothesis::wording::words;
use crate::findings;
use crate::observation::{Note, with_decimals};

/// Where across its bounds a parameter is tried.
const ACROSS: [f64; 4] = [0.0, 0.02, 0.5, 0.9];

/// What is to be noted of `judged`.
pub(in crate::diagnose) fn add_notes(judged: &Judgement, notes: &mut Vec<Note>) {
    if judged.practical {
        notes.push(Note::new(
            findings::ADEQUACY_PRACTICAL,
            "a small discrepancy beyond noise remains; the effects remove most of the misfit",
            "",
        ));
    }
    if judged.events_open() {
        let words = words(&judged.context);
        notes.push(Note::new(
            findings::CONTACT_UNEXPLAINED,
            format!(
                "the {} are explained; the {} leave a discrepancy that no effect explains",
                words.segment[1], words.events
            ),
            words.vary,
        ));
    }
    if judged.lag1 != 0.0 {
        let rho = judged.lag1;
        let text = format!("noise is autocorrelated (lag-1 {rho:.2}); residuals were prewhitened");
        notes.push(Note::new(findings::NOISE_AUTOCORRELATED, text, ""));
    }
    note_unidentifiable(&judged.context, judged.best(), notes);
    if judged.reports_effects() {
        note_less_plausible(&judged.context, &judged.found, judged.decision.margin, notes);
    }
}

/// Says which parameters of `model` the recordings do not determine: those on which they do not depend at all, and those
/// that they do not depend on near the value found, as friction once the body grips.
fn note_unidentifiable(context: &Context<'_>, model: &Hypothesis, notes: &mut Vec<Note>) {
    let silent = |g: &usize| !model.fit.covariance[(*g, *g)].is_finite();
    for g in (0..model.structure.globals.len()).filter(silent) {
        let parameter = &model.structure.globals[g].parameter;
        if model.structure.globals[g].effect.is_some() {
            continue;
        }
        let remedy = "bring a recording in which it matters";
        notes.push(if moves_something(context, model, g) {
            let (name, value) = (&parameter.name, with_decimals(model.fit.point.parameters[g], 3));
            let text = format!("the recordings do not determine `{name}`: near {value} they do not depend on it");
            Note::new(findings::PARAMETER_NOT_IDENTIFIABLE, text, remedy)
        } else {
            Note::new(
                findings::PARAMETER_NO_EFFECT,
                format!("`{}` changes nothing in these recordings", parameter.name),
                remedy,
            )
        });
    }
}

/// Whether another value of shared parameter `g` within its bounds would change anything that counts.
fn moves_something(context: &Context<'_>, model: &Hypothesis, g: usize) -> bool {
    let parameter = &model.structure.globals[g].parameter;
    ACROSS.iter().any(|share| {
        let mut point = model.fit.point.clone();
        point.parameters[g] = parameter.min + share * parameter.span();
        // What cannot be simulated is no less than a change.
        context.joint(&model.structure).residuals(&point, 1.0).map_or(true, |moved| {
            let both = moved.iter().flatten().zip(model.fit.residuals.iter().flatten());
            both.map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt() > SILENT
        })
    })
}

/// Says which effects explain the recordings as well as those found within `margin`, and why they are not offered.
fn note_less_plausible(context: &Context<'_>, found: &Selection, margin: f64, notes: &mut Vec<Note>) {
    for place in &found.places {
        let offered = in_place_of(context, place, margin);
        let near = place.others.iter().filter(|(other, gap)| *gap < margin && !offered.contains(other));
        for (other, why) in near.filter_map(|(other, _)| Some((*other, implausible_reason(context, *other)?))) {
            let name = context.catalogue[other].name;
            let text = format!("`{name}` explains these recordings about as well, but {why}");
            notes.push(Note::new(
                findings::EFFECT_IMPLAUSIBLE,
                text,
                "set world.medium = \"other\" where it did not move in air",
            ));
        }
    }
}

/// Notes recordings that are copies of one motion.
pub(in crate::diagnose) fn note_copies(context: &Context, notes: &mut Vec<Note>) {
    let mut recordings: Vec<usize> = context.sets().iter().map(|set| set.recording).collect();
    recordings.dedup();
    if recordings.len() > 1 && context.evidence.shows_one_motion() {
        let words = words(context);
        let text = format!(
            "all {} recordings show the same {motion} and count as one: effects that one {motion} does not distinguish are \
             not distinguished by its repetition",
            recordings.len(),
            motion = words.motion
        );
        notes.push(Note::new(findings::RECORDINGS_ALIKE, text, words.otherwise));
    }
}
