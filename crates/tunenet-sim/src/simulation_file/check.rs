//! Holds a parsed file against the schema and says where it departs from it.

use std::ops::Range;
use std::path::Path;

use toml_edit::{Item, Table, TableLike};
use tunenet_core::{Error, Result};

use super::schema::{BALL_KEYS, BALL_PARAMETERS, Key, PARAMETER_KEYS, find, item_number, keys, siblings};

/// Checks a whole file: every key known, every value fitting, nothing required missing.
pub(super) fn document(path: &Path, text: &str, root: &Table) -> Result<()> {
    if root.get("kind").is_none() {
        let message = "expected `kind = \"ball\"`, found no `kind`".to_string();
        return Err(Error::file(path, message, "is this a simulation file? assets/ball.toml is one to start from"));
    }
    walk(&SIMULATION, path, text, root, "")?;
    for key in BALL_KEYS.iter().filter(|k| k.required) {
        if lookup(root, &key.path).is_none() {
            let message = format!("expected `{}` ({}), found none", key.path, key.meaning);
            let (table, name) = key.path.split_once('.').unwrap_or(("", &key.path));
            return Err(Error::file(path, message, format!("add `{name} = …` under [{table}]")));
        }
    }
    for name in BALL_PARAMETERS {
        let Some(table) = lookup(root, &format!("parameters.{name}")).and_then(Item::as_table_like) else { continue };
        if let Some(key) = PARAMETER_KEYS.iter().find(|k| k.required && table.get(&k.path).is_none()) {
            let message = format!("expected `{}` ({}) in [parameters.{name}], found none", key.path, key.meaning);
            return Err(Error::file(path, message, "a parameter needs value, min and max"));
        }
    }
    if let Some((key, span, expected, found)) = parameters(root) {
        return Err(located(
            path,
            text,
            span,
            format!("`{key}`: expected {expected}, found {found}"),
            "correct the value or its bounds",
        ));
    }
    Ok(())
}

/// The first parameter whose bounds and value contradict each other: its path, place, what is expected and found.
pub(super) fn parameters(root: &Table) -> Option<(String, Range<usize>, String, String)> {
    for name in BALL_PARAMETERS {
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
        if min < 0.0 || *name == "restitution" && max > 1.0 {
            let what = if min < 0.0 { ("min", min) } else { ("max", max) };
            let expected = if *name == "restitution" {
                "bounds within 0 to 1 (above 1 a bounce gains energy)"
            } else {
                "0 or more"
            };
            let span = get(what.0).map_or(0..0, |(_, span)| span);
            return Some((format!("parameters.{name}.{}", what.0), span, expected.into(), what.1.to_string()));
        }
    }
    None
}

fn lookup<'a>(root: &'a Table, path: &str) -> Option<&'a Item> {
    let mut parts = path.split('.');
    let mut item = root.get(parts.next()?)?;
    for part in parts {
        item = item.as_table_like()?.get(part)?;
    }
    Some(item)
}

/// Which keys a file may hold.
pub(crate) struct Vocabulary {
    /// What such a file is called.
    pub file: &'static str,
    /// The key at a path.
    pub find: fn(&str) -> Option<Key>,
    /// Whether there is a table at a path.
    pub has_table: fn(&str) -> bool,
    /// What could have been meant beside an unknown path.
    pub siblings: fn(&str) -> Vec<String>,
    /// A table that is not looked into.
    pub passed_over: &'static str,
}

const SIMULATION: Vocabulary =
    Vocabulary { file: "a simulation file", find, has_table: known_table, siblings, passed_over: "provenance" };

/// Refuses keys that `known` does not hold, and values that do not fit theirs.
pub(crate) fn walk(known: &Vocabulary, path: &Path, text: &str, table: &dyn TableLike, prefix: &str) -> Result<()> {
    for (name, item) in table.iter() {
        let full = format!("{prefix}{name}");
        if full == known.passed_over {
            continue;
        }
        let key_span =
            || table.get_key_value(name).and_then(|(key, _)| key.span()).or_else(|| item.span()).unwrap_or(0..0);
        match item.as_value().filter(|v| !v.is_inline_table()) {
            Some(value) => {
                let Some(key) = (known.find)(&full) else { return Err(unknown(known, path, text, key_span(), &full)) };
                if !key.shape.accepts(value) {
                    let found = value.to_string();
                    let message = format!("`{full}`: expected {}, found {}", key.shape.expected(), found.trim());
                    return Err(located(
                        path,
                        text,
                        value.span().unwrap_or(0..0),
                        message,
                        &format!("{full}: {}", key.meaning),
                    ));
                }
            }
            None => match item.as_table_like() {
                Some(inner) if (known.has_table)(&full) => walk(known, path, text, inner, &format!("{full}."))?,
                _ => return Err(unknown(known, path, text, key_span(), &full)),
            },
        }
    }
    Ok(())
}

fn known_table(path: &str) -> bool {
    let inside = format!("{path}.");
    let parameter = path.strip_prefix("parameters.").is_some_and(|name| BALL_PARAMETERS.contains(&name));
    path == "parameters" || parameter || keys().any(|k| k.path.starts_with(&inside))
}

fn unknown(known: &Vocabulary, path: &Path, text: &str, span: Range<usize>, key: &str) -> Error {
    let hint = format!("known here: {}", (known.siblings)(key).join(", "));
    located(path, text, span, format!("expected a key of {}, found `{key}`", known.file), &hint)
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
