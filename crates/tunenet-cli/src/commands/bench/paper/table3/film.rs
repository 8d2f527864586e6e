//! From a drop to its track.

use anyhow::Result;
use serde_json::{Value, json};

use super::super::super::rehearsal::films;
pub use super::super::super::rehearsal::{Film, Track};
use super::drops::Drop;

/// The paper's ball, m.
const RADIUS_M: f64 = 0.5;
/// How a spoilt film looks: noise on every channel out of 255, a quarter of the time between frames exposed, JPEG.
pub const SPOILT: (f64, f64, i32) = (6.0, 0.25, 75);

/// Renders and tracks all drops.
pub fn tracks(drops: &[Drop], seed: u64, spoilt: bool) -> Result<Vec<Film>> {
    let orders: Vec<Value> = drops.iter().map(|d| json!({ "camera": d.camera, "heights_m": d.heights_m })).collect();
    let (noise, exposure, quality) = SPOILT;
    let spoilt =
        if spoilt { json!({ "noise": noise, "exposure": exposure, "jpeg_quality": quality }) } else { json!({}) };
    films(seed, RADIUS_M, &spoilt, &orders)
}
