//! Evidence for an outcome: curves before and after, residuals, and profile likelihoods.

use rayon::prelude::*;

use super::Outcome;
use crate::Result;
use crate::estimate::{
    Adequacy, Contour, Fit, LEVEL, Point, Problem, Profile, RolloutLog, ScaleEstimate, contour, profile,
};
use crate::estimate::{floor, free, weighted, weights};
use crate::observation::{Kind, Observation};
use crate::simulator::{Prepared, Simulator, every, predict};
use crate::statistics::{NORMAL_95, autocorrelation};

/// Instants of a rollout that is drawn as a curve.
const CURVE: u32 = 1200;
/// Most lags of an autocorrelation.
const MOST_LAGS: usize = 20;
/// A channel moves where its range is more than this share of the widest, and more than this many times its noise.
const MOVES_SHARE: f64 = 0.02;
const MOVES_NOISE: f64 = 10.0;
/// A profile is drawn this many times as far as the interval reaches.
const BEYOND: f64 = 1.8;
/// Most pairs of parameters whose joint regions are sought, the most correlated first.
const MOST_PAIRS: usize = 3;
/// Levels of the joint regions.
const LEVELS: [f64; 2] = [0.5, LEVEL];

/// One recording and its simulation.
#[derive(Debug, Clone)]
pub struct Comparison {
    /// What was fitted to.
    pub seen: Observation,
    /// Noise of each channel, in its unit.
    pub noise: Vec<f64>,
    /// When something sudden happened, on the clock of `seen`.
    pub events: Vec<f64>,
    /// Whether the simulation moves this channel, so that it is worth drawing; at least one does.
    pub moves: Vec<bool>,
    /// The instants of the curves.
    pub clock: Vec<f64>,
    /// The rollout with the old parameters, nuisance parameters fitted; row-major `[instant, channel]`.
    pub before: Vec<f64>,
    /// The rollout with the new parameters, likewise.
    pub after: Vec<f64>,
    /// (measured − predicted) / noise with the new parameters; row-major `[sample, channel]`.
    pub residual: Vec<f64>,
    /// Autocorrelation of each channel's residual over lags from 0; shape `[channel][lag]`.
    pub autocorrelation: Vec<Vec<f64>>,
    /// Whether what is left is noise.
    pub adequacy: Adequacy,
}

impl Comparison {
    /// White residuals stay within ± this in 95 of 100 lags: 1.96/√n.
    #[must_use]
    pub fn envelope(&self) -> f64 {
        NORMAL_95 / (self.seen.len() as f64).sqrt()
    }
}

/// Everything that a report of an outcome draws.
#[derive(Debug, Clone)]
pub struct Evidence {
    /// For each recording used.
    pub recordings: Vec<Comparison>,
    /// For each fitted parameter.
    pub profiles: Vec<Profile>,
    /// Joint regions of pairs of fitted parameters: for each pair one of 50 % and one of 95 %.
    pub contours: Vec<Contour>,
    /// How many rollouts it took.
    pub rollouts: usize,
}

/// How much of the evidence is simulated.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Detail {
    /// The recordings alone: three rollouts of each.
    Recordings,
    /// Profile likelihoods and joint regions too, which take hundreds to thousands of rollouts.
    Profiles,
}

/// What there is to see behind `outcome`, which `simulator` was tuned to. Nothing where it was rejected.
///
/// # Errors
/// Where the simulator refuses.
pub fn evidence(simulator: &dyn Simulator, outcome: &Outcome, detail: Detail) -> Result<Evidence> {
    let mut found = Evidence { recordings: Vec::new(), profiles: Vec::new(), contours: Vec::new(), rollouts: 0 };
    let (Some(before), Some(after)) = (&outcome.before, &outcome.point) else { return Ok(found) };
    let recordings = &outcome.recordings;
    let noise: Vec<Vec<f64>> = recordings.iter().map(weights).collect();
    let free = free(simulator.parameters(), recordings);
    let shared = free.len().div_ceil(recordings.len().max(1));
    for (d, recording) in recordings.iter().enumerate() {
        let (old, new) = ((&before.parameters, &before.nuisances[d]), (&after.parameters, &after.nuisances[d]));
        found.recordings.push(compare(simulator, recording, &floor(recording), old, new, shared)?);
        found.rollouts += 3;
    }
    if free.is_empty() || detail == Detail::Recordings {
        return Ok(found);
    }
    let log = RolloutLog::default();
    let problem = Problem { simulator, recordings, noise: &noise, free: &free, log: Some(&log) };
    // The record's own best; the estimate from the events only and the paper's last iterate differ from it.
    let fit = problem.fit(after.clone(), 1.0)?;
    let linear = problem.linearise(&fit)?;
    let scale = ScaleEstimate::of(&problem, &fit, &linear);
    for i in 0..free.len() {
        let (curve, _) = profile(&problem, &fit, &scale, i, range(&problem, &fit, &scale, i, outcome, after));
        found.profiles.push(curve);
    }
    let mut pairs: Vec<(usize, usize)> = (0..free.len()).flat_map(|j| (0..j).map(move |i| (i, j))).collect();
    let strength = |&(i, j): &(usize, usize)| outcome.correlation[(i, j)].abs();
    pairs.sort_by(|a, b| strength(b).total_cmp(&strength(a)));
    for pair in pairs.into_iter().take(MOST_PAIRS) {
        for level in LEVELS {
            if let Some((region, _)) = contour(&problem, &fit, &scale, pair, level) {
                found.contours.push(region);
            }
        }
    }
    found.rollouts += log.count();
    Ok(found)
}

