//! One trial: a ball is dropped and filmed, everybody plans, and all shoot in the hidden world.

use std::path::Path;

use anyhow::Result;
use rand::Rng;
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;
use serde::{Deserialize, Serialize};
use tunenet_sim::shot::reach::Anywhere;
use tunenet_sim::shot::{Belief, Rule, Settings, ShotScene, Task, plan};

use super::super::rehearsal::Track;
use super::ball::Ball;
use super::drop::Filmed;
use super::estimate::{Estimate, Read, apex_on_pixels, diagnosed, known};
use super::world::{RADIUS_M, shoot};

const TASK: &str = include_str!("../../../../../../assets/shot.toml");
/// Balls that each plan is weighed by.
const DRAWS: usize = 64;

/// Who plans.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Way {
    /// With a restitution of .5.
    Untuned,
    /// By the apex rule on raw pixels, the nearest path.
    Apex,
    /// With the tuned restitution, the nearest path, as in the paper.
    Nearest,
    /// With the tuned restitution, the surest height.
    Tuned,
    /// The same with what a diagnosis of three drops names.
    Diagnosed,
    /// With the true ball.
    Known,
}

impl Way {
    pub const ALL: [Self; 6] = [Self::Untuned, Self::Apex, Self::Nearest, Self::Tuned, Self::Diagnosed, Self::Known];

    pub fn words(self) -> &'static str {
        match self {
            Self::Untuned => "untuned, restitution .5",
            Self::Apex => "apex rule on raw pixels, nearest path",
            Self::Nearest => "restitution alone, nearest path (the paper's rule)",
            Self::Tuned => "restitution alone",
            Self::Diagnosed => "with named effects, from up to three drops",
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
pub struct Trial {
    /// Whether the ball fell off the table while it was filmed.
    pub left: bool,
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
        let task = Task::parse(Path::new("shot.toml"), TASK)?;
        let scene = ShotScene::new(&task, RADIUS_M).map_err(anyhow::Error::msg)?;
        Ok(Self { task, scene })
    }

    /// The height that `rule` chooses for a believed ball, m.
    pub fn height(&self, estimate: &Estimate, rule: Rule) -> Result<f64> {
        let belief = Belief::new(&estimate.file()?, &self.task)?;
        let settings = Settings { rule, draws: DRAWS, ..Settings::default() };
        Ok(plan(&self.scene, &belief, self.task.heights_m, &Anywhere, &settings)?.best().height_m)
    }
}

/// A ball, what an undisturbed drop shows of it, and the height for who knows it.
pub struct Target {
    pub ball: Ball,
    pub shown: f64,
    pub known_m: f64,
    pub untuned_m: f64,
}

impl Target {
    pub fn new(ball: Ball, shown: f64, planner: &Planner) -> Result<Self> {
        let known_m = planner.height(&known(&ball), Rule::Probability)?;
        let untuned = Estimate { restitution: (0.5, (0.5, 0.5)), effects: Vec::new(), verdict: String::new() };
        let untuned_m = planner.height(&untuned, Rule::Nearest)?;
        Ok(Self { ball, shown, known_m, untuned_m })
    }
}

/// What everybody plans after one drop.
struct Planned {
    heights_m: Vec<(Way, f64)>,
    restitution: f64,
    /// Effects that the diagnosis named.
    named: Vec<String>,
}

impl Trial {
    /// From the films of up to three drops. `random` decides what chance does to the shots, the same for all who shoot.
    pub fn run(
        target: &Target,
        films: &[(Filmed, Option<Track>)],
        planner: &Planner,
        random: &ChaCha8Rng,
    ) -> Result<Self> {
        let reads: Vec<Read> = films.iter().map(|(_, track)| Read::new(track.as_ref())).collect();
        let flagged = reads[0].flagged();
        let planned = |first: usize| -> Result<Planned> {
            let (film, track) = &films[first];
            let tuned = reads[first].tuned(film.fall_m)?;
            // What was seen of a ball before it left is as good as ever; of drops too short for a diagnosis, the longest.
            let longest = (0..reads.len()).max_by_key(|i| (reads[*i].bounces_s.len(), *i == first)).unwrap_or(first);
            let effects = match diagnosed(&reads)? {
                Some(found) => found,
                None => reads[longest].tuned(films[longest].0.fall_m)?,
            };
            let apex = apex_on_pixels(track.as_ref(), film.fall_m);
            let apex = Estimate { restitution: (apex, (apex, apex)), effects: Vec::new(), verdict: "tuned".into() };
            let heights_m = vec![
                (Way::Untuned, target.untuned_m),
                (Way::Apex, planner.height(&apex, Rule::Nearest)?),
                (Way::Nearest, planner.height(&tuned, Rule::Nearest)?),
                (Way::Tuned, planner.height(&tuned, Rule::Probability)?),
                (Way::Diagnosed, planner.height(&effects, Rule::Probability)?),
                (Way::Known, target.known_m),
            ];
            let named = effects.effects.into_iter().map(|e| e.0).collect();
            Ok(Planned { heights_m, restitution: tuned.restitution.0, named })
        };
        let shots = |heights: &[(Way, f64)]| -> Vec<Shot> {
            let one = |&(way, height_m): &(Way, f64)| {
                let mut random = random.clone();
                let mut normal = || target.ball.spin_rad_s * random.sample::<f64, _>(StandardNormal);
                let spin = [normal(), normal(), 0.0];
                let landing = shoot(&target.ball, height_m, spin, &mut random);
                Shot { way, height_m, miss_m: landing.miss_m.min(9.0), goes_in: landing.goes_in }
            };
            heights.iter().map(one).collect()
        };
        let Planned { heights_m, restitution, named } = planned(0)?;
        let first = shots(&heights_m);
        let repeated = if flagged && films.len() > 1 { shots(&planned(1)?.heights_m) } else { first.clone() };
        let off = restitution - target.shown;
        Ok(Self { left: films[0].0.left, off, flagged, shots: first, repeated, named })
    }
}
