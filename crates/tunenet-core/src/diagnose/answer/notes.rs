//! What a person should know of a diagnosis besides its answer.

use crate::diagnose::Recording;
use crate::diagnose::answer::judgement::Judgement;
use crate::diagnose::answer::verdict::in_place_of;
use crate::diagnose::answer::{Tuned, Use};
use crate::diagnose::evidence::unmeasured::SILENT;
use crate::diagnose::hypothesis::context::{Context, Hypothesis};
use crate::diagnose::hypothesis::forward_selection::Selection;
use crate::diagnose::hypothesis::plausibility::{Exclusion, OutOfRange, implausible_reason, out_of_range};
use crate::diagnose::hypothesis::structure::SharedParameter;
use crate::diagnose::hypothesis::wording::words;
use crate::diagnose::judge::validation_doubt::Doubt;
use crate::findings;
use crate::observation::{Note, three_digits, with_decimals};

/// Where across its bounds a parameter is tried.
const ACROSS: [f64; 4] = [0.0, 0.02, 0.5, 0.9];

/// The least ratio of the residual to the noise (RMS) that is noted as an unknown remainder.
const REMAINS: f64 = 1.05;

/// What is to be noted of `judged`.
pub(in crate::diagnose) fn add_notes(judged: &Judgement, notes: &mut Vec<Note>) {
    if judged.practical {
        let times = judged.left / judged.floor.sqrt();
        let ratio = with_decimals(times, 1);
        if judged.context.evidence.discrepancy() {
            let text = format!(
                "unknown remainder: the residual is {ratio} times the noise (RMS), and no effect that is known explains it on held-out recordings"
            );
            // What is as large as the noise is no remainder.
            notes.extend((times >= REMAINS).then(|| Note::new(findings::REMAINDER_UNKNOWN, text, "")));
        } else {
            let text = format!("the residual is {ratio} times the noise (RMS); the effects remove most of the misfit");
            notes.push(Note::new(findings::ADEQUACY_PRACTICAL, text, ""));
        }
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
        let text = format!("the residual is autocorrelated (lag-1 {rho:.2}) and was prewhitened");
        notes.push(Note::new(findings::NOISE_AUTOCORRELATED, text, ""));
    }
    note_unidentifiable(&judged.context, judged.best(), notes);
    note_out_of_range(judged, notes);
    if let Some(random) = &judged.random_parameter {
        let text = format!(
            "`{}` differs between recordings, with a standard deviation of {}; the value is their mean",
            random.name,
            three_digits(random.sd)
        );
        notes.push(Note::new(findings::PARAMETER_DIFFERS, text, "keep the conditions the same, or say what differs"));
    }
    if judged.reports_effects() {
        note_less_plausible(&judged.context, &judged.found, judged.decision.margin, notes);
    }
}

/// Says which held-out recording disagrees with those that were fitted, from which nothing is missing.
pub(in crate::diagnose) fn note_contradiction(judged: &Judgement, uses: &[Use], notes: &mut Vec<Note>) {
    let Some((recording, ratio)) = judged.contradicts else { return };
    let text = format!(
        "{}, which is held out, disagrees with the recordings that were fitted: it leaves {} times as much",
        uses[recording].name,
        three_digits(ratio)
    );
    notes.push(Note::new(
        findings::RECORDINGS_ODD,
        text,
        "check its object, load, units and frame rate, or fit it too",
    ));
}

/// Says which effects explain more than the answer and are excluded by a coefficient, and which objects need a coefficient that
/// is not physical for them.
fn note_out_of_range(judged: &Judgement, notes: &mut Vec<Note>) {
    let Judgement { context, found, .. } = judged;
    let remedy = |found: &OutOfRange| match found.rests_on.as_slice() {
        [] => String::new(),
        settings => format!("check {} in the simulation file", settings.join(" and ")),
    };
    let rivals = found.selected.iter().filter_map(|selected| selected.excluded.as_ref());
    let mut said = Vec::new();
    for rival in rivals.chain(excluded_alone(context, found)) {
        if said.contains(&&rival.effect) {
            continue;
        }
        let text = format!("`{}` explains more than the answer, but {rival}", rival.effect);
        said.push(&rival.effect);
        notes.push(Note::new(findings::EFFECT_EXCLUDED, text, remedy(rival)));
    }
    if let Some(Doubt::UnphysicalAlone(own)) = &judged.decision.doubt {
        notes.push(Note::new(findings::EFFECT_OUT_OF_RANGE, format!("{own}, where it is fitted alone"), remedy(own)));
    }
    let several = context.subjects.len() > 1;
    for position in (0..judged.last().structure.effects.len()).filter(|_| several) {
        for odd in out_of_range(context, judged.last(), position).into_iter().flatten() {
            let text = format!("{}: {odd}", context.subjects[odd.object].name);
            notes.push(Note::new(findings::EFFECT_OUT_OF_RANGE, text, remedy(&odd)));
        }
    }
}

