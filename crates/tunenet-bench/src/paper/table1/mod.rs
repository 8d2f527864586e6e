//! Table 1: how far a tuned payload is from the true one, on masses like those of training and on heavier ones.
//!
//! ```text
//! sets (gen arm) → tuners (networks, rivals) → results → write
//! ```

mod linear;
mod results;
mod sets;
mod tuners;

use anyhow::Result;
use rayon::prelude::*;

use self::results::{Bound, Table1Row};
pub use self::results::{Table1Results, as_json, markdown, write};
use self::sets::{JudgedSet, Sets};
use self::tuners::{ArmTuners, ROWS};
use super::super::resume::Store;
use tunenet_cli::view::text::progress;

/// Rollouts that each may spend on a target.
pub const ROLLOUTS: usize = 10;
/// Standard deviation of the noise on the torques of the targets, N·m, in the noisy half of the table.
pub const NOISE_NM: f64 = 0.5;
/// Pairs and trainings are drawn afresh with each of these seeds.
const SEEDS: u64 = 3;
const QUICK_SEEDS: u64 = 1;
/// Pairs of one seed to train on, and in each of the two sets to judge by: over all seeds as many as the paper judges by.
const PAIRS: (u64, u64) = (1000, 100);
const QUICK_PAIRS: (u64, u64) = (100, 30);

/// `None` where only a shard of it was made.
pub fn run(store: &Store, seed: u64, quick: bool) -> Result<Option<Table1Results>> {
    let (seeds, pairs) = if quick { (QUICK_SEEDS, QUICK_PAIRS) } else { (SEEDS, PAIRS) };
    let bar = progress(seeds * (4 + 4 * ROWS.len() as u64), "table 1");
    let mut rows: Vec<Table1Row> = ROWS.into_iter().map(Table1Row::new).collect();
    let mut bounds = [JudgedSet::Validation, JudgedSet::Test].map(Bound::new);
    let (mut data, mut training) = (Vec::new(), Vec::new());
    for number in 0..seeds {
        let set_seed = seed * SEEDS + number;
        let sets = Sets::make(store, set_seed, pairs)?;
        bar.inc(1);
        let tuners = ArmTuners::make(store, &sets, set_seed, quick)?;
        bar.inc(3);
        for row in &mut rows {
            for noise_nm in [0.0, NOISE_NM] {
                for set in [JudgedSet::Validation, JudgedSet::Test] {
                    bar.inc(1);
                    if noise_nm > 0.0 && !row.title.noisy {
                        continue;
                    }
                    let name = format!("table1-{}-{}-{noise_nm}-{set_seed}", row.title.key, set.name());
                    let errors = store.piece(&name, || {
                        let one = |i: usize| tuners.errors(row.title.key, &sets, &sets.pair(set, i, noise_nm)?);
                        (0..sets.len(set)).into_par_iter().map(one).collect::<Result<Vec<_>>>()
                    })?;
                    if let Some(errors) = errors {
                        row.add(set, noise_nm, errors);
                    }
                }
            }
        }
        for bound in &mut bounds {
            let each = store.piece(&format!("table1-bound-{}-{set_seed}", bound.set.name()), || {
                let one = |i: usize| sets.bound_kg(bound.set, i, NOISE_NM);
                (0..sets.len(bound.set)).into_par_iter().map(one).collect::<Result<Vec<f64>>>()
            })?;
            bound.sd_kg.extend(each.into_iter().flatten());
        }
        data.push(sets.cost);
        training.push(tuners.cost);
    }
    bar.finish_and_clear();
    Ok((!store.sharded()).then_some(Table1Results { seed, seeds, pairs, quick, rows, bounds, data, training }))
}
