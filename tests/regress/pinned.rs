//! Pinned answers: one file of JSON for each group, one line for each answer.

use std::fmt::Write;
use std::path::{Path, PathBuf};

use serde_json::{Map, Value, json};

/// Marks an answer that is known to be wrong and says what would be right. Who mends it writes the pin anew without the mark.
const KNOWN_WRONG: &str = "known_wrong";
/// Relative; the same computation in another order of its sums stays far below.
const TOLERANCE: f64 = 1e-9;
/// Below this, in SI units, a number is zero.
const ZERO: f64 = 1e-12;

/// Compares what was found with what is pinned under this group's name, or writes it there.
pub fn check(group: &str, found: &[(String, Value)]) {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/regress").join(format!("{group}.json"));
    let pinned: Map<String, Value> = std::fs::read(&path)
        .map(|text| serde_json::from_slice(&text).unwrap_or_else(|e| panic!("{}: {e}", path.display())))
        .unwrap_or_default();
    if std::env::var_os("TUNENET_REGRESS_WRITE").is_some() {
        return write(&path, found, &pinned);
    }
    let mut told = String::new();
    let mut compared = 0;
    for (name, now) in found {
        let Some(before) = pinned.get(name) else {
            eprintln!("{group}: {name} is not pinned");
            continue;
        };
        compared += 1;
        let mut differences = Vec::new();
        differ("", before, &rounded(now), &mut differences);
        if differences.is_empty() {
            continue;
        }
        writeln!(told, "{name}:\n  {}", differences.join("\n  ")).expect("a string takes all");
        if let Some(right) = before.get(KNOWN_WRONG) {
            writeln!(told, "  the pinned answer was known to be wrong; right is: {right}").expect("a string takes all");
        }
    }
    assert!(compared > 0, "{}: nothing of it could be compared", path.display());
    assert!(
        told.is_empty(),
        "{told}{group}: the above differs from {}; where that is meant, run again with TUNENET_REGRESS_WRITE=1",
        path.display()
    );
}

/// Writes the answers, with the marks of those that were known to be wrong.
fn write(path: &PathBuf, found: &[(String, Value)], before: &Map<String, Value>) {
    let line = |(name, now): &(String, Value)| {
        let mut now = rounded(now);
        if let (Some(mark), Value::Object(map)) = (before.get(name).and_then(|b| b.get(KNOWN_WRONG)), &mut now) {
            map.insert(KNOWN_WRONG.into(), mark.clone());
        }
        format!("{}: {now}", json!(name))
    };
    let lines: Vec<String> = found.iter().map(line).collect();
    std::fs::write(path, format!("{{\n{}\n}}\n", lines.join(",\n"))).expect("a writable folder");
}

/// Numbers to twelve digits, which is what is compared and a little more.
fn rounded(value: &Value) -> Value {
    match value {
        Value::Number(n) if n.is_f64() => {
            let text = format!("{:.11e}", n.as_f64().unwrap_or_default());
            json!(text.parse::<f64>().unwrap_or_default())
        }
        Value::Array(all) => all.iter().map(rounded).collect(),
        Value::Object(map) => map.iter().map(|(key, value)| (key.clone(), rounded(value))).collect(),
        other => other.clone(),
    }
}

/// Adds a line for everything in which two digests differ.
fn differ(at: &str, before: &Value, now: &Value, lines: &mut Vec<String>) {
    match (before, now) {
        (Value::Number(a), Value::Number(b)) => {
            let (a, b) = (a.as_f64().unwrap_or(f64::NAN), b.as_f64().unwrap_or(f64::NAN));
            if (a - b).abs() > TOLERANCE * a.abs().max(b.abs()) + ZERO {
                lines.push(format!("{at}: pinned {a}, now {b}"));
            }
        }
        (Value::Array(a), Value::Array(b)) if a.len() == b.len() => {
            let before = lines.len();
            for (i, (a, b)) in a.iter().zip(b).enumerate() {
                differ(&format!("{at}[{i}]"), a, b, lines);
            }
            if lines.len() > before {
                lines.extend(half_widths(at, a, b));
            }
        }
        (Value::Object(a), Value::Object(b)) => {
            for key in a.keys().chain(b.keys().filter(|key| !a.contains_key(*key))).filter(|key| *key != KNOWN_WRONG) {
                let of = |map: &Map<String, Value>| map.get(key).cloned().unwrap_or_default();
                differ(&format!("{at}.{key}"), &of(a), &of(b), lines);
            }
        }
        (a, b) if a == b => {}
        (a, b) => lines.push(format!("{at}: pinned {a}, now {b}")),
    }
}

/// How far a value moved, measured by its interval: what may differ where solvers are merged is a tenth.
fn half_widths(at: &str, before: &[Value], now: &[Value]) -> Option<String> {
    let number = |v: &Value| v.as_f64();
    let [value, low, high] = before.iter().map(number).collect::<Option<Vec<_>>>()?[..] else { return None };
    let half = 0.5 * (high - low);
    let moved = (now.first().and_then(number)? - value).abs() / half;
    (half > 0.0).then(|| format!("{at}: moved by {moved:.3} of its half-width"))
}
