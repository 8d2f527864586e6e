//! What was measured, and how it is written down.

use std::fmt::Write;
use std::path::Path;

use anyhow::Result;
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value, json};
use tunenet_core::statistics::mean;

use crate::goals::met;
use crate::output::{file_of, mean_and_sd, write_all};

use super::super::counted_seeds;
use super::tuners::Table3Title;
use super::video::DEGRADATION;

/// How far off one tuned drop is.
#[derive(Debug, Clone, Copy, Serialize, Deserialize)]
pub struct DropError {
    /// Mean distance in height, cm.
    pub cm: f64,
    /// The same over the mean height, percent.
    pub percent: f64,
    /// Of the restitution; NaN is not written, so nothing stands for none.
    pub restitution: Option<f64>,
}

impl DropError {
    pub fn new(truth_m: &[f64], rolled_m: &[f64], restitution: f64) -> Self {
        let n = truth_m.len() as f64;
        let off = truth_m.iter().zip(rolled_m).map(|(a, b)| (a - b).abs()).sum::<f64>() / n;
        let height = truth_m.iter().map(|z| z.abs()).sum::<f64>() / n;
        Self { cm: 100.0 * off, percent: 100.0 * off / height, restitution: Some(restitution.abs()) }
    }

    /// Of a prediction of 0 m throughout.
    pub fn of_nothing(truth_m: &[f64]) -> Self {
        Self { restitution: None, ..Self::new(truth_m, &vec![0.0; truth_m.len()], 0.0) }
    }
}

/// One way of tuning.
#[derive(Debug, Clone)]
pub struct Table3Row {
    pub key: &'static str,
    pub title: Table3Title,
    /// Seed after seed, drop after drop; nothing where the video was refused.
    pub seeds: Vec<Vec<Option<DropError>>>,
}

/// Means over the drops.
struct Summary {
    cm: f64,
    percent: f64,
    restitution: Option<f64>,
    /// Spread of the mean distance over the seeds, cm.
    spread_cm: f64,
    /// Videos in which no ball, or no fall, was found.
    refused: usize,
}

impl Table3Row {
    pub fn new(title: Table3Title) -> Self {
        Self { key: title.key, title, seeds: Vec::new() }
    }

    fn summary(&self) -> Summary {
        // Of a seed whose videos were all refused there is no mean.
        let mean_of = |of: &dyn Fn(&DropError) -> f64, errors: &[Option<DropError>]| {
            if errors.iter().any(Option::is_some) { mean(errors.iter().flatten().map(of)) } else { f64::NAN }
        };
        let over = |of: &dyn Fn(&DropError) -> f64| {
            mean_and_sd(&self.seeds.iter().map(|s| mean_of(of, s)).collect::<Vec<_>>())
        };
        let (cm, spread_cm) = over(&|e| e.cm);
        let known = self.seeds.iter().flatten().flatten().all(|e| e.restitution.is_some());
        Summary {
            cm,
            percent: over(&|e| e.percent).0,
            restitution: known.then(|| over(&|e| e.restitution.unwrap_or_default()).0),
            spread_cm,
            refused: self.seeds.iter().flatten().filter(|e| e.is_none()).count(),
        }
    }

    /// Whether the goal is met, where there is one; a video that is refused meets none.
    fn met(&self, found: &Summary) -> Option<bool> {
        let (cm, percent, restitution) = self.title.goal?;
        let within = |found: Option<f64>, limit: Option<f64>| match (found, limit) {
            (Some(found), Some(limit)) => found <= limit,
            (_, limit) => limit.is_none(),
        };
        let tuned = found.refused == 0 && found.cm <= cm;
        Some(tuned && within(Some(found.percent), percent) && within(found.restitution, restitution))
    }
}

/// The whole table.
#[derive(Debug, Clone)]
pub struct Table3Results {
    pub seed: u64,
    pub seeds: u64,
    pub drops: u64,
    pub quick: bool,
    pub rows: Vec<Table3Row>,
}

