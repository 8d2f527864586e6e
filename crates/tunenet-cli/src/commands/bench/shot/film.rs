//! From drops to what was seen of them.

use anyhow::Result;
use serde_json::{Value, json};

use super::super::rehearsal::{Film, Track, films};
use super::drop::Filmed;
use super::world::RADIUS_M;

/// Standard deviation of the noise on every channel of every pixel, of 255.
const NOISE: f64 = 4.0;

/// Renders and tracks; `None` where no ball was found in the film.
pub fn tracks(drops: &[Filmed], seed: u64) -> Result<Vec<Option<Track>>> {
    let film = |d: &Filmed| -> Value {
        let heights: Vec<f64> = d.path_m.iter().map(|x| x[2]).collect();
        let across: Vec<[f64; 2]> = d.path_m.iter().map(|x| [x[0], x[1]]).collect();
        json!({ "camera": d.camera, "heights_m": heights, "across_m": across })
    };
    let orders: Vec<Value> = drops.iter().map(film).collect();
    let tracked = |film| match film {
        Film::Tracked(track) => Some(track),
        Film::Refused(_) => None,
    };
    Ok(films(seed, RADIUS_M, &json!({ "noise": NOISE }), &orders)?.into_iter().map(tracked).collect())
}
