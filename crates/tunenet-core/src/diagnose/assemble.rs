//! Putting the answer together.

use std::sync::atomic::Ordering;

use super::answer::{
    Candidate, Change, Diagnosis, Evidence, Explained, Fitted, Gap, GapOf, NamedEffect, NextExperiment, Test, Tuned,
    Use, Value, Verdict,
};
use super::by_object::by_object;
use super::decide::Decision;
use super::held_out::{HeldOut, rmse};
use super::intervals::{Intervals, NORMAL_95};
use super::search::{Found, Place};
use super::sets::Set;
use super::study::{Model, Study};
use super::unknown::describe;
use super::{Recording, experiment};
use crate::Result;
use crate::observation::Note;
use crate::simulator::Phase;

/// Everything judged, to be put together.
pub(super) struct Judged<'a> {
    /// Of the best candidates: the held-out residual of each alone over that without it.
    pub ratios: Vec<(usize, f64)>,
    pub decision: Decision,
    /// The mean square that noise alone leaves.
    pub floor: f64,
    pub found: Found<'a>,
    pub tests: Vec<Test>,
    pub before: Option<HeldOut>,
    pub after: Option<HeldOut>,
    pub control: Option<(&'static str, f64)>,
    pub held_out: Vec<Set>,
    pub uses: Vec<Use>,
    pub notes: Vec<Note>,
    /// Whether flights are explained, and contacts are not.
    pub open: bool,
    /// Whether recordings differ among themselves by more than their noise.
    pub differ: bool,
}

/// The answer.
pub(super) fn assemble(study: &Study, mut judged: Judged, recordings: &[Recording]) -> Result<Diagnosis> {
    let told = judged.told();
    let found = &judged.found;
    let last = if told { found.best.as_ref().unwrap_or(&found.base) } else { &found.base };
    let intervals = Intervals::new(study, last, judged.differ);
    if intervals.widened {
        judged.notes.push(Note::new(
            "intervals.widened",
            "the recordings differ among themselves by more than their noise; intervals are as wide as that scatter makes them",
            "",
        ));
    }
    let effects = if told {
        let places = found.places.iter().zip(&judged.decision.alternatives);
        places.map(|(place, alternatives)| named(study, last, &intervals, place, alternatives)).collect()
    } else {
        Vec::new()
    };
    let gap = gap(study, &judged, last)?;
    let (description, remains) = match judged.decision.verdict {
        Verdict::Unknown => {
            let (text, phase) = describe(study, found.best.as_ref().unwrap_or(&found.base))?;
            (Some(text), if judged.open { Some(Phase::Contact) } else { phase })
        }
        _ => (None, None),
    };
    Ok(Diagnosis {
        verdict: judged.decision.verdict,
        objects: by_object(study, &judged, last, &intervals),
        effects,
        candidates: candidates(study, found, &judged.ratios),
        gap: Some(gap),
        next_experiment: next(study, &judged)?,
        margin: judged.decision.margin,
        least_gain: study.settings.margin,
        doubt: judged.decision.doubt,
        description,
        remains,
        parameters: parameters(study, found, last, &intervals),
        explained: explained(study, &judged, last, recordings)?,
        names: judged.decision.names,
        adequacy: judged.tests,
        uses: judged.uses,
        notes: judged.notes,
        rollouts: study.rollouts.load(Ordering::Relaxed),
    })
}

impl Judged<'_> {
    /// Whether effects are told, be it with others in their place.
    fn told(&self) -> bool {
        matches!(self.decision.verdict, Verdict::Named | Verdict::OneOf)
    }
}

/// What to measure next.
fn next(study: &Study, judged: &Judged) -> Result<Option<NextExperiment>> {
    let plain = |text: &str| Some(NextExperiment { text: text.into(), settings: Vec::new() });
    Ok(match judged.decision.verdict {
        Verdict::OneOf => {
            experiment::next(study, &judged.found, &judged.decision.alternatives)?.or_else(|| plain(study.words().add))
        }
        Verdict::Unknown => plain(study.words().vary),
        _ => None,
    })
}

