//! Who tunes.

use std::path::Path;
use std::time::Instant;

use anyhow::Result;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use tunenet_core::network::{Course, Model, Pair, Preset, Side, TrainOptions, train_on};
use tunenet_core::observation::{Kind, Observation};
use tunenet_core::simulator::{Simulator, rollout};
use tunenet_core::tune::{Loop, Point, walk};
use tunenet_formats::dataset::DatasetReader;
use tunenet_formats::{load_model, save_model, train_file};
use tunenet_sim::ObservedArm;

use super::super::super::resume::Store;
use super::super::super::search::{Search, brent, entropy_search, evolution, gauss_newton, nearest};
use super::linear::Linear;
use super::sets::{Case, Sets};
use super::{NOISE_NM, ROLLOUTS};
use crate::goals::PAYLOAD_KG;

/// Rollouts of those that change no more after two.
const FEW: usize = 5;
/// Masses of stored rollouts, kg: evenly over both sets.
const STORED: u32 = 41;
const STORED_TO_KG: f64 = 2.0;
/// What direct prediction is measured from, kg.
const REFERENCE_KG: f64 = 0.5;
/// Samples per second of the sets to judge by.
const RATE_HZ: f64 = 240.0;

/// A row of the table.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Table1Title {
    pub key: &'static str,
    pub words: &'static str,
    /// What the paper states, kg: validation, test.
    pub published: Option<(f64, f64)>,
    /// Greatest mean error that is aimed at, kg: validation, test.
    pub goal: Option<(f64, f64)>,
    /// Whether it is tried with noise as well.
    pub noisy: bool,
}

const fn row(key: &'static str, words: &'static str) -> Table1Title {
    Table1Title { key, words, published: None, goal: None, noisy: false }
}

pub const ROWS: [Table1Title; 11] = [
    row("mean", "the mean of training"),
    row("max", "the greatest of training"),
    row("direct", "direct prediction, the paper's network"),
    Table1Title { published: Some((0.011, 0.198)), ..row("paper", "preset `paper`") },
    Table1Title { noisy: true, ..row("linear", "linear least squares") },
    Table1Title { noisy: true, ..row("gauss_newton", "Gauss–Newton by finite differences") },
    Table1Title { noisy: true, ..row("nearest", "nearest of 41 stored rollouts, then secant Gauss–Newton") },
    row("brent", "bounded Brent on the squared error"),
    row("cma_es", "CMA-ES in one dimension"),
    row("entropy_search", "greedy entropy search"),
    Table1Title { goal: Some(PAYLOAD_KG), noisy: true, ..row("default", "preset `default`") },
];

/// What a training took.
#[derive(Debug, Clone, Copy, Serialize, Deserialize)]
pub struct Training {
    pub epochs: u64,
    pub seconds: f64,
    pub default_seconds: f64,
}

/// All that learned.
pub struct ArmTuners {
    paper: Model,
    default: Model,
    direct: Model,
    linear: [Linear; 2],
    /// The reference's torques on the clock of training.
    reference: Vec<f64>,
    /// Masses with what would be seen of each.
    stored: Vec<(f64, Vec<f64>)>,
    mean_kg: f64,
    max_kg: f64,
    pub cost: Training,
}

impl ArmTuners {
    pub fn make(store: &Store, sets: &Sets, seed: u64, quick: bool) -> Result<Self> {
        let less = |preset: Preset| if quick { shorter(preset) } else { preset };
        let room = store.room("models")?;
        let path = |name: &str| room.join(format!("arm-{name}-{seed}.safetensors"));
        let learn = |name: &str, preset: Preset, data: &Path| -> Result<(Model, f64)> {
            let seconds = store.keep(&format!("table1-model-{name}-{seed}"), || {
                let began = Instant::now();
                let options = TrainOptions::new(less(preset), seed);
                save_model(&train_file(data, &options, None, &mut |_| true)?, path(name))?;
                Ok(began.elapsed().as_secs_f64())
            })?;
            Ok((load_model(path(name))?, seconds))
        };
        let reader = DatasetReader::open(&sets.training)?;
        let header = reader.header().clone();
        let pairs: Vec<Pair> = reader.collect::<tunenet_formats::Result<_>>()?;
        let reference = rollout(&sets.arm, &sets.parameters(REFERENCE_KG), &[], &header.clock)?;
        let learn_direct = || -> Result<Model> {
            store.keep(&format!("table1-model-direct-{seed}"), || {
                // The same network, whose proposed side never changes: all that it learns is the target's mass.
                let direct = |pair: &Pair| Pair {
                    proposed: reference.clone(),
                    proposed_parameters: sets.parameters(REFERENCE_KG),
                    ..pair.clone()
                };
                let all: Vec<Pair> = pairs.iter().map(direct).collect();
                let options = TrainOptions::new(less(Preset::paper_arm()), seed);
                Ok(save_model(&train_on(&header, &all, &options, &mut |_| true)?, path("direct"))?)
            })?;
            Ok(load_model(path("direct"))?)
        };
        // A training keeps one core busy.
        let ((paper, default), direct) = rayon::join(
            || {
                rayon::join(
                    || learn("paper", Preset::paper_arm(), &sets.training),
                    || learn("default", Preset::arm(), &sets.wide),
                )
            },
            learn_direct,
        );
        let ((paper, seconds), (default, default_seconds)) = (paper?, default?);
        let masses = || pairs.iter().map(|p| p.target_parameters[0]);
        let stored = (0..STORED).into_par_iter().map(|i| {
            let mass = STORED_TO_KG * f64::from(i) / f64::from(STORED - 1);
            Ok((mass, sets.roll(mass)?))
        });
        let epochs = match less(Preset::paper_arm()).course {
            Course::Epochs { epochs } => epochs,
            Course::Remixed { steps, .. } => steps,
        };
        Ok(Self {
            paper,
            default,
            direct: direct?,
            linear: [Linear::learn(&sets.training, 0.0, RATE_HZ)?, Linear::learn(&sets.training, NOISE_NM, RATE_HZ)?],
            reference,
            stored: stored.collect::<Result<_>>()?,
            mean_kg: masses().sum::<f64>() / pairs.len() as f64,
            max_kg: masses().fold(0.0, f64::max),
            cost: Training { epochs, seconds, default_seconds },
        })
    }

