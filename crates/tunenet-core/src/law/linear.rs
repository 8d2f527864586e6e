//! Exhaustive search over one factor, then over products with the best (stagewise least squares in the linearised response), constants
//! inside by a grid and a pattern search (Hooke and Jeeves 1961).

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use super::price;
use super::response::{Column, Response};
use super::shape::{Role, Shape};
use super::space::Space;
use super::term::{Factor, Term};

/// Rounds of the pattern search.
const ROUNDS: usize = 8;
/// How many of the best one-factor forms are multiplied with every factor.
const MULTIPLIED: usize = 6;
/// How many points of a grid the pattern search begins at.
const BEGINNINGS: usize = 2;

/// Terms with their numbers, and what they gain in the linearised response.
#[derive(Debug, Clone)]
pub(super) struct Candidate {
    pub terms: Vec<Term>,
    pub numbers: Vec<Vec<f64>>,
    pub score: f64,
}

/// What constants inside gain, and all numbers with them.
type Evaluate<'a> = dyn Fn(&[f64]) -> Option<(f64, Vec<f64>)> + 'a;

/// A search in a linearised response.
pub(super) struct Search<'a> {
    pub space: &'a Space,
    pub response: &'a Response,
    /// All factors that a term may have.
    pub factors: Vec<Factor>,
    /// How many of them there are, those with a rounded constant aside.
    pub kinds: usize,
    /// What is there already: its tangent is projected out.
    pub known: Vec<Column>,
}

impl<'a> Search<'a> {
    pub fn new(space: &'a Space, response: &'a Response) -> Self {
        let factors = factors(space, response);
        Self { space, response, kinds: factors.len(), factors, known: Vec::new() }
    }

    /// Every direction with one factor or none, best first.
    pub fn singles(&self) -> Vec<Candidate> {
        let forms: Vec<(usize, Option<&Factor>)> = (0..self.space.directions.len())
            .flat_map(|d| std::iter::once((d, None)).chain(self.factors.iter().map(move |f| (d, Some(f)))))
            .collect();
        let one = |&(direction, factor): &(usize, Option<&Factor>)| {
            let factors: Vec<Factor> = factor.into_iter().cloned().collect();
            let starts = factor.map_or_else(|| vec![Vec::new()], |f| f.grid(&self.response.ranges[f.variable]));
            self.best(direction, &factors, starts)
        };
        ranked(forms.par_iter().filter_map(one).collect())
    }

    /// Products of the best of `singles` with every factor, best first.
    pub fn products(&self, singles: &[Candidate]) -> Vec<Candidate> {
        let seeds = singles.iter().filter(|c| !c.terms[0].factors.is_empty()).take(MULTIPLIED);
        let pairs: Vec<(&Candidate, &Factor)> =
            seeds.flat_map(|seed| self.factors.iter().map(move |f| (seed, f))).collect();
        let one = |&(seed, factor): &(&Candidate, &Factor)| {
            let term = &seed.terms[0];
            let first = &term.factors[0];
            if !first.multiplies(factor) {
                return None;
            }
            let inner = &seed.numbers[0][term.components..];
            let grid = factor.grid(&self.response.ranges[factor.variable]);
            let starts = grid.into_iter().map(|more| inner.iter().copied().chain(more).collect()).collect();
            self.best(term.direction, &[first.clone(), factor.clone()], starts)
        };
        let mut found = ranked(pairs.par_iter().filter_map(one).collect());
        let same = |a: &Term, b: &Term| {
            a.direction == b.direction && a.factors[0] == b.factors[1] && a.factors[1] == b.factors[0]
        };
        let mut kept: Vec<Candidate> = Vec::new();
        for one in found.drain(..) {
            if !kept.iter().any(|other| same(&other.terms[0], &one.terms[0])) {
                kept.push(one);
            }
        }
        kept
    }

