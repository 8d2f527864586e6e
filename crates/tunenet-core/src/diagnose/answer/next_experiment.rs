//! Next experiment, maximin T-optimal (Atkinson and Fedorov 1975): where the confusable effects differ most.

use crate::Result;
use crate::diagnose::answer::verdict::unique;
use crate::diagnose::answer::{NextExperiment, driven_experiment};
use crate::diagnose::evidence::proposed::{Change, Proposed, proposed};
use crate::diagnose::evidence::recording::PreparedRecording;
use crate::diagnose::hypothesis::confusable_set::exact_twins;
use crate::diagnose::hypothesis::context::{Context, Hypothesis};
use crate::diagnose::hypothesis::forward_selection::{SelectedEffect, Selection};
use crate::diagnose::hypothesis::joint::{Joint, Point, Which};
use crate::diagnose::hypothesis::wording::{is_segmented, words};
use crate::estimate::jacobian::Columns;
use crate::estimate::projection::{Projector, orthonormal, stack};
use crate::simulator::Text;
use crate::statistics::dot;

/// Two explanations whose expected logarithmic likelihoods differ by less than this stay together: the usual margin of 6
/// in the information criterion.
const SEPARATED: f64 = 3.0;

/// The experiment that separates what is left together: for each effect of the best structure, `alternatives` are what
/// could be in its place.
pub(in crate::diagnose) fn next(
    context: &Context,
    found: &Selection,
    alternatives: &[Vec<usize>],
) -> Result<Option<NextExperiment>> {
    let Some(best) = &found.best else { return Ok(None) };
    let (twins, rest) = without_twins(context, found, best, alternatives);
    let open = found.selected.iter().zip(&rest).find(|(_, others)| !others.is_empty());
    if let (None, Some(text)) = (open, &twins) {
        return Ok(Some(NextExperiment { text: text.clone(), settings: Vec::new() }));
    }
    let found = distinguishing(context, found, best, open)?;
    Ok(found.map(|next| match twins {
        Some(text) => NextExperiment { text: format!("{}; {text}", next.text), ..next },
        None => next,
    }))
}

/// What is left in the place of each effect without its exact twins, and what is to be said of these, where there are any.
fn without_twins(
    context: &Context,
    found: &Selection,
    best: &Hypothesis,
    alternatives: &[Vec<usize>],
) -> (Option<String>, Vec<Vec<usize>>) {
    let name = |entry: usize| context.catalogue[entry].name.as_ref();
    let mut said = Vec::new();
    let mut rest = Vec::with_capacity(alternatives.len());
    for (selected, others) in found.selected.iter().zip(alternatives) {
        let twins = exact_twins(context, best, selected.entry);
        let alike: Vec<&(usize, &Text)> = twins.iter().filter(|(twin, _)| others.contains(twin)).collect();
        if !alike.is_empty() {
            let names: Vec<&str> = alike.iter().map(|(twin, _)| name(*twin)).collect();
            let ways = unique(alike.iter().map(|(_, way)| way.as_ref()).collect());
            let (own, names, ways) = (name(selected.entry), names.join(", "), ways.join(", or "));
            said.push(format!("no recording of these channels distinguishes {own} from {names}: {ways}"));
        }
        rest.push(others.iter().copied().filter(|other| alike.iter().all(|(twin, _)| twin != other)).collect());
    }
    ((!said.is_empty()).then(|| said.join("; ")), rest)
}

