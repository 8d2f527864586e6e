//! Linearised response (Ljung 1999, section 4.5): how the residuals of a fit answer to a piecewise-constant acceleration, with initial
//! states and parameters projected out (Frisch and Waugh 1933).

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use super::shape::{Range, Shape};
use super::space::{Carried, Host, Visit};
use super::term::{Factor, Term};
use crate::Result;
use crate::estimate::jacobian::Columns;
use crate::estimate::{Point, RolloutLog};
use crate::simulator::{Prepared, every, predict};
use crate::statistics::{mean, quantile};

/// Samples in a piece of constant acceleration, and most pieces of a recording.
const SAMPLES: usize = 3;
const MOST_PIECES: usize = 40;
/// Instants of a piece over which the factors of a term are averaged: an odd number, so that one is the middle.
pub(super) const INSTANTS: usize = 5;
/// Directions of the acceleration that change the record by less than this share of the strongest are left out.
const LEAST_SHARE: f64 = 1e-3;

/// One recording's part.
pub(super) struct Part {
    /// What the middle of each piece visits.
    pub visits: Vec<Visit>,
    /// What all instants of the pieces visit.
    all: Vec<Visit>,
    /// Response of the prediction in units of the noise, shape `[value, axis · piece]`.
    response: DMatrix<f64>,
    /// The response that is left, in its own coordinates, for each direction and component: shape `[coordinate, piece]`.
    reduced: Vec<Vec<DMatrix<f64>>>,
    /// The same for each axis.
    pub axes: Vec<DMatrix<f64>>,
    /// What of each coordinate the shared parameters explain, shape `[parameter, coordinate]`.
    explained: DMatrix<f64>,
    /// The orthonormal coordinates among the values.
    basis: DMatrix<f64>,
    /// An orthonormal basis of the nuisance parameters' columns.
    own: DMatrix<f64>,
    /// What of each value the shared parameters explain, shape `[value, parameter]`.
    tangents: DMatrix<f64>,
    /// The residuals in the coordinates.
    pub residual: DVector<f64>,
}

/// What a term changes, in the coordinates of all recordings, and what of it the shared parameters explain.
#[derive(Debug, Clone)]
pub(super) struct Column {
    coordinates: DVector<f64>,
    explained: DVector<f64>,
}

impl Column {
    pub fn coordinates(&self) -> &DVector<f64> {
        &self.coordinates
    }

    pub fn dot(&self, other: &Self) -> f64 {
        self.coordinates.dot(&other.coordinates) - self.explained.dot(&other.explained)
    }

    /// `(other − self) · by`.
    pub fn slope(&self, other: &Self, by: f64) -> Self {
        let of = |a: &DVector<f64>, b: &DVector<f64>| (b - a) * by;
        Self {
            coordinates: of(&self.coordinates, &other.coordinates),
            explained: of(&self.explained, &other.explained),
        }
    }

    /// The sum of columns, each as often as its coefficient says.
    pub fn sum(columns: &[Self], coefficients: &[f64]) -> Option<Self> {
        let mut each = columns.iter().zip(coefficients);
        let (first, by) = each.next()?;
        let mut sum = Self { coordinates: &first.coordinates * *by, explained: &first.explained * *by };
        for (column, by) in each {
            sum.coordinates.axpy(*by, &column.coordinates, 1.0);
            sum.explained.axpy(*by, &column.explained, 1.0);
        }
        Some(sum)
    }
}

/// The response of all recordings.
pub(super) struct Response {
    pub parts: Vec<Part>,
    /// The residuals as a column.
    pub left: Column,
    /// The same in the values themselves, of which a force can change only the coordinates.
    pub whole: Column,
    /// Their sum of squares after initial states and parameters.
    pub squares: f64,
    /// How many values there are.
    pub count: usize,
    /// Between which values the recordings move each variable.
    pub ranges: Vec<Range>,
    /// What is left of each recording without the law around which it was measured, in units of the noise.
    pub without: Vec<Vec<f64>>,
    /// The values of each variable at all instants of all recordings.
    variables: Vec<Vec<f64>>,
}

