//! Videos whose truth is known, made and tracked on order: what the tables on video are measured with.

use anyhow::{Context, Result};
use rayon::prelude::*;
use tunenet_track::synthetic;
use tunenet_video_protocol::synthetic::{Order, SyntheticTrack, Take};

/// The tracks of the videos that standard input asks for, in that order.
pub fn run() -> Result<Vec<SyntheticTrack>> {
    let order: Order = serde_json::from_reader(std::io::stdin().lock()).context("the order")?;
    let one = |(i, take): (usize, &Take)| {
        let seed = order.seed.wrapping_mul(0x9E37_79B9).wrapping_add(i as u64);
        Ok(synthetic::synthetic_track(take, order.radius_m, &order.degradation, seed)?)
    };
    order.videos.par_iter().enumerate().map(one).collect()
}