/// How far the profile of free parameter `i` is worth drawing: beyond its interval, and around the record's own best.
fn range(
    problem: &Problem,
    fit: &Fit,
    scale: &ScaleEstimate,
    i: usize,
    outcome: &Outcome,
    after: &Point,
) -> (f64, f64) {
    let position = problem.free[i];
    let p = &problem.simulator.parameters()[position];
    let (value, best) = (after.parameters[position], fit.point.parameters[position]);
    let interval = outcome.parameters.iter().find(|e| e.name == p.name).map_or((p.min, p.max), |e| e.interval95);
    let sd = scale.sd(fit.covariance[(i, i)]);
    let half_width = if sd.is_finite() { 3.5 * sd } else { p.span() };
    (
        (value - BEYOND * (value - interval.0)).min(best - half_width).max(p.min),
        (value + BEYOND * (interval.1 - value)).max(best + half_width).min(p.max),
    )
}

type Values<'a> = (&'a [f64], &'a [f64]);

fn compare(
    simulator: &dyn Simulator,
    recording: &Prepared,
    noise: &[f64],
    (old, old_own): (&Vec<f64>, &Vec<f64>),
    (new, new_own): (&Vec<f64>, &Vec<f64>),
    shared: usize,
) -> Result<Comparison> {
    let seen = &recording.seen;
    let clock = curve_clock(seen);
    let ends: [Values; 2] = [(old, old_own), (new, new_own)];
    let roll = |(parameters, nuisances): &Values| predict(simulator, recording, parameters, nuisances, &clock);
    let mut curves = every(ends.par_iter().map(roll))?;
    let (after, before) = (curves.pop().unwrap_or_default(), curves.pop().unwrap_or_default());
    let residual = weighted(simulator, recording, noise, new, new_own, seen.len())?;
    let width = noise.len();
    let column = |channel: usize| residual.iter().copied().skip(channel).step_by(width);
    let lags = MOST_LAGS.min(seen.len() / 3);
    let autocorrelation = (0..width).map(|c| autocorrelation(&column(c).collect::<Vec<_>>(), lags)).collect();
    let adequacy = Adequacy::of(seen, noise, &residual, (recording.nuisances.len() + shared, recording.discrepancy));
    Ok(Comparison {
        // A joint whose torque hardly changes is still one that a user asks after.
        moves: if seen.kind() == Kind::Joints { vec![true; width] } else { moves(&after, noise) },
        seen: seen.clone(),
        noise: noise.to_vec(),
        events: recording.events.clone(),
        clock,
        before,
        after,
        residual,
        autocorrelation,
        adequacy,
    })
}

/// Evenly spaced instants over the whole recording; the events themselves where the clock counts them.
fn curve_clock(seen: &Observation) -> Vec<f64> {
    if seen.kind() == Kind::EventTimes {
        return seen.clock().to_vec();
    }
    let (first, last) = (seen.clock()[0], seen.clock()[seen.len() - 1]);
    (0..CURVE).map(|i| first + (last - first) * f64::from(i) / f64::from(CURVE - 1)).collect()
}

