//! Drops from formulas alone, tuned to: the restitution comes back, and its interval keeps what it promises.

use crate::common::{Drop, Noise};
use rayon::prelude::*;
use tunenet_core::observation::{Kind, Observation};
use tunenet_core::tune::{Settings, Verdict, tune};
use tunenet_sim::{ObservedBall, SimulationFile};

const DROPS: u64 = 300;

fn drawn(seed: u64) -> Drop {
    let mut draw = Noise(seed.wrapping_mul(7919) + 1);
    let height_m = draw.between(0.3, 5.0);
    let mut drop = Drop {
        restitution: draw.between(0.05, 0.97),
        height_m,
        radius_m: draw.between(0.01, 0.5),
        floor_m: draw.between(-1.0, 1.0),
        rate_hz: draw.between(60.0, 240.0),
        frames: 0,
        held_s: draw.between(0.0, 0.3),
        noise_m: height_m * draw.between(0.0005, 0.003),
        seed: draw.next(),
    };
    let bounces = 2 + u32::try_from(draw.next() % 5).unwrap();
    // The record ends halfway through the flight after the last bounce.
    let end = f64::midpoint(drop.impact_s(bounces - 1), drop.impact_s(bounces));
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "seconds times a rate")]
    let frames = (end * drop.rate_hz) as usize + 1;
    drop.frames = frames;
    drop
}

/// What came of one drop.
struct Found {
    tuned: bool,
    covered: bool,
    story: String,
}

fn recover(seed: u64) -> Found {
    let drop = drawn(seed);
    let scene = format!(
        "kind = \"ball\"\n[ball]\nradius_m = {:?}\n[parameters.restitution]\nvalue = 0.5\nmin = 0.0\nmax = 1.0\n",
        drop.radius_m
    );
    let file = SimulationFile::parse("scene.toml".as_ref(), &scene).unwrap();
    let ball = ObservedBall::new(&file, Kind::Positions).unwrap();
    let (clock, rows): (Vec<f64>, Vec<[f64; 3]>) = drop.frames().into_iter().unzip();
    let seen = Observation::positions(clock, &rows).unwrap();
    let outcome = tune(&ball, &[seen], None, &Settings::default()).unwrap();
    let found = outcome.parameters.first();
    let (value, (low, high)) = found.map_or((f64::NAN, (f64::NAN, f64::NAN)), |p| (p.value, p.interval95));
    Found {
        tuned: outcome.verdict == Verdict::Tuned,
        covered: low <= drop.restitution && drop.restitution <= high,
        story: format!("{seed}: {:?} {value:.5} [{low:.5}, {high:.5}] {drop:?}", outcome.verdict),
    }
}

#[test]
fn drops_come_back_with_honest_intervals() {
    let all: Vec<Found> = (0..DROPS).into_par_iter().map(recover).collect();
    let share = |count: usize| count as f64 / all.len() as f64;
    let tuned = share(all.iter().filter(|f| f.tuned).count());
    let covered = share(all.iter().filter(|f| f.covered).count());
    eprintln!("{DROPS} drops: {tuned:.3} tuned, {covered:.3} covered");
    let stories = |wanted: fn(&Found) -> bool| {
        all.iter().filter(|f| wanted(f)).map(|f| f.story.as_str()).collect::<Vec<_>>().join("\n")
    };
    assert!(tuned >= 0.97, "{tuned} tuned, covered {covered}; not tuned:\n{}", stories(|f| !f.tuned));
    assert!(
        (0.90..=0.99).contains(&covered),
        "{covered} covered, tuned {tuned}; not covered:\n{}",
        stories(|f| !f.covered)
    );
}
