//! A closed-form simulator and the pairs of a data set drawn for it.

use rand::Rng as _;
use rand_chacha::ChaCha8Rng;
use tunenet_core::network::{CoveredParameter, DatasetHeader, PairDraw};
use tunenet_core::observation::{Channel, Kind};
use tunenet_core::simulator::{Parameter, Scale, Simulator};

const GRAVITY: f64 = 9.81;

/// A point that falls from `own[0]` metres and rebounds with its restitution; exact at every instant.
pub(crate) struct Bouncer {
    parameters: Vec<Parameter>,
    channels: Vec<Channel>,
}

impl Bouncer {
    pub(crate) fn new() -> Self {
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

pub(crate) fn header(pairs: u64, samples: u32) -> DatasetHeader {
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

pub(crate) fn scale(height: f64) -> Scale {
    Scale::new(0.0, height, 0.0, (height / GRAVITY).sqrt()).unwrap()
}

pub(crate) fn draw(_: u64, random: &mut ChaCha8Rng) -> PairDraw {
    let height = random.random_range(4.0..5.0);
    PairDraw {
        proposed: vec![random.random()],
        target: vec![random.random()],
        own: vec![height],
        scale: Some(scale(height)),
    }
}
