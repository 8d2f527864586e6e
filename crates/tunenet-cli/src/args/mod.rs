//! The command line.

pub mod device;
pub mod fit;
pub mod jobs;
pub mod plan;
pub mod shard;
pub mod track;

use std::ffi::OsString;
use std::path::PathBuf;

use clap::{Args, Parser, Subcommand, ValueEnum};
use serde::{Deserialize, Serialize};

pub use device::DeviceChoice;
pub use fit::{Apart, Diagnose, Tune};
pub use jobs::{jobs, pool};
pub use plan::{Plan, PlanRule};
pub use shard::{Merge, Sharing};
pub use track::Track;

/// Makes a simulator behave like a measured real thing.
///
/// Give it a simulation file and a recording of the real thing; it finds the parameters with which the simulation does
/// what was recorded, and says how sure it is of each.
#[derive(Debug, Parser)]
#[command(name = "tunenet", version, about, max_term_width = 100, propagate_version = true)]
#[command(arg_required_else_help = true, after_help = FIRST_STEPS)]
pub struct Arguments {
    /// What to do.
    #[command(subcommand)]
    pub command: Command,
}

/// The commands.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Write a commented simulation file to start from
    #[command(after_help = INIT_EXAMPLES)]
    Init(Init),
    /// Tune a simulation's parameters to observations
    #[command(after_help = fit::TUNE_EXAMPLES)]
    Tune(Tune),
    /// Name the effect that a simulation lacks, and write it into the simulation file
    #[command(after_help = fit::DIAGNOSE_EXAMPLES)]
    Diagnose(Diagnose),
    /// Find from where to let a ball go so that it bounces through a hoop
    #[command(after_help = plan::EXAMPLES)]
    Plan(plan::Plan),
    /// Follow the ball in a film
    #[command(after_help = track::EXAMPLES)]
    Track(track::Track),
    /// Roll a simulation out into an observation file
    #[command(after_help = SIMULATE_EXAMPLES)]
    Simulate(Simulate),
    /// Say what is in a file, whether it can be used, and for what
    #[command(after_help = INSPECT_EXAMPLES)]
    Inspect(Inspect),
    /// Generate a dataset of rollout pairs
    #[command(after_help = GEN_EXAMPLES)]
    Gen(Gen),
    /// Train the two-branch network on a dataset
    #[command(after_help = TRAIN_EXAMPLES)]
    Train(Train),
    /// Put together what --shard cut
    #[command(after_help = shard::MERGE_EXAMPLES)]
    Merge(Merge),
    /// Measure what is claimed
    #[command(disable_help_flag = true, disable_version_flag = true)]
    Bench {
        /// Which, and how: see `tunenet bench --help`
        #[arg(value_name = "ARGUMENT", trailing_var_arg = true, allow_hyphen_values = true)]
        arguments: Vec<OsString>,
    },
    /// Print completions for a shell
    #[command(
        after_help = "Examples:\n  tunenet completions bash > ~/.local/share/bash-completion/completions/tunenet"
    )]
    Completions {
        /// Which shell
        shell: clap_complete::Shell,
    },
    /// Print a manual page
    #[command(after_help = "Examples:\n  tunenet man | man -l -\n  tunenet man tune > tunenet-tune.1")]
    Man {
        /// Of which command; of the tool as a whole where left out
        command: Option<String>,
    },
}

const FIRST_STEPS: &str = "\
First steps:
  tunenet inspect drop.csv                               can this be used?
  tunenet init ball                                      write the ball's radius into ball.toml
  tunenet tune --sim ball.toml --observation drop.csv    the answer

All but completions and man take --json: one JSON object on standard output.
Exit status: 0 done, 1 a file or the system refused, 2 wrong usage,
             3 finished, and the honest answer is no.";
const INIT_EXAMPLES: &str = "\
Examples:
  tunenet init ball
  tunenet init ball --out tennis.toml
  tunenet init arm
  tunenet init process
Without a word about the release or the surface's height, both are estimated from each recording.";

const SIMULATE_EXAMPLES: &str = "\
Examples:
  tunenet simulate --sim tuned.toml --set release.height_m=1.5 --out drop.csv
  tunenet simulate --sim tuned.toml --set release.height_m=1.5 --out drop.mcap
  tunenet simulate --sim process.toml --allow-process --out swing.csv";
