//! The cells of `bench intervals`: recordings of one kind with one disturbance, from formulas alone.

use std::path::Path;

use anyhow::Result;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};
use tunenet_core::observation::{Kind, Observation};
use tunenet_core::tune::{Settings, Verdict, tune};
use tunenet_sim::simulation_file::LeftOpen;
use tunenet_sim::{ObservedBall, SimulationFile};

use crate::output::percent;
use crate::scene::{ANY_BALL, GRAVITY_M_S2, PAPER_BALL, PAPER_RADIUS_M, seeds};
use crate::tuning::closed_form::ClosedFormDrop;

/// The paper's heights of fall, m.
const FALLS_M: std::ops::Range<f64> = 3.5..4.5;
const RESTITUTIONS: [(f64, f64); 3] = [(0.0, 0.1), (0.1, 0.9), (0.9, 1.0)];
const NOISES_M: [f64; 3] = [0.005, 0.01, 0.03];
/// Noise of more than 1 % of the height of fall.
const GREAT_NOISES_M: [f64; 2] = [0.1, 0.2];
/// Noise and restitution of the cells with another disturbance.
const USUAL_NOISE_M: f64 = 0.01;
const USUAL_RESTITUTION: (f64, f64) = (0.1, 0.9);
/// Share of the samples that are outliers, and how far those lie off: m, either way.
const OUTLIER_SHARE: f64 = 0.05;
const OUTLIERS_M: std::ops::Range<f64> = 0.1..1.0;
/// Standard deviation of an instant, as a share of the time between two samples.
const JITTER_SHARE: f64 = 0.1;
/// Lists of impact times: their noise, s, heights of fall, m, and how many impacts.
const IMPACT_NOISE_S: f64 = 0.0002;
const IMPACT_FALLS_M: std::ops::Range<f64> = 0.5..1.5;
const IMPACT_RESTITUTION: (f64, f64) = (0.6, 0.9);
const IMPACTS: std::ops::RangeInclusive<u32> = 6..=14;
/// Scatter of the restitution from impact to impact, as a share of it.
const SCATTERS: [f64; 4] = [0.0, 0.003, 0.01, 0.03];

/// What a recording holds besides white noise.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Disturbance {
    None,
    /// Some samples lie far off.
    Outliers,
    /// Instants that are not those written down.
    Jitter,
    /// Restitution that differs from impact to impact, by this share.
    Scatter(f64),
}

/// Recordings of one kind, with noise of one size.
#[derive(Debug, Clone, Copy)]
pub struct Cell {
    /// Whether height of fall and surface are given; impact times need neither.
    given: Option<bool>,
    restitution: (f64, f64),
    /// m; of impact times, s.
    noise: f64,
    disturbance: Disturbance,
}

/// What came of one drop.
#[derive(Debug, Clone, Copy, Serialize, Deserialize)]
pub struct Tried {
    /// Whether the interval holds the truth.
    pub holds: bool,
    pub error: f64,
    pub verdict: Verdict,
}

/// All cells, in the order of the table.
pub fn cells() -> Vec<Cell> {
    let usual = |given, disturbance| Cell {
        given: Some(given),
        restitution: USUAL_RESTITUTION,
        noise: USUAL_NOISE_M,
        disturbance,
    };
    let mut all = Vec::new();
    for given in [true, false] {
        for restitution in RESTITUTIONS {
            all.extend(NOISES_M.map(|noise| Cell { restitution, noise, ..usual(given, Disturbance::None) }));
        }
    }
    for given in [true, false] {
        all.extend(GREAT_NOISES_M.map(|noise| Cell { noise, ..usual(given, Disturbance::None) }));
        all.extend([Disturbance::Outliers, Disturbance::Jitter].map(|disturbance| usual(given, disturbance)));
    }
    all.extend(SCATTERS.map(|share| Cell {
        given: None,
        restitution: IMPACT_RESTITUTION,
        noise: IMPACT_NOISE_S,
        disturbance: if share > 0.0 { Disturbance::Scatter(share) } else { Disturbance::None },
    }));
    all
}

