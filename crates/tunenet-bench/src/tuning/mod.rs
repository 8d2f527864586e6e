//! `tunenet bench tuning`: how near, after how many rollouts, compared with other uses of the rollouts.
//!
//! ```text
//! targets (closed_form) → measure (ours, rivals | likelihood) → results → write
//! ```
//!
//! Every finished cell is kept by [`resume`](super::resume).

mod any_drop;
pub(super) mod closed_form;
mod cross;
mod general;
mod information;
mod likelihood;
mod measure;
pub(super) mod ours;
mod results;
pub(super) mod rivals;
pub(super) mod rows;
pub(super) mod targets;
mod write;

pub(super) use self::rivals::apex;

use anyhow::Result;
use indicatif::ProgressBar;
use rayon::prelude::*;
use serde_json::json;
use tunenet_core::network::{Model, Preset};

use self::measure::{BenchTuner, Rival, TuningAccuracy};
use self::ours::Seconds;
use self::results::{MethodErrors, TuningResults, TuningTable};
use self::rivals::Stored;
use self::rows::{BUDGETS, Goal, Limit, Statistic};
use self::targets::{DropTarget, Simulation};
use super::resume::{Store, program};
use crate::args::{BenchTuning, Measured, TuningRow};
use crate::goals::MAKING_LIMIT_S;
use tunenet_cli::exit_status::Exit;
use tunenet_cli::view::answer;
use tunenet_cli::view::json::print_json;
use tunenet_cli::view::text::{progress, stage};

/// Trainings of each preset.
const TRAININGS: u64 = 3;
/// Targets of a row, and of a quick one.
const TARGETS: u64 = 1000;
const QUICK_TARGETS: u64 = 200;

pub fn run(options: &BenchTuning) -> Result<Exit> {
    let rows: Vec<TuningRow> =
        TuningRow::ALL.into_iter().filter(|r| options.only.is_empty() || options.only.contains(r)).collect();
    let targets = options.targets.unwrap_or(if options.quick { QUICK_TARGETS } else { TARGETS });
    let seed = options.common.seed;
    let trainings: Vec<u64> = (0..if options.quick { 1 } else { TRAININGS }).map(|i| seed * TRAININGS + i).collect();
    let key = json!({ "program": program()?, "seed": seed, "targets": targets, "quick": options.quick });
    let store = Store::open(&options.out, key, &options.sharing)?;

    let per_row = 2 * trainings.len() as u64 + 4;
    let in_row = |row: &TuningRow| match row {
        TuningRow::Cross => 4 * per_row,
        TuningRow::General => general::SETS.len() as u64,
        _ => per_row,
    };
    // The built-in network needs no training here.
    let trained: &[u64] = if rows.iter().all(|r| *r == TuningRow::General) { &[] } else { &trainings };
    let bar = progress(rows.iter().map(in_row).sum::<u64>() + 2 * trained.len() as u64, "tuning");
    let simulation = Simulation::new()?;
    let models = Models::make(&store, trained, options.quick, &bar)?;
    let stored = Stored::new(&simulation)?;
    let bench = Bench { simulation: &simulation, store: &store, models: &models, stored: &stored, bar: &bar };

    let (mut tables, mut general, mut warnings) = (Vec::new(), Vec::new(), Vec::new());
    for row in rows {
        if row == TuningRow::General {
            for set in general::SETS {
                let make = || general::table(set, seed, targets);
                general.extend(store.piece(&format!("general-{}", set.0), make)?);
                bar.inc(1);
            }
            continue;
        }
        if row != TuningRow::Cross {
            tables.extend(bench.row(row, seed, targets)?);
            continue;
        }
        match cross::folder() {
            Some(folder) => tables.extend(bench.cross(&folder)?),
            None => warnings.push(format!("cross, since {} names no folder", cross::FOLDER)),
        }
    }
    bar.finish_and_clear();
    if let Some(exit) = store.finished(Measured::Tuning(options.clone()), options.common.json)? {
        return Ok(exit);
    }
    let results = TuningResults {
        schema: "tunenet.bench.tuning/1",
        command: command(options, targets),
        version: env!("CARGO_PKG_VERSION"),
        seed,
        targets,
        quick: options.quick,
        trainings,
        rollouts: BUDGETS.to_vec(),
        rows: tables,
        general,
        making: models.making,
        making_limit_s: MAKING_LIMIT_S,
        warnings,
    };
    write::all(&options.out, &results)?;
    answer::text(options.common.json, &write::markdown(&results))?;
    stage("wrote", &options.out.join("tuning.md").display().to_string());
    if options.common.json {
        print_json(&serde_json::to_value(&results)?)?;
    }
    Ok(Exit::Done)
}

/// The command that makes these results again.
fn command(options: &BenchTuning, targets: u64) -> String {
    let only = match &options.only[..] {
        [] => String::new(),
        rows => format!(" --only {}", rows.iter().map(|r| r.name()).collect::<Vec<_>>().join(" ")),
    };
    let quick = if options.quick { " --quick" } else { "" };
    format!("tunenet bench tuning --targets {targets}{quick} --seed {}{only}", options.common.seed)
}

