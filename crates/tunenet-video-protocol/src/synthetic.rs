//! Videos whose truth is known, made and tracked on order.

use serde::{Deserialize, Serialize};
use tunenet_core::camera::Pinhole;

/// Videos to make.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Order {
    /// Random seed.
    pub seed: u64,
    /// The ball's radius, m.
    pub radius_m: f64,
    /// How the pictures are degraded.
    pub degradation: Degradation,
    /// The videos.
    pub videos: Vec<Take>,
}

/// One video.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Take {
    /// The camera that records it.
    pub camera: Pinhole,
    /// Heights of the ball's centre, one for each frame, m.
    pub heights_m: Vec<f64>,
    /// Where it is along x and y, m; on the vertical line above the origin where there are fewer than frames.
    pub across_m: Vec<[f64; 2]>,
}

impl Take {
    /// The ball's centre in a frame, m.
    #[must_use]
    pub fn place(&self, frame: usize) -> [f64; 3] {
        let [x, y] = self.across_m.get(frame).copied().unwrap_or_default();
        [x, y, self.heights_m[frame]]
    }
}

/// How the pictures are degraded.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Degradation {
    /// Standard deviation of the noise on every channel, 0 to 255.
    pub noise: f64,
    /// How long the shutter is open, as a share of the time between two frames, 0 to 1.
    pub exposure: f64,
    /// Quality of the JPEG that every picture goes through, 1 to 100; none for none.
    pub jpeg_quality: Option<i32>,
}

/// What became of a video.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum SyntheticTrack {
    /// The ball was found.
    Tracked(Places),
    /// Why it was not.
    Refused(crate::track::TrackFailure),
}

/// Where a ball was seen, frame by frame.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Places {
    /// To the right, px; where a frame does not show the ball, as in the frame before.
    pub u_px: Vec<f64>,
    /// Downwards, px.
    pub v_px: Vec<f64>,
    /// Whether a frame shows it.
    pub seen: Vec<bool>,
}
