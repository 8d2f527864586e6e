//! The whole way: a closed-form bouncing ball, a dataset, a training, an estimate.

mod device;
mod model;
mod training;

use crate::simulator::Scale;
use std::cell::RefCell;

use rand::Rng;
use rand_chacha::ChaCha8Rng;

use super::*;
use crate::observation::{Channel, Kind, Observation};
use crate::simulator::{Parameter, Simulator, rollout};
use crate::{Error, Result};

const GRAVITY: f64 = 9.81;

/// A point that falls from `own[0]` metres and rebounds with its restitution; exact at every instant.
struct Bouncer {
    parameters: Vec<Parameter>,
    channels: Vec<Channel>,
}

impl Bouncer {
    fn new() -> Self {
        Self {
            parameters: vec![Parameter::new("restitution", "1", 0.5, 0.0, 1.0).unwrap()],
            channels: Channel::positions(),
        }
    }
}

impl Simulator for Bouncer {
    fn parameters(&self) -> &[Parameter] {
        &self.parameters
    }

    fn channels(&self) -> &[Channel] {
        &self.channels
    }

    fn kind(&self) -> Kind {
        Kind::Positions
    }

    fn rollout(
        &self,
        parameters: &[f64],
        own: &[f64],
        clock: &[f64],
        values: &mut [f64],
    ) -> std::result::Result<(), String> {
        let (restitution, height) = (parameters[0], own[0]);
        // The arc in flight: where it began, how fast, how long it lasts.
        let (mut began, mut low, mut speed) = (0.0, height, 0.0);
        let mut lasts = (2.0 * height / GRAVITY).sqrt();
        let mut impact = GRAVITY * lasts;
        for (t, row) in clock.iter().zip(values.chunks_exact_mut(3)) {
            while t - began > lasts && impact > 1e-9 {
                began += lasts;
                impact *= restitution;
                (low, speed, lasts) = (0.0, impact, 2.0 * impact / GRAVITY);
            }
            let s = t - began;
            let z = if s > lasts { 0.0 } else { low + speed * s - 0.5 * GRAVITY * s * s };
            row.copy_from_slice(&[0.0, 0.0, z.max(0.0)]);
        }
        Ok(())
    }
}

fn header(pairs: u64, samples: u32) -> DatasetHeader {
    DatasetHeader {
        preset: "bouncer".into(),
        seed: 1,
        pairs,
        parameters: vec![CoveredParameter {
            name: "restitution".into(),
            unit: "1".into(),
            min: 0.0,
            max: 1.0,
            tuned: true,
        }],
        channels: Channel::positions(),
        target_channels: Vec::new(),
        // However few the samples, a bounce is among them: without one the restitution changes nothing.
        clock: (0..samples).map(|i| f64::from(i) * (3.0 / f64::from(samples)).max(1.0 / 60.0)).collect(),
        scene: "kind = \"ball\"\n".into(),
    }
}

fn scale(height: f64) -> Scale {
    Scale::new(0.0, height, 0.0, (height / GRAVITY).sqrt()).unwrap()
}

fn draw(_: u64, random: &mut ChaCha8Rng) -> PairDraw {
    let height = random.random_range(4.0..5.0);
    PairDraw {
        proposed: vec![random.random()],
        target: vec![random.random()],
        own: vec![height],
        scale: Some(scale(height)),
    }
}

/// A data set in memory.
struct Set {
    header: DatasetHeader,
    pairs: Vec<Pair>,
}

impl DataSet for Set {
    fn header(&self) -> &DatasetHeader {
        &self.header
    }

    fn pairs(&self) -> Result<Box<dyn Iterator<Item = Result<Pair>> + '_>> {
        Ok(Box::new(self.pairs.iter().cloned().map(Ok)))
    }
}

fn made(header: DatasetHeader, draw: &Draw<'_>) -> Set {
    let pair = |i: u64| roll_pair(&Bouncer::new(), &header, draw(i, &mut stream(header.seed, i))).unwrap();
    let pairs = (0..header.pairs).map(pair).collect();
    Set { header, pairs }
}

fn dataset(pairs: u64, samples: u32) -> Set {
    made(header(pairs, samples), &draw)
}

/// A checkpoint in memory.
#[derive(Default)]
struct Kept(RefCell<Option<Weights>>);

impl Checkpoint for Kept {
    fn fingerprint(&self, settings: &[u8]) -> Result<String> {
        Ok(String::from_utf8_lossy(settings).into())
    }

    fn load(&self) -> Result<Option<Weights>> {
        Ok(self.0.borrow().clone())
    }

    fn save(&self, weights: &Weights) -> Result<()> {
        *self.0.borrow_mut() = Some(weights.clone());
        Ok(())
    }
}

impl Kept {
    fn here(&self) -> Keeping<'_> {
        Keeping { checkpoint: Some(self), overflow: None }
    }
}

fn learned(data: &Set, preset: Preset) -> Model {
    train(data, &options(preset), Keeping::default(), &mut |_| true).unwrap()
}

/// A training short enough for a test.
fn short(steps: u64) -> Preset {
    Preset { course: Course::Remixed { steps, noise: 0.11, cut: 0.1 }, batch: 32, ..Preset::default() }
}

fn options(preset: Preset) -> TrainOptions {
    TrainOptions::new(preset, 7)
}

fn seen(restitution: f64, height: f64, samples: u32) -> Observation {
    let clock = header(0, samples).clock;
    let values = rollout(&Bouncer::new(), &[restitution], &[height], &clock).unwrap();
    Observation::new(Kind::Positions, Channel::positions(), clock, values).unwrap()
}
