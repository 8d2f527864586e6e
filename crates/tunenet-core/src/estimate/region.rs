//! Joint 95 % likelihood-ratio region of several parameters (Beale 1960).
//!
//! The region holds the values whose misfit, everything else fitted again, exceeds the least one by no more than noise does
//! in 95 of 100 recordings (a likelihood ratio). Where the misfit is quadratic this is an ellipse; where it is not, or a
//! bound cuts it, the boundary of a pair is walked.

use nalgebra::{DMatrix, DVector, Vector2};
use serde::Serialize;

use super::contour_ray::Ray;
use super::interval::{COARSE, Interval, LEVEL, ScaleEstimate, fit_along, fit_with_fixed};
use super::matrix_rows::rows_of_some;
use super::noise_model::weights;
use super::output_error::{Fit, Problem};
use super::problem::Point;
use crate::Result;
use crate::observation::Observation;
use crate::simulator::{Preparation, Prepared, Simulator};

/// The misfit at the ends of the ellipse's axes may stray from the quantile by this share; beyond, the ellipse is no picture
/// of the region.
const ELLIPTIC: f64 = 0.2;
/// Corners of a walked boundary.
const CORNERS: usize = 36;
/// The ellipse gives the rays their directions where no interval is this many times as long.
const SAME_SIZE: f64 = 2.0;

/// The joint 95 % region of the parameters that the data bear on.
#[derive(Debug, Clone, Serialize)]
pub struct Region {
    /// Their names.
    pub parameters: Vec<String>,
    /// The estimate, shape `[parameter]`.
    pub centre: Vec<f64>,
    /// Covariance of the estimate, the scatter and the autocorrelation of the residuals included, shape `[parameter, parameter]`.
    /// `None` where a parameter has no slope at the estimate, so that the region is no ellipse.
    #[serde(serialize_with = "rows_of_some")]
    pub covariance: Option<DMatrix<f64>>,
    /// The ellipse holds θ with (θ − centre)ᵀ covariance⁻¹ (θ − centre) ≤ this.
    pub quantile: f64,
    /// For a pair whose region is no ellipse within the bounds: the corners of its boundary, in order around it.
    pub boundary: Vec<[f64; 2]>,
    #[serde(skip)]
    scale: ScaleEstimate,
    #[serde(skip)]
    best: Point,
    #[serde(skip)]
    cost: f64,
    /// All positions that were fitted, and those of `parameters` among the simulator's.
    #[serde(skip)]
    free: Vec<usize>,
    #[serde(skip)]
    joint: Vec<usize>,
}

impl Region {
    /// The region of the free parameters at the places `joint` of `fit`, and the rollouts that it took. `intervals` are
    /// those of all free parameters, and scale the search for a boundary. It ends where the simulator refuses what lies beyond.
    #[must_use]
    pub fn of(
        problem: &Problem,
        fit: &Fit,
        scale: &ScaleEstimate,
        intervals: &[Interval],
        joint: &[usize],
    ) -> (Self, usize) {
        let mut region = Self::from_curvature(problem, fit, scale, joint);
        let mut rollouts = 0;
        let driven = problem.recordings.iter().all(|recording| recording.memoryless);
        if joint.len() == 2 && !driven {
            match region.shape(problem, fit, &mut rollouts) {
                Shape::Ellipse => {}
                Shape::CutEllipse => region.cut(problem),
                Shape::Other => region.walk(problem, [intervals[joint[0]], intervals[joint[1]]], &mut rollouts),
            }
        }
        (region, rollouts)
    }

    /// As [`of`](Region::of), from the curvature alone: an ellipse.
    pub(crate) fn from_curvature(problem: &Problem, fit: &Fit, scale: &ScaleEstimate, joint: &[usize]) -> Self {
        let covariance = DMatrix::from_fn(joint.len(), joint.len(), |a, b| {
            fit.covariance[(joint[a], joint[b])] * scale.variance * scale.inflation
        });
        let positions: Vec<usize> = joint.iter().map(|&j| problem.free[j]).collect();
        Self {
            parameters: positions.iter().map(|&i| problem.simulator.parameters()[i].name.clone()).collect(),
            centre: fit.point.at(&positions),
            covariance: covariance.iter().all(|v| v.is_finite()).then_some(covariance),
            quantile: scale.joint_quantile(joint.len(), LEVEL),
            boundary: Vec::new(),
            scale: *scale,
            best: fit.point.clone(),
            cost: fit.cost,
            free: problem.free.to_vec(),
            joint: positions,
        }
    }

