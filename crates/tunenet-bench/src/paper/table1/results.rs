//! What was measured, and how it is written down.

use std::fmt::Write;
use std::path::Path;

use anyhow::Result;
use serde_json::{Map, Value, json};
use tunenet_core::statistics::mean;

use crate::goals::{PAYLOAD_BOUNDS, PAYLOAD_RISE_KG, met};
use crate::output::{file_of, mean_and_sd, write_all};

use super::sets::{DataCost, JudgedSet};
use super::tuners::{Table1Title, Training};
use super::{NOISE_NM, ROLLOUTS};

/// Mean absolute value of a normal number with standard deviation 1: √(2/π).
const MEAN_OF_NORMAL: f64 = 0.797_884_560_802_865_4;
/// Errors below are rounding, and no better than one another, kg.
const ROUNDING_KG: f64 = 1e-9;

/// One row on one set.
#[derive(Debug, Clone)]
pub struct Table1Cell {
    pub set: JudgedSet,
    pub noise_nm: f64,
    /// Seed after seed, case after case: how far off it is after each rollout, kg.
    pub seeds: Vec<Vec<Vec<f64>>>,
}

/// The mean over cases after each rollout, kg.
fn by_rollout(cases: &[Vec<f64>]) -> Vec<f64> {
    let count = cases.first().map_or(0, Vec::len);
    (0..count).map(|k| mean(cases.iter().map(|e| e[k]))).collect()
}

impl Table1Cell {
    /// The mean over all cases of all seeds after each rollout, kg.
    fn by_rollout(&self) -> Vec<f64> {
        by_rollout(&self.seeds.concat())
    }

    /// The mean after the last rollout and its spread over the seeds, kg.
    fn mae_kg(&self) -> (f64, f64) {
        let last = |each: Vec<f64>| each.last().copied().unwrap_or(f64::NAN);
        // Every seed has as many cases, so that the mean of their means is that of all.
        mean_and_sd(&self.seeds.iter().map(|s| last(by_rollout(s))).collect::<Vec<_>>())
    }
}

/// One way of tuning.
#[derive(Debug, Clone)]
pub struct Table1Row {
    pub title: Table1Title,
    pub cells: Vec<Table1Cell>,
}

impl Table1Row {
    pub fn new(title: Table1Title) -> Self {
        Self { title, cells: Vec::new() }
    }

    /// Adds the errors of one seed.
    pub fn add(&mut self, set: JudgedSet, noise_nm: f64, errors: Vec<Vec<f64>>) {
        match self.cells.iter_mut().find(|c| c.set == set && c.noise_nm == noise_nm) {
            Some(cell) => cell.seeds.push(errors),
            None => self.cells.push(Table1Cell { set, noise_nm, seeds: vec![errors] }),
        }
    }

    fn cell(&self, set: JudgedSet, noise_nm: f64) -> Option<&Table1Cell> {
        self.cells.iter().find(|c| c.set == set && c.noise_nm == noise_nm)
    }

    fn mae_kg(&self, set: JudgedSet, noise_nm: f64) -> Option<f64> {
        self.cell(set, noise_nm).map(|c| c.mae_kg().0)
    }

    fn spread_kg(&self, set: JudgedSet, noise_nm: f64) -> Option<f64> {
        self.cell(set, noise_nm).map(|c| c.mae_kg().1)
    }
}

/// The least standard deviation that noise allows, over the cases of a set.
#[derive(Debug, Clone)]
pub struct Bound {
    pub set: JudgedSet,
    /// Of every case, kg.
    pub sd_kg: Vec<f64>,
}

impl Bound {
    pub fn new(set: JudgedSet) -> Self {
        Self { set, sd_kg: Vec::new() }
    }

    /// The mean error of a normal estimate that reaches it, kg.
    fn mae_kg(&self) -> f64 {
        MEAN_OF_NORMAL * mean(self.sd_kg.iter().copied())
    }
}

/// The whole table.
#[derive(Debug, Clone)]
pub struct Table1Results {
    pub seed: u64,
    pub seeds: u64,
    /// Of one seed.
    pub pairs: (u64, u64),
    pub quick: bool,
    pub rows: Vec<Table1Row>,
    pub bounds: [Bound; 2],
    /// Seed by seed.
    pub data: Vec<DataCost>,
    pub training: Vec<Training>,
}

impl Table1Results {
    /// The least error of a column, kg.
    fn least(&self, set: JudgedSet, noise_nm: f64) -> Option<f64> {
        self.rows.iter().filter_map(|row| row.mae_kg(set, noise_nm)).min_by(f64::total_cmp)
    }

