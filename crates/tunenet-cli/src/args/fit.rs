//! `tunenet tune` and `tunenet diagnose`: what is fitted to recordings.

use std::path::PathBuf;

use clap::Args;
use tunenet_core::diagnose::Settings;
use tunenet_core::tune::Detail;
use tunenet_core::{Error, Origin};
use tunenet_sim::simulation_file::Domain;

use super::{Common, Models, Permission, Reading, Sharing, Simulation, Writing, jobs, pair};

pub const TUNE_EXAMPLES: &str = "\
Examples:
  tunenet tune --sim assets/ball.toml assets/observations/drop.csv -o tuned.toml
  tunenet tune --sim ball.toml drop.csv --report drop.html
  tunenet tune --sim ball.toml --set ball.radius_m=0.02 flights/*.csv --each --json
  tunenet tune --sim ball.toml 'flights/*.csv' --each --out-dir answers --jobs 4 --shard 0/8
  tunenet tune --sim ball.toml log.csv --columns t_s=time,z_m=height
  tunenet tune --sim ball.toml drop.mp4
  tunenet tune --sim process.toml --allow-process swing.csv
  tunenet tune --sim process.toml --allow-process --manifest runs.toml
  tunenet tune --sim process.toml --allow-process swing.csv --checkpoint swing.rollouts
  tunenet tune --sim robot.toml so101_data --units '*=deg' --out tuned.toml --out-model tuned.xml
  tunenet tune --sim ball_easy.toml --set release.height_m=3.9 drop.mcap --model model.safetensors";

pub const DIAGNOSE_EXAMPLES: &str = "\
Examples:
  tunenet diagnose --sim assets/ball.toml assets/observations/light_[1-5].csv -o improved.toml
  tunenet diagnose --sim ball.toml d1.csv d2.csv d3.csv --held-out d4.csv --report answer.html
  tunenet diagnose --sim ball.toml --manifest balls.toml -o improved
  tunenet diagnose --sim ball.toml d1.csv d2.csv d3.csv --held-out d4.csv d5.csv --law -o improved.toml
  tunenet diagnose --sim ball.toml 'logs/*.mcap' --each --out-dir answers --jobs 4
  tunenet diagnose --sim process.toml --allow-process swing.csv
  tunenet diagnose --sim robot.toml so101_data --units '*=deg' --out improved.toml --out-model improved.xml
Several throws in varied directions separate effects that one throw cannot.
A manifest lists [[observation]] tables with `file` and, if they differ, `object`, `held_out` and keys of the simulation file.";

/// Where recordings are treated one by one.
#[derive(Debug, Clone, Default, Args)]
pub struct Apart {
    /// Folder for one result file per recording; existing results are skipped (requires --each)
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
        let expected = "`--each`, since shards divide recordings".into();
        Err(Error::Setting {
            origin: Origin::Flag,
            name: "--shard",
            expected,
            found: format!("only `--shard {shard}`"),
        })
    }
}

/// `tunenet tune`.
#[derive(Debug, Args)]
#[expect(clippy::struct_excessive_bools, reason = "each is a flag of its own")]
pub struct Tune {
    #[command(flatten)]
    pub simulation: Simulation,
    #[command(flatten)]
    pub permission: Permission,
    /// Recordings (CSV, MCAP, ROS 2 bag, LeRobot, HDF5, Parquet, NumPy, video); several are fitted jointly
    #[arg(value_name = "RECORDING", required_unless_present_any = ["observation", "manifest"], conflicts_with = "manifest")]
    pub recordings: Vec<PathBuf>,
    /// Recordings, as an option instead of arguments
    #[arg(long, value_name = "FILE", num_args = 1..)]
    pub observation: Vec<PathBuf>,
    /// TOML list of recordings that differ in settings and initial states; those held out are not fitted
    #[arg(long, value_name = "FILE.toml", conflicts_with = "observation")]
    pub manifest: Option<PathBuf>,
    #[command(flatten)]
    pub reading: Reading,
    /// Log of the same motion without payload (arms only); common errors cancel
    #[arg(long, value_name = "FILE")]
    pub reference: Option<PathBuf>,
    /// Fit each recording separately
    #[arg(long, conflicts_with_all = ["out_model", "out_bam", "out_isaac"])]
    pub each: bool,
    #[command(flatten)]
    pub apart: Apart,
    /// Number of threads [default: number of cores]
    #[arg(long, value_name = "N", value_parser = jobs)]
    pub jobs: Option<usize>,
    /// Use recordings that failed the checks; the result may be meaningless
    #[arg(long)]
    pub force: bool,
    /// Network to start from [default: chosen automatically]
    #[arg(long, value_name = "MODEL.safetensors")]
    pub model: Option<PathBuf>,
    /// Do not read or write the network cache
    #[arg(long)]
    pub no_cache: bool,
    /// Initial value of a parameter (may be repeated) [default: from the simulation file]
    #[arg(long, value_name = "NAME=VALUE", value_parser = start, value_delimiter = ',')]
    pub initial: Vec<(String, f64)>,
    /// Network iterations before the fit, one rollout each (no effect without a network)
    #[arg(long, value_name = "N", default_value_t = 5, value_parser = clap::value_parser!(u16).range(1..=1000))]
    pub iterations: u16,
    /// Clamp values to their bounds in every iteration (only `--model` with preset `paper`)
    #[arg(long)]
    pub clamp: bool,
    /// Most rollouts; the result is then what was found so far, and a report has no profile likelihoods
    #[arg(long, value_name = "N", value_parser = rollouts)]
    pub max_rollouts: Option<usize>,
    /// File that keeps answered rollouts; the same command goes on from it after an interruption
    #[arg(long, value_name = "FILE", conflicts_with_all = ["each", "shard"])]
    pub checkpoint: Option<PathBuf>,
    /// Only the first fit, with unchecked intervals
    #[arg(long)]
    pub quick: bool,
    /// Write the simulation file with the tuned values
    #[arg(short, long, value_name = "TUNED.toml")]
    pub out: Option<PathBuf>,
    /// Write the 95 % intervals as ranges for domain randomisation (JSON)
    #[arg(long, value_name = "RANGES.json", conflicts_with = "each")]
    pub out_ranges: Option<PathBuf>,
    #[command(flatten)]
    pub models: Models,
    /// Write an HTML report; its profile likelihoods take further rollouts
    #[arg(long, value_name = "FILE.html")]
    pub report: Option<PathBuf>,
    /// Draw profile likelihoods of an external program or of robot joints as well: hundreds to thousands of rollouts more
    #[arg(long, requires = "report", conflicts_with_all = ["quick", "max_rollouts"])]
    pub profiles: bool,
    #[command(flatten)]
    pub writing: Writing,
    #[command(flatten)]
    pub common: Common,
}

impl Tune {
    /// What a report draws: a limited tuning has no further rollouts for it, those of a program may take seconds, and joints have many
    /// parameters.
    pub fn drawn(&self, domain: Domain) -> Detail {
        let slow = matches!(domain, Domain::Process | Domain::Robot);
        let limited = self.quick || self.max_rollouts.is_some() || slow;
        if limited && !self.profiles { Detail::Recordings } else { Detail::Profiles }
    }
}

/// `tunenet diagnose`.
#[derive(Debug, Args)]
pub struct Diagnose {
    #[command(flatten)]
    pub simulation: Simulation,
    #[command(flatten)]
    pub permission: Permission,
    /// Recordings (CSV, MCAP, ROS 2 bag, LeRobot, HDF5, Parquet, NumPy, video) of one object
    #[arg(value_name = "RECORDING", required_unless_present_any = ["observation", "manifest"], conflicts_with = "manifest")]
    pub recordings: Vec<PathBuf>,
    /// Recordings, as an option instead of arguments
    #[arg(long, value_name = "FILE", num_args = 1..)]
    pub observation: Vec<PathBuf>,
    /// Recordings for validation only [default: chosen automatically from four or more]
    #[arg(long, value_name = "FILE", num_args = 1.., conflicts_with = "manifest")]
    pub held_out: Vec<PathBuf>,
    /// Log of the same motion without payload (arms only); common errors cancel
    #[arg(long, value_name = "FILE", conflicts_with = "manifest")]
    pub reference: Option<PathBuf>,
    /// TOML list of recordings, for several objects or settings
    #[arg(long, value_name = "FILE.toml", conflicts_with = "observation")]
    pub manifest: Option<PathBuf>,
    /// Diagnose each recording separately
    #[arg(long, conflicts_with_all = ["manifest", "held_out", "out", "out_model", "out_bam", "out_isaac", "out_ranges", "report"])]
    pub each: bool,
    #[command(flatten)]
    pub apart: Apart,
    #[command(flatten)]
    pub reading: Reading,
    /// Most rollouts; a search that takes more ends without an answer
    #[arg(long, value_name = "N", value_parser = rollouts)]
    pub max_rollouts: Option<usize>,
    /// Search whole recordings once; single recordings and the next experiment are left out
    #[arg(long)]
    pub quick: bool,
    /// Search a formula for the missing force as well [default: only where no known effect explains the recordings]
    #[arg(long, conflicts_with_all = ["quick", "max_rollouts"])]
    pub law: bool,
    /// Write the simulation file with the tuned values and the named effects; a folder for several objects
    #[arg(short, long, value_name = "IMPROVED.toml")]
    pub out: Option<PathBuf>,
    /// Write the 95 % intervals as ranges for domain randomisation (JSON)
    #[arg(long, value_name = "RANGES.json")]
    pub out_ranges: Option<PathBuf>,
    #[command(flatten)]
    pub models: Models,
    /// Write an HTML report
    #[arg(long, value_name = "FILE.html")]
    pub report: Option<PathBuf>,
    /// Number of threads [default: number of cores]
    #[arg(long, value_name = "N", value_parser = jobs)]
    pub jobs: Option<usize>,
    #[command(flatten)]
    pub writing: Writing,
    #[command(flatten)]
    pub common: Common,
}

impl Diagnose {
    /// How the library is to diagnose.
    pub fn settings(&self) -> Settings {
        let Self { max_rollouts, quick, .. } = *self;
        Settings { seed: self.common.seed, max_rollouts, quick, ..Settings::default() }
    }
}

fn rollouts(text: &str) -> Result<usize, String> {
    let count: Option<usize> = text.parse().ok().filter(|count| *count > 0);
    count.ok_or_else(|| format!("expected a whole number of rollouts, 1 or more, found `{text}`"))
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
