//! Holds a parsed file against the schema and says where it departs from it.

use std::ops::Range;
use std::path::Path;

use toml_edit::{Item, Table, TableLike};
use tunenet_formats::{Error, Result};

use super::declared_check::Wrong;
use super::domain::Domain;
use super::schema::{Key, PARAMETER_KEYS, item_number, lookup};
use super::{declared_check, equations_schema, process_schema, robot_schema};

/// Checks a whole file: every key known, every value fitting, nothing required missing. What it describes comes back.
pub(super) fn document(path: &Path, text: &str, root: &Table) -> Result<Domain> {
    let domain = domain(path, text, root)?;
    walk(&domain, path, text, root, "")?;
    for key in domain.keys().filter(|k| k.required) {
        if lookup(root, &key.path).is_none() {
            let message = format!("expected `{}` ({}), found none", key.path, key.meaning);
            let (table, name) = key.path.split_once('.').unwrap_or(("", &key.path));
            return Err(Error::file(path, message, format!("add `{name} = …` under [{table}]")));
        }
    }
    if domain.declares() && names(domain, root).is_empty() {
        let taken = match domain {
            Domain::Process => "the program takes",
            Domain::Robot => "a joint has, such as elbow__coulomb",
            _ => "formulas use",
        };
        let message = format!("expected at least one [parameters.NAME] (a number that {taken}), found none");
        return Err(Error::file(path, message, "a parameter needs value, min and max"));
    }
    for name in names(domain, root) {
        let Some(table) = lookup(root, &format!("parameters.{name}")).and_then(Item::as_table_like) else { continue };
        if let Some(key) = PARAMETER_KEYS.iter().find(|k| k.required && table.get(&k.path).is_none()) {
            let message = format!("expected `{}` ({}) in [parameters.{name}], found none", key.path, key.meaning);
            return Err(Error::file(path, message, "a parameter needs value, min and max"));
        }
    }
    let example = || format!("`tunenet init {}` writes an example with comments", domain.name());
    let entry = contradiction_of_kind(domain, root).map(|wrong| (wrong, example()));
    let bounds =
        || contradiction_of_bounds(domain, root).map(|wrong| (wrong, "correct the value or its bounds".into()));
    match entry.or_else(bounds) {
        Some(((key, span, expected, found), hint)) => {
            Err(located(path, text, span, format!("`{key}`: expected {expected}, found {found}"), &hint))
        }
        None => Ok(domain),
    }
}

/// What the file describes.
fn domain(path: &Path, text: &str, root: &Table) -> Result<Domain> {
    let each: Vec<String> = Domain::ALL.iter().map(|d| format!("\"{}\"", d.name())).collect();
    let expected = each.join(" or ");
    let Some(kind) = root.get("kind") else {
        let message = format!("expected `kind = {expected}`, found no `kind`");
        let hint = "is this a simulation file? `tunenet init` writes one to start from";
        return Err(Error::file(path, message, hint));
    };
    kind.as_str().and_then(Domain::named).ok_or_else(|| {
        let found = kind.to_string();
        let message = format!("`kind`: expected {expected}, found {}", found.trim());
        located(path, text, kind.span().unwrap_or(0..0), message, "kind: what is simulated")
    })
}

/// The parameters that a file may describe, or, where it names them itself, those that it describes.
pub(super) fn names(domain: Domain, root: &Table) -> Vec<&str> {
    if !domain.declares() {
        return domain.parameters().iter().map(|p| p.name).collect();
    }
    let all = lookup(root, "parameters").and_then(Item::as_table_like);
    all.map_or_else(Vec::new, |all| all.iter().map(|(name, _)| name).collect())
}

/// The first value that contradicts another, a parameter's its bounds, say: its path, place, what is expected and found.
pub(super) fn contradiction(domain: Domain, root: &Table) -> Option<Wrong> {
    contradiction_of_kind(domain, root).or_else(|| contradiction_of_bounds(domain, root))
}

/// Contradictions between entries that only one kind of file has.
fn contradiction_of_kind(domain: Domain, root: &Table) -> Option<Wrong> {
    match domain {
        Domain::Process => process_schema::contradiction(root),
        Domain::Equations => equations_schema::contradiction(root),
        Domain::Robot => robot_schema::contradiction(root),
        Domain::Ball | Domain::Arm => declared_check::contradiction(root, domain.declared()),
    }
}

/// Values of parameters outside their bounds, and bounds that are none.
fn contradiction_of_bounds(domain: Domain, root: &Table) -> Option<Wrong> {
    for name in names(domain, root) {
        let table = lookup(root, &format!("parameters.{name}")).and_then(Item::as_table_like);
        let Some(table) = table else { continue };
        let get =
            |field: &str| table.get(field).and_then(|item| Some((item_number(item)?, item.span().unwrap_or(0..0))));
        let (Some((min, _)), Some((max, max_span)), Some((value, span))) = (get("min"), get("max"), get("value"))
        else {
            continue;
        };
        if min >= max {
            return Some((
                format!("parameters.{name}.max"),
                max_span,
                format!("more than min = {min}"),
                max.to_string(),
            ));
        }
        if !(min..=max).contains(&value) {
            return Some((format!("parameters.{name}.value"), span, format!("{min} to {max}"), value.to_string()));
        }
        let Some(known) = domain.parameter(name) else { continue };
        let (least, most) = known.bounds;
        if min < least || max > most {
            let what = if min < least { ("min", min) } else { ("max", max) };
            let span = get(what.0).map_or(0..0, |(_, span)| span);
            return Some((format!("parameters.{name}.{}", what.0), span, known.within.into(), what.1.to_string()));
        }
    }
    None
}

