//! One trial: a ball is dropped and recorded; every method plans and shoots in the hidden world.

use std::cmp::Reverse;
use std::path::Path;

use anyhow::Result;
use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};
use tunenet_sim::shot::reach::Anywhere;
use tunenet_sim::shot::{Belief, Rule, Settings, ShotScene, Task, plan};

use super::ball::ShotBall;
use super::drop::VideoDrop;
use super::estimate::{BallEstimate, Read, Several, apex_on_pixels, known};
use super::world::{RADIUS_M, shoot};
use crate::scene::SHOT;
use tunenet_video_protocol::synthetic::Places;

/// Balls that a plan is weighed by: many for the plan with everything known, which is made once; intervals are narrow.
const DRAWS: usize = 32;
const DRAWS_KNOWN: usize = 512;

/// Who plans.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Way {
    /// With a restitution of 0.5.
    Untuned,
    /// By the apex rule on raw pixels, the nearest path.
    Apex,
    /// With the tuned restitution, the nearest path, as in the paper.
    Nearest,
    /// With the tuned restitution, the surest height.
    Tuned,
    /// The same with the restitution tuned to up to three drops.
    Pooled,
    /// The same with what a diagnosis of these names as well.
    Diagnosed,
    /// With the true ball.
    Known,
}

impl Way {
    pub const ALL: [Self; 7] =
        [Self::Untuned, Self::Apex, Self::Nearest, Self::Tuned, Self::Pooled, Self::Diagnosed, Self::Known];

    pub fn words(self) -> &'static str {
        match self {
            Self::Untuned => "untuned, restitution 0.5",
            Self::Apex => "apex rule on raw pixels, nearest path",
            Self::Nearest => "restitution alone, nearest path (the paper's rule)",
            Self::Tuned => "restitution alone",
            Self::Pooled => "restitution alone, from up to three drops",
            Self::Diagnosed => "with named effects and open drag, from up to three drops",
            Self::Known => "everything known",
        }
    }
}

/// What came of a shot.
#[derive(Debug, Clone, Copy, Serialize, Deserialize)]
pub struct Shot {
    pub way: Way,
    pub height_m: f64,
    pub miss_m: f64,
    pub goes_in: bool,
}

/// A trial from its first drop to its shots.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct ShotTrial {
    /// Whether the ball fell off the table during the recording.
    pub left: bool,
    /// How often it hit the table, and how often it was seen to.
    pub impacts: usize,
    pub bounces: usize,
    /// Whether the shot planned with the restitution alone misses even without random deflection of the rebound, where that of who knows
    /// everything goes in.
    pub misplanned: bool,
    /// How far the tuned restitution is from what an undisturbed drop shows.
    pub off: f64,
    pub flagged: bool,
    pub shots: Vec<Shot>,
    /// The same with a second drop where the first was flagged.
    pub repeated: Vec<Shot>,
    /// Effects that the diagnosis named.
    pub named: Vec<String>,
}

/// What plans shots.
pub struct Planner {
    task: Task,
    scene: ShotScene,
}

impl Planner {
    pub fn new() -> Result<Self> {
        let task = Task::parse(Path::new("shot.toml"), SHOT)?;
        let scene = ShotScene::new(&task, RADIUS_M).map_err(anyhow::Error::msg)?;
        Ok(Self { task, scene })
    }

    /// The height that `rule` chooses for a ball as estimated, m.
    pub fn height(&self, estimate: &BallEstimate, rule: Rule) -> Result<f64> {
        self.height_of(estimate, rule, DRAWS)
    }

    fn height_of(&self, estimate: &BallEstimate, rule: Rule, draws: usize) -> Result<f64> {
        let belief = Belief::new(&estimate.file()?, &self.task)?;
        let settings = Settings { rule, draws, ..Settings::default() };
        Ok(plan(&self.scene, &belief, self.task.release.heights_m, &Anywhere, &settings)?.best().height_m)
    }
}

/// A shot as it would be without random deflection.
fn goes_in_without_deflection(ball: &ShotBall, height_m: f64, random: &ChaCha8Rng) -> bool {
    let smooth = ShotBall { scatter_rad: 0.0, ..ball.clone() };
    shoot(&smooth, height_m, [0.0; 3], &mut random.clone()).goes_in
}

