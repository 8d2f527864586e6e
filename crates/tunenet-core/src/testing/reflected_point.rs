//! A point that falls and is reflected by a plane: z'' = −g above it, ż → −e ż on it, in closed form at every instant.
//!
//! The pairs of a data set drawn of it are a training in seconds.

use rand::Rng as _;
use rand_chacha::ChaCha8Rng;

use crate::network::{CoveredParameter, DatasetHeader, PairDraw};
use crate::observation::{Channel, Kind};
use crate::simulator::{Parameter, RolloutResult, Scale, Simulator};

/// m/s², downwards.
const GRAVITY_M_S2: f64 = 9.81;
/// Speed below which the point lies still, m/s.
const STILL_M_S: f64 = 1e-9;

/// A point that falls from rest; its nuisance parameter is the height from which, in m. Channels `x`, `y`, `z` in m.
pub struct ReflectedPoint {
    parameters: Vec<Parameter>,
    channels: Vec<Channel>,
}

impl ReflectedPoint {
    /// With one parameter, the share of its speed that the plane returns: 0 to 1, 0.5 at first.
    #[must_use]
    pub fn new() -> Self {
        let parameters = Parameter::new("returned", "1", 0.5, 0.0, 1.0).into_iter().collect();
        Self { parameters, channels: Channel::positions() }
    }
}

impl Default for ReflectedPoint {
    fn default() -> Self {
        Self::new()
    }
}

impl Simulator for ReflectedPoint {
    fn parameters(&self) -> &[Parameter] {
        &self.parameters
    }

    fn channels(&self) -> &[Channel] {
        &self.channels
    }

    fn kind(&self) -> Kind {
        Kind::Positions
    }

    fn rollout(&self, parameters: &[f64], nuisances: &[f64], clock: &[f64], values: &mut [f64]) -> RolloutResult {
        let (returned, height) = (parameters[0], nuisances[0]);
        // The arc between two impacts: when it began, where, how fast, how long it lasts.
        let (mut began, mut low, mut speed) = (0.0, height, 0.0);
        let mut lasts = (2.0 * height / GRAVITY_M_S2).sqrt();
        let mut impact = GRAVITY_M_S2 * lasts;
        for (t, row) in clock.iter().zip(values.chunks_exact_mut(3)) {
            while t - began > lasts && impact > STILL_M_S {
                began += lasts;
                impact *= returned;
                (low, speed, lasts) = (0.0, impact, 2.0 * impact / GRAVITY_M_S2);
            }
            let s = t - began;
            let z = if s > lasts { 0.0 } else { low + speed * s - 0.5 * GRAVITY_M_S2 * s * s };
            row.copy_from_slice(&[0.0, 0.0, z.max(0.0)]);
        }
        Ok(())
    }
}

/// The header of a data set of so many pairs, each of so many samples.
#[must_use]
pub fn header(pairs: u64, samples: u32) -> DatasetHeader {
    DatasetHeader {
        preset: "reflected_point".into(),
        seed: 1,
        pairs,
        parameters: vec![CoveredParameter {
            name: "returned".into(),
            unit: "1".into(),
            min: 0.0,
            max: 1.0,
            tuned: true,
        }],
        channels: Channel::positions(),
        target_channels: Vec::new(),
        // However few the samples, an impact is among them: without one the parameter changes nothing.
        clock: (0..samples).map(|i| f64::from(i) * (3.0 / f64::from(samples)).max(1.0 / 60.0)).collect(),
        scene: "kind = \"reflected_point\"\n".into(),
    }
}

/// The natural scales of a fall from this height, m.
#[must_use]
pub fn scale(height_m: f64) -> Scale {
    Scale { origin: 0.0, length: height_m, start_s: 0.0, time_s: (height_m / GRAVITY_M_S2).sqrt() }
}

/// A pair drawn at random: a fall from 4 m to 5 m.
#[must_use]
pub fn draw(_: u64, random: &mut ChaCha8Rng) -> PairDraw {
    let height = random.random_range(4.0..5.0);
    PairDraw {
        proposed: vec![random.random()],
        target: vec![random.random()],
        own: vec![height],
        scale: Some(scale(height)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simulator::rollout;

    #[test]
    fn it_rises_to_the_square_of_the_share_returned() {
        let fall = (2.0 * 4.0 / GRAVITY_M_S2).sqrt();
        let clock = [0.0, fall, 1.7 * fall, 100.0];
        let values = rollout(&ReflectedPoint::new(), &[0.7], &[4.0], &clock).unwrap();
        let z: Vec<f64> = values.chunks_exact(3).map(|row| row[2]).collect();
        assert!(z[0] == 4.0 && z[1].abs() < 1e-9 && (z[2] - 0.49 * 4.0).abs() < 1e-9 && z[3] == 0.0, "{z:?}");
    }
}
