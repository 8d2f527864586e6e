//! Greedy entropy search: a Gaussian process over the error, asked where the minimum may lie.
//!
//! As the paper's appendix sets it up: 50 bins of the range, 100 functions drawn from the process, a radial basis
//! function. The next rollout goes where the share of drawn functions with their minimum there, p, has the greatest
//! −p ln p (Zhu, Kimmel, Bekris and Boularias, 2018).

use anyhow::{Context, Result};
use nalgebra::{Cholesky, DMatrix, DVector};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;

use super::super::tuning::targets::mean_distance;
use super::{Course, Search};

const BINS: usize = 50;
const POPULATION: usize = 100;
/// How far the error at one value speaks for its neighbours, as a share of the range.
const REACH: f64 = 0.1;
/// The error's own variance added to that of the process: keeps the matrices positive.
const NUGGET: f64 = 1e-6;

/// The bin with the least expected error after every rollout.
pub fn search(target: &Search, most: usize) -> Result<Course> {
    let (low, high) = target.range;
    let bins: Vec<f64> = (0..BINS).map(|i| low + (high - low) * i as f64 / (BINS - 1) as f64).collect();
    let length = REACH * (high - low);
    let kernel = |a: f64, b: f64| (-0.5 * ((a - b) / length).powi(2)).exp();
    let mut random = ChaCha8Rng::seed_from_u64(target.seed);
    let (mut asked, mut errors): (Vec<usize>, Vec<f64>) = (Vec::new(), Vec::new());
    let mut course = vec![target.proposed];
    let mut next = random.random_range(0..BINS);
    while course.len() <= most {
        // Every bin is asked once at most: the simulator says the same again.
        asked.push(next);
        errors.push(mean_distance(&(target.roll)(bins[next])?, target.seen));
        let n = asked.len();
        let mean = errors.iter().sum::<f64>() / n as f64;
        let scale = (errors.iter().map(|e| (e - mean).powi(2)).sum::<f64>() / n as f64).sqrt().max(1e-9);
        let seen = DVector::from_iterator(n, errors.iter().map(|e| (e - mean) / scale));
        let among =
            DMatrix::from_fn(n, n, |i, j| kernel(bins[asked[i]], bins[asked[j]]) + if i == j { NUGGET } else { 0.0 });
        let across = DMatrix::from_fn(BINS, n, |i, j| kernel(bins[i], bins[asked[j]]));
        let known = Cholesky::new(among).context("the process over what was asked")?;
        let expected = &across * known.solve(&seen);
        course.push(bins[expected.imin()]);
        if n == BINS {
            break;
        }
        let prior = DMatrix::from_fn(BINS, BINS, |i, j| kernel(bins[i], bins[j]) + if i == j { NUGGET } else { 0.0 });
        let left = prior - &across * known.solve(&across.transpose());
        // What was asked is known but for rounding, which may leave it below nothing.
        let spread =
            Cholesky::new(left + DMatrix::identity(BINS, BINS) * NUGGET).context("the process over the bins")?;
        let mut least_at = [0usize; BINS];
        for _ in 0..POPULATION {
            let drawn = DVector::from_fn(BINS, |_, _| random.sample::<f64, _>(StandardNormal));
            least_at[(&expected + spread.l() * drawn).imin()] += 1;
        }
        let gain = |bin: usize| {
            let p = least_at[bin] as f64 / POPULATION as f64;
            if p > 0.0 { -p * p.ln() } else { 0.0 }
        };
        let open = (0..BINS).filter(|bin| !asked.contains(bin));
        next = open.max_by(|a, b| gain(*a).total_cmp(&gain(*b)).then(b.cmp(a))).context("a bin that was not asked")?;
    }
    let last = course[course.len() - 1];
    course.resize(most + 1, last);
    Ok(course)
}
