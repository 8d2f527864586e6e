//! 95 % intervals as ranges for domain randomisation, as JSON; docs/files.md lists the keys.

use std::path::Path;

use serde_json::{Value, json};
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
    let one = |p: &Estimate| range(&p.name, &p.unit, p.value, p.interval95);
    let ranges: Vec<Value> = outcome.parameters.iter().filter(|p| p.identified).map(one).collect();
    let mut object = json!({ "schema": SCHEMA, "verdict": outcome.verdict, "level": LEVEL, "ranges": ranges });
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
        object["ranges"] = of_object(answer, 0);
    } else {
        let one = |(number, o): (usize, &Object)| json!({ "name": o.name, "ranges": of_object(answer, number) });
        object["objects"] = objects.iter().enumerate().map(one).collect();
    }
    object
}

fn of_object(answer: &Answer, number: usize) -> Value {
    let tuned = answer.parameters();
    let parameters = tuned.iter().filter(|p| p.object == number);
    let parameters = parameters.map(|p| range(&p.name, &p.unit, p.value, p.interval95));
    if let Some((_, law)) = answer.found() {
        let numbers = law.terms.iter().flat_map(|term| {
            let name = |key: &str| format!("effects.{}.{key}", term.carried.effect.name);
            term.numbers.iter().map(move |n| range(&name(&n.key), &n.unit, n.value, n.interval95))
        });
        return parameters.chain(numbers).collect();
    }
    let effects = answer.effects_of(number).into_iter().flat_map(|named| {
        let values = named.coefficients.iter().filter_map(|c| Some((c, value_of(c, number)?)));
        let shown = values.filter(|(c, v)| named.shows(&c.key, v));
        shown.map(|(c, v)| range(&format!("effects.{}.{}", named.effect.name, c.key), &c.unit, v.value, v.interval95))
    });
    parameters.chain(effects).collect()
}

/// A number that a simulation may draw evenly from `low` to `high`.
fn range(name: &str, unit: &str, value: f64, (low, high): (f64, f64)) -> Value {
    json!({ "name": name, "unit": unit, "value": value, "low": low, "high": high })
}
