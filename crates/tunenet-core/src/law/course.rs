//! Partial residuals (Ezekiel 1924) of a law along a variable: in each range of the variable the acceleration that the recordings ask for,
//! of any form.

use nalgebra::{DMatrix, DVector};
use serde::Serialize;

use super::price::WIDER;
use super::refit::{Law, Session};
use super::response::{Column, Response};
use super::term::Term;
use crate::statistics::{NORMAL_95, mean, median, quantile, range};

/// Points of a curve.
const POINTS: usize = 81;
/// Into how many ranges a variable is divided: as many as leave the estimate precise.
const MOST_BINS: usize = 10;
const LEAST_BINS: usize = 4;
/// An estimate is precise where half of its intervals reach no farther than this share of what the law changes along the variable.
const PRECISE: f64 = 0.25;
/// Where directions of the estimate differ in precision by more than the root of this, the recordings do not determine it.
const LEAST_EIGENVALUE: f64 = 1e-9;
/// A number of a law is changed by this share of its standard deviation for the derivative of its curve.
const STEP: f64 = 1e-3;

/// A value of an acceleration where a variable has another one.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Sample {
    /// The variable.
    pub at: f64,
    /// The acceleration.
    pub value: f64,
    /// Its 95 % interval.
    pub interval95: (f64, f64),
}

/// What recordings ask for in a range of a variable.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Bin {
    /// The range.
    pub range: (f64, f64),
    /// The acceleration at its mean, with the interval of the noise.
    pub estimate: Sample,
}

/// The force of one component of a term along a variable that one of its factors depends on.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Course {
    /// The component of the direction.
    pub component: String,
    /// The unit of its acceleration.
    pub unit: String,
    /// The variable.
    pub variable: String,
    /// Its unit.
    pub variable_unit: String,
    /// The value of the other factor's variable at which the force is given, where it depends on another one.
    pub held: Option<(String, f64)>,
    /// The law between the first and the 99th percentile of what was visited, with the interval of all its numbers.
    pub curve: Vec<Sample>,
    /// The recordings' own estimate, the parameters and the other terms as they were fitted; empty where they do not determine one.
    pub bins: Vec<Bin>,
}

/// The courses of all terms of a law.
pub(super) fn courses(session: &Session, response: &Response, law: &Law) -> Vec<Course> {
    let numbers = law.numbers();
    let left = response.coordinates(&law.fit.residuals);
    let noise = session.scale(law);
    let mut before = law.fit.covariance.nrows() - numbers.iter().map(Vec::len).sum::<usize>();
    let mut made = Vec::new();
    for (term, numbers) in law.terms.iter().zip(&numbers) {
        let covariance = law.fit.covariance.view((before, before), (numbers.len(), numbers.len())).into_owned();
        before += numbers.len();
        let mut variables: Vec<usize> = term.factors.iter().map(|factor| factor.variable).collect();
        variables.dedup();
        for &variable in &variables {
            let along = Along::new(response, term, numbers, variable);
            let bins = along.bins(response, &left, noise);
            let curve = |component| along.curve(response, component, &covariance);
            made.extend((0..term.components).filter_map(|component| {
                let course = described(session, &along, component, curve(component), bins.as_deref().unwrap_or(&[]));
                course.curve.iter().all(|s| s.value.is_finite() && s.interval95.0.is_finite()).then_some(course)
            }));
        }
    }
    made
}

fn described(session: &Session, along: &Along, component: usize, curve: Vec<Sample>, bins: &[Vec<Bin>]) -> Course {
    let (host, space) = (session.host, session.host.space());
    let variable = &space.variables[along.variable];
    Course {
        component: space.directions[along.term.direction].components[component].clone(),
        unit: host.unit(along.term.direction, &[]),
        variable: variable.name.clone(),
        variable_unit: variable.unit.clone(),
        held: along.held.map(|(other, value)| (space.variables[other].name.clone(), value)),
        curve,
        bins: bins.get(component).cloned().unwrap_or_default(),
    }
}

/// A term along one variable.
struct Along<'a> {
    term: &'a Term,
    numbers: &'a [f64],
    variable: usize,
    /// The other variable, if any, and the value at which it is held.
    held: Option<(usize, f64)>,
    /// What the factor of the other variable is at all instants; 1 without one.
    other: Vec<f64>,
    /// The same at the held value.
    other_held: f64,
}

