//! Iteratively reweighted least squares over channels: weights from the residuals of the fit before.

use crate::Result;
use crate::estimate::{Point, Problem, RolloutLog, floor, weights};
use crate::simulator::{Prepared, Simulator};

/// Fits by which the spreads of the channels settle.
const WEIGHINGS: usize = 3;

/// What a discrepancy leaves is no smaller in a recording whose sensor is quiet: every channel counts the same in all of them.
fn weigh_alike(recordings: &mut [Prepared]) {
    let floors: Vec<Vec<f64>> = recordings.iter().map(floor).collect();
    let width = floors.iter().map(Vec::len).min().unwrap_or(0);
    let largest = |channel: usize| floors.iter().map(|floor| floor[channel]).fold(0.0, f64::max);
    let scale: Vec<f64> = (0..width).map(largest).collect();
    for recording in recordings {
        recording.residual_scale = Some(scale.clone());
    }
}

/// Of driven recordings: finds the [`residual_scale`](Prepared::residual_scale) of each channel's residuals by fitting, so that a joint whose
/// torques the model explains badly does not outvote those that it explains well.
///
/// # Errors
/// Where the simulator refuses.
pub(super) fn weigh(
    simulator: &dyn Simulator,
    recordings: &mut [Prepared],
    free: &[usize],
    log: &RolloutLog,
) -> Result<()> {
    if recordings.iter().all(|r| r.discrepancy) {
        weigh_alike(recordings);
        return Ok(());
    }
    if recordings.iter().any(|r| !r.memoryless || r.noise.is_none()) {
        return Ok(());
    }
    let mut point = Point::start(simulator, recordings);
    for _ in 0..WEIGHINGS {
        let noise: Vec<Vec<f64>> = recordings.iter().map(weights).collect();
        let fit = Problem { simulator, recordings, noise: &noise, free, log: Some(log) }.fit(point, 1.0)?;
        let width = simulator.channels().len();
        let scale = |channel: usize| {
            let of = |(r, n): (&Vec<f64>, &Vec<f64>)| {
                let squares = r.iter().skip(channel).step_by(width).map(|r| (r * n[channel]).powi(2));
                (squares.sum::<f64>(), r.len() / width)
            };
            let (sum, count) = fit.residuals.iter().zip(&noise).map(of).fold((0.0, 0), |a, b| (a.0 + b.0, a.1 + b.1));
            (sum / count.max(1) as f64).sqrt()
        };
        let scales: Vec<f64> = (0..width).map(scale).collect();
        for recording in recordings.iter_mut() {
            let floor = floor(recording);
            recording.residual_scale = Some(floor.iter().zip(&scales).map(|(f, s)| f.max(*s)).collect());
        }
        point = fit.point;
    }
    Ok(())
}
