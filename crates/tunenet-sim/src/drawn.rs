//! Recordings drawn from a scene and prepared as real ones are: what networks for a ball learn from.
//!
//! A network that is to start from guesses of the release and the surface has to know what such guesses look like. So
//! nothing is handed to it: a drop is simulated, seen by a camera that starts and stops somewhere, given noise, and goes
//! through [`ObservedBall`]'s own `prepare`. The proposed side is a rollout from the guesses that came out.

use rand::Rng;
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;
use tunenet_core::network::{CoveredParameter, DatasetHeader, Pair};
use tunenet_core::observation::{FEWEST_SAMPLES, Kind, Observation};
use tunenet_core::simulator::{Preparation, Prepared, Simulator, rollout};
use tunenet_core::{Error, Result};

use crate::ball::impact_times;
use crate::scene::BallScene;
use crate::simulation_file::LeftOpen;
use crate::{ObservedBall, SimulationFile};

/// Draws that may fail in a row (no bounce before the record ends, say) before a scene is given up.
const MOST_DRAWS: usize = 1000;
/// Most samples of a drawn record.
const MOST_FRAMES: f64 = 4000.0;
/// Half of the records show the ball held for up to this long before it is released, s.
const LONGEST_HELD_S: f64 = 0.4;

/// What recordings are drawn from. Lengths are heights of fall, from the apex of the first flight; times are `√(h/g)`.
#[derive(Debug, Clone, PartialEq)]
pub struct Ranges {
    /// Height of fall, m; even in its logarithm.
    pub fall_m: (f64, f64),
    /// Frames per second; even in its logarithm.
    pub rate_hz: (f64, f64),
    /// How much of the way from the apex to the surface lies behind the ball in the first frame, 0 to 1.
    pub begun: (f64, f64),
    /// Speed along the surface, in `√(g h)`.
    pub across: (f64, f64),
    /// The record ends after so many impacts at the least ...
    pub bounces: (usize, usize),
    /// ... and at the latest after so long.
    pub longest: f64,
    /// Greatest standard deviation of the noise on every axis, in heights of fall.
    pub noise: f64,
}

impl Ranges {
    /// Drops that the network for any ball is trained on, a little beyond what it is used for.
    #[must_use]
    pub fn general() -> Self {
        Self {
            fall_m: (0.25, 12.0),
            rate_hz: (22.0, 260.0),
            begun: (0.0, 0.6),
            across: (0.0, 0.0),
            bounces: (1, 7),
            longest: 12.0,
            noise: 0.015,
        }
    }
}

/// A scene that recordings are drawn from.
#[derive(Debug, Clone)]
pub struct Drawn {
    /// As a user tunes it.
    ball: ObservedBall,
    /// The same with release and surface open: what really happens.
    open: ObservedBall,
    file: SimulationFile,
    ranges: Ranges,
}

impl Drawn {
    /// Drops of `file`'s ball; what the file says of the release and the surface stays.
    ///
    /// # Errors
    /// As [`ObservedBall::new`].
    pub fn new(file: &SimulationFile, ranges: Ranges) -> tunenet_formats::Result<Self> {
        let mut open = file.clone();
        open.leave_open(&[
            LeftOpen::ReleaseHeight,
            LeftOpen::ReleasePosition,
            LeftOpen::ReleaseVelocity,
            LeftOpen::ReleaseTime,
            LeftOpen::SurfaceHeight,
        ]);
        let ball = ObservedBall::new(file, Kind::Positions)?;
        Ok(Self { ball, open: ObservedBall::new(&open, Kind::Positions)?, file: file.clone(), ranges })
    }

    /// The head of a dataset of such pairs.
    #[must_use]
    pub fn header(&self, preset: &str, seed: u64, pairs: u64) -> DatasetHeader {
        let covered = |p: &tunenet_core::simulator::Parameter| CoveredParameter {
            name: p.name.clone(),
            unit: p.unit.clone(),
            min: p.min,
            max: p.max,
            tuned: p.tune,
        };
        DatasetHeader {
            preset: preset.into(),
            seed,
            pairs,
            parameters: self.ball.parameters().iter().map(covered).collect(),
            channels: self.ball.channels().to_vec(),
            target_channels: Vec::new(),
            clock: Vec::new(),
            scene: self.file.text(),
        }
    }

    /// A recording, and a rollout with other parameters from what was made of its release.
    ///
    /// # Errors
    /// [`Error::Simulator`] where a thousand draws in a row give no recording that shows the parameters.
    pub fn pair(&self, random: &mut ChaCha8Rng) -> Result<Pair> {
        for _ in 0..MOST_DRAWS {
            let truth = self.parameters(random);
            let proposed = self.parameters(random);
            let Some(prepared) = self.recording(&truth, random) else { continue };
            let (nuisances, clock) = (prepared.nuisance_values(), prepared.seen.clock().to_vec());
            if let Ok(rolled) = rollout(&self.ball, &proposed, &nuisances, &clock) {
                return Ok(Pair {
                    proposed_parameters: proposed,
                    target_parameters: truth,
                    own: nuisances,
                    scale: prepared.scale,
                    proposed: rolled,
                    target: prepared.seen.values().to_vec(),
                    clock,
                });
            }
        }
        let message = "no recording that shows the parameters could be drawn".into();
        Err(Error::Simulator { at: "the scene's values".into(), message })
    }

