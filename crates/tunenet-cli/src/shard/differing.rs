//! In what two runs differ, option by option.

use serde_json::Value;

/// An option with its two values, for users: `--seed 0` and `--seed 9`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Difference {
    /// The option, `seed`.
    pub option: String,
    /// Its value in the first run.
    pub expected: String,
    /// Its value in the other run.
    pub found: String,
}

/// Every option in which `expected` and `found` differ. Options that stand together in an object count each on its own, by their
/// innermost names.
pub fn differing(expected: &Value, found: &Value) -> Vec<Difference> {
    let mut all = Vec::new();
    gather("", expected, found, &mut all);
    all
}

fn gather(option: &str, expected: &Value, found: &Value, all: &mut Vec<Difference>) {
    match (expected, found) {
        (Value::Object(a), Value::Object(b)) => {
            for key in a.keys().chain(b.keys().filter(|key| !a.contains_key(*key))) {
                let of = |object: &serde_json::Map<String, Value>| object.get(key).cloned().unwrap_or_default();
                gather(key, &of(a), &of(b), all);
            }
        }
        (a, b) if a == b => {}
        (a, b) => all.push(Difference { option: option.replace('_', "-"), expected: words(a), found: words(b) }),
    }
}

fn words(value: &Value) -> String {
    match value {
        Value::Null => "unset".into(),
        Value::Bool(true) => "on".into(),
        Value::Bool(false) => "off".into(),
        Value::String(text) => text.clone(),
        Value::Array(all) if all.is_empty() => "unset".into(),
        Value::Array(all) => all.iter().map(words).collect::<Vec<_>>().join(" "),
        other => other.to_string(),
    }
}

/// Both sides of several differences: `` `--seed` 0 and `--quick` off ``.
pub fn sides(all: &[Difference]) -> (String, String) {
    let side = |of: fn(&Difference) -> &String| {
        let each = all.iter().map(|one| format!("`--{}` {}", one.option, of(one)));
        each.collect::<Vec<_>>().join(" and ")
    };
    (side(|one| &one.expected), side(|one| &one.found))
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    #[test]
    fn only_what_differs_is_said() {
        let one = json!({ "records": 3, "quick": false, "only": [], "common": { "seed": 0 } });
        assert!(differing(&one, &one).is_empty());
        let two = json!({ "records": 3, "quick": true, "only": ["a", "b"], "common": { "seed": 9 } });
        let (expected, found) = sides(&differing(&one, &two));
        assert_eq!(expected, "`--quick` off and `--only` unset and `--seed` 0");
        assert_eq!(found, "`--quick` on and `--only` a b and `--seed` 9");
        let less = json!({ "records": 3, "common": { "seed": 0 }, "least_gain": 2.5 });
        assert_eq!(
            sides(&differing(&less, &json!({ "records": 3, "common": { "seed": 0 } }))).1,
            "`--least-gain` unset"
        );
    }
}
