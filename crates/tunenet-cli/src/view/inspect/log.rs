//! What `inspect` says of a log.

use std::path::Path;

use serde_json::{Value, json};
use tunenet_core::observation::{Check, Note, with_decimals};
use tunenet_formats::{JointQuantity, Log, kind_name, of_some_joint, shell_word};

use super::joints;
use super::motion::add_to;
use crate::answers::motion::Motion;
use crate::view::answer::Printout;
use crate::view::json::warning;
use crate::view::text::without_try;

/// The topics of a log.
pub fn contents(found: &Log, shown: &mut Printout) {
    let span = found.span_s.map_or_else(String::new, |s| format!(", {} s", with_decimals(s, 2)));
    shown.row(
        "log",
        &format!("{}{}, profile `{}`, written by `{}`", topics(found.topics.len()), span, found.profile, found.library),
    );
    let rows: Vec<Vec<String>> = found
        .topics
        .iter()
        .map(|t| {
            let usable =
                t.usable.as_ref().map_or_else(|reason| format!("- {reason}"), |kind| kind_name(*kind).to_string());
            let rate = t.rate_hz().map_or_else(String::new, |rate| format!("{} Hz", with_decimals(rate, 1)));
            vec![t.name.clone(), t.schema.clone(), t.encoding.clone(), t.messages.to_string(), rate, usable]
        })
        .collect();
    shown.table(&rows);
    for topic in found.topics.iter().filter(|t| t.usable.is_err() && !t.columns.is_empty()).take(MOST_NUMBERED) {
        shown.row("numbers", &format!("{}: {}", topic.name, numbers(&topic.columns)));
    }
}

/// Most topics whose numbers are listed, and most numbers of each.
const MOST_NUMBERED: usize = 12;
const MOST_NAMED: usize = 8;

fn numbers(columns: &[String]) -> String {
    let more = columns.len().saturating_sub(MOST_NAMED);
    let named = columns[..columns.len() - more].join(", ");
    if more == 0 { named } else { format!("{named} and {more} more") }
}

/// The topic whose numbers are positions of joints by their names, where no topic is read without naming its numbers.
pub fn of_joints(found: &Log) -> Option<&str> {
    let position = |name: &String| {
        of_some_joint(name).is_some_and(|of| !of.command && of.quantity == Some(JointQuantity::Position))
    };
    let none = found.ended.is_none() && found.topics.iter().all(|topic| topic.usable.is_err());
    let topic = found.topics.iter().find(|topic| topic.columns.iter().any(position));
    topic.filter(|_| none).map(|topic| topic.name.as_str())
}

/// Whether it can be used: `rejected` says why its only recording cannot, and `named` is the topic that was read.
pub fn verdict(found: &Log, path: &Path, rejected: Option<&str>, named: Option<&str>, shown: &mut Printout) {
    let usable: Vec<&_> = found.topics.iter().filter(|t| t.usable.is_ok()).collect();
    match (usable.as_slice(), &found.ended) {
        (_, Some(reason)) => {
            let seconds = found.span_s.map_or_else(String::new, |s| format!(" and span {s:.2} s"));
            shown.row("unusable", &format!("{reason}{seconds}; the rest is missing, so `tune` refuses the file"));
            if !found.remedy.is_empty() {
                shown.line(&format!("  try: {}", without_try(&found.remedy)));
            }
        }
        _ if rejected.is_some() => shown.row("unusable", rejected.unwrap_or_default()),
        _ if named.is_some() => shown.row("usable", named.unwrap_or_default()),
        ([], _) if of_joints(found).is_some() => {
            let (topic, from) = (of_joints(found).unwrap_or_default(), shell_word(&path.to_string_lossy()));
            shown.row("usable", &format!("the numbers of {topic}, as joints of a robot"));
            let command = format!("tunenet init robot --model ROBOT.urdf --from {from}");
            shown.line(&format!("  try: `{command}` writes a simulation file of its joints"));
        }
        ([], _) => {
            shown.row("unusable", "no topic carries positions, joints or bounces");
            if let Some(kind) = found.topics.iter().find_map(|topic| topic.undefined.as_deref()) {
                let name = kind.rsplit('/').next().unwrap_or(kind);
                shown.line(&format!(
                    "  try: --msg {name}.msg, the definition of the type that the log does not contain"
                ));
            }
            if found.topics.iter().any(|topic| !topic.columns.is_empty()) {
                shown.line("  try: choose a topic with --topic, and name its numbers with --columns");
            }
        }
        ([one], _) => shown.row("usable", &one.name),
        (several, _) => shown.row("usable", &format!("{} topics, choose one with --topic", several.len())),
    }
}

/// The object of a log; `refused` says why its only topic cannot be read.
pub fn object(
    found: &Log,
    motion: Option<&Motion>,
    units: Option<&Check>,
    notes: &[Note],
    refused: Option<&str>,
) -> Value {
    let mut object = json!({
        "kind": "log", "profile": found.profile, "library": found.library,
        "topics": found.topics.iter().map(|t| json!({
            "name": t.name, "schema": t.schema, "encoding": t.encoding, "messages": t.messages, "rate_hz": t.rate_hz(),
            "usable": t.usable.as_ref().ok().map(|k| k.name()), "reason": t.usable.as_ref().err(), "columns": t.columns,
        })).collect::<Vec<_>>(),
        "span_s": found.span_s, "ended": found.ended, "remedy": found.remedy,
        "warnings": notes.iter().map(warning).collect::<Vec<_>>(),
    });
    if let Some(refused) = refused {
        object["reason"] = refused.into();
    }
    if let Some(motion) = motion {
        add_to(motion, &mut object);
    }
    if let Some(units) = units {
        joints::add_to(units, &mut object);
    }
    object
}

fn topics(count: usize) -> String {
    if count == 1 { "1 topic".into() } else { format!("{count} topics") }
}
