//! The command line.

pub mod bench;
pub mod device;
pub mod plan;
pub mod shard;
pub mod track;

use std::path::PathBuf;

use clap::{Args, Parser, Subcommand, ValueEnum};
use serde::{Deserialize, Serialize};

pub use bench::{
    Bench, BenchDiagnose, BenchGrow, BenchIntervals, BenchPaper, BenchPreflight, BenchRegions, BenchShot, BenchSpeed,
    BenchTuning, DiagnoseRow, Measured, PaperTable, Row,
};
pub use device::DeviceChoice;
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
    #[command(after_help = TUNE_EXAMPLES)]
    Tune(Tune),
    /// Name the effect that a simulation lacks, and write it into the simulation file
    #[command(after_help = DIAGNOSE_EXAMPLES)]
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
    #[command(after_help = bench::EXAMPLES)]
    Bench(Bench),
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

const TUNE_EXAMPLES: &str = "\
Examples:
  tunenet tune --sim assets/ball.toml --observation assets/observations/drop.csv --out tuned.toml
  tunenet tune --sim ball.toml --observation drop.csv --report drop.html
  tunenet tune --sim ball.toml --set ball.radius_m=0.02 --observation flights/*.csv --each --json
  tunenet tune --sim ball.toml --observation 'flights/*.csv' --each --out-dir answers --jobs 4 --shard 0/8
  tunenet tune --sim ball.toml --observation log.csv --columns t_s=time,z_m=height
  tunenet tune --sim ball.toml --observation drop.mp4
  tunenet tune --sim process.toml --allow-process --observation swing.csv
  tunenet tune --sim ball_easy.toml --set release.height_m=3.9 --observation drop.mcap --model model.safetensors";
const DIAGNOSE_EXAMPLES: &str = "\
Examples:
  tunenet diagnose --sim assets/ball.toml --observation assets/observations/light_[1-5].csv --out improved.toml
  tunenet diagnose --sim ball.toml --observation d1.csv d2.csv d3.csv --held-out d4.csv --report answer.html
  tunenet diagnose --sim ball.toml --manifest balls.toml --out improved
  tunenet diagnose --sim ball.toml --observation 'logs/*.mcap' --each --out-dir answers --jobs 4
  tunenet diagnose --sim process.toml --allow-process --observation swing.csv
Several throws in varied directions tell effects apart that one throw cannot.
A manifest lists [[observation]] tables with `file`, and `object`, `held_out` and keys of the scene where they differ.";
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

/// Where recordings are treated one by one.
#[derive(Debug, Clone, Default, Args)]
pub struct Apart {
    /// With --each: write the answer to each recording into a file of its own here; what is there already is not done again
    #[arg(long, value_name = "FOLDER", requires = "each")]
    pub out_dir: Option<PathBuf>,
    #[command(flatten)]
    pub sharing: Sharing,
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

impl Apart {
    /// Shares are shares of many recordings.
    ///
    /// # Errors
    /// [`Error::Setting`](tunenet_core::Error::Setting) where `--shard` stands without `--each`.
    pub fn check(&self, each: bool) -> tunenet_core::Result<()> {
        let Some(shard) = self.sharing.shard.filter(|_| !each) else { return Ok(()) };
        let expected = "`--each` beside it, with a share of the recordings for every shard".into();
        Err(tunenet_core::Error::Setting { name: "--shard", expected, found: format!("{shard} alone") })
    }
}

/// `tunenet tune`.
#[derive(Debug, Args)]
#[expect(clippy::struct_excessive_bools, reason = "each is a flag of its own")]
pub struct Tune {
    #[command(flatten)]
    pub simulation: Simulation,
    #[command(flatten)]
    pub leave: Leave,
    /// Measured files (CSV, MCAP or film); several are tuned to together
    #[arg(long, value_name = "FILE", num_args = 1.., required = true)]
    pub observation: Vec<PathBuf>,
    #[command(flatten)]
    pub reading: Reading,
    /// Of an arm's log: the same motion without the payload; what both runs share then cancels
    #[arg(long, value_name = "FILE")]
    pub reference: Option<PathBuf>,
    /// Tune to each observation on its own
    #[arg(long)]
    pub each: bool,
    #[command(flatten)]
    pub apart: Apart,
    /// Threads [default: one for each core]
    #[arg(long, value_parser = jobs)]
    pub jobs: Option<usize>,
    /// Use recordings that their checks reject; the answer may mean nothing
    #[arg(long)]
    pub force: bool,
    /// Trained network, instead of the one that fits; its preset decides how the iterations go
    #[arg(long, value_name = "MODEL.safetensors")]
    pub model: Option<PathBuf>,
    /// Neither look for a network trained for this scene before, nor keep one
    #[arg(long)]
    pub no_cache: bool,
    /// Start value, instead of the simulation file's
    #[arg(long, value_name = "NAME=VALUE", value_parser = start, value_delimiter = ',')]
    pub initial: Vec<(String, f64)>,
    /// Iterations of the network, one rollout each
    #[arg(long, default_value_t = 5, value_parser = clap::value_parser!(u16).range(1..=1000))]
    pub iterations: u16,
    /// Keep values within their bounds at every iteration, with a model of preset `paper` too
    #[arg(long)]
    pub clamp: bool,
    /// Write the simulation file with the tuned values here
    #[arg(long, value_name = "TUNED.toml")]
    pub out: Option<PathBuf>,
    /// Write a page with drawings here: verdict, residuals, intervals, checks
    #[arg(long, value_name = "FILE.html")]
    pub report: Option<PathBuf>,
    #[command(flatten)]
    pub writing: Writing,
    #[command(flatten)]
    pub common: Common,
}

/// `tunenet diagnose`.
#[derive(Debug, Args)]
pub struct Diagnose {
    #[command(flatten)]
    pub simulation: Simulation,
    #[command(flatten)]
    pub leave: Leave,
    /// Measured files (CSV, MCAP or film) of one object
    #[arg(long, value_name = "FILE", num_args = 1.., required_unless_present = "manifest")]
    pub observation: Vec<PathBuf>,
    /// Measured files that are not fitted to, only judged by; some are set aside where there are enough and none is given
    #[arg(long, value_name = "FILE", num_args = 1.., conflicts_with = "manifest")]
    pub held_out: Vec<PathBuf>,
    /// Of arms' logs: the same motion without the payload, laid beside every recording
    #[arg(long, value_name = "FILE", conflicts_with = "manifest")]
    pub reference: Option<PathBuf>,
    /// Write a copy of the arm's URDF with the friction found in its `dynamics` here
    #[arg(long, value_name = "IMPROVED.urdf")]
    pub out_urdf: Option<PathBuf>,
    /// List of measured files, where there are several objects
    #[arg(long, value_name = "FILE.toml", conflicts_with = "observation")]
    pub manifest: Option<PathBuf>,
    /// Diagnose each observation on its own
    #[arg(long, conflicts_with_all = ["manifest", "held_out", "out", "out_urdf", "report"])]
    pub each: bool,
    #[command(flatten)]
    pub apart: Apart,
    #[command(flatten)]
    pub reading: Reading,
    /// Write the simulation file with the tuned values and the named effects here; a folder where there are several objects
    #[arg(long, value_name = "IMPROVED.toml")]
    pub out: Option<PathBuf>,
    /// Write the answer with its evidence, drawings and the change of the file as a web page here
    #[arg(long, value_name = "FILE.html")]
    pub report: Option<PathBuf>,
    /// Threads [default: one for each core]
    #[arg(long, value_parser = jobs)]
    pub jobs: Option<usize>,
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

fn jobs(text: &str) -> Result<usize, String> {
    let count: Option<usize> = text.parse().ok().filter(|count| (1..=1024).contains(count));
    count.ok_or_else(|| format!("expected 1 to 1024 threads, found `{text}`"))
}

fn pair(text: &str) -> Result<(String, String), String> {
    let (ours, theirs) = text.split_once('=').ok_or_else(|| format!("expected OURS=THEIRS, found `{text}`"))?;
    if ours.is_empty() || theirs.is_empty() {
        return Err(format!("expected OURS=THEIRS, found `{text}`"));
    }
    Ok((ours.into(), theirs.into()))
}

fn start(text: &str) -> Result<(String, f64), String> {
    let (name, value) = pair(text).map_err(|_| format!("expected NAME=VALUE, found `{text}`"))?;
    let number: f64 = value.parse().map_err(|_| format!("expected a number for `{name}`, found `{value}`"))?;
    if number.is_finite() {
        Ok((name, number))
    } else {
        Err(format!("expected a finite number for `{name}`, found `{value}`"))
    }
}
