//! How well an improved simulation file predicts recordings: its starts are fitted, and so are those of the true world, by the
//! same Gauss–Newton method with Levenberg's damping (1944).

use std::path::Path;
use std::sync::Arc;

use anyhow::Result;
use nalgebra::{DMatrix, DVector};
use tunenet_core::observation::{Channel, Circumstances, Hold, Input, Kind, Observation};
use tunenet_core::simulator::{Preparation, Simulator, predict};
use tunenet_sim::{Session, SimulationFile, simulator};

use super::arena::Arena;
use super::motion::{Force, World};
use super::set::{BlindSet, Recorded};

/// A ratio that stands for a model that cannot be simulated.
pub const BROKEN: f64 = 1e9;
const ITERATIONS: usize = 25;
/// Steps of the differences for the starts, in m, m/s, rad and rad/s.
const STEP: f64 = 1e-5;
/// The fit ends where a step improves the squares by less than this share.
const ENOUGH: f64 = 1e-9;

/// A simulation file as a simulator.
pub struct Improved {
    simulator: Box<dyn Simulator>,
    parameters: Vec<f64>,
}

/// The places of the start that a recording of an arena leaves to be fitted.
fn free(arena: Arena) -> &'static [usize] {
    match arena {
        Arena::Flight => &[0, 1, 2, 3, 4, 5],
        Arena::Plane | Arena::Centre => &[0, 1, 3, 4],
        Arena::Pendulum => &[0, 3],
    }
}

impl Improved {
    pub fn open(path: &Path) -> Result<Self> {
        let file = SimulationFile::parse(path, &std::fs::read_to_string(path)?)?;
        // A ball sees positions; equations see their own channels.
        let positions = simulator(&file, Kind::Positions, &Session::default());
        let simulator = match positions {
            Ok(simulator) => simulator,
            Err(_) => simulator(&file, Kind::Other, &Session::default())?,
        };
        let parameters = simulator.parameters().iter().map(|p| p.value).collect();
        Ok(Self { simulator, parameters })
    }

    /// Sets the parameters of the base model to the true ones.
    #[cfg(test)]
    pub fn set(&mut self, base: &super::arena::Base) {
        let names = ["restitution", "strength", "stiffness", "damping"];
        for (value, parameter) in self.parameters.iter_mut().zip(self.simulator.parameters()) {
            if names.contains(&parameter.name.as_str()) {
                let second = parameter.name == "damping" && base.arena == Arena::Pendulum;
                *value = base.numbers[usize::from(second)];
            }
        }
    }

    /// The recorded numbers of a motion from `start`; `None` where it cannot be simulated.
    pub fn seen(&self, set: &BlindSet, recorded: &Recorded, start: &[f64; 6]) -> Option<Vec<f64>> {
        let arena = set.world.base.arena;
        let observation = observation(set, recorded).ok()?;
        let Preparation::Usable(prepared) = self.simulator.prepare(&observation).ok()? else { return None };
        let nuisances: Vec<f64> = free(arena).iter().map(|&i| start[i]).collect();
        if prepared.nuisances.len() != nuisances.len() {
            return None;
        }
        predict(self.simulator.as_ref(), &prepared, &self.parameters, &nuisances, &set.clock).ok()
    }
}

fn observation(set: &BlindSet, recorded: &Recorded) -> Result<Observation> {
    let clock = set.clock.clone();
    let channels = |names: &[(&str, &str)]| names.iter().map(|(name, unit)| Channel::new(*name, *unit)).collect();
    Ok(match set.world.base.arena {
        Arena::Flight => {
            let rows: Vec<[f64; 3]> = recorded.values.chunks_exact(3).map(|row| [row[0], row[1], row[2]]).collect();
            Observation::positions(clock, &rows)?
        }
        Arena::Plane | Arena::Centre => {
            Observation::new(Kind::Other, channels(&[("x", "m"), ("y", "m")]), clock, recorded.values.clone())?
        }
        Arena::Pendulum => {
            let channel = Channel::new("u", "rad/s2");
            let input = Input::sampled(channel, Hold::Linear, clock.clone(), recorded.run.input.clone())?;
            let seen = Observation::new(Kind::Other, channels(&[("q", "rad")]), clock, recorded.values.clone())?;
            seen.under(Arc::new(Circumstances::driven_by(vec![input])))
        }
    })
}

/// A motion of a recording from another start.
type Rollout<'a> = &'a dyn Fn(&Recorded, &[f64; 6]) -> Option<Vec<f64>>;

/// What is left of the recordings, RMS, over what the true world leaves, both with their starts fitted; [`BROKEN`] where the
/// model cannot be simulated.
pub fn over_truth(improved: &Improved, set: &BlindSet, recorded: &[Recorded]) -> f64 {
    let left = |seen: Rollout| -> Option<f64> {
        recorded.iter().map(|one| squares_of(set.world.base.arena, one, |start| seen(one, start))).sum()
    };
    let truth = |one: &Recorded, start: &[f64; 6]| {
        let run = super::arena::Run { start: *start, ..one.run.clone() };
        Some(set.world.seen(&run, &set.clock))
    };
    let (Some(ours), Some(theirs)) = (left(&|one, start| improved.seen(set, one, start)), left(&truth)) else {
        return BROKEN;
    };
    (ours / theirs).sqrt().min(BROKEN)
}

/// Errors of new motions from their true starts, without noise: over the variance of the motions (nMSE), and over the errors of
/// the base model without the law.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Errors {
    pub nmse: f64,
    pub left: f64,
}

