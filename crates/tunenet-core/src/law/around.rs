//! Linearisation about a fit (Ljung 1999, section 4.5): where fits of laws begin, and derivatives with which they begin without rollouts.

use std::sync::atomic::Ordering;

use rayon::prelude::*;

use super::linear::Candidate;
use super::refit::{Law, Session};
use super::response::{Fitted, Response};
use super::space::Carried;
use super::term::Term;
use crate::Result;
use crate::estimate::jacobian::Columns;
use crate::estimate::{Linearisation, Point, RolloutLog};

/// How many fits begin before the rollouts are counted.
const AT_A_TIME: usize = 8;
/// Steps of differences, as shares.
pub(super) const DIFFERENCE: f64 = 1e-4;

/// A fit of the base model or of a law, and how the recordings answer to an acceleration there.
pub(super) struct Around {
    pub response: Response,
    /// Derivatives by the base model's parameters and by initial states.
    pub columns: Vec<Columns>,
    /// The base model's parameters and initial states.
    pub point: Point,
}

impl Around {
    /// About paths that follow the recordings by a force of their own.
    pub fn paths(response: Response, columns: Vec<Columns>, point: Point) -> Self {
        Self { response, columns, point }
    }

    /// About the base model.
    pub fn base(session: &Session, log: &RolloutLog) -> Result<Self> {
        let columns = session.linear.columns();
        Self::measured(session, &session.base, columns.to_vec(), (&[], &[]), log)
    }

    /// About a law: what distinguishes it from others that explain the recordings as well is small, so that the linear answer to it
    /// is exact to first order.
    pub fn law(session: &Session, near: &Self, law: &Law) -> Result<Self> {
        let linear = session.linearise(&near.response, law)?;
        let columns = linear.columns().iter().map(|one| {
            let kept = one.indices.iter().filter(|index| **index < law.first).count();
            Columns {
                indices: one.indices[..kept].to_vec(),
                shared: one.shared[..kept].to_vec(),
                nuisances: one.nuisances.clone(),
            }
        });
        let numbers = law.numbers();
        let carried = session.carried(&near.response, &law.terms, &numbers);
        Self::measured(session, &law.fit, columns.collect(), (&carried, &numbers), session.log)
    }

    fn measured(
        session: &Session,
        fit: &crate::estimate::Fit,
        columns: Vec<Columns>,
        (law, numbers): (&[Carried], &[Vec<f64>]),
        log: &RolloutLog,
    ) -> Result<Self> {
        let (recordings, noise) = (session.recordings, session.noise);
        let (point, residuals) = (&fit.point, fit.residuals.as_slice());
        let all = Fitted::each(recordings, noise, (point, residuals), (law, numbers));
        let response = Response::measure(session.host, &all, &columns, log)?.counting(session.count);
        let mut point = fit.point.clone();
        point.parameters.truncate(session.base.point.parameters.len());
        Ok(Self { response, columns, point })
    }

    /// Derivatives of the residuals with these terms, which follow `first` parameters of the base model.
    pub fn known(&self, first: usize, terms: &[Term], numbers: &[Vec<f64>]) -> Linearisation {
        let mut columns = self.columns.clone();
        let mut at = first;
        for (term, values) in terms.iter().zip(numbers) {
            let still = self.response.answer(term, values);
            for i in 0..values.len() {
                let mut moved = values.clone();
                let step = DIFFERENCE * moved[i].abs().max(1e-3);
                moved[i] += step;
                let answers = self.response.answer(term, &moved);
                for ((one, moved), still) in columns.iter_mut().zip(answers).zip(&still) {
                    one.indices.push(at);
                    one.shared.push(moved.iter().zip(still).map(|(m, s)| (s - m) / step).collect());
                }
                at += 1;
            }
        }
        Linearisation::known(columns)
    }

    /// Where the base model's parameters and the initial states lead to with a candidate.
    pub fn start(&self, session: &Session, candidate: &Candidate) -> Result<Point> {
        let mut residuals = self.response.without.clone();
        for (term, numbers) in candidate.terms.iter().zip(&candidate.numbers) {
            for (all, change) in residuals.iter_mut().zip(self.response.answer(term, numbers)) {
                all.iter_mut().zip(change).for_each(|(r, c)| *r -= c);
            }
        }
        session.stepped(&self.point, &self.columns, &residuals)
    }
}

impl Session<'_> {
    /// Fits of candidates with so many steps and measured derivatives, a few at a time, until the search has used its share of the rollouts.
    pub fn fits(&self, around: &Around, candidates: &[Candidate], effort: (usize, usize)) -> Vec<Law> {
        let mut found = Vec::new();
        for few in candidates.chunks(AT_A_TIME) {
            if !self.within() {
                self.short.store(true, Ordering::Relaxed);
                break;
            }
            found.par_extend(few.par_iter().filter_map(|candidate| self.fit(around, candidate, effort)));
        }
        found
    }

    /// Fits a candidate of a linear search; nothing where the simulator refuses it.
    pub fn fit(&self, around: &Around, candidate: &Candidate, effort: (usize, usize)) -> Option<Law> {
        let (terms, numbers) = (&candidate.terms, &candidate.numbers);
        let led = around.start(self, candidate).ok().and_then(|start| self.from(around, terms, numbers, start, effort));
        // A linearisation that reaches too far ends in a refusal; the values where it was made do not.
        led.or_else(|| self.from(around, terms, numbers, around.point.clone(), effort))
    }

    /// Fits terms from these numbers, and the base model's values from those of `start`.
    pub fn from(
        &self,
        around: &Around,
        terms: &[Term],
        numbers: &[Vec<f64>],
        start: Point,
        effort: (usize, usize),
    ) -> Option<Law> {
        let first = self.base.point.parameters.len();
        let known = around.known(first, terms, numbers);
        self.fitted(&around.response, (terms, numbers), start, Some(&known), effort)
    }
}
