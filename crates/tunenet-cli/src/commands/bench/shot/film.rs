//! From drops to what was seen of them: rendered and tracked by the program that sees.

use std::io::Write;
use std::process::{Command, Stdio};

use anyhow::{Context, Result, bail};
use serde::{Deserialize, Serialize};
use serde_json::json;

use super::drop::Filmed;
use super::world::RADIUS_M;

/// Where a ball was seen.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Track {
    pub u_px: Vec<f64>,
    pub v_px: Vec<f64>,
    /// Whether a frame shows it; where not, its last place stands.
    pub seen: Vec<bool>,
}

/// Standard deviation of the noise on every channel of every pixel, of 255.
const NOISE: f64 = 4.0;

/// Renders and tracks; `None` where no ball was found in the film.
pub fn tracks(drops: &[Filmed], seed: u64) -> Result<Vec<Option<Track>>> {
    let film = |d: &Filmed| {
        let heights: Vec<f64> = d.path_m.iter().map(|x| x[2]).collect();
        let across: Vec<[f64; 2]> = d.path_m.iter().map(|x| [x[0], x[1]]).collect();
        json!({ "camera": d.camera, "heights_m": heights, "across_m": across })
    };
    let films: Vec<_> = drops.iter().map(film).collect();
    let order = json!({
        "seed": seed, "radius_m": RADIUS_M, "spoilt": { "noise": NOISE }, "films": films, "may_fail": true,
    });
    let mut child = Command::new(crate::commands::film::program()?)
        .arg("film")
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .context("starting tunenet-video, which `make build` makes")?;
    // All of it is read there before anything is answered, so neither side waits for the other.
    child.stdin.take().context("a pipe to tunenet-video")?.write_all(order.to_string().as_bytes())?;
    let done = child.wait_with_output()?;
    if !done.status.success() {
        bail!("rendering and tracking failed: {}", String::from_utf8_lossy(&done.stderr).trim());
    }
    let tracks: Vec<Option<Track>> = serde_json::from_slice(&done.stdout).context("what tunenet-video answered")?;
    if tracks.len() != drops.len() {
        bail!("expected {} tracks, found {}", drops.len(), tracks.len());
    }
    Ok(tracks)
}