fn named(study: &Study, model: &Model, intervals: &Intervals, place: &Place, alternatives: &[usize]) -> NamedEffect {
    let entry = &study.catalogue[place.entry];
    let position = model.structure.effects.iter().position(|&e| e == place.entry);
    let mine = position.map_or_else(Vec::new, |p| model.structure.of_effect(p));
    let tilts: usize =
        study.sets.iter().map(|s| s.pull.iter().filter(|pull| Some(**pull) == study.chance).count()).sum();
    let found_chance = study.chance.map(|sd| (sd, tilts.max(1)));
    let coefficients = entry.of[0].coefficients.iter().enumerate().map(|(k, coefficient)| {
        let globals = &model.structure.globals;
        let places = mine.iter().copied().filter(|&g| globals[g].effect.is_some_and(|e| e.1 == k));
        let values = places.map(|g| Value {
            object: globals[g].object,
            value: model.fit.point.globals[g],
            interval95: intervals.of(g),
        });
        let values = match &found_chance {
            Some((sd, count)) if entry.chance() => {
                // The relative standard deviation of a spread estimated from so many draws.
                let reach = NORMAL_95 * sd / (2.0 * *count as f64).sqrt();
                vec![Value { object: None, value: *sd, interval95: ((sd - reach).max(0.0), sd + reach) }]
            }
            _ => values.collect(),
        };
        Fitted { key: coefficient.key, unit: coefficient.unit, values }
    });
    // What acts along an axis that was not measured has no value.
    let coefficients = coefficients.filter(|fitted| !fitted.values.is_empty());
    let next = place.others.first();
    NamedEffect {
        effect: entry.of[0].clone(),
        coefficients: coefficients.collect(),
        evidence: Evidence {
            bic_gain: place.gain,
            runner_up: next.map(|(other, _)| study.catalogue[*other].name),
            runner_up_bic_gap: next.map_or(f64::INFINITY, |(_, gap)| *gap),
            p_value: place.p_value,
        },
        alternatives: alternatives.iter().map(|&other| study.catalogue[other].name).collect(),
    }
}

fn candidates(study: &Study, found: &Found, ratios: &[(usize, f64)]) -> Vec<Candidate> {
    let best = found.alone.iter().filter(|t| t.excluded.is_none()).map(|t| t.gain).fold(f64::NEG_INFINITY, f64::max);
    let each = found.alone.iter().map(|t| Candidate {
        name: study.catalogue[t.entry].name,
        bic_gain: t.gain,
        delta: best - t.gain,
        fitted: t.model.is_some(),
        held_out_ratio: ratios.iter().find(|(entry, _)| *entry == t.entry).map(|(_, ratio)| *ratio),
        excluded: t.excluded.clone(),
    });
    each.collect()
}

fn gap(study: &Study, judged: &Judged, last: &Model) -> Result<Gap> {
    let found = &judged.found;
    let error = |model: &Model| -> Result<f64> {
        let plain = study.joint(&model.structure).plain_residuals(&model.fit.point)?;
        Ok(rmse(&study.sets, &plain, 0.0))
    };
    let told = !std::ptr::eq(last, &raw const found.base);
    let pair = |of: fn(&HeldOut) -> f64| {
        let (before, after) = (judged.before.as_ref()?, judged.after.as_ref()?);
        Some(Change { before: of(before), after: if told { of(after) } else { of(before) } })
    };
    Ok(Gap {
        unit: study.subjects[0].simulator.channels()[0].unit.clone(),
        of: GapOf::Recordings,
        before: error(&found.base)?,
        after: error(last)?,
        noise_floor: judged.floor.sqrt(),
        held_out: pair(|h| h.rmse),
        control: judged.control,
        forecast: pair(|h| h.forecast),
    })
}

fn parameters(study: &Study, found: &Found, last: &Model, intervals: &Intervals) -> Vec<Tuned> {
    let own = last.structure.globals.iter().enumerate().filter(|(_, g)| g.effect.is_none());
    own.map(|(g, global)| {
        let object = global.object.unwrap_or(0);
        let given = study.subjects[object].simulator.parameters().iter().find(|p| p.name == global.parameter.name);
        Tuned {
            object,
            name: global.parameter.name.clone(),
            unit: global.parameter.unit.clone(),
            given: given.map_or(global.parameter.value, |p| p.value),
            before: found.base.fit.point.globals[g],
            value: last.fit.point.globals[g],
            interval95: intervals.of(g),
        }
    })
    .collect()
}

fn explained(study: &Study, judged: &Judged, last: &Model, recordings: &[Recording]) -> Result<Vec<Explained>> {
    let told = judged.told();
    let one = |set: &Set, before: &[f64], after: &[f64], own: &[f64]| Explained {
        recording: set.recording,
        name: recordings[set.recording].name.clone(),
        flight: None,
        held_out: set.held_out,
        seen: set.prepared.seen.clone(),
        kept: set.keep.clone(),
        before: before.to_vec(),
        after: after.to_vec(),
        noise: set.noise.clone(),
        contacts: set.contacts.clone(),
        own: set.prepared.own.iter().zip(own).map(|(p, v)| (p.name.clone(), *v, p.unit.clone())).collect(),
    };
    let (before, after) = (study.weighted(&judged.found.base)?, study.weighted(last)?);
    let mut all: Vec<Explained> =
        (0..study.sets.len()).map(|d| one(&study.sets[d], &before[d], &after[d], &last.fit.point.own[d])).collect();
    if let (Some(before), Some(after)) = (&judged.before, &judged.after) {
        let after = if told { after } else { before };
        for (d, set) in judged.held_out.iter().enumerate() {
            all.push(one(set, &before.residuals[d], &after.residuals[d], &after.own[d]));
        }
    }
    all.sort_by_key(|e| e.recording);
    Ok(all)
}
