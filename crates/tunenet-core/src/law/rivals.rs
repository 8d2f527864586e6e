//! Rivals of a law (Burnham and Anderson 2002, section 2.6: a set of models instead of one): every form of the table, in the response about
//! that law, where the forms that explain the recordings as well differ from it by little.

use rayon::prelude::*;

use super::around::DIFFERENCE;
use super::forms::is_needless;
use super::linear::{Candidate, Search, ranked, solved};
use super::price;
use super::response::{Column, Response};
use super::space::Space;
use super::term::{Factor, Term};

/// How many forms are brought to their best constants, and how far behind the best of them they may lie.
const POLISHED: usize = 240;
const BEHIND: f64 = 400.0;
/// Steps of that.
const STEPS: usize = 6;
/// Twice the logarithmic likelihood that a linear answer may be wrong by, between forms that are near each other.
const SLACK: f64 = 6.0;
/// Most rivals.
const MOST: usize = 32;

impl<'a> Search<'a> {
    /// A search that knows rounded constants as forms of their own.
    pub fn fine(space: &'a Space, response: &'a Response) -> Self {
        let mut search = Self::new(space, response);
        let rounded: Vec<Factor> =
            search.factors.iter().flat_map(|f| f.multiples(&space.variables[f.variable].unit)).collect();
        search.factors.extend(rounded);
        search
    }

    /// Forms whose information criterion lies within `margin` of the best in this response, best first.
    pub fn rivals(&self, law: &Term, numbers: &[f64], margin: f64) -> Vec<Candidate> {
        let singles = self.singles();
        let open: Vec<Candidate> = singles.iter().filter(|c| c.terms[0].is_open()).cloned().collect();
        let products = self.products(&open);
        let own = Candidate { terms: vec![law.clone()], numbers: vec![numbers.to_vec()], score: 0.0 };
        let mut all = vec![own];
        all.extend(self.neighbours(law, numbers));
        all.extend(singles);
        all.extend(products);
        let all = forms(ranked(all));
        let best = all.first().map_or(0.0, |c| c.score);
        let near: Vec<&Candidate> = all.iter().take(POLISHED).filter(|c| c.score > best - BEHIND).collect();
        let mut polished: Vec<(f64, Candidate)> = near
            .par_iter()
            .filter_map(|c| {
                let found = self.polished(c)?;
                Some((self.criterion(&found), found))
            })
            .collect();
        polished.sort_by(|a, b| b.0.total_cmp(&a.0));
        let best = polished.first().map_or(0.0, |(bic, _)| *bic);
        let mut near: Vec<(f64, Candidate)> = Vec::new();
        for (bic, candidate) in &polished {
            let gain = |bic: f64, of: &Candidate| bic + price::numbers(self.response.count, &of.terms);
            let needless = |(other, simple): &(f64, Candidate)| {
                let more = gain(*bic, candidate) - gain(*other, simple);
                is_needless(self.space, &candidate.terms, &simple.terms, more)
            };
            if *bic >= best - margin - SLACK && !polished.iter().any(needless) {
                near.push((*bic, candidate.clone()));
            }
        }
        near.into_iter().take(MOST).map(|(_, candidate)| candidate).collect()
    }

    /// The neighbours of a term: each factor replaced by every other one, and, of a term of less than two factors, every one more.
    fn neighbours(&self, term: &Term, numbers: &[f64]) -> Vec<Candidate> {
        let replaced = (0..term.factors.len()).flat_map(|f| self.factors.iter().map(move |other| (Some(f), other)));
        let room = term.factors.len() < 2;
        let added = self.factors.iter().filter(|_| room).map(|other| (None, other));
        self.exchanged(term, numbers, &replaced.chain(added).collect::<Vec<_>>())
    }

    /// The term with each of these factors at its place, or added, with the best constants of their grids.
    fn exchanged(&self, term: &Term, numbers: &[f64], tried: &[(Option<usize>, &Factor)]) -> Vec<Candidate> {
        let grid = |factor: &Factor| factor.grid(&self.response.ranges[factor.variable]);
        let inner: Vec<Vec<f64>> = term.inner(numbers).iter().map(|own| own.to_vec()).collect();
        let one = |&(place, other): &(Option<usize>, &Factor)| {
            let (mut factors, mut parts) = (term.factors.clone(), inner.clone());
            let place = place.unwrap_or_else(|| {
                factors.push(other.clone());
                parts.push(Vec::new());
                factors.len() - 1
            });
            factors[place] = other.clone();
            if factors.len() > 1 && !factors[1 - place].multiplies(other) {
                return None;
            }
            let starts = grid(other).into_iter().map(|constants| {
                parts[place] = constants;
                parts.concat()
            });
            let starts = starts.collect();
            self.best(term.direction, &factors, starts)
        };
        tried.par_iter().filter_map(one).collect()
    }

