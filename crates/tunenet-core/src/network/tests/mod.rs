//! The whole way: a point reflected in closed form, a dataset, a training, an estimate.

mod device;
mod model;
mod training;

use std::cell::RefCell;

use rand_chacha::ChaCha8Rng;

use super::*;
use crate::observation::{Channel, Kind, Observation};
use crate::simulator::rollout;
use crate::testing::reflected_point::{ReflectedPoint, draw, header, scale};
use crate::{Error, Result};

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
    let pair = |i: u64| roll_pair(&ReflectedPoint::new(), &header, draw(i, &mut stream(header.seed, i))).unwrap();
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

fn seen(returned: f64, height: f64, samples: u32) -> Observation {
    let clock = header(0, samples).clock;
    let values = rollout(&ReflectedPoint::new(), &[returned], &[height], &clock).unwrap();
    Observation::new(Kind::Positions, Channel::positions(), clock, values).unwrap()
}
