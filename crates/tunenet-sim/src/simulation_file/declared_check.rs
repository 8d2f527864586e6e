//! Consistency checks of the tables whose names a file chooses: what no key alone shows to be wrong, with its place.

use std::ops::Range;

use toml_edit::{Item, Table, TableLike};
use tunenet_core::observation::Channel;

use super::declared_schema::{COEFFICIENT_KEYS, Declares};
use super::schema::{self, Key, item_number, lookup, texts};
use crate::formula_effect::FormulaEffect;
use crate::scene::Candidate;

/// What is wrong: the path, its place, what is expected and what is found.
pub(super) type Wrong = (String, Range<usize>, String, String);

/// The first thing that no key alone shows to be wrong.
pub(super) fn contradiction(root: &Table, declares: Declares) -> Option<Wrong> {
    missing(root, declares)
        .or_else(|| inputs(root))
        .or_else(|| starts(root))
        .or_else(|| candidates(root, declares))
        .or_else(|| declares.formulas().then(|| formulas(root, declares))?)
        .or_else(|| effects(root, declares))
}

fn tables<'a>(root: &'a Table, path: &str) -> Vec<(&'a str, &'a Item, &'a dyn TableLike)> {
    let all = lookup(root, path).and_then(Item::as_table_like);
    let each = all.into_iter().flat_map(|all| all.iter());
    each.filter_map(|(name, item)| Some((name, item, item.as_table_like()?))).collect()
}

fn wrong(path: String, item: Option<&Item>, expected: impl Into<String>, found: impl Into<String>) -> Wrong {
    (path, item.and_then(Item::span).unwrap_or(0..0), expected.into(), found.into())
}

/// The first required key that a table lacks, and the first table whose name cannot be one.
fn missing(root: &Table, declares: Declares) -> Option<Wrong> {
    let lacks = |path: String, item: &Item, table: &dyn TableLike, keys: Vec<&Key>| {
        let key = keys.into_iter().find(|key| key.required && table.get(&key.path).is_none())?;
        Some(wrong(path, Some(item), format!("`{}` ({})", key.path, key.meaning), "none"))
    };
    for head in declares.heads() {
        for (name, item, table) in tables(root, head) {
            let path = format!("{head}.{name}");
            if let Some(found) = lacks(path, item, table, declares.keys(&[head, name]).unwrap_or_default()) {
                return Some(found);
            }
        }
    }
    for (name, item, _) in tables(root, "candidates") {
        let within = format!("candidates.{name}.coefficients");
        let all = tables(root, &within);
        if all.is_empty() {
            let keys = if declares.needs_typical() { "`min`, `max` and `typical`" } else { "`min` and `max`" };
            let expected = format!("at least one [{within}.KEY] with {keys}");
            return Some(wrong(format!("candidates.{name}"), Some(item), expected, "none"));
        }
        for (key, item, table) in all {
            let needed = COEFFICIENT_KEYS.iter().filter(|key| key.path != "typical" || declares.needs_typical());
            if let Some(found) = lacks(format!("{within}.{key}"), item, table, needed.collect()) {
                return Some(found);
            }
        }
    }
    None
}

/// The headers of the channels.
fn channels(root: &Table) -> Vec<&str> {
    let names = |path: &str| {
        let all = lookup(root, path).and_then(Item::as_table_like).filter(|all| !all.is_empty());
        all.map(|all| all.iter().map(|(name, _)| name).collect::<Vec<_>>())
    };
    let observed: Vec<&str> =
        tables(root, "joints").into_iter().filter_map(|(.., table)| table.get("observe")).flat_map(texts).collect();
    lookup(root, "process.channels")
        .map(texts)
        .or_else(|| (!observed.is_empty()).then_some(observed))
        .or_else(|| names("outputs"))
        .or_else(|| names("states"))
        .unwrap_or_default()
}

/// Where the file names its channels.
fn naming_channels(root: &Table) -> &'static str {
    match (has(root, "process"), has(root, "joints")) {
        (true, _) => "process.channels",
        (false, true) => "joints.NAME.observe",
        (false, false) => "outputs",
    }
}

fn has(root: &Table, path: &str) -> bool {
    lookup(root, path).is_some()
}

fn text<'a>(table: &'a dyn TableLike, key: &str) -> Option<&'a str> {
    table.get(key).and_then(Item::as_str)
}

const UNIT: &str =
    "a lower-case name that ends in its unit, such as `force_n`, `theta_rad` or, without one, `throttle_1`";

