//! The frames of a film, one after the other, each with the instant at which it was taken.

use opencv::core::{Mat, MatTraitConst};
use opencv::videoio::{CAP_PROP_POS_MSEC, VideoCapture, VideoCaptureTrait, VideoCaptureTraitConst};
use std::path::{Path, PathBuf};
use tunenet_core::{Error, Result};

use crate::video;

/// A time that a container states is believed where it follows the last one by this many nominal steps at the least ...
const LEAST_STEP: f64 = 0.5;
/// ... and at the most: a film does not stand still for so long.
const MOST_STEPS: f64 = 1e3;

/// A film that is being read.
pub struct Frames {
    path: PathBuf,
    reader: VideoCapture,
    /// The file's nominal rate, 1/s.
    pub frames_per_s: f64,
    index: usize,
    last_s: f64,
}

impl Frames {
    /// Opens the film at `path`.
    ///
    /// # Errors
    /// As [`video::open`], but for what shows only when all frames are decoded.
    pub fn open(path: &Path) -> Result<Self> {
        let (reader, frames_per_s) = video::reader(path)?;
        Ok(Self { path: path.to_path_buf(), reader, frames_per_s, index: 0, last_s: f64::NEG_INFINITY })
    }

    /// Reads the next frame (blue, green, red; 8 bits each) into `image` and returns when it was taken, s after the
    /// first. `None` at the end.
    ///
    /// The container's own time stamps count where it has sensible ones; a film without them runs at the nominal rate.
    ///
    /// # Errors
    /// Where OpenCV fails on a frame.
    pub fn next(&mut self, image: &mut Mat) -> Result<Option<f64>> {
        let broken = |path: &Path, e: &opencv::Error| {
            let message = format!("expected a video, found a frame that OpenCV cannot decode ({})", e.message.trim());
            Error::file(path, message, "convert the video first")
        };
        if !self.reader.read(image).map_err(|e| broken(&self.path, &e))? || image.empty() {
            return Ok(None);
        }
        let stated_s = self.reader.get(CAP_PROP_POS_MSEC).map_err(|e| broken(&self.path, &e))? / 1000.0;
        let step_s = 1.0 / self.frames_per_s;
        let next_s = if self.index == 0 { 0.0 } else { self.last_s + step_s };
        let gap = (stated_s - self.last_s) / step_s;
        // A dropped frame leaves a gap of two steps or more, which is as it was; only nonsense is replaced.
        let time_s = match self.index {
            0 => stated_s.max(0.0),
            _ if (LEAST_STEP..MOST_STEPS).contains(&gap) => stated_s,
            _ => next_s,
        };
        self.index += 1;
        self.last_s = time_s;
        Ok(Some(time_s))
    }
}