    /// Whether the region holds `values`, in the order of [`parameters`](Region::parameters): everything else is fitted
    /// again with these held, and the misfit compared. `simulator` and `observations` are those that were tuned.
    ///
    /// # Errors
    /// Where the simulator refuses these values or observations.
    pub fn contains(&self, simulator: &dyn Simulator, observations: &[Observation], values: &[f64]) -> Result<bool> {
        let mut recordings: Vec<Prepared> = Vec::with_capacity(observations.len());
        for seen in observations {
            if let Preparation::Usable(prepared) = simulator.prepare(seen)? {
                recordings.push(*prepared);
            }
        }
        let noise: Vec<Vec<f64>> = recordings.iter().map(weights).collect();
        let problem = Problem { simulator, recordings: &recordings, noise: &noise, free: &self.free, log: None };
        Ok(self.excess(&problem, values, &mut 0)? <= self.quantile)
    }

    /// Whether the region as it is drawn holds `values`: its boundary where it was walked, its ellipse otherwise. Quicker
    /// than [`contains`](Region::contains), and only an approximation of it.
    #[must_use]
    pub fn draws(&self, values: &[f64]) -> bool {
        if !self.boundary.is_empty() {
            return inside(&self.boundary, [values[0], values[1]]);
        }
        let away = DVector::from_fn(values.len(), |i, _| values[i] - self.centre[i]);
        let root = self.covariance.clone().and_then(nalgebra::DMatrix::cholesky);
        root.is_some_and(|root| away.dot(&root.solve(&away)) <= self.quantile)
    }

    /// How far the misfit at `values`, all else fitted, lies above the least, in squares of standard deviations.
    fn excess(&self, problem: &Problem, values: &[f64], rollouts: &mut usize) -> Result<f64> {
        let fit = fit_with_fixed(problem, self.best.with(&self.joint, values), &self.joint, &self.scale)?;
        *rollouts += fit.rollouts;
        Ok(self.scale.excess(fit.cost - self.cost))
    }

    /// What the misfit at the ends of the ellipse's axes says of the region.
    fn shape(&self, problem: &Problem, fit: &Fit, rollouts: &mut usize) -> Shape {
        let Some(covariance) = &self.covariance else { return Shape::Other };
        let events = problem.recordings.iter().any(Prepared::has_events);
        let eigen = covariance.clone().symmetric_eigen();
        let mut cut = false;
        for (k, variance) in eigen.eigenvalues.iter().enumerate() {
            for side in [-1.0, 1.0] {
                let offset = side * (self.quantile * variance.max(0.0)).sqrt();
                let values: Vec<f64> =
                    self.centre.iter().zip(&eigen.eigenvectors.column(k)).map(|(c, axis)| c + offset * axis).collect();
                let within = values.iter().zip(&self.joint).all(|(v, &i)| {
                    let p = &problem.simulator.parameters()[i];
                    (p.min..=p.max).contains(v)
                });
                if !within {
                    if events {
                        return Shape::Other;
                    }
                    cut = true;
                    continue;
                }
                // What the simulator refuses bounds the region as well.
                let on = |excess: f64| (excess / self.quantile - 1.0).abs() <= ELLIPTIC;
                let along = fit_along(problem, fit, (&self.joint, &values), self.scale.cost(COARSE * self.quantile));
                let along = along.map(|there| {
                    *rollouts += there.rollouts;
                    self.scale.excess(there.cost - self.cost)
                });
                if !along.is_ok_and(on) && !self.excess(problem, &values, rollouts).is_ok_and(on) {
                    return Shape::Other;
                }
            }
        }
        let inside = self.joint.iter().zip(&self.centre).all(|(&i, value)| {
            let p = &problem.simulator.parameters()[i];
            p.min < *value && *value < p.max
        });
        match (cut, inside) {
            (false, _) => Shape::Ellipse,
            (true, true) => Shape::CutEllipse,
            (true, false) => Shape::Other,
        }
    }