fn inputs(root: &Table) -> Option<Wrong> {
    let switches: Vec<&str> = tables(root, "joints").iter().filter_map(|(.., table)| text(*table, "enable")).collect();
    for (name, item, table) in tables(root, "inputs") {
        let path = format!("inputs.{name}");
        let (unit, of_name) = (text(table, "unit"), Channel::from_header(name));
        match (unit, &of_name) {
            (None, None) if !switches.contains(&name) => {
                return Some(wrong(
                    path,
                    Some(item),
                    format!("{UNIT}; or `unit = \"N\"` in its table"),
                    format!("`{name}`"),
                ));
            }
            (Some(unit), Some(channel)) if channel.unit != unit => {
                let expected = format!("{}, the unit in which the name ends", channel.unit);
                return Some(wrong(format!("{path}.unit"), table.get("unit"), expected, format!("`{unit}`")));
            }
            _ => {}
        }
        if channels(root).contains(&name) {
            let expected = "a name that no channel has: what drives the simulation is not predicted by it";
            let found = format!("`{name}` under `{}` too", naming_channels(root));
            return Some(wrong(path, Some(item), expected, found));
        }
        if ["t_s", "t", "time", "time_s"].contains(&name) {
            return Some(wrong(path, Some(item), "another name than the clock's", format!("`{name}`")));
        }
        if let Some(other) = ["start", "parameters"].into_iter().find(|head| has(root, &format!("{head}.{name}"))) {
            let expected = "a name that nothing else has";
            return Some(wrong(path, Some(item), expected, format!("`{name}` under [{other}] too")));
        }
    }
    None
}

fn starts(root: &Table) -> Option<Wrong> {
    for (name, item, table) in tables(root, "start") {
        let path = format!("start.{name}");
        if Channel::from_header(name).is_none() && !has(root, &format!("states.{name}.unit")) {
            return Some(wrong(path, Some(item), UNIT, format!("`{name}`")));
        }
        if has(root, &format!("parameters.{name}")) {
            let expected = "a name that nothing else has";
            return Some(wrong(path, Some(item), expected, format!("`{name}` under [parameters] too")));
        }
        if text(table, "value") == Some("first") && !channels(root).contains(&name) {
            let named = naming_channels(root);
            let expected = format!("a number, since `{named}` has no `{name}` whose first sample it could be");
            return Some(wrong(format!("{path}.value"), table.get("value"), expected, "\"first\""));
        }
        let number = |key: &str| table.get(key).and_then(item_number);
        match (number("min"), number("max")) {
            (Some(min), None) => {
                return Some(wrong(path, table.get("min"), "`max` with `min`", format!("only min = {min}")));
            }
            (None, Some(max)) => {
                return Some(wrong(path, table.get("max"), "`min` with `max`", format!("only max = {max}")));
            }
            (Some(min), Some(max)) if min >= max => {
                let expected = format!("more than min = {min}");
                return Some(wrong(format!("{path}.max"), table.get("max"), expected, max.to_string()));
            }
            (Some(min), Some(max)) => {
                if let Some(value) = number("value").filter(|value| !(min..=max).contains(value)) {
                    let expected = format!("{min} to {max}");
                    return Some(wrong(format!("{path}.value"), table.get("value"), expected, value.to_string()));
                }
            }
            (None, None) => {}
        }
    }
    None
}

/// Each candidate is scored by rollouts; more than so many are no choice.
const MOST_CANDIDATES: usize = 500;

fn candidates(root: &Table, declares: Declares) -> Option<Wrong> {
    let count = tables(root, "candidates").len();
    if count > MOST_CANDIDATES {
        let expected = "at most 500 candidates";
        return Some(wrong("candidates".into(), root.get("candidates"), expected, count.to_string()));
    }
    for (name, item, table) in tables(root, "candidates") {
        let path = format!("candidates.{name}");
        if declares.is_built_in(name) {
            let expected = "a name that no built-in effect has";
            return Some(wrong(path, Some(item), expected, format!("`{name}`, which is built in")));
        }
        if has(root, &format!("parameters.{name}")) {
            let expected = "a name that nothing else has";
            return Some(wrong(path, Some(item), expected, format!("`{name}` under [parameters] too")));
        }
        for key in ["sentence", "acts"] {
            let said = text(table, key).unwrap_or_default();
            if said.trim().is_empty() || said.chars().any(char::is_control) {
                let expected = if key == "acts" { "a word" } else { "a sentence on one line" };
                return Some(wrong(
                    format!("{path}.{key}"),
                    table.get(key),
                    expected,
                    format!("`{}`", said.escape_debug()),
                ));
            }
        }
        for (key, item, table) in tables(root, &format!("{path}.coefficients")) {
            if let Some(found) =
                coefficient(&format!("{path}.coefficients.{key}"), key, item, table, declares.formulas())
            {
                return Some(found);
            }
        }
    }
    None
}

