//! `tunenet bench`.

use std::path::PathBuf;

use clap::{Args, Parser, Subcommand, ValueEnum};
use serde::{Deserialize, Serialize};

use tunenet_cli::{Common, Detail, Sharing, jobs};

use crate::examples;

/// Run the benchmarks
#[derive(Debug, Parser)]
#[command(name = "tunenet-bench", bin_name = "tunenet bench", version, about, max_term_width = 100)]
#[command(propagate_version = true, arg_required_else_help = true, after_help = examples::ALL)]
pub struct Arguments {
    /// Benchmark to run
    #[command(subcommand)]
    pub command: Command,
    #[command(flatten)]
    pub detail: Detail,
}

/// What this program is asked for.
#[derive(Debug, Subcommand)]
pub enum Command {
    #[command(flatten)]
    Measure(Measured),
    /// Print the merged result of shards
    #[command(hide = true)]
    Merged {
        /// Benchmark as its shards recorded it
        bench: String,
        /// Folder with the pieces
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
    #[command(after_help = examples::SPEED)]
    Speed(BenchSpeed),
    /// Tuning error over rollouts, compared with other methods and the Cramér–Rao bound
    #[command(after_help = examples::TUNING)]
    Tuning(BenchTuning),
    /// Accuracy of `diagnose` on synthetic recordings
    #[command(after_help = examples::DIAGNOSE)]
    Diagnose(BenchDiagnose),
    /// Accuracy of `diagnose --law` on synthetic recordings with a law in them
    #[command(after_help = examples::LAW)]
    Law(BenchLaw),
    /// Accuracy of `diagnose` on synthetic runs of a robot joint
    #[command(after_help = examples::JOINTS)]
    Joints(BenchJoints),
    /// Errors of `diagnose` on recordings of real joints, compared with published models
    #[command(after_help = examples::RECORDED)]
    Recorded(BenchRecorded),
    /// Interval coverage and false-alarm rate of `tune`
    #[command(after_help = examples::INTERVALS)]
    Intervals(BenchIntervals),
    /// Coverage of intervals and joint regions of several parameters
    #[command(after_help = examples::REGIONS)]
    Regions(BenchRegions),
    /// Rollouts of `tune`, compared with scipy and mujoco.sysid
    #[command(after_help = examples::ROLLOUTS)]
    Rollouts(BenchRollouts),
    /// Detection and false-alarm rate of the recording checks
    #[command(after_help = examples::PREFLIGHT)]
    Preflight(BenchPreflight),
    /// Reproduce the tables and figures of the paper
    #[command(after_help = examples::PAPER)]
    Paper(BenchPaper),
    /// Success rate of shots planned from one video
    #[command(after_help = examples::SHOT)]
    Shot(BenchShot),
    /// Scaling of data generation and training
    #[command(after_help = examples::GROW)]
    Grow(BenchGrow),
}

/// A table or figure of the paper.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum PaperTable {
    /// Error of the tuned payload
    Table1,
    /// Error of the tuned restitution after 1, 5, 10 and 100 rollouts
    Table2,
    /// Error of the tuned ball, from positions and from videos
    Table3,
    /// Figure: error of the tuned restitution over rollouts
    Figure2,
    /// Figure: success rate of the shot for each ball (takes as long as the others together)
    Figure3,
}

impl PaperTable {
    pub const ALL: [Self; 5] = [Self::Table1, Self::Table2, Self::Table3, Self::Figure2, Self::Figure3];
}

/// `tunenet bench paper`.
#[derive(Debug, Clone, PartialEq, Args, Serialize, Deserialize)]
pub struct BenchPaper {
    /// Folder for finished cells and results
    #[serde(skip)]
    #[arg(long, value_name = "FOLDER", default_value = "target/bench-paper")]
    pub out: PathBuf,
    /// Run only these
    #[arg(long, value_enum, value_name = "TABLE", num_args = 1..)]
    pub only: Vec<PaperTable>,
    /// Quick run: one seed, few drops, short trainings
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
    /// Folder for finished pieces and results
    #[serde(skip)]
    #[arg(long, value_name = "FOLDER", default_value = "target/bench-shot")]
    pub out: PathBuf,
    /// Number of trials per ball [default: 200, with `--quick` 10]
    #[arg(long, value_parser = clap::value_parser!(u64).range(1..=100_000))]
    pub trials: Option<u64>,
    /// Quick run: few trials, none in richer worlds
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
    /// Numbers of pairs to measure
    #[arg(long, value_name = "N", num_args = 1.., default_values_t = [1_000, 10_000, 100_000], value_parser = clap::value_parser!(u64).range(1..=1_000_000_000))]
    pub pairs: Vec<u64>,
    /// Number of threads per process
    #[arg(long, default_value_t = 2, value_parser = jobs)]
    pub threads: usize,
    /// Number of pairs for which to estimate the needs of a cluster
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..))]
    pub want: Option<u64>,
    /// Number of nodes of that cluster
    #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    pub nodes: u32,
    /// Number of cores per node
    #[arg(long, default_value_t = 32, value_parser = clap::value_parser!(u32).range(1..=4096))]
    pub cores: u32,
    /// Folder for temporary datasets and results
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
    /// Number of recordings per cell [default: 1000; 100 with --quick]
    #[arg(long, value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    pub draws: Option<u32>,
    /// Folder for finished cells and results
    #[serde(skip)]
    #[arg(long, value_name = "FOLDER", default_value = "target/bench-regions")]
    pub out: PathBuf,
    /// Quick run with few draws
    #[arg(long)]
    pub quick: bool,
    #[serde(skip)]
    #[command(flatten)]
    pub sharing: Sharing,
    #[command(flatten)]
    pub common: Common,
}

