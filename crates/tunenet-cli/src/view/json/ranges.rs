//! 95 % intervals as ranges for domain randomisation, as JSON; docs/files.md lists the keys.

use std::path::Path;

use serde_json::{Value, json};
use tunenet_core::diagnose::Fitted;
use tunenet_core::tune::{Estimate, LEVEL, Outcome};
use tunenet_formats::{Result, write_atomically};

use crate::answers::diagnose::{Answer, Object, value_of};

const SCHEMA: &str = "tunenet.ranges/1";

/// Writes ranges to a file, which never holds half of them.
///
/// # Errors
/// Where the file cannot be written.
pub fn write(out: &Path, ranges: &Value) -> Result<()> {
    write_atomically(out, |file| file.write_all(format!("{ranges:#}\n").as_bytes()))
}

/// The ranges of the parameters of a tuning, with their correlations where there are several.
pub fn of_tuning(outcome: &Outcome) -> Value {
    let (known, open): (Vec<&Estimate>, Vec<&Estimate>) = outcome.parameters.iter().partition(|p| p.identified);
    let ranges: Vec<Value> = known.iter().map(|p| range(&p.name, &p.unit, p.value, p.interval95)).collect();
    let open: Vec<&str> = open.iter().map(|p| p.name.as_str()).collect();
    let mut object = json!({ "schema": SCHEMA, "verdict": outcome.verdict, "level": LEVEL, "ranges": ranges });
    object["undetermined"] = open.into();
    if outcome.correlation.nrows() > 1 {
        let rows: Vec<Vec<f64>> = outcome.correlation.row_iter().map(|r| r.iter().copied().collect()).collect();
        object["correlation"] = json!({ "parameters": outcome.free, "matrix": rows });
    }
    object
}

/// The ranges of the parameters and of the effects' coefficients of a diagnosis; of several objects each has a list.
pub fn of_diagnosis(answer: &Answer) -> Value {
    let mut object = json!({ "schema": SCHEMA, "verdict": answer.word(), "level": LEVEL });
    let objects = &answer.loaded.objects;
    if objects.len() == 1 {
        (object["ranges"], object["undetermined"]) = of_object(answer, 0);
    } else {
        let one = |(number, o): (usize, &Object)| {
            let (ranges, open) = of_object(answer, number);
            json!({ "name": o.name, "ranges": ranges, "undetermined": open })
        };
        object["objects"] = objects.iter().enumerate().map(one).collect();
    }
    object
}

/// The ranges of an object's numbers, and the names of those that the recordings do not determine: these have none.
fn of_object(answer: &Answer, number: usize) -> (Value, Value) {
    let (mut ranges, mut open): (Vec<Value>, Vec<String>) = (Vec::new(), Vec::new());
    let bounds = answer.loaded.objects[number].simulator.parameters();
    for p in answer.parameters().iter().filter(|p| p.object == number) {
        if p.is_determined(bounds) {
            ranges.push(range(&p.name, &p.unit, p.value, p.interval95));
        } else {
            open.push(p.name.clone());
        }
    }
    if let Some((_, law)) = answer.found() {
        for term in &law.terms {
            let name = |key: &str| format!("effects.{}.{key}", term.carried.effect.name);
            ranges.extend(term.numbers.iter().map(|n| range(&name(&n.key), &n.unit, n.value, n.interval95)));
        }
        return (ranges.into(), open.into());
    }
    for named in answer.effects_of(number) {
        for (place, c) in named.coefficients.iter().enumerate() {
            let Some(value) = value_of(c, number) else { continue };
            let name = format!("effects.{}.{}", named.effect.name, c.key);
            let same = |others: &[Fitted]| others.iter().filter(|other| other.key == c.key).count();
            if named.determines(&c.key, value) {
                ranges.push(range(&name, &c.unit, value.value, value.interval95));
            } else if same(&named.coefficients) > 1 {
                open.push(format!("{name}.{}", same(&named.coefficients[..=place])));
            } else {
                open.push(name);
            }
        }
    }
    (ranges.into(), open.into())
}

/// The names in these ranges of what the recordings do not determine, as text; those of an object with its name.
pub fn undetermined(ranges: &Value) -> Vec<String> {
    let names = |of: &Value, head: &str| -> Vec<String> {
        let names = of["undetermined"].as_array().into_iter().flatten().filter_map(Value::as_str);
        names.map(|name| format!("{head}`{name}`")).collect()
    };
    let of_objects = ranges["objects"].as_array().into_iter().flatten();
    let of_objects = of_objects.flat_map(|o| names(o, &format!("{}: ", o["name"].as_str().unwrap_or_default())));
    names(ranges, "").into_iter().chain(of_objects).collect()
}

/// A number that a simulation may draw evenly from `low` to `high`.
fn range(name: &str, unit: &str, value: f64, (low, high): (f64, f64)) -> Value {
    json!({ "name": name, "unit": unit, "value": value, "low": low, "high": high })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_not_determined_is_named_with_its_object() {
        let one = json!({ "ranges": [], "undetermined": ["armature", "effects.backlash.gap_rad"] });
        assert_eq!(undetermined(&one), ["`armature`", "`effects.backlash.gap_rad`"]);
        let several = json!({ "objects": [{ "name": "left", "undetermined": ["armature"] }, { "name": "right" }] });
        assert_eq!(undetermined(&several), ["left: `armature`"]);
    }
}
