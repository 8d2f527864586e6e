//! The command line.

pub mod device;
pub mod fit;
pub mod jobs;
pub mod models;
pub mod plan;
pub mod reading;
pub mod shard;
pub mod track;

use std::ffi::OsString;
use std::path::PathBuf;

use clap::{Args, Parser, Subcommand, ValueEnum};
use serde::{Deserialize, Serialize};

pub use device::DeviceChoice;
pub use fit::{Apart, Diagnose, Tune};
pub use jobs::{check_threads, jobs, pool};
pub use models::Models;
pub use plan::{Plan, PlanRule};
pub use reading::{Numbers, Reading};
pub use shard::{Merge, Sharing};
pub use track::Track;

use crate::view::text::{Verbosity, set_verbosity};

/// Estimate simulator parameters from recorded motion.
///
/// tunenet fits a simulation file to recordings and reports each parameter with a 95 % confidence interval.
#[derive(Debug, Parser)]
#[command(name = "tunenet", version, about, max_term_width = 100, propagate_version = true)]
#[command(arg_required_else_help = true, after_help = FIRST_STEPS)]
pub struct Arguments {
    /// What to do.
    #[command(subcommand)]
    pub command: Command,
    #[command(flatten)]
    pub detail: Detail,
}

/// How much a program prints besides its answer.
#[derive(Debug, Clone, Copy, Args)]
pub struct Detail {
    /// Print only the answer and errors: no notes, warnings or progress
    #[arg(short, long, global = true, display_order = 900, conflicts_with = "verbose")]
    pub quiet: bool,
    /// Print details too, such as the iterations of `tune` and all candidates of `diagnose`
    #[arg(short, long, global = true, display_order = 901)]
    pub verbose: bool,
}

impl Detail {
    /// Makes this process print so much.
    pub fn apply(self) {
        set_verbosity(match (self.quiet, self.verbose) {
            (true, _) => Verbosity::Quiet,
            (_, true) => Verbosity::Verbose,
            _ => Verbosity::Normal,
        });
    }

    /// The same as flags, for a program that is started.
    pub fn flags(self) -> impl Iterator<Item = &'static str> {
        [(self.quiet, "--quiet"), (self.verbose, "--verbose")].into_iter().filter(|(is, _)| *is).map(|(_, flag)| flag)
    }
}

/// The commands.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Write a commented simulation file to start from
    #[command(after_help = INIT_EXAMPLES)]
    Init(Init),
    /// Estimate a simulation's parameters from recordings
    #[command(after_help = fit::TUNE_EXAMPLES)]
    Tune(Tune),
    /// Identify a missing physical effect and add it to the simulation file
    #[command(after_help = fit::DIAGNOSE_EXAMPLES)]
    Diagnose(Diagnose),
    /// Plan a bounce shot with a tuned ball
    #[command(after_help = plan::EXAMPLES)]
    Plan(plan::Plan),
    /// Track a ball in a video
    #[command(after_help = track::EXAMPLES)]
    Track(track::Track),
    /// Run a simulation and write its trajectory
    #[command(after_help = SIMULATE_EXAMPLES)]
    Simulate(Simulate),
    /// Describe a file and check whether it is usable
    #[command(after_help = INSPECT_EXAMPLES)]
    Inspect(Inspect),
    /// Generate training data: pairs of rollouts
    #[command(after_help = GEN_EXAMPLES)]
    Gen(Gen),
    /// Train a network on a dataset
    #[command(after_help = TRAIN_EXAMPLES)]
    Train(Train),
    /// Combine shards written with --shard
    #[command(after_help = shard::MERGE_EXAMPLES)]
    Merge(Merge),
    /// Run the benchmarks
    #[command(disable_help_flag = true, disable_version_flag = true)]
    Bench {
        /// Benchmark and its options: see `tunenet bench --help`
        #[arg(value_name = "ARGUMENT", trailing_var_arg = true, allow_hyphen_values = true)]
        arguments: Vec<OsString>,
    },
    /// Print completions for a shell
    #[command(
        after_help = "Examples:\n  tunenet completions bash > ~/.local/share/bash-completion/completions/tunenet"
    )]
    Completions {
        /// Shell to print completions for
        shell: clap_complete::Shell,
    },
    /// Print a manual page
    #[command(after_help = "Examples:\n  tunenet man | man -l -\n  tunenet man tune > tunenet-tune.1")]
    Man {
        /// Command [default: the main page]
        command: Option<String>,
    },
}

const FIRST_STEPS: &str = "\
First steps:
  tunenet inspect drop.csv                 check whether the recording is usable
  tunenet init ball                        write ball.toml, then set the ball's radius in it
  tunenet tune --sim ball.toml drop.csv    estimate the restitution

