//! A sum of 10 damped cosines with known frequencies: 20 parameters, 10 recordings that differ in length.

use anyhow::Result;
use rand::Rng;
use rand_chacha::ChaCha8Rng;
use std::f64::consts::TAU;
use tunenet_core::observation::{Channel, Kind, Observation};
use tunenet_core::simulator::{FnSimulator, Parameter, Simulator};

use super::problem::{Problem, noisy};

const COSINES: usize = 10;
const RECORDINGS: u32 = 10;
const RATE_HZ: f64 = 100.0;
const NOISE_M: f64 = 0.02;

pub fn problem(most_rollouts: usize, draw: &mut ChaCha8Rng) -> Result<Problem> {
    let simulator = simulator()?;
    let truth: Vec<f64> =
        (0..COSINES).flat_map(|_| [draw.random_range(0.5..1.5), draw.random_range(0.2..1.0)]).collect();
    let recordings = (0..RECORDINGS).map(|number| {
        let samples = 300 + 25 * number;
        let clock: Vec<f64> = (0..samples).map(|i| f64::from(i) / RATE_HZ).collect();
        let values = clock.iter().map(|&t| sum(&truth, t)).collect();
        noisy(&Observation::new(Kind::Other, simulator.channels().to_vec(), clock, values)?, &[NOISE_M], draw)
    });
    let recordings = recordings.collect::<Result<Vec<_>>>()?;
    Ok(Problem { name: "ten damped cosines", simulator, recordings, noise: vec![NOISE_M], most_rollouts })
}

fn simulator() -> Result<Box<dyn Simulator>> {
    let mut parameters = Vec::with_capacity(2 * COSINES);
    for k in 1..=COSINES {
        parameters.push(Parameter::new(format!("amplitude_{k}"), "m", 1.0, 0.0, 3.0)?);
        parameters.push(Parameter::new(format!("decay_{k}"), "1/s", 0.5, 0.0, 3.0)?);
    }
    Ok(Box::new(FnSimulator::new(parameters, vec![Channel::new("y", "m")], |p, _, clock, out| {
        clock.iter().zip(out).for_each(|(&t, y)| *y = sum(p, t));
        Ok(())
    })))
}

fn sum(values: &[f64], t: f64) -> f64 {
    let each = values.chunks_exact(2).enumerate();
    each.map(|(k, pair)| pair[0] * (-pair[1] * t).exp() * (TAU * (0.5 + 0.35 * k as f64) * t).cos()).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;

    #[test]
    fn amplitudes_add_up_at_the_start_and_recordings_differ_in_length() {
        let pairs: Vec<f64> = (0..COSINES).flat_map(|k| [k as f64, 0.3]).collect();
        assert!((sum(&pairs, 0.0) - 45.0).abs() < 1e-12);
        // One cosine alone, after two of its periods.
        assert!((sum(&[2.0, 0.5], 4.0) - 2.0 * (-2.0_f64).exp()).abs() < 1e-12);
        let problem = problem(1, &mut ChaCha8Rng::seed_from_u64(3)).unwrap();
        let lengths: Vec<usize> = problem.recordings.iter().map(Observation::len).collect();
        assert!(lengths.len() == 10 && lengths.windows(2).all(|pair| pair[0] < pair[1]), "{lengths:?}");
    }
}