/// The trained networks.
struct Models {
    /// By preset, `default` first, and training seed.
    all: Vec<(&'static str, u64, Model)>,
    making: Option<Seconds>,
}

impl Models {
    fn make(store: &Store, trainings: &[u64], quick: bool, bar: &ProgressBar) -> Result<Self> {
        let (default, paper) = (Preset::default(), Preset::paper());
        let make = |(name, preset, seed): (&'static str, &Preset, u64)| {
            let (model, seconds) = ours::trained(store, preset, seed, quick)?;
            bar.inc(1);
            Ok(((name, seed, model), seconds))
        };
        let each = |name, preset| trainings.iter().map(move |seed| (name, preset, *seed));
        let mut jobs: Vec<_> = each("default", &default).chain(each("paper", &paper)).collect();
        if jobs.is_empty() {
            return Ok(Self { all: Vec::new(), making: None });
        }
        // The first alone, because its time is stated.
        let first = make(jobs.remove(0))?;
        let rest: Vec<_> = jobs.into_par_iter().map(make).collect::<Result<_>>()?;
        let making = (!quick).then_some(first.1);
        Ok(Self { all: std::iter::once(first).chain(rest).map(|(model, _)| model).collect(), making })
    }

    fn with_preset<'a>(&'a self, preset: &'static str) -> impl Iterator<Item = (u64, &'a Model)> + 'a {
        self.all.iter().filter(move |m| m.0 == preset).map(|m| (m.1, &m.2))
    }
}

/// Everything that a cell needs.
struct Bench<'a> {
    simulation: &'a Simulation,
    store: &'a Store,
    models: &'a Models,
    stored: &'a Stored,
    bar: &'a ProgressBar,
}

impl Bench<'_> {
    fn row(&self, row: TuningRow, seed: u64, count: u64) -> Result<Option<TuningTable>> {
        let Some(conditions) = row.conditions() else { return Ok(None) };
        let draw = |number| self.simulation.target(conditions, seed, row as u64, number);
        let targets: Vec<DropTarget> = (0..count).into_par_iter().map(draw).collect::<Result<_>>()?;
        let methods = self.methods(row.name(), |tuner| {
            Ok(measure::accuracy(&measure::courses(self.simulation, tuner, &targets)?, &targets))
        })?;
        let fit = || Ok(measure::reference(self.simulation, conditions, &targets));
        let reference = self.store.piece(&format!("{}-likelihood", row.name()), fit)?;
        self.bar.inc(1);
        if self.store.sharded() {
            return Ok(None);
        }
        let goals = row.goals().iter().filter_map(|g| results::hold(g, &methods, reference.as_ref())).collect();
        Ok(Some(TuningTable {
            row: row.name().into(),
            unit: "error of restitution",
            targets: targets.len(),
            noise_m: Some(conditions.noise_m),
            reference,
            methods,
            goals,
            note: None,
        }))
    }

    fn cross(&self, folder: &std::path::Path) -> Result<Vec<TuningTable>> {
        let mut tables = Vec::new();
        for (set, range, rival_cm) in cross::SETS {
            let targets = cross::targets(self.simulation, &folder.join(set), range)?;
            let name = format!("cross-{set}");
            let methods = self.methods(&name, |tuner| {
                measure::distances_cm(self.simulation, &measure::courses(self.simulation, tuner, &targets)?, &targets)
            })?;
            self.bar.inc(1);
            if self.store.sharded() {
                continue;
            }
            let goal = Goal { rollouts: 5, statistic: Statistic::Mean, limit: Limit::Absolute(rival_cm) };
            let goals = results::hold(&goal, &methods, None).into_iter().collect();
            let unit = "mean distance in height, cm";
            let note = set.starts_with("pybullet").then_some(cross::OTHER_LAWS);
            let targets = targets.len();
            tables.push(TuningTable { row: name, unit, targets, noise_m: None, reference: None, methods, goals, note });
        }
        Ok(tables)
    }

    /// All ways of tuning, `default` first; of a shard what it made of them.
    fn methods(&self, row: &str, measure: impl Fn(&BenchTuner) -> Result<TuningAccuracy>) -> Result<Vec<MethodErrors>> {
        let mut methods = Vec::new();
        for preset in ["default", "paper"] {
            let mut runs = Vec::new();
            for (seed, model) in self.models.with_preset(preset) {
                let run = || measure(&BenchTuner::Network(model));
                runs.extend(self.store.piece(&format!("{row}-{preset}-{seed}"), run)?);
                self.bar.inc(1);
            }
            if self.store.sharded() {
                continue;
            }
            let title = format!("preset `{preset}`, {} trainings", runs.len());
            methods.push(MethodErrors::new(preset, title, &runs));
        }
        for rival in Rival::ALL {
            let run = || measure(&BenchTuner::Rival(rival, self.stored));
            let accuracy = self.store.piece(&format!("{row}-{}", rival.name()), run)?;
            methods.extend(accuracy.map(|accuracy| MethodErrors::new(rival.name(), rival.title().into(), &[accuracy])));
            self.bar.inc(1);
        }
        Ok(methods)
    }
}
