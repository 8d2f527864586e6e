//! The keys of `[inputs]`, `[start]` and `[candidates]`, whose tables a file names itself, and what no key alone can say of them.

use std::ops::Range;

use toml_edit::{Item, Table, TableLike};
use tunenet_core::observation::{Channel, Kind};
use tunenet_core::simulator::measurement_effects;

use super::equations_keys::{ADDS, CONSTANT, DERIVATIVE, EVENT_KEYS, OUTPUT, STATE_KEYS, THEN};
use super::schema::{GREATEST, Key, Shape, is_name, item_number, key, lookup, texts};
use crate::arm::effects as arm;
use crate::ball::effects as ball;
use crate::formula_effect::FormulaEffect;
use crate::scene::Candidate;

const ANY: Shape = Shape::Number(-GREATEST, GREATEST);
const TEXT: Shape = Shape::Word(&[]);

/// The keys of `[inputs.NAME]`.
pub const INPUT_KEYS: &[Key] = &[
    key(
        "hold",
        Shape::Word(&["previous", "linear"]),
        false,
        "its value between samples: that of the sample before, or on the line between both (default: previous)",
    ),
    key("column", TEXT, false, "what the file calls it (default: its name)"),
    key("file", TEXT, false, "the file that holds it, from the folder of the recording (default: the recording)"),
    key("topic", TEXT, false, "the topic of an MCAP log that holds it"),
    key("time_column", TEXT, false, "the column of its own clock, in s (default: that of its file)"),
    key("unit", TEXT, false, "its unit, where its name does not end in one"),
    key("default", ANY, false, "its value where a recording does not have it"),
];

/// The keys of `[start.NAME]`.
pub const START_KEYS: &[Key] = &[
    key(
        "value",
        Shape::NumberOrWord(-GREATEST, GREATEST, "first"),
        true,
        "the state at the first stamp: a number, or the first sample of the channel of its name; alone it is fixed",
    ),
    key("sd", Shape::Number(1e-12, GREATEST), false, "standard deviation of the prior around `value`: it is estimated"),
    key("min", ANY, false, "least value; with `max` and without `sd` it is estimated freely between both"),
    key("max", ANY, false, "greatest value"),
];

/// The keys of `[candidates.NAME]`.
pub const CANDIDATE_KEYS: &[Key] = &[
    key("sentence", TEXT, true, "one sentence that says what it does"),
    key(
        "acts",
        TEXT,
        true,
        "where it acts, in a word: flight, contact, joint, measurement, sensor, actuator or another",
    ),
    key("mistaken_for", Shape::Names, false, "effects that some recordings cannot distinguish from it"),
];

/// The further keys of `[candidates.NAME]` in a ball's or an arm's file, where a formula says what it does.
pub const FORMULA_KEYS: &[Key] = &[
    key("formula", TEXT, true, "what it adds: a formula of the world's variables and its own coefficients"),
    key(
        "along",
        Shape::Names,
        false,
        "in flight, the directions: v, r, x, y, z, spin, across, around; at a joint dq or none",
    ),
    key(
        "gives",
        TEXT,
        false,
        "what the formula gives: m_s2 or n in flight, restitution at a contact, nm at a joint (default: the first)",
    ),
    key(
        "per_direction",
        Shape::Names,
        false,
        "coefficients with one number for each direction, or for each of `joints`",
    ),
    key("centre", Shape::Numbers(3, -1e6, 1e6), false, "from where `r_m` is measured, in m (default: the origin)"),
    key("joints", Shape::Texts, false, "the joints at which it acts (default: all)"),
];
const RANGE: Key = key(
    "valid",
    Shape::Numbers(2, -GREATEST, GREATEST),
    false,
    "between which values of a variable it was seen to hold",
);
const NUMBERS: Shape = Shape::NumberOrList(-GREATEST, GREATEST);

/// The keys of `[candidates.NAME.coefficients.KEY]`.
pub const COEFFICIENT_KEYS: &[Key] = &[
    key("unit", TEXT, false, "its unit (default: 1)"),
    key(
        "absent",
        ANY,
        false,
        "the value at which the effect is absent (default: 0; of a formula's number, none: it only shapes the effect)",
    ),
    key("min", ANY, true, "least value that is fitted"),
    key("max", ANY, true, "greatest value that is fitted"),
    key(
        "typical",
        Shape::Number(1e-12, GREATEST),
        true,
        "distance from `absent` at which fits begin (of a formula's number by default a part of the range)",
    ),
    key("plausible", Shape::Numbers(2, -GREATEST, GREATEST), false, "outside it fits, and is not plausible"),
];

