//! A hypothesis as a least-squares problem: shared parameters and coefficients of all objects with every recording's nuisance
//! parameters.

use nalgebra::DMatrix;
use rayon::prelude::*;

use super::structure::Structure;
use crate::Result;
use crate::diagnose::evidence::recording::PreparedRecording;
use crate::estimate::RolloutLog;
use crate::estimate::huber::huber_cost;
use crate::estimate::jacobian::{Columns, grouped, grouped_jacobian, jacobian};
use crate::estimate::levenberg_marquardt::{Settings, minimise};
use crate::estimate::problem::{
    DIFFERENCE_STEP, LeastSquares, leading_samples, prior_cost, residuals as residuals_at, robust_scale,
};
use crate::simulator::{Parameter, every};

pub(in crate::diagnose) use crate::estimate::Point;

/// Difference step of a coefficient, as a share of a small visible one.
const COEFFICIENT_STEP: f64 = 1e-3;
/// The same where dry friction bends the slope within that step: as fine as the steps of parameters.
const FINE_STEP: f64 = 1e-5;
/// Candidates are compared by costs in steps of 0.5, so that a fit ends early.
const SETTINGS: Settings = Settings {
    steps: 40,
    derivatives: 12,
    damping: 1e-4,
    least_damping: 1e-10,
    greatest_damping: 1e8,
    still: 1e-11,
    tolerance_share: 5e-5,
    tolerance: 0.02,
    small_steps: 1,
    predicts: true,
    ends_measured: false,
    ..Settings::EXACT
};
/// How far a refused start is moved, as shares of the bounds.
const MOVES: [f64; 4] = [1e-4, 1e-3, 1e-2, 0.1];
/// A step of a parameter that would cross a bound goes so much of the way there.
const NEARER: f64 = 0.9;

/// How far a fit goes.
#[derive(Clone, Copy)]
pub(in crate::diagnose) struct Effort {
    pub steps: usize,
    /// Most times that derivatives are measured.
    pub derivatives: usize,
    /// Whether the last step has to be one by measured derivatives: the covariance is that of the last step.
    pub ends_measured: bool,
    /// A step that gains less than this in cost ends it; a half of 1 is what the noise of one sample is worth.
    pub tolerance: f64,
    /// The share of each recording that is fitted.
    pub horizon: f64,
    /// A fit that costs more than this after some steps ends.
    pub hopeless: f64,
}

/// Derivatives that are known before a fit.
#[derive(Clone, Copy)]
pub(in crate::diagnose) struct Known<'c> {
    /// Of each recording.
    columns: &'c [Columns],
    /// Whether they were measured at the start, instead of at a point not far from it.
    at_start: bool,
}

impl<'c> Known<'c> {
    /// Those at the start.
    pub fn measured(columns: &'c [Columns]) -> Self {
        Self { columns, at_start: true }
    }

    /// Those not far from the start.
    pub fn nearby(columns: &'c [Columns]) -> Self {
        Self { columns, at_start: false }
    }
}

/// Which derivatives.
#[derive(Clone, Copy)]
pub(in crate::diagnose) struct Which {
    /// Over this share of each recording.
    pub horizon: f64,
    /// By shared parameters from this one on ...
    pub first: usize,
    /// ... and by the nuisance parameters.
    pub nuisances: bool,
    /// By steps of a visible size: some coefficients (the time a shutter is open) have no slope at all where they are absent.
    pub visibly: bool,
}

impl Which {
    pub const ALL: Self = Self { horizon: 1.0, first: 0, nuisances: true, visibly: false };
}

/// What a fit ended with.
#[derive(Clone)]
pub(in crate::diagnose) struct Outcome {
    pub point: Point,
    /// White residuals in units of the noise, shape `[recording][sample · channel]`.
    pub residuals: Vec<Vec<f64>>,
    /// Half the robust sum of squares with that of the nuisance parameters from their priors.
    pub cost: f64,
    /// Residuals beyond 4 times this count by their absolute value.
    pub scale: f64,
    /// The part of the cost that the priors have.
    pub prior_part: f64,
    /// Covariance of the shared parameters for noise as stated.
    pub covariance: DMatrix<f64>,
    /// Whether the fit ended without hope: the cost of a minimum would be lower.
    pub abandoned: bool,
}

/// Recordings that have shared parameters in common, and those parameters.
pub(in crate::diagnose) struct Part {
    /// Positions among the recordings.
    pub recordings: Vec<usize>,
    /// Positions among the structure's shared parameters.
    pub columns: Vec<usize>,
}