/// About what a response is measured: a recording with its noise, and a fit to it with the law that it has, if any.
pub(super) struct Fitted<'a> {
    pub recording: &'a Prepared,
    pub noise: &'a [f64],
    /// Of the base model, then the law's numbers.
    pub parameters: &'a [f64],
    pub nuisances: &'a [f64],
    pub residuals: &'a [f64],
    pub law: &'a [Carried],
    pub numbers: &'a [Vec<f64>],
}

impl<'a> Fitted<'a> {
    /// Each recording of a fit with a law.
    pub fn each(
        recordings: &'a [Prepared],
        noise: &'a [Vec<f64>],
        (point, residuals): (&'a Point, &'a [Vec<f64>]),
        (law, numbers): (&'a [Carried], &'a [Vec<f64>]),
    ) -> Vec<Self> {
        let one = |(d, recording): (usize, &'a Prepared)| Self {
            recording,
            noise: &noise[d],
            parameters: &point.parameters,
            nuisances: &point.nuisances[d],
            residuals: &residuals[d],
            law,
            numbers,
        };
        recordings.iter().enumerate().map(one).collect()
    }
}

impl Response {
    /// Measures it by rollouts, one for each piece, axis and recording; the columns are derivatives by the base model's parameters and by
    /// initial states.
    pub fn measure(host: &dyn Host, all: &[Fitted], columns: &[Columns], log: &RolloutLog) -> Result<Self> {
        let space = host.space();
        let (mut parts, mut without) = (Vec::new(), Vec::new());
        for of in all {
            let model = host.carrying(of.law)?;
            let clock = of.recording.seen.clock();
            let pieces = (clock.len() / SAMPLES).clamp(2, MOST_PIECES);
            let (first, last) = (clock[0], clock[clock.len() - 1]);
            let span_s = (last - first) / pieces as f64;
            let count = pieces * INSTANTS;
            let instant = |i: usize| first + span_s * (i as f64 + 0.5) / INSTANTS as f64;
            let instants: Vec<f64> = (0..count).map(instant).collect();
            let visits = model.visits(of.recording, of.parameters, of.nuisances, &instants)?;
            log.add(1);
            let response = response(host, of, (first, span_s, pieces), log)?;
            let mut left = of.residuals.to_vec();
            for (carried, numbers) in of.law.iter().zip(of.numbers) {
                let change = answer(&visits, &response, &carried.term, numbers);
                left.iter_mut().zip(change.iter()).for_each(|(left, change)| *left += change);
            }
            parts.push((visits, response));
            without.push(left);
        }
        let visited: Vec<&[Visit]> = parts.iter().map(|(visits, _)| visits.as_slice()).collect();
        let ranges = ranges(&visited, space.variables.len());
        Ok(Self::reduced(parts, without, columns, ranges, space.axes.len()))
    }

    /// The same where a fit leaves these residuals and has other derivatives by its parameters and by initial states.
    pub fn leaving(&self, without: Vec<Vec<f64>>, columns: &[Columns]) -> Self {
        let parts = self.parts.iter().map(|part| (part.all.clone(), part.response.clone())).collect();
        let axes = self.parts.first().map_or(0, |part| part.axes.len());
        Self::reduced(parts, without, columns, self.ranges.clone(), axes).counting(self.count)
    }

    /// The same of recordings that hold so many independent values.
    pub fn counting(self, count: usize) -> Self {
        Self { count, ..self }
    }

