//! `tunenet gen ball` and `gen ball-video`.

use std::path::Path;

use anyhow::Result;
use rand::Rng;
use rand_chacha::ChaCha8Rng;
use tunenet_core::network::{CoveredParameter, DatasetHeader, PairDraw};
use tunenet_core::simulator::Simulator;
use tunenet_core::{Error, Origin};
use tunenet_formats::dataset::{fill, generate};
use tunenet_sim::SimulationFile;
use tunenet_sim::drawn::{Drawn, Ranges};
use tunenet_sim::scene::BallParameters;
use tunenet_sim::simulation_file::LeftOpen;
use tunenet_sim::video_drops::VideoDrops;

use super::super::load;
use super::write::made;
use crate::args::{Domain, Gen, Pairs};
use crate::exit_status::Exit;

/// The paper's ball: .5 m, seen at 60 Hz for 400 frames.
const PAPER_BALL: &str = include_str!("../../../../../assets/ball_easy.toml");
/// Any ball: nothing is known of release and floor.
const ANY_BALL: &str = include_str!("../../../../../assets/ball.toml");
/// The paper drops its ball's centre from these heights, m.
const CENTRE_HEIGHT_M: std::ops::Range<f64> = 4.0..5.0;

pub fn run(options: &Gen, out: &Path) -> Result<Exit> {
    let preset = options.preset.unwrap_or(Pairs::Easy);
    if preset == Pairs::Paper {
        let (expected, found) = ("`easy`, `hard`, `wide` or `general` for a ball".into(), "`paper`".into());
        return Err(Error::Setting { origin: Origin::Flag, name: "--preset", expected, found }.into());
    }
    let mut file = match (&options.sim, preset) {
        (Some(path), _) => SimulationFile::read(path)?,
        (None, Pairs::General) => SimulationFile::parse(Path::new("ball.toml"), ANY_BALL)?,
        (None, _) => SimulationFile::parse(Path::new("ball_easy.toml"), PAPER_BALL)?,
    };
    for assignment in &options.set {
        file.set(assignment)?;
    }
    load::of_kind(&file, tunenet_sim::simulation_file::Domain::Ball)?;
    if preset == Pairs::General {
        if options.domain == Domain::BallVideo {
            let (expected, found) = ("`easy`, `hard` or `wide` for ball-video".into(), "`general`".into());
            return Err(Error::Setting { origin: Origin::Flag, name: "--preset", expected, found }.into());
        }
        let drawn = Drawn::new(&file, Ranges::general())?;
        let header = drawn.header("ball/general", options.common.seed, options.pairs);
        let pair = |_: u64, random: &mut ChaCha8Rng| drawn.pair(random).map_err(tunenet_formats::Error::from);
        let shard = options.sharing.shard;
        return made(options, (&header, &[]), |report| fill(&header, shard, &pair, out, report));
    }
    // Every pair is dropped from a height of its own, at rest, at the record's first instant.
    file.leave_open(&[LeftOpen::ReleaseHeight, LeftOpen::ReleasePosition]);
    for key in ["release.velocity_m_s=[0,0,0]", "release.time_s=0"] {
        file.set(key)?;
    }
    if file.ball()?.surface.height_m.is_none() {
        file.set("surface.height_m=0")?;
    }
    let drops = VideoDrops::new(&file)?;
    let ball = drops.ball();
    let floor = file.ball()?.surface.height_m.unwrap_or(0.0);
    let (proposed, target) = ranges(preset);
    let pixels = options.domain == Domain::BallVideo;
    let covered = proposed.0.min(target.0)..proposed.1.max(target.1);
    let header = DatasetHeader {
        preset: format!("{}/{:?}", if pixels { "ball-video" } else { "ball" }, preset).to_lowercase(),
        seed: options.common.seed,
        pairs: options.pairs,
        parameters: ball
            .parameters()
            .iter()
            .map(|p| {
                let learned = p.name == "restitution";
                let (min, max) = if learned { (covered.start, covered.end) } else { (p.min, p.max) };
                CoveredParameter { name: p.name.clone(), unit: p.unit.clone(), min, max, tuned: learned }
            })
            .collect(),
        channels: ball.channels().to_vec(),
        target_channels: if pixels { VideoDrops::channels() } else { Vec::new() },
        clock: file.record().clock(),
        scene: file.text(),
    };
    let friction = ball.parameters().iter().find(|p| p.name == BallParameters::FRICTION).map_or(0.0, |p| p.value);
    if pixels {
        let pair = |_: u64, random: &mut ChaCha8Rng| {
            let top = floor + random.random_range(CENTRE_HEIGHT_M);
            let [proposed, target] = [proposed, target].map(|(low, high)| random.random_range(low..=high));
            drops.pair(proposed, target, top, random).map_err(tunenet_formats::Error::from)
        };
        let shard = options.sharing.shard;
        return made(options, (&header, &[]), |report| fill(&header, shard, &pair, out, report));
    }
    let draw = |_: u64, random: &mut ChaCha8Rng| {
        let own = vec![0.0, 0.0, floor + random.random_range(CENTRE_HEIGHT_M)];
        let mut restitution = |(low, high): (f64, f64)| vec![random.random_range(low..=high), friction];
        let (proposed, target) = (restitution(proposed), restitution(target));
        let scale = Some(ball.scale(&own, 0.0));
        PairDraw { proposed, target, own, scale }
    };
    made(options, (&header, &[]), |report| generate(ball, &header, options.sharing.shard, &draw, out, report))
}

/// The restitutions that proposed and target are drawn from.
pub fn ranges(pairs: Pairs) -> ((f64, f64), (f64, f64)) {
    match pairs {
        Pairs::Easy => ((0.3, 0.7), (0.3, 0.7)),
        Pairs::Hard => ((0.3, 0.7), (0.0, 1.0)),
        Pairs::Wide | Pairs::General | Pairs::Paper => ((0.0, 1.0), (0.0, 1.0)),
    }
}