/// A structure and the recordings that it is fitted to.
pub(in crate::diagnose) struct Joint<'a> {
    pub structure: &'a Structure<'a>,
    pub recordings: &'a [PreparedRecording],
    /// Whether a rollout shows derivatives by parameters of several channels.
    pub separable: bool,
    /// Counts rollouts against the allowance.
    pub rollouts: &'a RolloutLog,
}

/// A part of a joint problem.
struct Portion<'a> {
    joint: &'a Joint<'a>,
    part: &'a Part,
    which: Which,
}

impl LeastSquares for Portion<'_> {
    fn free(&self) -> &[usize] {
        &self.part.columns
    }

    fn recordings(&self) -> &[usize] {
        &self.part.recordings
    }

    fn parameter(&self, position: usize) -> &Parameter {
        &self.joint.structure.shared[position].parameter
    }

    fn touched(&self, recording: usize) -> Vec<usize> {
        let mut touched = self.joint.structure.columns(self.joint.recordings[recording].object);
        touched.retain(|column| self.part.columns.contains(column));
        touched
    }

    fn nuisances(&self, recording: usize) -> &[Parameter] {
        if self.which.nuisances { &self.joint.recordings[recording].prepared.nuisances } else { &[] }
    }

    fn prior_sd(&self, recording: usize, i: usize) -> f64 {
        self.joint.recordings[recording].prior_sd[i]
    }

    fn residual(&self, recording: usize, parameters: &[f64], nuisances: &[f64]) -> Result<Vec<f64>> {
        let samples = self.joint.samples(recording, self.which.horizon);
        let mut values = self.joint.plain(recording, parameters, nuisances, samples)?;
        self.joint.recordings[recording].filter.apply(&mut values);
        Ok(values)
    }

    fn scale(&self, residuals: &[Vec<f64>]) -> f64 {
        self.joint.scale(residuals)
    }

    fn step(&self, position: usize) -> f64 {
        let shared = &self.joint.structure.shared[position];
        match shared.absent {
            Some((_, typical)) if self.which.visibly => typical,
            Some((_, typical)) if self.joint.recordings.iter().any(|r| r.prepared.discrepancy) => FINE_STEP * typical,
            Some((_, typical)) => COEFFICIENT_STEP * typical,
            None => DIFFERENCE_STEP * shared.parameter.span(),
        }
    }

    fn width(&self) -> usize {
        self.joint.width()
    }

    fn is_separable(&self) -> bool {
        self.joint.separable
    }

    /// A coefficient on which the data are silent stays put.
    fn ridge(&self, position: usize) -> f64 {
        let shared = &self.joint.structure.shared[position];
        if shared.effect.is_some() { shared.parameter.span().powi(-2) } else { 0.0 }
    }

    /// Where a system loses nothing, a rollout may take for ever; a parameter goes only near such a bound.
    fn stepped(&self, position: usize, value: f64, step: f64) -> f64 {
        let shared = &self.joint.structure.shared[position];
        let bound = (value + step).clamp(shared.parameter.min, shared.parameter.max);
        let short = shared.effect.is_none() && bound != value + step;
        value + if short { NEARER * (bound - value) } else { bound - value }
    }

    /// Nothing is known of a direction that is refused on both sides.
    fn flat_where_refused(&self) -> bool {
        true
    }
}

