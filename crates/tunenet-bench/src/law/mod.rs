//! `tunenet bench law`: whether the formula that is found is the one that was hidden.
//!
//! ```text
//! cash_karp ← motion ← arena, term, strange ← laws ← set
//! rows → set → files → ask (the tool) → answer → judge, predict → trial → results → write
//! ```
//!
//! Nothing of the motions is shared with the simulator that is fitted; the tool gets files alone, and is started as a user
//! starts it.

mod answer;
mod arena;
mod ask;
mod cash_karp;
mod files;
mod judge;
mod laws;
mod motion;
mod predict;
mod results;
pub mod rows;
mod set;
mod strange;
mod term;
mod trial;
mod write;

use anyhow::Result;
use rayon::prelude::*;
use serde_json::json;
use tunenet_cli::exit_status::Exit;
use tunenet_cli::files::{hash, programs};
use tunenet_cli::view::answer as view;
use tunenet_cli::view::json::print_json;
use tunenet_cli::view::text::{progress, stage};

use self::results::LawResults;
use self::rows::sets;
use self::trial::{LawTrial, trial};
use crate::args::{BenchLaw, Measured};
use crate::output::{file_of, write_all};
use crate::resume::{Store, program};

/// Names the draws of this bench; nothing else, tests included, draws under it.
const PURPOSE: &str = "tunenet bench law";
/// Sets that are kept in one piece.
const SETS_PER_PIECE: usize = 4;
/// Where the files of sets stay whose answer is not right.
const SETS: &str = "sets";

pub fn run(options: &BenchLaw) -> Result<Exit> {
    let asked = sets(&options.only, options.count());
    let bar = progress(asked.len() as u64, "sets");
    let seed = options.common.seed;
    // The tool is another program than this one, and its answers are what is measured.
    let tool = hash::sha256(&programs::sibling(programs::TUNENET)?)?;
    let run = json!({ "program": program()?, "tool": tool, "seed": seed });
    let store = Store::open(&options.out, run, &options.sharing)?;
    let room = store.room(SETS)?;
    let threads = tunenet_cli::pool(options.jobs)?;
    let mut trials: Vec<LawTrial> = Vec::with_capacity(asked.len());
    let pieces: Vec<_> = asked.chunks(SETS_PER_PIECE).filter(|_| store.turn()).collect();
    let keep = |piece: &&[rows::Asked]| -> Result<Vec<LawTrial>> {
        let first = &piece[0];
        let hidden = first.recipe.hidden.name().replace([' ', ','], "-");
        let name = format!("{}-{hidden}-from-{}-{}", first.row.name(), first.number, piece.len());
        let make = || piece.iter().map(|one| trial(one, PURPOSE, seed, &room, &ask::ask)).collect::<Result<Vec<_>>>();
        let found = store.keep(&name, make);
        bar.inc(piece.len() as u64);
        found
    };
    let found: Vec<Vec<LawTrial>> = threads.install(|| pieces.par_iter().map(keep).collect::<Result<_>>())?;
    trials.extend(found.into_iter().flatten());
    bar.finish_and_clear();
    if let Some(exit) = store.finished(Measured::Law(options.clone()), options.common.json)? {
        return Ok(exit);
    }
    let results = LawResults::new(command(options), seed, options.quick, trials);
    let (text, value) = (write::markdown(&results), serde_json::to_value(&results)?);
    write_all(
        &options.out,
        [("law.md", text.clone()), ("goals.md", write::goals(&results)), ("law.json", file_of(&value))],
    )?;
    view::text(options.common.json, &text)?;
    stage("wrote", &options.out.join("law.md").display().to_string());
    if options.common.json {
        print_json(&value)?;
    }
    Ok(Exit::Done)
}

/// The command that makes these results again.
fn command(options: &BenchLaw) -> String {
    let quick = if options.quick { " --quick" } else { "" };
    let sets = options.sets.map_or_else(String::new, |sets| format!(" --sets {sets}"));
    let only = if options.only.is_empty() { String::new() } else { format!(" --only {}", options.only.join(" ")) };
    format!("tunenet bench law{quick}{sets} --seed {}{only}", options.common.seed)
}

#[cfg(test)]
mod tests {
    use clap::Parser;

    use super::*;
    use crate::args::{Arguments, Command};

    #[test]
    fn the_command_is_repeated_as_it_was_given() {
        let line = "tunenet bench law --quick --sets 2 --seed 5 --only ratio-10 drag-2";
        let words = line.replacen("tunenet bench", "bench", 1);
        let arguments = Arguments::try_parse_from(words.split(' ')).unwrap();
        let Command::Measure(Measured::Law(options)) = arguments.command else { panic!("another bench") };
        assert_eq!((command(&options), options.count()), (line.to_owned(), 2));
    }

    #[test]
    fn another_law_than_those_of_the_bench_is_refused() {
        assert!(Arguments::try_parse_from(["bench", "law", "--only", "drag-7"]).is_err());
    }
}