    fn reduced(
        parts: Vec<(Vec<Visit>, DMatrix<f64>)>,
        without: Vec<Vec<f64>>,
        columns: &[Columns],
        ranges: Vec<Range>,
        axes: usize,
    ) -> Self {
        let shared = columns.first().map_or(0, |c| c.shared.len());
        let count: usize = without.iter().map(Vec::len).sum();
        let owns: Vec<DMatrix<f64>> = columns.iter().map(|c| orthonormal(&c.nuisances)).collect();
        let clean = |d: usize, m: DMatrix<f64>| {
            let projected = &owns[d] * (owns[d].transpose() * &m);
            m - projected
        };
        let matrix = |columns: &[Vec<f64>], rows: usize| DMatrix::from_fn(rows, columns.len(), |i, j| columns[j][i]);
        let tangents: Vec<DMatrix<f64>> =
            columns.iter().zip(&without).enumerate().map(|(d, (c, r))| clean(d, matrix(&c.shared, r.len()))).collect();
        // The inverse root of the parameters' normal matrix makes their columns orthonormal.
        let normal = tangents.iter().fold(DMatrix::zeros(shared, shared), |sum, t| sum + t.transpose() * t);
        let root = inverse_root(&normal);
        let mut variables = vec![Vec::new(); ranges.len()];
        let (mut made, mut explained, mut residuals) = (Vec::new(), DVector::zeros(root.ncols()), Vec::new());
        for (d, (all, response)) in parts.into_iter().enumerate() {
            let visits: Vec<Visit> = all.iter().skip(INSTANTS / 2).step_by(INSTANTS).cloned().collect();
            let residual = clean(d, DMatrix::from_column_slice(without[d].len(), 1, &without[d]));
            let cleaned = clean(d, response.clone());
            let basis = basis(&cleaned);
            let along = basis.transpose() * &cleaned;
            let orthonormal = &tangents[d] * &root;
            explained += orthonormal.transpose() * residual.column(0);
            residuals.extend(residual.iter());
            for visit in &all {
                variables.iter_mut().zip(&visit.variables).for_each(|(all, value)| all.push(*value));
            }
            let pieces = visits.len();
            let axis = |a: usize| along.columns(a * pieces, pieces).into_owned();
            let axes: Vec<DMatrix<f64>> = (0..axes).map(axis).collect();
            let component = |direction: usize, c: usize| {
                let mut sum = DMatrix::zeros(along.nrows(), pieces);
                for (a, of_axis) in axes.iter().enumerate() {
                    for (b, visit) in visits.iter().enumerate() {
                        let share = visit.components[direction][c][a];
                        if share != 0.0 {
                            sum.column_mut(b).axpy(share, &of_axis.column(b), 1.0);
                        }
                    }
                }
                sum
            };
            let shape: Vec<usize> = visits.first().map_or(Vec::new(), |v| v.components.iter().map(Vec::len).collect());
            let reduced = (0..shape.len()).map(|k| (0..shape[k]).map(|c| component(k, c)).collect()).collect();
            made.push(Part {
                reduced,
                axes,
                explained: orthonormal.transpose() * &basis,
                residual: basis.transpose() * residual.column(0),
                own: owns[d].clone(),
                tangents: orthonormal,
                visits,
                all,
                response,
                basis,
            });
        }
        let left = Column { coordinates: stacked(made.iter().map(|p| &p.residual)), explained: explained.clone() };
        let whole = Column { coordinates: DVector::from_vec(residuals), explained };
        let squares = whole.dot(&whole);
        Self { parts: made, left, whole, squares, count, ranges, without, variables }
    }

    /// How many instants there are.
    pub fn instants(&self) -> usize {
        self.parts.iter().map(|part| part.all.len()).sum()
    }

    /// The values of a variable at all instants.
    pub fn variable(&self, variable: usize) -> &[f64] {
        &self.variables[variable]
    }

    /// The values of a factor at all instants.
    pub fn factor(&self, factor: &Factor, constants: &[f64]) -> Vec<f64> {
        let term = Term::new(0, 0, vec![Factor { variable: 0, ..factor.clone() }]);
        let each = self.variables[factor.variable].iter();
        each.map(|x| term.product(constants, &[*x], &[x.signum()])).collect()
    }

