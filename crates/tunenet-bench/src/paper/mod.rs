//! `tunenet bench paper`: the published tables and figures, next to the results of this program and its rivals.

mod figure3;
mod table1;
mod table2;
mod table3;

use anyhow::Result;
use serde_json::{Map, json};

use super::resume::{Store, program};
use crate::args::{BenchPaper, Measured, PaperTable};
use tunenet_cli::exit_status::Exit;
use tunenet_cli::view::answer;
use tunenet_cli::view::json::print_json;
use tunenet_cli::view::text::stage;

/// How many seeds, in words.
fn counted_seeds(seeds: u64) -> String {
    if seeds == 1 { "1 seed".into() } else { format!("{seeds} seeds") }
}

pub fn run(options: &BenchPaper) -> Result<Exit> {
    let seed = options.common.seed;
    let key = json!({ "program": program()?, "seed": seed, "quick": options.quick });
    let store = Store::open(&options.out, key, &options.sharing)?;
    let mut all = Map::from_iter([("schema".into(), json!("tunenet.bench.paper/1"))]);
    for table in if options.only.is_empty() { &PaperTable::ALL[..] } else { &options.only } {
        let out = &options.out;
        let (name, text, value) = match table {
            PaperTable::Table1 => {
                let Some(results) = table1::run(&store, seed, options.quick)? else { continue };
                table1::write(out, &results)?;
                ("table1", table1::markdown(&results), table1::as_json(&results))
            }
            PaperTable::Table2 => {
                let Some(results) = table2::run(&store, seed, options.quick)? else { continue };
                table2::write(out, &results)?;
                ("table2", table2::markdown(&results), table2::as_json(&results))
            }
            PaperTable::Table3 => {
                let Some(results) = table3::run(&store, seed, options.quick)? else { continue };
                table3::write(out, &results)?;
                ("table3", table3::markdown(&results), table3::as_json(&results))
            }
            PaperTable::Figure2 => {
                let Some(results) = table2::run(&store, seed, options.quick)? else { continue };
                table2::write_figure(out, &results)?;
                ("figure2", table2::figure_markdown(&results), table2::figure_json(&results))
            }
            PaperTable::Figure3 => {
                let Some(results) = figure3::run(&store, seed, options.quick)? else { continue };
                figure3::write(out, &results)?;
                ("figure3", figure3::markdown(&results), results.as_json())
            }
        };
        answer::text(options.common.json, &text)?;
        stage("wrote", &out.join(format!("{name}.md")).display().to_string());
        all.insert(name.into(), value);
    }
    if let Some(exit) = store.finished(Measured::Paper(options.clone()), options.common.json)? {
        return Ok(exit);
    }
    if options.common.json {
        print_json(&all.into())?;
    }
    Ok(Exit::Done)
}
