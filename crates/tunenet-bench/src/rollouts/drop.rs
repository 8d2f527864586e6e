//! A ball that falls and bounces, without noise but for the 6 decimals of its recording.

use std::path::Path;

use anyhow::Result;
use tunenet_core::Error;
use tunenet_core::observation::{Kind, Observation};
use tunenet_sim::ball::{Scene, State, positions};
use tunenet_sim::{ObservedBall, SimulationFile};

use super::problem::Problem;
use crate::scene::{ANY_BALL, GRAVITY_M_S2};

const RADIUS_M: f64 = 0.02;
const RESTITUTION: f64 = 0.7;
const HEIGHT_M: f64 = 1.0;
const FRAMES: u32 = 360;
const RATE_HZ: f64 = 120.0;
/// What the last decimal of a recording says, m.
const DIGIT_M: f64 = 1e-6;

pub fn problem(most_rollouts: usize) -> Result<Problem> {
    let file = SimulationFile::parse(Path::new("ball.toml"), ANY_BALL)?;
    let simulator = Box::new(ObservedBall::new(&file, Kind::Positions)?);
    // The standard deviation of what rounding leaves out.
    let noise = vec![DIGIT_M / 12.0_f64.sqrt(); 3];
    Ok(Problem { name: "noise-free ball", simulator, recordings: vec![recording()?], noise, most_rollouts })
}

fn recording() -> Result<Observation> {
    let scene = Scene {
        gravity_m_s2: GRAVITY_M_S2,
        radius_m: RADIUS_M,
        restitution: RESTITUTION,
        friction: 0.0,
        ..Scene::default()
    };
    let clock: Vec<f64> = (0..FRAMES).map(|i| f64::from(i) / RATE_HZ).collect();
    let mut values = vec![0.0; 3 * clock.len()];
    let start = State::at([0.0, 0.0, RADIUS_M + HEIGHT_M]);
    positions(&scene, &start, 0.0, &clock, &mut values)
        .map_err(|message| Error::Simulator { at: "the true values".into(), message })?;
    let rows: Vec<[f64; 3]> =
        values.chunks_exact(3).map(|row| [row[0], row[1], row[2]].map(|v| (v / DIGIT_M).round() * DIGIT_M)).collect();
    Ok(Observation::positions(clock, &rows)?)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_flight_is_a_parabola_to_the_last_digit() {
        let seen = recording().unwrap();
        for i in 0..50 {
            let height = RADIUS_M + HEIGHT_M - 0.5 * GRAVITY_M_S2 * seen.clock()[i].powi(2);
            assert!((seen.row(i)[2] - height).abs() <= 0.6 * DIGIT_M, "{i}: {:?} and {height}", seen.row(i));
        }
        assert!(seen.column(2).skip(60).fold(f64::INFINITY, f64::min) >= RADIUS_M - DIGIT_M);
    }
}
