//! `tunenet bench intervals`: how often a 95 % interval holds the truth.
//!
//! Drops come from formulas with white noise on the height, the way `bench tuning` makes its targets, and with the disturbances that
//! recordings have; lists of impact times come from formulas as well.

mod cell;

use anyhow::Result;
use rayon::prelude::*;
use serde_json::{Value, json};
use tunenet_core::statistics::{mean, median};
use tunenet_core::tune::Verdict;

use self::cell::{Cell, Tried, cells};
use crate::args::{BenchIntervals, Measured};
use crate::output::{percent, share};
use crate::resume::{DRAWS_PER_PIECE, Store, program};
use tunenet_cli::exit_status::Exit;
use tunenet_cli::view::answer;
use tunenet_cli::view::json::print_json;
use tunenet_cli::view::text::{progress, table};

/// What one cell of the table found.
struct Found {
    cell: Cell,
    /// Of the drops that were tuned.
    covered: f64,
    called_poor: f64,
    /// Neither tuned nor a poor fit.
    unanswered: f64,
    mean_error: f64,
    median_error: f64,
}

pub fn run(options: &BenchIntervals) -> Result<Exit> {
    let seed = options.common.seed;
    let store = Store::open(&options.out, json!({ "program": program()?, "seed": seed }), &options.sharing)?;
    let cells = cells();
    let bar = progress(cells.len() as u64 * u64::from(options.count()), "drops");
    let mut found = Vec::with_capacity(cells.len());
    for (position, cell) in cells.into_iter().enumerate() {
        let mut tried: Vec<Tried> = Vec::with_capacity(options.count() as usize);
        for first in (0..options.count()).step_by(DRAWS_PER_PIECE as usize) {
            let numbers = first..first.saturating_add(DRAWS_PER_PIECE).min(options.count());
            let one = |number| cell.tune(seed, number);
            let name = format!("intervals-{position}-from-{first}-to-{}", numbers.end);
            let make = || numbers.clone().into_par_iter().map(one).collect::<Result<Vec<Tried>>>();
            tried.extend(store.piece(&name, make)?.into_iter().flatten());
            bar.inc(numbers.len() as u64);
        }
        if options.sharing.shard.is_none() {
            found.push(Found::new(cell, &tried));
        }
    }
    bar.finish_and_clear();
    if let Some(exit) = store.finished(Measured::Intervals(options.clone()), options.common.json)? {
        return Ok(exit);
    }
    let head = [
        "recording; height, surface",
        "restitution",
        "noise",
        "disturbance",
        "95 % holds",
        "poor fit",
        "no answer",
        "mean error",
        "median",
    ];
    let mut rows: Vec<Vec<String>> = vec![head.map(String::from).to_vec()];
    rows.extend(found.iter().map(Found::row));
    answer::text(options.common.json, &table(&rows))?;
    if options.common.json {
        let cells: Vec<Value> = found.iter().map(Found::json).collect();
        print_json(&json!({
            "schema": "tunenet.bench.intervals/1", "drops": options.count(), "seed": options.common.seed, "cells": cells,
            "warnings": [],
        }))?;
    }
    Ok(Exit::Done)
}

impl Found {
    fn new(cell: Cell, tried: &[Tried]) -> Self {
        let errors = || tried.iter().map(|one| one.error);
        let tuned: Vec<&Tried> = tried.iter().filter(|o| o.verdict == Verdict::Tuned).collect();
        Self {
            cell,
            covered: share(&tuned, |o| o.holds),
            called_poor: share(tried, |o| o.verdict == Verdict::PoorFit),
            unanswered: share(tried, |o| matches!(o.verdict, Verdict::Rejected | Verdict::NotIdentifiable)),
            mean_error: mean(errors()),
            median_error: median(errors()).unwrap_or(f64::NAN),
        }
    }

    fn row(&self) -> Vec<String> {
        let mut row = self.cell.labels().to_vec();
        row.extend([self.covered, self.called_poor, self.unanswered].map(percent));
        row.extend([self.mean_error, self.median_error].map(|error| format!("{error:.5}")));
        row
    }

    fn json(&self) -> Value {
        let mut found = self.cell.json();
        found["covered"] = json!(self.covered);
        found["called_poor"] = json!(self.called_poor);
        found["unanswered"] = json!(self.unanswered);
        found["mean_error"] = json!(self.mean_error);
        found["median_error"] = json!(self.median_error);
        found
    }
}
