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

/// Shares of a held-out recording over which its initial state is fitted one after the other.
const GROWING: [f64; 3] = [0.15, 0.35, 0.65];

/// Recordings that were kept out of the fit.
pub(super) struct HeldOut<'a> {
    pub recordings: &'a [Prepared],
    pub noise: &'a [Vec<f64>],
}

/// Tests a law.
pub(super) fn judge(session: &Session, response: &Response, held_out: &HeldOut, law: &Law) -> Result<Gates> {
    let linear = session.linearise(response, law)?;
    let residual_force_nats = residual_force(response, &law.fit.residuals, linear.columns());
    let heterogeneity_p = (session.recordings.len() > 1).then(|| heterogeneity(&linear, &law.fit.residuals));
    let (mut held_out_ratio, mut held_out_base) = (None, None);
    if !held_out.recordings.is_empty() {
        let simulator = session.carrying(response, &law.terms, &law.numbers())?;
        let of = |simulator: &dyn Simulator, parameters: &[f64]| ahead(held_out, simulator, parameters, session.log);
        held_out_ratio = Some(of(simulator.as_ref(), &law.fit.point.parameters));
        let base = session.host.carrying(&[])?;
        held_out_base = Some(of(base.as_ref(), &session.base.point.parameters));
    }
    Ok(Gates { residual_force_nats, heterogeneity_p, held_out_ratio, held_out_base })
}

/// The root mean square of held-out residuals in units of the noise, of which only initial states are fitted, each recording on its own;
/// infinite where the simulator refuses.
fn ahead(held_out: &HeldOut, simulator: &dyn Simulator, parameters: &[f64], log: &RolloutLog) -> f64 {
    let (mut squares, mut freedom) = (0.0, 0_usize);
    for (recording, noise) in held_out.recordings.iter().zip(held_out.noise) {
        let (recordings, noise) = (std::slice::from_ref(recording), std::slice::from_ref(noise));
        let own = RolloutLog::default();
        let problem = Problem { simulator, recordings, noise, free: &[], log: Some(&own) };
        let start = || Point { parameters: parameters.to_vec(), ..Point::start(simulator, recordings) };
        let direct = problem.fit(start(), 1.0).ok();
        // A start that is guessed badly is found from the first samples on.
        let longer = |point: Point, horizon: &f64| Some(problem.fit(point, *horizon).ok()?.point);
        let grown = GROWING.iter().try_fold(start(), longer).and_then(|point| problem.fit(point, 1.0).ok());
        log.add(own.count());
        let Some(fit) = direct.into_iter().chain(grown).min_by(|a, b| a.cost.total_cmp(&b.cost)) else {
            return f64::INFINITY;
        };
        squares += fit.residuals.iter().flatten().map(|r| r * r).sum::<f64>();
        freedom += fit.residuals.iter().map(Vec::len).sum::<usize>().saturating_sub(recordings[0].nuisances.len());
    }
    (squares / freedom.max(1) as f64).sqrt()
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
