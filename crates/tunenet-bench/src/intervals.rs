//! `tunenet bench intervals`: how often a 95 % interval holds the truth.
//!
//! Drops come from formulas with white noise on the height, the way `bench tuning` makes its targets; each is tuned to as a
//! person would tune to it, with the height of fall and the surface given or with neither.

use std::path::Path;

use anyhow::Result;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};
use tunenet_core::observation::{Kind, Observation};
use tunenet_core::tune::{Settings, Verdict, tune};
use tunenet_sim::simulation_file::LeftOpen;
use tunenet_sim::{ObservedBall, SimulationFile};

use super::resume::Store;
use super::tuning::closed_form::Drop;
use crate::args::{BenchIntervals, Measured};
use crate::resume::program;
use tunenet_cli::failure::Exit;
use tunenet_cli::view::answer;
use tunenet_cli::view::json::print_json;
use tunenet_cli::view::text::{progress, table};

/// The paper's ball: .5 m, seen at 60 Hz for 400 frames.
const PAPER_BALL: &str = include_str!("../../../assets/ball_easy.toml");
const RADIUS_M: f64 = 0.5;
/// The paper's heights of fall, m.
const FALL_M: std::ops::Range<f64> = 3.5..4.5;
/// Added to the seed, so that no other command draws these drops.
const OWN_SEED: u64 = 0x1A7E_54A1;
const RESTITUTIONS: [(f64, f64); 3] = [(0.0, 0.1), (0.1, 0.9), (0.9, 1.0)];
const NOISES_M: [f64; 3] = [0.005, 0.01, 0.03];
/// Drops that are kept in one piece.
const PIECE: u32 = 50;

/// What one cell of the table found.
struct Cell {
    given: bool,
    restitution: (f64, f64),
    noise_m: f64,
    covered: f64,
    called_poor: f64,
    /// Neither tuned nor a poor fit.
    unanswered: f64,
    mean_error: f64,
    median_error: f64,
}

/// What came of one drop.
#[derive(Debug, Clone, Copy, Serialize, Deserialize)]
struct Tried {
    /// Whether the interval holds the truth.
    holds: bool,
    error: f64,
    verdict: Verdict,
}

pub fn run(options: &BenchIntervals) -> Result<Exit> {
    let seed = options.common.seed;
    // The version alone would not tell a rebuilt program from the one that made a piece.
    let store = Store::open(&options.out, json!({ "program": program()?, "seed": seed }), &options.sharing)?;
    let cells: Vec<(bool, (f64, f64), f64)> = [true, false]
        .into_iter()
        .flat_map(|given| RESTITUTIONS.into_iter().flat_map(move |e| NOISES_M.into_iter().map(move |n| (given, e, n))))
        .collect();
    let bar = progress(cells.len() as u64 * u64::from(options.count()), "drops");
    let mut found = Vec::with_capacity(cells.len());
    for (cell, (given, restitution, noise_m)) in cells.into_iter().enumerate() {
        let mut tried: Vec<Tried> = Vec::with_capacity(options.count() as usize);
        for first in (0..options.count()).step_by(PIECE as usize) {
            let numbers = first..first.saturating_add(PIECE).min(options.count());
            let one = |number| one(seed, number, given, restitution, noise_m);
            let name = format!("intervals-{cell}-from-{first}-to-{}", numbers.end);
            let make = || numbers.clone().into_par_iter().map(one).collect::<Result<Vec<Tried>>>();
            tried.extend(store.piece(&name, make)?.into_iter().flatten());
            bar.inc(numbers.len() as u64);
        }
        if options.sharing.shard.is_none() {
            found.push(Cell::of(given, restitution, noise_m, &tried));
        }
    }
    bar.finish_and_clear();
    if let Some(exit) = store.finished(Measured::Intervals(options.clone()), options.common.json)? {
        return Ok(exit);
    }
    let head =
        ["height, surface", "restitution", "noise", "95 % holds", "poor fit", "no answer", "mean error", "median"];
    let mut rows: Vec<Vec<String>> = vec![head.map(String::from).to_vec()];
    rows.extend(found.iter().map(Cell::row));
    answer::text(options.common.json, &table(&rows))?;
    if options.common.json {
        let cells: Vec<Value> = found.iter().map(Cell::json).collect();
        print_json(&json!({
            "schema": "tunenet.bench.intervals/1", "drops": options.count(), "seed": options.common.seed, "cells": cells,
            "warnings": [],
        }))?;
    }
    Ok(Exit::Done)
}