fn moves(curve: &[f64], noise: &[f64]) -> Vec<bool> {
    let width = noise.len();
    let range = |channel: usize| {
        let column = || curve.iter().copied().skip(channel).step_by(width);
        column().fold(f64::NEG_INFINITY, f64::max) - column().fold(f64::INFINITY, f64::min)
    };
    let ranges: Vec<f64> = (0..width).map(range).collect();
    let widest = ranges.iter().copied().fold(0.0, f64::max);
    let moving = |c: usize| ranges[c] >= MOVES_SHARE * widest && ranges[c] > MOVES_NOISE * noise[c];
    let found: Vec<bool> = (0..width).map(moving).collect();
    if found.contains(&true) { found } else { ranges.iter().map(|r| *r == widest).collect() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::observation::Channel;
    use crate::simulator::{Parameter, RolloutResult};
    use crate::tune::{Settings, tune};
    use rand::{Rng, SeedableRng};

    #[test]
    fn channels_that_only_carry_noise_are_not_drawn() {
        assert_eq!(moves(&[0.0, 0.0, 1.0, 0.001], &[0.002, 0.002]), [true, false]);
        assert_eq!(moves(&[0.0, 0.0, 0.0, 0.001], &[1.0, 1.0]), [false, true], "the widest where none moves");
    }

    /// Straight lines `a + b t`: least squares has a closed form for both variances and for the ellipse.
    struct Line(Vec<Parameter>, Vec<Channel>);

    impl Simulator for Line {
        fn parameters(&self) -> &[Parameter] {
            &self.0
        }

        fn channels(&self) -> &[Channel] {
            &self.1
        }

        fn rollout(&self, p: &[f64], _: &[f64], clock: &[f64], out: &mut [f64]) -> RolloutResult {
            clock.iter().zip(out).for_each(|(t, v)| *v = p[0] + p[1] * t);
            Ok(())
        }
    }

    #[test]
    fn a_straight_line_has_the_profile_and_the_ellipse_of_its_textbook() {
        let parameters = ["a", "b"].map(|name| Parameter::new(name, "1", 0.0, -10.0, 10.0).unwrap()).to_vec();
        let line = Line(parameters, vec![Channel::new("y", "1")]);
        let clock: Vec<f64> = (0..400).map(|i| f64::from(i) / 399.0).collect();
        let mut draw = rand_chacha::ChaCha8Rng::seed_from_u64(5);
        let values =
            clock.iter().map(|t| 1.0 + 2.0 * t + 0.1 * draw.sample::<f64, _>(rand_distr::StandardNormal)).collect();
        let seen = Observation::new(Kind::Other, line.channels().to_vec(), clock.clone(), values).unwrap();
        let outcome = tune(&line, &[seen], None, &Settings::default()).unwrap();
        let found = evidence(&line, &outcome, Detail::Profiles).unwrap();
        let comparison = &found.recordings[0];
        assert!(comparison.moves[0] && comparison.before.iter().all(|v| *v == 0.0));
        let beyond = comparison.autocorrelation[0][1..].iter().filter(|r| r.abs() > comparison.envelope()).count();
        assert!(beyond <= 3, "white noise leaves the envelope at {beyond} of 20 lags");

        // Var(b) = s² / Σ(t − t̄)², s² from the residuals themselves.
        let residual: f64 = comparison.residual.iter().map(|r| (r * comparison.noise[0]).powi(2)).sum();
        let variance = residual / 398.0;
        let middle = clock.iter().sum::<f64>() / 400.0;
        let squares: f64 = clock.iter().map(|t| (t - middle).powi(2)).sum();
        let half = 1.966 * (variance / squares).sqrt();
        let (low, high) = found.profiles[1].inside(found.profiles[1].cut95);
        assert!(((high - low) / (2.0 * half) - 1.0).abs() < 0.02, "{low} {high} instead of ±{half}");

        // Every point of the edge has (θ − θ̂)ᵀ XᵀX (θ − θ̂) = 2 s² F(0.95; 2, 398) with F = 3.018.
        let region = found.contours.iter().find(|c| c.level == LEVEL).unwrap();
        assert_eq!(region.edge.len(), 36);
        let sums = [400.0, clock.iter().sum::<f64>(), clock.iter().map(|t| t * t).sum::<f64>()];
        for (a, b) in &region.edge {
            let (da, db) = (a - region.best.0, b - region.best.1);
            let form = sums[0] * da * da + 2.0 * sums[1] * da * db + sums[2] * db * db;
            let level = form / (2.0 * variance);
            assert!((level / 3.018 - 1.0).abs() < 0.06, "{level}");
        }
    }
}