/// `tunenet bench rollouts`.
#[derive(Debug, Clone, PartialEq, Args, Serialize, Deserialize)]
pub struct BenchRollouts {
    /// Folder for results
    #[serde(skip)]
    #[arg(long, value_name = "FOLDER", default_value = "target/bench-rollouts")]
    pub out: PathBuf,
    #[command(flatten)]
    pub common: Common,
}

/// `tunenet bench preflight`.
#[derive(Debug, Clone, PartialEq, Args, Serialize, Deserialize)]
pub struct BenchPreflight {
    /// Number of recordings of each kind [default: 1000; 100 with --quick]
    #[arg(long, value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    pub records: Option<u32>,
    /// Folder for finished pieces
    #[serde(skip)]
    #[arg(long, value_name = "FOLDER", default_value = "target/bench-preflight")]
    pub out: PathBuf,
    /// Quick run with few records
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
    /// No effect
    Clean,
    /// No effect; autocorrelated noise
    #[value(name = "coloured")]
    Autocorrelated,
    /// No effect; 1 % outliers
    Outliers,
    /// No effect; 15 % of the frames missing
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
    /// Three effects
    Three,
    /// An effect that is not in the catalogue
    Outside,
    /// An effect that the simulation file declares as a formula, among others that do not act
    Formulas,
    /// Drag, where the simulation file states a wrong mass
    WrongMass,
    /// One recording of another ball
    OddBall,
    /// A restitution that differs from recording to recording
    Scatter,
    /// One effect; only x and z recorded
    Plane,
    /// One effect in one drop, then the suggested experiment
    Experiment,
    /// No effect or one in 100 drops; rollouts
    Many,
    /// One effect in three drops; rollouts and time
    Cost,
}

/// `tunenet bench diagnose`.
#[derive(Debug, Clone, PartialEq, Args, Serialize, Deserialize)]
pub struct BenchDiagnose {
    /// Folder for finished pieces and results
    #[serde(skip)]
    #[arg(long, value_name = "FOLDER", default_value = "target/bench-diagnose")]
    pub out: PathBuf,
    /// Run only these rows
    #[arg(long, value_enum, value_name = "ROW", num_args = 1..)]
    pub only: Vec<DiagnoseRow>,
    /// Use logs of an arm instead of drops of a ball
    #[arg(long, conflicts_with = "only")]
    pub arm: bool,
    /// Use recordings of driven mechanisms (cart-pole, DC motor, two-link arm) with candidates of their own
    #[arg(long, conflicts_with_all = ["only", "arm"])]
    pub driven: bool,
    /// Quick run with few recordings of each kind
    #[arg(long)]
    pub quick: bool,
    /// Number of threads [default: number of cores]
    #[serde(skip)]
    #[arg(long, value_parser = jobs)]
    pub jobs: Option<usize>,
    #[serde(skip)]
    #[command(flatten)]
    pub sharing: Sharing,
    #[command(flatten)]
    pub common: Common,
}

/// `tunenet bench law`.
#[derive(Debug, Clone, PartialEq, Args, Serialize, Deserialize)]
pub struct BenchLaw {
    /// Folder for finished pieces, results, and the files of sets that were not answered right
    #[serde(skip)]
    #[arg(long, value_name = "FOLDER", default_value = "target/bench-law")]
    pub out: PathBuf,
    /// Run only these rows (`clean`, `coloured`, `outliers`, `ratio-3`, `ratio-10`, `ratio-30`, `hidden-state`, `outside`,
    /// `discover`) and laws (`drag-2`)
    #[arg(long, value_name = "ROW|LAW", num_args = 1.., hide_possible_values = true, value_parser = clap::builder::PossibleValuesParser::new(crate::law::rows::names()))]
    pub only: Vec<String>,
    /// Number of sets of each law [default: 20; 1 with --quick]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..=10_000))]
    pub sets: Option<u64>,
    /// Quick run with one set of each law
    #[arg(long)]
    pub quick: bool,
    /// Number of threads [default: number of cores]
    #[serde(skip)]
    #[arg(long, value_parser = jobs)]
    pub jobs: Option<usize>,
    #[serde(skip)]
    #[command(flatten)]
    pub sharing: Sharing,
    #[command(flatten)]
    pub common: Common,
}

