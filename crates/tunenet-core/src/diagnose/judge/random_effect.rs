//! Random effect of contacts (Laird and Ware 1982): every contact turned by its own small tilt.
//!
//! No coefficient rolls it out. A recording brings the tilt of each contact as nuisance parameters, all drawn from one normal
//! distribution whose standard deviation is the coefficient (a random effect, Laird and Ware 1982). It can imitate much,
//! so it is tried last.

use nalgebra::{DMatrix, DVector};

use crate::Result;
use crate::diagnose::evidence::Evidence;
use crate::diagnose::evidence::recording::Set;
use crate::diagnose::hypothesis::catalogue::carrier;
use crate::diagnose::hypothesis::context::{Context, Hypothesis, RandomTilts};
use crate::diagnose::hypothesis::joint::Which;
use crate::estimate::information_criterion::p_value;
use crate::estimate::projection::Projector;
use crate::simulator::{Parameter, Preparation, Simulator, predict};
use crate::statistics::dot;

/// Step of a tilt for its derivative, rad.
const STEP_RAD: f64 = 1e-4;
/// Standard deviations that are tried, rad: a grid by this factor.
const LEAST_RAD: f64 = 1e-4;
const GREATEST_RAD: f64 = 0.5;
const FACTOR: f64 = 1.15;

/// What chance at contacts would explain.
#[derive(Debug, Clone)]
pub(in crate::diagnose) struct RandomTiltFit {
    /// Gain of the information criterion.
    pub gain: f64,
    /// Probability of that by chance of the noise, all candidates counted.
    pub p_value: f64,
    /// Standard deviation of a tilt, rad.
    pub sd: f64,
    /// The tilts of each recording.
    pub unknowns: Vec<Vec<Parameter>>,
}

/// What random tilts add to `model`: the gain in marginal likelihood, the tilts integrated out.
///
/// With residuals r of which the model's nuisance parameters and shared parameters are projected out, and the tilts' projected
/// columns H, r ~ N(0, v (I + s H Hᵀ)); the variance v is profiled, s found on a grid.
pub(in crate::diagnose) fn random_tilts(context: &Context<'_>, model: &Hypothesis) -> Result<Option<RandomTiltFit>> {
    let Some(chance) = context.chance_entry() else { return Ok(None) };
    let entries: Vec<_> = model.structure.effects.iter().map(|&e| &context.catalogue[e]).chain([chance]).collect();
    let mut carriers = Vec::new();
    for subject in context.subjects {
        carriers.push(carrier(subject, &entries)?);
    }
    let joint = context.joint(&model.structure);
    let residuals = &model.fit.residuals;
    let columns = joint.columns(&model.fit.point, residuals, Which::ALL);
    let lengths: Vec<usize> = residuals.iter().map(Vec::len).collect();
    let projector = Projector::new(&columns, &lengths, model.structure.globals.len());
    let mut left = residuals.concat();
    projector.project(&mut left);
    let total = left.len();
    let (mut stacked, mut unknowns, mut begin) = (Vec::new(), Vec::new(), 0);
    for (d, set) in context.sets().iter().enumerate() {
        let simulator = &*carriers[set.object];
        let tilts = tilts(simulator, set)?;
        let base = model.structure.parameters(set.object, &model.fit.point.parameters);
        let names = model.structure.simulator(set.object).parameters();
        // The coefficient of chance itself stays at its absent value.
        let parameters: Vec<f64> = simulator
            .parameters()
            .iter()
            .map(|p| names.iter().position(|n| n.name == p.name).map_or(p.value, |i| base[i]))
            .collect();
        let nuisances = |tilted: Option<usize>| -> Vec<f64> {
            let tilts = (0..tilts.len()).map(|k| if tilted == Some(k) { STEP_RAD } else { 0.0 });
            model.fit.point.nuisances[d].iter().copied().chain(tilts).collect()
        };
        context.rollouts.spend()?;
        let straight = predict(simulator, &set.prepared, &parameters, &nuisances(None), set.clock())?;
        for k in 0..tilts.len() {
            context.rollouts.spend()?;
            let tilted = predict(simulator, &set.prepared, &parameters, &nuisances(Some(k)), set.clock())?;
            let mut change: Vec<f64> = straight.iter().zip(&tilted).map(|(a, b)| (a - b) / STEP_RAD).collect();
            set.filter.apply(&mut change);
            let mut column = vec![0.0; total];
            column[begin..begin + change.len()].copy_from_slice(&change);
            projector.project(&mut column);
            stacked.push(column);
        }
        begin += lengths[d];
        unknowns.push(tilts);
    }
    if stacked.is_empty() {
        return Ok(None);
    }
    let (likelihood, sd) = random_effect(&stacked, &left, context.count());
    let gain = likelihood - (context.count() as f64).ln();
    // Half of the chance lies on the bound at which there is no scatter.
    let p_value = (0.5 * p_value(likelihood, 1) * context.catalogue.len() as f64).min(1.0);
    Ok(Some(RandomTiltFit { gain, p_value, sd, unknowns }))
}

