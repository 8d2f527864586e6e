//! `tunenet plan`.

use std::path::PathBuf;

use clap::{Args, ValueEnum};

use super::{Common, Simulation, Writing};

pub const EXAMPLES: &str = "\
Examples:
  tunenet plan --sim tuned.toml --task assets/shot.toml
  tunenet plan --sim tuned.toml --task assets/shot.toml --heights 200 --report shot.html
  tunenet plan --sim tuned.toml --task assets/shot.toml --rule nearest --out approach.mcap
Use the tuned simulation file of the same ball. The task file defines plane, hoop and robot;
assets/shot.toml in the source tree is an example. The robot's URDF (`arm.urdf`) is looked for
in the folder of the task file, so copy assets/shot.toml and assets/jaco_robotiq.urdf together.
A task without [arm] needs no URDF.";

/// How the best height is chosen.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum PlanRule {
    /// Maximise the success probability
    Probability,
    /// Minimise the distance to the hoop's centre, as in the paper
    Nearest,
}

/// `tunenet plan`.
#[derive(Debug, Args)]
pub struct Plan {
    #[command(flatten)]
    pub simulation: Simulation,
    /// Task file (TOML): plane, hoop, heights, robot
    #[arg(long, value_name = "TASK.toml")]
    pub task: PathBuf,
    /// Number of candidate release heights, evenly spaced over `release.heights_m` of the task
    #[arg(long, value_name = "N", default_value_t = 100, value_parser = clap::value_parser!(u32).range(2..=100_000))]
    pub heights: u32,
    /// Rule that chooses the height
    #[arg(long, value_enum, default_value = "probability")]
    pub rule: PlanRule,
    /// Number of Monte Carlo samples of the uncertain parameters
    #[arg(long, value_name = "N", default_value_t = 256, value_parser = clap::value_parser!(u32).range(1..=100_000))]
    pub draws: u32,
    /// Write the robot's approach to the release (MCAP)
    #[arg(short, long, value_name = "FILE.mcap")]
    pub out: Option<PathBuf>,
    /// Write an HTML report
    #[arg(long, value_name = "FILE.html")]
    pub report: Option<PathBuf>,
    #[command(flatten)]
    pub writing: Writing,
    #[command(flatten)]
    pub common: Common,
}
