//! What was measured, and how it is written down.

use std::fmt::Write;
use std::path::Path;

use anyhow::Result;
use serde_json::{Map, Value, json};
use tunenet_core::observation::recording::write_atomically;

use super::sets::{Cost, Set};
use super::tuners::{Title, Training};
use super::{ITERATIONS, NOISE_NM};

/// Mean absolute value of a normal number with standard deviation 1: √(2/π).
const MEAN_OF_NORMAL: f64 = 0.797_884_560_802_865_4;
/// How much the mean error under noise may exceed the bound's.
const EFFICIENT: f64 = 1.15;

/// One row on one set: how far off each case is after each iteration, kg.
#[derive(Debug, Clone)]
pub struct Cell {
    pub set: Set,
    pub noise_nm: f64,
    pub errors: Vec<Vec<f64>>,
}

impl Cell {
    /// The mean over the cases after each iteration, kg.
    fn by_iteration(&self) -> Vec<f64> {
        let count = self.errors.first().map_or(0, Vec::len);
        (0..count).map(|k| self.errors.iter().map(|e| e[k]).sum::<f64>() / self.errors.len() as f64).collect()
    }

    /// The mean after the last iteration, kg.
    fn mae_kg(&self) -> f64 {
        self.by_iteration().last().copied().unwrap_or(f64::NAN)
    }
}

/// One way of tuning.
#[derive(Debug, Clone)]
pub struct Row {
    pub title: Title,
    pub cells: Vec<Cell>,
}

impl Row {
    fn cell(&self, set: Set, noise_nm: f64) -> Option<&Cell> {
        self.cells.iter().find(|c| c.set == set && c.noise_nm == noise_nm)
    }

    fn mae_kg(&self, set: Set, noise_nm: f64) -> Option<f64> {
        self.cell(set, noise_nm).map(Cell::mae_kg)
    }
}

/// The least standard deviation that noise allows, over the cases of a set, kg.
#[derive(Debug, Clone, Copy)]
pub struct Bound {
    pub set: Set,
    pub sd_kg: f64,
}

impl Bound {
    pub fn new(set: Set, each: &[f64]) -> Self {
        Self { set, sd_kg: each.iter().sum::<f64>() / each.len().max(1) as f64 }
    }

    /// The mean error of a normal estimate that reaches it, kg.
    fn mae_kg(self) -> f64 {
        MEAN_OF_NORMAL * self.sd_kg
    }
}

/// The whole table.
#[derive(Debug, Clone)]
pub struct Results {
    pub seed: u64,
    pub pairs: (u64, u64),
    pub quick: bool,
    pub rows: Vec<Row>,
    pub bounds: Vec<Bound>,
    pub data: Cost,
    pub training: Training,
}

impl Results {
    fn bound(&self, set: Set) -> f64 {
        self.bounds.iter().find(|b| b.set == set).map_or(f64::NAN, |b| b.mae_kg())
    }

    /// Whether a row reaches what is aimed at, where something is.
    fn met(&self, row: &Row) -> Option<bool> {
        let (validation, test) = row.title.goal?;
        let within = |set, most| row.mae_kg(set, 0.0).is_some_and(|mae| mae <= most);
        let efficient = |set| row.mae_kg(set, NOISE_NM).is_some_and(|mae| mae <= EFFICIENT * self.bound(set));
        // No later iteration may be worse than the first.
        let steady = |cell: &Cell| cell.by_iteration().windows(2).all(|k| k[1] <= k[0] + 1e-3);
        let sets = [Set::Validation, Set::Test];
        Some(
            within(sets[0], validation)
                && within(sets[1], test)
                && sets.into_iter().all(efficient)
                && row.cells.iter().all(steady),
        )
    }
}

pub fn as_json(results: &Results) -> Value {
    let row = |row: &Row| {
        let of = |set, noise| row.cell(set, noise).map(Cell::by_iteration);
        let value = json!({
            "validation_mae_kg": row.mae_kg(Set::Validation, 0.0), "test_mae_kg": row.mae_kg(Set::Test, 0.0),
            "noisy_validation_mae_kg": row.mae_kg(Set::Validation, NOISE_NM),
            "noisy_test_mae_kg": row.mae_kg(Set::Test, NOISE_NM),
            "validation_by_iteration_kg": of(Set::Validation, 0.0), "test_by_iteration_kg": of(Set::Test, 0.0),
            "noisy_validation_by_iteration_kg": of(Set::Validation, NOISE_NM),
            "noisy_test_by_iteration_kg": of(Set::Test, NOISE_NM),
            "published_validation_kg": row.title.published.map(|p| p.0),
            "published_test_kg": row.title.published.map(|p| p.1), "goal_met": results.met(row),
        });
        (row.title.key.to_owned(), value)
    };
    let mut all: Map<String, Value> = results.rows.iter().map(row).collect();
    all.insert("noise_nm".into(), json!(NOISE_NM));
    let bound = json!({ "validation_mae_kg": results.bound(Set::Validation), "test_mae_kg": results.bound(Set::Test) });
    all.insert("cramer_rao".into(), bound);
    all.insert("pairs".into(), json!({ "training": results.pairs.0, "judged": results.pairs.1 }));
    all.insert("data".into(), json!({ "rollouts": results.data.rollouts, "seconds": results.data.seconds }));
    let training = &results.training;
    all.insert(
        "training".into(),
        json!({
            "epochs": training.epochs, "seconds": training.seconds, "default_seconds": training.default_seconds,
        }),
    );
    all.into()
}