    /// The law with each factor omitted, or replaced by the other shapes of its variable and by whole powers, and whole powers in the place of
    /// what is left of it: a second factor may mend the shape of the first. Rollouts compare these forms whatever the response says of them,
    /// because a force that changes within a piece of it is seen badly there.
    pub fn kin(&self, term: &Term, numbers: &[f64]) -> Vec<Candidate> {
        let mut all = self.replaced(term, numbers);
        for fewer in self.fewer(term, numbers) {
            let replaced = self.replaced(&fewer.terms[0], &fewer.numbers[0]);
            all.extend(replaced.into_iter().filter(|c| c.terms[0].is_closed()));
            all.push(fewer);
        }
        all.iter().filter_map(|c| self.polished(c)).collect()
    }

    /// The term with one factor replaced by the other shapes of its variable and by whole powers.
    fn replaced(&self, term: &Term, numbers: &[f64]) -> Vec<Candidate> {
        let whole = |factor: &Factor| factor.rounded.is_none_or(|p| p.fract() == 0.0);
        let of = |f: usize| {
            let (own, others) = (&term.factors[f], term.factors.iter().enumerate().filter(move |(i, _)| *i != f));
            let kept = others.map(|(_, other)| other).all(whole);
            let kin = move |other: &&Factor| kept && other.variable == own.variable && *other != own && whole(other);
            self.factors.iter().filter(kin).map(move |other| (Some(f), other))
        };
        self.exchanged(term, numbers, &(0..term.factors.len()).flat_map(of).collect::<Vec<_>>())
    }

    /// The term with each factor omitted.
    fn fewer(&self, term: &Term, numbers: &[f64]) -> Vec<Candidate> {
        let inner = term.inner(numbers);
        let without = |f: usize| {
            let others = (0..term.factors.len()).filter(|i| *i != f);
            let factors: Vec<Factor> = others.clone().map(|i| term.factors[i].clone()).collect();
            self.best(term.direction, &factors, vec![others.flat_map(|i| inner[i].to_vec()).collect()])
        };
        (0..term.factors.len()).filter_map(without).collect()
    }

    /// The information criterion of a candidate in this response.
    fn criterion(&self, candidate: &Candidate) -> f64 {
        candidate.score + price::score(0.0, -price::bits(self.space, self.kinds, &candidate.terms))
    }

    /// A candidate of one term with its best constants, by Gauss and Newton's method in the response.
    fn polished(&self, candidate: &Candidate) -> Option<Candidate> {
        let ([term], [numbers]) = (candidate.terms.as_slice(), candidate.numbers.as_slice()) else { return None };
        let count = term.components;
        let (mut gain, mut numbers) = self.evaluate(term.direction, &term.factors, &numbers[count..])?;
        for _ in 0..STEPS {
            let before = gain;
            let Some(steps) = self.newton(term, &numbers) else { break };
            for share in [1.0, 0.4, 0.1] {
                let moved = self.within_bounds(term, &numbers[count..], &steps, share);
                let Some((more, found)) = self.evaluate(term.direction, &term.factors, &moved) else { continue };
                if more > gain {
                    (gain, numbers) = (more, found);
                    break;
                }
            }
            if gain - before < 0.01 {
                break;
            }
        }
        let terms = vec![term.clone()];
        let score = self.score(gain, &terms);
        Some(Candidate { terms, numbers: vec![numbers], score })
    }

    /// The step of the constants inside that the response asks for.
    fn newton(&self, term: &Term, numbers: &[f64]) -> Option<Vec<f64>> {
        let count = term.components;
        let mut columns = self.columns(term, numbers);
        let still = Column::sum(&columns, &numbers[..count])?;
        for i in count..numbers.len() {
            let mut moved = numbers.to_vec();
            let step = DIFFERENCE * moved[i].abs().max(1e-3);
            moved[i] += step;
            let there = Column::sum(&self.columns(term, &moved), &numbers[..count])?;
            columns.push(still.slope(&there, step.recip()));
        }
        if columns.len() == count {
            return None;
        }
        let all: Vec<&Column> = columns.iter().chain(&self.known).collect();
        let (_, found) = solved(&all, &self.response.left)?;
        Some(found[count..columns.len()].to_vec())
    }

    fn within_bounds(&self, term: &Term, inner: &[f64], steps: &[f64], share: f64) -> Vec<f64> {
        let bounds = term.factors.iter().flat_map(|f| {
            let range = &self.response.ranges[f.variable];
            (0..f.constants()).map(move |i| f.shape.bounds(i, range))
        });
        let moved = inner.iter().zip(steps).zip(bounds);
        moved.map(|((value, step), (low, high))| (value + share * step).clamp(low, high)).collect()
    }
}

/// Each form once, best first.
fn forms(all: Vec<Candidate>) -> Vec<Candidate> {
    let same = |a: &Term, b: &Term| {
        let turned = || b.factors.iter().rev().eq(&a.factors);
        a.direction == b.direction && (a.factors == b.factors || turned())
    };
    let mut kept: Vec<Candidate> = Vec::new();
    for one in all {
        if !kept.iter().any(|other| same(&other.terms[0], &one.terms[0])) {
            kept.push(one);
        }
    }
    kept
}
