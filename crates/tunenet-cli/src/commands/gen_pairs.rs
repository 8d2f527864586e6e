//! `tunenet gen`.

use std::path::{Path, PathBuf};

use anyhow::Result;
use rand::Rng;
use rand_chacha::ChaCha8Rng;
use serde_json::json;
use tunenet_core::Error;
use tunenet_core::network::{CoveredParameter, DatasetHeader, DatasetReader, PairDraw, fill_shard, generate_shard};
use tunenet_core::simulator::Simulator;
use tunenet_sim::SimulationFile;
use tunenet_sim::drawn::{Drawn, Ranges};
use tunenet_sim::filmed::FilmedDrops;

use super::destination::{self, Output, Product};
use super::shard::{self, Share};
use super::{load, print_json};
use crate::cli::{Domain, Gen, Pairs};
use crate::failure::Exit;
use crate::terminal::{progress, stage};

/// The paper's ball: .5 m, seen at 60 Hz for 400 frames.
const PAPER_BALL: &str = include_str!("../../../../assets/ball_easy.toml");
/// Any ball: nothing is known of release and floor.
const ANY_BALL: &str = include_str!("../../../../assets/ball.toml");
/// The paper drops its ball's centre from these heights, m.
const CENTRE_HEIGHT_M: std::ops::Range<f64> = 4.0..5.0;

pub fn run(options: &Gen) -> Result<Exit> {
    let inputs: Vec<&Path> = options.sim.iter().map(AsRef::as_ref).collect();
    load::ending(&options.out, &["mcap"])?;
    let out = place(options);
    let output = Output::new(&out, "--out", Product::Dataset);
    destination::check(&[output], &inputs, options.writing.overwrite)?;
    if out.exists() && !out.is_file() {
        let message = "expected a file to write to, found a device";
        return Err(Error::file(&out, message, "choose a name that ends in .mcap").into());
    }
    if options.domain == Domain::Arm {
        return super::gen_arm::run(options);
    }
    if options.domain == Domain::Process {
        return super::gen_process::run(options);
    }
    let preset = options.preset.unwrap_or(Pairs::Easy);
    if preset == Pairs::Paper {
        let (expected, found) = ("`easy`, `hard`, `wide` or `general` for a ball".into(), "`paper`".into());
        return Err(Error::Setting { name: "--preset", expected, found }.into());
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
            return Err(Error::Setting { name: "--preset", expected, found }.into());
        }
        let drawn = Drawn::new(&file, Ranges::general())?;
        let header = drawn.header("ball/general", options.common.seed, options.pairs);
        let pair = |_: u64, random: &mut ChaCha8Rng| drawn.pair(random);
        let shard = options.sharing.shard;
        return made(options, &header, |report| fill_shard(&header, shard, &pair, &out, report));
    }
    // Every pair is dropped from a height of its own, at rest, at the record's first instant.
    file.unset("release.height_m");
    file.unset("release.position_m");
    for key in ["release.velocity_m_s=[0,0,0]", "release.time_s=0"] {
        file.set(key)?;
    }
    if file.number("surface.height_m").is_none() {
        file.set("surface.height_m=0")?;
    }
    let filmed = FilmedDrops::new(&file)?;
    let ball = filmed.ball();
    let floor = file.number("surface.height_m").unwrap_or(0.0);
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
        target_channels: if pixels { FilmedDrops::channels() } else { Vec::new() },
        clock: file.record().clock(),
        scene: file.text(),
    };
    let friction = ball.parameters()[1].value;
    if pixels {
        let pair = |_: u64, random: &mut ChaCha8Rng| {
            let top = floor + random.random_range(CENTRE_HEIGHT_M);
            let [proposed, target] = [proposed, target].map(|(low, high)| random.random_range(low..=high));
            filmed.pair(proposed, target, top, random)
        };
        let shard = options.sharing.shard;
        return made(options, &header, |report| fill_shard(&header, shard, &pair, &out, report));
    }
    let draw = |_: u64, random: &mut ChaCha8Rng| {
        let own = vec![0.0, 0.0, floor + random.random_range(CENTRE_HEIGHT_M)];
        let mut restitution = |(low, high): (f64, f64)| vec![random.random_range(low..=high), friction];
        let (proposed, target) = (restitution(proposed), restitution(target));
        let scale = Some(ball.scale(&own, 0.0));
        PairDraw { proposed, target, own, scale }
    };
    made(options, &header, |report| generate_shard(ball, &header, options.sharing.shard, &draw, &out, report))
}