const TUNE: Key = key("tune", Shape::Flag, false, "whether `tune` may change these numbers (default: false)");
const NUMBER: Key = key("effects", NUMBERS, false, "coefficient of a declared candidate");

/// What a kind of file declares itself.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Declares {
    /// Inputs, initial states and candidates of a program.
    Program,
    /// Candidates of a ball.
    Ball,
    /// Candidates of an arm.
    Arm,
    /// States, formulas, constants, events, inputs, initial states and candidates of equations.
    Equations,
}

impl Declares {
    /// Heads of the tables that a file names itself.
    pub(super) fn heads(self) -> &'static [&'static str] {
        match self {
            Self::Program => &["inputs", "start", "candidates"],
            Self::Equations => {
                &["states", "derivatives", "outputs", "constants", "inputs", "start", "events", "candidates"]
            }
            Self::Ball | Self::Arm => &["candidates"],
        }
    }

    /// Whether candidates are formulas.
    fn formulas(self) -> bool {
        matches!(self, Self::Ball | Self::Arm)
    }

    /// Whether a built-in effect bears this name.
    pub(super) fn is_built_in(self, name: &str) -> bool {
        self.built_in().iter().any(|known| known == name)
    }

    /// The names of the effects that are built in.
    fn built_in(self) -> Vec<String> {
        let measured = |kind| measurement_effects(kind).into_iter().map(|effect| effect.name.into_owned());
        match self {
            Self::Program | Self::Equations => {
                // The first are those that a series of any kind can show.
                let mut all: Vec<String> = measured(Kind::Other).collect();
                all.extend(measured(Kind::Positions).filter(|name| measured(Kind::Other).all(|known| known != *name)));
                all
            }
            Self::Ball => ball::ALL.iter().map(|e| e.name.to_owned()).chain(measured(Kind::Positions)).collect(),
            Self::Arm => arm::ALL.iter().map(|e| e.name.to_owned()).collect(),
        }
    }

    /// The keys of the table at `path`, where it is one that a file names itself.
    fn keys(self, path: &[&str]) -> Option<Vec<&'static Key>> {
        let only = |keys: &'static [Key]| Some(keys.iter().collect());
        match *path {
            [head, ..] if !self.heads().contains(&head) => None,
            ["inputs", name] if is_name(name) => only(INPUT_KEYS),
            ["start", name] if is_name(name) => only(START_KEYS),
            ["states", name] if is_name(name) => only(STATE_KEYS),
            ["events", name] if is_name(name) => only(EVENT_KEYS),
            ["candidates", name] if is_name(name) && self.formulas() => {
                Some(CANDIDATE_KEYS.iter().chain(FORMULA_KEYS).collect())
            }
            ["candidates", name] if is_name(name) => only(CANDIDATE_KEYS),
            ["candidates", name, "coefficients", one] if is_name(name) && is_name(one) => only(COEFFICIENT_KEYS),
            _ => None,
        }
    }

    /// The key of whatever name stands in the table at `path`, where names of the file are its keys.
    fn named(self, path: &[&str]) -> Option<Key> {
        match path {
            _ if self != Self::Equations => None,
            ["derivatives"] => Some(DERIVATIVE),
            ["outputs"] => Some(OUTPUT),
            ["constants"] => Some(CONSTANT),
            ["events", name, "then"] if is_name(name) => Some(THEN),
            ["candidates", name, "adds"] if is_name(name) => Some(ADDS),
            _ => None,
        }
    }

    /// The key at `path`.
    pub(super) fn find(self, path: &str) -> Option<Key> {
        let parts: Vec<&str> = path.split('.').collect();
        let (last, table) = parts.split_last()?;
        match table {
            ["effects", name] if is_name(name) && !self.is_built_in(name) && is_name(last) => {
                Some(if *last == "tune" { TUNE } else { NUMBER })
            }
            ["candidates", name, "valid"] if self.formulas() && is_name(name) && is_name(last) => Some(RANGE),
            _ if self == Self::Equations && is_name(last) && self.named(table).is_some() => self.named(table),
            _ => self.keys(table)?.into_iter().find(|key| key.path == *last).cloned(),
        }
    }

    /// Whether there is a table at `path`.
    pub(super) fn has_table(self, path: &str) -> bool {
        let parts: Vec<&str> = path.split('.').collect();
        match parts[..] {
            [head] => self.heads().contains(&head),
            ["effects", name] => is_name(name) && !self.is_built_in(name),
            ["candidates", name, "coefficients"] => is_name(name),
            ["candidates", name, "valid"] => self.formulas() && is_name(name),
            _ if self.named(&parts).is_some() => true,
            _ => self.keys(&parts).is_some(),
        }
    }

    /// What could have been meant in the table at `table`; empty where a file does not name it itself.
    pub(super) fn siblings(self, table: &str) -> Vec<String> {
        let parts: Vec<&str> = table.split('.').collect();
        let named = |keys: Vec<&Key>| keys.iter().map(|key| key.path.to_string()).collect::<Vec<_>>();
        match parts[..] {
            ["candidates", _] => {
                let own = self.keys(&parts).map(named).unwrap_or_default();
                let adds = (self == Self::Equations).then(|| "adds.STATE".to_owned());
                [own, adds.into_iter().collect(), vec!["coefficients.KEY".into()]].concat()
            }
            ["candidates", _, "coefficients"] => vec!["a key of letters, digits and _, with its own table".into()],
            ["events", _] if self == Self::Equations => vec!["when".into(), "then.STATE".into()],
            [head] if self.heads().contains(&head) => vec![format!("{head}.NAME, of letters, digits and _")],
            _ if self.named(&parts).is_some() => vec!["a name of letters, digits and _".into()],
            _ => self.keys(&parts).map(named).unwrap_or_default(),
        }
    }
}