    fn bound(&self, set: JudgedSet) -> f64 {
        self.bounds.iter().find(|b| b.set == set).map_or(f64::NAN, Bound::mae_kg)
    }

    /// Rollouts of all data sets, and what they took, s.
    fn data_cost(&self) -> (u64, f64) {
        (self.data.iter().map(|c| c.rollouts).sum(), self.data.iter().map(|c| c.seconds).sum())
    }

    /// What one training took, the mean over the seeds.
    fn mean_training(&self) -> Training {
        let mean = |of: fn(&Training) -> f64| mean(self.training.iter().map(of));
        let epochs = self.training.first().map_or(0, |t| t.epochs);
        Training { epochs, seconds: mean(|t| t.seconds), default_seconds: mean(|t| t.default_seconds) }
    }

    /// Whether a row reaches what is aimed at, where something is.
    fn met(&self, row: &Table1Row) -> Option<bool> {
        let (validation, test) = row.title.goal?;
        let within = |set, most| row.mae_kg(set, 0.0).is_some_and(|mae| mae <= most);
        let efficient = |set| row.mae_kg(set, NOISE_NM).is_some_and(|mae| mae <= PAYLOAD_BOUNDS * self.bound(set));
        // No later rollout may make it worse.
        let steady = |cell: &Table1Cell| cell.by_rollout().windows(2).all(|k| k[1] <= k[0] + PAYLOAD_RISE_KG);
        let sets = [JudgedSet::Validation, JudgedSet::Test];
        Some(
            within(sets[0], validation)
                && within(sets[1], test)
                && sets.into_iter().all(efficient)
                && row.cells.iter().all(steady),
        )
    }
}

pub fn as_json(results: &Table1Results) -> Value {
    let row = |row: &Table1Row| {
        let of = |set, noise| row.cell(set, noise).map(Table1Cell::by_rollout);
        let value = json!({
            "validation_mae_kg": row.mae_kg(JudgedSet::Validation, 0.0), "test_mae_kg": row.mae_kg(JudgedSet::Test, 0.0),
            "noisy_validation_mae_kg": row.mae_kg(JudgedSet::Validation, NOISE_NM),
            "noisy_test_mae_kg": row.mae_kg(JudgedSet::Test, NOISE_NM),
            "validation_by_rollout_kg": of(JudgedSet::Validation, 0.0), "test_by_rollout_kg": of(JudgedSet::Test, 0.0),
            "noisy_validation_by_rollout_kg": of(JudgedSet::Validation, NOISE_NM),
            "noisy_test_by_rollout_kg": of(JudgedSet::Test, NOISE_NM),
            "validation_spread_kg": row.spread_kg(JudgedSet::Validation, 0.0), "test_spread_kg": row.spread_kg(JudgedSet::Test, 0.0),
            "noisy_validation_spread_kg": row.spread_kg(JudgedSet::Validation, NOISE_NM),
            "noisy_test_spread_kg": row.spread_kg(JudgedSet::Test, NOISE_NM),
            "published_validation_kg": row.title.published.map(|p| p.0),
            "published_test_kg": row.title.published.map(|p| p.1), "goal_met": results.met(row),
        });
        (row.title.key.to_owned(), value)
    };
    let mut all: Map<String, Value> = results.rows.iter().map(row).collect();
    all.insert("noise_nm".into(), json!(NOISE_NM));
    let bound = json!({ "validation_mae_kg": results.bound(JudgedSet::Validation), "test_mae_kg": results.bound(JudgedSet::Test) });
    all.insert("cramer_rao".into(), bound);
    all.insert("pairs".into(), json!({ "training": results.pairs.0, "judged": results.pairs.1 }));
    all.insert("seeds".into(), json!(results.seeds));
    let (rollouts, data_s) = results.data_cost();
    all.insert("data".into(), json!({ "rollouts": rollouts, "seconds": data_s }));
    let training = results.mean_training();
    all.insert(
        "training".into(),
        json!({
            "epochs": training.epochs, "seconds": training.seconds, "default_seconds": training.default_seconds,
        }),
    );
    all.into()
}

