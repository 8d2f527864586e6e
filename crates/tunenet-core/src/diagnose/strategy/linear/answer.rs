//! The diagnosis in words and numbers.

use std::sync::atomic::Ordering;

use nalgebra::{DMatrix, DVector};

use super::certain::Further;
use super::choose::{Chosen, Stood};
use super::experiment;
use super::fit::{Fitted as Model, Normal};
use super::judge::Judged;
use super::logs::{Logs, Place};
use crate::Result;
use crate::diagnose::answer::{
    Candidate, Change, Diagnosis, Evidence, Explained, Fitted, Gap, GapOf, NamedEffect, NextExperiment, Tuned, Use,
    Value, Verdict,
};
use crate::diagnose::input::Settings;
use crate::findings;
use crate::observation::{Note, with_decimals};
use crate::statistics::{UPPER_95, dot, student_quantile};

/// Stretches of each recording whose disagreement says how sure the numbers are; see `tune`'s blocks.
const BLOCKS: usize = 15;

/// Where no recording can be used.
pub(super) fn insufficient(uses: Vec<Use>, notes: Vec<Note>) -> Diagnosis {
    Diagnosis {
        verdict: Verdict::Insufficient,
        objects: Vec::new(),
        effects: Vec::new(),
        names: Vec::new(),
        candidates: Vec::new(),
        gap: None,
        adequacy: Vec::new(),
        next_experiment: Some(NextExperiment {
            text: "mend what is said of each recording, or record half a minute or more in which every joint moves over its range, \
                   with positions and torques"
                .into(),
            settings: vec![("duration_s".into(), 30.0)],
        }),
        margin: 0.0,
        least_gain: 0.0,
        doubt: None,
        description: None,
        remains: None,
        parameters: Vec::new(),
        explained: Vec::new(),
        uses,
        notes,
        rollouts: 0,
    }
}

/// The whole answer.
pub(super) fn answer(
    logs: &Logs,
    chosen: &Chosen,
    further: Option<Further>,
    settings: &Settings,
    uses: Vec<Use>,
    mut notes: Vec<Note>,
) -> Result<Diagnosis> {
    let judged = logs.judge(chosen)?;
    let verdict = verdict(chosen, &judged, settings.margin);
    let reported = matches!(verdict, Verdict::Named | Verdict::OneOf);
    let last = if reported { &chosen.best } else { &chosen.base };
    let covariance = covariance(logs, last)?;
    let names = names(logs, chosen, verdict, settings.margin);
    if reported && !judged.adequate {
        let text = "something is left beyond noise; the effects take the larger part away, on the stretches that were not \
                    fitted as well";
        notes.push(Note::new(findings::ADEQUACY_PRACTICAL, text, ""));
    }
    let effects: Vec<NamedEffect> = if reported {
        chosen.effects.iter().map(|s| named(logs, last, &covariance, s, settings.margin)).collect()
    } else {
        Vec::new()
    };
    let held_out = match (logs.rmse(&chosen.base.point, true)?, logs.rmse(&last.point, true)?) {
        (Some(before), Some(after)) => Some(Change { before, after }),
        _ => None,
    };
    let gap = Gap {
        unit: logs.simulators[0].channels()[0].unit.clone(),
        of: GapOf::Recordings,
        before: logs.rmse(&chosen.base.point, false)?.unwrap_or(0.0),
        after: logs.rmse(&last.point, false)?.unwrap_or(0.0),
        noise_floor: logs.noise_floor(false),
        held_out,
        control: control(logs, chosen, reported)?,
        forecast: None,
    };
    let description = (verdict == Verdict::Unknown).then(|| describe(logs, &chosen.best)).transpose()?;
    let mut next_experiment = experiment::next(logs, chosen, verdict, &names, settings.margin)?;
    if let Some(further) = further {
        notes.push(further.note);
        next_experiment = next_experiment.or(further.experiment);
    }
    Ok(Diagnosis {
        verdict,
        objects: Vec::new(),
        next_experiment,
        names,
        effects,
        candidates: candidates(logs, chosen)?,
        gap: Some(gap),
        adequacy: judged.tests,
        margin: settings.margin,
        least_gain: settings.margin,
        doubt: None,
        description,
        remains: None,
        parameters: parameters(logs, &chosen.base, last, &covariance),
        explained: explained(logs, &chosen.base, last)?,
        uses,
        notes,
        rollouts: logs.rollouts.load(Ordering::Relaxed),
    })
}

