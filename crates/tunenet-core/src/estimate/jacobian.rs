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
    /// How many there are.
    pub fn count(&self) -> usize {
        self.shared.len() + self.nuisances.len()
    }

    /// Those of the first `values` residuals.
    pub fn leading(&self, values: usize) -> Self {
        let first = |columns: &[Vec<f64>]| columns.iter().map(|c| c[..values.min(c.len())].to_vec()).collect();
        Self { indices: self.indices.clone(), shared: first(&self.shared), nuisances: first(&self.nuisances) }
    }

    /// Without the shared parameters that are not at one of these positions, which rise; the others are numbered anew.
    pub fn at(&self, positions: &[usize]) -> Self {
        let kept = self.indices.iter().zip(&self.shared);
        let kept = kept.filter_map(|(index, column)| Some((positions.binary_search(index).ok()?, column.clone())));
        let (indices, shared) = kept.unzip();
        Self { indices, shared, nuisances: self.nuisances.clone() }
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
    let all = |k: usize| (0..touched(problem, point, k)).map(|column| vec![column]).collect();
    Ok(measured(problem, point, residuals, all)?.0)
}

/// The same by fewer rollouts, and how many: a shared parameter that acts [directly](Parameter::channels) on channels of its own is moved
/// together with those that act on others, and what it does to theirs counts as nothing (Curtis, Powell and Reid 1974).
///
/// # Errors
/// As [`jacobian`].
pub(crate) fn grouped_jacobian(
    problem: &dyn LeastSquares,
    point: &Point,
    residuals: &[Vec<f64>],
) -> Result<(Vec<Columns>, usize)> {
    let groups = |k: usize| {
        let shared = problem.touched(problem.recordings()[k]);
        let own: Vec<_> = shared.iter().map(|&index| problem.parameter(index).channels.as_deref()).collect();
        let mut groups = grouped(&own);
        groups.extend((shared.len()..touched(problem, point, k)).map(|column| vec![column]));
        groups
    };
    measured(problem, point, residuals, groups)
}

/// Groups of columns of which no two act on the same channel; `own` are the channels on which each acts directly.
pub(crate) fn grouped(own: &[Option<&[usize]>]) -> Vec<Vec<usize>> {
    let mut groups: Vec<(Vec<usize>, Vec<usize>)> = Vec::new();
    for (position, own) in own.iter().enumerate() {
        let apart = |taken: &[usize]| own.is_some_and(|own| own.iter().all(|channel| !taken.contains(channel)));
        // Of a parameter that may act on any channel, the group is taken by none and open to none.
        match groups.iter_mut().find(|(taken, _)| !taken.is_empty() && apart(taken)) {
            Some((taken, group)) => {
                taken.extend(own.iter().copied().flatten());
                group.push(position);
            }
            None => groups.push((own.map_or_else(Vec::new, <[usize]>::to_vec), vec![position])),
        }
    }
    groups.into_iter().map(|(_, group)| group).collect()
}

/// How many derivatives the recording at `k` has.
fn touched(problem: &dyn LeastSquares, point: &Point, k: usize) -> usize {
    let d = problem.recordings()[k];
    problem.touched(d).len() + problem.nuisances(d).len().min(point.nuisances[d].len())
}

