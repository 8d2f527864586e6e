//! What `inspect` says of a video: whether a ball can be followed in it, and what its path shows.

use std::path::Path;

use anyhow::Result;
use serde_json::{Value, json};
use tunenet_video_protocol::track::Facts;

use super::Standing;
use crate::commands::video::{Asked, TrackFailure};
use crate::view::answer::Printout;

/// What is in the video at `path`, and whether it can be used.
pub fn look(path: &Path, camera_rate: Option<f64>, shown: &mut Printout) -> Result<(Value, Standing)> {
    let asked = Asked::default().with("--camera-rate", camera_rate.map(|r| r.to_string()));
    let found = match asked.track(path) {
        Ok(found) => found,
        Err(error) => {
            let failure = error.downcast::<TrackFailure>()?;
            shown.row("unusable", &failure.note.text);
            shown.line(&format!("  try: {}", failure.note.remedy));
            let (frames, warnings) = failure.untracked.map_or((0, Vec::new()), |u| (u.frames, vec![u.finding]));
            let object = json!({
                "kind": "film", "reason": failure.note.text, "remedy": failure.note.remedy,
                "frames": frames, "seen": 0, "warnings": warnings,
            });
            return Ok((object, Standing::Unusable));
        }
    };
    let facts = found.facts;
    let Facts { width_px, height_px, frames, fps, seen, .. } = facts;
    shown.row("video", &format!("{width_px} × {height_px} px, {frames} frames, {fps:.2} a second"));
    let bounces = facts.bounces_s.len();
    shown.row("ball", &format!("seen in {seen} frames, {bounces} bounces"));
    facts.warnings.iter().for_each(|finding| shown.warn(&finding.note()));
    let against = facts.rejected().map(|check| &check.text).or(facts.rolls().map(|finding| &finding.text));
    let (reason, standing) = match against {
        Some(text) => (Some(text.clone()), Standing::Unusable),
        None if facts.scale.is_none() => {
            let reason = "the ball does not fly freely, so nothing says how large a pixel is";
            (Some(reason.to_owned()), Standing::Refused)
        }
        None => (None, Standing::Usable),
    };
    match &reason {
        None => shown.row("usable", "positions: tune a ball's restitution"),
        Some(reason) => shown.row("unusable", reason),
    }
    let object = json!({
        "kind": "film", "reason": reason, "frames": frames, "seen": seen, "fps": fps,
        "duplicates": facts.duplicates, "dropped": facts.dropped, "width_px": width_px, "height_px": height_px,
        "scale": facts.scale, "preflight": facts.preflight, "bounces": bounces, "warnings": facts.warnings,
    });
    Ok((object, standing))
}
