//! Drops to tracks: each drop is rendered as a video and the ball is tracked in it.

use anyhow::Result;
use tunenet_video_protocol::synthetic::{Degradation, Order, SyntheticTrack, Take};

use super::super::super::synthetic_video;
use super::drops::RecordedDrop;
use crate::scene::PAPER_RADIUS_M;

/// How a degraded video looks: noise on every channel out of 255, a quarter of the time between frames exposed, JPEG.
pub const DEGRADATION: (f64, f64, i32) = (6.0, 0.25, 75);

/// Renders and tracks all drops.
pub fn tracks(drops: &[RecordedDrop], seed: u64, degraded: bool) -> Result<Vec<SyntheticTrack>> {
    let take =
        |d: &RecordedDrop| Take { camera: d.camera.clone(), heights_m: d.heights_m.clone(), across_m: Vec::new() };
    let (noise, exposure, quality) = DEGRADATION;
    let degradation =
        if degraded { Degradation { noise, exposure, jpeg_quality: Some(quality) } } else { Degradation::default() };
    synthetic_video::tracks(&Order {
        seed,
        radius_m: PAPER_RADIUS_M,
        degradation,
        videos: drops.iter().map(take).collect(),
    })
}