/// `tunenet bench joints`.
#[derive(Debug, Clone, PartialEq, Args, Serialize, Deserialize)]
pub struct BenchJoints {
    /// Folder for finished pieces, results, and the files of sets that were not answered right
    #[serde(skip)]
    #[arg(long, value_name = "FOLDER", default_value = "target/bench-joints")]
    pub out: PathBuf,
    /// Run only these rows (`clean`, `ratio-3`, `ratio-10`, `ratio-30`) and effects (`backlash`)
    #[arg(long, value_name = "ROW|EFFECT", num_args = 1.., hide_possible_values = true, value_parser = clap::builder::PossibleValuesParser::new(crate::joints::rows::names()))]
    pub only: Vec<String>,
    /// Number of sets of each effect at each ratio [default: 20; 1 with --quick]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..=10_000))]
    pub sets: Option<u64>,
    /// Quick run with one set of each effect at each ratio
    #[arg(long)]
    pub quick: bool,
    /// Number of threads [default: number of cores]
    #[serde(skip)]
    #[arg(long, value_parser = jobs)]
    pub jobs: Option<usize>,
    #[serde(skip)]
    #[command(flatten)]
    pub sharing: Sharing,
    #[command(flatten)]
    pub common: Common,
}

/// What `bench recorded` diagnoses.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum, Serialize, Deserialize)]
pub enum RecordedRow {
    /// A servo of a small arm (STS3215) that swings loads: 20 runs, and 20 held out
    Servo,
    /// The drive of EMPS, from its voltage to its position
    Drive,
    /// A small arm (SO-101) that follows commands, each of four episodes held out in turn
    Arm,
}

/// `tunenet bench recorded`.
#[derive(Debug, Clone, PartialEq, Args, Serialize, Deserialize)]
pub struct BenchRecorded {
    /// Folder of the recordings, with `servo-sts3215`, `emps`, `lerobot-v3-so101` and `models` [default: the environment variable `TUNENET_MEASURED`]
    #[serde(skip)]
    #[arg(long, value_name = "FOLDER")]
    pub measured: Option<PathBuf>,
    /// Folder for results
    #[serde(skip)]
    #[arg(long, value_name = "FOLDER", default_value = "target/bench-recorded")]
    pub out: PathBuf,
    /// Run only these rows
    #[arg(long, value_enum, value_name = "ROW", num_args = 1..)]
    pub only: Vec<RecordedRow>,
    #[command(flatten)]
    pub common: Common,
}

/// `tunenet bench intervals`.
#[derive(Debug, Clone, PartialEq, Args, Serialize, Deserialize)]
pub struct BenchIntervals {
    /// Number of drops per cell [default: 1000; 100 with --quick]
    #[arg(long, value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    pub drops: Option<u32>,
    /// Folder for finished pieces
    #[serde(skip)]
    #[arg(long, value_name = "FOLDER", default_value = "target/bench-intervals")]
    pub out: PathBuf,
    /// Quick run with few drops
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
    /// Drops from 0.3 to 10 m at 24 to 240 Hz with unknown release: the built-in network
    General,
    /// Drops from other engines, in the folder that the environment variable `TUNENET_PEERS` names
    Cross,
}

/// `tunenet bench tuning`.
#[derive(Debug, Clone, PartialEq, Args, Serialize, Deserialize)]
pub struct BenchTuning {
    /// Folder for finished cells, models and results
    #[serde(skip)]
    #[arg(long, value_name = "FOLDER", default_value = "target/bench-tuning")]
    pub out: PathBuf,
    /// Run only these rows
    #[arg(long, value_enum, value_name = "ROW", num_args = 1..)]
    pub only: Vec<TuningRow>,
    /// Number of targets per row [default: 1000; 200 with --quick]
    #[arg(long, value_parser = clap::value_parser!(u64).range(1..=1_000_000))]
    pub targets: Option<u64>,
    /// Quick run: one short training of each preset
    #[arg(long)]
    pub quick: bool,
    #[serde(skip)]
    #[command(flatten)]
    pub sharing: Sharing,
    #[command(flatten)]
    pub common: Common,
}