    /// Pairs of these, solved together, best first.
    pub fn pairs(&self, singles: &[Candidate]) -> Vec<Candidate> {
        let columns: Vec<Vec<Column>> = singles.iter().map(|c| self.columns(&c.terms[0], &c.numbers[0])).collect();
        let each: Vec<(usize, usize)> = (0..singles.len()).flat_map(|i| (0..i).map(move |j| (j, i))).collect();
        let one = |&(i, j): &(usize, usize)| {
            let both: Vec<&Column> = columns[i].iter().chain(&columns[j]).collect();
            let (gain, coefficients) = solved(&both, &self.response.left)?;
            let (a, b) = (&singles[i], &singles[j]);
            let mut numbers = vec![a.numbers[0].clone(), b.numbers[0].clone()];
            let first = a.terms[0].components;
            numbers[0][..first].copy_from_slice(&coefficients[..first]);
            numbers[1][..b.terms[0].components].copy_from_slice(&coefficients[first..]);
            let terms = vec![a.terms[0].clone(), b.terms[0].clone()];
            let score = self.score(gain, &terms);
            Some(Candidate { terms, numbers, score })
        };
        ranked(each.par_iter().filter_map(one).collect())
    }

    /// The columns of a term with these numbers.
    pub fn columns(&self, term: &Term, numbers: &[f64]) -> Vec<Column> {
        let values = self.product(&term.factors, &numbers[term.components..]);
        self.response.columns(term.direction, &values)
    }

    /// The values of a product at all instants.
    pub(super) fn product(&self, factors: &[Factor], inner: &[f64]) -> Vec<f64> {
        let (mut at, mut product) = (0, Vec::new());
        for factor in factors {
            let end = at + factor.constants();
            let values = self.response.factor(factor, &inner[at..end]);
            at = end;
            if product.is_empty() {
                product = values;
            } else {
                product.iter_mut().zip(values).for_each(|(p, v)| *p *= v);
            }
        }
        if product.is_empty() { vec![1.0; self.response.instants()] } else { product }
    }

    pub(super) fn score(&self, gain: f64, terms: &[Term]) -> f64 {
        let (count, squares) = (self.response.count, self.response.squares);
        let likelihood = price::likelihood(count, squares, (squares - gain).max(0.05 * count as f64));
        let bic = likelihood - price::numbers(count, terms);
        price::score(bic, price::bits(self.space, self.kinds, terms))
    }

    /// The best constants inside from these starts.
    pub(super) fn best(&self, direction: usize, factors: &[Factor], starts: Vec<Vec<f64>>) -> Option<Candidate> {
        let evaluate = |inner: &[f64]| self.evaluate(direction, factors, inner);
        let mut begun: Vec<(f64, Vec<f64>)> =
            starts.into_iter().filter_map(|inner| Some((evaluate(&inner)?.0, inner))).collect();
        begun.sort_by(|a, b| b.0.total_cmp(&a.0));
        let found = begun.into_iter().take(BEGINNINGS).map(|start| self.pattern(factors, start, &evaluate));
        let (gain, inner) = found.max_by(|a, b| a.0.total_cmp(&b.0))?;
        let (_, numbers) = evaluate(&inner)?;
        let components = self.space.directions[direction].components.len();
        let terms = vec![Term::new(direction, components, factors.to_vec())];
        let score = self.score(gain, &terms);
        Some(Candidate { terms, numbers: vec![numbers], score })
    }

    /// Compass search from a point, each constant within its bounds.
    fn pattern(
        &self,
        factors: &[Factor],
        (mut gain, mut inner): (f64, Vec<f64>),
        evaluate: &Evaluate,
    ) -> (f64, Vec<f64>) {
        let moves: Vec<(Role, f64, (f64, f64))> = factors
            .iter()
            .flat_map(|f| {
                let range = self.response.ranges[f.variable];
                let roles = f.open().iter().enumerate();
                roles.map(move |(i, role)| (*role, f.shape.reach(i, &range), f.shape.bounds(i, &range)))
            })
            .collect();
        let mut share = 1.0;
        for _ in 0..ROUNDS {
            let mut better = false;
            for (i, (role, reach, (low, high))) in moves.iter().enumerate() {
                if *role == Role::Phase {
                    continue;
                }
                for sign in [1.0, -1.0] {
                    let mut moved = inner.clone();
                    moved[i] = if role.logarithmic() {
                        inner[i] * reach.powf(sign * share)
                    } else {
                        inner[i] + sign * share * reach
                    };
                    moved[i] = moved[i].clamp(*low, *high);
                    if let Some((more, _)) = evaluate(&moved).filter(|(more, _)| *more > gain) {
                        (gain, inner, better) = (more, moved, true);
                        break;
                    }
                }
            }
            if !better {
                share *= 0.5;
            }
        }
        (gain, inner)
    }

