//! `tunenet bench paper`: the published tables, beside what this program and its rivals reach.

mod table1;
mod table3;

use anyhow::{Context, Result};
use serde_json::{Map, json};

use super::resume::Store;
use crate::cli::{BenchPaper, PaperTable};
use crate::commands::{load, print_json};
use crate::failure::Exit;
use crate::terminal::stage;

pub fn run(options: &BenchPaper) -> Result<Exit> {
    let seed = options.common.seed;
    // The version alone would not tell a rebuilt program from the one that made a cell.
    let program = load::hash(&std::env::current_exe().context("this program's own path")?)?;
    let key = json!({ "program": program, "seed": seed, "quick": options.quick });
    let store = Store::open(&options.out, key)?;
    let mut all = Map::from_iter([("schema".into(), json!("tunenet.bench.paper/1"))]);
    for table in if options.only.is_empty() { &PaperTable::ALL[..] } else { &options.only } {
        match table {
            PaperTable::Table1 => {
                let results = table1::run(&store, seed, options.quick)?;
                table1::write(&options.out, &results)?;
                anstream::eprintln!("{}", table1::markdown(&results));
                stage("wrote", &options.out.join("table1.md").display().to_string());
                all.insert("table1".into(), table1::as_json(&results));
            }
            PaperTable::Table3 => {
                let results = table3::run(&store, seed, options.quick)?;
                table3::write(&options.out, &results)?;
                anstream::eprintln!("{}", table3::markdown(&results));
                stage("wrote", &options.out.join("table3.md").display().to_string());
                all.insert("table3".into(), table3::as_json(&results));
            }
        }
    }
    if options.common.json {
        print_json(&all.into());
    }
    Ok(Exit::Done)
}
