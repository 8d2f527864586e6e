//! Drops to tracks: each drop is rendered as a video and the ball is tracked in it.

use anyhow::Result;
use tunenet_video_protocol::synthetic::{Degradation, Order, Places, SyntheticTrack, Take};

use super::super::synthetic_video;
use super::drop::VideoDrop;
use super::world::RADIUS_M;

/// Standard deviation of the noise on every channel of every pixel, of 255.
const NOISE: f64 = 4.0;

/// Renders and tracks; `None` where no ball was found in the video.
pub fn tracks(drops: &[VideoDrop], seed: u64) -> Result<Vec<Option<Places>>> {
    let take = |d: &VideoDrop| Take {
        camera: d.camera.clone(),
        heights_m: d.path_m.iter().map(|x| x[2]).collect(),
        across_m: d.path_m.iter().map(|x| [x[0], x[1]]).collect(),
    };
    let degradation = Degradation { noise: NOISE, ..Degradation::default() };
    let order = Order { seed, radius_m: RADIUS_M, degradation, videos: drops.iter().map(take).collect() };
    let tracked = |track| match track {
        SyntheticTrack::Tracked(places) => Some(places),
        SyntheticTrack::Refused(_) => None,
    };
    Ok(synthetic_video::tracks(&order)?.into_iter().map(tracked).collect())
}
