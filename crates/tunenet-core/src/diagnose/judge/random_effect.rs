//! Random effect of events (Laird and Ware 1982): every event has draws of its own from one normal distribution.
//!
//! The draws of a recording's events are nuisance parameters of the recording. The coefficient of the effect is their standard
//! deviation, on which no rollout depends. A random effect can imitate much, so it is tried last.

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use crate::Result;
use crate::diagnose::evidence::Evidence;
use crate::diagnose::evidence::recording::PreparedRecording;
use crate::diagnose::hypothesis::catalogue::carrier;
use crate::diagnose::hypothesis::context::{Context, EventEffects, Hypothesis};
use crate::diagnose::hypothesis::joint::Which;
use crate::estimate::information_criterion::p_value;
use crate::estimate::projection::Projector;
use crate::simulator::{Parameter, Preparation, Simulator};
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
    let of_recording = |(index, recording): (usize, &PreparedRecording)| -> Result<(Vec<Parameter>, Vec<Direction>)> {
        let simulator = &*carriers[recording.object];
        let draws = draws(simulator, recording)?;
        let columns = draw_columns(context, (model, index), simulator, draws.len())?;
        Ok((draws, directions(&columns, (&projector, index), &left)))
    };
    let found: Result<Vec<_>> = context.recordings().par_iter().enumerate().map(of_recording).collect();
    let (draws, directions): (Vec<_>, Vec<_>) = found?.into_iter().unzip();
    if draws.iter().all(Vec::is_empty) {
        return Ok(None);
    }
    let squares = dot(&left, &left);
    let (likelihood, sd, explained) = random_effect(&directions.concat(), squares, context.count());
    let rms = |squares: f64| (squares.max(0.0) / context.count() as f64).sqrt();
    let left = (rms(squares), rms(squares - explained));
    let gain = likelihood - (context.count() as f64).ln();
    // Half of the probability lies on the bound, where the standard deviation is 0.
    let p_value = (0.5 * p_value(likelihood, 1) * context.catalogue.len() as f64).min(1.0);
    Ok(Some(EventEffectFit { gain, p_value, sd, left, draws }))
}