/// The experiment that separates an effect of `best` from what else could be in its place; without such an effect, the one that
/// shows more.
fn distinguishing(
    context: &Context,
    found: &Selection,
    best: &Hypothesis,
    open: Option<(&SelectedEffect, &Vec<usize>)>,
) -> Result<Option<NextExperiment>> {
    let name = |entry: usize| context.catalogue[entry].name.as_ref();
    let Some((selected, others)) = open else {
        // Nothing else explains anything: what is in no catalogue is all that could be in its place.
        let words = words(context);
        let known = found.selected.iter().filter_map(|selected| (words.knowledge)(name(selected.entry)));
        let known = unique(known.collect());
        let text = std::iter::once(words.add).chain(known).collect::<Vec<_>>().join("; or ");
        return Ok(Some(NextExperiment { text, settings: Vec::new() }));
    };
    if context.evidence.driven() {
        return driven_experiment::next(context, best, selected.entry, others).map(Some);
    }
    let designs = designs(context, best)?;
    let is_random = |entry: usize| context.catalogue[entry].is_random_effect();
    let gaps = if is_random(selected.entry) || others.iter().any(|&other| is_random(other)) {
        // A random effect has new draws at every event, whatever the motion, and a steady effect does not: the more events along
        // a new direction, the better.
        designs.iter().map(|design| vec![across(design); others.len()]).collect()
    } else {
        gaps(context, best, selected.entry, others, &designs)?
    };
    // What some motion separates at all; the rest are twins in any of them.
    let separable: Vec<usize> =
        (0..others.len()).filter(|&b| gaps.iter().any(|design| design[b] > SEPARATED)).collect();
    let twins: Vec<&str> = (0..others.len()).filter(|b| !separable.contains(b)).map(|b| name(others[b])).collect();
    let least = |design: &[f64]| separable.iter().map(|&b| design[b]).fold(f64::INFINITY, f64::min);
    let chosen = (0..designs.len()).max_by(|&a, &b| least(&gaps[a]).total_cmp(&least(&gaps[b])));
    let mut text = String::new();
    let mut settings = Vec::new();
    if let (Some(chosen), false) = (chosen, separable.is_empty()) {
        let how = designs[chosen].change.words();
        settings = designs[chosen].change.settings();
        let distinguished: Vec<&str> = separable.iter().map(|&b| name(others[b])).collect();
        text = format!(
            "{how} and add that recording: it distinguishes {} from {} (expected gain {})",
            name(selected.entry),
            distinguished.join(", "),
            gain(2.0 * least(&gaps[chosen]))
        );
    }
    if !twins.is_empty() {
        let words = words(context);
        let known: Vec<&str> =
            std::iter::once(name(selected.entry)).chain(twins.iter().copied()).filter_map(words.knowledge).collect();
        let unique = unique(known);
        // Of anything else, what no proposal separates may come apart in recordings that nobody here thinks of.
        if !is_segmented(context) {
            let alike = (!designs.is_empty()).then(|| {
                let rest = twins.join(", ");
                format!(
                    "no other input or initial state distinguishes {} from {rest}: do they do the same?",
                    name(selected.entry)
                )
            });
            let add = alike.is_none().then_some(words.add);
            let first = (!text.is_empty()).then_some(text.as_str()).or(add).into_iter();
            let text = first.chain(alike.as_deref()).chain(unique).collect::<Vec<_>>().join("; or ");
            return Ok(Some(NextExperiment { text, settings }));
        }
        let also = if text.is_empty() { "" } else { "; " };
        let rest = twins.join(", ");
        let (own, ways) = (name(selected.entry), unique.join(", or "));
        text = format!("{text}{also}{} {own} from {rest}: {ways}", words.inseparable);
    }
    Ok((!text.is_empty()).then_some(NextExperiment { text, settings }))
}

/// The speed along the surface with which a design starts, in units in which 1 m/s separates.
fn across(design: &Proposed) -> f64 {
    match design.change {
        Change::Proposed { tangential_m_s, .. } => SEPARATED * tangential_m_s,
        _ => 0.0,
    }
}

/// Recordings that could be made, as the best model predicts them; the first recording lends clock and noise.
fn designs(context: &Context, best: &Hypothesis) -> Result<Vec<Proposed>> {
    let recording = &context.recordings()[0];
    let parameters = best.structure.parameters(recording.object, &best.fit.point.parameters);
    let point = (parameters.as_slice(), best.fit.point.nuisances[0].as_slice());
    proposed(recording, best.structure.simulator(recording.object), point, &context.rollouts)
}

