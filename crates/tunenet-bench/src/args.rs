//! `tunenet bench`.

use std::path::PathBuf;

use clap::{Args, Parser, Subcommand, ValueEnum};
use serde::{Deserialize, Serialize};

use tunenet_cli::{Common, Sharing, jobs};

pub const EXAMPLES: &str = "\
Examples:
  tunenet bench speed
  tunenet bench speed --json
  tunenet bench tuning --quick --only easy-0 easy-2cm
  tunenet bench diagnose --quick --only clean ratio-10
  tunenet bench diagnose --shard 0/8        one of eight shares, which `tunenet merge` puts together
All but `speed` and `grow` go on where they stopped when the same command is given again.";

/// Measure what is claimed
#[derive(Debug, Parser)]
#[command(name = "tunenet-bench", bin_name = "tunenet bench", version, about, max_term_width = 100)]
#[command(propagate_version = true, arg_required_else_help = true, after_help = EXAMPLES)]
pub struct Arguments {
    /// Which
    #[command(subcommand)]
    pub command: Command,
}

/// What this program is asked for.
#[derive(Debug, Subcommand)]
pub enum Command {
    #[command(flatten)]
    Measure(Measured),
    /// Print the whole answer from the pieces that shards have brought together
    #[command(hide = true)]
    Merged {
        /// The bench as its shards have noted it
        bench: String,
        /// Where the pieces lie
        #[arg(long)]
        out: PathBuf,
        #[arg(long)]
        json: bool,
    },
    /// Print the manual page
    #[command(hide = true)]
    Man,
}

/// What is measured.
///
/// As a value it says everything that decides what comes out, and nothing else: where it goes and on how many threads is left
/// out.
#[derive(Debug, Clone, PartialEq, Subcommand, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Measured {
    /// Rollouts, training and tuning per second
    Speed(BenchSpeed),
    /// Error against rollouts, compared with rivals, a maximum-likelihood fit and the Cramér–Rao bound
    Tuning(BenchTuning),
    /// Whether the effect that is named is the one that was hidden, and what is said where none was
    Diagnose(BenchDiagnose),
    /// How often the stated intervals hold the truth, and how often a good drop is called a poor fit
    Intervals(BenchIntervals),
    /// How often intervals and joint regions of several parameters hold the truth
    Regions(BenchRegions),
    /// How many faulty records are found, and how many good ones are rejected
    Preflight(BenchPreflight),
    /// The tables and figures of the paper, next to our results
    Paper(BenchPaper),
    /// How often a ball recorded on one video goes through a hoop
    Shot(BenchShot),
    /// What more pairs cost in seconds, memory and bytes, and what a cluster would need
    Grow(BenchGrow),
}

/// How many are drawn of each kind by default: enough for shares of a percent, or to see that it works.
fn drawn(asked: Option<u32>, quick: bool) -> u32 {
    asked.unwrap_or(if quick { 100 } else { 1000 })
}

impl BenchPreflight {
    /// Records of each kind.
    pub fn count(&self) -> u32 {
        drawn(self.records, self.quick)
    }
}

impl BenchIntervals {
    /// Drops in each cell.
    pub fn count(&self) -> u32 {
        drawn(self.drops, self.quick)
    }
}

impl BenchRegions {
    /// Recordings in each cell.
    pub fn count(&self) -> u32 {
        drawn(self.draws, self.quick)
    }
}

/// A table or figure of the paper.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum PaperTable {
    /// How far a tuned payload is from the real one
    Table1,
    /// The error of a tuned restitution after 1, 5, 10 and 100 rollouts
    Table2,
    /// How far a tuned ball is from the real one, from positions and from videos
    Table3,
    /// The error of a tuned restitution against the rollouts spent, drawn
    Figure2,
    /// How often a ball recorded on video goes through a hoop, ball by ball; takes as long as the rest together
    Figure3,
}

impl PaperTable {
    pub const ALL: [Self; 5] = [Self::Table1, Self::Table2, Self::Table3, Self::Figure2, Self::Figure3];
}

