//! The pairs that the table is measured on: `gen arm` makes them, and noise is added to their targets.

use std::path::Path;

use anyhow::{Context, Result};
use rand::Rng;
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;
use serde::{Deserialize, Serialize};
use tunenet_core::network::{Pair, stream};
use tunenet_core::observation::{Kind, Observation};
use tunenet_core::simulator::{Prepared, Simulator, rollout};
use tunenet_formats::dataset::DatasetReader;
use tunenet_sim::{ObservedArm, SimulationFile};

use super::super::super::process;
use super::super::super::resume::Store;
use crate::scene::{URDF, seeds};

const ARM: &str = include_str!("../../../../../assets/arm.toml");
/// Rate at which networks learn, 1/s: the paper's network has one input for each sample.
const TRAINING_HZ: &str = "record.rate_hz=60";
/// Step of the slope behind the bound, kg.
const SLOPE_KG: f64 = 0.01;

/// A set to judge by.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum JudgedSet {
    /// Masses as in training.
    Validation,
    /// Targets 1 kg heavier.
    Test,
}

impl JudgedSet {
    pub fn name(self) -> &'static str {
        match self {
            Self::Validation => "validation",
            Self::Test => "test",
        }
    }

    /// Least and greatest mass of its targets, kg.
    fn range_kg(self) -> (f64, f64) {
        match self {
            Self::Validation => (0.0, 1.0),
            Self::Test => (1.0, 2.0),
        }
    }
}

/// What making all sets took.
#[derive(Debug, Clone, Copy, Serialize, Deserialize)]
pub struct DataCost {
    pub rollouts: u64,
    pub seconds: f64,
}

/// One case: what is proposed, what was seen, and what is true.
pub struct Case {
    pub proposed_kg: f64,
    pub target_kg: f64,
    /// Standard deviation of the noise on what was seen, N·m.
    pub noise_nm: f64,
    pub seen: Prepared,
    /// Least and greatest mass of its set, kg.
    pub range_kg: (f64, f64),
    /// Random seed of a search.
    pub seed: u64,
}

/// The arm, and the pairs.
pub struct Sets {
    pub arm: ObservedArm,
    /// The same, whose payload may have any mass that nine steps of a network can lead to.
    pub unbounded: ObservedArm,
    /// Masses of training 0 to 1 kg, for the paper's settings.
    pub training: std::path::PathBuf,
    /// The same number over 0 to 2 kg, for ours.
    pub wide: std::path::PathBuf,
    validation: Vec<Pair>,
    test: Vec<Pair>,
    clock: Vec<f64>,
    seed: u64,
    pub cost: DataCost,
}

impl Sets {
    pub fn make(store: &Store, seed: u64, (training, judged): (u64, u64)) -> Result<Self> {
        let room = store.room("arm")?;
        let file = room.join("arm.toml");
        std::fs::write(&file, ARM).with_context(|| format!("writing {}", file.display()))?;
        std::fs::write(room.join("jaco_robotiq.urdf"), URDF).context("writing the URDF")?;
        let path = |name: &str| room.join(format!("{name}-{seed}.mcap"));
        let make = |name: &str, preset: &str, pairs: u64, pairs_seed: u64, set: &[&str]| -> Result<f64> {
            let out = path(name);
            store.keep(&format!("table1-{name}-{seed}"), || {
                // Files that another program left there must not be resumed.
                let _ = std::fs::remove_file(&out);
                let (pairs, pairs_seed) = (pairs.to_string(), pairs_seed.to_string());
                let (sim, out) = (text(&file)?, text(&out)?);
                let first = ["gen", "arm", "--sim", sim, "--preset", preset, "--pairs", &pairs, "--seed", &pairs_seed];
                Ok(process::run(&[&first[..], &["--out", out], set].concat())?.seconds)
            })
        };
        // Three streams of one seed, so that no pair is met twice.
        let seeds = [3 * seed, 3 * seed + 1, 3 * seed + 2];
        let paper = make("train", "paper", training, seeds[0], &["--set", TRAINING_HZ])?;
        let validation = make("validation", "paper", judged, seeds[1], &[])?;
        let test = make("test", "hard", judged, seeds[2], &[])?;
        make("wide", "wide", training, seeds[0], &["--set", TRAINING_HZ])?;
        let read = |name: &str| DatasetReader::open(path(name))?.collect::<tunenet_formats::Result<Vec<Pair>>>();
        let scene = SimulationFile::read(&file)?;
        let mut unbounded = scene.clone();
        unbounded.set("parameters.payload_mass.max=100")?;
        let cost = DataCost { rollouts: 2 * (training + 2 * judged), seconds: paper + validation + test };
        Ok(Self {
            arm: ObservedArm::new(&scene)?,
            unbounded: ObservedArm::new(&unbounded)?,
            training: path("train"),
            wide: path("wide"),
            validation: read("validation")?,
            test: read("test")?,
            clock: DatasetReader::open(path("test"))?.header().clock.clone(),
            seed,
            cost,
        })
    }

    fn pairs(&self, set: JudgedSet) -> &[Pair] {
        match set {
            JudgedSet::Validation => &self.validation,
            JudgedSet::Test => &self.test,
        }
    }

    pub fn len(&self, set: JudgedSet) -> usize {
        self.pairs(set).len()
    }

    /// Case `number`, its target with noise of this standard deviation.
    pub fn pair(&self, set: JudgedSet, number: usize, noise_nm: f64) -> Result<Case> {
        let pair = &self.pairs(set)[number];
        let noise_seed = self.seed.rotate_left(32) ^ seeds::TABLE1_NOISE ^ u64::from(set == JudgedSet::Test);
        let mut random: ChaCha8Rng = stream(noise_seed, number as u64);
        let values = pair.target.iter().map(|v| v + noise_nm * random.sample::<f64, _>(StandardNormal)).collect();
        let seen = Observation::new(Kind::Joints, self.arm.channels().to_vec(), self.clock.clone(), values)?;
        Ok(Case {
            proposed_kg: pair.proposed_parameters[0],
            target_kg: pair.target_parameters[0],
            noise_nm,
            range_kg: set.range_kg(),
            seed: noise_seed ^ (number as u64),
            seen: Prepared::whole(seen, self.arm.parameters().len()),
        })
    }

    /// Torques with this payload, on the clock of the sets.
    pub fn roll(&self, mass_kg: f64) -> Result<Vec<f64>> {
        Ok(rollout(&self.arm, &self.parameters(mass_kg), &[], &self.clock)?)
    }

    pub fn parameters(&self, mass_kg: f64) -> Vec<f64> {
        let mut all: Vec<f64> = self.arm.parameters().iter().map(|p| p.value).collect();
        all[0] = mass_kg;
        all
    }

    /// The Cramér–Rao bound of case `number` under this noise: no unbiased estimate has a smaller standard deviation, kg.
    pub fn bound_kg(&self, set: JudgedSet, number: usize, noise_nm: f64) -> Result<f64> {
        let pair = &self.pairs(set)[number];
        let there = self.roll(pair.target_parameters[0] + SLOPE_KG)?;
        let slopes = there.iter().zip(&pair.target).map(|(a, b)| ((a - b) / SLOPE_KG).powi(2));
        Ok(noise_nm / slopes.sum::<f64>().sqrt())
    }
}

fn text(path: &Path) -> Result<&str> {
    path.to_str().context("the folder's name is not Unicode")
}