/// The derivatives of the residuals of the recording `index` by this many draws, by one rollout for each.
fn draw_columns(
    context: &Context<'_>,
    (model, index): (&Hypothesis, usize),
    simulator: &dyn Simulator,
    draws: usize,
) -> Result<Vec<Vec<f64>>> {
    let recording = &context.recordings()[index];
    let base = model.structure.parameters(recording.object, &model.fit.point.parameters);
    let names = model.structure.simulator(recording.object).parameters();
    // The coefficient of the random effect itself keeps its absent value.
    let parameters: Vec<f64> = simulator
        .parameters()
        .iter()
        .map(|p| names.iter().position(|n| n.name == p.name).map_or(p.value, |i| base[i]))
        .collect();
    let at = |moved: Option<usize>| -> Result<Vec<f64>> {
        let draws = (0..draws).map(|k| if moved == Some(k) { STEP } else { 0.0 });
        let nuisances: Vec<f64> = model.fit.point.nuisances[index].iter().copied().chain(draws).collect();
        let values = (parameters.as_slice(), nuisances.as_slice());
        context.rollouts.predict_of((recording.object, simulator), &recording.prepared, values, recording.clock())
    };
    let unmoved = at(None)?;
    let column = |k: usize| -> Result<Vec<f64>> {
        let mut change: Vec<f64> = unmoved.iter().zip(&at(Some(k))?).map(|(a, b)| (a - b) / STEP).collect();
        recording.filter.apply(&mut change);
        Ok(change)
    };
    (0..draws).map(column).collect()
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

/// A principal direction of the draws of one recording, without what shared parameters explain of it.
#[derive(Debug, Clone)]
struct Direction {
    /// How much a draw of size 1 along it moves the residuals, squared.
    square: f64,
    /// Its product with what is left.
    along: f64,
    /// Its products with the directions of the shared parameters.
    shared: DVector<f64>,
}

/// The principal directions of a recording's draws, whose derivatives have no product with one another; none where a number is not finite.
fn directions(columns: &[Vec<f64>], (projector, index): (&Projector, usize), left: &[f64]) -> Vec<Direction> {
    if columns.is_empty() {
        return Vec::new();
    }
    let left = &left[projector.range(index)];
    let columns: Vec<Vec<f64>> = columns.iter().map(|column| projector.without_nuisances(index, column)).collect();
    let size = columns.len();
    let gram = DMatrix::from_fn(size, size, |i, j| dot(&columns[i], &columns[j]));
    let along = DVector::from_fn(size, |i, _| dot(&columns[i], left));
    let shared: Vec<Vec<f64>> = columns.iter().map(|column| projector.along_shared(index, column)).collect();
    let shared = DMatrix::from_fn(shared.first().map_or(0, Vec::len), size, |i, j| shared[j][i]);
    if gram.iter().chain(&along).chain(&shared).any(|v| !v.is_finite()) {
        return Vec::new();
    }
    let eigen = gram.symmetric_eigen();
    let direction = |k: usize| {
        let axis = eigen.eigenvectors.column(k);
        Direction { square: eigen.eigenvalues[k].max(0.0), along: along.dot(&axis), shared: &shared * axis }
    };
    (0..size).map(direction).collect()
}

/// Twice the gain in marginal logarithmic likelihood by a random effect with these directions, its standard deviation in the draws' unit, and
/// how much of the sum of squares its draws explain; `squares` is the sum of what is left, and `count` values have noise of unit size or a
/// common multiple of it.
///
/// The draws of a recording are its own, so that the covariance has a block for each; shared parameters couple these, by the matrix inversion
/// lemma and the lemma of its determinant (Rasmussen and Williams 2006, A.3). Time in proportion to the number of directions.
fn random_effect(directions: &[Direction], squares: f64, count: usize) -> (f64, f64, f64) {
    let shared = directions.first().map_or(0, |direction| direction.shared.len());
    let n = count as f64;
    let (mut best, mut sd) = ((0.0, 0.0, 0.0), LEAST_SD);
    while sd < GREATEST_SD {
        let (mut explained, mut width) = (0.0, 0.0);
        let (mut inner, mut right) = (DMatrix::identity(shared, shared), DVector::zeros(shared));
        for Direction { square, along, shared } in directions {
            let inflated = sd * sd / (1.0 + sd * sd * square);
            explained += inflated * along * along;
            width += (sd * sd * square).ln_1p();
            inner.ger(-inflated, shared, shared, 1.0);
            right.axpy(inflated * along, shared, 1.0);
        }
        // Where rounding leaves the matrix without a Cholesky factor, nothing is gained.
        if let Some(factor) = inner.cholesky() {
            explained += right.dot(&factor.solve(&right));
            width += 2.0 * factor.l_dirty().diagonal().iter().map(|d| d.ln()).sum::<f64>();
            let gain = n * (squares / (squares - explained).max(1e-9 * squares)).ln() - width;
            if gain > best.0 {
                best = (gain, sd, explained);
            }
        }
        sd *= FACTOR;
    }
    best
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::hypothesis::multistart::fit_without_effects;
    use crate::diagnose::tests::zoo::in_swings;
    use crate::estimate::jacobian::Columns;
    use rand::{Rng, SeedableRng};

    /// Forty directions, each moved by a draw of standard deviation 0.05 times a strength of 60 in noise of 1.
    #[test]
    fn the_spread_of_a_random_effect_is_found_and_noise_alone_has_none() {
        let mut draw = rand_chacha::ChaCha8Rng::seed_from_u64(5);
        let mut normal = || draw.sample::<f64, _>(rand_distr::StandardNormal);
        let mut left: Vec<f64> = (0..400).map(|_| normal()).collect();
        let along = |left: &[f64]| -> Vec<Direction> {
            let one = |k: usize| Direction { square: 3600.0, along: 60.0 * left[k], shared: DVector::zeros(0) };
            (0..40).map(one).collect()
        };
        let (gain, ..) = random_effect(&along(&left), dot(&left, &left), 400);
        assert!(gain < 4.0, "{gain}");
        (0..40).for_each(|k| left[k] += 60.0 * 0.05 * normal());
        let (gain, sd, explained) = random_effect(&along(&left), dot(&left, &left), 400);
        assert!(gain > 30.0 && (sd - 0.05).abs() < 0.015, "{gain} {sd}");
        let rest = (dot(&left, &left) - explained) / 400.0;
        assert!((rest.sqrt() - 1.0).abs() < 0.15, "the noise is left: {rest}");
    }

    /// Two recordings with a nuisance parameter and two draws each, and two shared parameters: as by dense matrices of all projected columns.
    #[test]
    fn directions_of_each_recording_and_dense_matrices_agree() {
        let wave =
            |seed: f64, length: usize| -> Vec<f64> { (0..length).map(|i| (seed + 1.7 * i as f64).sin()).collect() };
        let lengths = [9, 7];
        let of = |at: usize| Columns {
            indices: vec![0, 1],
            shared: vec![wave(0.3 + at as f64, lengths[at]), wave(2.1 * at as f64, lengths[at])],
            nuisances: vec![vec![1.0; lengths[at]]],
        };
        let projector = Projector::new(&[of(0), of(1)], &lengths, 2);
        let draws = [0, 1].map(|at| [4.0, 5.3].map(|seed| wave(seed * (1.0 + at as f64), lengths[at])));
        let mut left = wave(0.9, 16);
        projector.project(&mut left);
        let found: Vec<Direction> = (0..2).flat_map(|at| directions(&draws[at], (&projector, at), &left)).collect();
        assert!(directions(&[], (&projector, 0), &left).is_empty(), "a recording without events has no draws");
        let squares = dot(&left, &left);
        let (gain, sd, explained) = random_effect(&found, squares, 16);
        let stacked = [0, 1].map(|at| {
            draws[at].clone().map(|draw| {
                let mut column = [vec![0.0; 9 * at], draw, vec![0.0; 7 * (1 - at)]].concat();
                projector.project(&mut column);
                DVector::from_vec(column)
            })
        });
        let columns = DMatrix::from_columns(&stacked.concat());
        let spread = DMatrix::identity(16, 16) + &columns * columns.transpose() * (sd * sd);
        let r = DVector::from_vec(left);
        let factor = spread.cholesky().unwrap();
        let rest = r.dot(&factor.solve(&r));
        assert!((squares - explained - rest).abs() < 1e-9 * squares, "{explained} {rest} {squares}");
        let wanted = 16.0 * (squares / rest).ln() - factor.determinant().ln();
        assert!(gain > 0.0 && (gain - wanted).abs() < 1e-9 * wanted.abs().max(1.0), "{gain} {wanted}");
    }

    #[test]
    fn without_events_there_are_no_draws() {
        in_swings(&[], 1, 0, |context| {
            let base = fit_without_effects(context).unwrap();
            assert!(fit_event_effects(context, &base).unwrap().is_none());
        });
    }
}