impl Cell {
    /// Draws drop `number`, tunes to it, and compares what was found with the truth.
    pub fn tune(self, seed: u64, number: u32) -> Result<Tried> {
        let mut random = ChaCha8Rng::seed_from_u64(seed.wrapping_add(seeds::INTERVALS));
        random.set_stream(u64::from(number));
        let restitution = random.random_range(self.restitution.0..self.restitution.1);
        let (ball, seen) = match self.given {
            Some(given) => self.heights(&mut random, restitution, given)?,
            None => self.impacts(&mut random, restitution)?,
        };
        let outcome = tune(&ball, &[seen], None, &Settings::default())?;
        let first = outcome.parameters.first();
        Ok(Tried {
            holds: first.is_some_and(|p| (p.interval95.0..=p.interval95.1).contains(&restitution)),
            error: first.map_or(1.0, |p| (p.value - restitution).abs()),
            verdict: outcome.verdict,
        })
    }

    /// A drop by its positions, tuned to as a person would: with height of fall and surface, or with neither.
    fn heights(self, random: &mut ChaCha8Rng, restitution: f64, given: bool) -> Result<(ObservedBall, Observation)> {
        let drop = ClosedFormDrop { restitution, fall_m: random.random_range(FALLS_M) };
        let mut file = SimulationFile::parse(Path::new("ball_easy.toml"), PAPER_BALL)?;
        if given {
            file.set(&format!("release.height_m={}", drop.fall_m))?;
        } else {
            file.leave_open(&[
                LeftOpen::ReleaseHeight,
                LeftOpen::ReleaseVelocity,
                LeftOpen::ReleaseTime,
                LeftOpen::SurfaceHeight,
            ]);
        }
        let clock = file.record().clock();
        let instants: Vec<f64> = if self.disturbance == Disturbance::Jitter {
            let sd_s = JITTER_SHARE * (clock[1] - clock[0]);
            // Before the release the ball is held at the height of fall.
            clock.iter().map(|t| (t + sd_s * random.sample::<f64, _>(StandardNormal)).max(0.0)).collect()
        } else {
            clock.clone()
        };
        let heights = drop.heights(&instants);
        let noise = |random: &mut ChaCha8Rng| self.noise * random.sample::<f64, _>(StandardNormal);
        let mut positions: Vec<[f64; 3]> =
            heights.into_iter().map(|z| [noise(random), noise(random), PAPER_RADIUS_M + z + noise(random)]).collect();
        if self.disturbance == Disturbance::Outliers {
            for position in &mut positions {
                if random.random_bool(OUTLIER_SHARE) {
                    let off = random.random_range(OUTLIERS_M);
                    position[2] += if random.random_bool(0.5) { off } else { -off };
                }
            }
        }
        Ok((ObservedBall::new(&file, Kind::Positions)?, Observation::positions(clock, &positions)?))
    }

    /// The same ball by the times of its impacts: impact n leaves with `v_n = e_n v_{n−1}` and returns `2 v_n / g` later.
    fn impacts(self, random: &mut ChaCha8Rng, restitution: f64) -> Result<(ObservedBall, Observation)> {
        let file = SimulationFile::parse(Path::new("ball.toml"), ANY_BALL)?;
        let scatter = if let Disturbance::Scatter(share) = self.disturbance { share } else { 0.0 };
        let mut at_s = 0.0;
        let mut speed_m_s = (2.0 * GRAVITY_M_S2 * random.random_range(IMPACT_FALLS_M)).sqrt();
        let mut times_s = Vec::new();
        for _ in 0..random.random_range(IMPACTS) {
            times_s.push(at_s + self.noise * random.sample::<f64, _>(StandardNormal));
            speed_m_s *= restitution * (1.0 + scatter * random.sample::<f64, _>(StandardNormal));
            at_s += 2.0 * speed_m_s / GRAVITY_M_S2;
        }
        Ok((ObservedBall::new(&file, Kind::EventTimes)?, Observation::event_times("impact", times_s)?))
    }

