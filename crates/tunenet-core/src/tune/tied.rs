//! Tied numbers by variance inflation (Marquardt 1970): parameters, and numbers that the simulation takes for known, of which the
//! recordings determine a combination only.

use nalgebra::{DMatrix, DVector};

use super::{Tuning, channel_weights};
use crate::Result;
use crate::estimate::{Fit, Information, Point, Problem, RolloutLog, free, weights};
use crate::findings;
use crate::observation::Note;
use crate::simulator::{Effect, Prepared, Simulator};

/// A number is tied to others that inflate its variance by more than this factor: the limit of the source.
const INFLATED: f64 = 10.0;
/// At most so many others together.
const MOST: usize = 3;

/// Names of numbers that are tied at `point`, group by group: free parameters, and numbers of the simulation that its effects
/// [restate](Effect::restates). Nothing of a simulator without such an effect.
///
/// # Errors
/// Where the simulator refuses an effect or the point.
fn tied(problem: &Problem, point: &Point) -> Result<Vec<Vec<String>>> {
    let restating: Vec<Effect> = problem.simulator.effects().into_iter().filter(|e| !e.restates.is_empty()).collect();
    if restating.is_empty() || problem.free.is_empty() {
        return Ok(Vec::new());
    }
    let effects: Vec<&str> = restating.iter().map(|effect| effect.name.as_ref()).collect();
    let simulator = problem.simulator.with_effects(&effects)?;
    let before = problem.simulator.parameters().len();
    let added = before..simulator.parameters().len();
    let recordings: Vec<Prepared> = problem.recordings.iter().map(|one| one.with_parameters(added.len())).collect();
    let free: Vec<usize> = problem.free.iter().copied().chain(added.clone()).collect();
    let with = Problem {
        simulator: simulator.as_ref(),
        recordings: &recordings,
        noise: problem.noise,
        free: &free,
        log: problem.log,
    };
    let mut at = point.clone();
    at.parameters.extend(simulator.parameters()[added].iter().map(|parameter| parameter.value));
    let fit = with.evaluate(at)?;
    let linear = with.linearise(&fit)?;
    let (information, ..) = with.curvature(&fit, &linear);
    let own = problem.free.iter().map(|&i| problem.simulator.parameters()[i].name.clone());
    let stated = restating.iter().flat_map(|effect| effect.restates.iter().map(ToString::to_string));
    let names: Vec<String> = own.chain(stated).collect();
    Ok(groups(&information).into_iter().map(|group| group.into_iter().map(|i| names[i].clone()).collect()).collect())
}

/// Names of numbers of which recordings determine a combination only, near a fit of another search: parameters, and what the
/// simulation states. `simulator` has the effects of that search; rollouts are counted in `log`.
///
/// # Errors
/// Where the simulator refuses.
pub(crate) fn tied_near(
    simulator: &dyn Simulator,
    mut recordings: Vec<Prepared>,
    near: &Point,
    log: &RolloutLog,
) -> Result<Vec<Vec<String>>> {
    for recording in &mut recordings {
        let more = simulator.parameters().len().saturating_sub(recording.silent.len());
        *recording = recording.with_parameters(more);
    }
    let free = free(simulator.parameters(), &recordings);
    channel_weights::weigh(simulator, &mut recordings, &free, log)?;
    let noise: Vec<Vec<f64>> = recordings.iter().map(weights).collect();
    tied(&Problem { simulator, recordings: &recordings, noise: &noise, free: &free, log: Some(log) }, near)
}

impl Tuning<'_> {
    /// Numbers of which the recordings determine a combination only, by their names: parameters, and what the simulation states. What
    /// effects state anew is noted here; directions of parameters alone are noted with them.
    pub(super) fn tied(&self, fit: &Fit, known: &Information, notes: &mut Vec<Note>) -> Result<Vec<Vec<String>>> {
        let name = |i: usize| self.simulator.parameters()[self.free[i]].name.clone();
        let mut all: Vec<Vec<String>> =
            known.directions.iter().map(|direction| direction.parts().into_iter().map(name).collect()).collect();
        if self.settings.finish && !self.settings.quick && !fit.cut_short {
            let rest = self.log.remainder();
            let found = tied(&Problem { log: Some(&rest), ..self.problem() }, &fit.point);
            self.log.add(rest.count());
            if !rest.was_short() {
                let found = found?;
                notes.extend(found.iter().map(|group| note(group)));
                all.extend(found);
            }
        }
        Ok(all)
    }
}