impl<'a> Along<'a> {
    fn new(response: &Response, term: &'a Term, numbers: &'a [f64], variable: usize) -> Self {
        let mut at = term.components;
        let mut made =
            Self { term, numbers, variable, held: None, other: vec![1.0; response.instants()], other_held: 1.0 };
        for factor in &term.factors {
            let own = &numbers[at..at + factor.constants()];
            at += factor.constants();
            if factor.variable != variable {
                made.other = response.factor(factor, own);
                let values = response.variable(factor.variable);
                let (held, value) = typical(values, &made.other);
                made.held = Some((factor.variable, held));
                made.other_held = value;
            }
        }
        made
    }

    /// The force of a component where the variable has this value.
    fn force(&self, numbers: &[f64], component: usize, x: f64) -> f64 {
        let most = self.variable.max(self.held.map_or(0, |(other, _)| other));
        let mut variables = vec![0.0; most + 1];
        if let Some((other, value)) = self.held {
            variables[other] = value;
        }
        variables[self.variable] = x;
        let sides: Vec<f64> = variables.iter().map(|v: &f64| v.signum()).collect();
        numbers[component] * self.term.product(numbers, &variables, &sides)
    }

    /// The law with the interval that the covariance of its numbers leaves (the delta method).
    fn curve(&self, response: &Response, component: usize, covariance: &DMatrix<f64>) -> Vec<Sample> {
        let of = &response.ranges[self.variable];
        let one = |i: usize| {
            let x = of.low + (of.high - of.low) * i as f64 / (POINTS - 1) as f64;
            let value = self.force(self.numbers, component, x);
            let slope = DVector::from_fn(self.numbers.len(), |k, _| {
                let step = STEP * covariance[(k, k)].max(0.0).sqrt();
                if step == 0.0 {
                    return 0.0;
                }
                let changed = |by: f64| {
                    let mut numbers = self.numbers.to_vec();
                    numbers[k] += by;
                    self.force(&numbers, component, x)
                };
                (changed(step) - changed(-step)) / (2.0 * step)
            });
            let half = NORMAL_95 * WIDER * (covariance * &slope).dot(&slope).max(0.0).sqrt();
            Sample { at: x, value, interval95: (value - half, value + half) }
        };
        (0..POINTS).map(one).collect()
    }

    /// The estimate of each component in as many ranges as leave it precise.
    fn bins(&self, response: &Response, left: &DVector<f64>, noise: f64) -> Option<Vec<Vec<Bin>>> {
        let halves = |bins: &[Vec<Bin>]| -> Option<f64> {
            median(bins.iter().flatten().map(|bin| (bin.estimate.interval95.1 - bin.estimate.interval95.0) / 2.0))
        };
        let of = &response.ranges[self.variable];
        let law = |component: usize| {
            let step = (of.high - of.low) / (POINTS - 1) as f64;
            range((0..POINTS).map(|i| self.force(self.numbers, component, of.low + step * i as f64)))
        };
        let precise = PRECISE * (0..self.term.components).map(law).fold(0.0, f64::max);
        let mut best = None;
        for count in (LEAST_BINS..=MOST_BINS).rev() {
            let Some(bins) = self.divided(response, left, noise, count) else { continue };
            let is_precise = halves(&bins).is_some_and(|half| half <= precise);
            best = Some(bins);
            if is_precise {
                break;
            }
        }
        best
    }

    /// The estimate in so many ranges that were visited equally long; none where the recordings do not determine it.
    fn divided(&self, response: &Response, left: &DVector<f64>, noise: f64, count: usize) -> Option<Vec<Vec<Bin>>> {
        let values = response.variable(self.variable);
        let edges = edges(values, count);
        let ranges: Vec<(f64, f64)> = edges.windows(2).map(|pair| (pair[0], pair[1])).collect();
        let last = ranges.len().checked_sub(1)?;
        let within = |k: usize, x: f64| ranges[k].0 <= x && (x < ranges[k].1 || k == last && x == ranges[k].1);
        let mut columns: Vec<Column> = Vec::new();
        for k in 0..=last {
            let each = values.iter().zip(&self.other);
            let each: Vec<f64> = each.map(|(x, other)| if within(k, *x) { *other } else { 0.0 }).collect();
            columns.extend(response.columns(self.term.direction, &each));
        }
        let components = self.term.components;
        let all = DMatrix::from_fn(left.len(), columns.len(), |i, j| columns[j].coordinates()[i]);
        let (found, deviations) = solved(&all, left)?;
        let bin = |k: usize, component: usize| {
            let at = mean(values.iter().copied().filter(|x| within(k, *x)));
            let (found, sd) = (found[k * components + component], noise * deviations[k * components + component]);
            let value = self.force(self.numbers, component, at) + self.other_held * found;
            let half = NORMAL_95 * (self.other_held * sd).abs();
            Bin { range: ranges[k], estimate: Sample { at, value, interval95: (value - half, value + half) } }
        };
        Some((0..components).map(|component| (0..=last).map(|k| bin(k, component)).collect()).collect())
    }
}

