//! A simulator and recordings, and what both methods need for them.

use anyhow::{Result, bail};
use rand::Rng;
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;
use tunenet_core::observation::Observation;
use tunenet_core::simulator::{Preparation, Prepared, Simulator, predict};
use tunenet_core::tune::{Outcome, Settings, tune};

use super::python::{Bounded, Package, least_squares};
use super::results::Comparison;

/// What is tuned.
pub struct Problem {
    pub name: &'static str,
    pub simulator: Box<dyn Simulator>,
    pub recordings: Vec<Observation>,
    /// Standard deviation of the noise of each channel.
    pub noise: Vec<f64>,
    /// The goal.
    pub most_rollouts: usize,
}

impl Problem {
    /// Tunes by every method.
    pub fn compare(&self) -> Result<Comparison> {
        let ours = tune(&*self.simulator, &self.recordings, None, &Settings::default())?;
        let theirs = self.by(Package::Scipy)?;
        let of_mujoco = self.by(Package::Mujoco)?;
        let count = self.recordings.len();
        let difference = theirs.as_ref().map(|(values, _)| self.difference(&ours, values));
        Ok(Comparison {
            problem: self.name,
            parameters: self.simulator.parameters().iter().filter(|p| p.tune).count(),
            recordings: count,
            verdict: ours.verdict,
            rollouts: ours.rollouts,
            scipy_rollouts: theirs.map(|(_, calls)| calls * count),
            mujoco_rollouts: of_mujoco.map(|(_, calls)| calls * count),
            most_rollouts: self.most_rollouts,
            largest_difference: difference,
        })
    }

    /// The largest difference of a value to that of scipy, in half-widths of its 95 % interval.
    fn difference(&self, ours: &Outcome, theirs: &[f64]) -> f64 {
        let tuned = self.simulator.parameters().iter().filter(|p| p.tune).zip(theirs);
        let each = tuned.filter_map(|(parameter, value)| {
            let estimate = ours.parameters.iter().find(|e| e.name == parameter.name)?;
            let (low, high) = estimate.interval95;
            Some((estimate.value - value).abs() / (0.5 * (high - low)))
        });
        each.fold(0.0, f64::max)
    }

    /// The tuned parameters by another package, and its calls; `None` where the package is not there. It fits the same nuisance parameters, those of
    /// each recording after the parameters.
    fn by(&self, package: Package) -> Result<Option<(Vec<f64>, usize)>> {
        let prepared = self.recordings.iter().map(|seen| match self.simulator.prepare(seen)? {
            Preparation::Usable(prepared) => Ok(*prepared),
            Preparation::Rejected(rejected) => bail!("{}: {}", self.name, rejected.note.text),
        });
        let prepared = prepared.collect::<Result<Vec<Prepared>>>()?;
        let parameters = self.simulator.parameters();
        let free: Vec<usize> = (0..parameters.len()).filter(|&i| parameters[i].tune).collect();
        let all = || free.iter().map(|&i| &parameters[i]).chain(prepared.iter().flat_map(|p| &p.nuisances));
        let bounded = Bounded {
            start: all().map(|p| p.value).collect(),
            low: all().map(|p| p.min).collect(),
            high: all().map(|p| p.max).collect(),
        };
        let mut calls = 0;
        let residuals = |point: &[f64]| -> Option<Vec<f64>> {
            calls += 1;
            let (shared, mut own) = point.split_at_checked(free.len())?;
            let mut values: Vec<f64> = parameters.iter().map(|p| p.value).collect();
            free.iter().zip(shared).for_each(|(&i, value)| values[i] = *value);
            let mut out = Vec::new();
            for recording in &prepared {
                let (nuisances, rest) = own.split_at_checked(recording.nuisances.len())?;
                own = rest;
                let seen = &recording.seen;
                let made = predict(&*self.simulator, recording, &values, nuisances, seen.clock()).ok()?;
                let noise = self.noise.iter().cycle();
                out.extend(
                    made.iter().zip(seen.values()).zip(noise).map(|((made, seen), noise)| (made - seen) / noise),
                );
            }
            Some(out)
        };
        let found = least_squares(package, &bounded, residuals)?;
        Ok(found.map(|mut values| {
            values.truncate(free.len());
            (values, calls)
        }))
    }
}

/// The same with white noise of these standard deviations, one for each channel.
pub fn noisy(seen: &Observation, noise: &[f64], draw: &mut ChaCha8Rng) -> Result<Observation> {
    let each = seen.values().iter().zip(noise.iter().cycle());
    Ok(seen.with_values(each.map(|(value, sd)| value + sd * draw.sample::<f64, _>(StandardNormal)).collect())?)
}
