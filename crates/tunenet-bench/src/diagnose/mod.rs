//! `tunenet bench diagnose`: whether the effect that is named is the one that was hidden.
//!
//! ```text
//! rows → blind → ask → trial → results → write
//! ```
//!
//! Every finished piece is kept by [`resume`](super::resume).

#[cfg(test)]
mod agreement;
mod arm;
mod ask;
mod blind;
mod driven;
#[cfg(test)]
mod fixed;
mod results;
mod rows;
mod trial;
mod write;

use anyhow::Result;
use rayon::prelude::*;
use serde_json::json;

use self::ask::Asked;
use self::blind::{BlindSet, Trouble, stream};
use self::results::DiagnoseResults;
use self::rows::{Counts, DiagnoseCell};
use self::trial::BlindTrial;
use super::resume::{Store, program};
use crate::args::{BenchDiagnose, DiagnoseRow, Measured};
use tunenet_cli::exit_status::Exit;
use tunenet_cli::view::answer;
use tunenet_cli::view::json::print_json;
use tunenet_cli::view::text::{progress, stage};

/// Names the draws of this bench; nothing else, tests included, draws under it.
const PURPOSE: &str = "tunenet bench diagnose";
/// Threads of the row that is timed.
const TIMED_THREADS: usize = 2;

pub fn run(options: &BenchDiagnose) -> Result<Exit> {
    if options.arm {
        return arm::run(options);
    }
    if options.driven {
        return driven::run(options);
    }
    let rows: Vec<DiagnoseRow> =
        DiagnoseRow::ALL.into_iter().filter(|r| options.only.is_empty() || options.only.contains(r)).collect();
    let counts = if options.quick { Counts::QUICK } else { Counts::WHOLE };
    let seed = options.common.seed;
    let store = Store::open(&options.out, json!({ "program": program()?, "seed": seed }), &options.sharing)?;
    let cells: Vec<DiagnoseCell> = rows.iter().flat_map(|row| row.cells(counts)).collect();
    let bar = progress(cells.iter().map(|c| c.count).sum(), "sets");
    let threads = tunenet_cli::pool(options.jobs)?;
    let timed = tunenet_cli::pool(Some(TIMED_THREADS))?;
    let asked = Asked::new()?;
    let mut finished: Vec<(DiagnoseRow, Vec<BlindTrial>)> = Vec::new();
    for row in rows {
        let those: Vec<&DiagnoseCell> = cells.iter().filter(|c| c.row == row && store.turn()).collect();
        let keep = |cell: &&DiagnoseCell, alone: bool| {
            let name = format!("{}-from-{}-{}", cell.name, cell.first, cell.count);
            let trials = store.keep(&name, || trials(&asked, cell, seed, PURPOSE, alone));
            bar.inc(cell.count);
            trials
        };
        let pieces: Vec<Vec<BlindTrial>> = if row == DiagnoseRow::Cost {
            timed.install(|| those.iter().map(|cell| keep(cell, true)).collect::<Result<_>>())?
        } else {
            threads.install(|| those.par_iter().map(|cell| keep(cell, false)).collect::<Result<_>>())?
        };
        if options.sharing.shard.is_none() {
            finished.push((row, pieces.concat()));
        }
    }
    bar.finish_and_clear();
    if let Some(exit) = store.finished(Measured::Diagnose(options.clone()), options.common.json)? {
        return Ok(exit);
    }
    let results = DiagnoseResults {
        schema: "tunenet.bench.diagnose/1",
        command: command(options),
        version: env!("CARGO_PKG_VERSION"),
        seed,
        quick: options.quick,
        rows: finished
            .iter()
            .map(|(row, trials)| results::table(*row, trials))
            .chain([results::summary(&finished)])
            .collect(),
    };
    write::all(&options.out, &results)?;
    answer::text(options.common.json, &write::markdown(&results))?;
    stage("wrote", &options.out.join("diagnose.md").display().to_string());
    if options.common.json {
        print_json(&serde_json::to_value(&results)?)?;
    }
    Ok(Exit::Done)
}

/// The command that makes these results again.
fn command(options: &BenchDiagnose) -> String {
    let only = match &options.only[..] {
        [] => String::new(),
        rows => format!(" --only {}", rows.iter().map(|r| r.name()).collect::<Vec<_>>().join(" ")),
    };
    let quick = if options.quick { " --quick" } else { "" };
    format!("tunenet bench diagnose{quick} --seed {}{only}", options.common.seed)
}

/// The sets of a cell, each asked about; one after the other where they are timed.
fn trials(asked: &Asked, cell: &DiagnoseCell, seed: u64, purpose: &str, alone: bool) -> Result<Vec<BlindTrial>> {
    let numbers = cell.first..cell.first + cell.count;
    let one = |number| trial(asked, cell, seed, purpose, number);
    if alone { numbers.map(one).collect() } else { numbers.into_par_iter().map(one).collect() }
}

fn trial(asked: &Asked, cell: &DiagnoseCell, seed: u64, purpose: &str, number: u64) -> Result<BlindTrial> {
    let mut random = stream(purpose, seed, &cell.name, number);
    let truth: Vec<String> = cell.recipe.hidden.iter().map(|kind| kind.name().into()).collect();
    let mut trial = BlindTrial { truth, drops: cell.recipe.drops, answer: None, floor_m: None, then: None };
    let Some(set) = BlindSet::draw(&cell.recipe, &mut random)? else { return Ok(trial) };
    let other = match set.stated_mass_kg {
        Some(mass_kg) => Some(Asked::with_mass(mass_kg)?),
        None if cell.row == DiagnoseRow::Formulas => Some(Asked::with_formulas()?),
        None => None,
    };
    let (answer, experiment) = other.as_ref().unwrap_or(asked).ask(&set.seen, &set.held_out)?;
    trial.answer = Some(answer);
    if cell.row == DiagnoseRow::Experiment {
        if let Some(throw) = experiment {
            let mut seen = set.seen.clone();
            seen.push(set.thrown(throw.position_m, throw.velocity_m_s, &mut random)?);
            trial.then = Some(asked.ask(&seen, &[])?.0);
        }
    } else if cell.recipe.trouble == Trouble::None {
        trial.floor_m = set.floor().map(|floor| (floor.held_out_m, floor.forecast_m));
    }
    Ok(trial)
}
