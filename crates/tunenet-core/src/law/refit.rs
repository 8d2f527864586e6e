//! Output-error fits of laws (Ljung 1999, section 7.2): through rollouts, starts and parameters of the simulator fitted with them.

use super::linear::Candidate;
use super::price;
use super::response::Response;
use super::space::{Host, Visiting};
use super::term::Term;
use crate::Result;
use crate::estimate::huber::huber_cost;
use crate::estimate::{Fit, Linearisation, Point, Problem, RolloutLog, free};
use crate::simulator::{Prepared, Simulator};

/// How far the bounds of a coefficient reach, in units of what the linear stage found.
const REACH: f64 = 40.0;

/// A law that was fitted through rollouts.
#[derive(Debug, Clone)]
pub(super) struct Law {
    pub terms: Vec<Term>,
    pub fit: Fit,
    /// Where its numbers begin among the parameters.
    pub first: usize,
    /// What it gains in the information criterion, and with the price of its structure.
    pub bic: f64,
    pub score: f64,
}

impl Law {
    /// The numbers of each term.
    pub fn numbers(&self) -> Vec<Vec<f64>> {
        let mut at = self.first;
        let each = self.terms.iter().map(|term| {
            at += term.constants();
            self.fit.point.parameters[at - term.constants()..at].to_vec()
        });
        each.collect()
    }

    /// Standard deviations of all its numbers.
    pub fn deviations(&self) -> Vec<f64> {
        let count = price::constants(&self.terms);
        let all = self.fit.covariance.nrows();
        (all - count..all).map(|i| self.fit.covariance[(i, i)].max(0.0).sqrt()).collect()
    }
}

/// What all fits share.
pub(super) struct Session<'a> {
    pub host: &'a dyn Host,
    pub recordings: &'a [Prepared],
    pub noise: &'a [Vec<f64>],
    pub log: &'a RolloutLog,
    pub base: Fit,
    pub linear: Linearisation,
    /// The base model's free parameters.
    pub free: Vec<usize>,
    pub squares: f64,
    pub count: usize,
    /// How many factors there are to choose from.
    pub factors: usize,
    variants: std::sync::atomic::AtomicUsize,
}

/// Shares of the recordings over which the base model is fitted one after the other, so that it ends in the right minimum.
const HORIZONS: [f64; 3] = [0.45, 0.7, 1.0];

impl<'a> Session<'a> {
    /// Fits the base model.
    pub fn new(
        host: &'a dyn Host,
        recordings: &'a [Prepared],
        noise: &'a [Vec<f64>],
        log: &'a RolloutLog,
    ) -> Result<Self> {
        let simulator = host.carrying(&[])?;
        let free = free(simulator.parameters(), recordings);
        let problem = Problem { simulator: simulator.as_ref(), recordings, noise, free: &free, log: Some(log) };
        let mut point = Point::start(simulator.as_ref(), recordings);
        let mut base = None;
        for horizon in HORIZONS {
            let fit = problem.fit(point.clone(), horizon)?;
            point = fit.point.clone();
            base = Some(fit);
        }
        // Growing horizons may end in another minimum than the first guesses do.
        let direct = problem.fit(Point::start(simulator.as_ref(), recordings), 1.0);
        let mut base = match (base, direct) {
            (Some(grown), Ok(direct)) if grown.cost <= direct.cost => grown,
            (Some(grown), Err(_)) => grown,
            (_, direct) => direct?,
        };
        let linear = problem.settle(&mut base)?;
        let (squares, count) = (counted(&base), base.residuals.iter().map(Vec::len).sum());
        let variants = std::sync::atomic::AtomicUsize::new(1);
        Ok(Self { host, recordings, noise, log, base, linear, free, squares, count, factors: 1, variants })
    }

