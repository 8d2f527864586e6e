//! Algorithm 1 of the paper (arXiv 1907.11200): roll out, ask the network how the parameters differ, move, repeat.

use super::film::Film;
use super::outcome::Iteration;
use super::unknowns::Point;
use crate::network::{Model, Side};
use crate::observation::Observation;
use crate::simulator::{Parameter, Prepared, Simulator, predict};
use crate::{Error, Result};

/// Two rollouts farther apart than this share of the bounds give a chord, not a slope, so no secant step is taken; nor does
/// one reach farther than that.
const LONGEST_SECANT: f64 = 0.03;
/// ... and closer than this the rollouts differ by rounding alone.
const SHORTEST_SECANT: f64 = 1e-9;

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
    // A network that learned from pictures as they are looks at the picture; any other at what was read back from it.
    let raw = recording.film.as_ref().filter(|film| !model.reads_back() && film.channels() == model.target_channels());
    let target = Side { observation: raw.unwrap_or(&recording.seen), scale: recording.scale.as_ref() };
    let film = Film::of(recording).filter(|_| raw.is_none());
    if settings.library
        && let Some(values) = model.start(target)?
    {
        point = point.with(&free, &clamped(simulator, &free, &values));
    }
    // Slopes compare trajectories to the last digit. Where the release is a guess they lead astray; the network has
    // learned how guesses err.
    let secant = settings.secant && free.len() == 1 && !model.from_recordings();
    let mut rolled: Vec<Rolled> = Vec::new();
    let mut iterations = Vec::new();
    let mut best: Option<(f64, Point)> = None;
    for k in 0..=settings.iterations {
        let values = predict(simulator, recording, &point.parameters, &point.own[0], clock)?;
        let beside = film.as_ref().and_then(|film| film.beside(&values));
        let seen_now = beside.as_ref().map_or(&recording.seen, |b| &b.seen);
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
        if secant {
            // Slopes are taken in the picture, whose camera is fitted anew at every rollout. The network goes by the first
            // reading: far from the truth a camera that suits the rollout is none.
            let (compared, with) = match (&beside, &film) {
                (Some(beside), Some(film)) => (beside.appears_px.clone(), film.v_px()),
                _ => (values.clone(), recording.seen.values()),
            };
            rolled.push(Rolled { at: now[0], values: compared, rmse });
            next = secant_step(&rolled, with, simulator.parameters()[free[0]].span());
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
        point = point.with(&free, &next);
    }
    let rollouts = iterations.len();
    let end = match best {
        Some((_, best)) if settings.best => best,
        _ => point,
    };
    Ok(Walk { point: end, iterations, rollouts })
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

/// A rollout that has been made: where, what it gave, and how far off.
struct Rolled {
    at: f64,
    values: Vec<f64>,
    rmse: f64,
}

/// Where the Gauss–Newton step from the best rollout leads, its slope the difference to the nearest other. At the end it is
/// the maximum of the likelihood for white noise. `None` where no other is near enough.
///
/// All others are worse, so the best value lies nearer to the best rollout than to any of them: a step goes at most half
/// the way to the next. That keeps it from the wilderness where a slope is hardly there (a restitution near 0).
fn secant_step(rolled: &[Rolled], seen: &[f64], span: f64) -> Option<f64> {
    let best = rolled.iter().min_by(|a, b| a.rmse.total_cmp(&b.rmse))?;
    let distance = |other: &Rolled| (other.at - best.at).abs() / span;
    let others = || rolled.iter().filter(|other| distance(other) > SHORTEST_SECANT);
    let near = others().min_by(|a, b| distance(a).total_cmp(&distance(b))).filter(|o| distance(o) < LONGEST_SECANT)?;
    let (mut square, mut product) = (0.0, 0.0);
    for ((new, old), seen) in best.values.iter().zip(&near.values).zip(seen) {
        let slope = (new - old) / (best.at - near.at);
        square += slope * slope;
        product += slope * (seen - new);
    }
    let step = (square > 0.0).then(|| product / square)?;
    let ahead = others().map(|other| (other.at - best.at) * step.signum()).filter(|way| *way > 0.0);
    let reach = ahead.fold(LONGEST_SECANT * span, |least, way| least.min(0.5 * way));
    Some(best.at + step.clamp(-reach, reach))
}