/// The table for users. Writing to a string cannot fail, so its results are dropped.
pub fn markdown(results: &Table1Results) -> String {
    let mut out = String::new();
    let quick = if results.quick { " --quick" } else { "" };
    let _ = writeln!(out, "# Table 1: error of the tuned payload, kg\n");
    let _ = writeln!(out, "    tunenet bench paper --only table1{quick} --seed {}\n", results.seed);
    let (training, judged) = results.pairs;
    let _ = writeln!(
        out,
        "{}: {training} pairs of 0 to 1 kg to train on (preset `default`: of 0 to 2 kg), {judged} to validate, {judged} to test, \
         whose targets are 1 kg heavier, and trainings of its own. The mean of |Δm| over all after \
         {ROLLOUTS} rollouts on a target (fewer where nothing changes any more), ± its spread over the seeds. Noise is white, \
         {NOISE_NM} N·m on every torque of the target, at 240 Hz. The least error of a column is bold, rounding apart.\n",
        if results.seeds == 1 { "One seed".into() } else { format!("{} seeds, each with its own", results.seeds) }
    );
    if results.quick {
        let _ = writeln!(out, "Quick: trainings of a quarter of the length; the figures are indicative only.\n");
    }
    let _ = writeln!(out, "| tuned by | validation | test | validation, noise | test, noise | published | goal |");
    let _ = writeln!(out, "|---|---|---|---|---|---|---|");
    for row in &results.rows {
        let of = |set, noise| {
            let Some((mean, spread)) = row.cell(set, noise).map(Table1Cell::mae_kg) else { return String::new() };
            let text = match results.seeds {
                1 => figures(mean),
                _ => format!("{} ± {}", figures(mean), figures(spread)),
            };
            if results.least(set, noise).is_some_and(|least| mean <= 1.01 * least + ROUNDING_KG) {
                format!("**{text}**")
            } else {
                text
            }
        };
        let published = row.title.published.map_or(String::new(), |(v, t)| format!("{v}, {t}"));
        let goal = match (row.title.goal, results.met(row)) {
            (Some((v, t)), Some(is_met)) => {
                format!("{v}, {t}, {PAYLOAD_BOUNDS} × bound: {}", met(is_met))
            }
            _ => String::new(),
        };
        let _ = writeln!(
            out,
            "| {} | {} | {} | {} | {} | {published} | {goal} |",
            row.title.words,
            of(JudgedSet::Validation, 0.0),
            of(JudgedSet::Test, 0.0),
            of(JudgedSet::Validation, NOISE_NM),
            of(JudgedSet::Test, NOISE_NM)
        );
    }
    let bound = |set| figures(results.bound(set));
    let _ = writeln!(
        out,
        "| Cramér–Rao bound (its mean \\|Δm\\|) | | | {} | {} | | |\n",
        bound(JudgedSet::Validation),
        bound(JudgedSet::Test)
    );
    let _ = writeln!(out, "After each rollout:\n\n| tuned by | set | {} |", heads());
    let _ = writeln!(out, "|---|---|{}", "---|".repeat(ROLLOUTS));
    for row in results.rows.iter().filter(|r| r.cells.iter().any(|c| c.by_rollout().len() > 1)) {
        for cell in &row.cells {
            let each: Vec<String> = cell.by_rollout().iter().map(|v| figures(*v)).collect();
            let noise = if cell.noise_nm > 0.0 { ", noise" } else { "" };
            let blank = " |".repeat(ROLLOUTS - each.len());
            let _ = writeln!(out, "| {} | {}{noise} | {} |{blank}", row.title.words, cell.set.name(), each.join(" | "));
        }
    }
    let (rollouts, data_s) = results.data_cost();
    let Training { epochs, seconds, default_seconds } = results.mean_training();
    let _ = writeln!(
        out,
        "\n{rollouts} rollouts of 5 s in {data_s:.1} s; one preset `paper`, {epochs} epochs, trained in {seconds:.1} s, one preset \
         `default` in {default_seconds:.1} s, three trainings at a time."
    );
    out
}

fn heads() -> String {
    (1..=ROLLOUTS).map(|k| format!("K = {k}")).collect::<Vec<_>>().join(" | ")
}

/// Three figures, in powers of ten where there are many zeros.
fn figures(value: f64) -> String {
    if value != 0.0 && value.abs() < 1e-3 { format!("{value:.1e}") } else { format!("{value:.4}") }
}

/// Writes `table1.md`, `table1.csv` and `table1.json`; none is ever half written.
pub fn write(folder: &Path, results: &Table1Results) -> Result<()> {
    let mut csv = "row,set,noise_nm,seed,rollout,mae_kg\n".to_owned();
    for row in &results.rows {
        for cell in &row.cells {
            for (seed, cases) in cell.seeds.iter().enumerate() {
                for (k, mae) in by_rollout(cases).iter().enumerate() {
                    let (key, set, noise) = (row.title.key, cell.set.name(), cell.noise_nm);
                    let _ = writeln!(csv, "{key},{set},{noise},{seed},{},{mae}", k + 1);
                }
            }
        }
    }
    write_all(
        folder,
        [("table1.md", markdown(results)), ("table1.csv", csv), ("table1.json", file_of(&as_json(results)))],
    )
}
