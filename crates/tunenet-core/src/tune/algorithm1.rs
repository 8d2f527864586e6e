//! Algorithm 1 of the paper (arXiv 1907.11200): roll out, ask the network how the parameters differ, move, repeat.

use super::outcome::Iteration;
use super::unknowns::Point;
use crate::network::Model;
use crate::observation::Observation;
use crate::simulator::{Parameter, Prepared, Simulator, rollout};
use crate::{Error, Result};

/// Two iterates farther apart than this share of the bounds give a chord, not a slope, so no secant step is taken.
const LONGEST_SECANT: f64 = 0.03;
/// ... and closer than this the rollouts differ by rounding alone.
const SHORTEST_SECANT: f64 = 1e-9;

/// How the loop moves.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Loop {
    /// How many iterations, one rollout each.
    pub iterations: usize,
    /// Whether values are kept within their bounds.
    pub clamp: bool,
    /// Whether steps after the first two may use the slope between earlier rollouts (Gauss–Newton by secants) where the
    /// network's own are too coarse. Only sensible for one parameter.
    pub secant: bool,
    /// Whether the best iterate by trajectory error is returned, instead of the last.
    pub best: bool,
}

/// Where the loop ended and how it got there.
#[derive(Debug, Clone)]
pub struct Walk {
    /// The iterate returned.
    pub point: Point,
    /// Every iterate with its error, the start first.
    pub iterations: Vec<Iteration>,
    /// Rollouts used, the one that judges the last iterate included.
    pub rollouts: usize,
}

/// Runs the loop on one recording. `free` are the positions of the model's parameters in the simulator.
///
/// # Errors
/// [`Error::Model`] where model and simulator disagree on the parameters; where the simulator refuses.
pub fn walk(
    simulator: &dyn Simulator,
    recording: &Prepared,
    model: &Model,
    start: Point,
    settings: Loop,
) -> Result<Walk> {
    let free = positions(simulator.parameters(), model)?;
    let clock = recording.seen.clock();
    let mut point = start;
    let mut seen: Vec<(f64, Vec<f64>, f64)> = Vec::new();
    let mut iterations = Vec::new();
    let mut best: Option<(f64, Point)> = None;
    for k in 0..=settings.iterations {
        let values = rollout(simulator, &point.parameters, &point.own[0], clock)?;
        let rmse = (values.iter().zip(recording.seen.values()).map(|(p, s)| (s - p).powi(2)).sum::<f64>()
            / clock.len() as f64)
            .sqrt();
        iterations.push(Iteration { k, parameters: point.at(&free), rmse });
        if best.as_ref().is_none_or(|(least, _)| rmse < *least) {
            best = Some((rmse, point.clone()));
        }
        if k == settings.iterations {
            break;
        }
        let now = point.at(&free);
        let secant = (settings.secant && free.len() == 1 && k >= 1)
            .then(|| {
                secant_step(&seen, now[0], &values, recording.seen.values(), simulator.parameters()[free[0]].span())
            })
            .flatten();
        seen.push((now[0], values.clone(), rmse));
        let step = if let Some(step) = secant {
            vec![step]
        } else {
            let (kind, channels) = (recording.seen.kind(), recording.seen.channels().to_vec());
            let proposed = Observation::new(kind, channels, clock.to_vec(), values)?;
            model.estimate(&proposed, recording.scale.as_ref(), &recording.seen, recording.scale.as_ref())?
        };
        for (&position, step) in free.iter().zip(step) {
            let p = &simulator.parameters()[position];
            let value = point.parameters[position] + step;
            point.parameters[position] = if settings.clamp { value.clamp(p.min, p.max) } else { value };
        }
    }
    let rollouts = iterations.len();
    let end = match best {
        Some((_, best)) if settings.best => best,
        _ => point,
    };
    Ok(Walk { point: end, iterations, rollouts })
}

/// Checks that the model's parameters are the simulator's, and says where they stand.
fn positions(parameters: &[Parameter], model: &Model) -> Result<Vec<usize>> {
    let find = |name: &str| {
        parameters.iter().position(|p| p.name == name).ok_or_else(|| Error::Model {
            what: format!("tunes `{name}`"),
            expected: format!("one of {}", parameters.iter().map(|p| p.name.as_str()).collect::<Vec<_>>().join(", ")),
            found: format!("`{name}`"),
        })
    };
    model.parameters().iter().map(|p| find(&p.name)).collect()
}

/// The Gauss–Newton step whose slope is the difference to the nearest earlier rollout. At the end it is the maximum of
/// the likelihood for white noise. `None` where no earlier rollout is near enough, or too near.
fn secant_step(earlier: &[(f64, Vec<f64>, f64)], at: f64, values: &[f64], seen: &[f64], span: f64) -> Option<f64> {
    let distance = |x: f64| (x - at).abs() / span;
    let near = earlier.iter().filter(|(x, ..)| distance(*x) > SHORTEST_SECANT && distance(*x) < LONGEST_SECANT);
    let (x, other, _) = near.min_by(|a, b| distance(a.0).total_cmp(&distance(b.0)))?;
    let (mut square, mut product) = (0.0, 0.0);
    for ((new, old), seen) in values.iter().zip(other).zip(seen) {
        let slope = (new - old) / (at - x);
        square += slope * slope;
        product += slope * (seen - new);
    }
    (square > 0.0).then(|| product / square)
}
