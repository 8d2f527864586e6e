//! What several benches have in common: scenes that come with the tool, ranges of the paper, and where random draws start.

/// Gravity of every closed form and every integrator of the benches, m/s²: the default of simulation files.
pub const GRAVITY_M_S2: f64 = 9.81;

/// The paper's ball (arXiv 1907.11200): 0.5 m, seen at 60 Hz for 400 frames.
pub const PAPER_BALL: &str = include_str!("../../../assets/ball_easy.toml");
pub const PAPER_RADIUS_M: f64 = 0.5;
/// Heights that its centre falls from, m.
pub const PAPER_CENTRE_M: std::ops::Range<f64> = 4.0..5.0;
/// Restitutions of the paper's Easy set, which it trains on, and of its Hard set.
pub const EASY: (f64, f64) = (0.3, 0.7);
pub const HARD: (f64, f64) = (0.0, 1.0);
/// A ball of 40 mm of which nothing but its size is known.
pub const ANY_BALL: &str = include_str!("../../../assets/ball.toml");

/// The arm that comes with the tool, and the shot that it plans.
pub const URDF: &str = include_str!("../../../assets/jaco_robotiq.urdf");
pub const SHOT: &str = include_str!("../../../assets/shot.toml");

/// Where draws start: each bench combines its constant with the seed on the command line, and nothing else in this project,
/// neither a training nor a selection nor a test, draws from it.
pub mod seeds {
    pub const TUNING_TARGETS: u64 = 0x7a26_e75b_0d1c_93f4;
    pub const GENERAL_TARGETS: u64 = 0x3be1_90d7_4c52_a86f;
    pub const TABLE1_NOISE: u64 = 0x51f6_a3c9_0e77_2b1d;
    pub const TABLE3_DROPS: u64 = 0x3c95_1f0d_b2e8_6a47;
    pub const INTERVALS: u64 = 0x1A7E_54A1;
    pub const REGIONS: u64 = 0x7_0113_4715;
    pub const ROLLOUTS: u64 = 0x4_90c7_28b3;
}