    /// What was recorded and what is known of it, restitution, noise and disturbance, for a person.
    pub fn labels(self) -> [String; 4] {
        let noise = if self.given.is_some() {
            format!("{} cm", self.noise * 100.0)
        } else {
            format!("{} ms", self.noise * 1000.0)
        };
        let known = match self.given {
            Some(true) => "heights, given",
            Some(false) => "heights, unknown",
            None => "impact times",
        };
        let (low, high) = self.restitution;
        [known.into(), format!("{low} to {high}"), noise, self.disturbance.label()]
    }

    /// As [`labels`](Self::labels), for a program.
    pub fn json(self) -> Value {
        let recording = if self.given.is_some() { "heights" } else { "impact_times" };
        json!({
            "recording": recording, "given": self.given, "restitution": [self.restitution.0, self.restitution.1],
            "noise_m": self.given.is_some().then_some(self.noise), "noise_s": self.given.is_none().then_some(self.noise),
            "disturbance": self.disturbance.label(),
        })
    }
}

impl Disturbance {
    fn label(self) -> String {
        match self {
            Self::None => "none".into(),
            Self::Outliers => format!("{} outliers", percent(OUTLIER_SHARE)),
            Self::Jitter => format!("clock jitter {}", percent(JITTER_SHARE)),
            Self::Scatter(share) => format!("restitution ± {}", percent(share)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn seen(given: Option<bool>, disturbance: Disturbance, seed: u64) -> Observation {
        let cell = Cell { given, restitution: (0.7, 0.7), noise: 0.0, disturbance };
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        match given {
            Some(given) => cell.heights(&mut random, 0.7, given).unwrap().1,
            None => cell.impacts(&mut random, 0.7).unwrap().1,
        }
    }

    fn ratios(times_s: &[f64]) -> Vec<f64> {
        times_s.windows(3).map(|t| (t[2] - t[1]) / (t[1] - t[0])).collect()
    }

    #[test]
    fn flights_shorten_by_the_restitution_and_scatter_about_it() {
        let exact = seen(None, Disturbance::None, 1);
        assert!(IMPACTS.contains(&u32::try_from(exact.clock().len()).unwrap()));
        assert!(ratios(exact.values()).iter().all(|ratio| (ratio - 0.7).abs() < 1e-9));
        let scattered: Vec<f64> =
            (0..200).flat_map(|seed| ratios(seen(None, Disturbance::Scatter(0.03), seed).values())).collect();
        let count = scattered.len() as f64;
        let mean = scattered.iter().sum::<f64>() / count;
        let sd = (scattered.iter().map(|ratio| (ratio - mean).powi(2)).sum::<f64>() / count).sqrt();
        assert!((mean - 0.7).abs() < 0.003 && (sd - 0.021).abs() < 0.002, "{mean} {sd}");
    }

    /// Without noise, what differs from the undisturbed drop of the same seed is the disturbance alone.
    #[test]
    fn a_twentieth_of_the_samples_are_outliers_and_jitter_moves_instants_only() {
        let heights = |disturbance, seed| {
            seen(Some(false), disturbance, seed).values().iter().skip(2).step_by(3).copied().collect::<Vec<f64>>()
        };
        let (mut outliers, mut count) = (0_usize, 0_usize);
        for seed in 0..20 {
            let (plain, outlying) = (heights(Disturbance::None, seed), heights(Disturbance::Outliers, seed));
            for (plain, outlying) in plain.iter().zip(&outlying) {
                let off = (plain - outlying).abs();
                assert!(off == 0.0 || (0.1 - 1e-9..1.0).contains(&off), "{off}");
                outliers += usize::from(off > 0.0);
                count += 1;
            }
        }
        let share = outliers as f64 / count as f64;
        assert!((share - OUTLIER_SHARE).abs() < 0.01, "{share}");
        let (plain, jittered) = (heights(Disturbance::None, 3), heights(Disturbance::Jitter, 3));
        let furthest = plain.iter().zip(&jittered).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        // At most 9 m/s over some five standard deviations of 1.7 ms.
        assert!(furthest > 0.001 && furthest < 0.08, "{furthest}");
    }
}
