//! Any dropped ball: height, rate, release and floor unknown, as a user tunes to it, with the built-in network.

use std::fmt::Write;
use std::path::Path;

use anyhow::{Context, Result};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use tunenet_core::observation::{Kind, Observation};
use tunenet_core::statistics::{median, quantile};
use tunenet_core::tune::{Settings, tune};
use tunenet_sim::{ObservedBall, SimulationFile, built_in};

use super::any_drop::{self, DropParameters};
use super::closed_form::ClosedFormDrop;
use super::information;
use super::measure::short;
use super::rivals;
use crate::goals::{GENERAL_MEAN, GENERAL_MEDIAN_BOUNDS, met};
use crate::output::mean_and_median;
use crate::scene::{ANY_BALL, EASY, GRAVITY_M_S2, HARD, seeds};

/// Noise on every axis, in heights of fall.
const NOISE: f64 = 0.005;
const FALL_M: (f64, f64) = built_in::FALL_M;
const RATE_HZ: (f64, f64) = built_in::RATE_HZ;
const BOUNCES: std::ops::RangeInclusive<usize> = 2..=6;
/// Restitutions, and the greatest mean error that is aimed at.
pub const SETS: [(&str, (f64, f64), f64); 2] = [("easy", EASY, GENERAL_MEAN[0]), ("wide", HARD, GENERAL_MEAN[1])];
/// Half of all normal errors are smaller than this many standard deviations.
const NORMAL_MEDIAN: f64 = 0.6745;

/// A recording, its truth, and the smallest standard deviation that it allows.
struct GeneralTarget {
    truth: DropParameters,
    /// Time and height.
    heights: Vec<(f64, f64)>,
    seen: Observation,
    bound_sd: f64,
}

/// Errors of one way of tuning.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct GeneralErrors {
    pub name: String,
    pub mean: f64,
    pub median: f64,
    /// Nineteen of twenty are smaller.
    pub p95: f64,
}

/// One set of targets.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct GeneralTable {
    pub row: String,
    pub targets: u64,
    /// Median error that unbiased estimates with the least variance would have.
    pub bound: f64,
    /// The built-in network first.
    pub methods: Vec<GeneralErrors>,
    pub mean_limit: f64,
    pub median_limit: f64,
    pub met: bool,
}

/// Draws `count` targets and tunes to them.
pub fn table((name, range, mean_limit): (&str, (f64, f64), f64), seed: u64, count: u64) -> Result<GeneralTable> {
    let targets: Vec<GeneralTarget> =
        (0..count).into_par_iter().map(|number| draw(range, seed, number)).collect::<Result<_>>()?;
    let file = SimulationFile::parse(Path::new("ball.toml"), ANY_BALL)?;
    let ball = ObservedBall::new(&file, Kind::Positions)?;
    let model = built_in::ball()?;
    let tuned = |with: bool, finish: bool| {
        let one = |target: &GeneralTarget| -> Result<f64> {
            let settings = Settings { finish, ..Settings::default() };
            let model = with.then_some(&model);
            let outcome = tune(&ball, std::slice::from_ref(&target.seen), model, &settings)?;
            // No answer is counted as the middle of the bounds.
            let value = outcome.parameters.first().filter(|p| p.identified).map_or(0.5, |p| p.value);
            Ok((value - target.truth.drop.restitution).abs())
        };
        targets.par_iter().map(one).collect::<Result<Vec<f64>>>()
    };
    let rule = targets.iter().map(|t| (rivals::two_parabolas(&t.heights) - t.truth.drop.restitution).abs()).collect();
    let likeliest = |t: &GeneralTarget| {
        let (clock, heights): (Vec<f64>, Vec<f64>) = t.heights.iter().copied().unzip();
        (any_drop::fit(t.truth, &clock, &heights) - t.truth.drop.restitution).abs()
    };
    let methods = vec![
        errors("built-in network, then the fit", tuned(true, true)?),
        errors("the fit alone", tuned(false, true)?),
        errors("built-in network alone, K = 5", tuned(true, false)?),
        errors("two-parabola rule", rule),
        errors("maximum likelihood by the closed form", targets.par_iter().map(likeliest).collect()),
    ];
    let bound = median(targets.iter().map(|t| NORMAL_MEDIAN * t.bound_sd)).context("targets")?;
    let median_limit = GENERAL_MEDIAN_BOUNDS * bound;
    let is_met = methods[0].mean <= mean_limit && methods[0].median <= median_limit;
    Ok(GeneralTable {
        row: format!("general-{name}"),
        targets: count,
        bound,
        methods,
        mean_limit,
        median_limit,
        met: is_met,
    })
}

