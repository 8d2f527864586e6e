//! Random effect of events (Laird and Ware 1982): every event has draws of its own from one normal distribution.
//!
//! The draws of a recording's events are nuisance parameters of the recording. The coefficient of the effect is their standard
//! deviation, on which no rollout depends. A random effect can imitate much, so it is tried last.

use nalgebra::{DMatrix, DVector};

use crate::Result;
use crate::diagnose::evidence::Evidence;
use crate::diagnose::evidence::recording::PreparedRecording;
use crate::diagnose::hypothesis::catalogue::carrier;
use crate::diagnose::hypothesis::context::{Context, EventEffects, Hypothesis};
use crate::diagnose::hypothesis::joint::Which;
use crate::estimate::information_criterion::p_value;
use crate::estimate::projection::Projector;
use crate::simulator::{Parameter, Preparation, Simulator, predict};
use crate::statistics::dot;

/// Step of a draw for its derivative, in the unit of the draws: rad, or one in which they are as small next to 1.
const STEP: f64 = 1e-4;
/// Least and greatest standard deviation that is tried, in the same unit, and the ratio of one to the next.
const LEAST_SD: f64 = 1e-4;
const GREATEST_SD: f64 = 0.5;
const FACTOR: f64 = 1.15;

/// What a random effect of events explains.
#[derive(Debug, Clone)]
pub(in crate::diagnose) struct EventEffectFit {
    /// Gain of the information criterion.
    pub gain: f64,
    /// Probability of that by chance of the noise, all candidates counted.
    pub p_value: f64,
    /// Standard deviation of a draw, in the unit of the draws.
    pub sd: f64,
    /// Root mean squares of what is left in units of the noise: without draws, and with them, if the recordings are linear in them.
    pub left: (f64, f64),
    /// The draws of each recording.
    pub draws: Vec<Vec<Parameter>>,
}

/// What a random effect of events adds to `model`: the gain in marginal likelihood, the draws integrated out.
///
/// With residuals r of which the model's nuisance parameters and shared parameters are projected out, and the draws' projected
/// columns H, r ~ N(0, v (I + s H Hᵀ)); the variance v is profiled, s found on a grid.
pub(in crate::diagnose) fn fit_event_effects(
    context: &Context<'_>,
    model: &Hypothesis,
) -> Result<Option<EventEffectFit>> {
    let Some(random) = context.random_effect_entry() else { return Ok(None) };
    let entries: Vec<_> = model.structure.effects.iter().map(|&e| &context.catalogue[e]).chain([random]).collect();
    let mut carriers = Vec::new();
    for subject in context.subjects {
        carriers.push(carrier(subject, &entries)?);
    }
    let joint = context.joint(&model.structure);
    let residuals = &model.fit.residuals;
    let columns = joint.columns(&model.fit.point, residuals, Which::ALL);
    let lengths: Vec<usize> = residuals.iter().map(Vec::len).collect();
    let projector = Projector::new(&columns, &lengths, model.structure.shared.len());
    let mut left = residuals.concat();
    projector.project(&mut left);
    let total = left.len();
    let (mut stacked, mut all_draws, mut begin) = (Vec::new(), Vec::new(), 0);
    for (index, recording) in context.recordings().iter().enumerate() {
        let simulator = &*carriers[recording.object];
        let draws = draws(simulator, recording)?;
        let base = model.structure.parameters(recording.object, &model.fit.point.parameters);
        let names = model.structure.simulator(recording.object).parameters();
        // The coefficient of the random effect itself keeps its absent value.
        let parameters: Vec<f64> = simulator
            .parameters()
            .iter()
            .map(|p| names.iter().position(|n| n.name == p.name).map_or(p.value, |i| base[i]))
            .collect();
        let nuisances = |moved: Option<usize>| -> Vec<f64> {
            let draws = (0..draws.len()).map(|k| if moved == Some(k) { STEP } else { 0.0 });
            model.fit.point.nuisances[index].iter().copied().chain(draws).collect()
        };
        context.rollouts.spend()?;
        let unmoved = predict(simulator, &recording.prepared, &parameters, &nuisances(None), recording.clock())?;
        for k in 0..draws.len() {
            context.rollouts.spend()?;
            let moved = predict(simulator, &recording.prepared, &parameters, &nuisances(Some(k)), recording.clock())?;
            let mut change: Vec<f64> = unmoved.iter().zip(&moved).map(|(a, b)| (a - b) / STEP).collect();
            recording.filter.apply(&mut change);
            let mut column = vec![0.0; total];
            column[begin..begin + change.len()].copy_from_slice(&change);
            projector.project(&mut column);
            stacked.push(column);
        }
        begin += lengths[index];
        all_draws.push(draws);
    }
    if stacked.is_empty() {
        return Ok(None);
    }
    let (likelihood, sd, explained) = random_effect(&stacked, &left, context.count());
    let rms = |squares: f64| (squares.max(0.0) / context.count() as f64).sqrt();
    let squares = dot(&left, &left);
    let left = (rms(squares), rms(squares - explained));
    let gain = likelihood - (context.count() as f64).ln();
    // Half of the probability lies on the bound, where the standard deviation is 0.
    let p_value = (0.5 * p_value(likelihood, 1) * context.catalogue.len() as f64).min(1.0);
    Ok(Some(EventEffectFit { gain, p_value, sd, left, draws: all_draws }))
}