    /// What a form gains with these constants inside, and all its numbers.
    pub(super) fn evaluate(&self, direction: usize, factors: &[Factor], inner: &[f64]) -> Option<(f64, Vec<f64>)> {
        let components = self.space.directions[direction].components.len();
        let wave = factors.iter().position(|f| f.shape == Shape::Wave);
        let mut columns = self.response.columns(direction, &self.product(factors, inner));
        let phase = wave.map(|w| factors[..w].iter().map(Factor::constants).sum::<usize>() + 1);
        if let Some(phase) = phase {
            let mut quarter = inner.to_vec();
            quarter[phase] += std::f64::consts::FRAC_PI_2;
            columns.extend(self.response.columns(direction, &self.product(factors, &quarter)));
        }
        let all: Vec<&Column> = columns.iter().chain(&self.known).collect();
        let (gain, coefficients) = solved(&all, &self.response.left)?;
        let mut inner = inner.to_vec();
        let mut linear = coefficients[..components].to_vec();
        if let Some(phase) = phase {
            // a cos(x) − b sin(x) = c cos(x + f), with one phase of all components.
            let quarter = &coefficients[components..2 * components];
            let strongest =
                (0..components).max_by(|&i, &j| linear[i].hypot(quarter[i]).total_cmp(&linear[j].hypot(quarter[j])))?;
            let turn = quarter[strongest].atan2(linear[strongest]);
            for (a, b) in linear.iter_mut().zip(quarter) {
                *a = *a * turn.cos() + b * turn.sin();
            }
            inner[phase] += turn;
        }
        linear.extend(inner);
        Some((gain, linear))
    }
}

/// All factors that a term may have.
fn factors(space: &Space, response: &Response) -> Vec<Factor> {
    let of = |(i, v): (usize, &super::space::Variable)| {
        let shapes = Shape::of(v.nature, &response.ranges[i]);
        shapes.into_iter().map(move |shape| Factor::new(shape, i))
    };
    // What does not vary is no variable.
    let varies = |i: usize| response.ranges[i].high > response.ranges[i].low;
    space.variables.iter().enumerate().filter(|(i, _)| varies(*i)).flat_map(of).collect()
}

/// Best first.
pub(super) fn ranked(mut all: Vec<Candidate>) -> Vec<Candidate> {
    all.retain(|c| c.score.is_finite());
    all.sort_by(|a, b| b.score.total_cmp(&a.score));
    all
}

/// Least squares of `left` by these columns: how much it falls, and the coefficients.
pub(super) fn solved(columns: &[&Column], left: &Column) -> Option<(f64, Vec<f64>)> {
    let n = columns.len();
    let normal = DMatrix::from_fn(n, n, |i, j| columns[i].dot(columns[j]));
    let right = DVector::from_fn(n, |i, _| columns[i].dot(left));
    let scale = DVector::from_fn(n, |i, _| normal[(i, i)].max(0.0).sqrt());
    if scale.iter().any(|s| !(*s > 1e-12 && s.is_finite())) {
        return None;
    }
    let scaled =
        DMatrix::from_fn(n, n, |i, j| normal[(i, j)] / (scale[i] * scale[j]) + if i == j { 1e-10 } else { 0.0 });
    let right = DVector::from_fn(n, |i, _| right[i] / scale[i]);
    let found = scaled.cholesky()?.solve(&right);
    let gain = found.dot(&right);
    gain.is_finite().then(|| (gain, (0..n).map(|i| found[i] / scale[i]).collect()))
}