    /// The recordings as a problem for another simulator.
    fn problem<'b>(
        &'b self,
        simulator: &'b dyn Simulator,
        free: &'b [usize],
        log: Option<&'b RolloutLog>,
    ) -> Problem<'b> {
        Problem { simulator, recordings: self.recordings, noise: self.noise, free, log }
    }

    /// The base model one linear step from its fit, towards these residuals.
    fn stepped(&self, residuals: &[Vec<f64>]) -> Result<Point> {
        let simulator = self.host.carrying(&[])?;
        let problem = self.problem(simulator.as_ref(), &self.free, None);
        Ok(problem.stepped(&self.base, &self.linear, residuals))
    }

    /// A simulator with these terms, whose coefficients reach as far as their numbers suggest.
    pub fn carrying(&self, response: &Response, terms: &[Term], numbers: &[Vec<f64>]) -> Result<Box<dyn Visiting>> {
        let carried: Vec<_> = terms
            .iter()
            .zip(numbers)
            .enumerate()
            .map(|(i, (term, numbers))| {
                let most = numbers[..term.components].iter().fold(0.0_f64, |most, c| most.max(c.abs()));
                term.carried(self.host, &response.ranges, i, REACH * most.max(1e-9))
            })
            .collect();
        self.host.carrying(&carried)
    }

    /// Fits a candidate of the linear search; nothing where the simulator refuses it or no rollouts are left.
    pub fn fit(&self, response: &Response, candidate: &Candidate, steps: usize) -> Option<Law> {
        let mut residuals = self.base.residuals.clone();
        for (term, numbers) in candidate.terms.iter().zip(&candidate.numbers) {
            for (all, change) in residuals.iter_mut().zip(response.answer(term, numbers)) {
                all.iter_mut().zip(change).for_each(|(r, c)| *r -= c);
            }
        }
        let start = self.stepped(&residuals).ok()?;
        let begun = self.from(response, &candidate.terms, &candidate.numbers, start, steps);
        // A linearisation that reaches too far ends in a refusal; the base model's own values do not.
        begun.or_else(|| self.from(response, &candidate.terms, &candidate.numbers, self.base.point.clone(), steps))
    }

    /// Fits terms from these numbers, and the base model's values from those of `start`.
    pub fn from(
        &self,
        response: &Response,
        terms: &[Term],
        numbers: &[Vec<f64>],
        mut start: Point,
        steps: usize,
    ) -> Option<Law> {
        let simulator = self.carrying(response, terms, numbers).ok()?;
        let count = price::constants(terms);
        let all = simulator.parameters();
        let first = all.len() - count;
        start.parameters.truncate(first);
        start.parameters.extend(numbers.iter().flatten());
        for (value, p) in start.parameters.iter_mut().zip(all).skip(first) {
            *value = value.clamp(p.min, p.max);
        }
        let free: Vec<usize> = self.free.iter().copied().chain(first..all.len()).collect();
        let own: usize = self.recordings.iter().map(|r| r.nuisances.len() + free.len() + 1).sum();
        if !self.log.affords(own + self.recordings.len() * steps) {
            return None;
        }
        let variant = self.variants.fetch_add(1, std::sync::atomic::Ordering::Relaxed);
        let log = self.log.variant(variant);
        let problem = self.problem(simulator.as_ref(), &free, Some(&log));
        let fit = problem.fit_steps(start, steps, steps.div_ceil(2)).ok()?;
        Some(self.law(terms.to_vec(), fit, first))
    }

    /// Fits a law on, to the end.
    pub fn finish(&self, response: &Response, law: &Law) -> Option<Law> {
        self.from(response, &law.terms, &law.numbers(), law.fit.point.clone(), 24)
    }

    fn law(&self, terms: Vec<Term>, fit: Fit, first: usize) -> Law {
        let squares = counted(&fit);
        let gain = price::likelihood(self.count, self.squares, squares);
        let bic = price::bic(gain, self.count, price::constants(&terms));
        let score = price::score(bic, price::bits(self.host.space(), self.factors, &terms));
        Law { terms, fit, first, bic, score }
    }

    /// The derivatives at a law, in the order of its free parameters.
    pub fn linearise(&self, response: &Response, law: &Law) -> Result<Linearisation> {
        let simulator = self.carrying(response, &law.terms, &law.numbers())?;
        let free: Vec<usize> = self.free.iter().copied().chain(law.first..simulator.parameters().len()).collect();
        let problem = self.problem(simulator.as_ref(), &free, None);
        let linear = problem.linearise(&law.fit)?;
        self.log.add(linear.rollouts());
        Ok(linear)
    }

    /// Twice the gain in logarithmic likelihood over the base model.
    pub fn gain(&self, law: &Law) -> f64 {
        law.bic + price::constants(&law.terms) as f64 * (self.count as f64).ln()
    }

    /// What effects of the catalogue gain in the information criterion on the same recordings.
    pub fn rival(&self, names: &[&str]) -> Option<f64> {
        let base = self.host.carrying(&[]).ok()?;
        let simulator = base.with_effects(names).ok()?;
        // The recordings were prepared without these effects and know nothing of their coefficients.
        let known = base.parameters().len();
        let free: Vec<usize> =
            free(base.parameters(), self.recordings).into_iter().chain(known..simulator.parameters().len()).collect();
        let mut start = self.base.point.clone();
        let more = simulator.parameters().len() - start.parameters.len();
        let typical = |i: usize| {
            let p = &simulator.parameters()[i];
            (p.value + 1e-3 * p.span()).min(p.max)
        };
        start.parameters.extend((start.parameters.len()..simulator.parameters().len()).map(typical));
        let variant = self.variants.fetch_add(1, std::sync::atomic::Ordering::Relaxed);
        let log = self.log.variant(variant);
        let problem = self.problem(simulator.as_ref(), &free, Some(&log));
        let fit = problem.fit(start, 1.0).ok()?;
        let gain = price::likelihood(self.count, self.squares, counted(&fit));
        Some(price::bic(gain, self.count, more))
    }
}

/// The robust sum of squares that laws are compared by.
fn counted(fit: &Fit) -> f64 {
    2.0 * huber_cost(&fit.residuals, 1.0)
}
