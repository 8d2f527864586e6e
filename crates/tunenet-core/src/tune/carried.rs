//! What is not known of a value that stays as it is: a torque gain that an earlier recording calibrated, say.
//!
//! The fit takes such a value as exact, so that its intervals lack the error that it brings. Here everything is fitted again
//! with the value at either end of its own 95 % interval. How far an answer moves is half an interval that is independent of
//! the recording's own, and the two add as squares.

use nalgebra::DVector;

use super::fit::{Fit, Problem};
use super::interval::Interval;
use super::region::Region;
use crate::Result;
use crate::observation::Note;
use crate::simulator::Parameter;

/// Half a 95 % interval of a normal distribution, in standard deviations.
const HALF: f64 = 1.959_964;

/// What one such value does to the answers.
pub(super) struct Carried<'a> {
    parameter: &'a Parameter,
    /// The answer for each free parameter.
    values: Vec<f64>,
    /// How far each free parameter moves as this value moves by half its interval.
    moves: Vec<f64>,
}

/// Every value that stays and is not exact, with what it does to `fit`; and the rollouts that it took.
///
/// # Errors
/// Where the simulator refuses both ends of an interval.
pub(super) fn carried<'a>(problem: &'a Problem, fit: &Fit) -> Result<(Vec<Carried<'a>>, usize)> {
    let (mut all, mut rollouts) = (Vec::new(), 0);
    for (i, parameter) in problem.simulator.parameters().iter().enumerate().filter(|(_, p)| !p.tune) {
        let Some((low, high)) = parameter.known95 else { continue };
        let mut ends = Vec::with_capacity(2);
        for end in [low, high] {
            let mut start = fit.point.clone();
            start.parameters[i] = end.clamp(parameter.min, parameter.max);
            let there = problem.fit(start, 1.0)?;
            rollouts += there.rollouts;
            ends.push(there.point);
        }
        // Where the answer bends with the value, the farther side counts, with the direction of a rising value.
        let moves = problem.free.iter().map(|&free| {
            let [down, up] = [0, 1].map(|k| ends[k].parameters[free] - fit.point.parameters[free]);
            if up.abs() >= down.abs() { up } else { -down }
        });
        let moves = moves.collect();
        all.push(Carried { parameter, values: fit.point.at(problem.free), moves });
    }
    Ok((all, rollouts))
}

impl Carried<'_> {
    /// Widens each interval by what this value may be off.
    pub fn widen(&self, intervals: &mut [Interval]) {
        for ((interval, value), moved) in intervals.iter_mut().zip(&self.values).zip(&self.moves) {
            for (end, side) in [(&mut interval.low, -1.0), (&mut interval.high, 1.0)] {
                end.value = value + side * (end.value - value).hypot(*moved);
            }
        }
    }

    /// The same of the joint region of the free parameters at the places `joint`.
    pub fn widen_region(&self, region: &mut Region, joint: &[usize]) {
        let moved = DVector::from_fn(joint.len(), |k, _| self.moves[joint[k]] / HALF);
        if let Some(covariance) = &mut region.covariance {
            *covariance += &moved * moved.transpose();
        }
    }

    /// What a person should know of it.
    pub fn note(&self) -> Note {
        let (name, value) = (&self.parameter.name, self.parameter.value);
        let (low, high) = self.parameter.known95.unwrap_or((value, value));
        let text = format!(
            "`{name}` stays at {value:.4} and is itself known to {low:.4} to {high:.4} (95 %) only; the intervals allow for that"
        );
        Note::new("parameter.carried", text, "")
    }
}