/// Derivatives by rollouts that each move a group of columns: those of a recording by its position, the shared parameters first.
fn measured(
    problem: &dyn LeastSquares,
    point: &Point,
    residuals: &[Vec<f64>],
    groups: impl Fn(usize) -> Vec<Vec<usize>>,
) -> Result<(Vec<Columns>, usize)> {
    let recordings = problem.recordings();
    let indices: Vec<Vec<usize>> = recordings.iter().map(|&d| problem.touched(d)).collect();
    let tasks: Vec<(usize, Vec<usize>)> =
        (0..recordings.len()).flat_map(|k| groups(k).into_iter().map(move |group| (k, group))).collect();
    let moved = |k: usize, group: &[usize], direction: f64| -> Result<(Vec<f64>, Vec<f64>)> {
        let d = recordings[k];
        let (mut parameters, mut nuisances) = (point.parameters.clone(), point.nuisances[d].clone());
        let step = |&column: &usize| {
            if let Some(&index) = indices[k].get(column) {
                nudge(&mut parameters[index], problem.parameter(index), direction * problem.step(index))
            } else {
                let i = column - indices[k].len();
                let p = &problem.nuisances(d)[i];
                nudge(&mut nuisances[i], p, direction * DIFFERENCE_STEP * p.span())
            }
        };
        let steps = group.iter().map(step).collect();
        problem.residual(d, &parameters, &nuisances).map(|r| (r, steps))
    };
    let single = |k: usize, column: usize| -> Result<Vec<f64>> {
        // On the edge of what can be simulated (a start that touches a surface) only one side exists, or none.
        let (mut values, steps) = match moved(k, &[column], 1.0).or_else(|_| moved(k, &[column], -1.0)) {
            Ok(found) => found,
            Err(broken @ Error::SimulatorBroken { .. }) => return Err(broken),
            Err(_) if problem.flat_where_refused() => return Ok(vec![0.0; residuals[k].len()]),
            Err(refused) => return Err(refused),
        };
        values.iter_mut().zip(&residuals[k]).for_each(|(m, r)| *m = (*m - r) / steps[0]);
        Ok(values)
    };
    let group = |(k, group): &(usize, Vec<usize>)| -> Result<(Vec<Vec<f64>>, usize)> {
        let (k, width) = (*k, problem.width());
        let apart = if group.len() > 1 { moved(k, group, 1.0).ok() } else { None };
        let Some((values, steps)) = apart else {
            return Ok((group.iter().map(|&column| single(k, column)).collect::<Result<_>>()?, group.len()));
        };
        let part = |(column, step): (&usize, f64)| {
            let own = problem.parameter(indices[k][*column]).channels.as_deref().unwrap_or_default();
            let change =
                |(i, (m, r)): (usize, (&f64, &f64))| if own.contains(&(i % width)) { (m - r) / step } else { 0.0 };
            values.iter().zip(&residuals[k]).enumerate().map(change).collect()
        };
        Ok((group.iter().zip(steps).map(part).collect(), 1))
    };
    let found = every(tasks.par_iter().map(group))?;
    let mut columns: Vec<Vec<Vec<f64>>> =
        (0..recordings.len()).map(|k| vec![Vec::new(); touched(problem, point, k)]).collect();
    let mut rollouts = 0;
    for ((k, group), (own, count)) in tasks.iter().zip(found) {
        rollouts += count;
        group.iter().zip(own).for_each(|(&column, values)| columns[*k][column] = values);
    }
    let gather = |(indices, mut shared): (Vec<usize>, Vec<Vec<f64>>)| {
        let nuisances = shared.split_off(indices.len());
        Columns { indices, shared, nuisances }
    };
    Ok((indices.into_iter().zip(columns).map(gather).collect(), rollouts))
}

