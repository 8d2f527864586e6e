//! Algorithm 1 of the paper (arXiv 1907.11200): roll out, ask the network how the parameters differ, move, repeat.

use super::camera_projection::VideoTrack;
use super::outcome::Iteration;
use super::secant::{LONGEST_SECANT, Made};
use crate::estimate::Point;
use crate::network::{Model, Side};
use crate::observation::Observation;
use crate::simulator::{Parameter, Prepared, Simulator, predict};
use crate::{Error, Result};

/// How the loop moves.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[expect(clippy::struct_excessive_bools, reason = "each is switched on its own")]
pub struct Loop {
    /// How many iterations, one rollout each.
    pub iterations: usize,
    /// Whether values are kept within their bounds.
    pub clamp: bool,
    /// Whether steps may start from the best rollout and use the slope to another near it (Gauss–Newton by secants) where
    /// the network's own are too coarse. Only sensible for one parameter.
    pub secant: bool,
    /// Whether the best iterate by trajectory error is returned, instead of the last.
    pub best: bool,
    /// Whether the rollouts stored with the model may say where to start, instead of the start given, and how steep the
    /// way is before two rollouts do.
    pub library: bool,
}

/// Where the loop ended and how it got there.
#[derive(Debug, Clone)]
pub struct Walk {
    /// The iterate returned.
    pub point: Point,
    /// Every iterate with its error, the start first.
    pub iterations: Vec<Iteration>,
    /// The answer before the first rollout and after every one but the last, which judges only: the iterate that follows,
    /// or the best known where that one is a restart.
    pub answers: Vec<Vec<f64>>,
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
    start: &Point,
    settings: Loop,
) -> Result<Walk> {
    let free = positions(simulator.parameters(), model)?;
    let clock = recording.seen.clock();
    let mut point = start.clone();
    // A network that learned from pictures as they are looks at the picture; any other at what was read back from it.
    let raw =
        recording.video.as_ref().filter(|video| !model.reads_back() && video.channels() == model.target_channels());
    let target = Side { observation: raw.unwrap_or(&recording.seen), scale: recording.scale.as_ref() };
    let track = VideoTrack::of(recording).filter(|_| raw.is_none());
    if settings.library
        && let Some(values) = model.start(target)?
    {
        point = point.with(&free, &clamped(simulator, &free, &values));
    }
    // Slopes compare trajectories to the last digit. Where the initial state is a guess they are wrong; the network
    // has learned how guesses err.
    let secant = settings.secant && free.len() == 1 && !model.from_recordings();
    let bounds = free.first().map(|&i| (simulator.parameters()[i].min, simulator.parameters()[i].max));
    let mut made = secant.then_some(bounds).flatten().map(Made::within);
    let mut iterations = Vec::new();
    let mut answers = vec![point.at(&free)];
    let mut best: Option<(f64, Point)> = None;
    for k in 0..=settings.iterations {
        let rolled = |point: &Point| predict(simulator, recording, &point.parameters, &point.nuisances[0], clock);
        let values = match (rolled(&point), &best) {
            (Ok(values), _) => values,
            // What the stored rollouts propose cannot be simulated: the start given has to.
            (Err(_), None) => {
                point = start.clone();
                answers = vec![point.at(&free)];
                rolled(&point)?
            }
            // A proposal that cannot be simulated leads no further: what came before it stands.
            (Err(_), Some((_, before))) => {
                point = before.clone();
                break;
            }
        };
        let projected = track.as_ref().and_then(|track| track.project(&values));
        let seen_now = projected.as_ref().map_or(&recording.seen, |b| &b.seen);
        let squares = values.iter().zip(seen_now.values()).map(|(p, s)| (s - p).powi(2)).sum::<f64>();
        let rmse = (squares / clock.len() as f64).sqrt();
        iterations.push(Iteration { k, parameters: point.at(&free), rmse });
        if best.as_ref().is_none_or(|(least, _)| rmse < *least) {
            best = Some((rmse, point.clone()));
        }
        if k == settings.iterations {
            break;
        }
        let now = point.at(&free);
        let mut next = None;
        if let Some(made) = &mut made {
            // Slopes are taken in the picture, whose camera is fitted again at every rollout. The network goes by the first
            // reading: far from the truth, the camera that fits the rollout is wrong.
            let (compared, with) = match (&projected, &track) {
                (Some(projected), Some(track)) => (projected.appears_px.clone(), track.v_px()),
                _ => (values.clone(), recording.seen.values()),
            };
            made.push(now[0], compared, rmse);
            if let Some(restart) = made.restart() {
                answers.push(best.as_ref().map_or_else(|| now.clone(), |(_, best)| best.at(&free)));
                point = point.with(&free, &[restart]);
                continue;
            }
            next = made.step(with);
        }
        let next = if let Some(next) = next {
            vec![next]
        } else {
            let (kind, channels) = (recording.seen.kind(), recording.seen.channels().to_vec());
            let seen = Observation::new(kind, channels, clock.to_vec(), values)?;
            let proposed = Side { observation: &seen, scale: recording.scale.as_ref() };
            let mut step = model.estimate_batch(&[(proposed, target)])?.swap_remove(0);
            if settings.library
                && secant
                && let Some(finer) = model.library_step(now[0], proposed, target)?
                && finer.abs() < LONGEST_SECANT * simulator.parameters()[free[0]].span()
            {
                step = vec![finer];
            }
            now.iter().zip(step).map(|(value, step)| value + step).collect()
        };
        let next = if settings.clamp { clamped(simulator, &free, &next) } else { next };
        answers.push(next.clone());
        point = point.with(&free, &next);
    }
    let rollouts = iterations.len();
    let end = match best {
        Some((_, best)) if settings.best => best,
        _ => point,
    };
    Ok(Walk { point: end, iterations, answers, rollouts })
}

/// The values within the bounds of the parameters at `free`.
fn clamped(simulator: &dyn Simulator, free: &[usize], values: &[f64]) -> Vec<f64> {
    let bounds = free.iter().map(|&i| &simulator.parameters()[i]);
    bounds.zip(values).map(|(p, value)| value.clamp(p.min, p.max)).collect()
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
