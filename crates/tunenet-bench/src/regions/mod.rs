//! `tunenet bench regions`: how often the intervals and joint regions of several parameters hold the truth.
//!
//! ```text
//! throw, swing (closed forms) → cell (draw, tune, judge) → table
//! ```
//!
//! A finished cell is kept, so that an interrupted run goes on where it stopped.

mod cell;
mod swing;
mod throw;

use std::fmt::Write;

use anyhow::Result;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};
use tunenet_core::statistics::mean;
use tunenet_core::tune::Status;

use self::cell::{Found, RegionCell};
use super::resume::{DRAWS_PER_PIECE, Store, program};
use crate::args::{BenchRegions, Measured};
use crate::output::{file_of, percent, share, write_all};
use tunenet_cli::exit_status::Exit;
use tunenet_cli::view::answer;
use tunenet_cli::view::json::print_json;
use tunenet_cli::view::text::{progress, stage};

/// What one cell found: shares of its recordings.
#[derive(Debug, Clone, Serialize, Deserialize)]
struct RegionRow {
    #[serde(flatten)]
    cell: RegionCell,
    /// For each parameter, how often its interval holds the truth, and how often it is determined.
    parameters: Vec<Interval>,
    /// Of those with a region: how often it holds the truth, by the likelihood and as it is drawn.
    joint: f64,
    drawn: f64,
    /// How often its boundary had to be walked.
    walked: f64,
    /// How often there was no region, poor fits included.
    without: f64,
    called_poor: f64,
    /// Rollouts of a tuning: the mean, and the most.
    rollouts: f64,
    most_rollouts: usize,
}

#[derive(Debug, Clone, Serialize, Deserialize)]
struct Interval {
    name: String,
    covered: f64,
    determined: f64,
}

pub fn run(options: &BenchRegions) -> Result<Exit> {
    let seed = options.common.seed;
    let store = Store::open(&options.out, json!({ "program": program()?, "seed": seed }), &options.sharing)?;
    let cells = RegionCell::all();
    let bar = progress(cells.len() as u64 * u64::from(options.count()), "recordings");
    let mut rows = Vec::with_capacity(cells.len());
    for (number, cell) in cells.into_iter().enumerate() {
        let mut found: Vec<Found> = Vec::with_capacity(options.count() as usize);
        for first in (0..options.count()).step_by(DRAWS_PER_PIECE as usize) {
            let draws = first..first.saturating_add(DRAWS_PER_PIECE).min(options.count());
            let one = |draw: u32| cell.one(seed, ((number as u64) << 32) + u64::from(draw));
            let make = || draws.clone().into_par_iter().map(one).collect::<Result<Vec<_>>>();
            let name = format!("region-{number}-from-{first}-to-{}", draws.end);
            found.extend(store.piece(&name, make)?.into_iter().flatten());
            bar.inc(draws.len() as u64);
        }
        if options.sharing.shard.is_none() {
            rows.push(RegionRow::new(cell, &found));
        }
    }
    bar.finish_and_clear();
    if let Some(exit) = store.finished(Measured::Regions(options.clone()), options.common.json)? {
        return Ok(exit);
    }
    let command = format!("tunenet bench regions --draws {} --seed {seed}", options.count());
    let text = markdown(&command, &rows);
    let object: Value = json!({
        "schema": "tunenet.bench.regions/1", "draws": options.count(), "seed": seed, "cells": rows, "warnings": [],
    });
    write_all(&options.out, [("regions.md", text.clone()), ("regions.json", file_of(&object))])?;
    answer::text(options.common.json, &text)?;
    stage("wrote", &options.out.join("regions.md").display().to_string());
    if options.common.json {
        print_json(&object)?;
    }
    Ok(Exit::Done)
}

impl RegionRow {
    fn new(cell: RegionCell, found: &[Found]) -> Self {
        let count = found.len() as f64;
        let names: Vec<String> = found
            .iter()
            .map(|f| &f.parameters)
            .find(|p| !p.is_empty())
            .into_iter()
            .flatten()
            .map(|p| p.0.clone())
            .collect();
        let interval = |(i, name): (usize, String)| {
            let is = |what: &dyn Fn(&(String, bool, Status)) -> bool| {
                share(found, |f| f.parameters.get(i).is_some_and(what))
            };
            Interval { name, covered: is(&|p| p.1), determined: is(&|p| p.2.identified()) }
        };
        let regions: Vec<(bool, bool)> = found.iter().filter_map(|f| f.region).collect();
        Self {
            cell,
            parameters: names.into_iter().enumerate().map(interval).collect(),
            joint: share(&regions, |r| r.0),
            drawn: share(&regions, |r| r.1),
            walked: share(found, |f| f.walked),
            without: 1.0 - regions.len() as f64 / count,
            called_poor: share(found, |f| f.poor),
            rollouts: mean(found.iter().map(|f| f.rollouts as f64)),
            most_rollouts: found.iter().map(|f| f.rollouts).max().unwrap_or_default(),
        }
    }
}

/// The table. Writing to a string cannot fail, so its results are dropped.
fn markdown(command: &str, rows: &[RegionRow]) -> String {
    let mut out = format!("# Several parameters: how often 95 % regions hold the truth\n\n    {command}\n\n");
    out.push_str(
        "Recordings come from closed forms, not from the simulator that is tuned. *Joint* is the region by the likelihood \
         ratio, *drawn* its ellipse or walked boundary, both of the recordings that have one.\n\n\
         | recordings | joint | drawn | walked | no region | poor fit | intervals (determined) | rollouts (most) |\n\
         |---|---|---|---|---|---|---|---|\n",
    );
    for row in rows {
        let each = |p: &Interval| format!("{} {} ({})", p.name, percent(p.covered), percent(p.determined));
        let intervals = row.parameters.iter().map(each).collect::<Vec<_>>().join(", ");
        let shares = [row.joint, row.drawn, row.walked, row.without, row.called_poor].map(percent).join(" | ");
        let (rollouts, most) = (row.rollouts, row.most_rollouts);
        let _ = writeln!(out, "| {} | {shares} | {intervals} | {rollouts:.0} ({most}) |", row.cell.name());
    }
    out
}

#[cfg(test)]
mod tests;
