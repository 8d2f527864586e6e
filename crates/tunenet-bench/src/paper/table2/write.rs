//! The table as Markdown for users, CSV for plots and JSON for programs; and its figure.

use std::fmt::Write;
use std::path::Path;

use anyhow::Result;
use serde_json::{Map, Value, json};

use crate::output::{file_of, write_all};

use super::super::counted_seeds;
use super::methods::Method;
use super::results::{POINTS, ROUNDING, TIED, Table2Cell, Table2Results};
use super::{BUDGETS, SETS, figure};

/// `table2.default.easy.k5`, and the value in the paper.
pub fn as_json(results: &Table2Results) -> Value {
    let mut all = Map::new();
    for method in Method::ALL {
        let mut sets = Map::new();
        for (set, _) in SETS {
            let Some(cell) = results.cells_of(set).find(|c| c.method == method) else { continue };
            let mut row = Map::new();
            for k in BUDGETS {
                let (mean, spread) = cell.after(k);
                row.insert(format!("k{k}"), json!(mean));
                row.insert(format!("k{k}_spread"), json!(spread));
                if let Some(published) = method.published(set, k) {
                    row.insert(format!("k{k}_published"), json!(published));
                }
            }
            sets.insert(set.into(), row.into());
        }
        all.insert(method.key().into(), sets.into());
    }
    all.insert("seeds".into(), json!(results.seeds));
    all.insert("targets".into(), json!(results.targets));
    all.into()
}

/// The table for users. Writing to a string cannot fail, so its results are dropped.
pub fn markdown(results: &Table2Results) -> String {
    let mut out = String::new();
    let quick = if results.quick { " --quick" } else { "" };
    let _ = writeln!(out, "# Table 2: error of the restitution\n");
    let _ = writeln!(out, "    tunenet bench paper --only table2{quick} --seed {}\n", results.seed);
    let _ = writeln!(
        out,
        "Mean absolute error after K rollouts on a target; {} of {} targets and one training each, ± the spread over the \
         seeds. Targets are a closed form's drops. In brackets what the paper reports of its own method on its own \
         simulator (arXiv 1907.11200). The least error of a column is bold.\n",
        counted_seeds(results.seeds),
        results.targets
    );
    for (set, conditions) in SETS {
        let (low, high) = conditions.restitution;
        let noise = match conditions.noise_m {
            0.0 => "no noise".to_owned(),
            sd => format!("noise of {} cm", 100.0 * sd),
        };
        let _ = writeln!(out, "## {set}: restitution {low} to {high}, {noise}\n");
        let heads = BUDGETS.map(|k| format!(" K = {k} |")).concat();
        let _ = writeln!(out, "| method |{heads}\n|---|{}", "---|".repeat(BUDGETS.len()));
        for cell in results.cells_of(set) {
            let mut row = format!("| {} |", cell.method.title());
            for k in BUDGETS {
                let (mean, spread) = cell.after(k);
                let best = results.best(set, k) == Some(cell.method);
                let value =
                    if results.seeds == 1 { format!("{mean:.1e}") } else { format!("{mean:.1e} ± {spread:.0e}") };
                let value = if best { format!("**{value}**") } else { value };
                let published = cell.method.published(set, k).map_or(String::new(), |p| format!(" ({p})"));
                let _ = write!(row, " {value}{published} |");
            }
            let _ = writeln!(out, "{row}");
        }
        let lost: Vec<String> = BUDGETS
            .into_iter()
            .filter_map(|k| Some((k, results.best(set, k).filter(|best| *best != Method::Default)?)))
            .map(|(k, best)| format!("K = {k} to {}", best.title()))
            .collect();
        let verdict = if lost.is_empty() {
            "Preset `default` has the least error of every column.".into()
        } else {
            format!("Preset `default` loses {}.", lost.join("; "))
        };
        let _ = writeln!(out, "\n{verdict}\n");
    }
    let _ = writeln!(
        out,
        "A column counts as preset `default`'s where no other method's error is less by more than {} %, or by more than the \
         {ROUNDING:e} of rounding.\n",
        100.0 * TIED
    );
    let idle: Vec<&str> = Method::ALL.into_iter().filter(|m| !m.rolls_out()).map(Method::title).collect();
    let _ = writeln!(out, "No rollouts are spent on a target by: {}.", idle.join("; "));
    out
}