fn coefficient(path: &str, key: &str, item: &Item, table: &dyn TableLike, formula: bool) -> Option<Wrong> {
    if key == "tune" {
        return Some(wrong(
            path.into(),
            Some(item),
            "another key than `tune`, which says whether `tune` fits it",
            "`tune`",
        ));
    }
    let number = |key: &str| table.get(key).and_then(item_number);
    let at = |key: &str| (format!("{path}.{key}"), table.get(key));
    let (min, max) = (number("min")?, number("max")?);
    let absent = number("absent").unwrap_or(if formula { 0.5 * (min + max) } else { 0.0 });
    let typical = number("typical").unwrap_or(0.0);
    let (place, found) = if min >= max {
        (at("max"), (format!("more than min = {min}"), max.to_string()))
    } else if !(min..=max).contains(&absent) {
        let written = if table.get("absent").is_some() {
            "absent"
        } else if absent < min {
            "min"
        } else {
            "max"
        };
        let expected = format!("bounds that hold absent = {absent}, the value without the effect");
        (at(written), (expected, format!("{min} to {max}")))
    } else if absent + typical > max && absent - typical < min {
        let expected = format!("at most {}, so that fits begin within the bounds", (max - absent).max(absent - min));
        (at("typical"), (expected, typical.to_string()))
    } else {
        let ends: Vec<f64> =
            table.get("plausible").and_then(Item::as_array)?.iter().filter_map(schema::number).collect();
        let &[low, high] = ends.as_slice() else { return None };
        if low < high && low < max && high > min {
            return None;
        }
        (at("plausible"), (format!("[low, high] that overlap {min} to {max}"), format!("[{low}, {high}]")))
    };
    let ((path, item), (expected, found)) = (place, found);
    Some(wrong(path, item, expected, found))
}

/// The candidate that a table declares.
fn candidate(item: &Item) -> Option<Candidate> {
    let table = item.clone().into_table().ok()?;
    toml_edit::de::from_document(toml_edit::DocumentMut::from(table)).ok()
}

/// What is wrong with the formulas of candidates.
fn formulas(root: &Table, declares: Declares) -> Option<Wrong> {
    let mass_kg = lookup(root, "ball.mass_kg").and_then(item_number);
    for (name, item, table) in tables(root, "candidates") {
        let path = format!("candidates.{name}");
        let Some(candidate) = candidate(item) else {
            let found = "one whose values do not fit its keys";
            return Some(wrong(path, Some(item), "a candidate as docs/files.md describes it", found));
        };
        let made = match declares {
            Declares::Arm => FormulaEffect::of_arm(name, &candidate, None),
            Declares::Robot => FormulaEffect::of_robot(name, &candidate, None),
            _ => FormulaEffect::of_ball(name, &candidate, mass_kg),
        };
        if let Err(misfit) = made {
            let at = misfit.key.split('.').try_fold(item, |item, key| item.as_table_like()?.get(key)).or(Some(item));
            let (path, mut span, expected, found) =
                wrong(format!("{path}.{}", misfit.key), at, misfit.expected, misfit.found);
            if let Some(place) = misfit.place {
                // Behind the quote, as far as the text holds no escape.
                span = span.start + 1 + place.start..span.start + 1 + place.end;
            }
            return Some((path, span, expected, found));
        }
        for (variable, value) in table.get("valid").and_then(Item::as_table_like).into_iter().flat_map(|t| t.iter()) {
            let ends: Vec<f64> = value.as_array().into_iter().flatten().filter_map(schema::number).collect();
            if ends.len() == 2 && ends[0] >= ends[1] {
                let found = format!("[{}, {}]", ends[0], ends[1]);
                return Some(wrong(format!("{path}.valid.{variable}"), Some(value), "[low, high]", found));
            }
        }
    }
    None
}

