//! Table 3: how far a tuned simulator's ball is from the real one, tuned to positions and to uncalibrated video.
//!
//! ```text
//! drops (closed form) → film (rendered, tracked) → tuners (networks, rivals) → results → write
//! ```

mod drops;
mod film;
mod results;
mod tuners;

use anyhow::Result;
use rayon::prelude::*;

use self::drops::Drops;
use self::results::{Error, Row};
pub use self::results::{Results, as_json, markdown, write};
use self::tuners::{Estimate, Tuners};
use super::super::resume::Store;
use tunenet_cli::view::text::progress;
use tunenet_video_protocol::synthetic::SyntheticTrack;

/// Cameras, drops and trainings are drawn anew with each of these seeds.
const SEEDS: u64 = 5;
const QUICK_SEEDS: u64 = 1;
/// Drops of one seed.
const DROPS: u64 = 100;
const QUICK_DROPS: u64 = 20;

/// `None` where only a shard of it was made.
pub fn run(store: &Store, seed: u64, quick: bool) -> Result<Option<Results>> {
    let (seeds, count) = if quick { (QUICK_SEEDS, QUICK_DROPS) } else { (SEEDS, DROPS) };
    let drops = Drops::new()?;
    let bar = progress(seeds * (3 + Tuners::ROWS.len() as u64), "table 3");
    let mut rows: Vec<Row> = Tuners::ROWS.iter().map(|title| Row::new(*title)).collect();
    for number in 0..seeds {
        let own = seed * SEEDS + number;
        let test = (0..count).map(|i| drops.draw(own, i)).collect::<Result<Vec<_>>>()?;
        let clean = store.keep(&format!("table3-tracks-{own}"), || film::tracks(&test, own, false))?;
        let spoilt = store.keep(&format!("table3-spoilt-{own}"), || film::tracks(&test, own, true))?;
        bar.inc(1);
        let tuners = Tuners::make(store, own, quick)?;
        bar.inc(2);
        for row in &mut rows {
            let one = |(drop, film): (&drops::Drop, &SyntheticTrack)| -> Result<Option<Error>> {
                Ok(match tuners.estimate(row.key, &drops, drop, film)? {
                    Estimate::Restitution(e) => {
                        let rolled = drops.roll(e, drop.top_m)?;
                        Some(Error::new(&drop.heights_m, &rolled, e - drop.restitution))
                    }
                    Estimate::Nothing => Some(Error::of_nothing(&drop.heights_m)),
                    Estimate::Refused => None,
                })
            };
            let make = || {
                test.par_iter()
                    .zip(if row.title.spoilt { &spoilt } else { &clean })
                    .map(one)
                    .collect::<Result<Vec<_>>>()
            };
            row.seeds.extend(store.piece(&format!("table3-{}-{own}", row.key), make)?);
            bar.inc(1);
        }
    }
    bar.finish_and_clear();
    Ok((!store.sharded()).then_some(Results { seed, seeds, drops: count, quick, rows }))
}
