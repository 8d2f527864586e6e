//! Release height of a shot: grid search over heights, by geometry or by the Monte Carlo probability of a hit.

use rayon::prelude::*;
use tunenet_core::{Error, Origin};

use super::belief::Draw;
use super::{Belief, Pass, Reach, ShotScene};
use crate::ball::{Scene, State};

/// Why there is no plan.
#[derive(Debug, thiserror::Error)]
pub enum NoPlan {
    /// The arm can hold the ball at none of the heights.
    #[error("the arm reaches none of the heights from {lowest_m} to {highest_m} m")]
    OutOfReach {
        /// The lowest of them, m.
        lowest_m: f64,
        /// The highest, m.
        highest_m: f64,
    },
    /// The ball of the file, released at one of the heights, cannot be followed.
    #[error("a height of {height_m} m: {message}")]
    NotFollowed {
        /// The height, m.
        height_m: f64,
        /// Why not.
        message: String,
    },
    /// A setting is out of its range, or the robot cannot be used.
    #[error(transparent)]
    Other(#[from] Error),
}

/// How the best height is chosen.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Rule {
    /// The one whose path passes closest to the hoop's centre, as in the paper (arXiv 1907.11200).
    Nearest,
    /// The one that most of the drawn balls go in from; among equals the one from which they stay farthest from the rim.
    Probability,
}

/// How to plan.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settings {
    /// How many heights, evenly from the lowest to the highest; at least 2.
    pub heights: usize,
    /// How to choose.
    pub rule: Rule,
    /// Balls drawn from what is uncertain.
    pub draws: usize,
    /// Start of the draws.
    pub seed: u64,
}

impl Default for Settings {
    fn default() -> Self {
        Self { heights: 100, rule: Rule::Probability, draws: 256, seed: 0 }
    }
}

/// One height.
#[derive(Debug, Clone, PartialEq)]
pub struct Candidate {
    /// Of the ball's centre above the impact point, m.
    pub height_m: f64,
    /// How the ball of the file goes by the hoop.
    pub pass: Pass,
    /// Share of the drawn balls that go in; absent where it was not asked for.
    pub probability: Option<f64>,
    /// Mean over them of how far they stay from the rim, m.
    margin_m: f64,
    /// The joints that hold the ball there (rad); `None` where the arm does not reach so far.
    pub joints_rad: Option<Vec<f64>>,
}

/// What planning ends with.
#[derive(Debug, Clone, PartialEq)]
pub struct Plan {
    /// Every height, from the lowest to the highest.
    pub candidates: Vec<Candidate>,
    /// Which of them is the best that the arm reaches; of a hoop that none reaches, the one that comes nearest.
    pub best: usize,
    /// Whether any ball goes in from there.
    pub reachable: bool,
}

impl Plan {
    /// The best height.
    #[must_use]
    pub fn best(&self) -> &Candidate {
        &self.candidates[self.best]
    }
}

/// Chooses among heights from `lowest` to `highest` (m, the ball's centre above the impact point).
///
/// # Errors
/// [`NoPlan::OutOfReach`] where `reach` reaches none of the heights; [`NoPlan::NotFollowed`] where the ball cannot be followed;
/// [`Error::Setting`] for fewer than 2 heights or no draw, and what `reach` refuses.
pub fn plan(
    scene: &ShotScene,
    belief: &Belief,
    (lowest, highest): (f64, f64),
    reach: &dyn Reach,
    settings: &Settings,
) -> Result<Plan, NoPlan> {
    if settings.heights < 2 || settings.draws == 0 {
        let found = format!("{} heights, {} draws", settings.heights, settings.draws);
        let expected = "at least 2 heights and 1 draw".into();
        return Err(Error::Setting { origin: Origin::Caller, name: "--heights", expected, found }.into());
    }
    let share = |i: usize| i as f64 / (settings.heights - 1) as f64;
    let heights: Vec<f64> = (0..settings.heights).map(|i| lowest + share(i) * (highest - lowest)).collect();
    let mut before: Option<Vec<f64>> = None;
    let mut joints = Vec::with_capacity(heights.len());
    for height in &heights {
        let held = reach.joints([0.0, 0.0, *height], before.as_deref())?;
        before = held.clone().or(before);
        joints.push(held);
    }
    if joints.iter().all(Option::is_none) {
        return Err(NoPlan::OutOfReach { lowest_m: lowest, highest_m: highest });
    }
    let nominal = belief.nominal();
    let mut candidates = heights
        .par_iter()
        .zip(joints)
        .map(|(height, joints_rad)| {
            let pass = shot(scene, &nominal, *height, &State::default())?;
            Ok(Candidate { height_m: *height, pass, probability: None, margin_m: pass.margin_m, joints_rad })
        })
        .collect::<Result<Vec<_>, NoPlan>>()?;
    let draws = belief.draws(settings.draws, settings.seed);
    if settings.rule == Rule::Probability {
        candidates.par_iter_mut().for_each(|candidate| candidate.weigh(scene, &draws));
    }
    let nearer =
        |a: &Candidate, b: &Candidate| b.pass.falls.cmp(&a.pass.falls).then(a.pass.miss_m.total_cmp(&b.pass.miss_m));
    let better = |a: &Candidate, b: &Candidate| match settings.rule {
        Rule::Nearest => nearer(a, b),
        Rule::Probability => {
            let probability = |c: &Candidate| c.probability.unwrap_or(0.0);
            let surer = probability(b).total_cmp(&probability(a));
            surer.then(b.margin_m.total_cmp(&a.margin_m)).then_with(|| nearer(a, b))
        }
    };
    let within = (0..candidates.len()).filter(|i| candidates[*i].joints_rad.is_some());
    let best = within.min_by(|a, b| better(&candidates[*a], &candidates[*b])).unwrap_or(0);
    candidates[best].weigh(scene, &draws);
    let reachable = candidates[best].pass.goes_in() || candidates[best].probability.is_some_and(|p| p > 0.0);
    Ok(Plan { candidates, best, reachable })
}

impl Candidate {
    fn weigh(&mut self, scene: &ShotScene, draws: &[Draw]) {
        if self.probability.is_some() {
            return;
        }
        // Beyond a ball's width a miss is a miss, and so is a release that never gets to bounce.
        let worst = -2.0 * scene.radius_m;
        let one = |draw: &Draw| match shot(scene, &draw.ball, self.height_m, &draw.offset) {
            Ok(pass) => (f64::from(u8::from(pass.goes_in())), pass.margin_m.clamp(worst, -worst)),
            Err(_) => (0.0, worst),
        };
        // Added up in their order, so that the number of threads changes no digit.
        let each: Vec<(f64, f64)> = draws.par_iter().map(one).collect();
        let (hits, margin) = each.iter().fold((0.0, 0.0), |(hits, margin), one| (hits + one.0, margin + one.1));
        let count = draws.len() as f64;
        (self.probability, self.margin_m) = (Some(hits / count), margin / count);
    }
}

fn shot(scene: &ShotScene, ball: &Scene, height_m: f64, offset: &State) -> Result<Pass, NoPlan> {
    let [x, y, z] = offset.position_m;
    let release = State { position_m: [x, y, z + height_m], ..*offset };
    let flight = scene.fly(ball, &release).map_err(|message| NoPlan::NotFollowed { height_m, message })?;
    Ok(Pass::judge(&flight, &scene.hoop, scene.radius_m))
}