/// What is wrong: the path, its place, what is expected and what is found.
type Wrong = (String, Range<usize>, String, String);

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
            let keys = if declares.formulas() { "`min` and `max`" } else { "`min`, `max` and `typical`" };
            let expected = format!("at least one [{within}.KEY] with {keys}");
            return Some(wrong(format!("candidates.{name}"), Some(item), expected, "none"));
        }
        for (key, item, table) in all {
            // A formula's number has a range to begin in.
            let needed = COEFFICIENT_KEYS.iter().filter(|key| !(declares.formulas() && key.path == "typical"));
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
    lookup(root, "process.channels")
        .map(texts)
        .or_else(|| names("outputs"))
        .or_else(|| names("states"))
        .unwrap_or_default()
}

/// Where the file names its channels.
fn naming_channels(root: &Table) -> &'static str {
    if has(root, "process") { "process.channels" } else { "outputs" }
}

fn has(root: &Table, path: &str) -> bool {
    lookup(root, path).is_some()
}

fn text<'a>(table: &'a dyn TableLike, key: &str) -> Option<&'a str> {
    table.get(key).and_then(Item::as_str)
}

const UNIT: &str =
    "a name in small letters that ends in its unit, such as `force_n`, `theta_rad` or, without one, `throttle_1`";

fn inputs(root: &Table) -> Option<Wrong> {
    for (name, item, table) in tables(root, "inputs") {
        let path = format!("inputs.{name}");
        let (unit, of_name) = (text(table, "unit"), Channel::from_header(name));
        match (unit, &of_name) {
            (None, None) => {
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

fn candidates(root: &Table, declares: Declares) -> Option<Wrong> {
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
            table.get("plausible").and_then(Item::as_array)?.iter().filter_map(super::schema::number).collect();
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
            let ends: Vec<f64> = value.as_array().into_iter().flatten().filter_map(super::schema::number).collect();
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
        Some(all) => all.iter().filter_map(super::schema::number).collect(),
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

    #[test]
    fn what_contradicts_itself_is_refused_with_its_place() {
        for (from, to, place, wanted) in [
            (
                "[inputs.force_n]",
                "[inputs.force]",
                "9:",
                "`inputs.force`: expected a name in small letters that ends in its unit",
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
