//! Jacobian of the residuals by forward differences, one-sided at a bound or where the simulator refuses (Nocedal and Wright
//! 2006, section 8.1).

use rayon::prelude::*;

use super::problem::{DIFFERENCE_STEP, LeastSquares, Point};
use crate::simulator::{Parameter, every};
use crate::{Error, Result};

/// Derivatives of one recording's residuals.
#[derive(Debug, Clone)]
pub(crate) struct Columns {
    /// Positions of the shared parameters in [`Point::parameters`].
    pub indices: Vec<usize>,
    /// A column for each of them, shape `[index][sample · channel]`.
    pub shared: Vec<Vec<f64>>,
    /// A column for each nuisance parameter, shape `[nuisance parameter][sample · channel]`.
    pub nuisances: Vec<Vec<f64>>,
}

impl Columns {
    /// How many there are: each took one rollout.
    pub fn count(&self) -> usize {
        self.shared.len() + self.nuisances.len()
    }

    /// These, and those by the shared parameters of `more`.
    pub fn with(&self, more: &Self) -> Self {
        Self {
            indices: [self.indices.as_slice(), &more.indices].concat(),
            shared: self.shared.iter().chain(&more.shared).cloned().collect(),
            nuisances: self.nuisances.clone(),
        }
    }
}

/// Derivatives at `point`, where the residuals are `residuals`.
///
/// # Errors
/// Where the simulator refuses both sides of a direction, unless that counts as
/// [flat](LeastSquares::flat_where_refused), or where it failed.
pub(crate) fn jacobian(problem: &dyn LeastSquares, point: &Point, residuals: &[Vec<f64>]) -> Result<Vec<Columns>> {
    let recordings = problem.recordings();
    let indices: Vec<Vec<usize>> = recordings.iter().map(|&d| problem.touched(d)).collect();
    let nuisances = |k: usize| problem.nuisances(recordings[k]).len().min(point.nuisances[recordings[k]].len());
    let tasks: Vec<(usize, usize)> = (0..recordings.len())
        .flat_map(|k| (0..indices[k].len() + nuisances(k)).map(move |column| (k, column)))
        .collect();
    let column = |&(k, column): &(usize, usize)| -> Result<Vec<f64>> {
        let d = recordings[k];
        let moved = |direction: f64| {
            let (mut parameters, mut nuisances) = (point.parameters.clone(), point.nuisances[d].clone());
            let step = if let Some(&index) = indices[k].get(column) {
                nudge(&mut parameters[index], problem.parameter(index), direction * problem.step(index))
            } else {
                let i = column - indices[k].len();
                let p = &problem.nuisances(d)[i];
                nudge(&mut nuisances[i], p, direction * DIFFERENCE_STEP * p.span())
            };
            problem.residual(d, &parameters, &nuisances).map(|r| (r, step))
        };
        // On the edge of what can be simulated (a start that touches a surface) only one side exists, or none.
        let (mut values, step) = match moved(1.0).or_else(|_| moved(-1.0)) {
            Ok(found) => found,
            Err(broken @ Error::SimulatorBroken { .. }) => return Err(broken),
            Err(_) if problem.flat_where_refused() => return Ok(vec![0.0; residuals[k].len()]),
            Err(refused) => return Err(refused),
        };
        values.iter_mut().zip(&residuals[k]).for_each(|(m, r)| *m = (*m - r) / step);
        Ok(values)
    };
    let mut columns = every(tasks.par_iter().map(column))?.into_iter();
    let gather = |(k, indices): (usize, Vec<usize>)| Columns {
        shared: columns.by_ref().take(indices.len()).collect(),
        nuisances: columns.by_ref().take(nuisances(k)).collect(),
        indices,
    };
    Ok(indices.into_iter().enumerate().map(gather).collect())
}

/// Moves `value` by `step`, inward where it would leave the bounds; returns the step taken.
fn nudge(value: &mut f64, parameter: &Parameter, step: f64) -> f64 {
    let before = *value;
    *value += if (parameter.min..=parameter.max).contains(&(before + step)) { step } else { -step };
    *value - before
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::estimate::problem::residuals;
    use crate::estimate::problem::tests::Lines;

    #[test]
    fn a_line_has_the_negative_clock_as_its_column() {
        let lines = Lines::new(1.0, &[0.5, -0.5]);
        // In the middle, on the upper end of what is not refused, and on the lower bound.
        for b in [0.0, 9.0, -10.0] {
            let point = lines.start().with(&[1], &[b]);
            let found = jacobian(&lines, &point, &residuals(&lines, &point).unwrap()).unwrap();
            for one in found {
                assert_eq!((one.count(), &one.indices), (2, &vec![1]));
                let right = |(c, t): (&f64, &f64)| (c + t).abs() < 1e-8;
                assert!(one.shared[0].iter().zip(&lines.clock).all(right), "{b}: {:?}", one.shared);
                assert!(one.nuisances[0].iter().all(|c| (c + 1.0).abs() < 1e-8), "{:?}", one.nuisances);
            }
        }
    }

    #[test]
    fn a_step_that_would_leave_the_bounds_goes_inward() {
        let p = Parameter::new("p", "1", 1.0, 0.0, 1.0).unwrap();
        let mut value = 1.0;
        assert_eq!((nudge(&mut value, &p, 0.25), value), (-0.25, 0.75));
    }

    #[test]
    fn a_direction_refused_on_both_sides_is_an_error() {
        let lines = Lines::new(1.0, &[0.0]);
        assert!(jacobian(&lines, &lines.start().with(&[1], &[9.5]), &[vec![0.0; 4]]).is_err());
    }
}