pub fn as_json(results: &Table3Results) -> Value {
    let row = |row: &Table3Row| {
        let found = row.summary();
        let value = json!({
            "cm": found.cm, "percent": found.percent, "restitution": found.restitution, "spread_cm": found.spread_cm, "refused": found.refused,
            "published_cm": row.title.published.map(|p| p.0), "published_percent": row.title.published.and_then(|p| p.1),
            "goal_met": row.met(&found),
        });
        (row.key.to_owned(), value)
    };
    let mut all: Map<String, Value> = results.rows.iter().map(row).collect();
    all.insert("seeds".into(), json!(results.seeds));
    all.insert("drops".into(), json!(results.drops));
    all.into()
}

/// The table for users. Writing to a string cannot fail, so its results are dropped.
pub fn markdown(results: &Table3Results) -> String {
    let mut out = String::new();
    let (noise, exposure, quality) = DEGRADATION;
    let quick = if results.quick { " --quick" } else { "" };
    let _ = writeln!(out, "# Table 3: distance in height of the tuned ball\n");
    let _ = writeln!(out, "    tunenet bench paper --only table3{quick} --seed {}\n", results.seed);
    let _ = writeln!(
        out,
        "{} of {} drops. The drops are a closed form's, rendered at 160 × 120 and tracked; every camera and every \
         training is new with the seed. Percent is the mean of |Δz| over the mean of |z|, run by run. Five rollouts. A \
         degraded video has noise of {noise} on every channel (of 255), a shutter open for {exposure} of the time between \
         frames, and JPEG of quality {quality}. A video in which no ball is found counts as refused, and in no mean. The \
         published rows Neural and VRNN are not here: their figures are not at hand.\n",
        counted_seeds(results.seeds),
        results.drops
    );
    if results.quick {
        let _ = writeln!(out, "Quick: trainings of a quarter of the steps; the figures are indicative only.\n");
    }
    let _ = writeln!(
        out,
        "| tuned to | cm | % | restitution | refused | published | goal |\n|---|---|---|---|---|---|---|"
    );
    for row in &results.rows {
        let found = row.summary();
        let restitution = found.restitution.map_or(String::new(), |e| format!("{e:.4}"));
        let published = row.title.published.map_or(String::new(), |(cm, percent)| {
            let percent = percent.map_or(String::new(), |p| format!(", {p} %"));
            format!("{cm} cm{percent}")
        });
        let goal = match (row.title.goal, row.met(&found)) {
            (Some((cm, percent, _)), Some(is_met)) => {
                let percent = percent.map_or(String::new(), |p| format!(", {p} %"));
                format!("{cm} cm{percent}: {}", met(is_met))
            }
            _ => String::new(),
        };
        let (cm, spread, percent) = (found.cm, found.spread_cm, found.percent);
        let _ = writeln!(
            out,
            "| {} | {cm:.3} ± {spread:.3} | {percent:.3} | {restitution} | {} | {published} | {goal} |",
            row.title.words, found.refused
        );
    }
    out
}

/// Writes `table3.md`, `table3.csv` and `table3.json`; none is ever half written.
pub fn write(folder: &Path, results: &Table3Results) -> Result<()> {
    let mut csv = "row,seed,drop,cm,percent,restitution\n".to_owned();
    for row in &results.rows {
        for (seed, drops) in row.seeds.iter().enumerate() {
            for (i, e) in drops.iter().enumerate().filter_map(|(i, e)| Some((i, e.as_ref()?))) {
                let restitution = e.restitution.map_or(String::new(), |e| e.to_string());
                let _ = writeln!(csv, "{},{seed},{i},{},{},{restitution}", row.key, e.cm, e.percent);
            }
        }
    }
    write_all(
        folder,
        [("table3.md", markdown(results)), ("table3.csv", csv), ("table3.json", file_of(&as_json(results)))],
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_seed_is_one() {
        let text = |seeds| markdown(&Table3Results { seed: 0, seeds, drops: 6, quick: true, rows: Vec::new() });
        assert!(text(1).contains("\n1 seed of 6 drops.") && text(3).contains("\n3 seeds of 6 drops."), "{}", text(1));
    }
}
