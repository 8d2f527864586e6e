//! Drops to tracks: each drop is rendered as a video and the ball is tracked in it.

use anyhow::Result;
use tunenet_video_protocol::synthetic::{Order, Spoilt, SyntheticTrack, Take};

use super::super::super::synthetic_video;
use super::drops::RecordedDrop;
use crate::scene::PAPER_RADIUS_M;

/// How a degraded video looks: noise on every channel out of 255, a quarter of the time between frames exposed, JPEG.
pub const SPOILT: (f64, f64, i32) = (6.0, 0.25, 75);

/// Renders and tracks all drops.
pub fn tracks(drops: &[RecordedDrop], seed: u64, spoilt: bool) -> Result<Vec<SyntheticTrack>> {
    let take =
        |d: &RecordedDrop| Take { camera: d.camera.clone(), heights_m: d.heights_m.clone(), across_m: Vec::new() };
    let (noise, exposure, quality) = SPOILT;
    let spoilt = if spoilt { Spoilt { noise, exposure, jpeg_quality: Some(quality) } } else { Spoilt::default() };
    synthetic_video::tracks(&Order { seed, radius_m: PAPER_RADIUS_M, spoilt, films: drops.iter().map(take).collect() })
}
