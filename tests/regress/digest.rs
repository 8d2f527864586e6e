//! What of an answer is pinned: verdict, names, values with their intervals, codes and rollouts; no sentence and no time.

use crate::common::Ran;
use serde_json::{Map, Value, json};

/// The digest of what a command with `--json` answered, or its exit status where it refuses.
pub fn answered(ran: &Ran) -> Value {
    match serde_json::from_str(&ran.stdout) {
        Ok(answer) => of(&answer),
        Err(_) => json!({ "exit": ran.code }),
    }
}

/// The digest of an answer of `tune`, `diagnose` or `inspect`, which have keys of their own.
pub fn of(answer: &Value) -> Value {
    let mut digest = Map::new();
    for key in ["verdict", "stop", "usable", "candidates", "margin", "rollouts"] {
        keep(&mut digest, key, answer[key].clone());
    }
    keep(&mut digest, "warnings", codes(&answer["warnings"]));
    keep(&mut digest, "gravity", values(&answer["gravity"], "value_m_s2", "interval95_m_s2"));
    keep(&mut digest, "noticed", noticed(&answer["preflight"]));
    keep(&mut digest, "files", list(&answer["files"], of));
    keep(&mut digest, "parameters", named(&answer["parameters"], number));
    keep(&mut digest, "effects", named(&answer["effects"], effect));
    keep(&mut digest, "objects", list(&answer["objects"], object));
    keep(&mut digest, "gap", gap(&answer["gap"]));
    keep(&mut digest, "adequacy", list(&answer["adequacy"], |test| json!([test["passed"], test["value"]])));
    keep(&mut digest, "next_experiment", answer["next_experiment"]["settings"].clone());
    Value::Object(digest)
}

/// Keeps what says anything.
fn keep(digest: &mut Map<String, Value>, key: &str, value: Value) {
    let empty = match &value {
        Value::Null => true,
        Value::Array(all) => all.is_empty(),
        Value::Object(all) => all.is_empty(),
        _ => false,
    };
    if !empty {
        digest.insert(key.into(), value);
    }
}

fn list(of: &Value, one: impl Fn(&Value) -> Value) -> Value {
    Value::Array(of.as_array().into_iter().flatten().map(one).collect())
}

fn codes(warnings: &Value) -> Value {
    list(warnings, |warning| warning["code"].clone())
}

/// Codes of the preflight checks that noticed something; one list for each recording.
fn noticed(preflight: &Value) -> Value {
    let one =
        |check: &Value| (check["state"] == "noticed" || check["state"] == "failed").then(|| check["code"].clone());
    let checks = preflight.as_array().into_iter().flatten();
    let flat = checks.flat_map(|c| c.as_array().map_or_else(|| vec![c], |all| all.iter().collect()));
    Value::Array(flat.filter_map(one).collect())
}

/// A value and its interval as `[value, low, high]`; values alone where no interval is stated.
fn values(of: &Value, value: &str, interval: &str) -> Value {
    match (&of[value], &of[interval]) {
        (Value::Null, _) => Value::Null,
        (value, Value::Array(ends)) if ends.len() == 2 && value.is_number() => json!([value, ends[0], ends[1]]),
        (value, interval) => json!([value, interval]),
    }
}

/// A parameter or coefficient; where it differs from object to object, one for each.
fn number(of: &Value) -> Value {
    match &of["objects"] {
        Value::Array(_) => list(&of["objects"], number),
        _ => values(of, "value", "interval95"),
    }
}

/// A map from names, whether the answer has an object or a list whose entries bear them.
fn named(of: &Value, one: impl Fn(&Value) -> Value) -> Value {
    let mut map = Map::new();
    for (key, value) in of.as_object().into_iter().flatten() {
        map.insert(key.clone(), one(value));
    }
    for entry in of.as_array().into_iter().flatten() {
        let name = |key: &str| entry[key].as_str().unwrap_or_default();
        let key = if name("object").is_empty() {
            name("name").into()
        } else {
            format!("{} {}", name("object"), name("name"))
        };
        map.insert(key, one(entry));
    }
    Value::Object(map)
}

fn effect(of: &Value) -> Value {
    let mut map = Map::new();
    keep(&mut map, "alternatives", of["alternatives"].clone());
    keep(&mut map, "bic_gain", of["evidence"]["bic_gain"].clone());
    for (key, coefficient) in of["coefficients"].as_object().into_iter().flatten() {
        keep(&mut map, key, number(coefficient));
    }
    Value::Object(map)
}

fn object(of: &Value) -> Value {
    json!([of["object"], of["verdict"], list(&of["effects"], |e| e["name"].clone())])
}

/// Before and after of all that was fitted, held out and forecast.
fn gap(of: &Value) -> Value {
    let mut map = Map::new();
    keep(&mut map, "of", of["of"].clone());
    for (key, of) in [("fitted", of), ("held_out", &of["held_out"]), ("forecast", &of["forecast"])] {
        if !of["after"].is_null() {
            map.insert(key.into(), json!([of["before"], of["after"]]));
        }
    }
    Value::Object(map)
}
