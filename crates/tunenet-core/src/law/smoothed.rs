//! Two-stage estimation (Varah 1982): a force that depends on the time alone makes each rollout follow its recording, and laws are searched
//! about that path. Where a force bends a motion far from the base model's, what the latter visits says little of the law.

use std::slice::from_ref;

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use super::around::Around;
use super::forms::{is_same, ranked};
use super::linear::{Candidate, Search};
use super::refit::{Law, Session};
use super::response::{Fitted, Part, Response};
use super::shape::Shape;
use super::space::{Carried, Nature};
use super::term::{Factor, Term};
use crate::Result;
use crate::estimate::jacobian::Columns;
use crate::estimate::{Point, Problem, RolloutLog};
use crate::simulator::every;

/// How many standard deviations of the noise the best law leaves where the response about the base model did not lead to it.
const FAR: f64 = 1.1;
/// How many bumps in time the force has along each axis, and how wide each is, in distances between neighbours.
const BUMPS: usize = 16;
const WIDTH: f64 = 1.2;
/// Numbers of a bump: its height, its place and its width.
const NUMBERS: usize = 3;
/// What is added to the diagonal of their normal equations, as a share of its mean: forces that the recordings do not show stay small.
const RIDGE: f64 = 1e-6;
/// How far heights may move, in units of the greatest with which the fit begins.
const REACH: f64 = 10.0;
/// Steps of the fit of a path.
const STEPS: usize = 8;
/// How many laws begin about the paths, of one factor and of two.
const SINGLES: usize = 6;
const PRODUCTS: usize = 3;
/// Over which first shares of the recordings how many of them are fitted one after the other: fewer and fewer of the best (Jamieson and
/// Talwalkar 2016), and among them the one that explains most of the whole paths, of which a first share shows little.
const SHARES: [(f64, usize); 5] = [(0.2, SINGLES + PRODUCTS), (0.35, 3), (0.5, 2), (0.75, 2), (1.0, 2)];

/// A path that follows one recording.
struct Trajectory {
    /// The base model's parameters with the force's numbers, and the initial state.
    point: Point,
    residuals: Vec<f64>,
    /// Derivatives by the base model's parameters and by the initial state.
    columns: Columns,
    force: Vec<Carried>,
    numbers: Vec<Vec<f64>>,
}

/// A force along each axis as a sum of bumps in time, with the numbers of each.
type Force = (Vec<Term>, Vec<Vec<f64>>);

/// Laws about paths that follow the recordings, fitted to the whole of them, where `best` leaves far more than the noise.
pub(super) fn smoothed(session: &Session, base: &Around, best: Option<&Law>) -> Vec<Law> {
    if !session.within() || best.is_some_and(|best| session.scale(best) < FAR) {
        return Vec::new();
    }
    let clock = session.host.space().variables.iter().position(|v| v.nature == Nature::Clock);
    let Some(Ok(around)) = clock.map(|clock| along(session, base, clock)) else { return Vec::new() };
    let search = Search::new(session.host.space(), &around.response);
    let singles = search.singles();
    let products = search.products(&singles);
    let begun: Vec<Candidate> = singles.into_iter().take(SINGLES).chain(products.into_iter().take(PRODUCTS)).collect();
    let [(first, _), later @ ..] = SHARES;
    let begin = |one: &Candidate| {
        let start = around.start(session, one).ok()?;
        session.longer(&around.response, (&one.terms, &one.numbers), start, first)
    };
    let mut laws = ranked(begun.par_iter().filter_map(begin).collect());
    for (share, most) in later {
        laws = kept(laws, begun.first(), most);
        let longer = |law: &Law| {
            let numbers = law.numbers();
            session.longer(&around.response, (&law.terms, &numbers), law.fit.point.clone(), share)
        };
        laws = ranked(laws.par_iter().filter_map(longer).collect());
    }
    laws
}

/// So many of the laws, of which the best come first, and among them that of a candidate.
fn kept(mut laws: Vec<Law>, of: Option<&Candidate>, most: usize) -> Vec<Law> {
    let place = of.and_then(|one| laws.iter().position(|law| is_same(&law.terms, &one.terms)));
    if let Some(place) = place.filter(|place| *place >= most) {
        laws.swap(most - 1, place);
    }
    laws.truncate(most);
    laws
}

/// About paths that follow the recordings; `clock` is the position of that variable.
pub(super) fn along(session: &Session, base: &Around, clock: usize) -> Result<Around> {
    let (recordings, noise) = (session.recordings, session.noise);
    let forces: Vec<Force> = base.response.parts.iter().map(|part| force(session, part, clock)).collect();
    let starts = starts(session, base, &forces)?;
    let one = |d: usize| path(session, base, d, &forces[d], starts[d].clone());
    let paths = every((0..recordings.len()).into_par_iter().map(one))?;
    let fitted = paths.iter().enumerate().map(|(d, path)| Fitted {
        recording: &recordings[d],
        noise: &noise[d],
        parameters: &path.point.parameters,
        nuisances: &path.point.nuisances[0],
        residuals: &path.residuals,
        law: &path.force,
        numbers: &path.numbers,
    });
    let columns: Vec<Columns> = paths.iter().map(|path| path.columns.clone()).collect();
    let response = Response::measure(session.host, &fitted.collect::<Vec<_>>(), &columns, session.log)?;
    let response = response.counting(session.count);
    let nuisances = paths.iter().map(|path| path.point.nuisances[0].clone()).collect();
    let parameters = base.point.parameters.clone();
    Ok(Around::paths(response, columns, Point { parameters, nuisances }))
}

