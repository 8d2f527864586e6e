//! What `inspect` says of a film: whether a ball can be followed in it, and what its path shows.

use std::path::Path;

use anyhow::Result;
use serde_json::{Value, json};

use crate::commands::film::{Asked, Unseen, note};
use crate::terminal::{stage, warn};

/// What is in the film at `path`, and whether it can be used.
pub fn look(path: &Path, camera_rate: Option<f64>) -> Result<(Value, bool)> {
    let asked = Asked::default().with("--camera-rate", camera_rate.map(|r| r.to_string()));
    let found = match asked.track(path) {
        Ok(found) => found,
        Err(error) => {
            let unseen = error.downcast::<Unseen>()?;
            stage("unusable", &unseen.note.text);
            anstream::eprintln!("  try: {}", unseen.note.remedy);
            let object = json!({
                "kind": "film", "reason": unseen.note.text, "remedy": unseen.note.remedy,
                "frames": unseen.object["frames"], "seen": 0, "warnings": unseen.object["warnings"],
            });
            return Ok((object, false));
        }
    };
    let number = |key: &str| found[key].as_f64().unwrap_or(0.0);
    stage(
        "film",
        &format!(
            "{} × {} px, {} frames, {:.2} a second",
            number("width_px"),
            number("height_px"),
            number("frames"),
            number("fps")
        ),
    );
    let bounces = found["bounces_s"].as_array().map_or(0, Vec::len);
    stage("ball", &format!("seen in {} frames, {bounces} bounces", number("seen")));
    found["warnings"].as_array().into_iter().flatten().map(note).for_each(|n| warn(&n));
    let failed = found["preflight"].as_array().into_iter().flatten().find(|c| c["state"] == "failed");
    let rolls = found["warnings"].as_array().into_iter().flatten().find(|w| w["code"] == "ball.rolls");
    let reason = match (failed.or(rolls), found["scale"].is_null()) {
        (Some(check), _) => check["text"].as_str().unwrap_or_default().to_owned(),
        (None, true) => "the ball does not fly freely, so nothing says how large a pixel is".to_owned(),
        (None, false) => String::new(),
    };
    let usable = reason.is_empty();
    if usable {
        stage("usable", "positions: tune a ball's restitution");
    } else {
        stage("unusable", &reason);
    }
    let mut object = json!({ "kind": "film", "reason": (!usable).then_some(reason) });
    for key in ["frames", "seen", "fps", "duplicates", "dropped", "width_px", "height_px", "scale", "preflight"] {
        object[key] = found[key].clone();
    }
    object["bounces"] = json!(bounces);
    object["warnings"] = found["warnings"].clone();
    Ok((object, usable))
}