/// Moves `value` by `step`, inward where it would leave the bounds; returns the step taken.
fn nudge(value: &mut f64, parameter: &Parameter, step: f64) -> f64 {
    let before = *value;
    *value += if (parameter.min..=parameter.max).contains(&(before + step)) { step } else { -step };
    *value - before
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use std::sync::atomic::{AtomicUsize, Ordering};

    use crate::estimate::problem::residuals;
    use crate::estimate::problem::tests::Lines;

    /// Two channels, each with a rate of its own that bends it, which reaches the other by a share; a third number acts on both.
    pub struct Coupled {
        parameters: Vec<Parameter>,
        share: f64,
        pub rollouts: AtomicUsize,
    }

    impl Coupled {
        pub const TRUE: [f64; 3] = [0.7, 1.3, 0.2];

        pub fn new(share: f64) -> Self {
            let one = |name: &str, channels: Option<Vec<usize>>| Parameter {
                channels,
                ..Parameter::new(name, "1", 1.0, 0.0, 2.0).unwrap()
            };
            let parameters = vec![one("first", Some(vec![0])), one("second", Some(vec![1])), one("both", None)];
            Self { parameters, share, rollouts: AtomicUsize::new(0) }
        }

        pub fn start() -> Point {
            Point { parameters: vec![1.0; 3], nuisances: vec![Vec::new()] }
        }

        fn predicted(&self, [a, b, c]: [f64; 3]) -> Vec<f64> {
            let rows = (0..40).map(|i| f64::from(i) / 40.0);
            rows.flat_map(|t| {
                [(a + self.share * b) * t + (a * t).exp() + c, (b + self.share * a) * t + (b * t).exp() - c]
            })
            .collect()
        }
    }

    impl LeastSquares for Coupled {
        fn free(&self) -> &[usize] {
            &[0, 1, 2]
        }

        fn recordings(&self) -> &[usize] {
            &[0]
        }

        fn parameter(&self, position: usize) -> &Parameter {
            &self.parameters[position]
        }

        fn nuisances(&self, _recording: usize) -> &[Parameter] {
            &[]
        }

        fn residual(&self, _recording: usize, parameters: &[f64], _nuisances: &[f64]) -> Result<Vec<f64>> {
            self.rollouts.fetch_add(1, Ordering::Relaxed);
            let found = self.predicted([parameters[0], parameters[1], parameters[2]]);
            Ok(self.predicted(Self::TRUE).iter().zip(found).map(|(seen, found)| (seen - found) / 1e-3).collect())
        }

        fn width(&self) -> usize {
            2
        }

        fn is_separable(&self) -> bool {
            true
        }
    }

    /// Of three parameters at 0, 2 and 5 those at 2 and 5 stay, as the first and the second.
    #[test]
    fn columns_that_are_kept_are_numbered_anew() {
        let all = Columns {
            indices: vec![0, 2, 5],
            shared: vec![vec![1.0], vec![2.0], vec![5.0]],
            nuisances: vec![vec![9.0]],
        };
        let kept = all.at(&[2, 4, 5]);
        assert_eq!(
            (kept.indices, kept.shared, kept.nuisances),
            (vec![0, 2], vec![vec![2.0], vec![5.0]], vec![vec![9.0]])
        );
    }

    #[test]
    fn channels_apart_share_a_rollout_and_what_crosses_is_left_out() {
        let derivatives = |share: f64| {
            let problem = Coupled::new(share);
            let (point, left) = (Coupled::start(), residuals(&problem, &Coupled::start()).unwrap());
            let each = jacobian(&problem, &point, &left).unwrap();
            let (grouped, rollouts) = grouped_jacobian(&problem, &point, &left).unwrap();
            assert_eq!(rollouts, 2);
            let off = |(a, b): (&Vec<f64>, &Vec<f64>)| a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            let off: Vec<f64> = each[0].shared.iter().zip(&grouped[0].shared).map(off).collect();
            (off, grouped)
        };
        let (off, _) = derivatives(0.0);
        assert!(off.iter().all(|off| *off < 1e-6), "{off:?}");
        let (off, grouped) = derivatives(0.1);
        assert!(off[0] > 50.0 && off[2] < 1e-6, "{off:?}");
        assert!(grouped[0].shared[0].iter().skip(1).step_by(2).all(|value| *value == 0.0));
    }

    #[test]
    fn no_two_of_a_group_act_on_one_channel() {
        let own: [Option<&[usize]>; 6] = [Some(&[0, 1]), None, Some(&[2]), Some(&[1, 2]), Some(&[3]), Some(&[0])];
        assert_eq!(grouped(&own), [vec![0, 2, 4], vec![1], vec![3, 5]]);
    }

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