    /// What a direction times these values at all instants changes: a column for each of its components.
    pub fn columns(&self, direction: usize, values: &[f64]) -> Vec<Column> {
        let components = self.parts[0].reduced[direction].len();
        let pieces = self.pieces(values);
        let one = |c: usize| {
            let mut coordinates = Vec::new();
            let mut explained = DVector::zeros(self.left.explained.len());
            for (part, own) in self.parts.iter().zip(&pieces) {
                let along = &part.reduced[direction][c] * own;
                explained += &part.explained * &along;
                coordinates.extend(along.iter());
            }
            Column { coordinates: DVector::from_vec(coordinates), explained }
        };
        (0..components).map(one).collect()
    }

    /// What an acceleration changes that has these components along the axes where the middle of each piece is.
    pub fn accelerated(&self, along: impl Fn(&Visit) -> Vec<f64>) -> Column {
        let mut coordinates = Vec::new();
        let mut explained = DVector::zeros(self.left.explained.len());
        for part in &self.parts {
            let mut sum = DVector::zeros(part.residual.len());
            for (piece, visit) in part.visits.iter().enumerate() {
                let along = along(visit);
                part.axes.iter().zip(along).for_each(|(axis, by)| sum.axpy(by, &axis.column(piece), 1.0));
            }
            explained += &part.explained * &sum;
            coordinates.extend(sum.iter());
        }
        Column { coordinates: DVector::from_vec(coordinates), explained }
    }

    /// What a change of the predictions of each recording, in units of the noise, is next to initial states and parameters: a column in the
    /// values themselves.
    pub fn changed(&self, change: &[Vec<f64>]) -> Column {
        let (mut coordinates, mut explained) = (Vec::new(), DVector::zeros(self.whole.explained.len()));
        for (part, change) in self.parts.iter().zip(change) {
            let change = DVector::from_column_slice(change);
            let cleaned = &change - &part.own * part.own.tr_mul(&change);
            explained += part.tangents.tr_mul(&cleaned);
            coordinates.extend(cleaned.iter());
        }
        Column { coordinates: DVector::from_vec(coordinates), explained }
    }

    /// The means of these values at all instants over the pieces of each recording.
    fn pieces(&self, values: &[f64]) -> Vec<DVector<f64>> {
        let mut means = values.chunks_exact(INSTANTS).map(|instants| mean(instants.iter().copied()));
        let each = self.parts.iter().map(|part| {
            let own: Vec<f64> = means.by_ref().take(part.visits.len()).collect();
            DVector::from_vec(own)
        });
        each.collect()
    }

    /// The same with a column for each recording and component.
    pub fn own_columns(&self, direction: usize, values: &[f64]) -> Vec<Column> {
        let (mut row, mut columns) = (0, Vec::new());
        for (part, own) in self.parts.iter().zip(self.pieces(values)) {
            let rows = part.residual.len();
            for component in &part.reduced[direction] {
                let along = component * &own;
                let mut coordinates = DVector::zeros(self.dimension());
                coordinates.rows_mut(row, rows).copy_from(&along);
                columns.push(Column { coordinates, explained: &part.explained * &along });
            }
            row += rows;
        }
        columns
    }

    /// Residuals of another fit, or their derivatives by a parameter, in the coordinates.
    pub fn coordinates(&self, residuals: &[Vec<f64>]) -> DVector<f64> {
        let each = self.parts.iter().zip(residuals).map(|(part, of)| {
            let of = DVector::from_column_slice(of);
            part.basis.transpose() * (&of - &part.own * (part.own.transpose() * &of))
        });
        stacked(each.collect::<Vec<_>>().iter())
    }

    /// How the prediction of each recording answers to a term with these numbers.
    pub fn answer(&self, term: &Term, numbers: &[f64]) -> Vec<Vec<f64>> {
        let each = self.parts.iter().map(|part| answer(&part.all, &part.response, term, numbers));
        each.map(|change| change.iter().copied().collect()).collect()
    }