/// Every `[effects.NAME]` is declared or built in.
fn effects(root: &Table, declares: Declares) -> Option<Wrong> {
    let declared: Vec<&str> = tables(root, "candidates").iter().map(|(name, ..)| *name).collect();
    for (name, item, table) in tables(root, "effects").into_iter().filter(|(name, ..)| !declares.is_built_in(name)) {
        let path = format!("effects.{name}");
        if !declared.contains(&name) {
            let all = declares.built_in();
            let known = declared.iter().copied().chain(all.iter().map(String::as_str));
            let known: Vec<String> = known.map(|name| format!("`{name}`")).collect();
            let expected = format!("a declared candidate or a built-in effect ({})", known.join(", "));
            return Some(wrong(path, Some(item), expected, format!("`{name}`, which no [candidates.{name}] declares")));
        }
        for (key, value) in table.iter().filter(|(key, _)| *key != "tune") {
            let of = format!("candidates.{name}.coefficients.{key}");
            let bound = |end: &str| lookup(root, &format!("{of}.{end}")).and_then(item_number);
            let (Some(min), Some(max)) = (bound("min"), bound("max")) else {
                let keys = tables(root, &format!("candidates.{name}.coefficients"));
                let keys: Vec<String> = keys.iter().map(|(key, ..)| format!("`{key}`")).collect();
                let expected = format!("a coefficient of the candidate ({})", keys.join(", "));
                return Some(wrong(format!("{path}.{key}"), Some(value), expected, format!("`{key}`")));
            };
            let numbers = numbers(root, name, key, value);
            let numbers = match numbers {
                Ok(numbers) => numbers,
                Err((expected, found)) => {
                    return Some(wrong(format!("{path}.{key}"), Some(value), expected, found));
                }
            };
            if let Some(number) = numbers.into_iter().find(|number| !(min..=max).contains(number)) {
                return Some(wrong(
                    format!("{path}.{key}"),
                    Some(value),
                    format!("{min} to {max}"),
                    number.to_string(),
                ));
            }
        }
    }
    None
}

