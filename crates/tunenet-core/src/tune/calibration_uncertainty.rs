//! Propagation of calibration uncertainty (GUM, JCGM 100:2008): a fixed value that is itself known only within an interval, for
//! example a torque gain calibrated from an earlier recording.
//!
//! The fit treats such a value as exact, so its intervals lack that error. Here everything is fitted again with the value at
//! either end of its own 95 % interval. The change of an estimate is a half-width that is independent of the recording's own;
//! the two add in quadrature.

use nalgebra::DVector;

use crate::Result;
use crate::estimate::{Fit, Interval, Problem, Region};
use crate::findings;
use crate::observation::{Note, with_decimals};
use crate::statistics::NORMAL_95;

/// The effect of all such values on the estimates.
pub(super) struct CalibrationUncertainty {
    /// For each value: how far each free parameter moves as it moves by half its interval.
    moves: Vec<Vec<f64>>,
    /// Messages for the user.
    pub notes: Vec<Note>,
}

impl CalibrationUncertainty {
    /// Finds every value that stays and is not exact, and widens the `intervals` of the free parameters at `fit` by what it may be
    /// off.
    ///
    /// # Errors
    /// Where the simulator refuses an end of such a value's interval.
    pub fn of(problem: &Problem, fit: &Fit, intervals: &mut [Interval]) -> Result<Self> {
        let mut all = Self { moves: Vec::new(), notes: Vec::new() };
        for (i, parameter) in problem.simulator.parameters().iter().enumerate().filter(|(_, p)| !p.tune) {
            let Some((low, high)) = parameter.known95 else { continue };
            let mut ends = Vec::with_capacity(2);
            for end in [low, high] {
                let mut start = fit.point.clone();
                start.parameters[i] = end.clamp(parameter.min, parameter.max);
                let there = problem.fit(start, 1.0)?;
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
                "`{}` is fixed at {}, known only to {} to {} (95 %); the intervals include that uncertainty",
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

    /// Adds what something else does to the estimates: how far it moves each, and what the user should know of it.
    pub fn add(&mut self, moves: Vec<f64>, note: Note) {
        self.moves.push(moves);
        self.notes.push(note);
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
