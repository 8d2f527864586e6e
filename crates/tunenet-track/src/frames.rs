//! Pictures one after the other, each with the instant at which it was taken: a video, or a topic of a log.

use std::path::{Path, PathBuf};

use opencv::core::{Mat, MatTraitConst};
use opencv::videoio::{
    CAP_PROP_FRAME_COUNT, CAP_PROP_POS_MSEC, VideoCapture, VideoCaptureTrait, VideoCaptureTraitConst,
};
use tunenet_formats::Result;

use crate::video;

/// A container's time stamp is plausible if it follows the last one by this many nominal steps at the least ...
const LEAST_STEP: f64 = 0.5;
/// ... and at the most: a video does not stand still for so long.
const MOST_STEPS: f64 = 1e3;

/// Pictures in the order in which they were taken.
pub trait Pictures: Send {
    /// Reads the next picture (blue, green, red; 8 bits each) into `image` and returns when it was taken, s. `None` at the
    /// end.
    ///
    /// # Errors
    /// Where the next picture cannot be decoded.
    fn next(&mut self, image: &mut Mat) -> Result<Option<f64>>;

    /// How many there are, as far as the file says; it may promise too much.
    fn promised(&self) -> Option<usize>;
}

/// A video that is being read.
pub struct VideoFrames {
    path: PathBuf,
    reader: VideoCapture,
    frames_per_s: f64,
    promised: Option<usize>,
    index: usize,
    last_s: f64,
}

impl VideoFrames {
    /// Opens the video at `path`.
    ///
    /// # Errors
    /// As [`video::open`], but for what shows only when all frames are decoded.
    pub fn open(path: &Path) -> Result<Self> {
        let (reader, frames_per_s) = video::reader(path)?;
        let count = reader.get(CAP_PROP_FRAME_COUNT).unwrap_or(0.0);
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a count, checked to be small")]
        let promised = (1.0..1e9).contains(&count).then_some(count as usize);
        Ok(Self { path: path.into(), reader, frames_per_s, promised, index: 0, last_s: f64::NEG_INFINITY })
    }
}

impl Pictures for VideoFrames {
    /// The container's own time stamps count where they are plausible; a video without them runs at the nominal rate.
    fn next(&mut self, image: &mut Mat) -> Result<Option<f64>> {
        let broken = |e: opencv::Error| video::undecodable(&self.path, &e);
        if !self.reader.read(image).map_err(broken)? || image.empty() {
            return Ok(None);
        }
        let stated_s = self.reader.get(CAP_PROP_POS_MSEC).map_err(broken)? / 1000.0;
        let step_s = 1.0 / self.frames_per_s;
        let gap = (stated_s - self.last_s) / step_s;
        // A dropped frame leaves a gap of two steps or more, which is as it was; only nonsense is replaced.
        let time_s = match self.index {
            0 => stated_s.clamp(0.0, MOST_STEPS * step_s),
            _ if (LEAST_STEP..MOST_STEPS).contains(&gap) => stated_s,
            _ => self.last_s + step_s,
        };
        self.index += 1;
        self.last_s = time_s;
        Ok(Some(time_s))
    }

    fn promised(&self) -> Option<usize> {
        self.promised
    }
}
