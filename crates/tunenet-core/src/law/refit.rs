//! Output-error fits of laws (Ljung 1999, section 7.2): through rollouts, starts and parameters of the simulator fitted with them.

use std::sync::atomic::AtomicBool;

use super::Named;
use super::colour::Colour;
use super::outliers::Outliers;
use super::price;
use super::response::Response;
use super::space::{Carried, Host, Visiting};
use super::term::Term;
use crate::Result;
use crate::estimate::huber::huber_cost;
use crate::estimate::jacobian::Columns;
use crate::estimate::{Fit, GROWING_SHARES, Linearisation, Point, Problem, RolloutLog, free, residual_gap};
use crate::simulator::{Parameter, Preparation, Prepared, Simulator};
use crate::statistics::root_mean_square;

/// How far the bounds of a coefficient reach, in units of what the linear stage found, and at most: a simulation file takes no larger number.
const REACH: f64 = 40.0;
const GREATEST: f64 = 1e9;
/// Steps of a fit to the end.
const LAST_STEPS: usize = 24;
/// Steps of one from near its end.
const FEW_STEPS: usize = 6;

/// A parameter lies at a bound within this share of the bounds.
const AT_BOUND: f64 = 1e-9;

/// What a fit ends so near a bound, as a share of the bounds, it may owe to that.
const NEAR_BOUND: f64 = 0.01;

/// How far apart, in units of the noise (root mean square), the residuals of one force in two notations may end.
const SAME: f64 = 0.02;

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
    /// Rollouts that looked for a better base model, which the log does not hold.
    pub before: usize,
    pub base: Fit,
    pub linear: Linearisation,
    /// The base model's free parameters.
    pub free: Vec<usize>,
    pub squares: f64,
    /// How many independent values the recordings hold.
    pub count: usize,
    /// The colour of their noise.
    pub colour: Colour,
    /// How many factors there are to choose from.
    pub factors: usize,
    /// How many rollouts the search may use before its tests.
    pub allowed: usize,
    /// Whether that ended it.
    pub short: AtomicBool,
}

/// Shares of the recordings over which the base model is fitted before the whole, so that it ends in the right minimum.
const HORIZONS: [f64; 2] = [0.45, 0.7];

/// A base model that leaves so many times the noise may sit in a local minimum; another fit is a better one below this share of its cost.
const SUSPICIOUS: f64 = 3.0;
const BETTER: f64 = 0.98;