/// `tunenet bench paper`.
#[derive(Debug, Clone, PartialEq, Args, Serialize, Deserialize)]
pub struct BenchPaper {
    /// Where finished cells and results are kept
    #[serde(skip)]
    #[arg(long, value_name = "FOLDER", default_value = "target/bench-paper")]
    pub out: PathBuf,
    /// Only these
    #[arg(long, value_enum, value_name = "TABLE", num_args = 1..)]
    pub only: Vec<PaperTable>,
    /// One seed, few drops, short trainings
    #[arg(long)]
    pub quick: bool,
    #[serde(skip)]
    #[command(flatten)]
    pub sharing: Sharing,
    #[command(flatten)]
    pub common: Common,
}

/// `tunenet bench shot`.
#[derive(Debug, Clone, PartialEq, Args, Serialize, Deserialize)]
pub struct BenchShot {
    /// Where finished pieces and results are kept
    #[serde(skip)]
    #[arg(long, value_name = "FOLDER", default_value = "target/bench-shot")]
    pub out: PathBuf,
    /// Trials of each ball [default: 200, with `--quick` 10]
    #[arg(long, value_parser = clap::value_parser!(u64).range(1..=100_000))]
    pub trials: Option<u64>,
    /// Few trials, and none in richer worlds
    #[arg(long)]
    pub quick: bool,
    #[serde(skip)]
    #[command(flatten)]
    pub sharing: Sharing,
    #[command(flatten)]
    pub common: Common,
}

/// `tunenet bench grow`.
#[derive(Debug, Clone, PartialEq, Args, Serialize, Deserialize)]
pub struct BenchGrow {
    /// Sizes that are measured
    #[arg(long, value_name = "N", num_args = 1.., default_values_t = [1_000, 10_000, 100_000], value_parser = clap::value_parser!(u64).range(1..=1_000_000_000))]
    pub pairs: Vec<u64>,
    /// Threads of every process
    #[arg(long, default_value_t = 2, value_parser = jobs)]
    pub threads: usize,
    /// Say what a cluster would need for so many pairs
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..))]
    pub want: Option<u64>,
    /// Of so many nodes
    #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    pub nodes: u32,
    /// Of so many cores each
    #[arg(long, default_value_t = 32, value_parser = clap::value_parser!(u32).range(1..=4096))]
    pub cores: u32,
    /// Where data sets lie while they are measured, and results are kept
    #[serde(skip)]
    #[arg(long, value_name = "FOLDER", default_value = "target/bench-grow")]
    pub out: PathBuf,
    #[serde(skip)]
    #[command(flatten)]
    pub sharing: Sharing,
    #[command(flatten)]
    pub common: Common,
}

/// `tunenet bench regions`.
#[derive(Debug, Clone, PartialEq, Args, Serialize, Deserialize)]
pub struct BenchRegions {
    /// Recordings in each cell [default: 1000; 100 with --quick]
    #[arg(long, value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    pub draws: Option<u32>,
    /// Where finished cells and results are kept
    #[serde(skip)]
    #[arg(long, value_name = "FOLDER", default_value = "target/bench-regions")]
    pub out: PathBuf,
    /// Few draws, to see that it works
    #[arg(long)]
    pub quick: bool,
    #[serde(skip)]
    #[command(flatten)]
    pub sharing: Sharing,
    #[command(flatten)]
    pub common: Common,
}

/// `tunenet bench preflight`.
#[derive(Debug, Clone, PartialEq, Args, Serialize, Deserialize)]
pub struct BenchPreflight {
    /// Records of each kind [default: 1000; 100 with --quick]
    #[arg(long, value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    pub records: Option<u32>,
    /// Where finished pieces are kept
    #[serde(skip)]
    #[arg(long, value_name = "FOLDER", default_value = "target/bench-preflight")]
    pub out: PathBuf,
    /// Few records, to see that it works
    #[arg(long)]
    pub quick: bool,
    #[serde(skip)]
    #[command(flatten)]
    pub sharing: Sharing,
    #[command(flatten)]
    pub common: Common,
}