/// Writes `table2.md`, `table2.csv` and `table2.json`; none is ever half written.
pub fn write(folder: &Path, results: &Table2Results) -> Result<()> {
    let mut csv = "set,method,seed,rollouts,error\n".to_owned();
    for cell in &results.cells {
        for (seed, accuracy) in cell.seeds.iter().enumerate() {
            for (k, error) in POINTS.iter().zip(&accuracy.mean) {
                let _ = writeln!(csv, "{},{},{seed},{k},{error}", cell.set, cell.method.key());
            }
        }
    }
    write_all(
        folder,
        [("table2.md", markdown(results)), ("table2.csv", csv), ("table2.json", file_of(&as_json(results)))],
    )
}

/// `figure2.default.easy` as points of rollouts and error, the mean over the seeds.
pub fn figure_json(results: &Table2Results) -> Value {
    let points = |cell: &Table2Cell| POINTS.iter().enumerate().map(|(i, k)| json!([k, cell.at(i)])).collect::<Vec<_>>();
    let of = |method: Method| {
        let sets = results.cells.iter().filter(|c| c.method == method).map(|c| (c.set.to_owned(), points(c).into()));
        (method.key().to_owned(), Value::Object(sets.collect()))
    };
    Value::Object(Method::ALL.into_iter().map(of).collect())
}

/// What the figure shows, in words.
pub fn figure_markdown(results: &Table2Results) -> String {
    let quick = if results.quick { " --quick" } else { "" };
    format!(
        "# Figure 2: error of the restitution against the rollouts spent\n\n    \
         tunenet bench paper --only figure2{quick} --seed {}\n\n\
         Mean over {} of {} targets each; the numbers are in figure2.json.\n\n\
         ![Error of the restitution against rollouts, four panels](figure2.svg)\n",
        results.seed,
        counted_seeds(results.seeds),
        results.targets
    )
}

/// Writes `figure2.md`, `figure2.json` and `figure2.svg`; none is ever half written.
pub fn write_figure(folder: &Path, results: &Table2Results) -> Result<()> {
    let drawn = figure::draw(results);
    write_all(
        folder,
        [
            ("figure2.md", figure_markdown(results)),
            ("figure2.json", file_of(&figure_json(results))),
            ("figure2.svg", drawn),
        ],
    )
}

#[cfg(test)]
mod tests {
    use super::super::results::SeedAccuracy;
    use super::*;

    fn results(ours: f64, rival: f64) -> Table2Results {
        let cell = |method, error| Table2Cell {
            set: "easy",
            method,
            seeds: vec![SeedAccuracy { mean: vec![error; POINTS.len()] }],
        };
        let cells = vec![cell(Method::Default, ours), cell(Method::Brent, rival)];
        Table2Results { seed: 3, seeds: 1, targets: 40, quick: true, cells }
    }

    /// The rule by which a column is ours stands below the table, and is the one that is used.
    #[test]
    fn what_counts_as_tied_is_said_and_done() {
        let (tied, lost) = (markdown(&results(1.009e-3, 1e-3)), markdown(&results(1.02e-3, 1e-3)));
        for text in [&tied, &lost] {
            assert!(text.contains("less by more than 1 %, or by more than the 1e-12 of rounding"), "{text}");
        }
        let of_easy = |text: &str| text.split("## ").nth(1).unwrap_or_default().to_owned();
        assert!(of_easy(&tied).contains("has the least error of every column"), "{tied}");
        assert!(of_easy(&lost).contains("loses K = 1 to "), "{lost}");
    }

    /// It may be asked for without the table, whose file is not there then.
    #[test]
    fn the_figure_names_files_of_its_own_alone() {
        let text = figure_markdown(&results(1e-3, 1e-3));
        assert!(
            !text.contains("table2") && text.contains("figure2.json") && text.contains("Mean over 1 seed of"),
            "{text}"
        );
    }
}