    /// How far off the mass is after each rollout, kg; one number where none is spent.
    pub fn errors(&self, key: &str, sets: &Sets, case: &Case) -> Result<Vec<f64>> {
        let off = |mass: f64| (mass - case.target_kg).abs();
        let after = |course: Vec<f64>| Ok(course.into_iter().skip(1).map(off).collect());
        let search = || Search {
            roll: Box::new(|mass| sets.roll(mass)),
            seen: case.seen.seen.values(),
            proposed: case.proposed_kg,
            range: case.range_kg,
            bounds: (0.0, STORED_TO_KG),
            seed: case.seed,
        };
        match key {
            "mean" => Ok(vec![off(self.mean_kg)]),
            "max" => Ok(vec![off(self.max_kg)]),
            "direct" => Ok(vec![off(self.predicted(sets, case)?)]),
            "paper" => {
                // The bounds only keep the mass from falling below 0, which cannot be simulated.
                let how = Loop { iterations: ROLLOUTS, clamp: true, secant: false, best: false, library: false };
                Ok(walked(&self.paper, &sets.unbounded, case, how)?.into_iter().map(off).collect())
            }
            "default" => {
                let how = Loop { iterations: ROLLOUTS, clamp: true, secant: true, best: true, library: true };
                Ok(walked(&self.default, &sets.arm, case, how)?.into_iter().map(off).collect())
            }
            "linear" => {
                let (mut mass, mut errors) = (case.proposed_kg, Vec::new());
                let noisy = usize::from(case.noise_nm > 0.0);
                for _ in 0..FEW {
                    let now = sets.roll(mass)?;
                    let channels = sets.arm.channels().len();
                    mass = (mass + self.linear[noisy].step_kg(&now, case.seen.seen.values(), channels)).max(0.0);
                    errors.push(off(mass));
                }
                Ok(errors)
            }
            "gauss_newton" => after(gauss_newton::search(&search(), FEW)?),
            "nearest" => after(nearest::search(&search(), self.stored.clone(), FEW)?),
            "brent" => after(brent::search(&search(), ROLLOUTS)?),
            "cma_es" => after(evolution::search(&search(), ROLLOUTS, 1)?),
            "entropy_search" => after(entropy_search::search(&search(), ROLLOUTS)?),
            other => anyhow::bail!("`{other}` is no row of this table"),
        }
    }

    fn predicted(&self, sets: &Sets, case: &Case) -> Result<f64> {
        let channels = sets.arm.channels().to_vec();
        let clock = self.direct.clock().to_vec();
        let reference = Observation::new(Kind::Joints, channels, clock, self.reference.clone())?;
        let [proposed, target] = [&reference, &case.seen.seen].map(|observation| Side { observation, scale: None });
        Ok(REFERENCE_KG + self.direct.estimate_batch(&[(proposed, target)])?[0][0])
    }
}

/// The mass after each rollout: the best of those so far where `best` is asked for.
fn walked(model: &Model, arm: &ObservedArm, case: &Case, how: Loop) -> Result<Vec<f64>> {
    let mut start = Point::start(arm, std::slice::from_ref(&case.seen));
    start.parameters[0] = case.proposed_kg;
    let walk = walk(arm, &case.seen, model, &start, how)?;
    let mut best = (f64::INFINITY, 0.0);
    let each = walk.iterations.iter().map(|i| {
        if !how.best || i.rmse < best.0 {
            best = (i.rmse, i.parameters[0]);
        }
        best.1
    });
    Ok(each.skip(1).collect())
}

/// A quarter of the training.
fn shorter(mut preset: Preset) -> Preset {
    match &mut preset.course {
        Course::Remixed { steps, .. } => *steps /= 4,
        Course::Epochs { epochs } => *epochs /= 4,
    }
    preset
}