The answer goes to standard output; notes, warnings and progress go to standard error.
Colours are for terminals; NO_COLOR=1 turns them off, CLICOLOR_FORCE=1 turns them on.
All commands except completions and man take --json: one JSON object on standard output.
Exit status: 0 done, 1 error, 2 wrong usage, 3 completed without a usable result.";
const INIT_EXAMPLES: &str = "\
Examples:
  tunenet init ball
  tunenet init ball --out tennis.toml
  tunenet init arm
  tunenet init equations
  tunenet init process
  tunenet init robot --model so101.xml
  tunenet init robot --model so101.xml --from so101_data --joints Pitch=shoulder_lift
  tunenet init robot --model arm.urdf --from rosbag2_folder
If release and surface height are not set, they are estimated from each recording.";

const SIMULATE_EXAMPLES: &str = "\
Examples:
  tunenet simulate --sim tuned.toml --set release.height_m=1.5 -o drop.csv
  tunenet simulate --sim tuned.toml --set release.height_m=1.5 --out drop.mcap
  tunenet simulate --sim process.toml --allow-process --set parameters.length.value=0.62 --out swing.csv
  tunenet simulate --sim process.toml --allow-process --inputs torque.csv --out swing.csv
  tunenet simulate --sim robot.toml --inputs so101/episode_3 --units deg --out replayed.csv";
