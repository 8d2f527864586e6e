//! What `inspect` says of a recording in several episodes.

use std::path::Path;

use serde_json::{Value, json};
use tunenet_core::observation::Note;
use tunenet_formats::{Episodes, shell_word};

use crate::view::answer::Printout;
use crate::view::json::warning;

/// Most episodes that are listed in a line.
const MOST_LISTED: usize = 6;

/// Its format, rate, episodes and columns.
pub fn contents(found: &Episodes, shown: &mut Printout) {
    let robot = if found.robot.is_empty() { String::new() } else { format!(", {}", found.robot) };
    let rate = found.rate_hz.map_or_else(|| ", no rate".into(), |rate| format!(", {rate} Hz"));
    shown.row("dataset", &format!("{}{robot}{rate}", found.format));
    let listed = found.episodes.iter().take(MOST_LISTED).filter(|episode| !episode.name.is_empty());
    let listed: Vec<String> = listed
        .map(|episode| match episode.frames {
            Some(frames) => format!("{} ({frames} frames)", episode.name),
            None => episode.name.clone(),
        })
        .collect();
    let more = found.episodes.len().saturating_sub(MOST_LISTED);
    let more = if more > 0 { format!(" and {more} more") } else { String::new() };
    let count = found.episodes.len();
    let names = if listed.is_empty() { String::new() } else { format!(": {}{more}", listed.join(", ")) };
    shown.row("episodes", &format!("{count}{names}"));
    let head = ["column", "unit", "proposed", "why"].map(String::from).to_vec();
    let row = |column: &tunenet_formats::EpisodeColumn| {
        let dash = || "-".to_owned();
        let unit = column.unit.clone().unwrap_or_else(dash);
        let proposed = column.proposed.clone().unwrap_or_else(dash);
        vec![column.name.clone(), unit, proposed, column.why.clone()]
    };
    shown.table(&std::iter::once(head).chain(found.columns.iter().map(row)).collect::<Vec<_>>());
    if !found.units.is_empty() {
        shown.row(
            "proposed",
            &format!("check it against the robot's documents: `--units {}`", shell_word(&found.units)),
        );
    }
}

/// How it is used; `refused` says why the episode that is asked for cannot be.
pub fn verdict(found: &Episodes, path: &Path, refused: Option<&str>, shown: &mut Printout) {
    let Some(refused) = refused else {
        let several = found.episodes.len() > 1 && path.exists();
        let how = if several { "choose episodes with `--episodes`" } else { "one episode" };
        let rate = if found.lacks_clock { ", at the rate that `--rate HZ` states" } else { "" };
        shown.row("usable", &format!("columns by their names, in the units that `--units` states{rate}; {how}"));
        return;
    };
    shown.row("unusable", refused);
}

/// Its object.
pub fn object(found: &Episodes, notes: &[Note], refused: Option<&str>) -> Value {
    let mut object = json!({
        "kind": "episodes", "format": found.format, "robot": found.robot, "rate_hz": found.rate_hz,
        "lacks_clock": found.lacks_clock,
        "episodes": found.episodes.iter().map(|e| json!({ "name": e.name, "frames": e.frames })).collect::<Vec<_>>(),
        "columns": found.columns.iter().map(|c| json!({
            "name": c.name, "unit": c.unit, "proposed": c.proposed, "why": c.why,
        })).collect::<Vec<_>>(),
        "units": found.units,
        "warnings": found.notes.iter().chain(notes).map(warning).collect::<Vec<_>>(),
    });
    if let Some(refused) = refused {
        object["reason"] = refused.into();
    }
    object
}