pub fn errors(improved: &Improved, set: &BlindSet, recorded: &[Recorded]) -> Errors {
    let channels = set.world.base.arena.channels();
    let without = World { force: Force::Nothing, ..set.world.clone() };
    let (mut error, mut variance, mut base) = (0.0, 0.0, 0.0);
    for one in recorded {
        let truth = set.world.seen(&one.run, &set.clock);
        let Some(found) = improved.seen(set, one, &one.run.start) else {
            return Errors { nmse: BROKEN, left: BROKEN };
        };
        let squares = |other: &[f64]| other.iter().zip(&truth).map(|(a, b)| (a - b).powi(2)).sum::<f64>();
        error += squares(&found);
        base += squares(&without.seen(&one.run, &set.clock));
        for channel in 0..channels {
            let column: Vec<f64> = truth.iter().skip(channel).step_by(channels).copied().collect();
            let mean = column.iter().sum::<f64>() / column.len() as f64;
            variance += column.iter().map(|v| (v - mean).powi(2)).sum::<f64>();
        }
    }
    let over = |whole: f64| if whole > 0.0 { (error / whole).min(BROKEN) } else { BROKEN };
    Errors { nmse: over(variance), left: over(base) }
}

/// The least squares that any start leaves, sought from the true one.
fn squares_of(arena: Arena, recorded: &Recorded, seen: impl Fn(&[f64; 6]) -> Option<Vec<f64>>) -> Option<f64> {
    let free = free(arena);
    let residual = |start: &[f64; 6]| -> Option<DVector<f64>> {
        let made = seen(start)?;
        let each = recorded.values.iter().zip(&made).map(|(a, b)| a - b);
        let residual = DVector::from_iterator(recorded.values.len(), each);
        residual.iter().all(|v| v.is_finite()).then_some(residual)
    };
    let mut start = recorded.run.start;
    let mut now = residual(&start)?;
    let mut damping = 1e-6;
    for _ in 0..ITERATIONS {
        let mut slope = DMatrix::zeros(now.len(), free.len());
        for (column, &i) in free.iter().enumerate() {
            let moved = |by: f64| {
                let mut there = start;
                there[i] += by;
                residual(&there)
            };
            slope.set_column(column, &((moved(STEP)? - moved(-STEP)?) / (2.0 * STEP)));
        }
        let (mut matrix, side) = (slope.tr_mul(&slope), slope.tr_mul(&now));
        for i in 0..free.len() {
            matrix[(i, i)] *= 1.0 + damping;
        }
        let Some(step) = matrix.cholesky().map(|c| c.solve(&side)) else { break };
        let mut there = start;
        free.iter().zip(step.iter()).for_each(|(&i, by)| there[i] -= by);
        match residual(&there).filter(|next| next.norm_squared() < now.norm_squared()) {
            Some(next) => {
                let gained = 1.0 - next.norm_squared() / now.norm_squared();
                (start, now, damping) = (there, next, damping * 0.1);
                if gained < ENOUGH {
                    break;
                }
            }
            None if damping > 1e6 => break,
            None => damping *= 30.0,
        }
    }
    Some(now.norm_squared())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::law::files::Files;
    use crate::law::set::{Hidden, Recipe, stream};

    fn set(hidden: Hidden) -> (tempfile::TempDir, BlindSet, Improved) {
        let recipe = Recipe { hidden, ratio: 10.0, colour: 0.0, outliers: 0.0 };
        let set = BlindSet::draw(&recipe, &mut stream("test", 2, hidden.name(), 0)).unwrap();
        let folder = tempfile::tempdir().unwrap();
        let files = Files::write(folder.path(), &set).unwrap();
        let mut improved = Improved::open(&files.simulation).unwrap();
        improved.set(&set.world.base);
        (folder, set, improved)
    }

    #[test]
    fn the_true_model_leaves_as_much_as_the_true_world() {
        for arena in [Arena::Flight, Arena::Plane, Arena::Centre, Arena::Pendulum] {
            let (_folder, set, improved) = set(Hidden::Nothing(arena));
            let ratio = over_truth(&improved, &set, &set.held_out);
            assert!((ratio - 1.0).abs() < 1e-4, "{arena:?}: {ratio}");
            assert!(errors(&improved, &set, &set.held_out).nmse < 1e-9);
        }
    }

    #[test]
    fn a_model_without_the_law_leaves_more() {
        let (_folder, set, improved) = set(Hidden::Inside("inverse-r", Arena::Plane));
        assert!(over_truth(&improved, &set, &set.held_out) > 1.5);
        let errors = errors(&improved, &set, &set.held_out);
        assert!((errors.left - 1.0).abs() < 1e-6, "{errors:?}");
    }

    #[test]
    fn the_noise_is_what_fitted_starts_leave() {
        let (_folder, set, _) = set(Hidden::Inside("drag-2", Arena::Flight));
        let mut mean = 0.0;
        for one in set.fitted.iter().chain(&set.held_out).chain(&set.faster) {
            let seen = |start: &[f64; 6]| {
                let run = crate::law::arena::Run { start: *start, ..one.run.clone() };
                Some(set.world.seen(&run, &set.clock))
            };
            mean += squares_of(Arena::Flight, one, seen).unwrap() / 7.0;
        }
        let expected = set.noise.powi(2) * (450.0 - 6.0);
        assert!((mean / expected - 1.0).abs() < 0.08, "{mean} {expected}");
    }
}
