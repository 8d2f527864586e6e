//! The drops that everything is judged on, and the simulator that is tuned to them.

use std::path::Path;

use anyhow::Result;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;
use tunenet_core::observation::{Kind, Observation};
use tunenet_core::simulator::{Parameter, Prepared, Simulator, rollout};
use tunenet_core::tune::Point;
use tunenet_sim::scene::BallParameters;
use tunenet_sim::simulation_file::LeftOpen;
use tunenet_sim::{ObservedBall, SimulationFile};

use super::super::search::Search;
use super::closed_form::ClosedFormDrop;
use super::rows::Conditions;
use crate::scene::{EASY, PAPER_BALL, PAPER_CENTRE_M, PAPER_RADIUS_M, seeds};

/// Where the proposed models start: the paper's training range.
const PROPOSED: (f64, f64) = EASY;

/// One drop that a simulator is to be tuned to; its height of fall and its floor are known.
pub struct DropTarget {
    pub fall_m: f64,
    /// What is to be found.
    pub restitution: f64,
    /// What the iterations start from.
    pub proposed: f64,
    /// Least and greatest restitution that the target was drawn from.
    pub range: (f64, f64),
    /// Heights of the lowest point as seen, m.
    pub heights_m: Vec<f64>,
    /// The same as the tuner sees it.
    pub prepared: Prepared,
}

/// The paper's ball in our simulator, its release left open.
pub struct Simulation {
    pub ball: ObservedBall,
    pub clock: Vec<f64>,
}

impl Simulation {
    pub fn new() -> Result<Self> {
        let mut file = SimulationFile::parse(Path::new("ball_easy.toml"), PAPER_BALL)?;
        file.leave_open(&[LeftOpen::ReleaseHeight]);
        Ok(Self { ball: ObservedBall::new(&file, Kind::Positions)?, clock: file.record().clock() })
    }

    /// The drop number `number` of a row; each depends on these numbers alone.
    pub fn target(&self, conditions: Conditions, seed: u64, row: u64, number: u64) -> Result<DropTarget> {
        let mut random = ChaCha8Rng::seed_from_u64(seeds::TUNING_TARGETS ^ seed.rotate_left(32));
        random.set_stream(row << 32 | number);
        let fall_m = random.random_range(PAPER_CENTRE_M) - PAPER_RADIUS_M;
        let restitution = random.random_range(conditions.restitution.0..=conditions.restitution.1);
        let proposed = random.random_range(PROPOSED.0..=PROPOSED.1);
        let mut heights_m = ClosedFormDrop { fall_m, restitution }.heights(&self.clock);
        for height in &mut heights_m {
            *height += conditions.noise_m * random.sample::<f64, _>(StandardNormal);
        }
        self.seen(fall_m, heights_m, (restitution, proposed), conditions.restitution)
    }

    /// A target from its heights.
    pub fn seen(
        &self,
        fall_m: f64,
        heights_m: Vec<f64>,
        (restitution, proposed): (f64, f64),
        range: (f64, f64),
    ) -> Result<DropTarget> {
        let rows: Vec<[f64; 3]> = heights_m.iter().map(|z| [0.0, 0.0, z + PAPER_RADIUS_M]).collect();
        let observation = Observation::positions(self.clock.clone(), &rows)?;
        let release = [0.0, 0.0, fall_m + PAPER_RADIUS_M];
        let mut prepared = Prepared::whole(observation, self.ball.parameters().len());
        // Known, so the bounds say nothing; a parameter needs some.
        let known = release.iter().zip(["x", "y", "z"]);
        prepared.nuisances = known
            .map(|(v, axis)| Parameter::new(format!("release.{axis}"), "m", *v, v - 1.0, v + 1.0))
            .collect::<tunenet_core::Result<_>>()?;
        prepared.scale = Some(self.ball.scale(&release, 0.0));
        Ok(DropTarget { fall_m, restitution, proposed, range, heights_m, prepared })
    }

    /// The start of the iterations on a target.
    pub fn start(&self, target: &DropTarget) -> Point {
        let mut point = Point::start(&self.ball, std::slice::from_ref(&target.prepared));
        point.parameters[0] = target.proposed;
        point
    }

    /// A target as any search for one number sees it.
    pub fn search<'a>(&'a self, target: &'a DropTarget, seed: u64) -> Search<'a> {
        Search {
            roll: Box::new(|e| self.roll(target, e)),
            seen: &target.heights_m,
            proposed: target.proposed,
            range: target.range,
            bounds: (0.0, 1.0),
            // Every target is its own draw.
            seed: seed ^ target.fall_m.to_bits(),
        }
    }

    /// One rollout from a target's release: heights of the lowest point, m.
    pub fn roll(&self, target: &DropTarget, restitution: f64) -> Result<Vec<f64>> {
        self.roll_on(&self.clock, target.fall_m, restitution)
    }

    /// One rollout on another clock.
    pub fn roll_on(&self, clock: &[f64], fall_m: f64, restitution: f64) -> Result<Vec<f64>> {
        let friction =
            self.ball.parameters().iter().find(|p| p.name == BallParameters::FRICTION).map_or(0.0, |p| p.value);
        let values = rollout(&self.ball, &[restitution, friction], &[0.0, 0.0, fall_m + PAPER_RADIUS_M], clock)?;
        Ok(values.chunks_exact(3).map(|row| row[2] - PAPER_RADIUS_M).collect())
    }
}

/// Mean of `|a − b|`.
pub fn mean_distance(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).sum::<f64>() / a.len() as f64
}