/// Where no effect was found: the one that explains most, if a coefficient excludes it.
fn excluded_alone<'b>(context: &Context, found: &'b Selection) -> Option<&'b OutOfRange> {
    let fitted = found.alone.iter().filter(|candidate| candidate.model.is_some());
    let best = fitted.max_by(|a, b| a.gain.total_cmp(&b.gain))?;
    match &best.excluded {
        Some(Exclusion::Implausible(coefficient)) if found.best.is_none() && best.gain > context.settings.margin => {
            Some(coefficient)
        }
        _ => None,
    }
}

/// Says which parameters of `model` the recordings do not determine: those on which they do not depend at all, and those
/// that they do not depend on near the value found, as friction once the body grips.
fn note_unidentifiable(context: &Context<'_>, model: &Hypothesis, notes: &mut Vec<Note>) {
    let silent = |column: &usize| !model.fit.covariance[(*column, *column)].is_finite();
    for column in (0..model.structure.shared.len()).filter(silent) {
        let parameter = &model.structure.shared[column].parameter;
        if model.structure.shared[column].effect.is_some() {
            continue;
        }
        let remedy = "bring a recording in which it matters";
        notes.push(if moves_something(context, model, column) {
            let (name, value) = (&parameter.name, with_decimals(model.fit.point.parameters[column], 3));
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

/// Says which parameters have an interval as wide as their bounds, or of a mechanism end on one, less those of `model` on which
/// the recordings do not depend at all: these are noted [already](note_unidentifiable).
pub(in crate::diagnose) fn note_undetermined(
    context: &Context<'_>,
    model: &Hypothesis,
    tuned: &[Tuned],
    notes: &mut Vec<Note>,
) {
    let silent = |one: &Tuned| {
        let is_same =
            |shared: &SharedParameter| shared.object.unwrap_or(0) == one.object && shared.parameter.name == one.name;
        let same = model.structure.shared.iter().enumerate().find(|(_, shared)| is_same(shared));
        same.is_some_and(|(column, _)| !model.fit.covariance[(column, column)].is_finite())
    };
    for one in tuned.iter().filter(|one| !silent(one)) {
        let parameters = context.subjects[one.object].simulator.parameters();
        let determined = one.is_determined(parameters);
        let mechanism = context.evidence.discrepancy();
        let own = parameters.iter().find(|parameter| mechanism && parameter.name == one.name);
        if let Some(bound) = own.and_then(|parameter| parameter.bound_reached(one.value)) {
            let text = format!("`{}` ends on its bound {bound}", one.name);
            let remedy =
                "widen the bound if it may lie beyond; otherwise check the units and what the simulation leaves out";
            notes.push(Note::new(findings::PARAMETER_AT_BOUND, text, remedy));
        } else if !determined {
            let (low, high) = one.interval95;
            let interval = format!("{} to {}", three_digits(low), three_digits(high));
            let text = format!(
                "the recordings do not determine `{}`: its interval is {interval}, as wide as its bounds",
                one.name
            );
            let remedy = "bring a recording in which it matters";
            notes.push(Note::new(findings::PARAMETER_NOT_IDENTIFIABLE, text, remedy));
        }
    }
}

/// Whether another value of the shared parameter of this column, within its bounds, would change anything that counts.
fn moves_something(context: &Context<'_>, model: &Hypothesis, column: usize) -> bool {
    let parameter = &model.structure.shared[column].parameter;
    ACROSS.iter().any(|share| {
        let mut point = model.fit.point.clone();
        point.parameters[column] = parameter.min + share * parameter.span();
        // What cannot be simulated is no less than a change.
        context.joint(&model.structure).residuals(&point, 1.0).map_or(true, |moved| {
            let both = moved.iter().flatten().zip(model.fit.residuals.iter().flatten());
            both.map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt() > SILENT
        })
    })
}

/// Says which effects explain the recordings as well as those found within `margin`, and why they are not offered.
fn note_less_plausible(context: &Context<'_>, found: &Selection, margin: f64, notes: &mut Vec<Note>) {
    for selected in &found.selected {
        let offered = in_place_of(context, selected, margin);
        let near = selected.others.iter().filter(|(other, gap)| *gap < margin && !offered.contains(other));
        for (other, why) in near.filter_map(|(other, _)| Some((*other, implausible_reason(context, *other)?))) {
            let name = &context.catalogue[other].name;
            let text = format!("`{name}` explains these recordings about as well, but {why}");
            notes.push(Note::new(
                findings::EFFECT_IMPLAUSIBLE,
                text,
                "set world.medium = \"other\" where it did not move in air",
            ));
        }
    }
}

/// Notes, for every recording, which share of its samples does not count, and why. A recording that was cut into several is
/// none of these.
pub(in crate::diagnose) fn note_excluded(context: &Context, given: &[Recording], uses: &mut [Use]) {
    let all = || context.recordings().iter().chain(&context.evidence.validation);
    for recording in all() {
        let alone = all().filter(|other| other.index == recording.index).count() == 1;
        let (resting, outliers) = (recording.resting, recording.outliers());
        if alone && resting + outliers > 0 {
            let left = recording.prepared.seen.len();
            let before = given[recording.index].seen.len().saturating_sub(left + resting);
            uses[recording.index].notes.push(excluded([before, resting, outliers], left));
        }
    }
}

/// What does not count: before the fit, after the motion, outliers among the samples that are left.
fn excluded([before, resting, outliers]: [usize; 3], left: usize) -> Note {
    let percent = |part: usize| {
        let percent = 100.0 * part as f64 / (before + resting + left).max(1) as f64;
        if percent < 1.0 { with_decimals(percent, 1) } else { with_decimals(percent, 0) }
    };
    let parts = [(before, "by the checks"), (resting, "after the end of the motion"), (outliers, "as outliers")];
    let parts: Vec<(usize, &str)> = parts.into_iter().filter(|(part, _)| *part > 0).collect();
    let why = match parts[..] {
        [(_, why)] => why.to_owned(),
        _ => parts.iter().map(|(part, why)| format!("{} % {why}", percent(*part))).collect::<Vec<_>>().join(", "),
    };
    let all = percent(before + resting + outliers);
    Note::new(findings::SAMPLES_EXCLUDED, format!("{all} % of the samples do not count: {why}"), "")
}

/// Notes recordings that are copies of one motion.
pub(in crate::diagnose) fn note_copies(context: &Context, notes: &mut Vec<Note>) {
    let mut indices: Vec<usize> = context.recordings().iter().map(|recording| recording.index).collect();
    indices.dedup();
    if indices.len() > 1 && context.evidence.shows_one_motion() {
        let words = words(context);
        let text = format!(
            "all {} recordings show the same {motion} and count as one: effects that one {motion} does not distinguish are \
             not distinguished by its repetition",
            indices.len(),
            motion = words.motion
        );
        notes.push(Note::new(findings::RECORDINGS_ALIKE, text, words.otherwise));
    }
}

#[cfg(test)]
mod tests {
    use super::excluded;

    #[test]
    fn what_does_not_count_is_said_with_its_share() {
        assert_eq!(excluded([0, 120, 0], 280).text, "30 % of the samples do not count: after the end of the motion");
        let text = excluded([0, 120, 4], 276).text;
        assert_eq!(text, "31 % of the samples do not count: 30 % after the end of the motion, 1 % as outliers");
        assert_eq!(
            excluded([50, 0, 2], 50).text,
            "52 % of the samples do not count: 50 % by the checks, 2 % as outliers"
        );
    }
}
