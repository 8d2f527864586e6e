//! A search for a law as JSON, for programs; docs/law.md lists the keys.

use serde_json::{Map, Value as Json, json};
use tunenet_core::law::{Bin, Course, FoundTerm, Gates, Member, Number, Refused, Sample};

use crate::answers::law::{Law, alias, why_not};

/// The key `law` of the answer.
pub fn object(law: &Law) -> Json {
    let found = match &law.found {
        Ok(found) => found,
        Err(why) => {
            return json!({ "verdict": "unknown", "reason": "no_place", "why": why, "members": [], "refused": [], "rollouts": 0,
                           "seconds": law.seconds });
        }
    };
    let answer = &found.answer;
    let refused =
        |one: &Refused| with_tests(json!({ "text": one.text, "bic_gain": one.bic_gain, "gate": one.gate }), &one.gates);
    json!({
        "verdict": answer.verdict,
        "reason": answer.reason,
        "why": why_not(answer),
        "members": answer.members.iter().map(member).collect::<Vec<_>>(),
        "refused": answer.refused.iter().map(refused).collect::<Vec<_>>(),
        "base_residual_force_nats": answer.base_force_nats,
        "catalogue_bic_gain": answer.rival_bic_gain,
        "decaying_force_bic_gain": answer.decay_bic_gain,
        "recordings": answer.searched.len(),
        "held_out_recordings": answer.held_out,
        "residual_before": answer.left.0,
        "residual_after": answer.left.1,
        "rollouts": answer.rollouts,
        "seconds": law.seconds,
    })
}

fn member(member: &Member) -> Json {
    let named = member.alias.map(|effect| json!({ "effect": effect, "sentence": alias(member) }));
    let valid: Map<String, Json> =
        member.valid.iter().map(|(name, (low, high))| (name.clone(), json!([low, high]))).collect();
    let object = json!({
        "text": member.text(),
        "named": named,
        "terms": member.terms.iter().map(term).collect::<Vec<_>>(),
        "score": member.score,
        "bic_gain": member.bic_gain,
        "behind_best": member.behind_best,
        "bits": member.bits,
        "parameters": member.terms.iter().map(|t| t.numbers.len()).sum::<usize>(),
        "valid": valid,
        "courses": member.courses.iter().map(course).collect::<Vec<_>>(),
        "depends_on_time": member.depends_on_time,
        "bounded": member.bounded,
    });
    with_tests(object, &member.gates)
}

/// An object with what the tests of a law measured.
fn with_tests(mut object: Json, gates: &Gates) -> Json {
    let tests = json!({
        "residual_force_nats": gates.residual_force_nats,
        "heterogeneity_p": gates.heterogeneity_p,
        "held_out_ratio": gates.held_out_ratio,
        "held_out_base": gates.held_out_base,
        "held_out_left": gates.held_out_left,
        "held_out_p": gates.held_out_p,
        "held_out_force_nats": gates.held_out_force_nats,
        "held_out_differ_p": gates.held_out_differ_p,
        "held_out_nats": gates.held_out_nats,
        "beyond_bound": gates.beyond_bound,
    });
    if let (Json::Object(all), Json::Object(tests)) = (&mut object, tests) {
        all.extend(tests);
    }
    object
}

fn course(course: &Course) -> Json {
    let estimate = |s: &Sample| json!({ "at": s.at, "value": s.value, "interval95": [s.interval95.0, s.interval95.1] });
    let range = |bin: &Bin| json!({ "range": [bin.range.0, bin.range.1], "estimate": estimate(&bin.estimate) });
    json!({
        "component": course.component,
        "unit": course.unit,
        "variable": course.variable,
        "variable_unit": course.variable_unit,
        "held": course.held.as_ref().map(|(name, value)| json!({ "variable": name, "value": value })),
        "curve": course.curve.iter().map(estimate).collect::<Vec<_>>(),
        "bins": course.bins.iter().map(range).collect::<Vec<_>>(),
    })
}

fn term(term: &FoundTerm) -> Json {
    let count = term.components.len();
    let coefficient = |(number, direction): (&Number, &String)| {
        json!({
            "key": number.key, "direction": direction, "value": number.value, "unit": number.unit,
            "interval95": [number.interval95.0, number.interval95.1],
        })
    };
    let mut at = count;
    let factors = term.term.factors.iter().zip(&term.rounded).map(|(factor, rounded)| {
        let own = &term.numbers[at..at + factor.constants()];
        at += factor.constants();
        let mut constants: Vec<Json> = Vec::new();
        if let Some(rounded) = rounded {
            let role = factor.shape.roles()[0];
            constants.push(json!({
                "key": role.letter(), "role": role.name(), "value": rounded.value, "unit": "1",
                "interval95": [rounded.interval95.0, rounded.interval95.1], "fixed": true,
            }));
        }
        constants.extend(own.iter().map(|n| {
            json!({
                "key": n.key, "role": n.role.map(tunenet_core::law::Role::name), "value": n.value, "unit": n.unit,
                "interval95": [n.interval95.0, n.interval95.1], "fixed": false,
            })
        }));
        json!({ "kind": factor.shape.name(), "variable": variable(term, factor.variable), "constants": constants })
    });
    let factors: Vec<Json> = factors.collect();
    let formula = if term.formula.is_empty() { "a".to_owned() } else { format!("a * {}", term.formula) };
    json!({
        "formula": formula,
        "directions": term.components,
        "factors": factors,
        "coefficients": term.numbers[..count].iter().zip(&term.components).map(coefficient).collect::<Vec<_>>(),
    })
}

fn variable(term: &FoundTerm, position: usize) -> Option<&str> {
    term.variables.iter().find(|(known, _)| *known == position).map(|(_, name)| name.as_str())
}
