//! Tests of a law: residual force, heterogeneity of recordings (Cochran's Q, 1954), the score at bounds, and validation on held-out
//! recordings.

use nalgebra::{DMatrix, DVector};

use super::ahead::Ahead;
use super::evidence::{Shared, residual_force};
use super::gates::Gates;
use super::information::{said, scaled};
use super::refit::{Law, Session};
use super::response::{Response, inverse_root};
use crate::Result;
use crate::statistics::upper_chi_squared;

/// Tests a law.
pub(super) fn judge(session: &Session, response: &Response, ahead: &mut Ahead, law: &Law) -> Result<Gates> {
    let linear = session.linearise(response, law)?;
    let residuals = scaled(&session.cleaned(&law.fit.residuals), session.scale(law));
    let residual_force_nats = residual_force(response, &residuals, linear.columns(), Shared::Free);
    let each: Vec<_> = linear.columns().iter().zip(&residuals).map(|(columns, left)| said(columns, left)).collect();
    let heterogeneity_p = (session.recordings.len() > 1).then(|| heterogeneity(&each));
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
        beyond_bound: beyond_bound(&each, &session.outward(law)?),
    };
    ahead.judge(session, response, law, &mut gates)?;
    Ok(gates)
}

/// The probability that shared parameters differ so much from recording to recording by chance; what each of these says.
fn heterogeneity(each: &[(DMatrix<f64>, DVector<f64>)]) -> f64 {
    let (mut q, mut freedom) = (0.0, 0);
    for (information, score) in each {
        let root = inverse_root(information);
        q += (root.transpose() * score).norm_squared();
        freedom += root.ncols();
    }
    let (information, score) = together(each);
    let root = inverse_root(&information);
    q -= (root.transpose() * score).norm_squared();
    freedom = freedom.saturating_sub(root.ncols());
    if freedom == 0 { 1.0 } else { upper_chi_squared(q.max(0.0), freedom as f64) }
}

fn together(each: &[(DMatrix<f64>, DVector<f64>)]) -> (DMatrix<f64>, DVector<f64>) {
    let shared = each.first().map_or(0, |(_, score)| score.len());
    let none = (DMatrix::zeros(shared, shared), DVector::zeros(shared));
    each.iter().fold(none, |(information, score), (own, slope)| (information + own, score + slope))
}

/// How far recordings favour values beyond bounds, in standard deviations of the step that leads to the greatest likelihood (the score test,
/// Rao 1948): the greatest over the parameters, of which `outward` says by -1 or 1 at which bound they lie, and by 0 that they lie within.
fn beyond_bound(each: &[(DMatrix<f64>, DVector<f64>)], outward: &[f64]) -> f64 {
    let (information, score) = together(each);
    let root = inverse_root(&information);
    let covariance = &root * root.transpose();
    let step = &covariance * score;
    let beyond = outward.iter().enumerate().filter(|(_, side)| **side != 0.0).map(|(k, side)| {
        let deviation = covariance[(k, k)].sqrt();
        // The columns are derivatives of what is left, which falls along the step.
        if deviation > 0.0 { -side * step[k] / deviation } else { 0.0 }
    });
    beyond.fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two recordings that say 1 ± 1 and 3 ± 1 of one parameter: Q is 2, and together they say 4 of a deviation of 1/√2.
    #[test]
    fn recordings_that_differ_and_a_bound_that_they_exceed() {
        let one = |score: f64| (DMatrix::from_element(1, 1, 1.0), DVector::from_element(1, score));
        let each = [one(-1.0), one(-3.0)];
        assert!((heterogeneity(&each) - upper_chi_squared(2.0, 1.0)).abs() < 1e-12);
        assert!((beyond_bound(&each, &[1.0]) - 2.0 * 2.0_f64.sqrt()).abs() < 1e-12);
        assert_eq!(beyond_bound(&each, &[-1.0]), 0.0);
        assert_eq!(beyond_bound(&each, &[0.0]), 0.0);
    }
}