const INSPECT_EXAMPLES: &str = "\
Examples:
  tunenet inspect drop.csv
  tunenet inspect throws/*.csv
  tunenet inspect log.mcap --json
  tunenet inspect swing.csv --sim process.toml
  tunenet inspect --sim process.toml --manifest runs.toml";
const GEN_EXAMPLES: &str = "\
Examples:
  tunenet gen ball --preset easy --pairs 800 --seed 0 --out train.mcap
  tunenet gen ball --preset wide --pairs 1000 --seed 1 --out wide.mcap
  tunenet gen arm --sim assets/arm.toml --pairs 1000 --out payloads.mcap
  tunenet gen process --sim process.toml --allow-process --pairs 500 --out swings.mcap
  tunenet gen process --sim process.toml --allow-process --inputs torque.csv --pairs 500 --out driven.mcap
  # In a Slurm array; `tunenet merge` combines the shards:
  tunenet gen ball --preset easy --pairs 1000000 --out all.mcap --shard auto
The same command resumes an interrupted run.";
const TRAIN_EXAMPLES: &str = "\
Examples:
  tunenet train --data train.mcap --preset paper --out paper.safetensors
  tunenet train --data wide.mcap --preset default --out default.safetensors
The same command resumes an interrupted run.";
/// The simulation, wherever a command takes one.
#[derive(Debug, Args)]
pub struct Simulation {
    /// Simulation file (TOML)
    #[arg(long = "sim", value_name = "FILE.toml")]
    pub sim: PathBuf,
    /// Override a key of the simulation file (may be repeated)
    #[arg(long = "set", value_name = "TABLE.KEY=VALUE")]
    pub set: Vec<String>,
}

/// Permission to execute the simulator program, wherever a command simulates with one.
#[derive(Debug, Clone, Copy, Args)]
pub struct Permission {
    /// Allow the simulation file (`kind = "process"`) to run its program; use only with files that you trust
    #[arg(long)]
    pub allow_process: bool,
}

impl Simulation {
    /// The model of an arm or a robot that `--set` names instead of the file's own, seen from the file's folder.
    pub fn urdf_set(&self) -> Option<PathBuf> {
        let named = |set: &String| {
            let (key, value) = set.split_once('=')?;
            matches!(key.trim(), "arm.urdf" | "robot.model").then(|| value.trim().trim_matches(['"', '\'']).to_owned())
        };
        Some(self.sim.parent()?.join(self.set.iter().rev().find_map(named)?))
    }
}

/// What every command takes.
#[derive(Debug, Clone, PartialEq, Args, Serialize, Deserialize)]
pub struct Common {
    /// Print the result as one JSON object instead of text
    #[serde(skip)]
    #[arg(long)]
    pub json: bool,
    /// Random seed; equal seeds give equal results
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub seed: u64,
}

/// What every command takes that writes a file.
#[derive(Debug, Args)]
pub struct Writing {
    /// Overwrite existing files of any origin; without it only files of the same kind that tunenet wrote are replaced. Input
    /// files are never overwritten
    #[arg(long)]
    pub overwrite: bool,
}

/// What `init` describes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Scene {
    /// A ball that falls and bounces
    Ball,
    /// An arm that moves a payload
    Arm,
    /// An external simulator in any language (also writes an example program)
    Process,
    /// Differential equations that stand in the simulation file
    Equations,
    /// Robot joints that follow commands
    Robot,
}

/// `tunenet init`.
#[derive(Debug, Args)]
pub struct Init {
    /// Kind of simulation
    pub scene: Scene,
    /// Simulation file to write [default: ball.toml, arm.toml, process.toml, equations.toml or robot.toml]
    #[arg(short, long, value_name = "FILE.toml")]
    pub out: Option<PathBuf>,
    /// Of a robot: its model, a URDF or an MJCF; the file then has its joints, and starts at what an MJCF states of its motors
    #[arg(long, visible_alias = "model", value_name = "FILE")]
    pub urdf: Option<PathBuf>,
    /// Of a robot: a recording (LeRobot, ROS 2 bag, MCAP, HDF5, CSV, Parquet, NumPy); the file then has the joints that are in it
    #[arg(long, value_name = "FILE|FOLDER", requires = "urdf")]
    pub from: Option<PathBuf>,
    /// Calibration file of LeRobot, which states the units of the joints of `--from`
    #[arg(long, value_name = "FILE.json", requires = "from")]
    pub calibration: Option<PathBuf>,
    /// Joints of the model whose columns of `--from` have other names; COMMAND is the column of their commands, or in a log `/TOPIC` or
    /// `/TOPIC:COLUMN`
    #[arg(long, value_name = "JOINT=COLUMN[:COMMAND],…", value_parser = pair, value_delimiter = ',', requires = "from")]
    pub joints: Vec<(String, String)>,
    /// Topic with the positions of the joints [default: the one that has most of them]
    #[arg(long, requires = "from")]
    pub topic: Option<String>,
    /// Definition of a ROS message that the log names and does not define (may be repeated)
    #[arg(long = "msg", value_name = "TYPE.msg", requires = "from")]
    pub definitions: Vec<PathBuf>,
    #[command(flatten)]
    pub writing: Writing,
    #[command(flatten)]
    pub common: Common,
}

/// `tunenet simulate`.
#[derive(Debug, Args)]
pub struct Simulate {
    #[command(flatten)]
    pub simulation: Simulation,
    #[command(flatten)]
    pub permission: Permission,
    /// Recording to write: .csv, or .mcap of a ball or an arm
    #[arg(short, long, value_name = "FILE")]
    pub out: PathBuf,
    /// File with the recorded inputs of an external simulator, and the first samples of its states
    #[arg(long, value_name = "FILE", conflicts_with = "manifest")]
    pub inputs: Option<PathBuf>,
    /// TOML list of recordings: each is simulated in its own setup, as it was driven, into the folder `--out`
    #[arg(long, value_name = "FILE.toml")]
    pub manifest: Option<PathBuf>,
    #[command(flatten)]
    pub reading: Numbers,
    /// Write bounce times instead of positions
    #[arg(long)]
    pub bounces: bool,
    /// Write the true trajectory, without the measurement effects of the file
    #[arg(long)]
    pub truth: bool,
    #[command(flatten)]
    pub writing: Writing,
    #[command(flatten)]
    pub common: Common,
}

/// `tunenet inspect`.
#[derive(Debug, Args)]
pub struct Inspect {
    /// Files to describe: recordings, simulation files, datasets or models; for several recordings, gravity is also estimated jointly
    #[arg(value_name = "FILE", required_unless_present = "manifest")]
    pub files: Vec<PathBuf>,
    /// TOML list of recordings to describe, each with its keys of the scene, settings and initial states (requires --sim)
    #[arg(long, value_name = "FILE.toml", conflicts_with = "files", requires = "sim")]
    pub manifest: Option<PathBuf>,
    /// Simulation file: of an external simulator for its channels and inputs (its program is not run), of a ball for its gravity
    #[arg(long, value_name = "FILE.toml")]
    pub sim: Option<PathBuf>,
    #[command(flatten)]
    pub reading: Reading,
    #[command(flatten)]
    pub common: Common,
}

/// What `gen` generates.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Domain {
    /// A ball dropped from 4 to 5 m, as in the paper
    Ball,
    /// The same, with targets in pixels of an unknown camera
    BallVideo,
    /// An arm that draws a circle with a payload, as in the paper
    Arm,
    /// What an external simulator simulates
    Process,
    /// What equations simulate
    Equations,
    /// What robot joints do
    Robot,
}

/// Which parameters the pairs are drawn from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Pairs {
    /// Restitution 0.3 to 0.7 for both rollouts (paper: training and Easy sets)
    Easy,
    /// Proposed 0.3 to 0.7, target 0 to 1 (paper: Hard set); arm: targets 1 kg heavier (paper: test set)
    Hard,
    /// 0 to 1 for both rollouts, for preset `default`; arm: 0 to 2 kg; external simulator: the bounds of its parameters
    Wide,
    /// Noisy recordings of drops from 0.3 m to 10 m with unknown release and floor, for preset `general`
    General,
    /// Arm: payload 0 to 1 kg for both rollouts (paper: training set)
    Paper,
}

/// `tunenet gen`.
#[derive(Debug, Args)]
pub struct Gen {
    /// Scene to sample
    pub domain: Domain,
    /// Distribution of the pairs [default: easy; arm: paper; external simulator: wide]
    #[arg(long, value_enum)]
    pub preset: Option<Pairs>,
    /// Number of pairs
    #[arg(long, value_name = "N", default_value_t = 800, value_parser = clap::value_parser!(u64).range(1..))]
    pub pairs: u64,
    /// Simulation file [default: the paper's ball]
    #[arg(long = "sim", value_name = "FILE.toml", required_if_eq_any([("domain", "arm"), ("domain", "process"), ("domain", "equations"), ("domain", "robot")]))]
    pub sim: Option<PathBuf>,
    /// Override a key of the simulation file (may be repeated)
    #[arg(long = "set", value_name = "TABLE.KEY=VALUE")]
    pub set: Vec<String>,
    /// File with the recorded inputs of an external simulator
    #[arg(long, value_name = "FILE", conflicts_with = "manifest")]
    pub inputs: Option<PathBuf>,
    /// TOML list of recordings; each pair is driven as one of them
    #[arg(long, value_name = "FILE.toml")]
    pub manifest: Option<PathBuf>,
    #[command(flatten)]
    pub reading: Numbers,
    #[command(flatten)]
    pub permission: Permission,
    /// Dataset to write (MCAP)
    #[arg(short, long, value_name = "FILE.mcap")]
    pub out: PathBuf,
    #[command(flatten)]
    pub sharing: Sharing,
    #[command(flatten)]
    pub writing: Writing,
    #[command(flatten)]
    pub common: Common,
}

/// Which hyper-parameters.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Training {
    /// As published in the paper
    Paper,
    /// Recommended
    Default,
    /// Recommended for noisy recordings of any dropped ball
    General,
}

impl Training {
    /// Its name in the library.
    pub fn name(self) -> &'static str {
        match self {
            Self::Paper => "paper",
            Self::Default => "default",
            Self::General => "general",
        }
    }
}

/// `tunenet train`.
#[derive(Debug, Args)]
pub struct Train {
    /// Dataset written by `tunenet gen`
    #[arg(long, value_name = "FILE.mcap")]
    pub data: PathBuf,
    /// Training hyper-parameters
    #[arg(long, value_enum, default_value = "default")]
    pub preset: Training,
    /// Network to write
    #[arg(short, long, value_name = "MODEL.safetensors")]
    pub out: PathBuf,
    /// Memory limit in MiB for training data; the rest is kept in a temporary file next to `--out`, with the same result
    #[arg(long, value_name = "MIB", default_value_t = 256, value_parser = clap::value_parser!(u32).range(0..=1 << 20))]
    pub memory_mib: u32,
    /// Compute device
    #[arg(long, value_enum, default_value = "cpu")]
    pub device: DeviceChoice,
    #[command(flatten)]
    pub writing: Writing,
    #[command(flatten)]
    pub common: Common,
}

fn pair(text: &str) -> Result<(String, String), String> {
    let (ours, theirs) = text.split_once('=').ok_or_else(|| format!("expected OURS=THEIRS, found `{text}`"))?;
    if ours.is_empty() || theirs.is_empty() {
        return Err(format!("expected OURS=THEIRS, found `{text}`"));
    }
    Ok((ours.into(), theirs.into()))
}

#[cfg(test)]
mod tests {
    use clap::CommandFactory;

    use super::*;

    /// The words of an example as a shell would split them, without comment, pipe and redirection.
    fn words(example: &str) -> Vec<String> {
        let line = example.split("   ").next().unwrap_or_default();
        let command = line.split(['|', '>']).next().unwrap_or_default();
        // Only Slurm knows which shard `auto` is.
        let command = command.replace("--shard auto", "--shard 0/2");
        command.split_whitespace().map(|word| word.trim_matches('\'').to_owned()).collect()
    }

    #[test]
    fn every_example_in_the_help_is_accepted() {
        let tool = Arguments::command();
        let texts = tool.get_subcommands().chain([&tool]).filter_map(|command| command.get_after_help());
        let texts: Vec<String> = texts.map(ToString::to_string).collect();
        let examples: Vec<&str> = texts.iter().flat_map(|text| text.lines()).map(str::trim).collect();
        let examples: Vec<&str> = examples.into_iter().filter(|line| line.starts_with("tunenet ")).collect();
        assert!(examples.len() > 40, "{}", examples.len());
        for example in examples {
            let parsed = Arguments::try_parse_from(words(example));
            assert!(parsed.is_ok(), "{example}: {}", parsed.unwrap_err());
        }
    }
}
