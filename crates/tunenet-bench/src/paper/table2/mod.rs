//! Table 2 and Figure 2: the error of a tuned restitution against the rollouts spent, compared with other uses of
//! on.
//!
//! ```text
//! targets (closed form, of the tuning bench) → methods → results → write, figure
//! ```

mod direct;
mod figure;
mod methods;
mod results;
mod write;

use anyhow::Result;
use rayon::prelude::*;
use tunenet_core::network::Preset;

use self::direct::Direct;
use self::methods::{Method, Table2Tuners};
pub use self::results::Table2Results;
use self::results::{SeedAccuracy, Table2Cell};
pub use self::write::{as_json, figure_json, figure_markdown, markdown, write, write_figure};
use super::super::resume::Store;
use super::super::tuning::ours;
use super::super::tuning::rivals::Stored;
use super::super::tuning::rows::Conditions;
use super::super::tuning::targets::{DropTarget, Simulation};
use crate::lazy::Lazy;
use crate::scene::{EASY, HARD};
use tunenet_cli::view::text::progress;

/// Rollouts after which the estimates are compared.
pub const BUDGETS: [usize; 4] = [1, 5, 10, 100];
/// Targets and trainings are drawn afresh with each of these seeds.
const SEEDS: u64 = 3;
/// Targets of one seed in one set: the paper's number.
const TARGETS: u64 = 100;
const QUICK_TARGETS: u64 = 40;
/// The paper's two sets, without noise and with noise that a depth camera has.
pub const SETS: [(&str, Conditions); 4] = [
    ("easy", Conditions { restitution: EASY, noise_m: 0.0 }),
    ("hard", Conditions { restitution: HARD, noise_m: 0.0 }),
    ("easy_2cm", Conditions { restitution: EASY, noise_m: 0.02 }),
    ("hard_2cm", Conditions { restitution: HARD, noise_m: 0.02 }),
];
/// Rows of the tuning bench end below; its targets are never these.
const FIRST_STREAM: u64 = 0x200;

/// The appendix's network, data and loss, made small by the optimiser of preset `default` instead of plain gradient descent:
/// how much of what the paper's rows lack is the training alone.
fn by_adam() -> Preset {
    Preset { name: "paper_adam".into(), optimiser: Preset::default().optimiser, ..Preset::paper() }
}

/// `None` where only a shard of it was made.
pub fn run(store: &Store, seed: u64, quick: bool) -> Result<Option<Table2Results>> {
    let (seeds, count) = if quick { (1, QUICK_TARGETS) } else { (SEEDS, TARGETS) };
    let simulation = Simulation::new()?;
    let stored = Stored::new(&simulation)?;
    let bar = progress(seeds * (4 + (SETS.len() * Method::ALL.len()) as u64), "table 2");
    let mut cells: Vec<Table2Cell> = Vec::new();
    for number in 0..seeds {
        let set_seed = seed * SEEDS + number;
        let default = ours::trained(store, &Preset::default(), set_seed, quick)?.0;
        bar.inc(1);
        let paper = ours::trained(store, &Preset::paper(), set_seed, quick)?.0;
        bar.inc(1);
        let paper_adam = ours::trained(store, &by_adam(), set_seed, quick)?.0;
        bar.inc(1);
        // Where all that they estimate is kept already, they are not needed.
        let direct = Lazy::new(|| Direct::train(&simulation, Preset::paper(), set_seed, quick));
        let direct_adam = Lazy::new(|| Direct::train(&simulation, by_adam(), set_seed, quick));
        bar.inc(1);
        for (place, (set, conditions)) in SETS.into_iter().enumerate() {
            let draw = |i| simulation.target(conditions, set_seed, FIRST_STREAM + place as u64, i);
            let targets: Vec<DropTarget> = (0..count).into_par_iter().map(draw).collect::<Result<_>>()?;
            let tuner = Table2Tuners {
                simulation: &simulation,
                stored: &stored,
                default: &default,
                paper: &paper,
                paper_adam: &paper_adam,
                direct: &direct,
                direct_adam: &direct_adam,
            };
            for method in Method::ALL {
                let key = format!("table2-{set}-{}-{set_seed}", method.key());
                let measure = || {
                    tuner.prepare(method)?;
                    SeedAccuracy::measure(&tuner, method, &targets, set_seed)
                };
                let Some(accuracy) = store.piece(&key, measure)? else { continue };
                match cells.iter_mut().find(|c| c.set == set && c.method == method) {
                    Some(cell) => cell.seeds.push(accuracy),
                    None => cells.push(Table2Cell { set, method, seeds: vec![accuracy] }),
                }
                bar.inc(1);
            }
        }
    }
    bar.finish_and_clear();
    Ok((!store.sharded()).then_some(Table2Results { seed, seeds, targets: count, quick, cells }))
}
