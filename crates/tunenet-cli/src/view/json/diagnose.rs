//! The answer as JSON, for programs; docs/json.md lists the keys.

use serde_json::{Map, Value as Json, json};
use tunenet_core::diagnose::{
    Candidate, Change, Explained, Fitted, Gap, NamedEffect, OfObject, OwnEffect, PartGap, Test, Tuned, Use, Value,
};
use tunenet_sim::phase;

use super::warning;
use crate::answers::diagnose::{Answer, gap_of, is_per_joint};

pub fn object(answer: &Answer) -> Json {
    let diagnosis = answer.diagnosis;
    let warnings: Vec<Json> = answer.notes().iter().map(warning).collect();
    // Where a law is the answer, what the catalogue says without it stands in `law.catalogue`.
    let by_law = answer.found().is_some();
    let next = diagnosis.next_experiment.as_ref().filter(|_| !by_law);
    let mut object = json!({
        "schema": "tunenet.diagnose/1",
        "verdict": answer.word(),
        "objects": answer.objects().map(of_object).collect::<Vec<_>>(),
        "effects": if by_law { Vec::new() } else { effects(answer) },
        "candidates": if by_law { answer.rivals() } else { answer.candidates() },
        "scores": diagnosis.candidates.iter().map(score).collect::<Vec<_>>(),
        "gap": answer.gap().as_ref().map(gap),
        "gaps": diagnosis.gaps.iter().filter(|_| !by_law).map(|part| part_gap(answer, part)).collect::<Vec<_>>(),
        "margin": diagnosis.margin,
        "adequacy": diagnosis.adequacy.iter().filter(|_| !by_law).map(test).collect::<Vec<_>>(),
        "doubt": diagnosis.conclusion.doubt().filter(|_| !by_law).map(ToString::to_string),
        "description": diagnosis.conclusion.description().filter(|_| !by_law),
        "next_experiment": next.map(|next| {
            let settings: Map<String, Json> = next.settings.iter().map(|(k, v)| (k.clone(), json!(v))).collect();
            json!({ "text": next.text, "settings": settings })
        }),
        "parameters": answer.parameters().iter().map(|p| parameter(answer, p)).collect::<Vec<_>>(),
        "recordings": diagnosis.uses.iter().map(used).collect::<Vec<_>>(),
        "estimated": diagnosis.explained.iter().filter(|_| !by_law).map(estimated).collect::<Vec<_>>(),
        "rollouts": answer.rollouts(),
        "seconds": answer.seconds,
        "warnings": warnings,
    });
    if !diagnosis.tied.is_empty() && !by_law {
        object["tied"] = json!(diagnosis.tied);
    }
    if answer.re_asks > 0 {
        object["re_asks"] = json!(answer.re_asks);
    }
    if let Some(law) = answer.law {
        object["law"] = super::law::object(law);
    }
    if by_law {
        object["law"]["catalogue"] = json!({
            "verdict": diagnosis.verdict(),
            "effects": effects(answer),
            "candidates": answer.candidates(),
            "gap": diagnosis.gap.as_ref().map(gap),
            "adequacy": diagnosis.adequacy.iter().map(test).collect::<Vec<_>>(),
            "parameters": diagnosis.parameters.iter().map(|p| parameter(answer, p)).collect::<Vec<_>>(),
        });
    }
    object
}

fn effects(answer: &Answer) -> Vec<Json> {
    answer.diagnosis.effects().iter().map(|e| effect(answer, e)).collect()
}

fn of_object((name, one): (&str, &OfObject)) -> Json {
    let effect =
        |e: &OwnEffect| json!({ "name": e.name, "bic_gain": e.bic_gain, "shown": e.shown, "needed": e.needed });
    json!({ "object": name, "verdict": one.verdict, "effects": one.effects.iter().map(effect).collect::<Vec<_>>() })
}

fn effect(answer: &Answer, named: &NamedEffect) -> Json {
    let mut coefficients = coefficients(answer, named);
    if let Some(fitted) = named.coefficients.first() {
        let values: Option<Vec<Value>> = fitted.values.iter().map(|v| answer.drag_coefficient(named, v)).collect();
        if let Some(values) = values.filter(|values| !values.is_empty()) {
            let fitted = Fitted { key: "drag_coefficient".into(), unit: "1".into(), values };
            coefficients.insert(fitted.key.to_string(), coefficient(answer, &fitted));
        }
    }
    let evidence = &named.evidence;
    json!({
        "name": named.effect.name,
        "sentence": named.effect.sentence,
        "coefficients": coefficients,
        "where": { "phase": phase::code(&named.effect.phase), "text": phase::name(&named.effect.phase) },
        "evidence": {
            "bic_gain": evidence.bic_gain,
            "runner_up": evidence.runner_up,
            // JSON knows no infinity: null where nothing comes second.
            "runner_up_bic_gap": evidence.runner_up_bic_gap,
            "p_value": evidence.p_value,
        },
        "alternatives": named.alternatives,
    })
}

