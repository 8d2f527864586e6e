//! 95 % intervals as ranges for domain randomisation, as JSON; docs/files.md lists the keys.

use std::path::Path;

use serde_json::{Value, json};
use tunenet_core::diagnose::Fitted;
use tunenet_core::tune::{Estimate, LEVEL, Outcome};
use tunenet_formats::{Result, write_atomically};

use crate::answers::diagnose::{Answer, value_of};

const SCHEMA: &str = "tunenet.ranges/1";

/// Ranges as they are written, and what they leave out.
pub struct Ranges {
    object: Value,
    /// What the recordings do not determine, as text; of several objects with their names.
    pub undetermined: Vec<String>,
}

impl Ranges {
    /// Writes them to a file, which never holds half of them.
    ///
    /// # Errors
    /// Where the file cannot be written.
    pub fn write(&self, out: &Path) -> Result<()> {
        write_atomically(out, |file| file.write_all(format!("{:#}\n", self.object).as_bytes()))
    }
}

/// The ranges of the parameters of a tuning, with their correlations where there are several.
pub fn of_tuning(outcome: &Outcome) -> Ranges {
    let (known, open): (Vec<&Estimate>, Vec<&Estimate>) = outcome.parameters.iter().partition(|p| p.identified);
    let ranges: Vec<Value> = known.iter().map(|p| range(&p.name, &p.unit, p.value, p.interval95)).collect();
    let open: Vec<&str> = open.iter().map(|p| p.name.as_str()).collect();
    let mut object = json!({ "schema": SCHEMA, "verdict": outcome.verdict, "level": LEVEL, "ranges": ranges });
    let undetermined = open.iter().map(|name| quoted("", name)).collect();
    object["undetermined"] = open.into();
    if outcome.correlation.nrows() > 1 {
        let rows: Vec<Vec<f64>> = outcome.correlation.row_iter().map(|r| r.iter().copied().collect()).collect();
        object["correlation"] = json!({ "parameters": outcome.free, "matrix": rows });
    }
    Ranges { object, undetermined }
}

/// A name as text, behind that of its object.
fn quoted(object: &str, name: &str) -> String {
    format!("{object}`{name}`")
}

/// The ranges of the parameters and of the effects' coefficients of a diagnosis; of several objects each has a list.
pub fn of_diagnosis(answer: &Answer) -> Ranges {
    let mut object = json!({ "schema": SCHEMA, "verdict": answer.word(), "level": LEVEL });
    let objects = &answer.loaded.objects;
    let single = objects.len() == 1;
    let (mut undetermined, mut all): (Vec<String>, Vec<Value>) = (Vec::new(), Vec::new());
    for (number, one) in objects.iter().enumerate() {
        let (ranges, open) = of_object(answer, number);
        let head = if single { String::new() } else { format!("{}: ", one.name) };
        undetermined.extend(open.iter().map(|name| quoted(&head, name)));
        if single {
            (object["ranges"], object["undetermined"]) = (ranges.into(), open.into());
        } else {
            all.push(json!({ "name": one.name, "ranges": ranges, "undetermined": open }));
        }
    }
    if !single {
        object["objects"] = all.into();
    }
    Ranges { object, undetermined }
}

/// The ranges of an object's numbers, and the names of those that the recordings do not determine: these have none.
fn of_object(answer: &Answer, number: usize) -> (Vec<Value>, Vec<String>) {
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
        return (ranges, open);
    }
    for named in answer.effects_of(number) {
        for (place, c) in named.coefficients.iter().enumerate() {
            let Some(value) = value_of(c, number) else { continue };
            let same = |others: &[Fitted]| others.iter().filter(|other| other.key == c.key).count();
            let key = format!("effects.{}.{}", named.effect.name, c.key);
            // Of several joints, with the number of its own.
            let name = match same(&named.coefficients) {
                1 => key,
                _ => format!("{key}.{}", same(&named.coefficients[..=place])),
            };
            if named.determines(&c.key, value) {
                ranges.push(range(&name, &c.unit, value.value, value.interval95));
            } else {
                open.push(name);
            }
        }
    }
    (ranges, open)
}

/// A number that a simulation may draw evenly from `low` to `high`.
fn range(name: &str, unit: &str, value: f64, (low, high): (f64, f64)) -> Value {
    json!({ "name": name, "unit": unit, "value": value, "low": low, "high": high })
}