    /// Values of all parameters, those that are tuned drawn from their bounds.
    fn parameters(&self, random: &mut ChaCha8Rng) -> Vec<f64> {
        let each = self.ball.parameters().iter().map(|p| {
            let share: f64 = random.random();
            // More friction than stops the slip changes nothing, so small values are drawn more often.
            let share = match p.name.as_str() {
                "friction" => share * share,
                // Records of small restitutions are often refused, and the hardest where they are not.
                _ if random.random_bool(0.25) => 0.25 * share,
                _ => share,
            };
            if p.tune { p.min + share * p.span() } else { p.value }
        });
        each.collect()
    }

    /// One recording, prepared; `None` where it shows nothing or is refused.
    fn recording(&self, truth: &[f64], random: &mut ChaCha8Rng) -> Option<Prepared> {
        let Ranges { fall_m, rate_hz, begun, across, bounces, longest, noise } = &self.ranges;
        let BallScene { release, world, surface, ball, .. } = self.file.ball().ok()?;
        let (gravity, radius) = (world.gravity_m_s2, ball.radius_m);
        let floor = surface.height_m.unwrap_or(0.0);
        let fall = logarithmic(random, *fall_m);
        let speed = (gravity * fall).sqrt();
        let direction = std::f64::consts::TAU * random.random::<f64>();
        let side = speed * even(random, *across);
        let behind = even(random, *begun);
        let mut velocity = [side * direction.cos(), side * direction.sin(), -(2.0 * gravity * fall * behind).sqrt()];
        if random.random_bool(0.2) {
            velocity[2] = -velocity[2];
        }
        let held = release.time_s.is_none() && behind == 0.0 && random.random_bool(0.5);
        velocity = release.velocity_m_s.unwrap_or(velocity);
        let mut start = [0.0, 0.0, floor + radius + fall * (1.0 - behind)];
        if let Some(height) = release.height_m {
            start[2] = floor + radius + height;
        }
        start = release.position_m.unwrap_or(start);
        let nuisances = [&start[..], &velocity[..], &[floor]].concat();

        let (scene, state, _) = self.open.world(truth, &nuisances);
        let count = random.random_range(bounces.0..=bounces.1);
        let impacts = impact_times(&scene, &state, 0.0, count + 1).ok()?;
        let last = *impacts.get(count - 1).or(impacts.last())?;
        let next = impacts.get(count).copied().unwrap_or(last);
        let latest = longest * (fall / gravity).sqrt();
        let until = if random.random() { next } else { latest };
        let end = (last + random.random::<f64>() * (until - last)).min(latest);

        let rate = logarithmic(random, *rate_hz);
        let before = if held { even(random, (0.0, LONGEST_HELD_S)) } else { 0.0 };
        let begin = release.time_s.unwrap_or(0.0);
        // The camera does not wait for the release.
        let phase = if release.time_s.is_some() { 0.0 } else { random.random::<f64>() / rate };
        let frames = ((before + end) * rate).min(MOST_FRAMES);
        let clock: Vec<f64> = (0..1_000_000)
            .map(|i| f64::from(i) / rate + phase - before)
            .take_while(|t| *t * rate <= frames && *t <= end)
            .collect();
        let first = clock.partition_point(|t| *t < 0.0);
        if clock.len() < first + FEWEST_SAMPLES {
            return None;
        }
        // A rollout starts at the first instant of its clock: the release itself goes in front.
        let exact = clock[first] == 0.0;
        let free: Vec<f64> = (!exact).then_some(0.0).into_iter().chain(clock[first..].iter().copied()).collect();
        let rolled = rollout(&self.open, truth, &nuisances, &free).ok()?;
        let seen = rolled.chunks_exact(3).skip(usize::from(!exact));
        let held = std::iter::repeat_n(&start[..], first);
        let deviation = noise * fall * random.random::<f64>();
        let mut positions = Vec::with_capacity(3 * clock.len());
        for row in held.chain(seen) {
            positions.extend(row.iter().map(|v| v + deviation * random.sample::<f64, _>(StandardNormal)));
        }
        let clock: Vec<f64> = clock.iter().map(|t| t + begin).collect();
        let seen = Observation::new(Kind::Positions, self.ball.channels().to_vec(), clock, positions).ok()?;
        match self.ball.prepare(&seen) {
            Ok(Preparation::Usable(prepared)) if prepared.silent.iter().all(Option::is_none) => Some(*prepared),
            _ => None,
        }
    }
}

fn even(random: &mut ChaCha8Rng, (low, high): (f64, f64)) -> f64 {
    low + (high - low) * random.random::<f64>()
}

fn logarithmic(random: &mut ChaCha8Rng, (low, high): (f64, f64)) -> f64 {
    low * (high / low).powf(random.random())
}