/// The context in which every recording has these draws as nuisance parameters, with a prior of mean 0 and their standard deviation.
///
/// # Errors
/// Where a held-out recording cannot be prepared.
pub(in crate::diagnose) fn admit<'a>(context: &Context<'a>, effects: &EventEffectFit) -> Result<Context<'a>> {
    let entries: Vec<_> = context.random_effect_entry().into_iter().collect();
    let mut evidence = Evidence::clone(&context.evidence);
    for recording in &mut evidence.validation {
        let draws = draws(&*carrier(&context.subjects[recording.object], &entries)?, recording)?;
        recording.random_draws = draws.len();
        recording.prior_sd.extend(draws.iter().map(|_| effects.sd));
        recording.prepared.nuisances.extend(draws);
    }
    for (recording, draws) in evidence.training.iter_mut().zip(&effects.draws) {
        recording.random_draws = draws.len();
        recording.prior_sd.extend(draws.iter().map(|_| effects.sd));
        recording.prepared.nuisances.extend(draws.iter().cloned());
    }
    let count = effects.draws.iter().map(Vec::len).sum();
    Ok(Context { event_effects: Some(EventEffects { sd: effects.sd, count }), ..context.with_evidence(evidence) })
}

/// The draws of a recording: the nuisance parameters that a simulator with the random effect adds.
fn draws(simulator: &dyn Simulator, recording: &PreparedRecording) -> Result<Vec<Parameter>> {
    Ok(match simulator.prepare(&recording.prepared.seen)? {
        Preparation::Usable(prepared) => {
            prepared.nuisances.into_iter().skip(recording.prepared.nuisances.len()).collect()
        }
        Preparation::Rejected(_) => Vec::new(),
    })
}

/// Twice the gain in marginal logarithmic likelihood by a random effect with these columns, its standard deviation in the columns' unit, and
/// how much of the sum of squares its draws explain; `count` values have noise of unit size or a common multiple of it.
fn random_effect(columns: &[Vec<f64>], left: &[f64], count: usize) -> (f64, f64, f64) {
    let size = columns.len();
    let gram = DMatrix::from_fn(size, size, |i, j| dot(&columns[i], &columns[j]));
    let right = DVector::from_fn(size, |i, _| dot(&columns[i], left));
    if gram.iter().chain(right.iter()).any(|v| !v.is_finite()) {
        return (0.0, 0.0, 0.0);
    }
    let eigen = gram.symmetric_eigen();
    let whole = dot(left, left);
    let n = count as f64;
    // Of each principal direction: how strongly the effect moves it, and the square of what is there.
    let directions: Vec<(f64, f64)> = eigen
        .eigenvalues
        .iter()
        .enumerate()
        .filter(|(_, lambda)| **lambda > 1e-9)
        .map(|(k, lambda)| (*lambda, eigen.eigenvectors.column(k).dot(&right).powi(2) / lambda))
        .collect();
    let (mut best, mut sd) = ((0.0, 0.0, 0.0), LEAST_SD);
    while sd < GREATEST_SD {
        let (mut explained, mut width) = (0.0, 0.0);
        for (lambda, square) in &directions {
            let inflated = sd * sd * lambda;
            explained += square * inflated / (1.0 + inflated);
            width += (1.0 + inflated).ln();
        }
        let gain = n * (whole / (whole - explained).max(1e-9 * whole)).ln() - width;
        if gain > best.0 {
            best = (gain, sd, explained);
        }
        sd *= FACTOR;
    }
    best
}

#[cfg(test)]
mod tests {
    use super::{dot, fit_event_effects, random_effect};
    use crate::diagnose::hypothesis::multistart::fit_without_effects;
    use crate::diagnose::tests::zoo::in_swings;
    use rand::{Rng, SeedableRng};

    /// Forty directions, each moved by a draw of standard deviation .05 times a strength of 60 in noise of 1.
    #[test]
    fn the_spread_of_a_random_effect_is_found_and_noise_alone_has_none() {
        let mut draw = rand_chacha::ChaCha8Rng::seed_from_u64(5);
        let mut normal = || draw.sample::<f64, _>(rand_distr::StandardNormal);
        let mut left: Vec<f64> = (0..400).map(|_| normal()).collect();
        let columns: Vec<Vec<f64>> =
            (0..40).map(|k| (0..400).map(|i| if i == k { 60.0 } else { 0.0 }).collect()).collect();
        let (gain, ..) = random_effect(&columns, &left, 400);
        assert!(gain < 4.0, "{gain}");
        (0..40).for_each(|k| left[k] += 60.0 * 0.05 * normal());
        let (gain, sd, explained) = random_effect(&columns, &left, 400);
        assert!(gain > 30.0 && (sd - 0.05).abs() < 0.015, "{gain} {sd}");
        let rest = (dot(&left, &left) - explained) / 400.0;
        assert!((rest.sqrt() - 1.0).abs() < 0.15, "the noise is left: {rest}");
    }

    #[test]
    fn without_events_there_are_no_draws() {
        in_swings(&[], 1, 0, |context| {
            let base = fit_without_effects(context).unwrap();
            assert!(fit_event_effects(context, &base).unwrap().is_none());
        });
    }
}