/// The force in the linearised response of one recording: least squares with a ridge (Hoerl and Kennard 1970).
fn force(session: &Session, part: &Part, clock: usize) -> Force {
    let instants: Vec<f64> = part.visits.iter().map(|visit| visit.variables[clock]).collect();
    let (first, last) = (instants[0], instants[instants.len() - 1]);
    let apart = (last - first) / BUMPS as f64;
    let inner = |k: usize| [first + apart * (k as f64 + 0.5), WIDTH * apart];
    let bumps = DMatrix::from_fn(instants.len(), BUMPS, |i, k| Shape::Bump.value(instants[i], 1.0, &inner(k)));
    let axes = &session.host.space().axes;
    let mut design = DMatrix::zeros(part.residual.len(), axes.len() * BUMPS);
    for (a, axis) in part.axes.iter().enumerate() {
        design.columns_mut(a * BUMPS, BUMPS).copy_from(&(axis * &bumps));
    }
    let mut normal = design.tr_mul(&design);
    let ridge = RIDGE * normal.trace() / normal.nrows() as f64;
    for i in 0..normal.nrows() {
        normal[(i, i)] += ridge;
    }
    let right: DVector<f64> = design.tr_mul(&part.residual);
    let heights = normal.cholesky().map_or_else(|| DVector::zeros(right.len()), |factor| factor.solve(&right));
    let each = axes.iter().enumerate().flat_map(|(a, direction)| (0..BUMPS).map(move |k| (a, *direction, k)));
    let one = |(a, direction, k): (usize, usize, usize)| {
        let [place, width] = inner(k);
        let bump = Term::new(direction, 1, vec![Factor::new(Shape::Bump, clock)]);
        (bump, vec![heights[a * BUMPS + k], place, width])
    };
    each.map(one).unzip()
}

/// Where the linearised response leads each recording's initial state with its force, the base model's parameters as they are.
fn starts(session: &Session, base: &Around, forces: &[Force]) -> Result<Vec<Vec<f64>>> {
    let mut left = base.response.without.clone();
    for (d, (terms, numbers)) in forces.iter().enumerate() {
        for (term, numbers) in terms.iter().zip(numbers) {
            let change = base.response.answer_of(d, term, numbers);
            left[d].iter_mut().zip(change).for_each(|(left, change)| *left -= change);
        }
    }
    let simulator = session.host.carrying(&[])?;
    let (recordings, noise) = (session.recordings, session.noise);
    let problem = Problem { simulator: simulator.as_ref(), recordings, noise, free: &[], log: None };
    Ok(problem.stepped(&base.point, &session.linear.of(&[]), &left).nuisances)
}

/// The path of one recording: the heights of its force and the initial state, fitted through rollouts.
fn path(session: &Session, base: &Around, d: usize, (terms, numbers): &Force, start: Vec<f64>) -> Result<Trajectory> {
    let greatest = numbers.iter().fold(0.0_f64, |most, own| most.max(own[0].abs()));
    let carry =
        |(i, term): (usize, &Term)| term.carried(session.host, &base.response.ranges, i, REACH * greatest.max(1e-9));
    let force: Vec<Carried> = terms.iter().enumerate().map(carry).collect();
    let simulator = session.host.carrying(&force)?;
    let own = &base.point.parameters;
    let heights: Vec<usize> = (0..terms.len()).map(|i| own.len() + NUMBERS * i).collect();
    let parameters = own.iter().chain(numbers.iter().flatten()).copied().collect();
    let log = RolloutLog::default();
    let (recordings, noise) = (from_ref(&session.recordings[d]), from_ref(&session.noise[d]));
    let problem = Problem { simulator: simulator.as_ref(), recordings, noise, free: &heights, log: Some(&log) };
    let by_base = Problem { free: &session.free, ..problem };
    let fitted = problem.fit_steps(Point { parameters, nuisances: vec![start] }, None, STEPS, STEPS).and_then(|fit| {
        let linear = by_base.derivatives(&fit.point, &fit.residuals)?;
        Ok((fit, linear.columns()[0].clone()))
    });
    // What is refused has taken rollouts too.
    session.log.add(log.count());
    let (fit, columns) = fitted?;
    let numbers = fit.point.parameters[own.len()..].chunks_exact(NUMBERS).map(<[f64]>::to_vec).collect();
    Ok(Trajectory { residuals: fit.residuals[0].clone(), point: fit.point, columns, force, numbers })
}