    /// The same of one recording.
    pub fn answer_of(&self, recording: usize, term: &Term, numbers: &[f64]) -> Vec<f64> {
        let part = &self.parts[recording];
        answer(&part.all, &part.response, term, numbers).iter().copied().collect()
    }

    /// How many coordinates all recordings have together.
    pub fn dimension(&self) -> usize {
        self.left.coordinates.len()
    }
}

/// How the prediction of one recording answers to a term.
fn answer(visits: &[Visit], response: &DMatrix<f64>, term: &Term, numbers: &[f64]) -> DVector<f64> {
    let pieces = visits.len() / INSTANTS;
    let axes = response.ncols() / pieces;
    let mut acceleration = DVector::zeros(response.ncols());
    let product = |visit: &Visit| {
        let sides: Vec<f64> = visit.variables.iter().map(|x| x.signum()).collect();
        term.product(numbers, &visit.variables, &sides)
    };
    for (b, piece) in visits.chunks_exact(INSTANTS).enumerate() {
        let visit = &piece[INSTANTS / 2];
        let product = mean(piece.iter().map(product));
        for (component, coefficient) in visit.components[term.direction].iter().zip(numbers) {
            for a in 0..axes {
                acceleration[a * pieces + b] += coefficient * product * component[a];
            }
        }
    }
    response * acceleration
}

/// The response of one recording by rollouts with a window of acceleration along each axis.
fn response(
    host: &dyn Host,
    of: &Fitted,
    (first, span_s, pieces): (f64, f64, usize),
    log: &RolloutLog,
) -> Result<DMatrix<f64>> {
    let space = host.space();
    let (recording, noise) = (of.recording, of.noise);
    let clock = recording.seen.clock();
    let weigh =
        |values: Vec<f64>| -> Vec<f64> { values.iter().enumerate().map(|(i, v)| v / noise[i % noise.len()]).collect() };
    let mut columns = Vec::new();
    let anywhere = Range { low: first, high: clock[clock.len() - 1], least: first, greatest: 1.0 };
    for &direction in &space.axes {
        let clock_variable = space.variables.iter().position(|v| v.nature == super::space::Nature::Clock).unwrap_or(0);
        let term = Term::new(direction, 1, vec![Factor::new(Shape::Window, clock_variable)]);
        let ranges = vec![anywhere; space.variables.len()];
        let window = term.carried(host, &ranges, of.law.len(), f64::MAX.sqrt());
        let with = host.carrying(&of.law.iter().cloned().chain([window]).collect::<Vec<_>>())?;
        let run = |a: f64, b: usize| {
            let (from, to) = (first + span_s * b as f64, first + span_s * (b + 1) as f64);
            let numbers: Vec<f64> = of.parameters.iter().copied().chain([a, from, to]).collect();
            predict(with.as_ref(), recording, &numbers, of.nuisances, clock).map(weigh)
        };
        // The size that moves the record by about its noise: measured with a first piece, then used for all.
        let still = run(0.0, 0)?;
        let guess = 1e-6 / (span_s * span_s).max(1e-12);
        let moved = run(guess, 0)?;
        let most = moved.iter().zip(&still).map(|(a, b)| (a - b).abs()).fold(1e-12, f64::max);
        let size = guess * (1.0 / most).clamp(1e-9, 1e9);
        log.add(pieces + 2);
        let column = |b: usize| -> Result<Vec<f64>> {
            let one = |a: f64| Ok(run(a, b)?.iter().zip(&still).map(|(m, s)| (m - s) / a).collect());
            one(size).or_else(|_: crate::Error| one(-size))
        };
        columns.extend(every((0..pieces).into_par_iter().map(column))?);
    }
    let rows = clock.len() * recording.seen.channels().len();
    Ok(DMatrix::from_fn(rows, columns.len(), |i, j| columns[j][i]))
}

