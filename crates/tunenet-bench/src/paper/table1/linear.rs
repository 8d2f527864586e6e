//! Linear least squares from the difference of two observations to the difference of the masses, with the ridge that known
//! noise asks for.

use anyhow::{Context, Result};
use nalgebra::{DMatrix, DVector};
use tunenet_core::network::Pair;
use tunenet_formats::dataset::DatasetReader;

/// Intervals of each joint over which torques are averaged.
const BINS: usize = 50;
/// Least ridge, in units of the mean square of the inputs: keeps noise-free equations solvable.
const LEAST_RIDGE: f64 = 1e-12;

/// Weights, one for each joint and interval.
pub struct Linear(DVector<f64>);

impl Linear {
    /// Learned from a dataset's pairs, whose targets would have noise of this standard deviation at `rate_hz`.
    pub fn learn(data: &std::path::Path, noise_nm: f64, rate_hz: f64) -> Result<Self> {
        let reader = DatasetReader::open(data)?;
        let header = reader.header().clone();
        let channels = header.channels.len();
        let pairs: Vec<Pair> = reader.collect::<tunenet_formats::Result<_>>()?;
        let row = |pair: &Pair| means(&difference(&pair.proposed, &pair.target), channels);
        let inputs = DMatrix::from_rows(&pairs.iter().map(|p| row(p).transpose()).collect::<Vec<_>>());
        let masses = pairs.iter().map(|p| p.target_parameters[0] - p.proposed_parameters[0]);
        let masses = DVector::from_iterator(pairs.len(), masses);
        let duration = header.clock.last().copied().unwrap_or(1.0);
        // The noise of a mean over an interval, summed over all pairs.
        let noise = noise_nm * noise_nm * BINS as f64 / (duration * rate_hz) * pairs.len() as f64;
        let normal = inputs.transpose() * &inputs;
        let ridge = noise + LEAST_RIDGE * normal.trace();
        let normal = normal + DMatrix::identity(inputs.ncols(), inputs.ncols()) * ridge;
        let solved = normal.cholesky().context("the linear equations have no solution")?;
        Ok(Self(solved.solve(&(inputs.transpose() * masses))))
    }

    /// By how much the target is heavier, kg.
    pub fn step_kg(&self, proposed: &[f64], target: &[f64], channels: usize) -> f64 {
        means(&difference(proposed, target), channels).dot(&self.0)
    }
}

fn difference(proposed: &[f64], target: &[f64]) -> Vec<f64> {
    target.iter().zip(proposed).map(|(t, p)| t - p).collect()
}

/// The mean of every channel over each interval.
fn means(values: &[f64], channels: usize) -> DVector<f64> {
    let samples = values.len() / channels;
    let mut means = DVector::zeros(BINS * channels);
    for bin in 0..BINS {
        let (from, to) = (bin * samples / BINS, (bin + 1) * samples / BINS);
        for (c, sum) in means.rows_mut(bin * channels, channels).iter_mut().enumerate() {
            *sum = (from..to).map(|i| values[i * channels + c]).sum::<f64>() / (to - from) as f64;
        }
    }
    means
}