/// For each design and each other explanation: the expected difference of logarithmic likelihood, half the square of what
/// the best effect does that parameters, start states and the other effect cannot do instead, over all recordings and the
/// new one.
fn gaps(
    context: &Context,
    best: &Hypothesis,
    entry: usize,
    others: &[usize],
    designs: &[Proposed],
) -> Result<Vec<Vec<f64>>> {
    let effects: Vec<usize> = best.structure.effects.iter().copied().chain(others.iter().copied()).collect();
    let structure = context.structure(&effects)?;
    let parameters = structure.carry(&best.structure, &best.fit.point.parameters);
    let columns = |recordings: &[PreparedRecording], nuisances: Vec<Vec<f64>>| -> Result<(Vec<Columns>, Vec<usize>)> {
        let joint = Joint { structure: &structure, recordings, separable: false, rollouts: &context.rollouts };
        let point = Point { parameters: parameters.clone(), nuisances };
        let residuals = joint.residuals(&point, 1.0)?;
        let lengths = residuals.iter().map(Vec::len).collect();
        Ok((joint.columns(&point, &residuals, Which::ALL), lengths))
    };
    let (known, lengths) = columns(context.recordings(), best.fit.point.nuisances.clone())?;
    let of = |entry: usize| -> Vec<usize> {
        effects.iter().position(|&e| e == entry).map_or_else(Vec::new, |position| structure.of_effect(position))
    };
    let (mine, rivals) = (of(entry), others.iter().map(|&o| of(o)).collect::<Vec<_>>());
    let kept_columns = |all: &[Columns], wanted: &dyn Fn(usize) -> bool| -> Vec<Columns> {
        all.iter()
            .map(|one| {
                let kept: Vec<usize> = (0..one.indices.len()).filter(|&i| wanted(one.indices[i])).collect();
                Columns {
                    indices: kept.iter().map(|&i| one.indices[i]).collect(),
                    shared: kept.iter().map(|&i| one.shared[i].clone()).collect(),
                    nuisances: one.nuisances.clone(),
                }
            })
            .collect()
    };
    let mut all = Vec::new();
    for design in designs {
        let start = design.recording.prepared.nuisance_values();
        let Ok((new, new_lengths)) = columns(std::slice::from_ref(&design.recording), vec![start]) else {
            all.push(vec![0.0; others.len()]);
            continue;
        };
        let both: Vec<Columns> = known.iter().cloned().chain(new).collect();
        let lengths: Vec<usize> = lengths.iter().copied().chain(new_lengths).collect();
        let contested = |index: usize| mine.contains(&index) || rivals.iter().any(|r| r.contains(&index));
        let base = kept_columns(&both, &|index| !contested(index));
        let projector = Projector::new(&base, &lengths, structure.shared.len());
        let projected = |index: usize| {
            let mut column = stack(&both, &lengths, index);
            projector.project(&mut column);
            column
        };
        let mut effect = vec![0.0; lengths.iter().sum()];
        for &index in &mine {
            let size = parameters[index] - structure.shared[index].absent.map_or(0.0, |a| a.0);
            effect.iter_mut().zip(projected(index)).for_each(|(e, c)| *e += size * c);
        }
        let each = rivals.iter().map(|rival| {
            let span = orthonormal(rival.iter().map(|&index| projected(index)).collect());
            let taken: f64 = span.iter().map(|direction| dot(direction, &effect).powi(2)).sum();
            0.5 * (dot(&effect, &effect) - taken).max(0.0)
        });
        all.push(each.collect());
    }
    Ok(all)
}

/// Beyond this, a greater gain says nothing more.
const CLEAR_GAIN: f64 = 1000.0;

fn gain(value: f64) -> String {
    if value > CLEAR_GAIN { format!("above {CLEAR_GAIN}") } else { format!("{value:.0}") }
}
