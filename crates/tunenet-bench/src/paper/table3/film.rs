//! From a drop to its track.

use anyhow::Result;
use tunenet_video_protocol::synthetic::{Order, Spoilt, SyntheticTrack, Take};

use super::super::super::rehearsal::films;
use super::drops::Drop;

/// The paper's ball, m.
const RADIUS_M: f64 = 0.5;
/// How a degraded video looks: noise on every channel out of 255, a quarter of the time between frames exposed, JPEG.
pub const SPOILT: (f64, f64, i32) = (6.0, 0.25, 75);

/// Renders and tracks all drops.
pub fn tracks(drops: &[Drop], seed: u64, spoilt: bool) -> Result<Vec<SyntheticTrack>> {
    let take = |d: &Drop| Take { camera: d.camera.clone(), heights_m: d.heights_m.clone(), across_m: Vec::new() };
    let (noise, exposure, quality) = SPOILT;
    let spoilt = if spoilt { Spoilt { noise, exposure, jpeg_quality: Some(quality) } } else { Spoilt::default() };
    films(&Order { seed, radius_m: RADIUS_M, spoilt, films: drops.iter().map(take).collect() })
}