/// The coefficients by their keys; numbers of joints, which share a key, as lists in the order of the joints.
fn coefficients(answer: &Answer, named: &NamedEffect) -> Map<String, Json> {
    let mut found = Map::new();
    for fitted in &named.coefficients {
        let joints: Vec<&Fitted> = named.coefficients.iter().filter(|f| f.key == fitted.key).collect();
        let one = match joints.as_slice() {
            [alone] if !is_per_joint(named) => coefficient(answer, alone),
            all if fitted.values.len() == 1 => {
                let values: Vec<f64> = all.iter().map(|f| f.values[0].value).collect();
                let ranges: Vec<Json> =
                    all.iter().map(|f| json!([f.values[0].interval95.0, f.values[0].interval95.1])).collect();
                json!({ "value": values, "unit": fitted.unit, "interval95": ranges })
            }
            all => {
                let each = fitted.values.iter().enumerate().map(|(i, v)| {
                    let values: Vec<f64> = all.iter().map(|f| f.values[i].value).collect();
                    let range = |f: &&Fitted| json!([f.values[i].interval95.0, f.values[i].interval95.1]);
                    let ranges: Vec<Json> = all.iter().map(range).collect();
                    json!({ "object": answer.object(v), "value": values, "interval95": ranges })
                });
                json!({ "value": null, "unit": fitted.unit, "interval95": null, "objects": each.collect::<Vec<_>>() })
            }
        };
        found.insert(fitted.key.to_string(), one);
    }
    found
}

/// One value where all objects share it or there is one object; else one for each, and none that stands for all.
fn coefficient(answer: &Answer, fitted: &Fitted) -> Json {
    let range = |v: &Value| json!([v.interval95.0, v.interval95.1]);
    if let [one] = &fitted.values[..] {
        return json!({ "value": one.value, "unit": fitted.unit, "interval95": range(one) });
    }
    let each = fitted.values.iter().map(|v| {
        let object = answer.object(v);
        json!({ "object": object, "value": v.value, "interval95": range(v) })
    });
    json!({ "value": null, "unit": fitted.unit, "interval95": null, "objects": each.collect::<Vec<_>>() })
}

fn score(candidate: &Candidate) -> Json {
    json!({
        "name": candidate.name,
        "bic_gain": candidate.bic_gain,
        "behind_best": candidate.delta,
        "fitted": candidate.fitted,
        "held_out_ratio": candidate.held_out_ratio,
        "excluded": candidate.excluded.as_ref().map(ToString::to_string),
    })
}

fn change(change: &Change) -> Json {
    json!({ "before": change.before, "after": change.after })
}

fn gap(gap: &Gap) -> Json {
    json!({
        "unit": gap.unit,
        "of": gap_of(gap),
        "before": gap.before,
        "after": gap.after,
        "noise_floor": gap.noise_floor,
        "held_out": gap.held_out.as_ref().map(change),
        "forecast": gap.forecast.as_ref().map(change),
        "control": gap.control.as_ref().map(|(name, after)| json!({ "name": name, "after": after })),
    })
}

fn part_gap(answer: &Answer, part: &PartGap) -> Json {
    json!({
        "object": answer.loaded.objects.get(part.object).map(|o| &o.name),
        "channel": part.channel,
        "unit": part.unit,
        "before": part.before,
        "after": part.after,
        "noise_floor": part.noise_floor,
        "held_out": part.held_out.as_ref().map(change),
    })
}

fn test(test: &Test) -> Json {
    json!({ "name": test.name, "value": test.value, "threshold": test.threshold, "passed": test.passed })
}

fn parameter(answer: &Answer, tuned: &Tuned) -> Json {
    let object = answer.loaded.objects.get(tuned.object).map(|o| &o.name);
    json!({
        "object": object, "name": tuned.name, "unit": tuned.unit, "given": tuned.given, "before": tuned.before,
        "value": tuned.value, "interval95": [tuned.interval95.0, tuned.interval95.1],
    })
}

fn used(one: &Use) -> Json {
    json!({
        "file": one.name, "used": one.used, "held_out": one.held_out,
        "notes": one.notes.iter().map(warning).collect::<Vec<_>>(),
    })
}

fn estimated(one: &Explained) -> Json {
    let own = one.nuisances.iter().map(|(name, value, unit)| json!({ "name": name, "value": value, "unit": unit }));
    json!({ "file": one.name, "flight": one.segment, "own": own.collect::<Vec<_>>() })
}
