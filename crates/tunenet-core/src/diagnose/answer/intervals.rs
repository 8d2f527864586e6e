//! 95 % intervals of shared parameters.

use nalgebra::{DMatrix, DVector};

use crate::Result;
use crate::diagnose::hypothesis::context::{Context, Hypothesis};
use crate::diagnose::judge::cluster_robust::{cluster_robust_half_widths, stretch_robust_half_widths};
use crate::diagnose::judge::recording_scores::calibration_moves;
use crate::statistics::NORMAL_95;

/// The intervals of a model's shared parameters.
pub(in crate::diagnose) struct Intervals<'a> {
    model: &'a Hypothesis<'a>,
    half: Vec<f64>,
    /// Whether the scatter between recordings made any of them wider.
    pub widened: bool,
}

impl<'a> Intervals<'a> {
    /// By the curvature of the fit, the noise's size taken from what is left; where recordings `differ` among themselves, or
    /// stretches of a driven one, at least as wide as their scatter; and by what is not known of parameters that stay fixed.
    ///
    /// # Errors
    /// Where the simulator refuses.
    pub fn new(context: &Context, model: &'a Hypothesis<'a>, differ: bool) -> Result<Self> {
        let size = model.structure.shared.len();
        let variance = context.variance(model);
        let mut half: Vec<f64> = (0..size)
            .map(|column| NORMAL_95 * (variance * model.fit.covariance[(column, column)].max(0.0)).sqrt())
            .collect();
        let between = if context.evidence.driven() {
            stretch_robust_half_widths(context, model)
        } else if differ {
            cluster_robust_half_widths(context, model)
        } else {
            Vec::new()
        };
        let mut widened = false;
        for (half, between) in half.iter_mut().zip(&between) {
            if let Some(between) = between.filter(|between| between > half) {
                (*half, widened) = (between, true);
            }
        }
        for moves in calibration_moves(context, model)? {
            half.iter_mut().zip(moves).for_each(|(half, moved)| *half = half.hypot(NORMAL_95 * moved));
        }
        Ok(Self { model, half, widened: widened && !context.evidence.driven() })
    }

    /// That of the shared parameter of this column, within the bounds of what can be simulated.
    pub fn of(&self, column: usize) -> (f64, f64) {
        let (p, value) = (&self.model.structure.shared[column].parameter, self.model.fit.point.parameters[column]);
        ((value - self.half[column]).max(p.min), (value + self.half[column]).min(p.max))
    }

    /// The shared parameter of an object, or of all, with this name, and its interval; `None` where the model has none.
    pub fn number(&self, object: Option<usize>, name: &str) -> Option<(f64, (f64, f64))> {
        let shared = &self.model.structure.shared;
        let column = shared.iter().position(|shared| shared.object == object && shared.parameter.name == name)?;
        Some((self.model.fit.point.parameters[column], self.of(column)))
    }

    /// The squared distance of the shared parameters of these `columns` from absence, in standard errors as wide as the intervals
    /// and correlated as in the fit (Wald 1943).
    pub fn squared_distance_from_absence(&self, columns: &[usize]) -> f64 {
        let (shared, covariance) = (&self.model.structure.shared, &self.model.fit.covariance);
        let distance = DVector::from_iterator(
            columns.len(),
            columns.iter().map(|&column| {
                let absent = shared[column].absent.map_or(0.0, |(value, _)| value);
                NORMAL_95 * (self.model.fit.point.parameters[column] - absent)
                    / self.half[column].max(f64::MIN_POSITIVE)
            }),
        );
        let correlation = DMatrix::from_fn(columns.len(), columns.len(), |i, j| {
            let (a, b) = (columns[i], columns[j]);
            let scale = (covariance[(a, a)] * covariance[(b, b)]).sqrt();
            if i == j || scale <= 0.0 { f64::from(i == j) } else { covariance[(a, b)] / scale }
        });
        correlation.cholesky().map_or(0.0, |factor| distance.dot(&factor.solve(&distance)))
    }
}
