//! From a drop to its track: rendered and tracked by the program that sees.

use std::io::Write;
use std::process::{Command, Stdio};

use anyhow::{Context, Result, bail};
use serde::{Deserialize, Serialize};
use serde_json::json;

use super::drops::Drop;

/// What became of a film.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(untagged)]
pub enum Film {
    /// Where the ball was seen in every frame.
    Tracked(Track),
    /// Why it was refused.
    Refused(String),
}

/// Where a ball was seen in every frame.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Track {
    pub u_px: Vec<f64>,
    pub v_px: Vec<f64>,
}

/// How a spoilt film looks: noise on every channel out of 255, a quarter of the time between frames exposed, JPEG.
pub const SPOILT: (f64, f64, i32) = (6.0, 0.25, 75);

/// Renders and tracks all drops; the paper's ball is .5 m in radius.
pub fn tracks(drops: &[Drop], seed: u64, spoilt: bool) -> Result<Vec<Film>> {
    let films: Vec<_> = drops.iter().map(|d| json!({ "camera": d.camera, "heights_m": d.heights_m })).collect();
    let (noise, exposure, quality) = SPOILT;
    let spoilt = spoilt.then(|| json!({ "noise": noise, "exposure": exposure, "jpeg_quality": quality }));
    let order = json!({
        "seed": seed, "radius_m": 0.5, "spoilt": spoilt.unwrap_or_else(|| json!({})), "films": films,
    });
    let order = order.to_string();
    let mut child = Command::new(crate::commands::film::program()?)
        .arg("film")
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .context("starting tunenet-video, which `make build` makes")?;
    // All of it is read there before anything is answered, so neither side waits for the other.
    child.stdin.take().context("a pipe to tunenet-video")?.write_all(order.as_bytes())?;
    let done = child.wait_with_output()?;
    if !done.status.success() {
        bail!("rendering and tracking failed: {}", String::from_utf8_lossy(&done.stderr).trim());
    }
    let tracks: Vec<Film> = serde_json::from_slice(&done.stdout).context("what tunenet-video answered")?;
    if tracks.len() != drops.len() {
        bail!("expected {} tracks, found {}", drops.len(), tracks.len());
    }
    Ok(tracks)
}