/// The table for people. Writing to a string cannot fail, so its results are dropped.
pub fn markdown(results: &Results) -> String {
    let mut out = String::new();
    let quick = if results.quick { " --quick" } else { "" };
    let _ = writeln!(out, "# Table 1: error of the tuned payload, kg\n");
    let _ = writeln!(out, "    tunenet bench paper --only table1{quick} --seed {}\n", results.seed);
    let (training, judged) = results.pairs;
    let _ = writeln!(
        out,
        "{training} pairs of 0 to 1 kg to train on (preset `default`: of 0 to 2 kg), {judged} to validate, {judged} to test, whose \
         targets are 1 kg heavier. The mean of |Δm| after the last of {ITERATIONS} iterations (3 of linear least squares and \
         Gauss–Newton). Noise is white, {NOISE_NM} N·m on every torque of the target, at 240 Hz.\n"
    );
    if results.quick {
        let _ = writeln!(out, "Quick: trainings of a quarter of the length; the figures are indicative only.\n");
    }
    let _ = writeln!(out, "| tuned by | validation | test | validation, noise | test, noise | published | goal |");
    let _ = writeln!(out, "|---|---|---|---|---|---|---|");
    let number = |value: Option<f64>| value.map_or(String::new(), figures);
    for row in &results.rows {
        let of = |set, noise| number(row.mae_kg(set, noise));
        let published = row.title.published.map_or(String::new(), |(v, t)| format!("{v}, {t}"));
        let goal = match (row.title.goal, results.met(row)) {
            (Some((v, t)), Some(met)) => {
                format!("{v}, {t}, {EFFICIENT} × bound: {}", if met { "met" } else { "**missed**" })
            }
            _ => String::new(),
        };
        let _ = writeln!(
            out,
            "| {} | {} | {} | {} | {} | {published} | {goal} |",
            row.title.words,
            of(Set::Validation, 0.0),
            of(Set::Test, 0.0),
            of(Set::Validation, NOISE_NM),
            of(Set::Test, NOISE_NM)
        );
    }
    let bound = |set| figures(results.bound(set));
    let _ = writeln!(
        out,
        "| Cramér–Rao bound (its mean \\|Δm\\|) | | | {} | {} | | |\n",
        bound(Set::Validation),
        bound(Set::Test)
    );
    let _ = writeln!(out, "By iteration:\n\n| tuned by | set | {} |", heads());
    let _ = writeln!(out, "|---|---|{}", "---|".repeat(ITERATIONS));
    for row in results.rows.iter().filter(|r| r.cells.iter().any(|c| c.by_iteration().len() > 1)) {
        for cell in &row.cells {
            let each: Vec<String> = cell.by_iteration().iter().map(|v| figures(*v)).collect();
            let noise = if cell.noise_nm > 0.0 { ", noise" } else { "" };
            let blank = " |".repeat(ITERATIONS - each.len());
            let _ = writeln!(out, "| {} | {}{noise} | {} |{blank}", row.title.words, cell.set.name(), each.join(" | "));
        }
    }
    let Training { epochs, seconds, default_seconds } = results.training;
    let _ = writeln!(
        out,
        "\n{} rollouts of 5 s in {:.1} s; preset `paper`, {epochs} epochs, trained in {seconds:.1} s; preset `default` in \
         {default_seconds:.1} s.",
        results.data.rollouts, results.data.seconds
    );
    out
}

fn heads() -> String {
    (1..=ITERATIONS).map(|k| format!("K = {k}")).collect::<Vec<_>>().join(" | ")
}

/// Three figures, in powers of ten where there are many zeros.
fn figures(value: f64) -> String {
    if value != 0.0 && value.abs() < 1e-3 { format!("{value:.1e}") } else { format!("{value:.4}") }
}

/// Writes `table1.md`, `table1.csv` and `table1.json`; none is ever half written.
pub fn write(folder: &Path, results: &Results) -> Result<()> {
    let mut csv = "row,set,noise_nm,case,iteration,error_kg\n".to_owned();
    for row in &results.rows {
        for cell in &row.cells {
            for (case, errors) in cell.errors.iter().enumerate() {
                for (k, error) in errors.iter().enumerate() {
                    let (key, set, noise) = (row.title.key, cell.set.name(), cell.noise_nm);
                    let _ = writeln!(csv, "{key},{set},{noise},{case},{},{error}", k + 1);
                }
            }
        }
    }
    let json = format!("{:#}\n", as_json(results));
    for (name, text) in [("table1.md", markdown(results)), ("table1.csv", csv), ("table1.json", json)] {
        write_atomically(folder.join(name), |file| file.write_all(text.as_bytes()))?;
    }
    Ok(())
}