/// Between which values of each variable these visits lie.
pub(super) fn ranges(recordings: &[&[Visit]], variables: usize) -> Vec<Range> {
    let one = |v: usize| {
        let all = || recordings.iter().copied().flatten().map(move |visit| visit.variables[v]);
        Range {
            low: quantile(all(), 0.01).unwrap_or(0.0),
            high: quantile(all(), 0.99).unwrap_or(1.0),
            least: all().fold(f64::INFINITY, f64::min),
            greatest: all().fold(0.0, |most, x| most.max(x.abs())),
        }
    };
    (0..variables).map(one).collect()
}

fn stacked<'a>(parts: impl Iterator<Item = &'a DVector<f64>>) -> DVector<f64> {
    DVector::from_vec(parts.flat_map(|part| part.iter().copied()).collect())
}

/// An orthonormal basis of these columns.
fn orthonormal(columns: &[Vec<f64>]) -> DMatrix<f64> {
    let rows = columns.first().map_or(0, Vec::len);
    if columns.is_empty() {
        return DMatrix::zeros(rows, 0);
    }
    let m = DMatrix::from_fn(rows, columns.len(), |i, j| columns[j][i]);
    let root = inverse_root(&(m.transpose() * &m));
    m * root
}

/// A matrix R with R Rᵀ = M of the symmetric, not negative M.
pub(super) fn root(m: &DMatrix<f64>) -> DMatrix<f64> {
    let n = m.nrows();
    let scale = DVector::from_fn(n, |i, _| m[(i, i)].max(0.0).sqrt());
    let unit = |i: usize, j: usize| {
        let both = scale[i] * scale[j];
        if both > 0.0 && both.is_finite() { m[(i, j)] / both } else { f64::from(u8::from(i == j)) }
    };
    let eigen = DMatrix::from_fn(n, n, unit).symmetric_eigen();
    let spread = |i: usize| if scale[i].is_finite() { scale[i] } else { 0.0 };
    DMatrix::from_fn(n, n, |i, j| spread(i) * eigen.eigenvectors[(i, j)] * eigen.eigenvalues[j].max(0.0).sqrt())
}

/// A matrix R with Rᵀ M R = 1 on the span of the symmetric M.
pub(super) fn inverse_root(m: &DMatrix<f64>) -> DMatrix<f64> {
    let n = m.nrows();
    if n == 0 {
        return DMatrix::zeros(0, 0);
    }
    let scale = DVector::from_fn(n, |i, _| m[(i, i)].max(f64::MIN_POSITIVE).sqrt().recip());
    let scaled = DMatrix::from_fn(n, n, |i, j| m[(i, j)] * scale[i] * scale[j]);
    if scaled.iter().any(|v| !v.is_finite()) {
        return DMatrix::zeros(n, 0);
    }
    let eigen = scaled.symmetric_eigen();
    let kept: Vec<usize> = (0..n).filter(|&i| eigen.eigenvalues[i] > 1e-10).collect();
    DMatrix::from_fn(n, kept.len(), |i, j| {
        scale[i] * eigen.eigenvectors[(i, kept[j])] / eigen.eigenvalues[kept[j]].sqrt()
    })
}

/// The left singular vectors of a response that matter.
fn basis(response: &DMatrix<f64>) -> DMatrix<f64> {
    let eigen = (response.transpose() * response).symmetric_eigen();
    let greatest = eigen.eigenvalues.iter().fold(0.0_f64, |most, v| most.max(*v));
    let least = (LEAST_SHARE * LEAST_SHARE * greatest).max(f64::MIN_POSITIVE);
    let kept: Vec<usize> = (0..eigen.eigenvalues.len()).filter(|&i| eigen.eigenvalues[i] > least).collect();
    let right = DMatrix::from_fn(response.ncols(), kept.len(), |i, j| {
        eigen.eigenvectors[(i, kept[j])] / eigen.eigenvalues[kept[j]].sqrt()
    });
    response * right
}
