//! Tests of a law: residual force, heterogeneity of recordings (Cochran's Q, 1954), and validation on held-out recordings.

use nalgebra::{DMatrix, DVector};

use super::ahead::Ahead;
use super::answer::Gates;
use super::evidence::{Shared, residual_force};
use super::refit::{Law, Session};
use super::response::{Response, inverse_root};
use crate::Result;
use crate::estimate::Linearisation;
use crate::estimate::jacobian::Columns;
use crate::statistics::upper_chi_squared;

/// Tests a law.
pub(super) fn judge(session: &Session, response: &Response, ahead: &mut Ahead, law: &Law) -> Result<Gates> {
    let linear = session.linearise(response, law)?;
    let residuals = scaled(&law.fit.residuals, session.scale(law));
    let residual_force_nats = residual_force(response, &residuals, linear.columns(), Shared::Free);
    let heterogeneity_p = (session.recordings.len() > 1).then(|| heterogeneity(&linear, &residuals));
    let mut gates = Gates {
        residual_force_nats,
        heterogeneity_p,
        held_out_ratio: None,
        held_out_base: None,
        held_out_p: None,
        held_out_force_nats: None,
        held_out_differ_p: None,
    };
    ahead.judge(session, response, law, &mut gates)?;
    Ok(gates)
}

/// Residuals in units of what a law leaves.
pub(super) fn scaled(residuals: &[Vec<f64>], scale: f64) -> Vec<Vec<f64>> {
    residuals.iter().map(|all| all.iter().map(|r| r / scale).collect()).collect()
}

/// What a recording says of shared parameters, its own ones fitted: the information, and the slope.
pub(super) fn said(columns: &Columns, residual: &[f64]) -> (DMatrix<f64>, DVector<f64>) {
    let rows = residual.len();
    let matrix = |of: &[Vec<f64>]| DMatrix::from_fn(rows, of.len(), |i, j| of[j][i]);
    let own = matrix(&columns.nuisances);
    let own = &own * inverse_root(&(own.transpose() * &own));
    let clean = |m: DMatrix<f64>| {
        let explained = &own * (own.transpose() * &m);
        m - explained
    };
    let (c, r) = (clean(matrix(&columns.shared)), clean(DMatrix::from_column_slice(rows, 1, residual)));
    (c.transpose() * &c, (c.transpose() * r).column(0).into_owned())
}

/// The probability that shared parameters differ so much from recording to recording by chance.
fn heterogeneity(linear: &Linearisation, residuals: &[Vec<f64>]) -> f64 {
    let shared = linear.columns().first().map_or(0, |c| c.shared.len());
    let (mut q, mut freedom) = (0.0, 0);
    let (mut sum_s, mut sum) = (DMatrix::zeros(shared, shared), DVector::zeros(shared));
    for (columns, residual) in linear.columns().iter().zip(residuals) {
        let (information, score) = said(columns, residual);
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
