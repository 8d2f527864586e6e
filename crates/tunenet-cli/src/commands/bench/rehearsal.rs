//! Films of simulated drops: rendered and tracked by the program that sees, in one go.

use std::io::Write;
use std::process::{Command, Stdio};

use anyhow::{Context, Result, bail};
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

/// What became of a film.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(untagged)]
pub enum Film {
    /// The ball was found.
    Tracked(Track),
    /// Why it was refused.
    Refused(String),
}

/// Where a ball was seen, frame by frame.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Track {
    pub u_px: Vec<f64>,
    pub v_px: Vec<f64>,
    /// Whether a frame shows it; where not, its last place stands.
    pub seen: Vec<bool>,
}

/// Renders and tracks `films` of a ball of this radius, each with its `camera`, its `heights_m` and, where it moves sideways,
/// `across_m`; `spoilt` says what the pictures suffer.
pub fn films(seed: u64, radius_m: f64, spoilt: &Value, films: &[Value]) -> Result<Vec<Film>> {
    let order = json!({ "seed": seed, "radius_m": radius_m, "spoilt": spoilt, "films": films }).to_string();
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
    let tracked: Vec<Film> = serde_json::from_slice(&done.stdout).context("what tunenet-video answered")?;
    if tracked.len() != films.len() {
        bail!("expected {} tracks, found {}", films.len(), tracked.len());
    }
    Ok(tracked)
}
