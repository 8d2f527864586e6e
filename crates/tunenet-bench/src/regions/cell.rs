//! One cell of the table: how recordings are drawn, and how often what is stated of them holds.

use anyhow::Result;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;
use serde::{Deserialize, Serialize};
use std::path::Path;
use tunenet_core::observation::{Kind, Observation};
use tunenet_core::simulator::Simulator;
use tunenet_core::tune::{Outcome, Settings, Status, Verdict, tune};
use tunenet_sim::{ObservedBall, SimulationFile};

use super::swing::{self, Swing};
use super::throw::ClosedFormThrow;
use crate::scene::{ANY_BALL, seeds};

/// Radius of that ball, m.
const RADIUS_M: f64 = 0.02;

/// What a recording shows.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Scene {
    /// A throw that slips at its first impact: both parameters are determined.
    ThrowSlips,
    /// A throw that grips at its first impact: any greater friction does the same.
    ThrowGrips,
    /// A throw with any friction from 0.02 to 0.8.
    ThrowAny,
    /// A pendulum well inside its bounds.
    Pendulum,
    /// A pendulum whose damping is next to nothing, at most 2 % of its bounds.
    PendulumAtBound,
}

/// How recordings are drawn.
#[derive(Debug, Clone, Copy, Serialize, Deserialize)]
pub struct RegionCell {
    pub scene: Scene,
    /// Noise of every channel: m, or rad.
    pub noise: f64,
    pub rate_hz: f64,
}

impl RegionCell {
    /// All cells, in the order of the table.
    pub fn all() -> Vec<Self> {
        let throws = [(0.0005, 240.0), (0.002, 120.0), (0.005, 60.0), (0.01, 120.0)];
        let swings = [(0.001, 100.0), (0.005, 50.0), (0.02, 25.0)];
        let over = |scene, how: &[(f64, f64)]| -> Vec<Self> {
            how.iter().map(|&(noise, rate_hz)| Self { scene, noise, rate_hz }).collect()
        };
        [
            over(Scene::ThrowSlips, &throws),
            over(Scene::ThrowGrips, &throws[1..3]),
            over(Scene::ThrowAny, &throws[1..3]),
            over(Scene::Pendulum, &swings),
            over(Scene::PendulumAtBound, &swings[..2]),
        ]
        .concat()
    }

    pub fn name(&self) -> String {
        let scene = match self.scene {
            Scene::ThrowSlips => "throw that slips",
            Scene::ThrowGrips => "throw that grips",
            Scene::ThrowAny => "throw, any friction",
            Scene::Pendulum => "pendulum",
            Scene::PendulumAtBound => "pendulum, hardly damped",
        };
        let noise = match self.scene {
            Scene::Pendulum | Scene::PendulumAtBound => format!("{} mrad", self.noise * 1e3),
            _ => format!("{} mm", self.noise * 1e3),
        };
        format!("{scene}, {noise}, {} Hz", self.rate_hz)
    }

    /// Draws recording `number`, tunes to it, and holds what was found against the truth.
    pub fn one(&self, seed: u64, number: u64) -> Result<Found> {
        let mut random = ChaCha8Rng::seed_from_u64(seed.wrapping_add(seeds::REGIONS));
        random.set_stream(number);
        match self.scene {
            Scene::Pendulum | Scene::PendulumAtBound => self.swing(&mut random),
            _ => self.throw(&mut random),
        }
    }

    fn throw(&self, random: &mut ChaCha8Rng) -> Result<Found> {
        let (speed, course) = (random.random_range(2.0..6.0), random.random_range(0.0..std::f64::consts::TAU));
        let mut throw = ClosedFormThrow {
            restitution: random.random_range(0.3..0.95),
            friction: 0.0,
            radius_m: RADIUS_M,
            position_m: [0.0, 0.0, RADIUS_M + random.random_range(0.5..2.0)],
            velocity_m_s: [speed * f64::cos(course), speed * f64::sin(course), random.random_range(-1.0..2.0)],
        };
        throw.friction = match self.scene {
            Scene::ThrowSlips => throw.grip() * random.random_range(0.1..0.9),
            Scene::ThrowGrips => throw.grip() * random.random_range(1.1..3.0),
            _ => random.random_range(0.02..0.8),
        };
        let impacts = random.random_range(2..6);
        let clock = clock(throw.middle_after_s(impacts), self.rate_hz);
        let mut noise = || self.noise * random.sample::<f64, _>(StandardNormal);
        let seen: Vec<[f64; 3]> =
            throw.positions(&clock, impacts).into_iter().map(|p| p.map(|v| v + noise())).collect();
        let mut file = SimulationFile::parse(Path::new("ball.toml"), ANY_BALL)?;
        file.set("parameters.friction.tune=true")?;
        let ball = ObservedBall::new(&file, Kind::Positions)?;
        judge(&ball, Observation::positions(clock, &seen)?, &[throw.restitution, throw.friction])
    }

    fn swing(&self, random: &mut ChaCha8Rng) -> Result<Found> {
        let damping = if self.scene == Scene::Pendulum { 0.1..0.9 } else { 0.0..0.02 };
        let side = if random.random() { 1.0 } else { -1.0 };
        let truth =
            [random.random_range(0.4..1.6), random.random_range(damping), side * random.random_range(0.1..0.35)];
        let clock = clock(random.random_range(3.0..8.0), self.rate_hz);
        let angles = clock
            .iter()
            .map(|&t| swing::angle(truth, t) + self.noise * random.sample::<f64, _>(StandardNormal))
            .collect();
        let swing = Swing::new()?;
        let seen = Observation::new(Kind::Other, swing.channels().to_vec(), clock, angles)?;
        judge(&swing, seen, &truth)
    }
}

fn clock(end_s: f64, rate_hz: f64) -> Vec<f64> {
    (0..u32::MAX).map(|i| f64::from(i) / rate_hz).take_while(|t| *t < end_s).collect()
}

/// What came of one recording.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Found {
    /// For each parameter: its name, whether its interval holds the truth, and how it stands.
    pub parameters: Vec<(String, bool, Status)>,
    /// Whether the joint region holds the truth, and whether the region as it is drawn does.
    pub region: Option<(bool, bool)>,
    /// Whether its boundary had to be walked.
    pub walked: bool,
    pub poor: bool,
    pub rollouts: usize,
}

fn judge(simulator: &dyn Simulator, seen: Observation, truth: &[f64]) -> Result<Found> {
    let seen = [seen];
    let outcome: Outcome = tune(simulator, &seen, None, &Settings::default())?;
    let parameters = outcome.parameters.iter().zip(truth).map(|(p, truth)| {
        let (low, high) = p.interval95;
        (p.name.clone(), (low..=high).contains(truth), p.status)
    });
    let hold = |region: &tunenet_core::tune::Region| -> Result<(bool, bool)> {
        let of = |name: &String| outcome.parameters.iter().position(|p| p.name == *name).map(|i| truth[i]);
        let values: Vec<f64> = region.parameters.iter().filter_map(of).collect();
        Ok((region.contains(simulator, &seen, &values)?, region.draws(&values)))
    };
    Ok(Found {
        parameters: parameters.collect(),
        region: outcome.region95.as_ref().map(hold).transpose()?,
        walked: outcome.region95.as_ref().is_some_and(|r| !r.boundary.is_empty()),
        poor: outcome.verdict == Verdict::PoorFit,
        rollouts: outcome.rollouts,
    })
}