/// Which keys a file may hold.
pub(crate) trait Vocabulary {
    /// The key at a path.
    fn find(&self, path: &str) -> Option<Key>;
    /// Whether there is a table at a path.
    fn has_table(&self, path: &str) -> bool;
    /// What could have been meant instead of an unknown path.
    fn siblings(&self, path: &str) -> Vec<String>;
    /// What is said of an unknown key.
    fn unknown(&self, key: &str) -> String;
    /// A table that is not looked into.
    fn passes_over(&self, path: &str) -> bool;
}

impl Vocabulary for Domain {
    fn find(&self, path: &str) -> Option<Key> {
        Domain::find(*self, path)
    }

    fn has_table(&self, path: &str) -> bool {
        let inside = format!("{path}.");
        let parameter = path.strip_prefix("parameters.").is_some_and(|name| self.has_parameter(name));
        let declared = self.declared().has_table(path);
        path == "parameters" || parameter || declared || self.keys().any(|k| k.path.starts_with(&inside))
    }

    fn siblings(&self, path: &str) -> Vec<String> {
        Domain::siblings(*self, path)
    }

    fn unknown(&self, key: &str) -> String {
        // Names of effects are a file's own: they belong to no other kind.
        let own = |other: &Domain| key.starts_with("effects.") && !other.keys().any(|known| known.path == key);
        let known = |other: &Domain| !own(other) && (other.find(key).is_some() || other.has_table(key));
        let other = Domain::ALL.into_iter().find(known);
        match other {
            Some(other) => {
                format!(
                    "expected a key of `kind = \"{}\"`, found `{key}` of `kind = \"{}\"`",
                    self.name(),
                    other.name()
                )
            }
            None => format!("expected a key of a simulation file, found `{key}`"),
        }
    }

    fn passes_over(&self, path: &str) -> bool {
        path == "provenance" || *self == Domain::Process && path == "settings"
    }
}

/// Refuses keys that `known` does not hold, and values that do not fit theirs.
pub(crate) fn walk(
    known: &impl Vocabulary,
    path: &Path,
    text: &str,
    table: &dyn TableLike,
    prefix: &str,
) -> Result<()> {
    for (name, item) in table.iter() {
        let full = format!("{prefix}{name}");
        if known.passes_over(&full) {
            continue;
        }
        let key_span =
            || table.get_key_value(name).and_then(|(key, _)| key.span()).or_else(|| item.span()).unwrap_or(0..0);
        let misfit = |key: &Key, found: &str, span: Range<usize>| {
            let message = format!("`{full}`: expected {}, found {found}", key.shape.expected());
            Err(located(path, text, span, message, &format!("{full}: {}", key.meaning)))
        };
        match (item.as_value().filter(|v| !v.is_inline_table()), item.as_table_like(), known.find(&full)) {
            (Some(value), _, Some(key)) if !key.shape.accepts(value) => {
                let span = value.span().unwrap_or(0..0);
                // As it was written: 1e300 has 301 digits.
                let written = text.get(span.clone()).filter(|written| !written.is_empty());
                return misfit(&key, written.map_or_else(|| value.to_string(), str::to_owned).trim(), span);
            }
            (Some(_), _, Some(_)) => {}
            (None, Some(inner), _) if known.has_table(&full) => {
                walk(known, path, text, inner, &format!("{full}."))?;
            }
            (None, _, Some(key)) => return misfit(&key, "a table", key_span()),
            (_, _, None) => return Err(unknown(known, path, text, key_span(), &full)),
        }
    }
    Ok(())
}

fn unknown(known: &impl Vocabulary, path: &Path, text: &str, span: Range<usize>, key: &str) -> Error {
    located(path, text, span, known.unknown(key), &format!("known here: {}", known.siblings(key).join(", ")))
}

/// An error at a place of the text.
pub(crate) fn located(path: &Path, text: &str, span: Range<usize>, message: String, hint: &str) -> Error {
    let start = span.start.min(text.len());
    let before = text.get(..start).unwrap_or("");
    let line_start = before.rfind('\n').map_or(0, |i| i + 1);
    let source_line = text.get(line_start..).and_then(|rest| rest.lines().next()).unwrap_or("").to_string();
    let width = text.get(span).map_or(1, |s| s.lines().next().unwrap_or("").chars().count()).max(1);
    Error::Text {
        path: path.to_path_buf(),
        line: before.matches('\n').count() + 1,
        column: text.get(line_start..start).map_or(0, |s| s.chars().count()) + 1,
        width,
        source_line,
        message,
        hint: hint.to_string(),
    }
}
