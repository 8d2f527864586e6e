//! `tunenet bench preflight`: how much of what may be wrong with a record is found, and how often a good one is blamed.

mod faults;
mod motion;

use std::collections::BTreeMap;
use std::fmt::Write;
use tunenet_ball::findings;

use anyhow::Result;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};
use tunenet_ball::preflight::{Expected, of};
use tunenet_core::observation::Observation;
use tunenet_core::observation::{Check, State};

use super::resume::Store;
use crate::args::{BenchPreflight, Measured};
use crate::resume::program;
use faults::KINDS;
use motion::Record;
use tunenet_cli::exit_status::Exit;
use tunenet_cli::view::answer;
use tunenet_cli::view::json::print_json;
use tunenet_cli::view::text::progress;

/// Added to the seed, so that no other command draws these records.
const OWN_SEED: u64 = 0x9EF1_1647;
/// What has to be reached: of each kind found, of good records rejected.
const GOAL_FOUND: f64 = 0.95;
const GOAL_REJECTED: f64 = 0.01;

/// How good records without and with air fared.
struct Good {
    name: &'static str,
    records: usize,
    rejected: f64,
    /// With at least one notice, gravity's apart where there is air: that is no false one.
    noticed: f64,
    codes: BTreeMap<String, usize>,
}

/// Records that are kept in one piece.
const PIECE: usize = 200;

/// What is said of one good record.
#[derive(Debug, Clone, Serialize, Deserialize)]
struct Said {
    air: bool,
    /// What it is blamed for.
    codes: Vec<String>,
    rejected: bool,
    /// Of something that is not so.
    noticed: bool,
}

impl Said {
    fn of(checks: &[Check], air: bool) -> Self {
        let false_notice = |c: &Check| c.state == State::Noticed && !(air && c.kind == findings::GRAVITY_APPARENT);
        Self {
            air,
            codes: checks.iter().filter(|c| blames(c)).map(|c| c.kind.code().to_owned()).collect(),
            rejected: checks.iter().any(|c| c.state == State::Failed),
            noticed: checks.iter().any(false_notice),
        }
    }
}

pub fn run(options: &BenchPreflight) -> Result<Exit> {
    let (records, seed) = (options.count() as usize, options.common.seed);
    // The version number does not distinguish a rebuilt program from the one that made a piece.
    let store = Store::open(&options.out, json!({ "program": program()?, "seed": seed }), &options.sharing)?;
    let bar = progress((records * (KINDS.len() + 1)) as u64, "records");
    let random = |kind: usize, number: usize| {
        let mut random = ChaCha8Rng::seed_from_u64(seed.wrapping_add(OWN_SEED).wrapping_add(kind as u64));
        random.set_stream(number as u64);
        random
    };
    let said = |number: usize| {
        bar.inc(1);
        let (record, expected, air) = faults::good(&mut random(KINDS.len(), number));
        Ok(Said::of(&checked(record, &expected)?, air))
    };
    let good: Vec<Said> = pieces(&store, "good", records, &said)?;
    let good: Vec<Good> =
        [("good, no air", false), ("good, with air", true)].map(|(name, air)| judge(name, air, &good)).into();
    let mut found = Vec::new();
    for (k, kind) in KINDS.iter().enumerate() {
        let hit = |number: usize| {
            bar.inc(1);
            let (record, expected) = (kind.make)(&mut random(k, number));
            let checks = checked(record, &expected)?;
            Ok(checks.iter().any(|c| kind.found_by.contains(&c.kind) && blames(c)))
        };
        let hits: Vec<bool> = pieces(&store, &format!("fault-{k}"), records, &hit)?;
        found.push(hits.iter().filter(|h| **h).count() as f64 / records as f64);
    }
    bar.finish_and_clear();
    if let Some(exit) = store.finished(Measured::Preflight(options.clone()), options.common.json)? {
        return Ok(exit);
    }
    let met = found.iter().all(|f| *f >= GOAL_FOUND) && good.iter().all(|g| g.rejected <= GOAL_REJECTED);
    answer::text(options.common.json, markdown(records, seed, &good, &found).trim_end())?;
    if options.common.json {
        print_json(&as_json(records, seed, &good, &found, met))?;
    }
    Ok(Exit::Done)
}

/// Records of one kind, each looked at; of a shard those that are its own.
fn pieces<T: Serialize + DeserializeOwned + Send>(
    store: &Store,
    kind: &str,
    records: usize,
    look: &(dyn Fn(usize) -> Result<T> + Sync),
) -> Result<Vec<T>> {
    let mut all = Vec::with_capacity(records);
    for first in (0..records).step_by(PIECE) {
        let numbers = first..(first + PIECE).min(records);
        let name = format!("preflight-{kind}-from-{first}-to-{}", numbers.end);
        let make = || numbers.into_par_iter().map(look).collect::<Result<Vec<T>>>();
        all.extend(store.piece(&name, make)?.into_iter().flatten());
    }
    Ok(all)
}

fn blames(check: &Check) -> bool {
    matches!(check.state, State::Noticed | State::Failed)
}

fn checked(record: Record, expected: &Expected) -> Result<Vec<Check>> {
    Ok(of(&Observation::positions(record.clock, &record.position_m)?, expected))
}

fn judge(name: &'static str, air: bool, all: &[Said]) -> Good {
    let mine: Vec<&Said> = all.iter().filter(|said| said.air == air).collect();
    let share =
        |is: &dyn Fn(&Said) -> bool| mine.iter().filter(|said| is(said)).count() as f64 / mine.len().max(1) as f64;
    let mut codes = BTreeMap::new();
    for code in mine.iter().flat_map(|said| &said.codes) {
        *codes.entry(code.clone()).or_insert(0) += 1;
    }
    Good {
        name,
        records: mine.len(),
        rejected: share(&|said| said.rejected),
        noticed: share(&|said| said.noticed),
        codes,
    }
}

fn percent(share: f64) -> String {
    format!("{:.1} %", 100.0 * share)
}

fn markdown(records: usize, seed: u64, good: &[Good], found: &[f64]) -> String {
    let mut text = format!("{records} records of each kind, seed {seed}\n\n| fault | found |\n|---|---:|\n");
    for (kind, found) in KINDS.iter().zip(found) {
        let _ = writeln!(text, "| {} | {} |", kind.name, percent(*found));
    }
    let _ = writeln!(text, "\n| no fault | records | rejected | noticed | codes |\n|---|---:|---:|---:|---|");
    for g in good {
        let codes: Vec<String> = g.codes.iter().map(|(code, count)| format!("`{code}` {count}")).collect();
        let (rejected, noticed) = (percent(g.rejected), percent(g.noticed));
        let _ = writeln!(text, "| {} | {} | {rejected} | {noticed} | {} |", g.name, g.records, codes.join(", "));
    }
    text
}

fn as_json(records: usize, seed: u64, good: &[Good], found: &[f64], met: bool) -> Value {
    let faults = KINDS.iter().zip(found).map(|(k, f)| json!({ "fault": k.name, "codes": k.found_by, "found": f }));
    let good = good.iter().map(|g| {
        json!({ "name": g.name, "records": g.records, "rejected": g.rejected, "noticed": g.noticed, "codes": g.codes })
    });
    json!({
        "schema": "tunenet.bench.preflight/1", "records": records, "seed": seed,
        "faults": faults.collect::<Vec<_>>(), "good": good.collect::<Vec<_>>(),
        "goals": { "found": GOAL_FOUND, "rejected": GOAL_REJECTED, "met": met },
        "warnings": [],
    })
}