fn errors(name: &str, values: Vec<f64>) -> GeneralErrors {
    let p95 = quantile(values.iter().copied(), 0.95).unwrap_or(f64::NAN);
    let (mean, median) = mean_and_median(values);
    GeneralErrors { name: name.into(), mean, median, p95 }
}

/// The drop number `number`; it depends on these numbers alone. The record starts somewhere in the first third of the fall and
/// ends in the flight after the last of two to six bounces.
fn draw(range: (f64, f64), seed: u64, number: u64) -> Result<GeneralTarget> {
    let mut random = ChaCha8Rng::seed_from_u64(seeds::GENERAL_TARGETS ^ seed.rotate_left(32));
    random.set_stream(number | u64::from(range.0 > 0.0) << 40);
    let logarithmic = |random: &mut ChaCha8Rng, (low, high): (f64, f64)| low * (high / low).powf(random.random());
    let (fall_m, rate_hz) = (logarithmic(&mut random, FALL_M), logarithmic(&mut random, RATE_HZ));
    let drop = ClosedFormDrop { fall_m, restitution: random.random_range(range.0..=range.1) };
    let floor_m = random.random_range(-1.0..1.0);
    let fall_s = (2.0 * fall_m / GRAVITY_M_S2).sqrt();
    let begin_s = fall_s * random.random_range(0.0..0.33);
    let count = i32::try_from(random.random_range(BOUNCES))?;
    let flight_s = |n: i32| 2.0 * fall_s * drop.restitution.powi(n);
    let last_s = fall_s + (1..count).map(flight_s).sum::<f64>();
    // Nobody stops a camera at the first click: half the fall's time after it at the least.
    let end_s = (last_s + random.random::<f64>() * flight_s(count)).max(1.5 * fall_s);
    let clock: Vec<f64> =
        (0..1_000_000).map(|i| begin_s + f64::from(i) / rate_hz).take_while(|t| *t <= end_s).collect();
    let noise_m = NOISE * fall_m;
    let mut noise = || noise_m * random.sample::<f64, _>(StandardNormal);
    let rows: Vec<[f64; 3]> =
        drop.heights(&clock).into_iter().map(|z| [noise(), noise(), floor_m + z + noise()]).collect();
    let shown: Vec<f64> = clock.iter().map(|t| t - begin_s).collect();
    Ok(GeneralTarget {
        truth: DropParameters { drop, release_s: -begin_s, floor_m },
        heights: shown.iter().copied().zip(rows.iter().map(|r| r[2])).collect(),
        seen: Observation::positions(shown, &rows)?,
        bound_sd: information::restitution_sd(drop, &clock, noise_m),
    })
}

/// The tables for users.
pub fn markdown(tables: &[GeneralTable]) -> String {
    let mut out = String::new();
    for table in tables {
        let _ = writeln!(
            out,
            "## {}: {} targets, noise {} % of the height of fall, error of restitution\n\n\
             Any ball from {} to {} m at {} to {} Hz, two to six bounces; height, release and floor unknown. Bound on the \
             median: {}.\n\n| method | mean | median | 95 % below |\n|---|---|---|---|",
            table.row,
            table.targets,
            NOISE * 100.0,
            FALL_M.0,
            FALL_M.1,
            RATE_HZ.0,
            RATE_HZ.1,
            short(table.bound)
        );
        for GeneralErrors { name, mean, median, p95 } in &table.methods {
            let _ = writeln!(out, "| {name} | {} | {} | {} |", short(*mean), short(*median), short(*p95));
        }
        let ours = &table.methods[0];
        let _ = writeln!(
            out,
            "\n- mean ≤ {}: {}; median ≤ {} ({GENERAL_MEDIAN_BOUNDS} × bound): {}; {}\n\
             - maximum likelihood starts from the truth too: what it errs by is in the data, not in the search\n",
            short(table.mean_limit),
            short(ours.mean),
            short(table.median_limit),
            short(ours.median),
            met(table.met)
        );
    }
    out
}

/// Lines in the form of `tuning.csv`: no count of rollouts, since each answer takes as many as it needs.
pub fn csv(tables: &[GeneralTable]) -> String {
    let mut out = String::new();
    for (table, method) in tables.iter().flat_map(|t| t.methods.iter().map(move |m| (t, m))) {
        let name = method.name.replace(',', "");
        let _ = writeln!(out, "{},{name},1,,error of restitution,{},,{}", table.row, method.mean, method.median);
    }
    out
}