const INSPECT_EXAMPLES: &str = "\
Examples:
  tunenet inspect drop.csv
  tunenet inspect throws/*.csv
  tunenet inspect log.mcap --json
  tunenet inspect swing.csv --sim process.toml";
const GEN_EXAMPLES: &str = "\
Examples:
  tunenet gen ball --preset easy --pairs 800 --seed 0 --out train.mcap
  tunenet gen ball --preset wide --pairs 1000 --seed 1 --out wide.mcap
  tunenet gen arm --sim assets/arm.toml --pairs 1000 --out payloads.mcap
  tunenet gen ball --preset easy --pairs 1000000 --out all.mcap --shard auto    in a Slurm array; see `merge`
  tunenet gen process --sim process.toml --allow-process --pairs 500 --out swings.mcap
An interrupted run goes on where it stopped when the same command is given again.";
const TRAIN_EXAMPLES: &str = "\
Examples:
  tunenet train --data train.mcap --preset paper --out paper.safetensors
  tunenet train --data wide.mcap --preset default --out default.safetensors
An interrupted run goes on where it stopped when the same command is given again.";
/// The simulation, wherever a command takes one.
#[derive(Debug, Args)]
pub struct Simulation {
    /// Simulation file (TOML)
    #[arg(long = "sim", value_name = "FILE.toml")]
    pub sim: PathBuf,
    /// Override a key of the simulation file; may be repeated
    #[arg(long = "set", value_name = "TABLE.KEY=VALUE")]
    pub set: Vec<String>,
}

/// Leave to run a program, wherever a command simulates by one.
#[derive(Debug, Clone, Copy, Args)]
pub struct Leave {
    /// Run the program that a simulation file of `kind = "process"` names; only with files that you trust
    #[arg(long)]
    pub allow_process: bool,
}

impl Simulation {
    /// The URDF that `--set` names instead of the file's own, seen from the file's folder.
    pub fn urdf_set(&self) -> Option<PathBuf> {
        let named = |set: &String| {
            let (key, value) = set.split_once('=')?;
            (key.trim() == "arm.urdf").then(|| value.trim().trim_matches(['"', '\'']).to_owned())
        };
        Some(self.sim.parent()?.join(self.set.iter().rev().find_map(named)?))
    }
}

/// How files are read, wherever a command takes observations.
#[derive(Debug, Args)]
pub struct Reading {
    /// Which columns of a foreign CSV are ours, such as `t_s=time,z_m=height`, or numbers from 1 where there is no header
    #[arg(long, value_name = "OURS=THEIRS,…", value_parser = pair, value_delimiter = ',')]
    pub columns: Vec<(String, String)>,
    /// Which topic of an MCAP log
    #[arg(long)]
    pub topic: Option<String>,
    /// Frames per second at which a camera really took them: of a film that plays slower, or of a folder of frames
    #[arg(long, value_name = "1/S", value_parser = track::positive)]
    pub camera_rate: Option<f64>,
    /// Leave out the lines of a CSV file that cannot be used, where they are few, and say which
    #[arg(long)]
    pub skip_broken: bool,
}

/// What every command takes.
#[derive(Debug, Clone, PartialEq, Args, Serialize, Deserialize)]
pub struct Common {
    /// Print one JSON object on standard output and nothing else there
    #[serde(skip)]
    #[arg(long)]
    pub json: bool,
    /// Start of every random draw
    #[arg(long, default_value_t = 0)]
    pub seed: u64,
}

/// What every command takes that writes a file.
#[derive(Debug, Args)]
pub struct Writing {
    /// Replace a file that is there already, even one that tunenet did not write; what is read is never replaced
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
    /// A program of yours, in any language; one to start from is written beside it
    Process,
}

/// `tunenet init`.
#[derive(Debug, Args)]
pub struct Init {
    /// Of what
    pub scene: Scene,
    /// Where to write [default: ball.toml, arm.toml or process.toml]
    #[arg(long, value_name = "FILE.toml")]
    pub out: Option<PathBuf>,
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
    pub leave: Leave,
    /// Where to write: .csv or .mcap
    #[arg(long, value_name = "FILE")]
    pub out: PathBuf,
    /// Write impact times instead of positions
    #[arg(long)]
    pub bounces: bool,
    /// Write what happens, not what is measured: without the file's effects of the measurement
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
    /// What to look at: CSV, MCAP, film, simulation file, dataset or model; of several recordings, gravity together as well
    #[arg(value_name = "FILE", required = true)]
    pub files: Vec<PathBuf>,
    /// Simulation file of a program of yours, whose channels are looked for; the program is not run
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
    /// The same, its targets in the pixels of a camera that nobody knows
    BallVideo,
    /// An arm that draws a circle with a payload, as in the paper
    Arm,
    /// What a program of yours simulates
    Process,
}

/// Which parameters the pairs are drawn from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Pairs {
    /// Restitution .3 to .7, both sides: the paper's training and Easy sets
    Easy,
    /// Proposed .3 to .7, target 0 to 1: the paper's Hard set; of an arm, targets 1 kg heavier: its test set
    Hard,
    /// 0 to 1, both sides: for preset `default`; of an arm, 0 to 2 kg; of a program, its parameters' bounds
    Wide,
    /// Noisy recordings of drops from .3 to 10 m, release and floor unknown: for preset `general`
    General,
    /// Of an arm: payload 0 to 1 kg, both sides: the paper's training set
    Paper,
}

/// `tunenet gen`.
#[derive(Debug, Args)]
pub struct Gen {
    /// Of what
    pub domain: Domain,
    /// Distribution of the pairs [default: easy; paper of an arm; wide of a program]
    #[arg(long, value_enum)]
    pub preset: Option<Pairs>,
    /// How many
    #[arg(long, default_value_t = 800, value_parser = clap::value_parser!(u64).range(1..))]
    pub pairs: u64,
    /// Scene, instead of the paper's
    #[arg(long = "sim", value_name = "FILE.toml", required_if_eq_any([("domain", "arm"), ("domain", "process")]))]
    pub sim: Option<PathBuf>,
    /// Override a key of the scene; may be repeated
    #[arg(long = "set", value_name = "TABLE.KEY=VALUE")]
    pub set: Vec<String>,
    #[command(flatten)]
    pub leave: Leave,
    /// Where to write (MCAP)
    #[arg(long, value_name = "FILE.mcap")]
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
    /// The paper's appendix to the letter
    Paper,
    /// This project's own
    Default,
    /// The same for recordings of any dropped ball
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
    /// Dataset that `gen` wrote
    #[arg(long, value_name = "FILE.mcap")]
    pub data: PathBuf,
    /// Hyper-parameters
    #[arg(long, value_enum, default_value = "default")]
    pub preset: Training,
    /// Where to write the model
    #[arg(long, value_name = "MODEL.safetensors")]
    pub out: PathBuf,
    /// Most memory for what is learned from; more of it waits in a temporary file beside `--out`, the result is the same
    #[arg(long, value_name = "MIB", default_value_t = 256, value_parser = clap::value_parser!(u32).range(0..=1 << 20))]
    pub memory_mib: u32,
    /// Where the sums are done
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