/// What a person should know of such a group.
pub(crate) fn note(group: &[String]) -> Note {
    let names: Vec<String> = group.iter().map(|name| format!("`{name}`")).collect();
    let text = format!("{} are tied: the recordings determine a combination of them, not each", names.join(", "));
    let remedy =
        "read them as a set: their product or sum holds, and a value of one holds for these values of the others";
    Note::new(findings::PARAMETERS_TIED, text, remedy)
}

/// Positions of numbers that are tied to each other, by their information; groups with a number in common are one.
fn groups(information: &DMatrix<f64>) -> Vec<Vec<usize>> {
    let live: Vec<usize> = (0..information.nrows())
        .filter(|&i| information[(i, i)] > 0.0 && information.row(i).iter().all(|v| v.is_finite()))
        .collect();
    let unit = |i: usize, j: usize| information[(i, j)] / (information[(i, i)] * information[(j, j)]).sqrt();
    let mut found: Vec<Vec<usize>> = Vec::new();
    for &target in &live {
        let Some(others) = explained_by(&unit, target, &live) else { continue };
        let mut group = others;
        group.push(target);
        let (joined, apart) = found.into_iter().partition(|known: &Vec<usize>| known.iter().any(|i| group.contains(i)));
        found = apart;
        group.extend(joined.into_iter().flatten());
        group.sort_unstable();
        group.dedup();
        found.push(group);
    }
    found.sort();
    found
}

/// The fewest numbers, found one after the other, that inflate the variance of `target` beyond the limit.
fn explained_by(unit: &dyn Fn(usize, usize) -> f64, target: usize, live: &[usize]) -> Option<Vec<usize>> {
    let mut chosen: Vec<usize> = Vec::new();
    while chosen.len() < MOST {
        let open = live.iter().copied().filter(|i| *i != target && !chosen.contains(i));
        let with = |i: usize| {
            let all: Vec<usize> = chosen.iter().copied().chain([i]).collect();
            (share(unit, target, &all), i)
        };
        let (explained, best) = open.map(with).max_by(|a, b| a.0.total_cmp(&b.0))?;
        chosen.push(best);
        if explained > 1.0 - INFLATED.recip() {
            return Some(chosen);
        }
    }
    None
}

/// The share of the squares of one column that others explain.
fn share(unit: &dyn Fn(usize, usize) -> f64, target: usize, others: &[usize]) -> f64 {
    let count = others.len();
    // A trace of each column of its own, so that others may be tied among themselves.
    let ridge = |a: usize, b: usize| if a == b { 1e-9 } else { 0.0 };
    let among = DMatrix::from_fn(count, count, |a, b| unit(others[a], others[b]) + ridge(a, b));
    let with = DVector::from_fn(count, |a, _| unit(others[a], target));
    among.cholesky().map_or(0.0, |factor| factor.solve(&with).dot(&with))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Information of columns with unit noise.
    fn of(columns: &[[f64; 4]]) -> DMatrix<f64> {
        let product = |a: &[f64; 4], b: &[f64; 4]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        DMatrix::from_fn(columns.len(), columns.len(), |i, j| product(&columns[i], &columns[j]))
    }

    #[test]
    fn numbers_that_do_the_same_are_tied_and_others_are_not() {
        let (a, b, c) = ([1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]);
        assert!(groups(&of(&[a, b, c])).is_empty());
        assert_eq!(groups(&of(&[a, b, [-3.0, 0.0, 0.0, 0.1]])), [[0, 2]]);
        // The third is a sum of the first two: three numbers in one group.
        assert_eq!(groups(&of(&[a, b, [1.0, 1.0, 0.0, 0.0]])), [[0, 1, 2]]);
        assert_eq!(groups(&of(&[a, b, a, b, c])), [[0, 2], [1, 3]]);
        // What moves nothing is tied to nothing.
        assert!(groups(&of(&[a, [0.0; 4]])).is_empty());
    }

    #[test]
    fn a_loose_tie_is_none() {
        // Correlation 0.9 inflates a variance fivefold.
        let near = [0.9, 0.436, 0.0, 0.0];
        assert!(groups(&of(&[[1.0, 0.0, 0.0, 0.0], near])).is_empty());
    }
}
