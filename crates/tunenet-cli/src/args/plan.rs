//! `tunenet plan`.

use std::path::PathBuf;

use clap::{Args, ValueEnum};

use super::{Common, Simulation, Writing};

pub const EXAMPLES: &str = "\
Examples:
  tunenet plan --sim tuned.toml --task assets/shot.toml
  tunenet plan --sim tuned.toml --task shot.toml --heights 200 --report shot.html
  tunenet plan --sim tuned.toml --task shot.toml --rule nearest --out approach.mcap
The ball has to be the one that was tuned; where plane, hoop and robot stand is the task file's.";

/// How the best height is chosen.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum PlanRule {
    /// The one from which the shot most probably goes in
    Probability,
    /// The one whose path passes closest to the hoop's centre, as in the paper
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
    /// Heights to choose from
    #[arg(long, default_value_t = 100, value_parser = clap::value_parser!(u32).range(2..=100_000))]
    pub heights: u32,
    /// How to choose
    #[arg(long, value_enum, default_value = "probability")]
    pub rule: PlanRule,
    /// Balls drawn from what is uncertain
    #[arg(long, default_value_t = 256, value_parser = clap::value_parser!(u32).range(1..=100_000))]
    pub draws: u32,
    /// Write the robot's approach to the release here (MCAP)
    #[arg(long, value_name = "FILE.mcap")]
    pub out: Option<PathBuf>,
    /// Write the shot as a web page here
    #[arg(long, value_name = "FILE.html")]
    pub report: Option<PathBuf>,
    #[command(flatten)]
    pub writing: Writing,
    #[command(flatten)]
    pub common: Common,
}