/// Draws a drop, tunes to it, and holds what was found against the truth.
fn one(seed: u64, number: u32, given: bool, restitution: (f64, f64), noise_m: f64) -> Result<Tried> {
    let mut random = ChaCha8Rng::seed_from_u64(seed.wrapping_add(OWN_SEED));
    random.set_stream(u64::from(number));
    let drop =
        Drop { restitution: random.random_range(restitution.0..restitution.1), fall_m: random.random_range(FALL_M) };
    let mut file = SimulationFile::parse(Path::new("ball_easy.toml"), PAPER_BALL)?;
    if given {
        file.set(&format!("release.height_m={}", drop.fall_m))?;
    } else {
        file.leave_open(&[
            LeftOpen::ReleaseHeight,
            LeftOpen::ReleaseVelocity,
            LeftOpen::ReleaseTime,
            LeftOpen::SurfaceHeight,
        ]);
    }
    let clock = file.record().clock();
    let mut noise = || noise_m * random.sample::<f64, _>(StandardNormal);
    let positions: Vec<[f64; 3]> =
        drop.heights(&clock).into_iter().map(|z| [noise(), noise(), RADIUS_M + z + noise()]).collect();
    let ball = ObservedBall::new(&file, Kind::Positions)?;
    let seen = Observation::positions(clock, &positions)?;
    let outcome = tune(&ball, &[seen], None, &Settings::default())?;
    let (first, truth) = (outcome.parameters.first(), drop.restitution);
    Ok(Tried {
        holds: first.is_some_and(|p| (p.interval95.0..=p.interval95.1).contains(&truth)),
        error: first.map_or(1.0, |p| (p.value - truth).abs()),
        verdict: outcome.verdict,
    })
}

impl Cell {
    fn of(given: bool, restitution: (f64, f64), noise_m: f64, tried: &[Tried]) -> Self {
        let count = tried.len() as f64;
        let share = |is: &dyn Fn(&Tried) -> bool| tried.iter().filter(|o| is(o)).count() as f64 / count;
        let mut errors: Vec<f64> = tried.iter().map(|one| one.error).collect();
        errors.sort_by(f64::total_cmp);
        Self {
            given,
            restitution,
            noise_m,
            covered: share(&|o| o.holds),
            called_poor: share(&|o| o.verdict == Verdict::PoorFit),
            unanswered: share(&|o| matches!(o.verdict, Verdict::Rejected | Verdict::NotIdentifiable)),
            mean_error: errors.iter().sum::<f64>() / count,
            median_error: errors[errors.len() / 2],
        }
    }

    fn row(&self) -> Vec<String> {
        vec![
            if self.given { "given".into() } else { "unknown".into() },
            format!("{} to {}", self.restitution.0, self.restitution.1),
            format!("{} cm", self.noise_m * 100.0),
            format!("{:.1} %", 100.0 * self.covered),
            format!("{:.1} %", 100.0 * self.called_poor),
            format!("{:.1} %", 100.0 * self.unanswered),
            format!("{:.5}", self.mean_error),
            format!("{:.5}", self.median_error),
        ]
    }

    fn json(&self) -> Value {
        json!({
            "given": self.given, "restitution": [self.restitution.0, self.restitution.1], "noise_m": self.noise_m,
            "covered": self.covered, "called_poor": self.called_poor, "unanswered": self.unanswered,
            "mean_error": self.mean_error, "median_error": self.median_error,
        })
    }
}
