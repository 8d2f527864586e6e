//! The diagnosis put together from a judgement.

use crate::Result;
use crate::diagnose::answer::driven_experiment;
use crate::diagnose::answer::intervals::Intervals;
use crate::diagnose::answer::judgement::{Judgement, root_mean_square};
use crate::diagnose::answer::next_experiment;
use crate::diagnose::answer::notes::{note_excluded, note_undetermined};
use crate::diagnose::answer::per_object::{Spared, by_object, gaps, without_unneeded};
use crate::diagnose::answer::residual_description::describe;
use crate::diagnose::answer::{
    Candidate, Change, Conclusion, Diagnosis, Evidence, Explained, Fitted, Gap, GapOf, NamedEffect, NextExperiment,
    Tuned, Use, Value, Verdict,
};
use crate::diagnose::evidence::recording::PreparedRecording;
use crate::diagnose::hypothesis::context::{Context, EventEffects, Hypothesis};
use crate::diagnose::hypothesis::forward_selection::{SelectedEffect, Selection};
use crate::diagnose::hypothesis::wording::words;
use crate::diagnose::judge::held_out_proof::HeldOut;
use crate::diagnose::judge::validation_doubt::Doubt;
use crate::diagnose::{Recording, Subject};
use crate::estimate::{Point, RolloutLog};
use crate::findings;
use crate::observation::{Note, gap_unit};
use crate::simulator::{Parameter, Phase, Preparation, Prepared};
use crate::statistics::NORMAL_95;
use crate::tune::{estimates_near, note_tied, tied_near};

/// The answer of what was judged.
pub(in crate::diagnose) fn assemble(
    judged: &Judgement,
    given: &[Recording],
    mut uses: Vec<Use>,
    mut notes: Vec<Note>,
) -> Result<Diagnosis> {
    let Judgement { context, found, decision, .. } = judged;
    let last = judged.last();
    let intervals = Intervals::new(context, last, judged.heterogeneous)?;
    if intervals.widened {
        notes.push(Note::new(
            findings::INTERVALS_WIDENED,
            "recordings differ by more than their noise; intervals follow from that scatter",
            "",
        ));
    }
    note_excluded(context, given, &mut uses);
    let mut objects = by_object(judged, &intervals);
    let spared = without_unneeded(judged, &mut objects)?;
    let narrower = spared.as_ref().map(|one| Intervals::new(&one.context, &one.model, judged.heterogeneous));
    let narrower = narrower.transpose()?;
    let numbers = Numbers { model: last, intervals: &intervals, spared: narrower.as_ref() };
    let explained = explained(judged, spared.as_ref(), given)?;
    let parameters = as_tuned(judged, given, parameters(context, found, &numbers))?;
    note_undetermined(context, judged.best(), &parameters, &mut notes);
    let tied = tied(judged)?;
    notes.extend(tied.iter().map(|group| note_tied(group)));
    Ok(Diagnosis {
        conclusion: conclusion(judged, &numbers)?,
        objects,
        candidates: candidates(context, found, &judged.control.ratios),
        gap: Some(gap(judged, spared.as_ref())?),
        gaps: gaps(&explained),
        next_experiment: next(judged, &mut notes)?,
        margin: decision.margin,
        least_gain: context.settings.margin,
        parameters,
        tied,
        explained,
        adequacy: judged.tests.clone(),
        uses,
        notes,
        rollouts: context.rollouts.count(),
    })
}

/// Shared parameters of the answer with their intervals.
struct Numbers<'a> {
    model: &'a Hypothesis<'a>,
    intervals: &'a Intervals<'a>,
    /// Those of the hypothesis without what objects do not need.
    spared: Option<&'a Intervals<'a>>,
}

impl Numbers<'_> {
    /// The shared parameter of this column and its interval: of the hypothesis without what objects do not need, where that has it.
    fn of(&self, column: usize) -> (f64, (f64, f64)) {
        let shared = &self.model.structure.shared[column];
        let found = self.spared.and_then(|spared| spared.number(shared.object, &shared.parameter.name));
        found.unwrap_or_else(|| (self.model.fit.point.parameters[column], self.intervals.of(column)))
    }
}