/// A row of `bench diagnose`: what is hidden in its recordings.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum, Serialize, Deserialize)]
pub enum DiagnoseRow {
    /// Nothing
    Clean,
    /// Nothing; the noise is autocorrelated
    #[value(name = "coloured")]
    Autocorrelated,
    /// Nothing; 1 % of the samples are far off
    Outliers,
    /// Nothing; 15 % of the frames are missing
    Dropped,
    /// One effect, as large as the noise
    #[value(name = "ratio-1")]
    Ratio1,
    /// One effect, 3 times the noise
    #[value(name = "ratio-3")]
    Ratio3,
    /// One effect, 10 times the noise
    #[value(name = "ratio-10")]
    Ratio10,
    /// One effect, 30 times the noise
    #[value(name = "ratio-30")]
    Ratio30,
    /// Two effects
    Two,
    /// An effect that is in no catalogue
    Outside,
    /// One effect in one drop, then the experiment that was asked for
    Experiment,
    /// One effect in three drops; what the answer costs
    Cost,
}

/// `tunenet bench diagnose`.
#[derive(Debug, Clone, PartialEq, Args, Serialize, Deserialize)]
pub struct BenchDiagnose {
    /// Where finished pieces and results are kept
    #[serde(skip)]
    #[arg(long, value_name = "FOLDER", default_value = "target/bench-diagnose")]
    pub out: PathBuf,
    /// Only these rows
    #[arg(long, value_enum, value_name = "ROW", num_args = 1..)]
    pub only: Vec<DiagnoseRow>,
    /// Logs of an arm instead of drops of a ball
    #[arg(long, conflicts_with = "only")]
    pub arm: bool,
    /// Few sets of each kind
    #[arg(long)]
    pub quick: bool,
    /// Threads [default: one for each core]
    #[serde(skip)]
    #[arg(long, value_parser = jobs)]
    pub jobs: Option<usize>,
    #[serde(skip)]
    #[command(flatten)]
    pub sharing: Sharing,
    #[command(flatten)]
    pub common: Common,
}

/// `tunenet bench intervals`.
#[derive(Debug, Clone, PartialEq, Args, Serialize, Deserialize)]
pub struct BenchIntervals {
    /// Drops in each cell [default: 1000; 100 with --quick]
    #[arg(long, value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    pub drops: Option<u32>,
    /// Where finished pieces are kept
    #[serde(skip)]
    #[arg(long, value_name = "FOLDER", default_value = "target/bench-intervals")]
    pub out: PathBuf,
    /// Few drops, to see that it works
    #[arg(long)]
    pub quick: bool,
    #[serde(skip)]
    #[command(flatten)]
    pub sharing: Sharing,
    #[command(flatten)]
    pub common: Common,
}

/// `tunenet bench speed`.
#[derive(Debug, Clone, PartialEq, Args, Serialize, Deserialize)]
pub struct BenchSpeed {
    #[serde(skip)]
    #[command(flatten)]
    pub sharing: Sharing,
    #[command(flatten)]
    pub common: Common,
}

/// A row of `bench tuning`: restitutions 0.3 to 0.7 (easy) or 0 to 1 (hard), and the noise on the height.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum, Serialize, Deserialize)]
pub enum TuningRow {
    #[value(name = "easy-0")]
    Easy0,
    #[value(name = "hard-0")]
    Hard0,
    #[value(name = "easy-5mm")]
    Easy5mm,
    #[value(name = "easy-2cm")]
    Easy2cm,
    #[value(name = "hard-5mm")]
    Hard5mm,
    #[value(name = "hard-2cm")]
    Hard2cm,
    /// Drops from 0.3 to 10 m at 24 to 240 Hz, nothing known but the data: the built-in network
    General,
    /// Drops from other engines, in the folder that the environment variable `TUNENET_PEERS` names
    Cross,
}

/// `tunenet bench tuning`.
#[derive(Debug, Clone, PartialEq, Args, Serialize, Deserialize)]
pub struct BenchTuning {
    /// Where finished cells, models and results are kept
    #[serde(skip)]
    #[arg(long, value_name = "FOLDER", default_value = "target/bench-tuning")]
    pub out: PathBuf,
    /// Only these rows
    #[arg(long, value_enum, value_name = "ROW", num_args = 1..)]
    pub only: Vec<TuningRow>,
    /// Targets in each row [default: 1000; 200 with --quick]
    #[arg(long, value_parser = clap::value_parser!(u64).range(1..=1_000_000))]
    pub targets: Option<u64>,
    /// One short training of each preset instead of three whole ones
    #[arg(long)]
    pub quick: bool,
    #[serde(skip)]
    #[command(flatten)]
    pub sharing: Sharing,
    #[command(flatten)]
    pub common: Common,
}
