//! Video figures of `bench speed`: `tunenet-video` measures the rates, this program measures its memory.

use std::path::Path;
use std::process::{Command, Stdio};
use tunenet_cli::files::programs;

use anyhow::{Context, Result, bail};
use serde_json::{Value, json};
use tunenet_video_protocol::speed::VideoSpeed;

use super::process;

/// Frames of the shorter 4K video and of the longer one. Both exceed the frames that are buffered while the ball's colour is
/// detected, so that their peaks differ only if memory grows with length.
const SHORT: usize = 60;
const LONG: usize = 180;

/// What was measured; nothing where no program reads videos here.
pub struct VideoFigures(Option<VideoMeasured>);

struct VideoMeasured {
    speed: VideoSpeed,
    /// Greatest memory while tracking the shorter and the longer video, bytes.
    peaks: [Option<u64>; 2],
}

impl VideoFigures {
    /// Makes videos in `folder` and tracks them.
    pub fn measure(folder: &Path) -> Result<Self> {
        let program = programs::sibling(programs::VIDEO)?;
        if !program.is_file() {
            return Ok(Self(None));
        }
        let text = |path: &Path| path.to_str().map(str::to_owned).context("the folder's name is not Unicode");
        let done = Command::new(&program)
            .args(["speed", &text(folder)?])
            .stdin(Stdio::null())
            .output()
            .with_context(|| format!("starting {}", program.display()))?;
        if !done.status.success() {
            bail!("measuring videos failed: {}", String::from_utf8_lossy(&done.stderr).trim());
        }
        let speed = serde_json::from_slice(&done.stdout).context("what tunenet-video answered")?;
        let mut peaks = [None; 2];
        for (peak, frames) in peaks.iter_mut().zip([SHORT, LONG]) {
            let path = text(&folder.join(format!("{frames}.mp4")))?;
            process::run_program(&program, &["long-film", &path, &frames.to_string()])?;
            *peak = process::run_program(&program, &["track", &path])?.peak_bytes;
        }
        Ok(Self(Some(VideoMeasured { speed, peaks })))
    }

    pub fn rows(&self) -> Vec<Vec<String>> {
        let Some(VideoMeasured { speed, peaks }) = &self.0 else {
            return vec![vec!["videos".into(), "tunenet-video is missing: `make build`".into()]];
        };
        let each_s = |value: f64| format!("{value:.0} frames/s");
        let (decode, both) = (speed.video.decode_frames_s, speed.video.track_frames_s);
        let peak =
            |bytes: Option<u64>| bytes.map_or_else(|| "not known".into(), |b| format!("{:.0} MB", b as f64 / 1e6));
        [
            ("render 160 × 120 px, one core".into(), each_s(speed.render.clean_frames_s)),
            ("the same with noise and JPEG".into(), each_s(speed.render.noise_and_jpeg_frames_s)),
            ("track 160 × 120 px in memory, one core".into(), each_s(speed.track.frames_s)),
            ("largest distance of the track from the projection".into(), format!("{:.3} px", speed.track.worst_px)),
            ("decode a video of 1080p alone, all cores".into(), each_s(decode)),
            ("decode and track it, all cores".into(), format!("{} ({:.2} of decoding)", each_s(both), both / decode)),
            (
                format!("peak memory, {SHORT} and {LONG} frames of 4K"),
                format!("{} and {}", peak(peaks[0]), peak(peaks[1])),
            ),
        ]
        .map(|(what, value)| vec![what, value])
        .into()
    }

    pub fn as_json(&self) -> Value {
        let Some(VideoMeasured { speed, peaks }) = &self.0 else { return Value::Null };
        json!({
            "render": speed.render, "track": speed.track, "film": speed.video,
            "memory": { "frames": [SHORT, LONG], "peak_bytes": peaks },
        })
    }
}