/// Makes the pairs with `make`, where they are not there already, and says so.
pub(super) fn made(
    options: &Gen,
    header: &DatasetHeader,
    make: impl FnOnce(&mut dyn FnMut(u64, u64) -> bool) -> tunenet_core::Result<()>,
) -> Result<Exit> {
    if !there(options, header)? {
        let bar = progress(options.pairs, "rollouts");
        make(&mut |done, all| {
            bar.set_length(all);
            bar.set_position(done);
            true
        })?;
        bar.finish_and_clear();
    }
    tell(options, header)
}

/// Where the pairs are written: under `--out`, or where a shard of it belongs.
pub(super) fn place(options: &Gen) -> PathBuf {
    options.sharing.shard.map_or_else(|| options.out.clone(), |shard| shard::file(&options.out, shard))
}

/// Whether the shard is complete already, as of a task that is sent off again. One that is not is made again, and told.
///
/// # Errors
/// Where it is a shard of something else, which somebody may still want.
fn there(options: &Gen, header: &DatasetHeader) -> Result<bool> {
    let (Some(shard), out) = (options.sharing.shard, place(options)) else { return Ok(false) };
    if !out.exists() {
        return Ok(false);
    }
    let whole = DatasetReader::holds(&out, header, shard);
    if let Ok(other) = DatasetReader::open_shard(&out)
        && other.header() != header
        && !options.writing.overwrite
    {
        let told = |h: &DatasetHeader| format!("{} pairs of preset {}, seed {}", h.pairs, h.preset, h.seed);
        let message = format!("expected a shard of {}, found one of {}", told(header), told(other.header()));
        let hint = "give the command that made it, choose another --out, or replace it with --overwrite";
        return Err(Error::file(&out, message, hint).into());
    }
    let (what, why) =
        if whole { ("kept", "is complete already") } else { ("again", "was not this shard, or not whole") };
    stage(what, &format!("{} {why}", out.display()));
    Ok(whole)
}

fn tell(options: &Gen, header: &DatasetHeader) -> Result<Exit> {
    if let Some(shard) = options.sharing.shard {
        let block = shard.block(header.pairs);
        let what = format!("of {} pairs, preset {}, seed {}", header.pairs, header.preset, header.seed);
        let share = Share { pieces: block.end - block.start, all: header.pairs };
        return shard::tell(shard, &place(options), share, &what, options.common.json);
    }
    stage(
        "wrote",
        &format!("{}, {} pairs, preset {}, seed {}", options.out.display(), options.pairs, header.preset, header.seed),
    );
    if options.common.json {
        let frames = (!header.clocks_in_pairs()).then_some(header.clock.len());
        print_json(&json!({
            "schema": "tunenet.gen/1", "file": load::name(&options.out), "preset": header.preset,
            "pairs": options.pairs, "seed": header.seed, "frames": frames, "warnings": [],
        }))?;
    }
    Ok(Exit::Done)
}

/// The restitutions that proposed and target are drawn from.
pub fn ranges(pairs: Pairs) -> ((f64, f64), (f64, f64)) {
    match pairs {
        Pairs::Easy => ((0.3, 0.7), (0.3, 0.7)),
        Pairs::Hard => ((0.3, 0.7), (0.0, 1.0)),
        Pairs::Wide | Pairs::General | Pairs::Paper => ((0.0, 1.0), (0.0, 1.0)),
    }
}