impl Joint<'_> {
    /// How many channels the recordings have.
    pub fn width(&self) -> usize {
        self.recordings.first().map_or(1, PreparedRecording::width)
    }

    /// Of columns from `first` on, those that one rollout shows, so that each group is one.
    pub fn groups(&self, first: usize) -> Vec<Vec<usize>> {
        let columns: Vec<usize> = (first..self.structure.shared.len()).collect();
        if !self.separable {
            return columns.into_iter().map(|column| vec![column]).collect();
        }
        let own = |&column: &usize| self.structure.shared[column].parameter.channels.as_deref();
        let groups = grouped(&columns.iter().map(own).collect::<Vec<_>>());
        groups.into_iter().map(|group| group.into_iter().map(|position| columns[position]).collect()).collect()
    }

    fn samples(&self, index: usize, horizon: f64) -> usize {
        leading_samples(self.recordings[index].clock().len(), horizon)
    }

    /// Measured − predicted of the recording at `index` in its own unit, over its first `samples`.
    pub fn plain(&self, index: usize, shared: &[f64], nuisances: &[f64], samples: usize) -> Result<Vec<f64>> {
        let recording = &self.recordings[index];
        let mut parameters = self.structure.parameters(recording.object, shared);
        let simulator = self.structure.simulator(recording.object);
        let nuisances = recording.with_deviation(&mut parameters, simulator.parameters(), nuisances);
        let (of, values) = ((recording.object, simulator), (parameters.as_slice(), nuisances));
        let mut values = self.rollouts.predict_of(of, &recording.prepared, values, &recording.clock()[..samples])?;
        values.iter_mut().zip(recording.prepared.seen.values()).for_each(|(value, seen)| *value = seen - *value);
        Ok(values)
    }

    /// Measured − predicted in the channels' own units, shape `[recording][sample · channel]`.
    pub fn plain_residuals(&self, point: &Point) -> Result<Vec<Vec<f64>>> {
        let each = |d: usize| self.plain(d, &point.parameters, &point.nuisances[d], self.recordings[d].clock().len());
        every((0..self.recordings.len()).into_par_iter().map(each))
    }

    /// White residuals over the first share `horizon` of each recording.
    pub fn residuals(&self, point: &Point, horizon: f64) -> Result<Vec<Vec<f64>>> {
        let part = self.whole();
        residuals_at(&Portion { joint: self, part: &part, which: Which { horizon, ..Which::ALL } }, point)
    }

    /// Derivatives of the white residuals at `point`, where they are `residuals`.
    pub fn columns(&self, point: &Point, residuals: &[Vec<f64>], which: Which) -> Vec<Columns> {
        self.columns_of(point, residuals, which, |_| true)
    }

    /// The same by those shared parameters alone that pass a test.
    pub fn columns_of(
        &self,
        point: &Point,
        residuals: &[Vec<f64>],
        which: Which,
        wanted: impl Fn(&usize) -> bool,
    ) -> Vec<Columns> {
        let mut part = self.whole();
        part.columns.retain(|column| *column >= which.first && wanted(column));
        // Flat where refused, so that there is no error.
        let portion = Portion { joint: self, part: &part, which };
        let found = if self.separable {
            grouped_jacobian(&portion, point, residuals).map(|(columns, _)| columns)
        } else {
            jacobian(&portion, point, residuals)
        };
        found.unwrap_or_default()
    }

    fn whole(&self) -> Part {
        Part { recordings: (0..self.recordings.len()).collect(), columns: (0..self.structure.shared.len()).collect() }
    }

    /// Recordings and shared parameters that hang together. A parameter that all objects share joins all.
    pub fn parts(&self) -> Vec<Part> {
        let shared = &self.structure.shared;
        let objects = self.recordings.iter().map(|r| r.object).max().map_or(0, |o| o + 1);
        if objects < 2 || shared.iter().any(|parameter| parameter.object.is_none()) {
            return vec![self.whole()];
        }
        let part = |object: usize| Part {
            recordings: (0..self.recordings.len()).filter(|&d| self.recordings[d].object == object).collect(),
            columns: (0..shared.len()).filter(|&column| shared[column].object == Some(object)).collect(),
        };
        (0..objects).map(part).filter(|part| !part.recordings.is_empty()).collect()
    }

    /// Fits from `start`.
    ///
    /// # Errors
    /// Where the simulator refuses the start; a refused step is only shortened.
    pub fn fit(&self, mut start: Point, effort: Effort) -> Result<Outcome> {
        let residuals = self.residuals(&start, effort.horizon).or_else(|_| {
            (0..self.recordings.len()).for_each(|d| self.admit(d, &mut start, effort.horizon));
            self.residuals(&start, effort.horizon)
        })?;
        self.fit_from(start, residuals, effort, None)
    }

    /// Fits from `start`, where derivatives by all but the shared parameters from the position `known` on are near to `columns`.
    ///
    /// # Errors
    /// Where the simulator refuses the start.
    pub fn fit_extended(&self, start: Point, (columns, known): (&[Columns], usize), effort: Effort) -> Result<Outcome> {
        let residuals = self.residuals(&start, 1.0)?;
        let which = Which { first: known, nuisances: false, ..Which::ALL };
        let own = self.columns(&start, &residuals, which);
        let first: Vec<Columns> = columns.iter().zip(&own).map(|(known, own)| known.with(own)).collect();
        self.fit_from(start, residuals, effort, Some(Known::nearby(&first)))
    }

    /// The outcome at `point`, without a step.
    pub fn evaluate(&self, point: Point) -> Result<Outcome> {
        let residuals = self.residuals(&point, 1.0)?;
        self.fit_from(
            point,
            residuals,
            Effort {
                steps: 0,
                derivatives: 1,
                ends_measured: true,
                tolerance: 0.0,
                horizon: 1.0,
                hopeless: f64::INFINITY,
            },
            None,
        )
    }

    /// Moves the start of the recording at `index`, if the simulator refuses it (a body inside a surface), to the nearest one
    /// that the simulator accepts, one nuisance parameter at a time.
    fn admit(&self, index: usize, start: &mut Point, horizon: f64) {
        let samples = self.samples(index, horizon);
        let taken = |nuisances: &[f64]| self.plain(index, &start.parameters, nuisances, samples).is_ok();
        if taken(&start.nuisances[index]) {
            return;
        }
        for share in MOVES {
            for (i, unknown) in self.recordings[index].prepared.nuisances.iter().enumerate() {
                for direction in [1.0, -1.0] {
                    let mut nuisances = start.nuisances[index].clone();
                    nuisances[i] = (nuisances[i] + direction * share * unknown.span()).clamp(unknown.min, unknown.max);
                    if taken(&nuisances) {
                        start.nuisances[index] = nuisances;
                        return;
                    }
                }
            }
        }
    }

    /// The same where the residuals at the start are known, and derivatives may be.
    ///
    /// Objects that share no parameter are fitted each on its own: a step that one of them refuses holds up no other,
    /// and costs no rollout of it.
    pub fn fit_from(
        &self,
        start: Point,
        residuals: Vec<Vec<f64>>,
        effort: Effort,
        known: Option<Known>,
    ) -> Result<Outcome> {
        Ok(self.fit_keeping(start, residuals, effort, known)?.0)
    }

    /// The same with the derivatives in use at the end, which are of a point not far from it; none where none were needed.
    pub fn fit_keeping(
        &self,
        start: Point,
        mut residuals: Vec<Vec<f64>>,
        effort: Effort,
        known: Option<Known>,
    ) -> Result<(Outcome, Option<Vec<Columns>>)> {
        let Effort { steps, derivatives, ends_measured, tolerance, hopeless, .. } = effort;
        // Derivatives of several parameters by one rollout are those of a point not far away.
        let first_measured = known.is_none_or(|known| known.at_start && !self.separable);
        let settings = Settings { steps, derivatives, tolerance, ends_measured, hopeless, first_measured, ..SETTINGS };
        let parts = self.parts();
        let one = |part: &Part| {
            let residuals = part.recordings.iter().map(|&d| residuals[d].clone()).collect();
            let first = known.map(|known| part.recordings.iter().map(|&d| known.columns[d].clone()).collect());
            let portion = Portion { joint: self, part, which: Which { horizon: effort.horizon, ..Which::ALL } };
            minimise(&portion, start.clone(), residuals, first, &settings, &mut |_, _| {})
        };
        let fitted = every(parts.par_iter().map(one))?;
        let abandoned = fitted.iter().any(|part| part.abandoned);
        let size = self.structure.shared.len();
        let mut covariance = DMatrix::from_diagonal_element(size, size, f64::INFINITY);
        let (mut point, mut nearby) = (start, vec![None; self.recordings.len()]);
        for (part, fitted) in parts.iter().zip(fitted) {
            let among = fitted.equations.covariance();
            for (i, &row) in part.columns.iter().enumerate() {
                point.parameters[row] = fitted.point.parameters[row];
                for (j, &column) in part.columns.iter().enumerate() {
                    covariance[(row, column)] = among[(i, j)];
                }
            }
            for (&recording, columns) in part.recordings.iter().zip(fitted.nearby.unwrap_or_default()) {
                nearby[recording] = Some(columns);
            }
            for (&recording, left) in part.recordings.iter().zip(fitted.residuals) {
                point.nuisances[recording].clone_from(&fitted.point.nuisances[recording]);
                residuals[recording] = left;
            }
        }
        let part = self.whole();
        let prior_part = prior_cost(&Portion { joint: self, part: &part, which: Which::ALL }, &point);
        let scale = self.scale(&residuals);
        let cost = huber_cost(&residuals, scale) + prior_part;
        Ok((Outcome { point, residuals, cost, scale, prior_part, covariance, abandoned }, nearby.into_iter().collect()))
    }

    /// The scale of the robust loss.
    fn scale(&self, residuals: &[Vec<f64>]) -> f64 {
        self.recordings.first().map_or(1.0, |recording| recording.loss_scale) * spread(residuals)
    }
}

/// The robust size of white residuals; those that do not count are 0 and say nothing of it.
pub(in crate::diagnose) fn spread(residuals: &[Vec<f64>]) -> f64 {
    let counted: Vec<f64> = residuals.iter().flatten().copied().filter(|r| *r != 0.0).collect();
    if counted.is_empty() { 1.0 } else { robust_scale(&[counted]) }
}