/// A ball, what an undisturbed drop shows of it, and the height for who knows it.
pub struct ShotTarget {
    pub ball: ShotBall,
    pub shown: f64,
    pub known_m: f64,
    pub untuned_m: f64,
}

impl ShotTarget {
    pub fn new(ball: ShotBall, shown: f64, planner: &Planner) -> Result<Self> {
        let known_m = planner.height_of(&known(&ball), Rule::Probability, DRAWS_KNOWN)?;
        let untuned_m = planner.height(&BallEstimate::exact(0.5), Rule::Nearest)?;
        Ok(Self { ball, shown, known_m, untuned_m })
    }
}

/// The plan of every method after one drop.
struct Planned {
    heights_m: Vec<(Way, f64)>,
    tuned_m: f64,
    restitution: f64,
}

impl ShotTrial {
    /// From the videos of up to three drops. `random` draws the deflections of the shots, the same for all who shoot.
    pub fn run(
        target: &ShotTarget,
        videos: &[(VideoDrop, Option<Places>)],
        planner: &Planner,
        random: &ChaCha8Rng,
    ) -> Result<Self> {
        let reads: Vec<Read> = videos.iter().map(|(_, track)| Read::new(track.as_ref())).collect();
        let flagged = reads[0].flagged();
        let several = Several::new(&reads, videos[0].0.fall_m)?;
        // Of drops too short for more, the longest.
        let longest = (0..reads.len()).max_by_key(|i| (reads[*i].bounces_s.len(), Reverse(*i))).unwrap_or(0);
        let pooled = match several.tuned()? {
            Some(found) => found,
            None => reads[longest].tuned(videos[longest].0.fall_m)?,
        };
        // Where diagnosis has nothing to plan with, the drops that it saw still show the restitution, and something of drag.
        let effects = match several.diagnosed()? {
            Some(found) => found,
            None => several.with_open_drag(pooled.clone())?,
        };
        let together = [
            (Way::Pooled, planner.height(&pooled, Rule::Probability)?),
            (Way::Diagnosed, planner.height(&effects, Rule::Probability)?),
            (Way::Untuned, target.untuned_m),
            (Way::Known, target.known_m),
        ];
        let planned = |first: usize| -> Result<Planned> {
            let (drop, track) = &videos[first];
            let tuned = reads[first].tuned(drop.fall_m)?;
            let apex = BallEstimate::exact(apex_on_pixels(track.as_ref(), drop.fall_m));
            let tuned_m = planner.height(&tuned, Rule::Probability)?;
            let of_one_drop = [
                (Way::Apex, planner.height(&apex, Rule::Nearest)?),
                (Way::Nearest, planner.height(&tuned, Rule::Nearest)?),
                (Way::Tuned, tuned_m),
            ];
            Ok(Planned {
                heights_m: of_one_drop.into_iter().chain(together).collect(),
                tuned_m,
                restitution: tuned.restitution.0,
            })
        };
        let shots = |heights: &[(Way, f64)]| -> Vec<Shot> {
            let one = |&(way, height_m): &(Way, f64)| {
                let mut random = random.clone();
                let spin = target.ball.spin(&mut random);
                let landing = shoot(&target.ball, height_m, spin, &mut random);
                Shot { way, height_m, miss_m: landing.miss_m.min(9.0), goes_in: landing.goes_in }
            };
            heights.iter().map(one).collect()
        };
        let Planned { heights_m, tuned_m, restitution } = planned(0)?;
        let first = shots(&heights_m);
        let repeated = if flagged && videos.len() > 1 { shots(&planned(1)?.heights_m) } else { first.clone() };
        let undeflected = |height_m: f64| goes_in_without_deflection(&target.ball, height_m, random);
        Ok(Self {
            left: videos[0].0.left,
            impacts: videos[0].0.impacts,
            bounces: reads[0].bounces_s.len(),
            misplanned: undeflected(target.known_m) && !undeflected(tuned_m),
            off: restitution - target.shown,
            flagged,
            shots: first,
            repeated,
            named: effects.effects.into_iter().map(|e| e.0).collect(),
        })
    }
}
