//! Tests of a law: residual force, heterogeneity of recordings (Cochran's Q, 1954), and validation on held-out recordings.

use nalgebra::{DMatrix, DVector};

use super::answer::Gates;
use super::evidence::residual_force;
use super::refit::{Law, Session};
use super::response::{Response, inverse_root};
use crate::Result;
use crate::estimate::{Linearisation, Point, Problem, RolloutLog};
use crate::simulator::{Prepared, Simulator};
use crate::statistics::upper_chi_squared;

/// Residual force, in nats: odds of twenty to one.
pub(super) const MOST_FORCE: f64 = 3.0;
/// Probability of recordings that differ so much by chance.
pub(super) const LEAST_PROBABILITY: f64 = 1e-3;
/// Error on held-out recordings over the noise.
const MOST_HELD_OUT: f64 = 1.05;
/// Where few values are held out, noise alone exceeds that in more than one case of twenty: a normal quantile.
const ONE_IN_TWENTY: f64 = 1.645;

/// Recordings that were kept out of the fit.
pub(super) struct HeldOut<'a> {
    pub recordings: &'a [Prepared],
    pub noise: &'a [Vec<f64>],
}

/// Tests a law.
pub(super) fn judge(session: &Session, response: &Response, held_out: &HeldOut, law: &mut Law) -> Result<Gates> {
    let linear = session.linearise(response, law)?;
    let residual = response.coordinates(&law.fit.residuals);
    let shared = linear.columns().first().map_or(0, |c| c.shared.len());
    let tangents: Vec<DVector<f64>> = (0..shared)
        .map(|j| response.tangent(&linear.columns().iter().map(|c| c.shared[j].clone()).collect::<Vec<_>>()))
        .collect();
    let residual_force_nats = residual_force(response, &residual, &tangents);
    let heterogeneity_p = (session.recordings.len() > 1).then(|| heterogeneity(&linear, &law.fit.residuals));
    let (mut held_out_ratio, mut held_out_base) = (None, None);
    if !held_out.recordings.is_empty() {
        let simulator = session.carrying(response, &law.terms, &law.numbers())?;
        let values: usize = law.fit.residuals.iter().map(Vec::len).sum();
        let own: usize = session.recordings.iter().map(|r| r.nuisances.len()).sum::<usize>() + shared;
        let squares: f64 = law.fit.residuals.iter().flatten().map(|r| r * r).sum();
        // The noise is an estimate as well: the fit that is tested says what it is, where it leaves more.
        let noise = (squares / values.saturating_sub(own).max(1) as f64).sqrt().clamp(1.0, 1.05);
        let of = |simulator: &dyn Simulator, parameters: &[f64]| ahead(held_out, simulator, parameters, session.log);
        held_out_ratio = Some(of(simulator.as_ref(), &law.fit.point.parameters) / noise);
        let base = session.host.carrying(&[])?;
        held_out_base = Some(of(base.as_ref(), &session.base.point.parameters));
    }
    let values: usize = held_out.recordings.iter().map(|r| r.seen.values().len()).sum();
    let by_chance = 1.0 + ONE_IN_TWENTY / (2.0 * values.max(1) as f64).sqrt();
    let held_out_limit = MOST_HELD_OUT.max(by_chance);
    Ok(Gates { residual_force_nats, heterogeneity_p, held_out_ratio, held_out_base, held_out_limit })
}

/// The root mean square of held-out residuals in units of the noise, of which only initial states are fitted; infinite where the
/// simulator refuses.
fn ahead(held_out: &HeldOut, simulator: &dyn Simulator, parameters: &[f64], log: &RolloutLog) -> f64 {
    let own = RolloutLog::default();
    let problem =
        Problem { simulator, recordings: held_out.recordings, noise: held_out.noise, free: &[], log: Some(&own) };
    let mut point = Point::start(simulator, held_out.recordings);
    point.parameters = parameters.to_vec();
    let direct = problem.fit(point.clone(), 1.0).ok();
    let grown = problem.fit(point, 0.45).ok().and_then(|fit| problem.fit(fit.point, 1.0).ok());
    log.add(own.count());
    let best = direct.into_iter().chain(grown).min_by(|a, b| a.cost.total_cmp(&b.cost));
    let Some(fit) = best else { return f64::INFINITY };
    let values: usize = fit.residuals.iter().map(Vec::len).sum();
    let fitted: usize = held_out.recordings.iter().map(|r| r.nuisances.len()).sum();
    let squares: f64 = fit.residuals.iter().flatten().map(|r| r * r).sum();
    (squares / values.saturating_sub(fitted).max(1) as f64).sqrt()
}

/// The probability that shared parameters differ so much from recording to recording by chance.
fn heterogeneity(linear: &Linearisation, residuals: &[Vec<f64>]) -> f64 {
    let shared = linear.columns().first().map_or(0, |c| c.shared.len());
    let (mut q, mut freedom) = (0.0, 0);
    let (mut sum_s, mut sum) = (DMatrix::zeros(shared, shared), DVector::zeros(shared));
    for (columns, residual) in linear.columns().iter().zip(residuals) {
        let rows = residual.len();
        let matrix = |of: &[Vec<f64>]| DMatrix::from_fn(rows, of.len(), |i, j| of[j][i]);
        let own = matrix(&columns.nuisances);
        let own = &own * inverse_root(&(own.transpose() * &own));
        let clean = |m: DMatrix<f64>| {
            let explained = &own * (own.transpose() * &m);
            m - explained
        };
        let (c, r) = (clean(matrix(&columns.shared)), clean(DMatrix::from_column_slice(rows, 1, residual)));
        let (information, score) = (c.transpose() * &c, (c.transpose() * r).column(0).into_owned());
        let root = inverse_root(&information);
        q += (root.transpose() * &score).norm_squared();
        freedom += root.ncols();
        sum_s += information;
        sum += score;
    }
    let root = inverse_root(&sum_s);
    q -= (root.transpose() * sum).norm_squared();
    freedom = freedom.saturating_sub(root.ncols());
    if freedom == 0 { 1.0 } else { upper_chi_squared(q.max(0.0), freedom as f64) }
}
