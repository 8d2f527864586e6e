//! Films whose truth is known, made and tracked on order: what the tables on video are measured with.

use anyhow::{Context, Result};
use rayon::prelude::*;
use serde::Deserialize;
use serde_json::Value;
use tunenet_track::rehearsal::{self, Spoilt, Take};

/// Films to make, from standard input.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Order {
    seed: u64,
    radius_m: f64,
    #[serde(default)]
    spoilt: Spoilt,
    films: Vec<Take>,
}

/// The tracks of rendered films, in the order asked for; the reason in place of one where no ball is found.
pub fn run() -> Result<Value> {
    let order: Order = serde_json::from_reader(std::io::stdin().lock()).context("the order")?;
    let one = |(i, take): (usize, &Take)| -> Result<Value> {
        let seed = order.seed.wrapping_mul(0x9E37_79B9).wrapping_add(i as u64);
        Ok(match rehearsal::rehearse(take, order.radius_m, &order.spoilt, seed)? {
            Ok(track) => serde_json::to_value(track)?,
            Err(reason) => reason.verdict().into(),
        })
    };
    let tracks = order.films.par_iter().enumerate().map(one).collect::<Result<Vec<_>>>()?;
    Ok(tracks.into())
}
