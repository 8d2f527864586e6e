//! `tunenet bench shot`: a ball is dropped in front of a camera, and the next time it has to go through a hoop.
//!
//! ```text
//! ball, world (hidden) → drop → video (rendered, tracked) → estimate (tuned, diagnosed) → trial (planned, shot) → results,
//! figure
//! ```
//!
//! The hidden world shares nothing with the simulator that is tuned and planned with; all that leaves it is videos and the
//! height of each fall. Every finished piece is kept by [`resume`](super::resume).

mod ball;
mod drop;
mod estimate;
mod figure;
mod lacking;
mod results;
mod share;
mod trial;
mod video;
mod world;

use anyhow::{Context, Result};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;
use serde_json::json;
use sha2::{Digest, Sha256};

use self::ball::ShotBall;
use self::drop::VideoDrop;
use self::results::Series;
pub use self::results::ShotResults;
use self::trial::{Planner, ShotTarget, ShotTrial};
use self::world::{RADIUS_M, ShotState};
use super::resume::{Store, program};
use crate::args::{BenchShot, Measured};
use crate::lazy::Lazy;
use tunenet_cli::exit_status::Exit;
use tunenet_cli::view::answer;
use tunenet_cli::view::json::print_json;
use tunenet_cli::view::text::{progress, stage};

/// Trials of each ball; one in so many is played in a richer world as well.
const TRIALS: u64 = 200;
const RICHER: u64 = 4;
const QUICK: u64 = 10;
/// Drops of a trial.
const DROPS: u64 = 3;
/// Part of a stream: after the drops of a trial, its shots and its height.
const LACKING: u64 = DROPS + 2;
/// Trials that are recorded and kept together.
const TRIALS_PER_PIECE: u64 = 25;
/// The fall of an undisturbed drop, m.
const UNDISTURBED_FALL_M: f64 = 0.6;

pub fn run(options: &BenchShot) -> Result<Exit> {
    let seed = options.common.seed;
    let store = Store::open(&options.out, json!({ "program": program()?, "seed": seed }), &options.sharing)?;
    let results = measure(&store, Extent::new(options.trials, options.quick), seed)?;
    if let Some(exit) = store.finished(Measured::Shot(options.clone()), options.common.json)? {
        return Ok(exit);
    }
    results.write(&options.out)?;
    answer::text(options.common.json, &results.markdown())?;
    stage("wrote", &options.out.join("shot.md").display().to_string());
    if options.common.json {
        print_json(&results.as_json())?;
    }
    Ok(Exit::Done)
}

/// How much is played.
#[derive(Debug, Clone, Copy)]
pub struct Extent {
    /// Trials of each ball.
    trials: u64,
    /// Trials of each ball in a richer world.
    richer: u64,
    /// Whether it is found what each thing costs that is not known.
    lacking: bool,
    quick: bool,
}

impl Extent {
    fn new(trials: Option<u64>, quick: bool) -> Self {
        let trials = trials.unwrap_or(if quick { QUICK } else { TRIALS });
        Self { trials, richer: if quick { 0 } else { trials.div_ceil(RICHER) }, lacking: !quick, quick }
    }

    /// The six balls alone: no richer worlds, and no word on what is not known.
    pub fn plain(quick: bool) -> Self {
        Self { richer: 0, lacking: false, ..Self::new(None, quick) }
    }
}

/// Plays every trial that the store does not hold already. Of a run in shards the results are those of this share.
pub fn measure(store: &Store, extent: Extent, seed: u64) -> Result<ShotResults> {
    let Extent { trials, richer, lacking, quick } = extent;
    let planner = Planner::new()?;
    let balls = ball::all(&mut stream(seed, "balls", 0, 0));
    let bar = progress(6 * (trials + richer), "shots");
    let mut series = Vec::new();
    for (rich, count) in [(false, trials), (true, richer)] {
        for (number, ball) in balls.iter().enumerate() {
            let ball = if rich { ball.clone().richer() } else { ball.clone() };
            let name = format!("{}{number}", if rich { "richer" } else { "ball" });
            // Where all trials are kept already, it is not needed.
            let target = Lazy::new(|| target(ball.clone(), &planner));
            let mut all: Vec<ShotTrial> = Vec::new();
            for first in (0..count).step_by(usize::try_from(TRIALS_PER_PIECE)?) {
                let numbers = first..(first + TRIALS_PER_PIECE).min(count);
                let piece = format!("{name}-from-{first}-to-{}", numbers.end);
                let played = store.piece(&piece, || played(target.get()?, &name, seed, numbers.clone(), &planner))?;
                all.extend(played.into_iter().flatten());
                bar.inc(numbers.end - first);
            }
            if count > 0 {
                let random_stream = |shot: u64| stream(seed, &name, shot, LACKING);
                let costs = || lacking::costs(target.get()?, &planner, &random_stream);
                let lacking = if lacking { store.keep(&format!("{name}-lacking"), costs)? } else { Vec::new() };
                series.push(Series { ball: ball.clone(), rich, trials: all, lacking });
            }
        }
    }
    bar.finish_and_clear();
    Ok(ShotResults { seed, quick, trials, series })
}

/// Draws that depend on the seed and on what they are for, and on nothing else.
fn stream(seed: u64, what: &str, trial: u64, part: u64) -> ChaCha8Rng {
    ChaCha8Rng::from_seed(Sha256::digest(format!("tunenet bench shot/{seed}/{what}/{trial}/{part}")).into())
}

/// A ball with what a drop without push and scatter shows of it.
fn target(ball: ShotBall, planner: &Planner) -> Result<ShotTarget> {
    let quiet = ShotBall { scatter_rad: 0.0, ..ball.clone() };
    let start = ShotState { x: [0.0, 0.0, UNDISTURBED_FALL_M + RADIUS_M], v: [0.0; 3], w: [0.0; 3] };
    let seen = world::drop(&quiet, start, &drop::clock(), &mut stream(0, "quiet", 0, 0));
    let shown =
        estimate::tuned(&seen.impacts_s, UNDISTURBED_FALL_M)?.context("an undisturbed drop shows its restitution")?;
    ShotTarget::new(ball, shown.restitution.0, planner)
}

/// Trials of one ball: all are recorded at once, then planned and shot.
fn played(
    target: &ShotTarget,
    name: &str,
    seed: u64,
    numbers: std::ops::Range<u64>,
    planner: &Planner,
) -> Result<Vec<ShotTrial>> {
    let mut drops = Vec::new();
    for number in numbers.clone() {
        let fall_m = drop::height(&mut stream(seed, name, number, DROPS + 1));
        for drop in 0..DROPS {
            drops.push(VideoDrop::draw(&target.ball, fall_m, &mut stream(seed, name, number, drop))?);
        }
    }
    let tracks = video::tracks(&drops, seed ^ numbers.start)?;
    let mut seen = drops.into_iter().zip(tracks);
    let each: Vec<Vec<_>> =
        numbers.clone().map(|_| seen.by_ref().take(usize::try_from(DROPS).unwrap_or(1)).collect()).collect();
    let numbered: Vec<(u64, Vec<_>)> = numbers.zip(each).collect();
    let one =
        |(number, videos): &(u64, Vec<_>)| ShotTrial::run(target, videos, planner, &stream(seed, name, *number, DROPS));
    numbered.par_iter().map(one).collect()
}