/// The value of a variable where a factor of it is as large as usual, positive if it ever is, and the factor there.
fn typical(values: &[f64], factors: &[f64]) -> (f64, f64) {
    let positive = factors.iter().any(|f| *f > 0.0);
    let kept = values.iter().zip(factors).filter(|(_, f)| !positive || **f > 0.0);
    let kept: Vec<(f64, f64)> = kept.map(|(x, f)| (*x, *f)).collect();
    let middle = median(kept.iter().map(|(_, f)| f.abs())).unwrap_or(1.0);
    let near = kept.iter().min_by(|a, b| (a.1.abs() - middle).abs().total_cmp(&(b.1.abs() - middle).abs()));
    near.copied().unwrap_or((0.0, 1.0))
}

/// Bounds of ranges between which equally many values lie, rising, from the first to the 99th percentile.
fn edges(values: &[f64], count: usize) -> Vec<f64> {
    let at = |i: usize| quantile(values.iter().copied(), 0.01 + 0.98 * i as f64 / count as f64);
    let mut edges: Vec<f64> = (0..=count).filter_map(at).collect();
    edges.dedup();
    edges
}

/// Least squares: the solution and its standard deviations in units of the noise; none where columns are not independent.
fn solved(columns: &DMatrix<f64>, left: &DVector<f64>) -> Option<(DVector<f64>, DVector<f64>)> {
    let size = DVector::from_fn(columns.ncols(), |j, _| columns.column(j).norm());
    if size.iter().any(|norm| !norm.is_finite() || *norm == 0.0) {
        return None;
    }
    let unit = DMatrix::from_fn(columns.nrows(), columns.ncols(), |i, j| columns[(i, j)] / size[j]);
    let eigen = (unit.transpose() * &unit).symmetric_eigen();
    if eigen.eigenvalues.iter().any(|value| *value < LEAST_EIGENVALUE) {
        return None;
    }
    let spread =
        DMatrix::from_fn(size.len(), size.len(), |i, j| eigen.eigenvectors[(i, j)] / eigen.eigenvalues[j].sqrt());
    let found = &spread * (spread.transpose() * (unit.transpose() * left));
    let deviations = DVector::from_fn(size.len(), |i, _| spread.row(i).norm() / size[i]);
    Some((found.component_div(&size), deviations))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two columns at 60° to each other: y = 2 a + 3 b; the variance of each is 1/sin² 60° over its square.
    #[test]
    fn least_squares_have_the_solution_and_deviations_of_their_closed_form() {
        let (a, b) = ([2.0, 0.0, 0.0], [0.5, 0.75_f64.sqrt(), 0.0]);
        let columns = DMatrix::from_fn(3, 2, |i, j| if j == 0 { a[i] } else { b[i] });
        let left = DVector::from_fn(3, |i, _| 2.0 * a[i] + 3.0 * b[i] + if i == 2 { 7.0 } else { 0.0 });
        let (found, sd) = solved(&columns, &left).unwrap();
        assert!((found[0] - 2.0).abs() < 1e-12 && (found[1] - 3.0).abs() < 1e-12, "{found}");
        let one = 0.75_f64.sqrt().recip();
        assert!((sd[0] - one / 2.0).abs() < 1e-12 && (sd[1] - one).abs() < 1e-12, "{sd}");
        let twice = DMatrix::from_fn(3, 2, |i, j| a[i] * (1.0 + j as f64));
        assert!(solved(&twice, &left).is_none());
        assert!(solved(&DMatrix::zeros(3, 1), &left).is_none());
    }

    #[test]
    fn ranges_hold_equally_many_values_and_none_is_empty() {
        let values: Vec<f64> = (0..1000).map(f64::from).collect();
        assert_eq!(edges(&values, 4), [10.0, 255.0, 500.0, 745.0, 990.0]);
        let rest: Vec<f64> = (0..1000).map(|i| f64::from((i - 700).max(0))).collect();
        assert_eq!(edges(&rest, 4), [0.0, 45.0, 290.0]);
    }

    /// Of −1, −2, 3, 4 and 10 the middle of those above 0 is 4.
    #[test]
    fn the_other_variable_is_held_where_its_factor_is_as_large_as_usual() {
        assert_eq!(typical(&[0.0, 1.0, 2.0, 3.0, 4.0], &[-1.0, -2.0, 3.0, 4.0, 10.0]), (3.0, 4.0));
        assert_eq!(typical(&[0.0, 1.0, 2.0], &[-1.0, -2.0, -3.0]), (1.0, -2.0));
    }
}
