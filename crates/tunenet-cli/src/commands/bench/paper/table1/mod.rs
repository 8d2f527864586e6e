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

use self::results::{Bound, Cell, Row};
pub use self::results::{Results, as_json, markdown, write};
use self::sets::{Set, Sets};
use self::tuners::{ROWS, Tuners};
use super::super::resume::Store;
use crate::terminal::progress;

/// Iterations that each may take.
pub const ITERATIONS: usize = 9;
/// Standard deviation of the noise on the torques of the targets, N·m, in the noisy half of the table.
pub const NOISE_NM: f64 = 0.5;
/// Pairs to train on, and in each of the two sets to judge by.
const PAIRS: (u64, u64) = (1000, 300);
const QUICK_PAIRS: (u64, u64) = (100, 30);

/// `None` where only a shard of it was made.
pub fn run(store: &Store, seed: u64, quick: bool) -> Result<Option<Results>> {
    let pairs = if quick { QUICK_PAIRS } else { PAIRS };
    let bar = progress(4 + 4 * ROWS.len() as u64, "table 1");
    let sets = Sets::make(store, seed, pairs)?;
    bar.inc(1);
    let tuners = Tuners::make(store, &sets, seed, quick)?;
    bar.inc(3);
    let mut rows = Vec::new();
    for row in ROWS {
        let mut cells = Vec::new();
        for noise_nm in [0.0, NOISE_NM] {
            for set in [Set::Validation, Set::Test] {
                bar.inc(1);
                if noise_nm > 0.0 && !row.noisy {
                    continue;
                }
                let name = format!("table1-{}-{}-{noise_nm}-{seed}", row.key, set.name());
                let errors = store.piece(&name, || {
                    let one = |number: usize| tuners.errors(row.key, &sets, &sets.pair(set, number, noise_nm)?);
                    (0..sets.len(set)).into_par_iter().map(one).collect::<Result<Vec<_>>>()
                })?;
                cells.extend(errors.map(|errors| Cell { set, noise_nm, errors }));
            }
        }
        rows.push(Row { title: row, cells });
    }
    let bounds = [Set::Validation, Set::Test].map(|set| {
        let name = format!("table1-bound-{}-{seed}", set.name());
        store.piece(&name, || {
            let one = |number: usize| sets.bound_kg(set, number, NOISE_NM);
            (0..sets.len(set)).into_par_iter().map(one).collect::<Result<Vec<f64>>>()
        })
    });
    let [validation, test] = bounds;
    bar.finish_and_clear();
    let (Some(validation), Some(test), false) = (validation?, test?, store.sharded()) else { return Ok(None) };
    let bounds = vec![Bound::new(Set::Validation, &validation), Bound::new(Set::Test, &test)];
    let (data, training) = (sets.cost, tuners.cost);
    Ok(Some(Results { seed, pairs, quick, rows, bounds, data, training }))
}
