//! What is not known of a value that stays as it is: a torque gain that an earlier recording calibrated, say.
//!
//! The fit takes such a value as exact, so that its intervals lack the error that it brings. Here everything is fitted again
//! with the value at either end of its own 95 % interval. How far an answer moves is half an interval that is independent of
//! the recording's own, and the two add as squares.

use nalgebra::DVector;

use crate::Result;
use crate::estimate::{Fit, Interval, Problem, Region};
use crate::findings;
use crate::observation::{Note, with_decimals};
use crate::statistics::NORMAL_95;

/// What all such values do to the answers.
pub(super) struct Carried {
    /// For each value: how far each free parameter moves as it moves by half its interval.
    moves: Vec<Vec<f64>>,
    /// What a person should know of it.
    pub notes: Vec<Note>,
    /// The rollouts that it took.
    pub rollouts: usize,
}

impl Carried {
    /// Finds every value that stays and is not exact, and widens the `intervals` of the free parameters at `fit` by what it may be
    /// off.
    ///
    /// # Errors
    /// Where the simulator refuses an end of such a value's interval.
    pub fn of(problem: &Problem, fit: &Fit, intervals: &mut [Interval]) -> Result<Self> {
        let mut all = Self { moves: Vec::new(), notes: Vec::new(), rollouts: 0 };
        for (i, parameter) in problem.simulator.parameters().iter().enumerate().filter(|(_, p)| !p.tune) {
            let Some((low, high)) = parameter.known95 else { continue };
            let mut ends = Vec::with_capacity(2);
            for end in [low, high] {
                let mut start = fit.point.clone();
                start.parameters[i] = end.clamp(parameter.min, parameter.max);
                let there = problem.fit(start, 1.0)?;
                all.rollouts += there.rollouts;
                ends.push(there.point);
            }
            // Where the answer bends with the value, the farther side counts, with the direction of a rising value.
            let moves = problem.free.iter().map(|&free| {
                let [down, up] = [0, 1].map(|k| ends[k].parameters[free] - fit.point.parameters[free]);
                if up.abs() >= down.abs() { up } else { -down }
            });
            let moves: Vec<f64> = moves.collect();
            for ((interval, value), moved) in intervals.iter_mut().zip(fit.point.at(problem.free)).zip(&moves) {
                for (end, side) in [(&mut interval.low, -1.0), (&mut interval.high, 1.0)] {
                    end.value = value + side * (end.value - value).hypot(*moved);
                }
            }
            let text = format!(
                "`{}` stays at {} and is itself known to {} to {} (95 %) only; the intervals allow for that",
                parameter.name,
                with_decimals(parameter.value, 4),
                with_decimals(low, 4),
                with_decimals(high, 4)
            );
            all.notes.push(Note::new(findings::PARAMETER_CARRIED, text, ""));
            all.moves.push(moves);
        }
        Ok(all)
    }

    /// Widens the joint region of the free parameters at the places `joint` likewise.
    pub fn widen_region(&self, region: &mut Region, joint: &[usize]) {
        for moves in &self.moves {
            let moved = DVector::from_fn(joint.len(), |k, _| moves[joint[k]] / NORMAL_95);
            if let Some(covariance) = &mut region.covariance {
                *covariance += &moved * moved.transpose();
            }
        }
    }
}
