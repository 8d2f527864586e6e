//! The results as Markdown for users, CSV for plots and JSON for programs.

use std::fmt::Write;
use std::path::Path;

use anyhow::Result;

use super::general;
use super::measure::short;
use super::results::{MethodErrors, TuningResults, TuningTable};
use super::rows::BUDGETS;
use crate::goals::met;
use crate::output::{file_of, write_all};

/// Writes `tuning.md`, `tuning.csv` and `tuning.json`; none is ever half written.
pub fn all(folder: &Path, results: &TuningResults) -> Result<()> {
    write_all(
        folder,
        [
            ("tuning.md", markdown(results)),
            ("tuning.csv", csv(results)),
            ("tuning.json", file_of(&serde_json::to_value(results)?)),
        ],
    )
}

/// The tables. Writing to a string cannot fail, so its results are dropped.
pub fn markdown(results: &TuningResults) -> String {
    let mut out = String::new();
    let _ = writeln!(out, "# Tuning: error after K rollouts\n\n    {}\n", results.command);
    let trainings = results.trainings.iter().map(u64::to_string).collect::<Vec<_>>().join(", ");
    let _ = writeln!(
        out,
        "tunenet {}, seed {}, training seeds {trainings}. Targets come from a closed form, not from the simulator that is \
         tuned; height of fall and floor are known. Cells: mean absolute error (median); ± is the spread of the mean over \
         trainings. The judge is a maximum-likelihood fit of the same data by the closed form; the bound is Cramér and \
         Rao's, as a mean absolute error.\n",
        results.version, results.seed
    );
    if results.quick {
        let _ = writeln!(out, "Quick: one training of a quarter of the steps; the figures are indicative only.\n");
    }
    for table in &results.rows {
        one_table(&mut out, table);
    }
    out.push_str(&general::markdown(&results.general));
    if let Some(seconds) = results.making {
        let sum = seconds.generate + seconds.train;
        let core = seconds.train_on_core.map_or(String::new(), |s| format!(" (one core, {s:.1} s of it on that core)"));
        let verdict = met(sum <= results.making_limit_s);
        let _ = writeln!(
            out,
            "## Making a model of preset `default`\n\n`gen` {:.1} s + `train` {:.1} s{core} = {sum:.1} s; goal {} s: {verdict}\n",
            seconds.generate, seconds.train, results.making_limit_s
        );
    }
    for warning in &results.warnings {
        let _ = writeln!(out, "Left out: {warning}\n");
    }
    out
}

fn one_table(out: &mut String, table: &TuningTable) {
    let noise = table.noise_m.map_or(String::new(), |n| format!(", noise {} mm", n * 1e3));
    let _ = writeln!(out, "## {}: {} targets{noise}, {}\n", table.row, table.targets, table.unit);
    if let Some(judge) = &table.reference {
        let bound = judge.bound.map_or("not finite on average".into(), short);
        let (mean, median) = (short(judge.mean), short(judge.median));
        let _ = writeln!(out, "Maximum likelihood {mean} ({median}); bound {bound}.\n");
    }
    let heads = BUDGETS.map(|k| format!(" K={k} |")).concat();
    let _ = writeln!(out, "| method |{heads}\n|---|{}", "---|".repeat(BUDGETS.len()));
    for method in &table.methods {
        let _ = writeln!(out, "| {} | {} |", method.title, cells(method).join(" | "));
    }
    if let (Some(judge), Some(ours)) = (&table.reference, table.methods.first()) {
        let ratios = |title: &str, of: &[f64], to: f64| {
            let each: Vec<String> = of.iter().map(|v| format!("{:.2}", v / to)).collect();
            format!("| {title} | {} |\n", each.join(" | "))
        };
        // Without noise both are 0, and nothing can be a multiple of them.
        if table.noise_m.is_some_and(|n| n > 0.0) {
            out.push_str(&ratios("mean of `default` / maximum likelihood", &ours.mean, judge.mean));
            out.push_str(&ratios("median of `default` / maximum likelihood", &ours.median, judge.median));
            if let Some(bound) = judge.bound {
                out.push_str(&ratios("mean of `default` / bound", &ours.mean, bound));
            }
        }
    }
    out.push('\n');
    for goal in &table.goals {
        let source = if goal.limit_is.is_empty() { String::new() } else { format!(" ({})", goal.limit_is) };
        let (limit, measured) = (short(goal.limit), short(goal.measured));
        let verdict = met(goal.met);
        let _ = writeln!(out, "- K={}, {} ≤ {limit}{source}: {measured}, {verdict}", goal.rollouts, goal.statistic);
    }
    if let Some(note) = &table.note {
        let _ = writeln!(out, "- {note}");
    }
    if !table.goals.is_empty() {
        out.push('\n');
    }
}

fn cells(method: &MethodErrors) -> Vec<String> {
    let cell = |b: usize| {
        let spread = method.spread.get(b).map_or(String::new(), |s| format!(" ± {}", short(*s)));
        format!("{}{spread} ({})", short(method.mean[b]), short(method.median[b]))
    };
    (0..BUDGETS.len()).map(cell).collect()
}

fn csv(results: &TuningResults) -> String {
    let mut out = "row,method,trainings,rollouts,unit,mean,spread,median\n".to_owned();
    for (table, method) in results.rows.iter().flat_map(|t| t.methods.iter().map(move |m| (t, m))) {
        for (b, k) in BUDGETS.iter().enumerate() {
            let spread = method.spread.get(b).map_or(String::new(), f64::to_string);
            let MethodErrors { name, trainings, mean, median, .. } = method;
            let (row, unit) = (&table.row, table.unit);
            let _ = writeln!(out, "{row},{name},{trainings},{k},{unit},{},{spread},{}", mean[b], median[b]);
        }
    }
    out.push_str(&general::csv(&results.general));
    out
}
