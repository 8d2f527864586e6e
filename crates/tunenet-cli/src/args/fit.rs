//! `tunenet tune` and `tunenet diagnose`: what is fitted to recordings.

use std::path::PathBuf;

use clap::Args;
use tunenet_core::{Error, Origin};

use super::{Common, Leave, Reading, Sharing, Simulation, Writing, jobs, pair};

pub const TUNE_EXAMPLES: &str = "\
Examples:
  tunenet tune --sim assets/ball.toml --observation assets/observations/drop.csv --out tuned.toml
  tunenet tune --sim ball.toml --observation drop.csv --report drop.html
  tunenet tune --sim ball.toml --set ball.radius_m=0.02 --observation flights/*.csv --each --json
  tunenet tune --sim ball.toml --observation 'flights/*.csv' --each --out-dir answers --jobs 4 --shard 0/8
  tunenet tune --sim ball.toml --observation log.csv --columns t_s=time,z_m=height
  tunenet tune --sim ball.toml --observation drop.mp4
  tunenet tune --sim process.toml --allow-process --observation swing.csv
  tunenet tune --sim ball_easy.toml --set release.height_m=3.9 --observation drop.mcap --model model.safetensors";

pub const DIAGNOSE_EXAMPLES: &str = "\
Examples:
  tunenet diagnose --sim assets/ball.toml --observation assets/observations/light_[1-5].csv --out improved.toml
  tunenet diagnose --sim ball.toml --observation d1.csv d2.csv d3.csv --held-out d4.csv --report answer.html
  tunenet diagnose --sim ball.toml --manifest balls.toml --out improved
  tunenet diagnose --sim ball.toml --observation 'logs/*.mcap' --each --out-dir answers --jobs 4
  tunenet diagnose --sim process.toml --allow-process --observation swing.csv
Several throws in varied directions tell effects apart that one throw cannot.
A manifest lists [[observation]] tables with `file`, and `object`, `held_out` and keys of the scene where they differ.";

/// Where recordings are treated one by one.
#[derive(Debug, Clone, Default, Args)]
pub struct Apart {
    /// With --each: write the answer to each recording into a file of its own here; what is there already is not done again
    #[arg(long, value_name = "FOLDER", requires = "each")]
    pub out_dir: Option<PathBuf>,
    #[command(flatten)]
    pub sharing: Sharing,
}

impl Apart {
    /// Shares are shares of many recordings.
    ///
    /// # Errors
    /// [`Error::Setting`] where `--shard` stands without `--each`.
    pub fn check(&self, each: bool) -> tunenet_core::Result<()> {
        let Some(shard) = self.sharing.shard.filter(|_| !each) else { return Ok(()) };
        let expected = "`--each` beside it, with a share of the recordings for every shard".into();
        Err(Error::Setting { origin: Origin::Flag, name: "--shard", expected, found: format!("{shard} alone") })
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

fn start(text: &str) -> Result<(String, f64), String> {
    let (name, value) = pair(text).map_err(|_| format!("expected NAME=VALUE, found `{text}`"))?;
    let number: f64 = value.parse().map_err(|_| format!("expected a number for `{name}`, found `{value}`"))?;
    if number.is_finite() {
        Ok((name, number))
    } else {
        Err(format!("expected a finite number for `{name}`, found `{value}`"))
    }
}
