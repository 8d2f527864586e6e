//! Table 3: how far a tuned simulator's ball is from the real one, tuned to positions and to uncalibrated video.
//!
//! ```text
//! drops (closed form) → video (rendered, tracked) → tuners (networks, rivals) → results → write
//! ```

mod drops;
mod results;
mod tuners;
mod video;

use anyhow::Result;
use rayon::prelude::*;

use self::drops::Drops;
use self::results::{DropError, Table3Row};
pub use self::results::{Table3Results, as_json, markdown, write};
use self::tuners::{DropEstimate, DropTuners};
use super::super::resume::Store;
use tunenet_cli::view::text::progress;
use tunenet_video_protocol::synthetic::SyntheticTrack;

/// Cameras, drops and trainings are drawn afresh with each of these seeds.
const SEEDS: u64 = 5;
const QUICK_SEEDS: u64 = 1;
/// Drops of one seed.
const DROPS: u64 = 100;
const QUICK_DROPS: u64 = 20;

/// `None` where only a shard of it was made.
pub fn run(store: &Store, seed: u64, quick: bool) -> Result<Option<Table3Results>> {
    let (seeds, count) = if quick { (QUICK_SEEDS, QUICK_DROPS) } else { (SEEDS, DROPS) };
    let drops = Drops::new()?;
    let bar = progress(seeds * (3 + DropTuners::ROWS.len() as u64), "table 3");
    let mut rows: Vec<Table3Row> = DropTuners::ROWS.iter().map(|title| Table3Row::new(*title)).collect();
    for number in 0..seeds {
        let set_seed = seed * SEEDS + number;
        let test = (0..count).map(|i| drops.draw(set_seed, i)).collect::<Result<Vec<_>>>()?;
        let clean = store.keep(&format!("table3-tracks-{set_seed}"), || video::tracks(&test, set_seed, false))?;
        let degraded = store.keep(&format!("table3-spoilt-{set_seed}"), || video::tracks(&test, set_seed, true))?;
        bar.inc(1);
        let tuners = DropTuners::make(store, set_seed, quick)?;
        bar.inc(2);
        for row in &mut rows {
            let one = |(drop, track): (&drops::RecordedDrop, &SyntheticTrack)| -> Result<Option<DropError>> {
                Ok(match tuners.estimate(row.key, &drops, drop, track)? {
                    DropEstimate::Restitution(e) => {
                        let rolled = drops.roll(e, drop.top_m)?;
                        Some(DropError::new(&drop.heights_m, &rolled, e - drop.restitution))
                    }
                    DropEstimate::Nothing => Some(DropError::of_nothing(&drop.heights_m)),
                    DropEstimate::Refused => None,
                })
            };
            let make = || {
                test.par_iter()
                    .zip(if row.title.degraded { &degraded } else { &clean })
                    .map(one)
                    .collect::<Result<Vec<_>>>()
            };
            row.seeds.extend(store.piece(&format!("table3-{}-{set_seed}", row.key), make)?);
            bar.inc(1);
        }
    }
    bar.finish_and_clear();
    Ok((!store.sharded()).then_some(Table3Results { seed, seeds, drops: count, quick, rows }))
}