    /// The boundary of an ellipse that the bounds cut, along rays from the estimate.
    fn cut(&mut self, problem: &Problem) {
        let Some(root) = self.covariance.clone().and_then(nalgebra::DMatrix::cholesky) else { return };
        let root = root.l() * self.quantile.sqrt();
        let bounds = [0, 1].map(|k| {
            let p = &problem.simulator.parameters()[self.joint[k]];
            (p.min - self.centre[k], p.max - self.centre[k])
        });
        for corner in 0..CORNERS {
            let (sin, cos) = (std::f64::consts::TAU * corner as f64 / CORNERS as f64).sin_cos();
            let direction = [root[(0, 0)] * cos, root[(1, 0)] * cos + root[(1, 1)] * sin];
            let room = |k: usize| {
                let bound = if direction[k] < 0.0 { bounds[k].0 } else { bounds[k].1 };
                if direction[k] == 0.0 { 1.0 } else { bound / direction[k] }
            };
            let length = 1f64.min(room(0)).min(room(1));
            self.boundary.push([0, 1].map(|k| self.centre[k] + length * direction[k]));
        }
    }

    /// Walks the boundary of a pair: along rays from the middle, the last place that the region holds.
    fn walk(&mut self, problem: &Problem, intervals: [Interval; 2], rollouts: &mut usize) {
        let ends = intervals.map(|i| [i.low.value, i.high.value]);
        let half = Vector2::from(ends.map(|[low, high]| ((high - low) / 2.0).max(f64::MIN_POSITIVE)));
        let estimate = Vector2::new(self.centre[0], self.centre[1]);
        // From the middle of the intervals all of a long region is seen; where it is bent, the middle may lie outside.
        let middle = Vector2::from(ends.map(|[low, high]| low.midpoint(high)));
        let held = self.excess(problem, middle.as_slice(), rollouts).is_ok_and(|excess| excess <= self.quantile);
        let origin = if held { middle } else { estimate };
        // The ellipse's own shape, or that of the intervals where it has none or is a small part of them: at a kink the
        // curvature speaks of one side only.
        let like = |c: &DMatrix<f64>| (0..2).all(|i| half[i] < SAME_SIZE * self.scale.quantile() * c[(i, i)].sqrt());
        let shape = self.covariance.clone().filter(like).and_then(nalgebra::DMatrix::cholesky);
        let shape = shape.map(|c| c.l() * self.quantile.sqrt());
        for corner in 0..CORNERS {
            let (sin, cos) = (std::f64::consts::TAU * corner as f64 / CORNERS as f64).sin_cos();
            let direction = shape.as_ref().map_or_else(
                || Vector2::new(half[0] * cos, half[1] * sin),
                |l| Vector2::new(l[(0, 0)] * cos, l[(1, 0)] * cos + l[(1, 1)] * sin),
            );
            let ray = Ray {
                problem,
                scale: &self.scale,
                positions: [self.joint[0], self.joint[1]],
                best: (&self.best, self.cost),
                origin: origin.into(),
                direction: direction.into(),
            };
            let (corner, used) = ray.edge(self.quantile);
            *rollouts += used;
            self.boundary.push(corner);
        }
    }
}

/// What a region of two parameters looks like.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Shape {
    /// An ellipse within the bounds.
    Ellipse,
    /// An ellipse that the bounds cut.
    CutEllipse,
    /// The misfit is not quadratic.
    Other,
}

/// Whether a polygon holds a place: a ray from it crosses the polygon's sides an odd number of times.
fn inside(corners: &[[f64; 2]], [x, y]: [f64; 2]) -> bool {
    let sides = corners.iter().zip(corners.iter().cycle().skip(1));
    let crossed = |([ax, ay], [bx, by]): (&[f64; 2], &[f64; 2])| {
        (*ay > y) != (*by > y) && x < ax + (y - ay) / (by - ay) * (bx - ax)
    };
    sides.filter(|s| crossed(*s)).count() % 2 == 1
}

#[cfg(test)]
mod tests {
    use super::inside;

    #[test]
    fn a_polygon_holds_what_lies_in_it() {
        let bent = [[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [1.0, 0.5], [0.0, 2.0]];
        assert!(inside(&bent, [0.2, 1.0]) && inside(&bent, [1.9, 1.0]) && inside(&bent, [1.0, 0.4]));
        assert!(!inside(&bent, [1.0, 1.0]) && !inside(&bent, [3.0, 0.5]) && !inside(&bent, [0.2, 2.1]));
    }
}