/// The numbers of a coefficient, one or as many as it has directions; else what is expected and found.
fn numbers(root: &Table, name: &str, key: &str, value: &Item) -> Result<Vec<f64>, (String, String)> {
    let wanted = lookup(root, &format!("candidates.{name}"))
        .and_then(candidate)
        .map_or(1, |candidate| candidate.numbers_of(key));
    let given: Vec<f64> = match value.as_array() {
        Some(all) => all.iter().filter_map(schema::number).collect(),
        None => item_number(value).into_iter().collect(),
    };
    match (wanted, given.len(), value.is_array()) {
        (1, _, true) => Err(("one number".into(), "a list".into())),
        (wanted, found, _) if wanted != found => {
            Err((format!("[{wanted} numbers], one for each direction or joint"), found.to_string()))
        }
        _ => Ok(given),
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::super::SimulationFile;

    const FILE: &str = "kind = \"process\"
[process]
command = [\"./cart\"]
channels = [\"x_m\", \"theta_rad\"]
[parameters.mass_kg]
value = 1
min = 0
max = 2
[inputs.force_n]
hold = \"linear\"
[start.theta_rad]
value = \"first\"
sd = 0.01
min = -3.2
max = 3.2
[candidates.delay]
sentence = \"the motor acts late\"
acts = \"actuator\"
mistaken_for = []
[candidates.delay.coefficients.s]
unit = \"s\"
max = 0.1
min = 0
typical = 0.01
plausible = [0, 0.06]
[effects.delay]
s = 0.02
tune = true
";

    fn parsed(text: &str) -> Result<SimulationFile, String> {
        SimulationFile::parse(Path::new("cart.toml"), text).map_err(|error| error.to_string())
    }

    #[test]
    fn declarations_are_read_in_their_order_and_overridden_by_key() {
        let mut file = parsed(FILE).unwrap();
        assert_eq!(file.inputs().next().unwrap().1.channel("force_n").unwrap().unit, "N");
        assert_eq!(file.starts().next().unwrap().1.sd, Some(0.01));
        let declared = file.candidate("delay").unwrap();
        assert_eq!(declared.coefficients["s"].plausible, Some((0.0, 0.06)));
        assert_eq!((file.effects()[0].values.as_slice(), file.effects()[0].tune), ([0.02].as_slice(), true));
        file.set("start.theta_rad=-0.093").unwrap();
        assert_eq!(file.starts().next().unwrap().1.value, crate::scene::StartValue::Number(-0.093));
        file.set_all(&[("start.theta_rad.max", "1"), ("start.theta_rad.min", "-1"), ("start.theta_rad", "0")]).unwrap();
        assert_eq!(file.starts().next().unwrap().1.max, Some(1.0));
        file.add_effect("delay", &[("s", 0.05)]).unwrap();
        assert_eq!(file.effects()[0].values, [0.05]);
        let refused = file.add_effect("delay", &[("s", 0.5)]).unwrap_err().to_string();
        assert!(refused.contains("a number from 0 to 0.1 for `effects.delay.s`"), "{refused}");
        assert!(file.add_effect("backlash", &[("rad", 0.1)]).is_err());
        let before = file.clone();
        assert!(file.set("effects.backlash.rad=0.1").unwrap_err().to_string().contains("declares"));
        assert_eq!(file, before);
    }

    /// A program says where fits of its numbers begin; a formula's number begins within its range.
    #[test]
    fn a_formula_may_leave_out_where_fits_of_its_numbers_begin() {
        let refused = parsed(&FILE.replace("typical = 0.01\n", "")).unwrap_err();
        assert!(refused.contains("`candidates.delay.coefficients.s`: expected `typical`"), "{refused}");
        let equations = "kind = \"equations\"\nstates.x_m = {}\nstart.x_m.value = 1\nderivatives.x_m = \"-k*x_m\"\n\
                         outputs.x_m = \"x_m\"\nparameters.k = { value = 1, min = 0, max = 2 }\n\
                         candidates.drift = { sentence = \"it drifts\", acts = \"body\", adds.x_m = \"c\", \
                         coefficients.c = { unit = \"m/s\", min = -1, max = 3 } }\n";
        let file = parsed(equations).unwrap();
        let own = &file.candidate("drift").unwrap().coefficients["c"];
        assert!((own.typical(false) - 0.2).abs() < 1e-15);
    }

    #[test]
    fn what_contradicts_itself_is_refused_with_its_place() {
        for (from, to, place, wanted) in [
            (
                "[inputs.force_n]",
                "[inputs.force]",
                "9:",
                "`inputs.force`: expected a lower-case name that ends in its unit",
            ),
            ("hold = \"linear\"", "hold = \"cubic\"", "10:8", "expected \"previous\" or \"linear\", found \"cubic\""),
            ("hold = \"linear\"", "holds = 1", "10:1", "found `inputs.force_n.holds`"),
            ("hold = \"linear\"", "unit = \"V\"", "10:8", "expected N, the unit in which the name ends, found `V`"),
            ("[inputs.force_n]", "[inputs.x_m]", "9:", "a name that no channel has"),
            ("[inputs.force_n]", "[inputs.t_s]", "9:", "another name than the clock's"),
            ("[start.theta_rad]", "[start.theta]", "11:", "ends in its unit"),
            ("[start.theta_rad]", "[start.omega_rad_s]", "12:9", "`process.channels` has no `omega_rad_s`"),
            ("value = \"first\"\n", "", "11:", "expected `value` (the state at the first stamp"),
            ("value = \"first\"", "value = \"last\"", "12:9", "or \"first\", found \"last\""),
            ("value = \"first\"", "value = 7", "12:9", "expected -3.2 to 3.2, found 7"),
            ("min = -3.2\n", "", "14:7", "expected `min` with `max`, found only max = 3.2"),
            ("sd = 0.01", "sd = 0", "13:6", "expected a number from"),
            ("candidates.delay", "candidates.time_offset", "16:", "a name that no built-in effect has"),
            ("candidates.delay", "candidates.mass_kg", "16:", "`mass_kg` under [parameters] too"),
            ("min = 0\ntypical", "min = 0.02\ntypical", "23:7", "bounds that hold absent = 0"),
            ("typical = 0.01", "typical = 0", "24:11", "expected a number from"),
            ("typical = 0.01", "typical = 0.2", "24:11", "expected at most 0.1"),
            ("plausible = [0, 0.06]", "plausible = [0.2, 0.3]", "25:13", "that overlap 0 to 0.1"),
            ("max = 0.1\n", "", "20:", "expected `max` (greatest value that is fitted), found none"),
            (
                "[effects.delay]",
                "[effects.backlash]",
                "26:",
                "found `backlash`, which no [candidates.backlash] declares",
            ),
            ("s = 0.02", "rad = 0.02", "27:7", "a coefficient of the candidate (`s`)"),
            ("s = 0.02", "s = 0.2", "27:5", "expected 0 to 0.1, found 0.2"),
            ("acts = \"actuator\"", "acts = \"\"", "18:8", "expected a word"),
            (
                "[candidates.delay.coefficients.s]",
                "[candidates.delay.coefficients.tune]",
                "20:",
                "another key than `tune`",
            ),
        ] {
            assert!(FILE.contains(from), "{from}");
            let refused =
                parsed(&if from == "candidates.delay" { FILE.replace(from, to) } else { FILE.replacen(from, to, 1) })
                    .unwrap_err();
            assert!(refused.contains(wanted) && refused.starts_with(&format!("cart.toml:{place}")), "{to}: {refused}");
        }
        assert!(parsed(&format!("{FILE}[inputs.force_n]\n")).unwrap_err().contains("duplicate key"));
        assert!(parsed("kind = \"ball\"\nball.radius_m = 0.1\n[inputs.force_n]\n").is_err());
    }
}