/// The context in which every recording has these tilts as nuisance parameters, drawn towards 0 by their standard deviation.
///
/// # Errors
/// Where a held-out recording cannot be prepared.
pub(in crate::diagnose) fn admit<'a>(context: &Context<'a>, scatter: &RandomTiltFit) -> Result<Context<'a>> {
    let entries: Vec<_> = context.chance_entry().into_iter().collect();
    let mut evidence = Evidence::clone(&context.evidence);
    for set in &mut evidence.validation {
        let tilts = tilts(&*carrier(&context.subjects[set.object], &entries)?, set)?;
        set.random_draws = tilts.len();
        set.prior_sd.extend(tilts.iter().map(|_| scatter.sd));
        set.prepared.nuisances.extend(tilts);
    }
    for (set, tilts) in evidence.training.iter_mut().zip(&scatter.unknowns) {
        set.random_draws = tilts.len();
        set.prior_sd.extend(tilts.iter().map(|_| scatter.sd));
        set.prepared.nuisances.extend(tilts.iter().cloned());
    }
    let count = scatter.unknowns.iter().map(Vec::len).sum();
    Ok(Context { random_tilts: Some(RandomTilts { sd_rad: scatter.sd, count }), ..context.with_evidence(evidence) })
}

/// The tilts that a recording brings to a simulator that scatters.
fn tilts(simulator: &dyn Simulator, set: &Set) -> Result<Vec<Parameter>> {
    Ok(match simulator.prepare(&set.prepared.seen)? {
        Preparation::Usable(prepared) => prepared.nuisances.into_iter().skip(set.prepared.nuisances.len()).collect(),
        Preparation::Rejected(_) => Vec::new(),
    })
}

/// Twice the gain in marginal logarithmic likelihood by a random effect with these columns, and its standard deviation in
/// the columns' unit; `count` values have noise of unit size or a common multiple of it.
fn random_effect(columns: &[Vec<f64>], left: &[f64], count: usize) -> (f64, f64) {
    let size = columns.len();
    let gram = DMatrix::from_fn(size, size, |i, j| dot(&columns[i], &columns[j]));
    let right = DVector::from_fn(size, |i, _| dot(&columns[i], left));
    if gram.iter().chain(right.iter()).any(|v| !v.is_finite()) {
        return (0.0, 0.0);
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
    let (mut best, mut best_sd, mut sd) = (0.0, 0.0, LEAST_RAD);
    while sd < GREATEST_RAD {
        let (mut explained, mut width) = (0.0, 0.0);
        for (lambda, square) in &directions {
            let inflated = sd * sd * lambda;
            explained += square * inflated / (1.0 + inflated);
            width += (1.0 + inflated).ln();
        }
        let gain = n * (whole / (whole - explained).max(1e-9 * whole)).ln() - width;
        if gain > best {
            (best, best_sd) = (gain, sd);
        }
        sd *= FACTOR;
    }
    (best, best_sd)
}

#[cfg(test)]
mod tests {
    use super::{random_effect, random_tilts};
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
        let (gain, _) = random_effect(&columns, &left, 400);
        assert!(gain < 4.0, "{gain}");
        (0..40).for_each(|k| left[k] += 60.0 * 0.05 * normal());
        let (gain, sd) = random_effect(&columns, &left, 400);
        assert!(gain > 30.0 && (sd - 0.05).abs() < 0.015, "{gain} {sd}");
    }

    #[test]
    fn what_knows_no_contacts_has_no_tilts() {
        in_swings(&[], 1, 0, |context| {
            let base = fit_without_effects(context).unwrap();
            assert!(random_tilts(context, &base).unwrap().is_none());
        });
    }
}