impl<'a> Session<'a> {
    /// Fits the base model. Where that leaves far more than noise and a point is `known`, it is fitted from the first samples on and from
    /// that point as well.
    pub fn new(
        host: &'a dyn Host,
        recordings: &'a [Prepared],
        (noise, colour, known): (&'a [Vec<f64>], Colour, Option<&Point>),
        log: &'a RolloutLog,
        allowed: usize,
    ) -> Result<Self> {
        let simulator = host.carrying(&[])?;
        let free = free(simulator.parameters(), recordings);
        let problem = Problem { simulator: simulator.as_ref(), recordings, noise, free: &free, log: Some(log) };
        let start = || Point::start(simulator.as_ref(), recordings);
        let longer = |point: Point, horizon: &f64| problem.fit(point, *horizon).map(|fit| fit.point);
        let grown = HORIZONS.iter().try_fold(start(), longer).and_then(|point| problem.fit(point, 1.0));
        // Growing horizons may end in another minimum than the first guesses do.
        let direct = problem.fit(start(), 1.0);
        let mut refused = None;
        let mut found: Vec<Fit> = Vec::new();
        for fitted in [grown, direct] {
            fitted.map_or_else(|error| refused = Some(error), |fit| found.push(fit));
        }
        let least = found.iter().map(|fit| fit.cost).fold(f64::INFINITY, f64::min);
        found.sort_by(|a, b| a.cost.total_cmp(&b.cost));
        let poor = |fit: &Fit| root_mean_square(fit.residuals.iter().flatten().copied()) > SUSPICIOUS;
        let mut before = 0;
        if let Some(known) = known.filter(|_| found.first().is_none_or(poor)) {
            let own = RolloutLog::default();
            let again = Problem { log: Some(&own), ..problem };
            let longer = |point: Point, horizon: &f64| again.fit(point, *horizon).map(|fit| fit.point);
            let grown = GROWING_SHARES.iter().try_fold(start(), longer).and_then(|point| again.fit(point, 1.0));
            let others = grown.into_iter().chain(again.fit(known.clone(), 1.0));
            found.splice(0..0, others.filter(|other| other.cost < BETTER * least));
            found.sort_by(|a, b| a.cost.total_cmp(&b.cost));
            // What this takes is not taken from the search.
            before = own.count();
        }
        let settled = |mut fit: Fit| problem.settle(&mut fit).map(|linear| (fit, linear));
        // On the edge of what can be simulated there are no derivatives to go on with.
        let mut tried = found.into_iter().map(settled);
        let first = tried.next().unwrap_or_else(|| Err(refused.unwrap_or_else(|| problem.unaffordable())));
        let (base, linear) = first.or_else(|error| tried.find_map(Result::ok).ok_or(error))?;
        Ok(Self { before, allowed, ..Self::about(host, recordings, (noise, colour), (base, linear, free), log) })
    }

    /// About the fit that begins at a point where another fit of the same recordings ended.
    pub fn again(
        host: &'a dyn Host,
        recordings: &'a [Prepared],
        (noise, colour, known): (&'a [Vec<f64>], Colour, &Point),
        log: &'a RolloutLog,
    ) -> Result<Self> {
        let simulator = host.carrying(&[])?;
        let free = free(simulator.parameters(), recordings);
        let problem = Problem { simulator: simulator.as_ref(), recordings, noise, free: &free, log: Some(log) };
        let mut base = problem.fit(known.clone(), 1.0)?;
        let linear = problem.settle(&mut base)?;
        Ok(Self::about(host, recordings, (noise, colour), (base, linear, free), log))
    }

    fn about(
        host: &'a dyn Host,
        recordings: &'a [Prepared],
        (noise, colour): (&'a [Vec<f64>], Colour),
        (base, linear, free): (Fit, Linearisation, Vec<usize>),
        log: &'a RolloutLog,
    ) -> Self {
        let (squares, count) = (counted(&base), independent(&base.residuals, colour));
        Self {
            host,
            recordings,
            noise,
            log,
            before: 0,
            base,
            linear,
            free,
            squares,
            count,
            colour,
            factors: 1,
            allowed: usize::MAX,
            short: AtomicBool::new(false),
        }
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

    /// The root mean square of what is left, in the unit of the channels where they have one.
    pub fn gap(&self, residuals: &[Vec<f64>]) -> f64 {
        residual_gap(self.recordings, self.noise, residuals)
    }

    /// Where derivatives of the base model lead to from `point`, if these residuals are left there.
    pub fn stepped(&self, point: &Point, columns: &[Columns], residuals: &[Vec<f64>]) -> Result<Point> {
        let simulator = self.host.carrying(&[])?;
        Ok(self.problem(simulator.as_ref(), &self.free, None).stepped(point, columns, residuals))
    }

    /// These terms with the bounds of their numbers: coefficients reach as far as their numbers suggest.
    pub fn carried(&self, response: &Response, terms: &[Term], numbers: &[Vec<f64>]) -> Vec<Carried> {
        let each = terms.iter().zip(numbers).enumerate().map(|(i, (term, numbers))| {
            let most = numbers[..term.components].iter().fold(0.0_f64, |most, c| most.max(c.abs()));
            let reach = (REACH * if most > 0.0 { most } else { 1e-9 }).min(GREATEST);
            term.carried(self.host, &response.ranges, i, reach)
        });
        each.collect()
    }

    /// A simulator with these terms.
    pub fn carrying(&self, response: &Response, terms: &[Term], numbers: &[Vec<f64>]) -> Result<Box<dyn Visiting>> {
        self.host.carrying(&self.carried(response, terms, numbers))
    }

    /// Whether the search may go on: what is fitted at a time is chosen before, whatever the number of threads.
    pub fn within(&self) -> bool {
        self.log.count() < self.allowed
    }

    /// Fits terms from these numbers and from the law that they belong to, with derivatives of their own.
    pub fn on(&self, response: &Response, terms: &[Term], numbers: &[Vec<f64>], start: Point) -> Option<Law> {
        self.fitted(response, (terms, numbers), start, None, (FEW_STEPS, FEW_STEPS / 2))
    }

    /// Fits terms from a point with so many steps and measured derivatives.
    pub fn fitted(
        &self,
        response: &Response,
        written: (&[Term], &[Vec<f64>]),
        start: Point,
        near: Option<&Linearisation>,
        (steps, derivatives): (usize, usize),
    ) -> Option<Law> {
        self.by(response, written, start, &|problem, start| problem.fit_steps(start, near, steps, derivatives))
    }

    /// Fits terms over the first `share` of the recordings, from a point that was found in less of them or along another path.
    pub fn longer(
        &self,
        response: &Response,
        written: (&[Term], &[Vec<f64>]),
        start: Point,
        share: f64,
    ) -> Option<Law> {
        self.by(response, written, start, &|problem, start| problem.fit_share(start, share))
    }

    /// Fits terms with these numbers by `fit`; parameters and initial states begin where `start` has them.
    fn by(
        &self,
        response: &Response,
        (terms, numbers): (&[Term], &[Vec<f64>]),
        mut start: Point,
        fit: &dyn Fn(&Problem, Point) -> Result<Fit>,
    ) -> Option<Law> {
        let simulator = self.carrying(response, terms, numbers).ok()?;
        let all = simulator.parameters();
        let first = all.len() - price::constants(terms);
        start.parameters.truncate(first);
        start.parameters.extend(numbers.iter().flatten());
        for (value, p) in start.parameters.iter_mut().zip(all).skip(first) {
            *value = value.clamp(p.min, p.max);
        }
        let free: Vec<usize> = self.free.iter().copied().chain(first..all.len()).collect();
        // A log of its own: what a fit may do must not depend on others that run at the same time.
        let own = RolloutLog::default();
        let problem = self.problem(simulator.as_ref(), &free, Some(&own));
        let fit = fit(&problem, start);
        self.log.add(own.count());
        Some(self.law(terms.to_vec(), fit.ok()?, first))
    }

    /// Fits a law on, to the end.
    pub fn finish(&self, response: &Response, law: &Law) -> Option<Law> {
        let numbers = law.numbers();
        self.fitted(response, (&law.terms, &numbers), law.fit.point.clone(), None, (LAST_STEPS, LAST_STEPS / 2))
    }

    fn law(&self, terms: Vec<Term>, fit: Fit, first: usize) -> Law {
        let squares = counted(&fit);
        let gain = price::likelihood(self.count, self.squares, squares);
        let bic = gain - price::numbers(self.count, &terms);
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

    /// How many channels the recordings have.
    pub fn width(&self) -> usize {
        self.recordings.first().map_or(1, |recording| recording.seen.channels().len())
    }

    /// Residuals of the fitted recordings without their outliers.
    pub fn cleaned(&self, residuals: &[Vec<f64>]) -> Vec<Vec<f64>> {
        Outliers::of(residuals, self.width()).replaced(residuals)
    }

    /// Whether a parameter of the simulator lies near a bound, 0 aside, which is an end by nature.
    pub fn is_at_bound(&self, law: &Law) -> Result<bool> {
        let simulator = self.host.carrying(&[])?;
        Ok(self.free.iter().any(|&i| is_near_bound(&simulator.parameters()[i], law.fit.point.parameters[i])))
    }

    /// How many values there are beyond what a law and the initial states take.
    pub fn freedom(&self, law: &Law) -> f64 {
        let own = self.recordings.iter().map(|r| r.nuisances.len()).sum::<usize>();
        let own = own + self.free.len() + price::constants(&law.terms);
        self.count.saturating_sub(own).max(1) as f64
    }

    /// The noise that a law leaves, in units of what differences of the series show, which is less certain.
    pub fn scale(&self, law: &Law) -> f64 {
        (robust_squares(&self.cleaned(&law.fit.residuals)) / self.freedom(law)).sqrt().max(f64::MIN_POSITIVE)
    }

    /// At which bound each free parameter lies, -1 at the lower one and 1 at the upper one, and 0 within them; a law's own numbers count as
    /// within.
    pub fn outward(&self, law: &Law) -> Result<Vec<f64>> {
        let simulator = self.host.carrying(&[])?;
        let side = |&i: &usize| {
            let (p, value) = (&simulator.parameters()[i], law.fit.point.parameters[i]);
            let room = AT_BOUND * p.span();
            f64::from(u8::from(value >= p.max - room)) - f64::from(u8::from(value <= p.min + room))
        };
        let own = std::iter::repeat_n(0.0, price::constants(&law.terms));
        Ok(self.free.iter().map(side).chain(own).collect())
    }

    /// Twice the gain in logarithmic likelihood over the base model.
    pub fn gain(&self, law: &Law) -> f64 {
        law.bic + price::numbers(self.count, &law.terms)
    }

    /// What effects of the catalogue leave of the same recordings, fitted from what a diagnosis found, or from typical values where their
    /// number is another; parameters and initial states begin where those of the base model are, and where those of a law are. The draws of
    /// a random effect are fitted as well.
    pub fn rival(&self, named: &[Named], law: Option<&Law>) -> Option<Rival> {
        let base = self.host.carrying(&[]).ok()?;
        let names: Vec<&str> = named.iter().map(|one| one.name.as_str()).collect();
        let simulator = base.with_effects(&names).ok()?;
        // The recordings were prepared without these effects and know nothing of their coefficients.
        let known = base.parameters().len();
        let all = simulator.parameters();
        let free: Vec<usize> = free(base.parameters(), self.recordings).into_iter().chain(known..all.len()).collect();
        let more = all.len() - known;
        let found: Vec<f64> = named.iter().flat_map(|one| one.values.iter().copied()).collect();
        let found = if found.len() == more { found.as_slice() } else { &[] };
        let typical = |p: &Parameter| p.value + 1e-3 * p.span();
        let at = |(i, p): (usize, &Parameter)| found.get(i).copied().unwrap_or_else(|| typical(p)).clamp(p.min, p.max);
        let coefficients: Vec<f64> = all[known..].iter().enumerate().map(at).collect();
        let recordings = self.with_draws(simulator.as_ref())?;
        let start = |of: &Point| {
            let own = of.parameters[..known].iter().chain(&coefficients);
            let and_draws = |(own, recording): (&Vec<f64>, &Prepared)| {
                let draws = recording.nuisances[own.len()..].iter().map(|draw| draw.value);
                own.iter().copied().chain(draws).collect()
            };
            let nuisances = of.nuisances.iter().zip(&recordings).map(and_draws).collect();
            Point { parameters: own.copied().collect(), nuisances }
        };
        let starts = std::iter::once(&self.base.point).chain(law.map(|law| &law.fit.point)).map(start);
        let own = RolloutLog::default();
        let problem = Problem { recordings: &recordings, ..self.problem(simulator.as_ref(), &free, Some(&own)) };
        let fits = starts.filter_map(|start| problem.fit(start, 1.0).ok());
        let fit = fits.min_by(|a, b| a.cost.total_cmp(&b.cost));
        self.log.add(own.count());
        let fit = fit?;
        let gain = price::likelihood(self.count, self.squares, counted(&fit));
        let count = |all: &[Prepared]| all.iter().map(|one| one.nuisances.len()).sum::<usize>();
        let draws = count(&recordings) - count(self.recordings);
        let bic = |constants| price::bic(gain, self.count, constants);
        Some(Rival { bic: bic(more + draws), most: bic(more), residuals: fit.residuals })
    }

    /// The recordings with the draws of random effects of `simulator` as further nuisance parameters.
    fn with_draws(&self, simulator: &dyn Simulator) -> Option<Vec<Prepared>> {
        let one = |recording: &Prepared| {
            let Preparation::Usable(prepared) = simulator.prepare(&recording.seen).ok()? else { return None };
            let draws = prepared.nuisances.get(recording.nuisances.len()..)?;
            let nuisances = recording.nuisances.iter().chain(draws).cloned().collect();
            Some(Prepared { nuisances, ..recording.clone() })
        };
        self.recordings.iter().map(one).collect()
    }
}

/// Effects of the catalogue, fitted to the same recordings.
pub(super) struct Rival {
    /// What they gain in the information criterion; at most, if the draws of a random effect cost nothing.
    pub bic: f64,
    pub most: f64,
    residuals: Vec<Vec<f64>>,
}

impl Rival {
    /// Whether a law leaves the same residuals, so that both are one force in two notations.
    pub fn is(&self, law: &Law) -> bool {
        let pairs = || self.residuals.iter().flatten().zip(law.fit.residuals.iter().flatten());
        let squares: f64 = pairs().map(|(a, b)| (a - b).powi(2)).sum();
        squares <= pairs().count() as f64 * SAME * SAME
    }
}

/// Whether a value lies near a bound other than 0, which is an end by nature.
fn is_near_bound(p: &Parameter, value: f64) -> bool {
    [p.min, p.max].into_iter().any(|bound| bound != 0.0 && (value - bound).abs() <= NEAR_BOUND * p.span())
}

/// How many independent values there are, the noise being of this colour.
pub(super) fn independent(residuals: &[Vec<f64>], colour: Colour) -> usize {
    let all: usize = residuals.iter().map(Vec::len).sum();
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a share of a count")]
    let few = (all as f64 / colour.values_for_one()).round() as usize;
    few.max(1)
}

/// The robust sum of squares that laws are compared by.
fn counted(fit: &Fit) -> f64 {
    robust_squares(&fit.residuals)
}

/// The robust sum of squares of residuals.
pub(super) fn robust_squares(residuals: &[Vec<f64>]) -> f64 {
    2.0 * huber_cost(residuals, 1.0)
}
