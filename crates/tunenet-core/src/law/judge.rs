//! Tests of a law: residual force, heterogeneity of recordings (Cochran's Q, 1954), and validation on held-out recordings.

use nalgebra::{DMatrix, DVector};

use super::ahead::Ahead;
use super::answer::Gates;
use super::evidence::{Shared, residual_force};
use super::information::{said, scaled};
use super::refit::{Law, Session};
use super::response::{Response, inverse_root};
use crate::Result;
use crate::estimate::Linearisation;
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
        held_out_gap: None,
        held_out_left: None,
        held_out_p: None,
        held_out_force_nats: None,
        held_out_differ_p: None,
        held_out_nats: None,
    };
    ahead.judge(session, response, law, &mut gates)?;
    Ok(gates)
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
