//! A drop as the hidden world has it, and the camera that records it.

use anyhow::{Context, Result};
use rand::Rng;
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;
use tunenet_core::camera::Pinhole;

use super::ball::ShotBall;
use super::world::{RADIUS_M, ShotState, Three, drop};

/// Fall of the centre, m.
const DROP_FALL_M: std::ops::Range<f64> = 0.5..0.7;
/// Standard deviations of where the ball is released, m, and how it is pushed, m/s, along each level axis.
const OFFSET_M: f64 = 0.01;
const PUSH_M_S: f64 = 0.08;
const FRAMES: u32 = 150;
const RATE_HZ: f64 = 60.0;
/// Where the camera stands, m, and what it aims at above the resting ball's centre.
const DISTANCE_M: std::ops::Range<f64> = 0.8..1.2;
const HEIGHT_M: std::ops::Range<f64> = 0.3..0.6;
const AIM_M: f64 = 0.25;
const FIELD_OF_VIEW_RAD: f64 = std::f64::consts::FRAC_PI_3;
const PICTURE_PX: (usize, usize) = (320, 240);
const MOST_DRAWS: usize = 1000;
/// A place that no camera sees, m.
const NOWHERE_M: f64 = -1e6;

/// What a user records of a drop: how high it was, and a video.
pub struct VideoDrop {
    pub fall_m: f64,
    pub camera: Pinhole,
    /// What can be seen of the ball's centre, m.
    pub path_m: Vec<Three>,
    /// Whether the ball fell off the table during the recording.
    pub left: bool,
    /// How often it hit the table before that.
    pub impacts: usize,
}

/// The instants of a video, s.
pub fn clock() -> Vec<f64> {
    (0..FRAMES).map(|i| f64::from(i) / RATE_HZ).collect()
}

/// From how high a person drops the ball, each time of a trial.
pub fn height(random: &mut ChaCha8Rng) -> f64 {
    random.random_range(DROP_FALL_M)
}

impl VideoDrop {
    /// Releases a ball from `fall_m` above the table, before a camera of its own.
    pub fn draw(ball: &ShotBall, fall_m: f64, random: &mut ChaCha8Rng) -> Result<Self> {
        let camera = camera(fall_m, random)?;
        let mut normal = || random.sample::<f64, _>(StandardNormal);
        let (x, v) = ([normal(), normal()].map(|n| n * OFFSET_M), [normal(), normal()].map(|n| n * PUSH_M_S));
        let w = [normal(), normal()].map(|n| n * ball.spin_rad_s);
        let start = ShotState { x: [x[0], x[1], fall_m + RADIUS_M], v: [v[0], v[1], 0.0], w: [w[0], w[1], 0.0] };
        let dropped = drop(ball, start, &clock(), random);
        // The table's edge hides what falls below its top.
        let hidden = |x: &Three| if x[2] < 0.0 { [0.0, 0.0, NOWHERE_M] } else { *x };
        let left = dropped.gone_s.is_some() && dropped.path_m.last().is_some_and(|x| x[2] < 0.0);
        let path_m = dropped.path_m.iter().map(hidden).collect();
        Ok(Self { fall_m, camera, path_m, left, impacts: dropped.impacts_s.len() })
    }
}

/// A camera that sees the whole fall.
fn camera(fall_m: f64, random: &mut ChaCha8Rng) -> Result<Pinhole> {
    let sees = |camera: &Pinhole, z: f64| {
        camera.disc([0.0, 0.0, z], 1.5 * RADIUS_M).is_some_and(|disc| {
            let at = disc.centre_px[1];
            at >= disc.radius_px && at <= PICTURE_PX.1 as f64 - 1.0 - disc.radius_px
        })
    };
    let mut cameras = (0..MOST_DRAWS).filter_map(|_| {
        let eye = [random.random_range(DISTANCE_M), 0.0, random.random_range(HEIGHT_M) + RADIUS_M];
        Pinhole::aimed(eye, [0.0, 0.0, AIM_M + RADIUS_M], FIELD_OF_VIEW_RAD, PICTURE_PX)
    });
    let found = cameras.find(|camera| sees(camera, fall_m + RADIUS_M) && sees(camera, RADIUS_M));
    found.with_context(|| format!("no camera sees a fall of {fall_m} m"))
}