/// The verdict with what belongs to it.
fn conclusion(judged: &Judgement, numbers: &Numbers) -> Result<Conclusion> {
    let Judgement { context, found, decision, .. } = judged;
    let effects = || {
        let each = found.selected.iter().zip(&decision.alternatives).zip(&decision.distinct);
        each.map(|((selected, near), distinct)| named(context, numbers, selected, (near, *distinct))).collect()
    };
    Ok(match decision.verdict {
        Verdict::None => Conclusion::None,
        Verdict::Named => Conclusion::Named { effects: effects() },
        Verdict::OneOf => {
            Conclusion::OneOf { effects: effects(), names: decision.names.clone(), doubt: decision.doubt.clone() }
        }
        Verdict::Unknown => {
            let (description, phase) = if judged.contradicts.is_some() {
                // What is left of the recordings that were fitted is noise, which has no description.
                ("the recordings that were fitted are explained, and what is held out is not".to_owned(), None)
            } else {
                describe(context, judged.best())?
            };
            let remains = if judged.events_open() { Some(Phase::Event) } else { phase };
            Conclusion::Unknown { nearest: decision.names.clone(), description, remains }
        }
        Verdict::Insufficient => Conclusion::Insufficient,
    })
}

/// What to measure next, as far as the rollouts that are left allow; a quick diagnosis spends none on it.
fn next(judged: &Judgement, notes: &mut Vec<Note>) -> Result<Option<NextExperiment>> {
    let Context { settings, rollouts, .. } = &judged.context;
    let rest = if settings.quick { RolloutLog::new(Some(0), None, None).strict() } else { rollouts.remainder() };
    let found = next_within(judged, &Context { rollouts: rest.clone(), ..judged.context.clone() });
    rollouts.add(rest.count());
    if !rest.was_short() {
        return found;
    }
    if let Some(most) = settings.max_rollouts.filter(|_| !settings.quick) {
        let text = format!("the limit of {most} rollouts was reached before a next experiment was found");
        notes.push(Note::new(findings::ROLLOUTS_LIMIT, text, "allow more rollouts"));
    }
    Ok(None)
}

fn next_within(judged: &Judgement, context: &Context) -> Result<Option<NextExperiment>> {
    let plain = |text: &str| Some(NextExperiment { text: text.into(), settings: Vec::new() });
    Ok(match judged.decision.verdict {
        Verdict::OneOf => match check_settings(judged) {
            Some(text) => plain(&text),
            None => next_experiment::next(context, &judged.found, &judged.decision.alternatives)?
                .or_else(|| plain(words(context).add)),
        },
        Verdict::Unknown if context.evidence.driven() => Some(driven_experiment::vary(context, judged.best())?),
        Verdict::Unknown => plain(words(context).vary),
        _ => None,
    })
}

/// Which settings to check where an effect is excluded by what they say, and explains more than the answer.
fn check_settings(judged: &Judgement) -> Option<String> {
    let Some(Doubt::ExcludedExplainsMore(rival) | Doubt::UnphysicalAlone(rival)) = &judged.decision.doubt else {
        return None;
    };
    (!rival.rests_on.is_empty()).then(|| {
        let settings = rival.rests_on.join(" and ");
        format!("check {settings} in the simulation file: one of them is wrong if {} is the answer", rival.effect)
    })
}

fn named(
    context: &Context,
    numbers: &Numbers,
    selected: &SelectedEffect,
    (alternatives, is_distinct): (&[usize], bool),
) -> NamedEffect {
    let model = numbers.model;
    let entry = &context.catalogue[selected.entry];
    let position = model.structure.effects.iter().position(|&e| e == selected.entry);
    let mine = position.map_or_else(Vec::new, |p| model.structure.of_effect(p));
    let mut objects: Vec<Option<usize>> = mine.iter().map(|&column| model.structure.shared[column].object).collect();
    objects.sort_unstable();
    objects.dedup();
    let coefficients = entry.of[0].coefficients.iter().enumerate().map(|(k, coefficient)| {
        let shared = &model.structure.shared;
        let columns = mine.iter().copied().filter(|&column| shared[column].effect.is_some_and(|e| e.1 == k));
        let values = columns.map(|column| {
            let (value, interval95) = numbers.of(column);
            Value { object: shared[column].object, value, interval95 }
        });
        let values = match context.event_effects {
            Some(EventEffects { sd, count }) if entry.is_random_effect() => {
                // The relative standard deviation of a spread estimated from so many draws.
                let reach = NORMAL_95 * sd / (2.0 * count.max(1) as f64).sqrt();
                vec![Value { object: None, value: sd, interval95: ((sd - reach).max(0.0), sd + reach) }]
            }
            _ => values.collect(),
        };
        // Of a joint in which the effect cannot be seen, nothing is known.
        let values = if values.is_empty() && coefficient.number.is_some() {
            let unknown = (coefficient.min, coefficient.max);
            objects.iter().map(|&object| Value { object, value: coefficient.absent, interval95: unknown }).collect()
        } else {
            values
        };
        Fitted { key: coefficient.key.clone(), unit: coefficient.unit.clone(), values }
    });
    // What acts along an axis that was not measured has no value.
    let coefficients = coefficients.filter(|fitted| !fitted.values.is_empty());
    let next = selected.others.first();
    NamedEffect {
        effect: entry.of[0].clone(),
        coefficients: coefficients.collect(),
        evidence: Evidence {
            bic_gain: selected.gain,
            runner_up: next.map(|(other, _)| context.catalogue[*other].name.clone()),
            runner_up_bic_gap: next.map_or(f64::INFINITY, |(_, gap)| *gap),
            p_value: selected.p_value,
            is_distinct,
        },
        alternatives: alternatives.iter().map(|&other| context.catalogue[other].name.clone()).collect(),
    }
}

