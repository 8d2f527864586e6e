//! The results as Markdown for users, CSV for plots and JSON for programs.

use std::fmt::Write;
use std::path::Path;

use anyhow::Result;

use super::results::{DiagnoseResults, DiagnoseTable};
use crate::goals::met;
use crate::output::{file_of, write_all};

/// Writes `diagnose.md`, `goals.md`, `diagnose.csv`, `confusion.csv` and `diagnose.json`; none is ever half written.
pub fn all(folder: &Path, results: &DiagnoseResults) -> Result<()> {
    let texts = [
        ("diagnose.md", markdown(results)),
        ("goals.md", goals(results)),
        ("diagnose.csv", rates(results)),
        ("confusion.csv", confusion(results)),
        ("diagnose.json", file_of(&serde_json::to_value(results)?)),
    ];
    write_all(folder, texts)
}

/// The tables. Writing to a string cannot fail, so its results are dropped.
pub fn markdown(results: &DiagnoseResults) -> String {
    let mut out = String::new();
    let _ = writeln!(out, "# Diagnosis of blind sets\n\n    {}\n", results.command);
    let _ = writeln!(
        out,
        "tunenet {}, seed {}. The recordings come from an integrator of their own; 3-D, 120 Hz, 1.8 s, 2 mm of noise. \
         Numbers are percent of the sets where nothing else is said. Exact twins count as exact where they are named \
         together and nothing else with them.\n",
        results.version, results.seed
    );
    if results.quick {
        let _ = writeln!(out, "Quick: few sets of each kind; the figures are indicative only.\n");
    }
    results.rows.iter().for_each(|table| one(&mut out, table));
    out
}

/// What is aimed at and what was measured, in one table.
fn goals(results: &DiagnoseResults) -> String {
    let mut out = format!("# Goals of the diagnosis\n\n    {}\n\n", results.command);
    out.push_str("| row | what | aim | measured | |\n|---|---|---|---:|---|\n");
    for table in &results.rows {
        for goal in &table.goals {
            let verdict = met(goal.met);
            let (relation, limit, measured) = (goal.relation, goal.limit, number(goal.measured));
            let _ = writeln!(out, "| `{}` | {} | {relation} {limit} | {measured} | {verdict} |", table.row, goal.what);
        }
    }
    out
}

fn one(out: &mut String, table: &DiagnoseTable) {
    let _ = writeln!(out, "## {}: {}\n", table.row, table.title);
    let _ = writeln!(out, "| | {} |\n|---|{}", table.columns.join(" | "), "---:|".repeat(table.columns.len()));
    for line in &table.lines {
        let numbers: Vec<String> = line.numbers.iter().map(|n| number(*n)).collect();
        let _ = writeln!(out, "| {} | {} |", line.label, numbers.join(" | "));
    }
    out.push('\n');
    for goal in &table.goals {
        let verdict = met(goal.met);
        let (limit, measured) = (goal.limit, number(goal.measured));
        let _ = writeln!(out, "- {}: {} {limit}, measured {measured}, {verdict}", goal.what, goal.relation);
    }
    if !table.goals.is_empty() {
        out.push('\n');
    }
    let mut truth = "";
    for (hidden, answer, count) in &table.confusion {
        let start = if hidden == truth {
            "; "
        } else if truth.is_empty() {
            "- "
        } else {
            "\n- "
        };
        let head = if hidden == truth { String::new() } else { format!("{hidden}: ") };
        let _ = write!(out, "{start}{head}{answer} ×{count}");
        truth = hidden;
    }
    out.push_str(if truth.is_empty() { "" } else { "\n\n" });
}

/// Whole where it is whole.
fn number(value: f64) -> String {
    if value.fract() == 0.0 {
        return format!("{value:.0}");
    }
    let decimals = if value.abs() < 10.0 { 3 } else { 1 };
    format!("{value:.decimals$}")
}

fn rates(results: &DiagnoseResults) -> String {
    let mut out = "row,line,column,value\n".to_owned();
    for table in &results.rows {
        for line in &table.lines {
            for (column, value) in table.columns.iter().zip(&line.numbers) {
                let _ = writeln!(out, "{},\"{}\",{column},{value}", table.row, line.label);
            }
        }
    }
    out
}

fn confusion(results: &DiagnoseResults) -> String {
    let mut out = "row,truth,answer,count\n".to_owned();
    for table in &results.rows {
        for (truth, answer, count) in &table.confusion {
            let _ = writeln!(out, "{},\"{truth}\",\"{answer}\",{count}", table.row);
        }
    }
    out
}