fn verdict(chosen: &Chosen, judged: &Judged, margin: f64) -> Verdict {
    match (chosen.effects.is_empty(), judged.adequate || judged.practical) {
        (true, true) => Verdict::None,
        (_, false) => Verdict::Unknown,
        (false, true) if !chosen.effects.iter().any(|s| s.doubtful(margin)) => Verdict::Named,
        (false, true) => Verdict::OneOf,
    }
}

fn names(logs: &Logs, chosen: &Chosen, verdict: Verdict, margin: f64) -> Vec<&'static str> {
    let name = |entry: usize| logs.entries[entry].effect.name;
    let mut all: Vec<&'static str> = Vec::new();
    match verdict {
        Verdict::Named => all.extend(chosen.effects.iter().map(|s| name(s.entry))),
        Verdict::OneOf => {
            for stood in &chosen.effects {
                all.push(name(stood.entry));
                all.extend(stood.near(margin).map(name));
            }
        }
        Verdict::Unknown => {
            all.extend(
                chosen.alone.iter().filter(|t| t.excluded.is_none() && t.gain > 0.0).map(|t| name(t.entry)).take(3),
            );
        }
        Verdict::None | Verdict::Insufficient => {}
    }
    let mut seen = Vec::new();
    all.retain(|n| {
        !seen.contains(n) && {
            seen.push(*n);
            true
        }
    });
    all
}

/// Covariance of what is free in `model`, from the disagreement of stretches, at least that of noise as it is weighed; and the
/// quantile that makes a 95 % interval of it.
struct Covariance {
    matrix: DMatrix<f64>,
    active: Vec<Place>,
    quantile: f64,
}

impl Covariance {
    fn interval(&self, place: Place, value: f64, bounds: (f64, f64)) -> (f64, f64) {
        let Some(i) = self.active.iter().position(|p| *p == place) else { return (value, value) };
        let half = self.quantile * self.matrix[(i, i)].max(0.0).sqrt();
        ((value - half).max(bounds.0), (value + half).min(bounds.1))
    }
}

fn covariance(logs: &Logs, model: &Model) -> Result<Covariance> {
    let columns = logs.columns(&model.point, &model.active)?;
    let normal = Normal::new(&model.active, &columns, &model.residuals);
    let n = model.active.len();
    let inverse = normal.inverse(&(0..n).collect::<Vec<_>>());
    let (mut between, mut stretches, mut offset) = (DMatrix::zeros(n, n), 0, 0);
    for run in logs.fitted() {
        let (width, samples) = (run.width(), run.prepared.seen.len());
        let blocks = BLOCKS.min(samples);
        for b in 0..blocks {
            let range = offset + b * samples / blocks * width..offset + (b + 1) * samples / blocks * width;
            let pull = DVector::from_fn(n, |i, _| dot(&columns[i][range.clone()], &model.residuals[range.clone()]));
            between += &pull * pull.transpose();
        }
        stretches += blocks;
        offset += samples * width;
    }
    let values = logs.count() as f64;
    let naive = &inverse * (model.square / (values - n as f64).max(1.0));
    // Few stretches say little of many numbers at once; of each number alone, with one lost, they do.
    let robust = &inverse * between * &inverse * (stretches as f64 / (stretches as f64 - 1.0).max(1.0));
    let mut matrix =
        DMatrix::from_fn(n, n, |i, j| if i == j { robust[(i, i)].max(naive[(i, i)]) } else { naive[(i, j)] });
    // A value that stays and is not exact, a calibrated gain say, moves what is fitted beside it.
    for (place, sd) in logs.carried() {
        let column = logs.columns(&model.point, &[place])?;
        let pull = DVector::from_fn(n, |i, _| dot(&columns[i], &column[0]) * sd);
        let moved = &inverse * pull;
        matrix += &moved * moved.transpose();
    }
    let freedom = (stretches as f64 - 1.0).max(1.0);
    let quantile = student_quantile(UPPER_95, freedom);
    Ok(Covariance { matrix, active: model.active.clone(), quantile })
}

fn named(logs: &Logs, model: &Model, covariance: &Covariance, stood: &Stood, margin: f64) -> NamedEffect {
    let entry = &logs.entries[stood.entry];
    let coefficients = entry.effect.coefficients.iter().enumerate().map(|(k, coefficient)| {
        let value = |object: usize| {
            let place = (object, entry.first + k);
            let value = model.point[object][entry.first + k];
            let interval95 = covariance.interval(place, value, (coefficient.min, coefficient.max));
            Value { object: Some(object), value, interval95 }
        };
        Fitted { key: coefficient.key, unit: coefficient.unit, values: logs.objects().into_iter().map(value).collect() }
    });
    let runner_up = stood.others.first();
    let evidence = Evidence {
        bic_gain: stood.gain,
        runner_up: runner_up.map(|(e, _)| logs.entries[*e].effect.name),
        runner_up_bic_gap: runner_up.map_or(f64::INFINITY, |(_, behind)| *behind),
        p_value: stood.p_value,
    };
    NamedEffect {
        coefficients: coefficients.collect(),
        effect: entry.effect.clone(),
        evidence,
        alternatives: stood.near(margin).map(|e| logs.entries[e].effect.name).collect(),
    }
}