fn candidates(context: &Context, found: &Selection, ratios: &[(usize, f64)]) -> Vec<Candidate> {
    let best = found.alone.iter().filter(|c| c.excluded.is_none()).map(|c| c.gain).fold(f64::NEG_INFINITY, f64::max);
    let each = found.alone.iter().map(|c| Candidate {
        name: context.catalogue[c.entry].name.clone(),
        bic_gain: c.gain,
        delta: best - c.gain,
        fitted: c.model.as_ref().is_some_and(|model| !model.fit.abandoned),
        held_out_ratio: ratios.iter().find(|(entry, _)| *entry == c.entry).map(|(_, ratio)| *ratio),
        excluded: c.excluded.clone(),
    });
    each.collect()
}

fn gap(judged: &Judgement, spared: Option<&Spared>) -> Result<Gap> {
    let (context, found) = (&judged.context, &judged.found);
    let before = if found.best.is_some() { root_mean_square(context, &found.base)? } else { judged.left };
    let left = spared.map_or(judged.left, |one| one.left);
    let pair = |of: fn(&HeldOut) -> f64| {
        let after = spared.map_or(judged.after.as_ref(), |one| one.held_out.as_ref());
        let (before, after) = (judged.before.as_ref()?, after?);
        Some(Change { before: of(before), after: if judged.reports_effects() { of(after) } else { of(before) } })
    };
    Ok(Gap {
        unit: gap_unit(context.subjects[0].simulator.channels()).to_owned(),
        of: GapOf::Recordings,
        before,
        after: if judged.reports_effects() { left } else { before },
        noise_floor: judged.floor.sqrt(),
        held_out: pair(|h| h.rmse),
        control: judged.control.wrong.clone(),
        forecast: pair(|h| h.forecast),
    })
}

fn parameters(context: &Context, found: &Selection, numbers: &Numbers) -> Vec<Tuned> {
    let last = numbers.model;
    let tuned = last.structure.shared.iter().enumerate().filter(|(_, shared)| shared.effect.is_none());
    tuned
        .map(|(column, shared)| {
            let object = shared.object.unwrap_or(0);
            let given =
                context.subjects[object].simulator.parameters().iter().find(|p| p.name == shared.parameter.name);
            let (value, interval95) = numbers.of(column);
            Tuned {
                object,
                name: shared.parameter.name.clone(),
                unit: shared.parameter.unit.clone(),
                given: given.map_or(shared.parameter.value, |p| p.value),
                before: found.base.fit.point.parameters[column],
                value,
                interval95,
            }
        })
        .collect()
}

