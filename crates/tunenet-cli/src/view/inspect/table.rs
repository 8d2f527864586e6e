//! What `inspect` says of a table of numbers.

use serde_json::{Value, json};
use tunenet_core::observation::{Check, Kind, Note};
use tunenet_formats::{Column, Table, kind_name};

use super::motion::add_to;
use super::{described, joints};
use crate::answers::motion::Motion;
use crate::view::answer::Printout;
use crate::view::json::warning;
use crate::view::text::without_try;

/// What a table contains, in words.
pub fn contents(found: &Table, shown: &mut Printout) {
    // A table whose columns say nothing has rows and no samples: what to type comes first.
    let samples = if found.samples == 0 { String::new() } else { format!(", {} samples", found.samples) };
    shown.row("table", &format!("{} rows{samples}", found.rows));
    let plain = |c: &Column| vec![c.name.clone(), c.read_as.clone().unwrap_or_else(|| "-".into())];
    let plain = || found.columns.iter().map(plain).collect::<Vec<_>>();
    shown.table(&described::of(found).map_or_else(plain, |described| described::rows(found, described)));
    if let (Some((first, last)), Some(rate)) = (found.span_s, found.median_rate_hz) {
        let gap = found.largest_gap_s.unwrap_or(0.0);
        let [first, last] = [first, last].map(|t| (t * 1e6).round() / 1e6);
        shown.row("clock", &format!("{first} s to {last} s, {rate:.1} Hz, largest gap {gap:.4} s"));
    }
    for line in &found.broken {
        shown.row("broken", &format!("line {}: {}", line.line, line.message));
    }
    if found.broken_count > found.broken.len() {
        shown.row("broken", &format!("{} more lines", found.broken_count - found.broken.len()));
    }
    if let Some((first, last)) = whole_lines(found) {
        let header = if first > 1 && has_header(found) { "1p;" } else { "" };
        shown.row("whole", &format!("lines {first} to {last}: `sed -n '{header}{first},{last}p'` cuts them out"));
        shown.line("  try: clear single bad cells; a line with an empty cell is skipped");
    }
}

/// Whether it can be used, and what to type where it cannot.
pub fn verdict(usable: Result<Kind, &str>, motion: Option<&Motion>, remedy: &str, shown: &mut Printout) {
    match usable {
        Ok(kind) => {
            let good = motion.and_then(Motion::purpose).unwrap_or_else(|| purpose(kind));
            shown.row("usable", &format!("{}: {good}", kind_name(kind)));
        }
        Err(reason) => shown.row("unusable", reason),
    }
    if usable.is_err() && !remedy.is_empty() {
        shown.line(&format!("  try: {}", without_try(remedy)));
    }
}

/// The object of a table.
pub fn object(
    found: &Table,
    usable: Result<Kind, &str>,
    motion: Option<&Motion>,
    units: Option<&Check>,
    notes: &[Note],
    remedy: &str,
) -> Value {
    let column = |c: &Column| match described::of(found) {
        Some(described) => described::object(c, described),
        None => json!({ "name": c.name, "read_as": c.read_as }),
    };
    let mut object = json!({
        "kind": usable.map(Kind::name).ok(),
        "reason": usable.err(),
        "remedy": usable.err().map(|_| remedy),
        "for": usable.ok().map(|k| motion.and_then(Motion::purpose).unwrap_or_else(|| purpose(k))),
        "rows": found.rows, "samples": found.samples,
        "columns": found.columns.iter().map(column).collect::<Vec<_>>(),
        "span_s": found.span_s.map(|(a, b)| [a, b]), "median_rate_hz": found.median_rate_hz, "largest_gap_s": found.largest_gap_s,
        "broken_lines": found.broken.iter().map(|b| json!({ "line": b.line, "message": b.message })).collect::<Vec<_>>(),
        "broken_count": found.broken_count,
        "warnings": notes.iter().map(warning).collect::<Vec<_>>(),
    });
    if let Some(motion) = motion {
        add_to(motion, &mut object);
    }
    if let Some(units) = units {
        joints::add_to(units, &mut object);
    }
    object
}

/// What an observation of this kind can be used for.
fn purpose(kind: Kind) -> &'static str {
    match kind {
        Kind::Positions => "tune a ball's restitution and friction",
        Kind::EventTimes => "tune a ball's restitution",
        Kind::Pixels => "tune a ball's restitution, the camera found from the fall",
        Kind::Joints => "tune an arm's payload",
        _ => "tune robot joints, equations or your own simulator",
    }
}

fn has_header(found: &Table) -> bool {
    found.columns.iter().any(|c| !c.name.is_empty())
}

/// The longest stretch of lines without a broken one, where some are broken and all are listed.
fn whole_lines(found: &Table) -> Option<(usize, usize)> {
    if found.broken.is_empty() || found.broken_count > found.broken.len() {
        return None;
    }
    let header = usize::from(has_header(found));
    let ends = found.broken.iter().map(|b| b.line).chain([header + found.rows + 1]);
    let mut start = header + 1;
    let mut best = None;
    for end in ends {
        if end > start && best.is_none_or(|(first, last)| end - start > last + 1 - first) {
            best = Some((start, end - 1));
        }
        start = end + 1;
    }
    best
}