fn candidates(logs: &Logs, chosen: &Chosen) -> Result<Vec<Candidate>> {
    let best = chosen.alone.iter().find(|t| t.excluded.is_none()).map_or(0.0, |t| t.gain);
    let before = logs.rmse(&chosen.base.point, true)?;
    chosen
        .alone
        .iter()
        .map(|trial| {
            let unseen = trial.fit.as_ref().map(|fit| logs.rmse(&fit.point, true)).transpose()?.flatten();
            Ok(Candidate {
                name: logs.entries[trial.entry].effect.name,
                bic_gain: trial.gain,
                delta: best - trial.gain,
                fitted: trial.fit.is_some(),
                held_out_ratio: unseen.zip(before).map(|(after, before)| after / before.max(f64::MIN_POSITIVE)),
                excluded: trial.excluded.clone(),
            })
        })
        .collect()
}

/// What the best wrong effect reaches on what was held out.
fn control(logs: &Logs, chosen: &Chosen, reported: bool) -> Result<Option<(&'static str, f64)>> {
    let mine = |e: usize| chosen.effects.iter().any(|s| s.entry == e || s.near(f64::INFINITY).take(1).any(|o| o == e));
    let wrong = chosen.alone.iter().find(|t| t.excluded.is_none() && t.fit.is_some() && !mine(t.entry));
    let Some((trial, fit)) = wrong.and_then(|t| Some((t, t.fit.as_ref()?))).filter(|_| reported) else {
        return Ok(None);
    };
    Ok(logs.rmse(&fit.point, true)?.map(|after| (logs.entries[trial.entry].effect.name, after)))
}

fn parameters(logs: &Logs, base: &Model, last: &Model, covariance: &Covariance) -> Vec<Tuned> {
    let one = |place: Place| {
        let (object, i) = place;
        let p = logs.parameter(place);
        let value = last.point[object][i];
        Tuned {
            object,
            name: p.name.clone(),
            unit: p.unit.clone(),
            given: logs.given[object].parameters()[i].value,
            before: base.point[object][i],
            value,
            interval95: covariance.interval(place, value, (p.min, p.max)),
        }
    };
    logs.tunable().into_iter().map(one).collect()
}

fn explained(logs: &Logs, base: &Model, last: &Model) -> Result<Vec<Explained>> {
    let one = |run: &super::logs::Run| {
        Ok(Explained {
            recording: run.recording,
            name: logs.names[run.recording].clone(),
            segment: None,
            held_out: run.held_out,
            seen: run.prepared.seen.clone(),
            kept: vec![true; run.prepared.seen.values().len()],
            before: logs.in_noise(run, &base.point)?,
            after: logs.in_noise(run, &last.point)?,
            noise: run.noise.clone(),
            events: Vec::new(),
            nuisances: Vec::new(),
        })
    };
    logs.runs.iter().map(one).collect()
}

/// What is left where nothing explains it: in which joint most, by how many times the noise.
fn describe(logs: &Logs, model: &Model) -> Result<String> {
    let width = logs.runs[0].width();
    let mut sums = vec![0.0; width];
    let mut count = 0usize;
    for run in logs.fitted() {
        for (i, r) in logs.in_noise(run, &model.point)?.iter().enumerate() {
            sums[i % width] += r * r;
        }
        count += run.prepared.seen.len();
    }
    let ratio = |i: usize| (sums[i] / count.max(1) as f64).sqrt();
    let worst = (0..width).max_by(|a, b| sums[*a].total_cmp(&sums[*b])).unwrap_or(0);
    let others: Vec<String> = (0..width)
        .filter(|&i| i != worst && ratio(i) > 1.5)
        .map(|i| format!("{} ({})", i + 1, with_decimals(ratio(i), 1)))
        .collect();
    let rest = if others.is_empty() { String::new() } else { format!("; also in {}", others.join(", ")) };
    Ok(format!(
        "what is left is largest in joint {}: {} times the noise of its torque{rest}",
        worst + 1,
        with_decimals(ratio(worst), 1)
    ))
}