/// The parameters as [tuning](crate::tune) states them, where nothing is missing: then both answer the same question. Where the
/// tuning leaves more than noise, or a parameter is not determined, they stay as they are.
fn as_tuned(judged: &Judgement, given: &[Recording], mut parameters: Vec<Tuned>) -> Result<Vec<Tuned>> {
    let context = &judged.context;
    if judged.decision.verdict != Verdict::None || judged.random_parameter.is_some() {
        return Ok(parameters);
    }
    for (object, subject) in context.subjects.iter().enumerate() {
        let near = judged.found.base.structure.parameters(object, &judged.found.base.fit.point.parameters);
        let mut point = Point { parameters: near, nuisances: Vec::new() };
        let mut prepared = Vec::new();
        for (index, recording) in context.recordings().iter().enumerate().filter(|(_, r)| r.object == object) {
            let one = tuned_recording(subject, recording, given)?;
            let known = recording.prepared.nuisances.iter().zip(&judged.found.base.fit.point.nuisances[index]);
            let known: Vec<(&str, f64)> = known.map(|(p, value)| (p.name.as_str(), *value)).collect();
            let value = |p: &Parameter| known.iter().find(|(name, _)| *name == p.name).map_or(p.value, |(_, v)| *v);
            point.nuisances.push(one.nuisances.iter().map(value).collect());
            prepared.push(one);
        }
        if prepared.is_empty() {
            continue;
        }
        let rest = context.rollouts.remainder();
        let estimates = estimates_near(subject.simulator, prepared, &point, &rest);
        context.rollouts.add(rest.count());
        if rest.was_short() {
            // The curvature of the diagnosis's own fit does.
            continue;
        }
        for estimate in estimates?.into_iter().flatten().filter(|estimate| estimate.identified) {
            for tuned in parameters.iter_mut().filter(|t| t.object == object && t.name == estimate.name) {
                (tuned.before, tuned.value, tuned.interval95) = (estimate.value, estimate.value, estimate.interval95);
            }
        }
    }
    Ok(parameters)
}

/// Numbers that are tied in the answer, object by object; a quick diagnosis spends no rollouts on them.
fn tied(judged: &Judgement) -> Result<Vec<Vec<String>>> {
    let (context, last) = (&judged.context, judged.last());
    let mut all = Vec::new();
    for (object, subject) in context.subjects.iter().enumerate().filter(|_| !context.settings.quick) {
        let own = context.recordings().iter().enumerate().filter(|(_, r)| r.object == object);
        let (indices, recordings): (Vec<usize>, Vec<Prepared>) =
            own.map(|(index, r)| (index, r.prepared.clone())).unzip();
        if recordings.is_empty() || subject.simulator.effects().iter().all(|effect| effect.restates.is_empty()) {
            continue;
        }
        let parameters = last.structure.parameters(object, &last.fit.point.parameters);
        let nuisances = indices.iter().map(|&index| last.fit.point.nuisances[index].clone()).collect();
        let rest = context.rollouts.remainder();
        let point = Point { parameters, nuisances };
        let found = tied_near(last.structure.simulator(object), recordings, &point, &rest);
        context.rollouts.add(rest.count());
        if !rest.was_short() {
            all.extend(found?);
        }
    }
    Ok(all)
}

/// A recording as it is tuned to: with its end at rest, and with all that is free there. Of a driven one the end is held out.
fn tuned_recording(subject: &Subject, recording: &PreparedRecording, given: &[Recording]) -> Result<Prepared> {
    if !recording.driven()
        && let Preparation::Usable(prepared) = subject.simulator.prepare(given[recording.index].seen)?
    {
        return Ok(*prepared);
    }
    Ok(recording.prepared.clone())
}

fn explained(judged: &Judgement, spared: Option<&Spared>, given: &[Recording]) -> Result<Vec<Explained>> {
    let context = &judged.context;
    let last = spared.map_or_else(|| judged.last(), |one| &one.model);
    let held_out = spared.map_or(judged.after.as_ref(), |one| one.held_out.as_ref());
    let one = |recording: &PreparedRecording, before: &[f64], after: &[f64], nuisances: &[f64]| Explained {
        recording: recording.index,
        object: recording.object,
        name: given[recording.index].name.clone(),
        segment: None,
        held_out: recording.held_out,
        seen: recording.prepared.seen.clone(),
        kept: recording.keep.clone(),
        before: before.to_vec(),
        after: after.to_vec(),
        noise: recording.noise.clone(),
        measured_noise: recording.measured_noise.clone(),
        events: recording.events.clone(),
        nuisances: recording
            .prepared
            .nuisances
            .iter()
            .zip(nuisances)
            .map(|(p, v)| (p.name.clone(), *v, p.unit.clone()))
            .collect(),
    };
    let (before, after) = (context.weighted(&judged.found.base)?, context.weighted(last)?);
    let mut all: Vec<Explained> = (0..context.recordings().len())
        .map(|d| one(&context.recordings()[d], &before[d], &after[d], &last.fit.point.nuisances[d]))
        .collect();
    if let (Some(before), Some(after)) = (&judged.before, held_out) {
        let after = if judged.reports_effects() { after } else { before };
        for (index, recording) in context.evidence.validation.iter().enumerate() {
            all.push(one(recording, &before.residuals[index], &after.residuals[index], &after.nuisances[index]));
        }
    }
    all.sort_by_key(|e| e.recording);
    Ok(all)
}
