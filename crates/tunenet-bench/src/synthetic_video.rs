//! Synthetic videos of drops: `tunenet-video` renders and tracks them in one run.

use std::io::Write;
use std::process::{Command, Stdio};
use tunenet_cli::files::programs;

use anyhow::{Context, Result, bail};
use tunenet_video_protocol::synthetic::{Order, SyntheticTrack};

/// Renders the videos of an order and tracks the ball in each.
///
/// # Errors
/// Where `tunenet-video` does not start, fails, or answers with another number of tracks.
pub fn tracks(order: &Order) -> Result<Vec<SyntheticTrack>> {
    let mut child = Command::new(programs::sibling(programs::VIDEO)?)
        .arg("film")
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .context("starting tunenet-video, which `make build` makes")?;
    // All of it is read there before anything is answered, so neither side waits for the other.
    child.stdin.take().context("a pipe to tunenet-video")?.write_all(&serde_json::to_vec(order)?)?;
    let done = child.wait_with_output()?;
    if !done.status.success() {
        bail!("rendering and tracking failed: {}", String::from_utf8_lossy(&done.stderr).trim());
    }
    let tracked: Vec<SyntheticTrack> = serde_json::from_slice(&done.stdout).context("what tunenet-video answered")?;
    if tracked.len() != order.videos.len() {
        bail!("expected {} tracks, found {}", order.videos.len(), tracked.len());
    }
    Ok(tracked)
}
