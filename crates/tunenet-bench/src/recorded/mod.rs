//! `tunenet bench recorded`: what `diagnose` makes of real joints, whose recordings are no part of this project, held against figures that
//! others published for the same recordings.

mod arm;
mod drive;
mod drive_equations;
mod lagged;
mod rollouts_per_second;
mod servo;
mod table;

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail};
use serde::Serialize;
use serde_json::Value;
use tunenet_cli::exit_status::Exit;
use tunenet_cli::view::answer as view;
use tunenet_cli::view::json::print_json;
use tunenet_cli::view::text::stage;

use crate::args::{BenchRecorded, RecordedRow};
use crate::goals::met;
use crate::output::{file_of, write_all};
use crate::tool::{Said, answered};

/// What is measured, held against its goal.
#[derive(Debug, Clone, Serialize)]
struct Row {
    what: String,
    aim: String,
    measured: String,
    /// What others have for the same recordings.
    others: String,
    /// `None` where it is only reported.
    met: Option<bool>,
}

#[derive(Debug, Clone, Serialize)]
struct RecordedResults {
    schema: &'static str,
    version: &'static str,
    rows: Vec<Row>,
}

pub fn run(options: &BenchRecorded) -> Result<Exit> {
    let measured = folder(options)?;
    std::fs::create_dir_all(&options.out).with_context(|| format!("creating {}", options.out.display()))?;
    let mut rows = Vec::new();
    let wanted = |row: RecordedRow| options.only.is_empty() || options.only.contains(&row);
    if wanted(RecordedRow::Servo) {
        stage("diagnose", "the servo");
        rows.extend(servo::rows(&measured.join("servo-sts3215"), tempfile::tempdir()?.path())?);
    }
    if wanted(RecordedRow::Drive) {
        stage("diagnose", "the drive");
        let folder = tempfile::tempdir()?;
        rows.extend(drive::rows(&measured.join("emps"), folder.path())?);
        rows.push(drive_equations::row(&measured.join("emps/train.csv"), folder.path())?);
    }
    if wanted(RecordedRow::Arm) {
        stage("diagnose", "the arm");
        let (model, data) = (measured.join("models/so101/so101_new_calib.xml"), measured.join("lerobot-v3-so101"));
        rows.extend(arm::rows(&model, &data, tempfile::tempdir()?.path())?);
    }
    let results = RecordedResults { schema: "tunenet.bench.recorded/1", version: env!("CARGO_PKG_VERSION"), rows };
    let (text, value) = (markdown(&results), serde_json::to_value(&results)?);
    write_all(&options.out, [("recorded.md", text.clone()), ("recorded.json", file_of(&value))])?;
    view::text(options.common.json, &text)?;
    stage("wrote", &options.out.join("recorded.md").display().to_string());
    if options.common.json {
        print_json(&value)?;
    }
    Ok(Exit::Done)
}

/// The folder of the recordings.
fn folder(options: &BenchRecorded) -> Result<PathBuf> {
    let named = || std::env::var_os("TUNENET_MEASURED").map(PathBuf::from);
    let Some(folder) = options.measured.clone().or_else(named) else {
        bail!(
            "the recordings are no part of this project: expected their folder as --measured, or in TUNENET_MEASURED"
        );
    };
    std::fs::canonicalize(&folder).with_context(|| format!("opening {}", folder.display()))
}

/// The answer of `tunenet` to these words.
fn asked(words: &[&str], folder: &Path) -> Result<Value> {
    match answered(words, folder)? {
        Said::Answered(answer) => Ok(answer),
        Said::Failed(why) => bail!("tunenet {}: {why}", words.join(" ")),
    }
}

/// The table. Writing to a string cannot fail, so its results are dropped.
fn markdown(results: &RecordedResults) -> String {
    let mut out = String::from("# Recordings of real joints\n\n    tunenet bench recorded\n\n");
    out.push_str("| what | aim | measured | others | |\n|---|---|---:|---|---|\n");
    for Row { what, aim, measured, others, met: is } in &results.rows {
        let _ = writeln!(out, "| {what} | {aim} | {measured} | {others} | {} |", is.map_or("", met));
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_without_a_goal_have_no_verdict() {
        let row =
            |met| Row { what: "error".into(), aim: "at most 1".into(), measured: "2".into(), others: "3".into(), met };
        let results =
            RecordedResults { schema: "s", version: "0", rows: vec![row(None), row(Some(true)), row(Some(false))] };
        let text = markdown(&results);
        let ends: Vec<&str> =
            text.lines().skip(6).map(|line| line.trim_start_matches("| error | at most 1 | 2 | 3 ")).collect();
        assert_eq!(ends, ["|  |", &format!("| {} |", met(true)), &format!("| {} |", met(false))]);
    }
}
