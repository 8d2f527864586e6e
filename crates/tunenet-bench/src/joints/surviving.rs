//! What tuning leaves of a hidden effect: the motor's numbers fitted without the effect to what it does, by Levenberg–Marquardt
//! (Levenberg 1944; Marquardt 1963).

use nalgebra::{DMatrix, DVector};

use super::motion::{apart, positions};
use super::servo::{Motor, NUMBERS, Run, Secrets};

const STEPS: usize = 25;
/// A step that gains less than this share ends it.
const STILL: f64 = 1e-4;
/// Difference step, as a share of the size of the number.
const DIFFERENCE: f64 = 1e-3;
/// Other starts: dry friction, braking by the bearings and inertia by these factors, since both frictions have local minima.
const STARTS: [[f64; 3]; 3] = [[1.0, 1.0, 1.0], [0.4, 3.0, 1.0], [1.5, 0.3, 1.2]];

/// What is left of the positions of all runs, one after the other, rad.
pub fn surviving(motor: &Motor, secrets: &Secrets, runs: &[Run], step_s: f64) -> Vec<f64> {
    let rolled = |numbers: [f64; NUMBERS], secrets: &Secrets| -> Vec<f64> {
        runs.iter().flat_map(|run| positions(&Motor::of(numbers), secrets, run, step_s)).collect()
    };
    let truth = rolled(motor.numbers(), secrets);
    let plain = |numbers: [f64; NUMBERS]| rolled(numbers, &Secrets::NONE);
    let starts = STARTS.map(|[coulomb, viscous, armature]| {
        Motor {
            coulomb: motor.coulomb * coulomb,
            viscous: motor.viscous * viscous,
            armature: motor.armature * armature,
            ..*motor
        }
        .numbers()
    });
    let size = |left: &Vec<f64>| apart(left, &vec![0.0; left.len()]);
    let ended = starts.into_iter().map(|start| fitted(start, &truth, &plain));
    ended.min_by(|a, b| size(a).total_cmp(&size(b))).unwrap_or_default()
}

/// What a fit ends with.
pub(super) fn fitted(mut at: [f64; NUMBERS], truth: &[f64], model: &dyn Fn([f64; NUMBERS]) -> Vec<f64>) -> Vec<f64> {
    let scale = Motor::CENTRE.numbers().map(|number| if number == 0.0 { 0.1 } else { number });
    let mut values = model(at);
    let mut left = apart(truth, &values);
    let mut damping = 1e-3;
    for _ in 0..STEPS {
        let mut columns = Vec::with_capacity(truth.len() * NUMBERS);
        for (i, size) in scale.iter().enumerate() {
            let mut moved = at;
            moved[i] += DIFFERENCE * size;
            columns.extend(model(moved).iter().zip(&values).map(|(new, old)| (new - old) / DIFFERENCE));
        }
        let jacobian = DMatrix::from_vec(truth.len(), NUMBERS, columns);
        let residual = DVector::from_iterator(truth.len(), truth.iter().zip(&values).map(|(a, b)| a - b));
        let (square, slope) = (jacobian.transpose() * &jacobian, jacobian.transpose() * residual);
        let mut better = None;
        while better.is_none() && damping < 1e6 {
            let damped = &square + DMatrix::from_diagonal(&(square.diagonal() * damping).add_scalar(1e-12));
            let Some(step) = damped.cholesky().map(|factor| factor.solve(&slope)) else { break };
            let next = Motor::limited(std::array::from_fn(|i| at[i] + scale[i] * step[i]));
            let there = model(next);
            let rest = apart(truth, &there);
            if rest < left {
                better = Some((next, there, rest));
                damping *= 0.2;
            } else {
                damping *= 5.0;
            }
        }
        let Some((next, there, rest)) = better else { break };
        let gained = 1.0 - rest / left;
        (at, values, left) = (next, there, rest);
        if gained < STILL {
            break;
        }
    }
    truth.iter().zip(&values).map(|(a, b)| a - b).collect()
}
