//! How fast pictures are made, decoded and tracked.

use serde::{Deserialize, Serialize};

/// All figures, each a median of several measurements.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct VideoSpeed {
    /// Pictures made.
    pub render: Render,
    /// Pictures in memory tracked.
    pub track: Track,
    /// A file decoded.
    #[serde(rename = "film")]
    pub video: DecodingSpeed,
}

/// Pictures made on one core.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Render {
    /// Frames per second.
    pub clean_frames_s: f64,
    /// The same with noise and JPEG.
    pub noise_and_jpeg_frames_s: f64,
}

/// Pictures tracked on one core.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Track {
    /// Frames per second.
    pub frames_s: f64,
    /// The greatest distance from the projected centre, px.
    pub worst_px: f64,
}

/// A video of 1080p on all cores.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DecodingSpeed {
    /// Frames decoded per second.
    pub decode_frames_s: f64,
    /// Frames decoded and tracked per second.
    pub track_frames_s: f64,
    /// Frames of the video.
    pub frames: usize,
}
